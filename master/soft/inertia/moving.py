"""A slider with mass while it moves on and contacts break: an ordinary differential equation."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebroots, chebtrim, chebvander
from scipy.integrate import DOP853, LSODA, DenseOutput
from scipy.optimize import brentq

from master.outcome import StoppedError, stop_after
from master.soft.inertia.body import GETS_SLOW, RINGS, Body, Mode
from master.soft.inertia.record import Instant, Spent
from origins.thresholds.law import Array

# Most steps of the integrator: some 20 s.
MOST_STEPS = 50_000
# Error of a step, in units of the tolerance, and the least, in mean thresholds: rounding. Those of a slip add up, and
# move what follows; at 1e-3 that was up to half of the tolerance, and did not fall with it.
FINE, FINEST = 1e-4, 1e-12
# Points of a step at which the speed is compared with the drive's.
POINTS = 17
# Degree in time of the state within a step of DOP853 (in a step of LSODA, of up to 12, turning points of the speed are
# looked for with as many terms); and the matrix that takes values at POINTS even points of a step
# to coefficients of Chebyshev's polynomials, in which a coefficient below ROUNDING of the largest is none.
DEGREE, ROUNDING = 7, 1e-14
COEFFICIENTS = np.linalg.pinv(chebvander(np.linspace(-1.0, 1.0, POINTS), DEGREE))
# Steps between two looks at the clock, which takes as long as a step.
UNWATCHED = 64
# Longest first step, in times (M/K)^(1/2) of a swing on the spring, as long as a slip takes. The integrator's own guess
# hangs on the unit of time, and where it is too long its stages lie so far ahead that F is solved there without end.
# The far shorter swing on the contacts would let `moving` and `following` alternate without getting on.
FIRST_STEP = 1.0
# Above critical damping, first step in times M/g in which a speed relaxes: these are far shorter than all else, and
# LSODA, whose implicit steps need not resolve them, begins at its lowest order.
FIRST_RELAXING = 1e-3
# Accuracy of an instant within a step, in steps; and relative, the least that brentq takes is 4 spacings.
INSTANT, INSTANT_RELATIVE = 1e-15, 1e-14


class Integrated(NamedTuple):
    """The integrator's state: travel and speed, and the parts of Spent."""

    y: float
    w: float
    damped: float
    work: float
    on_contacts: float

    @property
    def spent(self) -> Spent:
        """The energies."""
        return Spent(self.work, self.damped, self.on_contacts)


class Step(NamedTuple):
    """A step of the integrator, in time since `begun`; a state is an array of what `Integrated` names.

    first, last : times of its beginning and end; state : at the end; inside : the state at times between
    """

    begun: float
    first: float
    last: float
    state: Array
    inside: DenseOutput

    def when(self, part: int, value: float, low: float) -> float:
        """When a part of the state, which is beside the value at `low` and at the end, has it."""
        if low >= self.last:
            return low
        inside, accuracy = self.inside, INSTANT * (self.last - self.first)
        return float(
            brentq(
                lambda t: inside(t)[part] - value,
                *(low, self.last),
                xtol=accuracy,
                rtol=INSTANT_RELATIVE,
            )
        )

    def turns_back(self, at_rest: bool) -> float | None:
        """When the speed falls to 0, None where it does not; `at_rest`: it is 0 or below at the beginning.

        A slider that comes all but to rest may turn and go on within one step, so that the step's ends tell of no turn.
        """
        even = np.linspace(self.first, self.last, POINTS)
        polynomial = COEFFICIENTS @ self.inside(even)[1]
        if polynomial[0] > np.abs(polynomial[1:]).sum():
            return None
        # between two of these times the speed only rises or only falls
        times = np.union1d(even, self._turning_points(polynomial))
        speed = self.inside(times)[1]
        ahead = np.flatnonzero(speed > 0.0)
        if at_rest and not ahead.size:
            return self.first
        begin = int(ahead[0]) if at_rest else 0
        behind = begin + 1 + np.flatnonzero(speed[begin + 1 :] <= 0.0)
        if not behind.size:
            return None
        k = int(behind[0])
        return self._replace(last=float(times[k])).when(1, 0.0, float(times[k - 1]))

    def _turning_points(self, polynomial: Array) -> Array:
        """Times at which this polynomial neither rises nor falls; some others among them do no harm."""
        slope = chebder(polynomial)
        roots = chebroots(chebtrim(slope, ROUNDING * np.abs(slope).max())).real
        times = self.first + (self.last - self.first) * 0.5 * (roots + 1.0)
        return np.clip(times, self.first, self.last)

    def up_to(self, end: float) -> "Step":
        """The step cut at this time."""
        return self._replace(last=end, state=self.inside(end))


