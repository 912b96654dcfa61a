"""One replica: N contacts and a slider, from the start to the end of the drive's path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from origins import Contacts, Drive
from origins.errors import InputError

if TYPE_CHECKING:
    from eq_model.coupled.slide_kernel import Pull

Array = npt.NDArray[np.float64]

_NEVER = -(1 << 62)
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
    avalanches : array of shape (40,)
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

    def packed(self) -> Array:
        """All of it as one row of numbers."""
        tail = *self.avalanches, self.breaks, self.balance
        return np.concatenate([self.position, self.force, self.holding, self.slips.ravel(), tail])

    @classmethod
    def unpacked(cls, row: Array, slips: int) -> Followed:
        """What was packed with so many slips."""
        curves, table, tail = np.split(row, [row.size - 6 * slips - 42, row.size - 42])
        counts, breaks, balance = tail[:-2].astype(np.int64), int(tail[-2]), float(tail[-1])
        position, force, holding = curves.reshape(3, -1)
        return cls(position, force, holding, table.reshape(-1, 6), counts, breaks, balance)


class Follower:
    """Follows replicas of `n` contacts on the slider that `drive` pulls; a slip breaks at least
    `slip_fraction` of them."""

    def __init__(
        self, contacts: Contacts, drive: Drive, n: int, seed: int, slip_fraction: float
    ) -> None:
        from eq_model.coupled.draws import Draws
        from eq_model.coupled.queue_kernel import bucket_width
        from eq_model.coupled.slide_kernel import Pull

        assert drive.spring is not None
        self._draws, self._drive, self._n = Draws(contacts, seed), drive, n
        self._unit, self._spring = self._draws.unit, drive.spring
        law, mean = contacts.thresholds, contacts.mean_threshold
        self._width = bucket_width(n, lambda width: float(law.cdf(width * mean)))
        delay, nothing = contacts.delay, np.empty(0)
        self._pull = Pull(
            spring=drive.spring * n,
            path=nothing,
            time=nothing,
            clock=nothing,
            clock_drive=nothing,
            wait=0.0 if delay is None else delay.time,
            mean=mean / self._unit,
            slip=max(int(np.ceil(slip_fraction * n)), 1),
            at_once=drive.slip == "instant" and delay is None,
            resets=drive.slip == "reset",
            linked=contacts.stiffness == "linked",
            delayed=delay is not None,
        )

    def follow(self, replica: int) -> Followed:
        """What the replica does.

        Raises InputError where contacts would break while the drive moves back to its first point.
        """
        from eq_model.coupled import slide_kernel as kernel
        from eq_model.coupled.queue_kernel import clear, make_queue

        n, size = self._n, self._drive.path.size
        draws, queue = self._draws.of_replica(replica), make_queue(n, self._pull.mean, self._width)
        slider = np.zeros(1, kernel.SLIDER)
        s, slips = slider[0], list[list[float]]()
        s["back"] = _NEVER
        kernel.form_all(slider, queue, draws, self._pull, n, True)
        balance = float(s["force"]) / self._pull.spring
        pull = self._driven(s, balance)
        told = kernel.make_told(size)
        returns = kernel.make_returns(n if pull.delayed else 1)
        while (why := kernel.slide(slider, queue, draws, pull, told, returns)) != kernel.PATH_DONE:
            if why == kernel.BUCKETS_PASSED:
                continue  # to let an interrupt be heard
            if why == kernel.RESET_DUE:  # no contact holds, no return is due, and X = X_T
                drive = s["pulled"] / pull.spring
                s["size"], s["after"], s["force_after"] = s["broken"], drive, 0.0
                s["at"], s["returning"] = np.rint(drive), s["returns"]
                for name in ("force", "stiffness", "held", "out", "broken"):
                    s[name] = 0
                clear(queue, int(s["at"]))
                kernel.form_all(slider, queue, draws, pull, n, False)
            slips.append([float(s[name]) for name in _OF_A_SLIP])
        unit, each = self._unit, self._unit / n
        return Followed(
            position=told.position * unit,
            force=told.force * each,
            holding=told.held / n,
            slips=np.reshape(slips, (-1, len(_OF_A_SLIP)))
            * [each / self._spring, unit, unit, each, each, 1.0],
            avalanches=told.avalanches,
            breaks=int(s["breaks"]),
            balance=balance * unit,
        )

    def _driven(self, s: np.void, balance: float) -> Pull:
        """The pull of a drive that comes to its path from X_T = balance (units)."""
        drive, unit, spring = self._drive, self._unit, self._pull.spring
        path, both = drive.path / unit, spring + s["stiffness"]
        if spring * path[0] - s["force"] <= both * s["back"]:
            first = (s["force"] + both * s["back"]) / spring * unit
            raise InputError(
                f"path[0] = {drive.path[0]:g}: contacts break backwards while the drive moves there"
                f" from X_T = {balance * unit:g}, where it balances the start; begin the path above"
                f" {first:g}"
            )
        way = np.abs(np.diff(path, prepend=balance))
        time = np.cumsum(way) * unit / drive.velocity if drive.time is None else drive.time
        # at the end the drive rests
        clock, places = np.r_[0.0, time, time[-1] + 1.0], np.r_[balance, path, path[-1]]
        moves = np.append(True, np.diff(clock) > 0.0)
        return self._pull._replace(
            path=spring * path, time=time, clock=clock[moves], clock_drive=places[moves]
        )
