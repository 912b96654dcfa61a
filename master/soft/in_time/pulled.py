"""Pulled: a soft slider along its whole path, K (X_T - X) = F, step by step and slip after slip."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from master.soft.in_time.carried import Carried, TooLongError, Trial
from master.soft.in_time.steps import Steps
from master.soft.in_time.track import Node, Piece
from origins.drive import Drive

Array = npt.NDArray[np.float64]

# Step of the search for the end of a slip without births, as a share of the length over which births
# change; and the shortest slip, as a share of a step.
SCAN, LEAST_SLIP = 0.06, 1e-4
# Most slips, and most steps of a search for the end of one.
MOST_SLIPS = 20_000
# Step that is tried when less than it remains of the planned ones, in their size.
LAST = 1.5


class Pulled:
    """The solution along the whole path, with steps of 2^-level of the coarsest.

    Parameters
    ----------
    contacts : Carried
        All contacts at X = 0; TooLongError says how far their steps came.
    drive : Drive
    pieces : list of Piece
        Of the drive's path.
    close : float
        Share of a step to which its balance is found.
    level : int
    plan : list of float
        Lengths, in coarsest steps, of the smooth sections between bends and slips, as the next
        coarser level found them; empty on the coarsest level.

    Attributes
    ----------
    tracks : list of lists of Node, one for each smooth section
    stretches : list of float
        Lengths of the smooth sections, and of instant slips, in the units of `plan`.
    slips : list of arrays of shape (5,)
        X_T, X before and after, F before and after (lengths).
    """

    def __init__(
        self,
        contacts: Carried,
        drive: Drive,
        pieces: list[Piece],
        close: float,
        level: int,
        plan: list[float],
    ) -> None:
        self.contacts, self._rule, self._spring = contacts, drive.slip, float(drive.spring or 0.0)
        self._pieces, self._finer, self._plan = pieces, 2**level, plan
        self._steps = Steps(contacts, self._spring, close)
        self.tracks, self.stretches = list[list[Node]](), list[float]()
        self.slips = list[Array]()

    def run(self) -> None:
        """Follow the drive to its end."""
        if not self._pieces:
            self.tracks.append([])
            self._write(0.0)
        for piece in self._pieces:
            self.contacts.mark_later(piece.begin)
            self._follow(piece, piece is self._pieces[-1])

    def _follow(self, piece: Piece, last: bool) -> None:
        """Follow the drive to the end of a piece."""
        here, since = self.contacts, [len(self.tracks)]
        self._steps.begin(piece)
        while True:
            end = min([*here.pending, piece.end])
            if self._slide(end):
                self.slips.append(self._slip())
                since.append(len(self.tracks))
                if last and self._rule == "reset" and len(since) == 3:
                    return self._repeat(self.tracks[since[1] :])
            elif end < piece.end:
                here.born_now()
            else:
                return None

    def _repeat(self, tracks: list[list[Node]]) -> None:
        """Repeat the tracks since the last reset up to the end: after each reset all is the same."""
        here, (before, last) = self.contacts, self.slips[-2:]
        period = here.now - tracks[0][0].clock
        way = (last[2] - before[2]) * np.array([1.0, 1.0, 1.0, 0.0, 0.0])
        more = int((self._steps.piece.end - here.now) / period)
        if more > MOST_SLIPS:
            raise TooLongError
        self.slips += [last + k * way for k in range(1, more + 1)]
        for k in range(1, more + 2):
            later = k * period
            self.tracks += [[one._replace(clock=one.clock + later) for one in t] for t in tracks]

    def _slide(self, end: float) -> bool:
        """Take steps until `end`, or until a slip begins; returns whether one does."""
        here, steps, nodes = self.contacts, self._steps, list[Node]()
        self.tracks.append(nodes)
        here.bend()
        self._write(0.0)
        steps.start(end, nodes)
        # the number of steps doubles with each level, so that errors are series in their square
        number = len(self.stretches)
        length = self._plan[number] if number < len(self._plan) else 0.0
        self._size = size = float(length / np.ceil(length) if length else 1.0) / self._finer
        share, slips = 0.5, False
        while not slips and here.now < end:
            # the last of the planned steps covers the rest
            late = 0.0 < length < nodes[-1].step + LAST * size
            trial = steps.step(LAST * size if late else size, share)
            if trial.now >= end:
                trial = steps.to(end, trial.travel)
            slips = steps.past(trial, size)
            if slips:
                # approach the slip by steps of half the rest
                for _ in range(4):
                    half = steps.balanced(0.5 * steps.onset(trial.travel).travel)
                    self._take(half)
                    trial = trial._replace(travel=trial.travel - half.travel)
                trial = steps.onset(trial.travel)
            elif late and trial.now < end:
                trial = steps.step(size, share)
            time, stretch = steps.counted(trial.now), self._take(trial)
            share = time / stretch if stretch > 0.0 else share
        self.stretches.append(nodes[-1].step)
        return slips

    def _take(self, trial: Trial) -> float:
        """Take a step, unless it has neither travel nor duration; returns its size."""
        size = max(self._steps.size(trial), 0.0)
        if trial.travel or trial.now > self.contacts.now:
            self.contacts.take(trial)
            self._write(self.tracks[-1][-1].step + size)
        return size

    def _write(self, step: float) -> None:
        here = self.contacts
        self.tracks[-1].append(Node(step, here.now, here.force, here.holding))

    def _slip(self) -> Array:
        """Let the slider slip while the drive holds."""
        here, rule = self.contacts, self._rule
        drive, before, force = self._steps.piece.at(here.now), here.place, here.force
        if rule == "reset":
            here.relax()
            here.place = drive - here.force / self._spring
        else:
            self._rush(rule == "reform-after" or here.delay > 0.0)
        return np.array([drive, before, here.place, force, here.force])

    def _rush(self, out: bool) -> None:
        """Move the slider to the first balance; with `out`, broken contacts stay out until then."""
        here, steps = self.contacts, self._steps
        step = SCAN * steps.scales.length if out else self._size * steps.length
        size = steps.sign * step
        here.bend()
        begin, broken, travel = here.place, here.breaks, 0.0
        # with `thin`, heat has broken the weakest, and the others first carry more as they stretch
        away = not steps.scales.thin
        for _ in range(MOST_SLIPS):
            trial = here.tried(travel + size, here.now, out)
            lack = steps.lack(trial)
            if lack <= 0.0 and (away or abs(here.place + travel - begin) > here.unit):
                break
            away |= lack > 0.0
            if out:
                travel += size
            else:
                here.take(trial)
        else:
            raise TooLongError
        low = travel if here.place + travel != begin else LEAST_SLIP * size

        def lacks(way: float) -> float:
            return steps.lack(here.tried(way, here.now, out))

        if lacks(low) > 0.0:
            # accuracy of a slip's end, in mean thresholds
            low = float(brentq(lacks, low, travel + size, xtol=1e-15 * here.unit))
        here.take(here.tried(low, here.now, out))
        here.bend()
        if not out:
            self.stretches.append(abs(here.place - begin) / steps.length)
            return
        fresh = here.breaks - broken
        here.mark_later(here.now, fresh)
        if not here.delay:
            here.born_at_once(fresh)
