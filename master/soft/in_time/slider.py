"""A soft slider along its whole path, K (X_T - X) = F, step by step and slip after slip."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline
from scipy.optimize import brentq
from scipy.optimize.elementwise import find_root

from master.soft.in_time.cohorts import Cohorts, Trial
from master.soft.in_time.pieces import Piece
from master.soft.in_time.steps import Node, Steps
from master.soft.slips import MOST_SLIPS, StoppedError
from origins.drive import Drive

Array = npt.NDArray[np.float64]


class Slider:
    """The solution along the whole path, with steps of 2^-level of the coarsest.

    Parameters
    ----------
    contacts : Cohorts
        All contacts at X = 0; StoppedError says how far their steps came.
    drive : Drive
    pieces : list of Piece
        Of the drive's path.
    close : float
        Share of a step to which its balance is found.
    plan : list of float
        Lengths, in coarsest steps, of the smooth sections between bends and slips, as the next
        coarser level found them; empty on the coarsest level.

    Attributes
    ----------
    sections : list of lists of Node, one for each smooth section
    lengths : list of float
        Lengths of the smooth sections, and of instant slips, in the units of `plan`.
    slips : list of arrays of shape (5,)
        X_T, X before and after, F before and after (lengths).
    """

    def __init__(
        self,
        contacts: Cohorts,
        drive: Drive,
        pieces: list[Piece],
        close: float,
        plan: list[float],
    ) -> None:
        self.contacts, self._rule, self._spring = contacts, drive.slip, float(drive.spring or 0.0)
        self._pieces, self._finer, self._plan = pieces, 2**contacts.level, plan
        self._steps = Steps(contacts, self._spring, close)
        self.sections, self.lengths = list[list[Node]](), list[float]()
        self.slips = list[Array]()

    def run(self) -> None:
        """Follow the drive to its end."""
        contacts = self.contacts
        if not self._pieces:
            self.sections.append([])
            self._write(0.0)
        for piece in self._pieces:
            contacts.repeat_later(piece.begin)
            self._steps.begin(piece)
            while True:
                end = min([*contacts.pending, piece.end])
                if self._slide(end):
                    self.slips.append(self._slip())
                elif end < piece.end:
                    contacts.born_now()
                else:
                    break

    def _slide(self, end: float) -> bool:
        """Take steps until `end`, or until a slip begins; returns whether one does."""
        contacts, steps, nodes = self.contacts, self._steps, list[Node]()
        self.sections.append(nodes)
        contacts.bend()
        self._write(0.0)
        steps.start(end, nodes)
        # the number of steps doubles with each level, so that errors are series in their square
        number = len(self.lengths)
        length = self._plan[number] if number < len(self._plan) else 0.0
        self._size = size = float(length / np.ceil(length) if length else 1.0) / self._finer
        share, slips = 0.5, False
        while not slips and contacts.now < end:
            # the last of the planned steps covers the rest
            late = 0.0 < length < nodes[-1].size + 1.5 * size
            trial = steps.step(1.5 * size if late else size, share)
            if trial.now >= end:
                trial = steps.step_to(end, trial.travel)
            slips = steps.slip_begins(trial, size)
            if slips:
                # approach the slip by steps of half the rest
                for _ in range(4):
                    half = steps.step_by(0.5 * steps.up_to_slip(trial.travel).travel)
                    self._take(half)
                    trial = trial._replace(travel=trial.travel - half.travel)
                trial = steps.up_to_slip(trial.travel)
            elif late and trial.now < end:
                trial = steps.step(size, share)
            time, stretch = steps.counted(trial.now), self._take(trial)
            share = time / stretch if stretch > 0.0 else share
        self.lengths.append(nodes[-1].size)
        return slips

    def _take(self, trial: Trial) -> float:
        """Take a step, unless it has neither travel nor duration; returns its size."""
        size = max(self._steps.size(trial), 0.0)
        if trial.travel or trial.now > self.contacts.now:
            self.contacts.take(trial)
            self._write(self.sections[-1][-1].size + size)
        return size

    def _write(self, size: float) -> None:
        state = self.contacts
        self.sections[-1].append(Node(size, state.now, state.force, state.holding))

    def _slip(self) -> Array:
        """Let the slider slip while the drive holds."""
        contacts, rule = self.contacts, self._rule
        drive, before, force = self._steps.piece.at(contacts.now), contacts.place, contacts.force
        if rule == "reset":
            contacts.relax()
            contacts.place = drive - contacts.force / self._spring
        else:
            self._slip_to_balance(rule == "reform-after" or contacts.delay > 0.0)
        return np.array([drive, before, contacts.place, force, contacts.force])

    def _slip_to_balance(self, out: bool) -> None:
        """Move the slider to the first balance; with `out`, broken contacts stay out until then."""
        contacts, steps = self.contacts, self._steps
        # without births only the end has to be found, in small steps so that none is missed
        step = 0.06 * steps.scales.length if out else self._size * steps.length
        size = steps.sign * step
        contacts.bend()
        begin, broken, travel = contacts.place, contacts.breaks, 0.0
        # with `thin`, heat has broken the weakest, and the others first carry more as they stretch
        away = not steps.scales.thin
        for _ in range(MOST_SLIPS):
            trial = contacts.trial(travel + size, contacts.now, out)
            missing = steps.imbalance(trial)
            if missing <= 0.0 and (away or abs(contacts.place + travel - begin) > contacts.unit):
                break
            away |= missing > 0.0
            if out:
                travel += size
            else:
                contacts.take(trial)
        else:
            raise StoppedError("no steps were found that follow the slider")
        low = travel if contacts.place + travel != begin else 1e-4 * size  # the shortest slip

        def imbalance(way: float) -> float:
            return steps.imbalance(contacts.trial(way, contacts.now, out))

        if imbalance(low) > 0.0:
            # accuracy of a slip's end, in mean thresholds
            low = float(brentq(imbalance, low, travel + size, xtol=1e-15 * contacts.unit))
        contacts.take(contacts.trial(low, contacts.now, out))
        contacts.bend()
        if not out:
            self.lengths.append(abs(contacts.place - begin) / steps.length)
            return
        fresh = contacts.breaks - broken
        contacts.repeat_later(contacts.now, fresh)
        if not contacts.delay:
            contacts.born_at_once(fresh)


def read(sections: list[list[Node]], asked: Array) -> Array:
    """Force (lengths) and holding share at times (n,), shape (2, n); at a slip, after it.

    By splines in the size of all steps, in which the time, too, is smooth.
    """
    ends = np.array([section[-1].time for section in sections])
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(sections) - 1)
    out = np.empty((2, asked.size))
    for k in np.unique(which):
        at, nodes = asked[which == k], np.array(sections[k])
        nodes = nodes[np.unique(nodes[:, 0], return_index=True)[1]]
        step, times = nodes[:, 0], nodes[:, 1]
        if step.size == 1:
            out[:, which == k] = nodes[0, 2:, None]
            continue
        # splines are best at odd degrees
        values = make_interp_spline(step, nodes[:, 1:], k=min(5, 2 * ((step.size - 2) // 2) + 1))
        cell = np.clip(np.searchsorted(times, at, side="left"), 1, step.size - 1)
        found = find_root(
            lambda x, time, values=values: values(x)[..., 0] - time,
            (step[cell - 1], step[cell]),
            args=(np.clip(at, times[cell - 1], times[cell]),),
        )
        out[:, which == k] = values(found.x)[:, 1:].T
    return out
