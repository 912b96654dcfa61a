"""All contacts along one motion: those that hold since t = 0, and those born on each panel.

What is left of the births of a panel in motion is summed over its nodes; where their largest |x| since bends with the
moment of birth, or passes a bend of P_c, over nodes between such bends. Contacts born in one hold share their place:
for each threshold what is left of them all is known in closed form, and they go on as one strand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.break_counts import Breaks
from master._old.panels import MOST_NODES, Panel, gauss, radau
from master._old.pot import Pot
from master._old.replay import replay
from master._old.resting import Resting
from master._old.timeline import Piece
from master._old.wear import Wear

Array = npt.NDArray[np.float64]
Nodes = tuple[Array, Array]
Numbers = npt.NDArray[np.intp]

_CLOSE = 1e-12
_TOUCH = 1e-9
_MOST_GRADES = 8
_FINER = 4.0
_DEAD = 1e-19
_EACH = 3e5  # a panel takes as long as so much
_LARGEST = 2e6


class Generations:
    """
    start, again : pairs of arrays (n,)
        Stretches of the contacts that hold at X = 0, and of births (lengths); with each its weight over S(|r|).
    limits : stretches at which P_c bends or jumps
    rough : whether what is left of births changes as a broken power of the stretch where they form
    level : sums over parts of a panel have one more node with each

    Attributes
    ----------
    wear, again : as given
    """

    def __init__(
        self, wear: Wear, start: Nodes, again: Nodes, course: list[Piece], limits: Array, rough: bool, level: int
    ) -> None:
        self._shortest = 0.0 if rough else wear.time
        self.nodes = MOST_NODES + 1 + level
        self._still = not np.isfinite(wear.time)  # at rest nothing breaks
        self.wear, self._course, self.again, self._limits = wear, course, again, limits
        self._strands = Strands(wear)
        first = wear.fresh(start[0])
        self._strands.add(-start[0], np.abs(start[0]), first, start[1], -1)
        self._keeper = wear.keeper()
        self._pots = Strands(self._keeper or wear)
        self._pot: Pot | None = None
        self._resting: Resting | None = None
        if self._keeper is None and any(piece.travel == 0.0 for piece in course):
            self._resting = Resting(wear, again, max(piece.duration for piece in course))
        self._at = 0.0
        self.work, self._each = 0.0, wear.work * wear.slow
        self.length, self.time, self.rate = wear.length, wear.time, wear.rate
        left = wear.left(first, start[0], np.abs(start[0]))
        self.start = float(left.held @ start[1]), float((left.stiff * start[0]) @ start[1])
        # of finished panels in motion: X at both ends, extremes of X since
        self._panels: list[Panel] = []
        self._table = np.empty((0, 4))
        self._alive = np.empty(0, dtype=bool)

    @property
    def error(self) -> float:
        return self.wear.error

    def known(self, panel: Panel, breaks: Breaks) -> tuple[Array, Array]:
        """What holds at the panel's nodes of the births before it, and its force."""
        standing = panel.travel == 0.0
        if standing and self._pot is None and self._keeper is not None:
            self._pot = Pot(self._keeper, self.again)
        if not standing and self._pot is not None:
            share, worn = self._pot.merged()
            if share > 0.0:
                stretch = self.again[0]
                self._pots.add(self._at - stretch, np.abs(stretch), worn, share * self.again[1], -1)
            self._pot = None
        time = panel.nodes
        at = panel.place(time)
        self.work += _EACH + (time.size + 1.0) * self._strands.count * self._each
        extra, bent = self._bent(time, at, breaks)
        held, pull = self._strands.sums(self._at, at, time - panel.begin, bent)
        more = self._pots.sums(self._at, at, time - panel.begin, None)
        held, pull = held + extra[0] + more[0], pull + extra[1] + more[1]
        if self._pot is not None:
            resting = self._pot.left(time - panel.begin)
            held, pull = held + resting[0], pull + resting[1]
        return held, pull

    def young(self, panel: Panel) -> Young:
        """Births of the panel itself, at each of its nodes."""
        ends = panel.nodes
        places = panel.place(ends)
        begin, before, count = (np.full(ends.size, x) for x in (panel.begin, panel.before, panel.count))
        node, time, weight = self._parts(np.stack([begin, ends, before, places, count]), ends, places, places, places)
        now, sizes = ends[node], np.bincount(node, minlength=ends.size)
        if self._pot is not None:
            held, pull = self._pot.young(now - time)
        elif self._resting is not None and panel.travel == 0.0:
            held, pull = self._resting.young(now - time)
        else:
            held, pull = self._replay(time, panel.births(time), now, places[node])
        firsts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        return Young(time, held * weight, pull * weight, firsts.astype(np.intp))

    def finish(self, panel: Panel, breaks: Breaks) -> None:
        """On to the panel's end, the breaks on it being known."""
        self._strands.advance(self._at, panel.after, panel.duration)
        self._pots.advance(self._at, panel.after, panel.duration)
        self._at = panel.after
        if self._pot is not None:
            time, weight = self._parts_of(panel, panel.end, self._at, self._at)
            self._pot.add(panel.duration, panel.end - time, weight * breaks.rate(time))
            return
        self._table[:, 2] = np.maximum(self._table[:, 2], self._at)
        self._table[:, 3] = np.minimum(self._table[:, 3], self._at)
        self._born(panel, breaks.rate(panel.nodes) * radau(panel.count).weights * panel.duration)
        self._panels.append(panel)
        self._table = np.append(self._table, [[panel.before, panel.after, panel.after, panel.after]], axis=0)
        self._alive = np.append(self._alive, panel.spot is None)  # at one place births do not come one by one
        gone = np.setdiff1d(np.flatnonzero(self._alive), self._strands.origin)
        self._alive[[k for k in gone.tolist() if not self._between_nodes(k, panel.end)]] = False

    def _between_nodes(self, k: int, now: float) -> bool:
        """Whether of a panel's births some still hold that stand at none of its nodes."""
        panel, (_, _, most, least) = self._panels[k], self._table[k].tolist()
        birth, _ = self._parts_of(panel, now, most, least)
        if birth.size == self.nodes:
            return False
        held, _ = self._replay(birth, panel.place(birth), np.full(birth.size, now), np.full(birth.size, self._at))
        return bool((held > _DEAD).any())

    def _born(self, panel: Panel, even: Array) -> None:
        """Births at the panel's nodes, now at its end."""
        stretch, share = self.again
        nodes = stretch.size
        time = panel.nodes
        first, place = np.tile(stretch, time.size), np.repeat(panel.births(time), nodes) - np.tile(stretch, time.size)
        worn = np.tile(self.wear.fresh(stretch), (time.size, 1))
        last = panel.after - place
        self.wear.advance(worn, first, last, np.abs(first), np.repeat(panel.end - time, nodes))
        furthest = np.maximum(np.abs(first), np.abs(last))
        self._strands.add(place, furthest, worn, np.outer(even, share).ravel(), len(self._panels))

    def _bent(self, time: Array, at: Array, breaks: Breaks) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Where at times, shape (p,), what is left bends with the moment of birth: what holds of the births of such
        panels, and its force, shape (2, p); and which panels, (p, panels)."""
        out, bent = np.zeros((2, time.size)), np.zeros((time.size, self._alive.size), dtype=bool)
        most = np.maximum(self._table[:, 2], at[:, None])
        least = np.minimum(self._table[:, 3], at[:, None])
        i, k = np.nonzero(self._suspects(time, at, most, least))
        if not i.size:
            return out, bent
        bent[i, k] = True
        panels = np.array([edges(panel) for panel in self._panels]).T[:, k]
        pair, birth, weight = self._parts(panels, time[i], at[i], most[i, k], least[i, k])
        weight *= breaks.rate(birth)
        begin, end, before, after, _ = panels[:, pair]
        place = before + (after - before) * ((birth - begin) / (end - begin))
        which, moved = i[pair], np.ones(pair.size, dtype=bool)
        if self._resting is not None:
            moved = k[pair] < self._rests(at)
            for row, left in enumerate(self._resting.young((time[which] - birth)[~moved])):
                out[row] += np.bincount(which[~moved], left * weight[~moved], minlength=time.size)
        which = which[moved]
        for row, left in enumerate(self._replay(birth[moved], place[moved], time[which], at[which])):
            out[row] += np.bincount(which, left * weight[moved], minlength=time.size)
        return out, bent

    def _rests(self, at: Array) -> int:
        """The first of the panels of a hold that goes on."""
        k = len(self._panels)
        while k and self._panels[k - 1].travel == 0.0 and (at == self._panels[k - 1].after).all():
            k -= 1
        return k

    def _replay(self, birth: Array, place: Array, time: Array, at: Array) -> tuple[Array, Array]:
        self.work += birth.size * self.again[0].size * self._each
        return replay(self.wear, self._course, self.again, birth, place, time, at)

    def _suspects(self, time: Array, at: Array, most: Array, least: Array) -> npt.NDArray[np.bool_]:
        """Which panels may be split, at times and X with these extremes of X since, shape (p, panels)."""
        low, high = (f(self._table[:, 0], self._table[:, 1]) for f in (np.minimum, np.maximum))
        # a node right at an end may be on the wrong side
        close = _TOUCH * (high - low)
        out = np.zeros(most.shape, dtype=bool)
        for x in self._candidates(time[:, None], at[:, None], most, least):
            out |= (x > low - close) & (x < high + close)
        if self._still:
            reach = np.maximum(most - self._table[:, 1], self._table[:, 1] - least)
            return (out | (reach < high - low)) & self._alive if not self._shortest else out & self._alive
        for k in range(max(low.size - 2, 0), low.size):
            panel = self._panels[k]
            if panel.count > 1 and panel.duration > self._shortest:
                out[:, k] |= time - panel.end < panel.duration
        return out & self._alive

    def _candidates(self, time: Array, at: Array, most: Array, least: Array) -> list[Array]:
        """X of births at which their largest |x| bends, or passes a limit; where that is forgotten, their |x| now or
        at an end of any motion before."""
        out = []
        for r in self.again[0].tolist():
            if self.wear.forgets:
                before = [np.where(one.end < time, one.after, np.nan) for one in self._course]
                for x in [at, *before]:
                    out += [x, x + 2.0 * r] if r else [x]
                    for reach in self._limits[self._limits > abs(r)].tolist():
                        out += [x - reach + r, x + reach + r]
                continue
            out.append(0.5 * (most + least) + r)
            for reach in (abs(r), *self._limits[self._limits > abs(r)].tolist()):
                if reach > 0.0:
                    out += [most - reach + r, least + reach + r]
        return out

    def _parts_of(self, panel: Panel, now: float, most: float, least: float) -> tuple[Array, Array]:
        """Nodes in time on parts of a panel, and their weights, as the slider stands now."""
        rest = (np.array([x]) for x in (now, self._at, most, least))
        return self._parts(np.array([edges(panel)]).T, *rest)[1:]

    def _parts(
        self, panels: Array, now: Array, at: Array, most: Array, least: Array
    ) -> tuple[Numbers, Array, Array]:
        """Of each panel, a column of `panels`, parts between which what is left changes smoothly with the moment of
        birth: which panel each node is of, in order, its time and its weight."""
        begin, end, before, after = panels[:4]
        duration, travel = end - begin, after - before
        which, times = [np.arange(begin.size)] * 2, [begin, end]
        with np.errstate(divide="ignore", invalid="ignore"):  # of those that rest
            share = (np.array(self._candidates(now, at, most, least)) - before) / travel
        _, some = inside = np.nonzero((travel != 0.0) & (share > _CLOSE) & (share < 1.0 - _CLOSE))
        shares = [(some, share[inside])]
        if self.wear.forgets and not self._shortest:
            steps = _FINER ** -np.arange(1.0, _MOST_GRADES + 1.0)
            around = share[inside][:, None] + np.append(steps, -steps)
            near = np.nonzero((around > 0.0) & (around < 1.0))
            shares.append((some[near[0]], around[near]))
        for one, split in shares:
            which.append(one)
            times.append(begin[one] + split * duration[one])
        since = now - end
        if self._still:
            with np.errstate(divide="ignore", invalid="ignore"):
                moved = np.maximum(most - after, after - least) * (duration / np.abs(travel))
            since = np.where(travel != 0.0, moved, since)
        one, back = grades_of(panels, since, self._shortest)
        which.append(one)
        times.append(end[one] - back)
        every, cuts = np.concatenate(which), np.concatenate(times)
        order = np.lexsort((cuts, every))
        every, cuts = every[order], cuts[order]
        width = np.diff(cuts)
        kept = np.flatnonzero((np.diff(every) == 0) & (width > 0.0))
        nodes, weights = gauss(self.nodes)
        width = width[kept, None]
        return np.repeat(every[kept], nodes.size), (cuts[kept, None] + width * nodes).ravel(), (width * weights).ravel()


@dataclass(frozen=True)
class Young:
    """Moments of birth within a panel up to each of its nodes, one node after the other, the weights of the births per
    time there in what holds and in the force, and where those of each node begin."""

    time: Array
    held: Array
    pull: Array
    firsts: Numbers


class Strands:
    """Contacts born at one place and one stretch each: rows with X less the stretch, the largest |x|, what their wear
    keeps, a weight, and the number of the panel they were born on."""

    def __init__(self, wear: Wear) -> None:
        self._wear = wear
        self._place, self._furthest, self._share = np.empty(0), np.empty(0), np.empty(0)
        self._worn = np.empty((0, wear.width))
        self.origin = np.empty(0, dtype=np.intp)

    @property
    def count(self) -> int:
        return self._place.size

    def add(self, place: Array, furthest: Array, worn: Array, share: Array, origin: int) -> None:
        self._place, self._furthest = np.append(self._place, place), np.append(self._furthest, furthest)
        self._worn = np.concatenate([self._worn, worn])
        self._share = np.append(self._share, share)
        self.origin = np.append(self.origin, np.full(place.size, origin))

    def sums(
        self, before: float, at: Array, lasts: Array, without: npt.NDArray[np.bool_] | None
    ) -> tuple[Array, Array]:
        """What holds, and its force, when the slider has gone on from X = before to each of `at`; `without` the births
        of panels, shape (at.size, panels)."""
        held, pull = np.zeros(at.size), np.zeros(at.size)
        n = self._place.size
        if not n:
            return held, pull
        begin = before - self._place
        some = max(1, int(_LARGEST / (n * (self._worn.shape[1] + 1))))
        for first in range(0, at.size, some):
            rows = slice(first, first + some)
            count = at[rows].size
            stretch = (at[rows, None] - self._place).ravel()
            worn, furthest = np.tile(self._worn, (count, 1)), np.tile(self._furthest, count)
            self._wear.advance(worn, np.tile(begin, count), stretch, furthest, np.repeat(lasts[rows], n))
            left = self._wear.left(worn, stretch, np.maximum(furthest, np.abs(stretch)))
            share = np.tile(self._share, (count, 1))
            if without is not None:
                born = np.flatnonzero(self.origin >= 0)
                share[:, born] *= ~without[rows][:, self.origin[born]]
            held[rows] = (left.held.reshape(count, n) * share).sum(axis=1)
            pull[rows] = ((left.stiff * stretch).reshape(count, n) * share).sum(axis=1)
        return held, pull

    def advance(self, before: float, at: float, duration: float) -> None:
        """All go on; those of which nothing is left are forgotten."""
        if not self._place.size:
            return
        stretch = at - self._place
        self._wear.advance(self._worn, before - self._place, stretch, self._furthest, duration)
        self._furthest = np.maximum(self._furthest, np.abs(stretch))
        held = self._wear.left(self._worn.copy(), stretch, self._furthest).held
        alive = np.flatnonzero(held > _DEAD)
        if alive.size < held.size:
            self._place, self._furthest, self._share = self._place[alive], self._furthest[alive], self._share[alive]
            self._worn, self.origin = self._worn[alive], self.origin[alive]


def edges(panel: Panel) -> tuple[float, float, float, float, float]:
    """Times and X at both ends, and how many nodes."""
    return panel.begin, panel.end, panel.before, panel.after, panel.count


def grades(panel: Panel, age: float, shortest: float) -> list[float]:
    """Times in a panel between which what is left changes as little, a time `age` after its end: births break the
    faster the weaker they are, some at once."""
    _, back = grades_of(np.array([edges(panel)]).T, np.array([age]), shortest)
    return (panel.end - back).tolist()


def grades_of(panels: Array, age: Array, shortest: float) -> tuple[Numbers, Array]:
    """The same of many panels, columns of such: which, and how long before its end."""
    begin, end, before, after, count = panels
    duration = end - begin
    graded = (count > 1) & (duration > shortest) & (age < duration)
    number = np.full(begin.size, float(_MOST_GRADES))
    if shortest:
        most = np.where(after != before, number, np.inf)
        number = np.minimum(np.ceil(np.log(np.maximum(duration / shortest, 1.0)) / np.log(_FINER)), most)
    n = np.arange(1.0, number[graded].max(initial=0.0) + 1.0)
    back = _FINER**-n * duration[:, None]
    kept = np.nonzero(graded[:, None] & (n <= number[:, None]) & (back > 0.5 * age[:, None]))
    return kept[0], back[kept]


def between(panel: Panel, splits: Array, count: int) -> tuple[Array, Array]:
    """`count` nodes in time on each part of a panel, and their weights."""
    nodes, weights = gauss(count)
    edges = np.concatenate([[panel.begin], splits, [panel.end]])
    width = np.diff(edges)[:, None]
    return (edges[:-1, None] + width * nodes).ravel(), (width * weights).ravel()
