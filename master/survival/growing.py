"""Contacts whose thresholds grow with their age, as those of coalescing grains do (paper, Sec. VI), or by any law.

Each contact keeps its quantile for life. It breaks where the cumulative hazard H(|x|; age) of the law
of thresholds at its age reaches that of its quantile, so that of the contacts that formed together

    fraction that holds = exp(-(H_worst - H_0)),      H_worst = the largest H since the birth,

H_0 being H at t = 0 of contacts that are stretched then. On a straight leg H first falls, while the
contact relaxes or its threshold outgrows the stretch, and then rises: it is largest at an end.

With heat a contact whose quantile has the hazard η, and so the threshold x_s(η; age), may break early. Then

    fraction that holds = integral over η > H_worst of e^{-(η - H_0)} e^{-A(η)},

A(η), the integrated rate, being the integral over time of the rate h(|x|; x_s).
"""

from __future__ import annotations

from copy import copy

import numpy as np

from master.motion import History, Motion
from master.numerics.averages import FROM_HALF, HALF_OF_NODES, integrals_above
from master.numerics.polynomials import Rows
from master.survival.changing import ChangingLife
from master.survival.life import MARGIN, Survivors
from origins import Contacts, GrowingThresholds
from origins.errors import refuse
from origins.start import Start
from origins.thresholds.law import Array

# H above which the survival e^-H, below NEGLECTED, counts as 0.
LARGEST_HAZARD = 39.2
# Edges of the first pieces of sums over quantiles, as η - H_worst.
HAZARDS = np.array([0.0, 0.25, 4.0, LARGEST_HAZARD])
# Last coefficients below which pieces are not halved, of these sums and, relative to 1 + A, of A over the logarithm of
# time: errors are about the square. The second where thresholds do not begin at 0: heat then breaks contacts within a
# narrow band of thresholds, and to the first errors of 1e-8 would make tables rough (measured).
COEFFICIENT_LIMIT, LIMIT_OF_BAND = 1e-6, 1e-7
# Of the tolerance: such coefficients on a path that is asked for to above 1e-4, with A at half of the nodes; and the
# largest. Larger ones make tables rough, and cost 100 times the look-ups (measured).
OF_TOLERANCE, LOOSEST = 1e-3, 1e-6
# With heat, of contacts whose thresholds do not begin at 0: the tolerance down to which all paths are followed; and
# below it the most CPU seconds that one may take without `wall_time`, by an estimate (see `_seconds`).
FINEST, MOST_SECONDS = 1e-5, 70.0
# CPU seconds to 1e-6 of a leg of a mean threshold or more, of a turn beside it, and of each decade of a rest's time;
# factors for each decade of the tolerance of legs, and of turns and rests; and for a start with a width. Measured: a
# step of the speed 7 s, to 1e-9 17 s, from a wide start 23 s, of narrow thresholds to 1e-8 58 s; a turn 14, 23 and 99 s
# to 1e-6, 1e-7 and 1e-8, of a slower slider 46 s; rests of 20 and 2,000 times the law's time 20 to 33 and 59 s.
OF_LEG, OF_TURN, OF_DECADE_AT_REST = 7.0, 14.0, 10.0
FOR_DECADE, FOR_DECADE_TURNED, FOR_WIDTH = 1.4, 2.6, 3.0
# With heat: the same over stretches at birth, with which normal laws are summed to 1e-8; and the work of a survival in
# look-ups in a table (measured).
WARM_COEFFICIENT_LIMIT, WARM_WORK = 1e-5, 250
# Part of a contact's age, in the logarithm of time, from which on a leg is told apart from none; and the least.
SHORTEST, TINY = 1e-14, 1e-200
# Largest threshold of which a rate is asked (a length), as that of the strongest contact of all may be infinite: beyond
# all others, and its square is finite.
LARGEST = 1e100
# ln A at which e^-A is 0 in floating point.
LOG_OF_BROKEN = 7.0
# Largest hazard lost right after pinning: the survival e^-300 is close to underflow.
MOST_LOST = 300.0