class Moving(Body):
    """A slider that moves fast enough to break contacts, and is integrated step by step."""

    def moving(self) -> Mode:
        """Integrate the motion until the slider turns, rests, reaches a drop of F or the drive's leg ends."""
        begun, rate = self.t, self.spring * self._speed
        solver = self._solver()
        while True:
            at_rest = self.w <= 0.0
            solver.step()
            self.steps += 1
            if solver.status == "failed" or self.steps > MOST_STEPS:
                raise StoppedError(RINGS)
            if not self.steps % UNWATCHED:
                stop_after(self.contacts.until)
            step = Step(begun, solver.t_old, solver.t, solver.y, solver.dense_output())
            drop, back, finished = self._drop, step.turns_back(at_rest), solver.status == "finished"
            if back is not None:
                step = step.up_to(back)
            drops = step.state[0] > drop
            if drops:
                step = step.up_to(step.when(0, drop, step.first))
            turns = back is not None and not drops
            finished &= not (drops or turns)
            self._take(step, self._leg_end() if finished else begun + step.last)
            if turns:
                self.w = 0.0
                return self.turn()
            if drops:
                self.y = float(np.nextafter(drop, np.inf))
                return self.moving
            if finished:
                self._next_leg()
                return self.moving
            if rate >= 0.0 and self._follows(GETS_SLOW) and self._goes_on_slowly(rate):
                return self.following

    def _solver(self) -> DOP853 | LSODA:
        """The integrator from the present state to the end of the drive's leg."""
        m, g, k = self.mass, self.damping, self.spring
        move, v = self.move, self._speed
        pull, rate = float(self._pull(self.t)), k * v
        # behind a drop F is another polynomial: until it is reached, the one before goes on
        self._drop = np.inf

        def change(t: float, state: Array) -> Array:
            y, w = float(state[0]), float(state[1])
            panel = move.panel_at(y, self._drop)
            self._drop = min(self._drop, move.next_drop(self.y))
            if y > self._drop:
                panel = move.panel_at(y, self._drop)
            spring, force = pull + rate * t - k * y, panel.force(y)
            return np.array([w, (spring - g * w - force) / m, g * w * w, v * spring, force * w])

        state = np.array(Integrated(self.y, self.w, **self.spent._asdict()))
        fine, unit = max(FINE * self.tolerance / self.unit, FINEST), self.unit
        fast = unit / np.sqrt(m / self.stiff)
        sizes = fine * np.array([unit, fast, unit**2, unit**2, unit**2])
        lasts = self._leg_end() - self.t

        def slopes(t: float, state: Array) -> Array:
            """Derivatives of `change` by the state, shape (5, 5)."""
            y, w = float(state[0]), float(state[1])
            panel, out = move.panel_at(y, self._drop), np.zeros((5, 5))
            slope = panel.slope(y)
            out[0, 1], out[1, :2], out[2, 1] = 1.0, ((-k - slope) / m, -g / m), 2.0 * g * w
            out[3, 0], out[4, :2] = -v * k, (slope * w, panel.force(y))
            return out

        if self._heavily_damped:
            first = min(FIRST_RELAXING * m / g, lasts)
            return LSODA(
                change, 0.0, state, lasts, first_step=first, rtol=fine, atol=sizes, jac=slopes
            )
        solver = DOP853(change, 0.0, state, lasts, rtol=fine, atol=sizes)
        solver.h_abs = min(solver.h_abs, FIRST_STEP * float(np.sqrt(m / self.spring)))
        return solver

    def _take(self, step: Step, end: float) -> None:
        """Take a step that ends at this time: results at the asked times, falls, and the state."""
        record, d, begun = self.record, self.move.direction, step.begun
        self._watch_step(step)
        which = record.between(begun + step.first, end)
        for at in range(which.start, which.stop):
            now = Integrated(*step.inside(record.times[at] - begun).tolist())
            force = d * self._force(now.y)
            record.write(at, self.base + d * now.y, d * now.w, force, now.spent)
            record.store_later(self.move, slice(at, at + 1), np.array([now.y]))
        last = Integrated(*step.state.tolist())
        self.t, self.y, self.w, self.spent = end, last.y, last.w, last.spent

    def _watch_step(self, step: Step) -> None:
        """Falls of the spring's force within a step."""
        times, begun, limit = np.linspace(step.first, step.last, POINTS), step.begun, self._speed
        y, w = step.inside(times)[:2]

        def when(k: int) -> float:
            return step._replace(last=float(times[k + 1])).when(1, limit, float(times[k]))

        def at(t: float) -> Instant:
            place = float(step.inside(t)[0])
            return self._instant(begun + t, place, place)

        self.record.watch(self._watched(times, (y, w), self._drive(begun + times), at, when))
