"""Contacts that also break below their thresholds, at a rate h(|x|; x_s) (paper, temper1 to temper10).

ThermalLife is the closure "exact", in which each contact breaks at its own rate; MeanRateLife is the
closure "paper" (Eqs. temper3, temper4), in which all contacts break at one mean rate H(x).
"""

import numpy as np

from master.motion import History, Legs
from master.numerics.averages import CHECKED, Integrals, integrals_above
from master.numerics.polynomials import Rows
from master.numerics.table import Table
from master.survival.life import MARGIN, SMALLEST, TIE, LawLife, Survivors
from origins import Contacts
from origins.laws.rate_law import LARGEST_EXPONENT
from origins.thresholds.law import Array
from origins.thresholds.quadrature import finite_density

# Last two Legendre coefficients below which pieces of the stretches at birth, and panels of H, are not halved.
RESOLVED = 1e-9
# Above ln A = _GONE a share e^-A < 1e-29 is negligible, even where few contacts hold, and above _DEAD it is
# 0 in floating point. Panels with a share of contacts below _NO_WEIGHT are left out.
_GONE, _DEAD, _NO_WEIGHT = np.log(67.0), 7.0, 1e-18
# Least H, in attempt frequencies, whose relative error matters: one break in 1e35 attempts.
_NEVER = 1e-35
_EPSILON = float(np.finfo(float).eps)


class ThermalLife(LawLife):
    """The Life of contacts that break by heat, each at its own rate h(x; x_s).

    Born at r, a contact whose largest |x| was m still holds with the probability

        E = integral over x_s > m of P_c(x_s) e^(-A(x_s)) / S(|r|),

    A the integral of h over the time since its birth; of independent or linked stiffness; `resolved`: see Life.
    """

    pair_work = 6

    def __init__(self, contacts: Contacts, resolved: float = RESOLVED) -> None:
        super().__init__(contacts)
        self.resolved, self.largest_birth_stretch, self._contacts = (
            resolved,
            self.largest_stretch,
            contacts,
        )
        self._mass = -np.diff(self.law.sf(self.panels))
        self.left_out = float(np.minimum(self._mass, _NO_WEIGHT).sum())

    def rounded_away(self, velocity: float) -> Array:
        """Bounds of what the strongest contacts would add to the integrals of E and K over the way, shape (2,): a share
        of 3e-14, which rounding in sums over thresholds loses. Each breaks at its threshold, or before A is 20."""
        assert self._contacts.thermal is not None
        x = float(self.law.isf(3e-14)) * np.geomspace(1.0, 1e60, 2001)
        stiff, lost = self._contacts.relative_stiffness(x), -np.diff(self.law.sf(x), append=0.0)
        with np.errstate(all="ignore"):
            at = self._contacts.thermal.rates.reached(np.log(velocity) + 3.0, 0.0, x, stiff)
        at = np.fmin(at, x)  # nan where barriers overflow
        return np.array([lost @ at, lost @ (stiff * at**2)])

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """See Life."""
        out, error = np.zeros((2, born.size)), self.error
        for some, moves in history.by_birth():
            replay = Replay(self._contacts, born[some], moves.legs())
            weight = 1.0 / self.law.sf(np.abs(born[some]))
            out[:, some], of_sums = self._held(replay, weight, side[some])
            error = max(error, of_sums)
        return Survivors(np.minimum(out[0], 1.0), out[1] * (born + history.now), error)

    def _held(self, replay: "Replay", weight: Array, side: Array) -> tuple[Array, float]:
        """Sums over thresholds of P_c e^-A, and of this times k_i/<k> where linked, shape (1 or 2, n); and the error.
        The weight, shape (n,), is the factor on P_c: 1/(the survival at birth)."""
        every, linked = np.arange(weight.size), self._contacts.stiffness == "linked"

        def held(contact: Rows, threshold: Array) -> Array:
            level = np.minimum(replay.log_spent(contact, threshold), _DEAD)
            share = (weight[contact, None] * np.exp(-np.exp(level)))[None]
            stiff = share * self._contacts.relative_stiffness(threshold) if linked else share[:0]
            return np.concatenate([share, stiff])

        def held_by_density(contact: Rows, threshold: Array) -> Array:
            return held(contact, threshold) * finite_density(self.law, threshold)

        least = np.maximum(replay.furthest, SMALLEST)
        level = replay.log_spent(every, np.maximum(self.panels, least[:, None]))
        felt = self._mass * weight[:, None] > _NO_WEIGHT
        # as a function of the threshold A rises, then falls, so that on a panel it is least at an end
        felt &= np.minimum(level[:, 1:], level[:, :-1]) < _GONE
        # where few contacts hold, each is stretched far, so that their error counts the more
        few = np.maximum(weight * self.law.sf(least), 1e-4)
        # the error of a sum is about the square of this; a larger one would show as roughness in tables
        accuracy = max(0.1 * self.resolved, 2e-12) * few
        out, missed, _ = integrals_above(held_by_density, least, self.panels, felt, accuracy)
        for position, share in zip(self.atoms, self.atom_weights, strict=True):
            each = held(every, np.full((every.size, 1), position))[..., 0]
            out += share * each * (side < position * (1.0 - TIE))
        return out, MARGIN * float(missed.max(initial=0.0))


