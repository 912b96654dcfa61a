"""All contacts along one motion where thresholds age: strands of those that hold since t = 0 and of those born on each
panel, each with the density of its thresholds. The face is that of master.generations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from master._old.break_counts import Breaks
from master._old.generations import Young, between
from master._old.panels import MOST_NODES, Panel, radau
from master._old.threshold_cells import Cells
from origins import Contacts

Array = npt.NDArray[np.float64]
Nodes = tuple[Array, Array]

_STEP = 0.25  # of the narrowest width, in one step of a density
_RATE = 0.15  # of the contacts that break early in one
_HELD = 4.0  # steps between two nodes of a panel in a hold
_FINER = 4.0 ** (1.0 / 3.0)  # times as many with each level: a quarter of what third order lacks is left
_AT_ONCE = 1e-3  # of the time in which thresholds spread by the narrowest width
_DEAD = 1e-13
_EACH = 3e5
_SLOW = 20.0


@dataclass(frozen=True)
class Aged:
    """Strands: X less the stretch, when they were born, a weight, and the weights of their thresholds above the
    stretch, (n,) and (n, cells); none are followed while `asleep`, as none can have broken yet."""

    place: Array
    birth: Array
    share: Array
    asleep: npt.NDArray[np.bool_]
    weights: Array

    def where(self, these: npt.NDArray[np.bool_]) -> Aged:
        return Aged(self.place[these], self.birth[these], self.share[these], self.asleep[these], self.weights[these])

    def with_(self, other: Aged) -> Aged:
        return Aged(
            np.append(self.place, other.place),
            np.append(self.birth, other.birth),
            np.append(self.share, other.share),
            np.append(self.asleep, other.asleep),
            np.concatenate([self.weights, other.weights]),
        )

    @property
    def held(self) -> Array:
        return np.where(self.asleep, 1.0, self.weights.sum(axis=1))


class AgeingGenerations:
    """
    start, again : pairs of arrays (n,)
        Stretches of the contacts that hold at X = 0, and of births (lengths), and weights of sum 1.
    level : steps and cells are finer with each
    """

    error = 0.0

    def __init__(self, contacts: Contacts, level: int, start: Nodes, again: Nodes) -> None:
        assert contacts.ageing is not None
        self._cells, self._again, self._fine = Cells(contacts, level), again, _FINER**level
        self.length, self.rate = self._cells.width, self._cells.rate
        self.time = _AT_ONCE * self._cells.width**2 / contacts.ageing.rate
        self.work = 0.0
        self._strands = self._fresh(-start[0], np.zeros(start[0].size), start[1], start[0])
        self._at = 0.0
        self._next = self._strands
        self.start = float(start[1].sum()), float(start[1] @ start[0])

    def known(self, panel: Panel, breaks: Breaks) -> tuple[Array, Array]:
        """What holds at the panel's nodes of the births before it, and its force."""
        held, pull = np.empty(panel.count), np.empty(panel.count)
        strands, clock, at = self._strands, panel.begin, self._at
        times = panel.nodes
        self.work += _EACH
        for i, (time, place) in enumerate(zip(times.tolist(), panel.place(times).tolist(), strict=True)):
            count = strands.place.size
            strands = self._moved(strands, np.full(count, at), np.full(count, clock), place, time, panel)
            left = strands.share * strands.held
            held[i], pull[i] = left.sum(), left @ (place - strands.place)
            clock, at = time, place
        self._next = strands
        return held, pull

    def young(self, panel: Panel) -> Young:
        """Births of the panel itself, at each of its nodes."""
        stretch, share = self._again
        ends, held, pull, times = panel.nodes, [], [], []
        for now, at in zip(ends.tolist(), panel.place(ends).tolist(), strict=True):
            time, weight = between(Panel(panel.begin, now, panel.before, at, panel.count), np.empty(0), MOST_NODES + 1)
            place = panel.place(time)
            born = self._born(time, place, np.tile(share, (time.size, 1)))
            begun = np.repeat(place, stretch.size), np.repeat(time, stretch.size)
            strands = self._moved(born, *begun, at, now, panel)
            left = strands.share * strands.held
            held.append(left.reshape(time.size, -1).sum(axis=1) * weight)
            pull.append((left * (at - strands.place)).reshape(time.size, -1).sum(axis=1) * weight)
            times.append(time)
        firsts = np.cumsum([0, *(time.size for time in times[:-1])]).astype(np.intp)
        return Young(np.concatenate(times), np.concatenate(held), np.concatenate(pull), firsts)

    def finish(self, panel: Panel, breaks: Breaks) -> None:
        """On to the panel's end, the breaks on it being known: they were those of the panel asked for last."""
        self._at = panel.after
        time = panel.nodes
        even = breaks.rate(time) * radau(panel.count).weights * panel.duration
        place, nodes = panel.place(time), self._again[0].size
        born = self._born(time, place, np.outer(even, self._again[1]))
        begun = np.repeat(place, nodes), np.repeat(time, nodes)
        strands = self._next.with_(self._moved(born, *begun, panel.after, panel.end, panel))
        self._strands = strands.where(strands.held > _DEAD)

    def _born(self, time: Array, place: Array, share: Array) -> Aged:
        """Births at times and X, shape (m,), with weights (m, n) for each of the stretches of births."""
        stretch = np.tile(self._again[0], time.size)
        place, birth = (np.repeat(x, self._again[0].size) for x in (place, time))
        return self._fresh(place - stretch, birth, share.ravel(), stretch)

    def _fresh(self, place: Array, birth: Array, share: Array, stretch: Array) -> Aged:
        asleep = self._cells.untouched(stretch, np.zeros(stretch.size))
        weights = np.zeros((stretch.size, self._cells.edges.size - 1))
        weights[~asleep] = self._cells.fresh(stretch[~asleep])
        return Aged(place, birth, share, asleep, weights)

    def _moved(self, strands: Aged, at: Array, clock: Array, goal: float, end: float, panel: Panel) -> Aged:
        """Strands that are with the slider at X = `at` at times `clock`, (n,), once it is at `goal` at `end`."""
        cells = self._cells
        still = strands.asleep & cells.untouched(goal - strands.place, end - strands.birth)
        up = strands.asleep & ~still
        weights = strands.weights
        if up.any():
            weights = weights.copy()
            weights[up] = cells.aged((at - strands.place)[up], (clock - strands.birth)[up])
        rows = np.flatnonzero(~still)
        if rows.size:
            begun, lasts, ways = at[rows] - strands.place[rows], end - clock[rows], goal - at[rows]
            longest, furthest = float(lasts.max()), float(np.abs(ways).max())
            least = _HELD if panel.travel == 0.0 else furthest / (_STEP * cells.width)
            steps = max(1, int(np.ceil(self._fine * max(least, longest * cells.rate / _RATE))))
            self.work += steps * rows.size * cells.edges.size * _SLOW
            part = weights[rows]
            for k in range(steps):
                part = self._step(part, begun + ways * (k / steps), begun + ways * ((k + 1) / steps), lasts / steps)
            weights = weights.copy()
            weights[rows] = part
        return replace(strands, asleep=still, weights=weights)

    def _step(self, weights: Array, begin: Array, end: Array, lasts: Array) -> Array:
        """One step of each strand, of a length and a time of its own."""
        turns = begin * end < 0.0
        # a stretch that passes 0 comes down and goes up again: one move each
        first = np.where(turns, np.abs(begin) / np.where(turns, np.abs(end - begin), 1.0), 1.0)
        middle = np.where(turns, 0.0, end)
        weights = self._cells.move(weights, np.abs(begin), np.abs(middle), first * lasts)
        if turns.any():
            rest = (1.0 - first[turns]) * lasts[turns]
            onward = np.abs(end[turns])
            weights[turns] = self._cells.move(weights[turns], np.zeros(rest.size), onward, rest)
        return weights
