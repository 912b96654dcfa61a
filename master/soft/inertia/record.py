"""Record of a slider with mass: its motion and energies at asked times, and the falls of its spring's force."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from master.soft.inertia.reaction import Reaction
from origins.drive import FASTER, LOWER, RISE, ROOM, SLIP_FRACTION
from origins.thresholds.law import Array

# Share of the contacts that breaks in a fall of the force; rounding is below it.
ANY = 1e-6
# Part of the time of a fall. A swing back spends its last fiftieth on the last thousandth (LOWER) of its fall; one that
# spends more than this part on it only comes close to its end.
TOO_LONG_AT_END = 0.25
# Part of LOWER by which the force changes from one instant that is kept to the next.
NEXT = 0.25
# Share of a fall in place of 0, whose logarithm is taken.
TINY = 1e-30


class Instant(NamedTuple):
    """A slider at an instant.

    time, drive, place, force : t, X_T, X and F/(N_c<k>) of the spring; breaks : per contact since t = 0
    """

    time: float
    drive: float
    place: float
    force: float
    breaks: float


class SlipWithMass(NamedTuple):
    """A swing down of the spring's force that ended a stick, and the top speed in it along the axis of X; whether it
    fades, so that its end is where all but LOWER of it is done, with the force that it comes close to."""

    begin: Instant
    end: Instant
    top_speed: float
    fades: bool


class Watched(NamedTuple):
    """A slider at some times in order, close enough to see each fall of its spring's force.

    times, speeds, places, forces : arrays of shape (n,); speeds along the way of the drive, others as in Instant
    holding : share of the contacts that hold, array of shape (n,)
    drive_speed : of the drive along its way; drive_direction : +1 or -1
    at : the slider at a time between the first and the last
    when : the time between the k-th and the next one at which the slider is as fast as its drive
    """

    times: Array
    speeds: Array
    places: Array
    forces: Array
    holding: Array
    drive_speed: float
    drive_direction: int
    at: Callable[[float], Instant]
    when: Callable[[int], float]


def crossing(excess: Callable[[float], float], low: float, high: float) -> float:
    """Where `excess` changes its sign; where both ends have one sign, as it was told from numbers that were rounded
    otherwise, the end at which it is nearer to 0."""
    first, last = excess(low), excess(high)
    if first * last > 0.0:
        return low if abs(first) < abs(last) else high
    return float(brentq(excess, low, high))


class Spent(NamedTuple):
    """Energies per N_c<k> (lengths squared), numbers or arrays of one shape: what the drive gave, and what the damping
    and moving the contacts took."""

    work: Any
    damped: Any
    on_contacts: Any

    def plus(self, other: "Spent") -> "Spent":
        """Both together."""
        return Spent(*(a + b for a, b in zip(self, other, strict=True)))

    def less(self, other: "Spent") -> "Spent":
        """These without the other ones."""
        return Spent(*(a - b for a, b in zip(self, other, strict=True)))

    def at(self, which: int | slice) -> "Spent":
        """Those at some of the instants."""
        return Spent(*(one[which] for one in self))


NOTHING_SPENT = Spent(0.0, 0.0, 0.0)


class OnMove(NamedTuple):
    """Asked times at which the contacts are those of one move, and its travels there (n,); what they store is found at
    the end."""

    move: Reaction
    which: slice
    travels: Array


class Record:
    """Results at asked times, arrays of shape (n,), in order; NaN where the slider has not come yet.

    place, speed, contact_force : X, dX/dt and F/(N_c<k>)
    work, damped, on_contacts : from t = 0 on, see Spent
    stored : energy of the contacts, known at the end; holding : share of the contacts
    slips : in order, as origins.drive defines them
    """

    def __init__(self, times: Array, unit: float, waits: float) -> None:
        """`unit` is the mean threshold, a length; `waits` the delay of the contacts, a time."""
        self.times, self._rise, self._room = times, RISE * unit, ROOM * unit
        self._unit, self._waits = unit, waits
        self._path_end = float(times[-1]) if times.size else np.inf
        self.place, self.speed, self.contact_force = (np.full(times.size, np.nan) for _ in range(3))
        self.work, self.damped, self.on_contacts = (np.full(times.size, np.nan) for _ in range(3))
        self.stored, self.holding = np.zeros(times.size), np.ones(times.size)
        self.slips = list[SlipWithMass]()
        # where the present fall began, and the largest speed in it along the drive's way
        self._fall: Instant | None = None
        self._top_speed = 0.0
        self._way_down = list[Instant]()  # the slider in it, wherever the force has changed
        # where the present swing down, or the next one, begins, and where it has been lowest, None before it has fallen
        # enough; the largest speed in it; whether it is the last slip
        self._high: Instant | None = None
        self._low: Instant | None = None
        self._top_of_swing, self._slips, self._direction = 0.0, False, 0
        self._end: Instant | None = None  # of that swing, where it fades
        self._limit = 0.0  # the drive's speed along its way, at least 0
        # whether the slider has stuck since the last slip, and the breaks when it last did
        self._stuck, self._broken_before = True, 0.0
        # X and the share that held there
        self._stuck_at, self._held = 0.0, 1.0
        # from where on the slider may be sticking
        self._rest: Instant | None = None
        self._waiting = list[OnMove]()

    def between(self, begin: float, end: float) -> slice:
        """Which of the asked times lie beyond `begin`, or at it if it is 0, and up to `end`."""
        first = np.searchsorted(self.times, begin, "right" if begin > 0.0 else "left")
        return slice(int(first), int(np.searchsorted(self.times, end, "right")))

    def write(
        self,
        which: int | slice,
        place: Array | float,
        speed: Array | float,
        contact_force: Array | float,
        spent: Spent,
    ) -> None:
        """The results at some of the asked times; `spent` from t = 0 on."""
        self.place[which], self.speed[which] = place, speed
        self.contact_force[which] = contact_force
        self.work[which], self.damped[which], self.on_contacts[which] = spent

    def store_later(self, move: Reaction, which: slice, y: Array) -> None:
        """The contacts at these times are those of a move at travels y."""
        if y.size:
            self._waiting.append(OnMove(move, which, y))

    def finish(self) -> None:
        """Find what the contacts store, on each move at once."""
        for move in {id(one.move): one.move for one in self._waiting}.values():
            own = [one for one in self._waiting if one.move is move]
            which = np.concatenate([np.arange(one.which.start, one.which.stop) for one in own])
            self.stored[which] += move.stored(np.concatenate([one.travels for one in own]))
        self._waiting = []

    def watch(self, seen: Watched) -> None:
        """Begin and end falls of the spring's force, and see whether the slider sticks outside of them."""
        self._limit = limit = max(seen.drive_speed, 0.0)
        if seen.drive_direction != self._direction:
            self._direction = seen.drive_direction
            self._end_swing()
        if (seen.speeds[0] > limit) != (self._fall is not None):  # the drive's speed has changed
            self._begin_or_end_fall(seen.at(float(seen.times[0])), limit, seen.drive_direction)
        for k, t in enumerate(seen.times.tolist()):
            if k and (seen.speeds[k] > limit) != (seen.speeds[k - 1] > limit):
                self._begin_or_end_fall(seen.at(seen.when(k - 1)), limit, seen.drive_direction)
            if self._fall is None:
                self._see_stick(k, t, seen)
            else:
                self._top_speed = max(self._top_speed, _peak(seen.speeds, k))
                high, force = self._high or self._fall, float(seen.forces[k])
                change = abs(force - self._way_down[-1].force)
                ends = t >= (1.0 - 1e-12) * self._path_end  # but for the rounding of times
                if ends or change > NEXT * LOWER * abs(high.force - force):
                    self._way_down.append(seen.at(t))

    def end_path(self) -> None:
        """The path has ended: so has a fall that has faded."""
        if self._fall is None:
            return
        high, last = self._high or self._fall, self._way_down[-1]
        if last.force != high.force and self._faded(high, last) is not None:
            self._begin_or_end_fall(last, self._limit, self._direction)

    def _faded(self, high: Instant, at: Instant) -> Instant | None:
        """Where all but LOWER of a swing from `high` down to `at` is done, with its force, if the slider has spent
        more than a part TOO_LONG_AT_END of its time from there on; else None. Only time and place are not of `at`."""
        down = [*self._way_down, at]
        rest = np.array([one.force - at.force for one in down]) / (high.force - at.force)
        k = max(int(np.argmax(rest <= LOWER)), 1)
        # between two of them the rest falls as an exponential does
        first, last = np.log(np.clip(rest[k - 1 : k + 1], TINY, 1.0) / LOWER).tolist()
        part = first / (first - last) if first > 0.0 > last else 1.0
        low, up = down[k - 1], down[k]
        when = low.time + part * (up.time - low.time)
        place = low.place + part * (up.place - low.place)
        if at.time - when <= TOO_LONG_AT_END * (at.time - high.time):
            return None
        return at._replace(time=when, place=place)

    @property
    def slips_since(self) -> float | None:
        """When a swing down began that ends a stick and goes on, which may be a slip; None without one."""
        if self._fall is None or not self._stuck:
            return None
        return (self._high or self._fall).time

    def forget_fall(self) -> None:
        """The present fall is none that counts."""
        self._fall = None

    def _see_stick(self, k: int, t: float, seen: Watched) -> None:
        """Whether the slider sticks at the k-th time."""
        rest, force = self._rest, float(seen.forces[k])
        place, holding = float(seen.places[k]), float(seen.holding[k])
        if seen.drive_direction * (place - self._stuck_at) < -self._room:
            self._stuck = False  # it has only turned there
        enough = max(RISE, SLIP_FRACTION * self._held if self._stuck else 0.0)
        if rest is None or holding < enough or abs(place - rest.place) > self._room:
            self._rest = seen.at(t)
        elif seen.drive_direction * (force - rest.force) >= self._rise:
            self._rest = here = seen.at(t)
            if here.breaks - rest.breaks < SLIP_FRACTION * holding:
                self._stuck, self._broken_before = True, here.breaks
                self._stuck_at, self._held = place, holding

    def _begin_or_end_fall(self, at: Instant, limit: float, drive_direction: int) -> None:
        """The spring's force begins to fall, or a fall ends: the present swing down has begun, goes on or is over, and
        is a slip if it ends a stick."""
        begin, self._fall = self._fall, None
        ahead = drive_direction
        if begin is None:
            self._fall, self._top_speed = at, 0.0
            self._way_down = [at]
            if self._low is not None and ahead * (at.force - self._low.force) >= self._rise:
                self._end_swing()
            if self._low is None and (
                self._high is None or ahead * (at.force - self._high.force) >= 0.0
            ):
                self._high, self._top_of_swing = at, 0.0
            return
        high = self._high or begin
        drop = ahead * (high.force - at.force)
        self._top_of_swing = top = max(self._top_of_swing, self._top_speed)
        if self._low is not None or drop >= self._rise:
            lower = self._low is None or ahead * (self._low.force - at.force) > LOWER * drop
            if lower or self._low is None:
                self._low, self._end = at, self._faded(high, at)
            # of those that held, and of those that hold in steady sliding
            holding = self._unit / (self._unit + limit * self._waits)
            least = max(RISE, SLIP_FRACTION * max(self._held, holding))
            broke = at.breaks - self._broken_before >= least
            begins = not self._slips and self._stuck and broke and top >= FASTER * limit
            if self._slips:
                self.slips.pop()
            if begins or self._slips:
                fades = self._end is not None
                self.slips.append(SlipWithMass(high, self._end or self._low, ahead * top, fades))
                self._slips, self._stuck = True, False
            if begins or (self._slips and lower):
                self._rest = at
                return
        if at.breaks - begin.breaks > ANY:
            self._rest = at

    def _end_swing(self) -> None:
        """The present swing down is over."""
        self._high = self._low = None
        self._slips = False


def _peak(values: Array, k: int) -> float:
    """The k-th of some values, or if it is the largest beside, that of a parabola through the three."""
    if 0 < k < values.size - 1 and values[k] >= max(values[k - 1], values[k + 1]):
        before, here, after = values[k - 1 : k + 2].tolist()
        bend = before - 2.0 * here + after
        return here - 0.125 * (after - before) ** 2 / bend if bend < 0.0 else here
    return float(values[k])
