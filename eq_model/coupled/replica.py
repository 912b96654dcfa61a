"""One replica: N contacts and a slider, from the start to the end of the drive's path."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from eq_model.coupled.draws import Draws
from origins import Contacts, Drive
from origins.errors import InputError

if TYPE_CHECKING:
    from eq_model.coupled.queue_kernel import Queue
    from eq_model.coupled.slide_kernel import Pull, Told

Array = npt.NDArray[np.float64]

SIZES = 40  # classes of avalanches: up to 2^40 breaks
_OF_A_SLIP = ("pulled", "before", "after", "force_before", "force_after", "size")


@dataclass(frozen=True)
class Followed:
    """What a replica did.

    Attributes
    ----------
    position, force, holding : arrays of shape (n,)
        X and F/(N_c <k>) (lengths), and the fraction that holds, at the path's points; at a slip,
        after it.
    slips : array of shape (m, 6)
        X_T, X before and after, F before and after (lengths), and how many contacts broke.
    avalanches : array of shape (SIZES,)
        How many that were no slips broke 1, 2 to 3, 4 to 7, ... contacts.
    breaks : int
        All of them.
    balance : float
        X_T = F(0)/K, where the drive stands at t = 0 (a length).
    """

    position: Array
    force: Array
    holding: Array
    slips: Array
    avalanches: npt.NDArray[np.int64]
    breaks: int
    balance: float


class Follower:
    """Follows replicas of `n` contacts on the slider that `drive` pulls; a slip breaks at least
    `slip_fraction` of them."""

    def __init__(
        self, contacts: Contacts, drive: Drive, n: int, key: tuple[int, int], slip_fraction: float
    ) -> None:
        assert drive.spring is not None
        self.contacts, self.drive, self.n, self._spring = contacts, drive, n, drive.spring
        self._draws = Draws(contacts, n, key)
        self._unit = self._draws.unit
        self._mean = contacts.mean_threshold / self._unit
        self._slip = max(int(np.ceil(slip_fraction * n)), 1)

    def follow(self, replica: int) -> Generator[float, None, Followed]:
        """Yields now and then the share of the drive's path that is done.

        Raises InputError where contacts would break while the drive moves back to its first point.
        """
        from eq_model.coupled import slide_kernel
        from eq_model.coupled.queue_kernel import make_queue
        from eq_model.coupled.slide_kernel import SLIDER, Returns, Told

        queue, slider = make_queue(self.n, self._mean), np.zeros(1, SLIDER)
        pull = self._begin(replica, slider, queue)
        balance = float(slider[0]["force"]) / pull.spring
        thresholds, stretches = self._draws.thresholds(replica), self._draws.stretches(replica)
        size, s = self.drive.path.size, slider[0]
        told = Told(
            np.zeros(size), np.zeros(size), np.zeros(size, np.int64), np.zeros(SIZES, np.int64)
        )
        room = 1 if self.contacts.delay is None else self.n
        returns = Returns(np.empty(room), np.empty(room, np.int64))
        slips = list[list[float]]()
        while True:
            why = slide_kernel.slide(slider, queue, thresholds, stretches, pull, told, returns)
            if why == slide_kernel.PATH_DONE:
                return self._followed(s, told, slips, balance)
            if why == slide_kernel.BUCKETS_PASSED:
                yield float(s["point"]) / size
                continue
            if why == slide_kernel.RESET_DUE:
                self._reset(slider, queue)
                slide_kernel.form_all(slider, queue, thresholds, stretches, pull, self.n)
            slips.append([float(s[name]) for name in _OF_A_SLIP])

    def _begin(self, replica: int, slider: npt.NDArray[np.void], queue: Queue) -> Pull:
        """All contacts form at X = 0; the drive stands where it balances them."""
        from eq_model.coupled.slide_kernel import begin

        drive, unit = self.drive, self._unit
        spring = self._spring * self.n
        nothing = np.empty(0)
        pull = self._pull(nothing, nothing, nothing, nothing)
        back = max(begin(slider, queue, pull, *part) for part in self._draws.begin(replica))
        s, path = slider[0], drive.path / unit
        balance = s["force"] / spring
        reached = (spring * path[0] - s["force"]) / (spring + s["stiffness"])
        if reached <= back:
            first = (s["force"] + (spring + s["stiffness"]) * back) / spring * unit
            raise InputError(
                f"path[0] = {drive.path[0]:g}: contacts break backwards while the drive moves there"
                f" from X_T = {balance * unit:g}, where it balances the start of replica {replica};"
                f" begin the path above {first:g}"
            )
        way = np.abs(np.diff(path, prepend=balance))
        time = np.cumsum(way) * unit / drive.velocity if drive.time is None else drive.time
        clock, places = np.append(0.0, time), np.append(balance, path)
        apart = np.append(True, np.diff(clock) > 0.0)
        clock, places = clock[apart], places[apart]
        # at the end the drive rests
        clock, places = np.append(clock, clock[-1] + 1.0), np.append(places, places[-1])
        return self._pull(spring * path, time, clock, places)

    def _pull(self, path: Array, time: Array, clock: Array, places: Array) -> Pull:
        from eq_model.coupled.slide_kernel import Pull

        contacts, rule = self.contacts, self.drive.slip
        delay = contacts.delay
        return Pull(
            spring=self._spring * self.n,
            path=path,
            time=time,
            clock=clock,
            clock_drive=places,
            wait=0.0 if delay is None else delay.time,
            mean=self._mean,
            slip=self._slip,
            at_once=rule == "instant" and delay is None,
            resets=rule == "reset",
            linked=contacts.stiffness == "linked",
            reforming=contacts.reforming is not None,
            delayed=delay is not None,
        )

    def _reset(self, slider: npt.NDArray[np.void], queue: Queue) -> None:
        """No contact holds, no return is due, and X = X_T: all are about to form there."""
        from eq_model.coupled.queue_kernel import clear

        s = slider[0]
        drive = s["pulled"] / (self._spring * self.n)
        s["size"], s["after"], s["force_after"] = s["broken"], drive, 0.0
        s["at"] = np.rint(drive)
        for name in ("force", "stiffness", "held", "out", "broken"):
            s[name] = 0
        s["returning"] = s["returns"]
        clear(queue, int(s["at"]))

    def _followed(
        self, s: np.void, told: Told, slips: list[list[float]], balance: float
    ) -> Followed:
        unit, of_force = self._unit, self._unit / self.n
        lengths = np.array([of_force / self._spring, unit, unit, of_force, of_force, 1.0])
        return Followed(
            position=told.position * self._unit,
            force=told.force * (self._unit / self.n),
            holding=told.held / self.n,
            slips=np.reshape(slips, (-1, len(_OF_A_SLIP))) * lengths,
            avalanches=told.avalanches,
            breaks=int(s["breaks"]),
            balance=balance * unit,
        )
