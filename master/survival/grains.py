"""Contacts whose thresholds grow with their age, as coalescing grains do (paper, Sec. VI).

Each contact keeps its quantile for life. It breaks where the cumulative hazard H(|x|; age) of the law
of thresholds at its age reaches that of its quantile, so that of the contacts that pinned together

    share that holds = exp(-(H_worst - H_0)),      H_worst = the largest H since the birth,

H_0 being H at t = 0 of contacts that are stretched then. On a straight leg H first falls, while the
contact relaxes or its threshold outgrows the stretch, and then rises: it is largest at an end.

With heat a contact whose quantile has the hazard η, and so the threshold x_s(η; age), may break early. Then

    share that holds = integral over η > H_worst of e^{-(η - H_0)} e^{-A(η)},

A(η) being the integral over time of the rate h(|x|; x_s).
"""

from copy import copy

import numpy as np

from master.motion import History
from master.numerics.averages import integrals_above
from master.numerics.polynomials import Rows
from master.survival.life import MARGIN, Life, Survivors
from origins import Contacts, GrainContact
from origins.start import Start
from origins.thresholds.law import Array

# H above which the survival e^-H, below 1e-17, counts as 0.
GONE = 39.2
# Edges of the first pieces of sums over quantiles, as η - H_worst; and last coefficients below which pieces are not
# halved, of these sums and, relative to 1 + A, of A over the logarithm of time.
HAZARDS, RESOLVED = np.array([0.0, 0.25, 4.0, GONE]), 1e-6


class GrainLife(Life):
    """Life (see master.survival.life) of contacts with growing grains; with heat, on one leg only.

    longest : the latest time > 0 at which `survival_and_force` is called

    Contacts born with the law `contacts.start`, the same object, or at single stretches other than 0 are those of t = 0
    and have the grains' starting age; all others pin at birth, at the stretch 0 and the age tau_m.
    """

    error = 1e-13  # the share's error by that of the hazards
    left_out, fresh = 1e-17, False  # e^-GONE

    def __init__(self, contacts: Contacts, longest: float) -> None:
        grains = contacts.grains
        assert grains is not None and grains.age is not None
        self.grains: GrainContact = grains
        self.start, self._of_start = contacts.start, False
        self.start_since = grains.age - grains.growth.first_pinning_time
        self.largest_stretch = float(grains.quantile(-np.expm1(-GONE), grains.age + longest))
        # no contact of the start is stretched beyond the largest threshold at t = 0
        self.largest_birth_stretch = grains.at_start.support()[1]
        self.resolution_length, self._thermal = 0.25 * grains.at_start.std(), contacts.thermal
        if contacts.thermal is not None:
            # with this `resolved` normal laws are summed to 1e-8
            self.pair_work, self.resolved = 1000, 1e-5

    def survival_and_force(self, born: Start | Array, history: History) -> Survivors:
        """See Life."""
        life = copy(self)
        life._of_start = born is self.start if isinstance(born, Start) else bool(np.any(born))
        return super(GrainLife, life).survival_and_force(born, history)

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """See Life."""
        displacement, lived, speed = history.legs()
        stretch = born[:, None] + displacement
        since = np.cumsum(np.insert(lived, 0, self.start_since * self._of_start, axis=1), axis=1)
        hazards = self.grains.hazard_at(stretch, self.grains.growth.excess_after(since))
        worst = hazards.max(axis=1)
        if not self._of_start:
            # right after pinning some are stretched faster than their thresholds grow
            lost = np.array([self.grains.lost_hazard(abs(float(v))) for v in speed])
            birth = np.where(lived.any(axis=1), np.argmax(lived > 0.0, axis=1), speed.size - 1)
            worst = np.maximum(worst, lost[birth])
        # contacts with |x| above the largest threshold at t = 0 never hold
        share = np.exp(np.where(np.isfinite(hazards[:, 0]), hazards[:, 0], -np.inf) - worst)
        error = self.error
        if self._thermal is not None:
            alive = share > 0.0
            unbroken, of_heat = self._unbroken(stretch[alive], since[alive], worst[alive])
            share[alive] *= unbroken
            error += of_heat
        return Survivors(share, share * stretch[:, -1], error)

    def _unbroken(self, stretch: Array, since: Array, worst: Array) -> tuple[Array, float]:
        """Share that heat has not broken of contacts with quantiles beyond the hazards `worst`, (n,), by stretches and
        times since pinning at both ends of one leg, (n, 2); and its error."""
        of_spent = [0.0]

        def held(row: Rows, hazard: Array) -> Array:
            spent, missed = self._spent(hazard, stretch[row], since[row])
            of_spent.append(missed)
            return np.exp(worst[row, None] - hazard - spent)[None]

        found = integrals_above(held, worst, worst[:, None] + HAZARDS, True, RESOLVED)
        of_sums = MARGIN * float(found.missed[0].max(initial=0.0))
        return found.value[0], of_sums + max(of_spent)

    def _spent(self, hazard: Array, stretch: Array, since: Array) -> tuple[Array, float]:
        """A of contacts whose quantiles have these hazards (n, k), with moves (n, 2), shape (n, k); and the error of
        e^-A."""
        assert self._thermal is not None
        law, count, (first, last) = self._thermal.rates, hazard.shape[1], stretch.T
        begin, end = since.T
        speed = np.divide(last - first, end - begin, out=np.zeros(end.size), where=end > begin)
        # the rate bends where x = 0
        across = np.where(first * last < 0.0, begin - first / np.where(speed, speed, 1.0), end)
        # grains grow in the logarithm of the time; at the end the rate may vanish as a root
        unit = self.grains.growth.first_pinning_time
        log_times = np.log1p(np.stack([begin, across, end], axis=1) / unit)
        earlier = np.repeat((log_times[:, -1:] - log_times)[:, ::-1], count, axis=0)

        def rate(owner: Rows, before_end: Array) -> Array:
            row = owner // count
            time = unit * np.expm1(log_times[row, -1:] - before_end)
            x = np.abs(first[row, None] + speed[row, None] * (time - begin[row, None]))
            excess = self.grains.growth.excess_after(time)
            limit = self.grains.threshold_at(hazard.ravel()[owner, None], excess)
            rates = law.rate(np.minimum(x, limit), limit, 1.0) * (unit + time)
            return np.stack([rates, rates + 1.0 / span[row, None]])

        # the share e^-A is as good as the error of A relative to 1 + A, the integral of the second function
        span = log_times[:, -1] - log_times[:, 0]
        found = integrals_above(rate, np.zeros(hazard.size), earlier, True, RESOLVED, relative=True)
        spent, missed = found.value[0], found.missed[0] / np.maximum(found.value[1], 1.0)
        return spent.reshape(hazard.shape), MARGIN * float(missed.max(initial=0.0))