class GrowingLife(ChangingLife):
    """Life (see master.survival.life) of contacts with GrowingThresholds.

    longest : the latest time > 0 at which `survival_and_force` is called

    Contacts born with the law `contacts.start`, the same object, or at single stretches other than 0 are those of t = 0
    and have the starting age; all others pin at birth, at the stretch 0 (of grains at the age tau_m).
    """

    def __init__(self, contacts: Contacts, longest: float) -> None:
        """Find how far contacts may be stretched, and how finely their survival varies."""
        super().__init__(contacts, longest)
        growing = contacts.growing
        assert growing is not None
        self._growing: GrowingThresholds = growing
        self.start, self._thermal = contacts.start, contacts.thermal
        self._is_of_start = False  # set for each query, in a copy
        if contacts.thermal is not None:
            self.pair_work = WARM_WORK
            self.coefficient_limit = WARM_COEFFICIENT_LIMIT
        self._limit = COEFFICIENT_LIMIT if growing.begins_at_0 else LIMIT_OF_BAND
        self._at_half = False  # whether A is asked for at half of the nodes of sums over quantiles

    @classmethod
    def made(
        cls, contacts: Contacts, tolerance: float, motion: Motion, until: float
    ) -> GrowingLife:
        """See ChangingLife."""
        life = cls(contacts, float(motion.times[-1]))
        slow = contacts.thermal is not None and not life._growing.begins_at_0
        if slow and not motion.one_leg and tolerance < FINEST and until == np.inf:
            seconds = life._seconds(motion, tolerance)
            if seconds > MOST_SECONDS:
                what = "on a path that turns, rests or changes its speed, with heat where thresholds grow"
                hint = (
                    f"takes some {seconds:.0f} s {what}; {FINEST:g} takes less, or give wall_time"
                )
                refuse("tolerance", tolerance, hint)
        # With looser limits tables of grains are rough, and never fine enough. So are those of a path of one leg, where
        # forces are the same at all limits: refined 43 times, they took 90 times as long at 1e-4 as at 1e-5.
        limit = min(OF_TOLERANCE * tolerance, LOOSEST)
        if limit > life._limit and not (life._growing.begins_at_0 or motion.one_leg):
            life._limit, life._at_half = limit, True
        return life

    def _seconds(self, motion: Motion, tolerance: float) -> float:
        """About how long a path of several legs takes to a tolerance below FINEST, in s of CPU time."""
        speeds, decades = motion.speeds, np.log10(1e-6 / max(tolerance, 1e-16))
        turns = float((speeds[1:] * speeds[:-1] < 0.0).sum())
        rests = np.diff(motion.times)[speeds == 0.0] / self._growing.time_unit
        bent = OF_TURN * turns + OF_DECADE_AT_REST * float(np.log10(1.0 + rests).sum())
        distances = np.abs(np.diff(motion.positions)) / self._growing.at_start.mean()
        legs = OF_LEG * float(np.minimum(distances, 1.0).sum())
        seconds = legs * FOR_DECADE**decades + bent * FOR_DECADE_TURNED**decades
        return float(seconds * (1.0 if self.start.is_single else FOR_WIDTH))

    @classmethod
    def why_not(cls, contacts: Contacts, one_leg: bool = True) -> str:
        """See ChangingLife: with heat the births of contacts whose thresholds begin at 0 take minutes on a path of
        several legs."""
        growing = contacts.growing
        assert growing is not None
        if refusal := super().why_not(contacts, one_leg):
            return f"{refusal}, or use eq_model.simulate"
        if contacts.thermal is None or one_leg or not growing.begins_at_0:
            return ""
        fault = (
            "heat beside thresholds that grow is taken at one speed alone, by the master equation"
        )
        instead = "use eq_model.simulate, which takes a rigid slider that turns or rests"
        return f"contacts.thermal: {fault}; {instead}"

    @classmethod
    def longest(cls, contacts: Contacts, velocity: float) -> float:
        """See ChangingLife."""
        growing = contacts.growing
        assert growing is not None
        growing.check_speed(velocity)
        lost = growing.lost_hazard(velocity)
        if lost > MOST_LOST:
            few = f"none holds but a fraction exp(-{lost:.4g})"
            why = "they are stretched before their grains have grown"
            hint = f"{few}: {why}; slide more slowly, and of many speeds leave such ones out"
            refuse("velocity", velocity, hint)
        return super().longest(contacts, velocity)

    def survival_and_force(self, born: Start | Array, history: History) -> Survivors:
        """See Life."""
        life = copy(self)
        life._is_of_start = born is self.start if isinstance(born, Start) else bool(np.any(born))
        return super(GrowingLife, life).survival_and_force(born, history)

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """See Life."""
        displacement, duration, speed = history.legs()
        stretch = born[:, None] + displacement
        pinned_for = np.insert(
            duration, 0, self._growing.start_pinned_for * self._is_of_start, axis=1
        )
        pinned_for = np.cumsum(pinned_for, axis=1)
        hazards = self._growing.hazard_at(stretch, pinned_for)
        worst = hazards.max(axis=1)
        if not self._is_of_start:
            # right after pinning some are stretched faster than their thresholds grow
            lost = np.array([self._growing.lost_hazard(abs(float(v))) for v in speed])
            has_moved = duration.any(axis=1)
            birth_leg = np.where(has_moved, np.argmax(duration > 0.0, axis=1), speed.size - 1)
            worst = np.maximum(worst, lost[birth_leg])
        # contacts with |x| above the largest threshold at t = 0 never hold
        at_birth = np.where(np.isfinite(hazards[:, 0]), hazards[:, 0], -np.inf)
        survival = np.exp(at_birth - worst)
        error = self.error
        if self._thermal is not None:
            some = survival > 0.0
            of_heat, heat_error = self._heat_survival(stretch[some], pinned_for[some], worst[some])
            survival[some] *= of_heat
            error += heat_error
        return Survivors(survival, survival * stretch[:, -1], error)

    def _heat_survival(
        self, stretch: Array, pinned_for: Array, worst: Array
    ) -> tuple[Array, float]:
        """Fraction that heat has not broken of contacts with quantiles beyond the hazards `worst`, (n,), by stretches
        and times since pinning at the ends of all legs, (n, legs + 1); and its error."""
        rate_errors = [0.0]

        def survival(row: Rows, hazard: Array) -> Array:
            some = hazard[:, HALF_OF_NODES] if self._at_half else hazard
            integrated, error = self.integrated_rate(some, stretch[row], pinned_for[row])
            rate_errors.append(error)
            if self._at_half:  # A takes long, and ln A is smoother than e^-A
                log = np.log(np.maximum(integrated, TINY)) @ FROM_HALF
                integrated = np.exp(np.minimum(log, LOG_OF_BROKEN))
            return np.exp(worst[row, None] - hazard - integrated)[None]

        ends = worst[:, None] + HAZARDS
        found = integrals_above(survival, worst, ends, True, self._limit)
        sums_error = MARGIN * float(found.missed[0].max(initial=0.0))
        return found.value[0], sums_error + max(rate_errors)

    def integrated_rate(
        self, hazard: Array, stretch: Array, pinned_for: Array
    ) -> tuple[Array, float]:
        """A of contacts whose quantiles have these hazards (n, k), with stretches and times since pinning at the ends
        of legs (n, legs + 1), shape (n, k); and the error of e^-A."""
        integrated, error = np.zeros(hazard.shape), 0.0
        for leg in range(stretch.shape[1] - 1):
            ends = np.s_[leg : leg + 2]
            begin, end = np.log1p(pinned_for[:, ends].T / self._growing.time_unit)
            lasts = end - begin > SHORTEST * end + TINY  # others are over in the rounding of times
            if lasts.any():
                on_leg = hazard[lasts], stretch[lasts, ends], pinned_for[lasts, ends]
                added, missed = self._on_one_leg(*on_leg)
                integrated[lasts] += added
                error += missed
        return integrated, error

    def _on_one_leg(self, hazard: Array, stretch: Array, pinned_for: Array) -> tuple[Array, float]:
        """As `integrated_rate`, on one leg: of shape (n, 2)."""
        assert self._thermal is not None
        rates, unit = self._thermal.rates, self._growing.time_unit
        count = hazard.shape[1]
        first, last = stretch.T
        begin, end = pinned_for.T
        speed = np.divide(last - first, end - begin, out=np.zeros(end.size), where=end > begin)
        # the rate bends where x = 0
        crosses_0 = first * last < 0.0
        at_0 = np.where(crosses_0, begin - first / np.where(speed, speed, 1.0), end)
        # thresholds grow in the logarithm of the time; at the end the rate may vanish as a root
        log_times = np.log1p(np.stack([begin, at_0, end], axis=1) / unit)
        before_ends = np.repeat((log_times[:, -1:] - log_times)[:, ::-1], count, axis=0)
        span = log_times[:, -1] - log_times[:, 0]

        threshold_of = self._growing.thresholds_of(hazard.ravel())

        def rate_and_1(owner: Rows, before_end: Array) -> Array:
            """The rate per logarithm of time, and this plus 1/span, whose integral is A + 1."""
            row = owner // count
            time = unit * np.expm1(log_times[row, -1:] - before_end)
            x = np.abs(first[row, None] + speed[row, None] * (time - begin[row, None]))
            threshold = np.minimum(threshold_of(owner, time), LARGEST)
            rate = rates.rate(np.minimum(x, threshold), threshold, 1.0) * (unit + time)
            return np.stack([rate, rate + 1.0 / span[row, None]])

        # the survival e^-A is as good as the error of A relative to 1 + A, the integral of the second function
        least = np.zeros(hazard.size)
        found = integrals_above(rate_and_1, least, before_ends, True, self._limit, relative=True)
        integrated = found.value[0].reshape(hazard.shape)
        error = found.missed[0] / np.maximum(found.value[1], 1.0)
        return integrated, MARGIN * float(error.max(initial=0.0))