class Replay:
    """The rate of n contacts, born at stretches of shape (n,), integrated over time: leg by leg, the mean rate times
    the duration. furthest : the largest |x| of each, shape (n,), below its threshold."""

    def __init__(self, contacts: Contacts, born: Array, legs: Legs) -> None:
        assert contacts.thermal is not None
        self._rates, self._stiffness = contacts.thermal.rates, contacts.relative_stiffness
        self._stretch, self._duration = born[:, None] + legs.displacement, legs.duration
        self.furthest: Array = np.abs(self._stretch).max(axis=1)
        self._offset: Array | None = None
        if self._rates.separable and contacts.stiffness != "linked":
            # h = f(x) g(x_s): A at one x_s gives all others; on all legs but the last those born together share it
            births = np.stack([born, self._duration[:, :-1].sum(axis=1)])
            first = np.any(np.diff(births, prepend=np.nan) != 0.0, axis=0)
            last = np.append(np.zeros(legs.speed.size - 1), 1.0)
            shared = self._log_spent_at_0(np.flatnonzero(first), 1.0 - last)[np.cumsum(first) - 1]
            self._offset = np.logaddexp(shared, self._log_spent_at_0(np.arange(born.size), last))

    def _log_spent_at_0(self, row: Rows, on: Array) -> Array:
        """ln[A/h(0; x_s)], the same at all x_s, of contacts on the legs where `on` is 1; shape (n, 1)."""
        ends = np.abs(self._stretch[row]) * np.maximum(np.append(on, 0.0), np.append(0.0, on))
        furthest = ends.max(axis=1, keepdims=True, initial=SMALLEST)
        return self.log_spent(row, furthest, on) - self._rates.log_rate(0.0, furthest, 1.0)

    def log_spent(self, row: Rows, threshold: Array, on: Array | float = 1.0) -> Array:
        """ln A of the contacts `row`, shape (n,), on all legs or those where `on` is 1, at thresholds of shape
        (n, k), which |x| has exceeded there at most by rounding; finite."""
        least = -740.0  # where A = 0 or underflows
        if self._offset is not None:
            return np.maximum(self._rates.log_rate(0.0, threshold, 1.0) + self._offset[row], least)
        spent, (contact, leg) = np.zeros(threshold.shape), np.nonzero(self._duration[row] * on)
        # moves whose rates stay in the processor's cache
        together = max(4096 // max(threshold.shape[1], 1), 1)
        for begin in range(0, contact.size, together):
            which, some = leg[begin : begin + together, None], contact[begin : begin + together]
            own = row[some, None]
            near, far = self._stretch[own, which], self._stretch[own, which + 1]
            passed = self._mean_rate(near, far, threshold[some]) * self._duration[own, which]
            first = np.flatnonzero(np.diff(some, prepend=-1))
            spent[some[first]] += np.add.reduceat(passed, first, axis=0)
        return np.log(np.maximum(spent, np.exp(least)))

    def _mean_rate(self, near: Array, far: Array, threshold: Array) -> Array:
        """Mean of h over straight moves, at thresholds of shape (n, k); ends of shape (n, 1)."""
        stiffness, across = self._stiffness(threshold), near * far < 0.0
        first, last = (np.minimum(np.abs(end), threshold) for end in (near, far))
        low, high = np.minimum(first, last), np.maximum(first, last)
        begin = np.where(across, 0.0, low)
        passed, way = self._passed(begin, high, threshold, stiffness), high - begin
        if across.any():  # |x| falls to 0 and rises again
            some = np.flatnonzero(across)
            back, way[some] = low[some], high[some] + low[some]
            passed[some] += self._passed(0.0 * back, back, threshold[some], stiffness[some])
        # rounding of the way's ends hardly matters for this mean, unlike for the integral
        mean = passed if way.all() else self._rates.rate(high, threshold, stiffness)
        return np.divide(passed, way, out=mean, where=way > 0.0)

    def _passed(self, low: Array, high: Array, threshold: Array, stiffness: Array) -> Array:
        """Integral of h over stretches from low to high; all of one shape."""
        log_passed = self._rates.log_passed(low, high, threshold, stiffness)
        return np.exp(np.minimum(log_passed, LARGEST_EXPONENT))


class MeanRateLife(LawLife):
    """The Life of contacts with P_T = P + H/v (paper, Eqs. temper2 and temper4).

    H(x), the integral of h(x; x_s) P_c(x_s) over x_s > |x|, is the rate of all contacts, and

        E = product over all ways out of S(|x_end|)/S(|x_begin|) exp(-integral of H over time),

    a way out being one on which |x| grows beyond |r|. As in App. C, a contact that was pulled back and goes out
    again may break at thresholds that it has passed before; on one leg the product is S(|x|)/S(|r|).
    Contacts have independent stiffness; `resolved`: see Life.
    """

    pair_work = 6

    def __init__(self, contacts: Contacts, resolved: float = RESOLVED) -> None:
        """Tabulate the mean rate H and its integral."""
        super().__init__(contacts)
        assert contacts.thermal is not None
        self.resolved, self.largest_birth_stretch = resolved, self.largest_stretch
        rates = self._rates = contacts.thermal.rates
        edges = np.unique(np.concatenate([[0.0, self.largest_stretch], self.bends, self.panels]))
        scale, far = rates.scale, self.largest_stretch
        barrier = float(np.log(scale) - rates.log_rate(0.0, far, 1.0))
        self._accuracy = 0.1 * resolved  # relative last coefficients of H in its table
        # relative rounding of h per k_BT of the barrier, divided by the accuracy; halving cannot reduce it
        rounding = 16.0 * _EPSILON * max(barrier, 1.0) / self._accuracy

        def looser(values: Array, widths: Array) -> Array:
            most = np.maximum(np.abs(values[0]).max(axis=1), _NEVER * scale)
            # near a bend panels get narrow and add little to L
            return np.asarray(most / np.minimum(1.0, widths / (1e-3 * far)))

        found = self.mean_rate, edges[edges <= far], self._accuracy, 1e-13 * far
        table = self._table = Table(*found, size=14, looser=looser, rounding=rounding)
        # the table is checked away from its nodes; an error of H counts by its part of L, the integral
        # of H, and one of ln L changes the survival e^-L by at most 1/e of it
        at = table.begin + 0.02 * table.widths
        wrong = np.abs(self.rate(at) - self.mean_rate(at)[0]) + self._above(at, checked=1).missed[0]
        grown = np.maximum(self.grown(table.edges[1:]), _NEVER * scale * far)
        self.error = float((np.cumsum(wrong * table.widths) / grown).max(initial=0.0)) / np.e

    def rate(self, x: Array) -> Array:
        """H at x >= 0, from the table; same shape."""
        return np.asarray(self._table(x)[0])

    def grown(self, x: Array) -> Array:
        """L, the integral of H from 0 to x, of either sign; same shape."""
        return np.sign(x) * self._table.up_to(np.abs(x))

    def mean_rate(self, x: Array) -> Array:
        """H at stretches x >= 0, shape (1, *x.shape), by its definition (paper, Eq. temper3)."""
        out = self._above(x.ravel()).value.reshape(x.shape)
        for position, weight in zip(self.atoms, self.atom_weights, strict=True):
            below = x < position
            out[below] += weight * self._rates.rate(x[below], position, 1.0)
        return out[None]

    def _above(self, x: Array, checked: int = CHECKED) -> Integrals:
        """h averaged over the thresholds above x, without exact ones; shape (1, n)."""

        def breaking(row: Rows, xi: Array) -> Array:
            return (self._rates.rate(x[row, None], xi, 1.0) * finite_density(self.law, xi))[None]

        # right below an edge the distance of thresholds from x suffers from rounding, by 1e-14 of x
        away = np.append(self.panels, np.inf)[np.searchsorted(self.panels, x, "right")] - x
        relative = np.maximum(20.0 * self._accuracy, 1e-14 * x / np.maximum(away, 1e-14 * x))
        given = breaking, np.maximum(x, SMALLEST), self.panels, True
        return integrals_above(*given, relative, True, checked)

    def unmet(self, begin: Array, end: Array, first: Array, side: Array) -> Array:
        """Share that meets no threshold on a straight move; |r| = first at birth; arrays that broadcast."""
        # a way out through 0 begins at |r|; a way towards 0 has the factor 1
        least = np.where(begin * end < 0.0, first, np.maximum(np.abs(begin), first))
        held, whole = (
            self.threshold_survival(m, side) for m in (np.maximum(np.abs(end), least), least)
        )
        return np.divide(held, whole, out=np.zeros_like(whole), where=whole > 0.0)

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """See Life."""
        share, error = np.zeros(born.size), self.error
        for some, moves in history.by_birth():
            displacement, duration, speeds = moves.legs()
            x, rests = born[some, None] + displacement, speeds == 0.0
            grown, speeds = self.grown(x), np.where(rests, np.inf, np.abs(speeds))
            spent = np.abs(np.diff(grown)) / speeds
            spent[:, rests] = duration[:, rests] * self.rate(np.abs(x[:, 1:][:, rests]))
            # may exceed the difference
            rounded = (_EPSILON * np.abs(grown[:, 1:]) / speeds * (duration > 0.0)).sum(axis=1)
            unmet = self.unmet(x[:, :-1], x[:, 1:], np.abs(born[some, None]), side[some, None])
            share[some] = np.minimum(unmet.prod(axis=1), 1.0) * np.exp(-spent.sum(axis=1))
            error = max(error, float((share[some] * rounded).max(initial=0.0)))
        return Survivors(share, share * (born + history.now), error)
