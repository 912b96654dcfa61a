"""Record of a slider with mass: its motion and energies at asked times, and the falls of its spring's force."""

from typing import NamedTuple

import numpy as np

from master.soft.inertia.reaction import Reaction
from master.soft.regime import SLIP_SHARE
from origins.thresholds.law import Array


class Fall(NamedTuple):
    """An instant at which a fall of the spring's force begins or ends.

    time, drive, place, force : t, X_T, X and F/(N_c<k>) of the spring; breaks : of the present move, per contact
    """

    time: float
    drive: float
    place: float
    force: float
    breaks: float


class Slip(NamedTuple):
    """A fall in which enough contacts broke, and the top speed in it along the axis of X."""

    begin: Fall
    end: Fall
    top_speed: float


class Record:
    """Results at asked times, arrays of shape (n,), in order; NaN where the slider has not come yet.

    place, speed, contact_force : X, dX/dt and F/(N_c<k>)
    work, damped, on_contacts : energy per N_c<k> from t = 0 on, that the drive gave, that the damping took, and that
        moving the contacts took; stored : that of the contacts, known at the end; holding : share of the contacts
    slips : in order; fall, top_speed : the fall that has begun, if any, and the largest speed in it
    """

    def __init__(self, times: Array, least_drop: float) -> None:
        """`least_drop` is the least fall of the force that counts as a slip, a length."""
        self.times, self._least = times, least_drop
        self.place, self.speed, self.contact_force = (np.full(times.size, np.nan) for _ in range(3))
        self.work, self.damped, self.on_contacts = (np.full(times.size, np.nan) for _ in range(3))
        self.stored, self.holding = np.zeros(times.size), np.ones(times.size)
        self.slips, self.top_speed = list[Slip](), 0.0
        self.fall: Fall | None = None
        self._waiting = list[tuple[Reaction, slice, Array]]()

    def between(self, begin: float, end: float) -> slice:
        """Which of the asked times lie beyond `begin`, or at it if it is 0, and up to `end`."""
        first = np.searchsorted(self.times, begin, "right" if begin > 0.0 else "left")
        return slice(int(first), int(np.searchsorted(self.times, end, "right")))

    def store_later(self, move: Reaction, which: slice, y: Array) -> None:
        """The contacts at these times are those of a move at travels y."""
        if y.size:
            self._waiting.append((move, which, y))

    def finish(self) -> None:
        """Find what the contacts store, on each move at once."""
        for move in {id(entry[0]): entry[0] for entry in self._waiting}.values():
            own = [entry[1:] for entry in self._waiting if entry[0] is move]
            which = np.concatenate([np.arange(part.start, part.stop) for part, _ in own])
            self.stored[which] += move.stored(np.concatenate([y for _, y in own]))
        self._waiting = []

    def begin_fall(self, at: Fall) -> None:
        """The spring's force begins to fall."""
        self.fall, self.top_speed = at, 0.0

    def end_fall(self, at: Fall, direction: int) -> None:
        """The spring's force is smallest here; it was a slip if enough contacts broke."""
        begin, self.fall = self.fall, None
        if begin is None or abs(begin.force - at.force) < self._least:
            return
        if at.breaks - begin.breaks >= SLIP_SHARE:
            self.slips.append(Slip(begin, at, direction * self.top_speed))
