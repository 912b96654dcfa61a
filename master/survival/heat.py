"""Contacts that also break below their thresholds, at a rate h(|x|; x_s) (paper, temper1 to temper10).

ThermalLife is the closure "exact", in which each contact breaks at its own rate; MeanRateLife is the
closure "paper" (Eqs. temper3, temper4), in which all contacts break at one mean rate H(x).
"""

import numpy as np

from master.motion import History
from master.numerics.averages import CHECKED, Integrals, integrals_above
from master.numerics.polynomials import Rows
from master.numerics.table import Table
from master.survival.integrated_rate import IntegratedRate
from master.survival.life import COEFFICIENT_LIMIT, FEW, MARGIN, SMALLEST, TIE, LawLife, Survivors
from origins import Contacts
from origins.thresholds.law import Array
from origins.thresholds.quadrature import finite_density

# ln A from which on the survival e^-A < 1e-29 is negligible, even where few contacts hold; and at which it is cut, as
# e^-A is then 0 in floating point.
_NEGLIGIBLE_FROM, _ZERO_FROM = np.log(67.0), 7.0
# Fraction of the contacts below which those with thresholds on one panel are left out.
_NO_WEIGHT = 1e-18
# Fraction of the contacts that rounding in sums over thresholds loses; and ln A at which, surely, a contact has broken.
_ROUNDED_FRACTION, _SURELY_BROKEN = 3e-14, 3.0
# Finest last coefficients of sums over thresholds: their error is about the square, far below rounding, but larger
# ones would show as roughness in tables.
_FINEST = 2e-12
# Least H, in attempt frequencies, whose relative error matters: one break in 1e35 attempts.
_NEVER = 1e-35
_EPSILON = float(np.finfo(float).eps)
# Place on a panel of the table of H, from 0 to 1, at which it is checked: away from all nodes.
_CHECKED_AT = 0.02
# Relative rounding of a rate per k_BT of its barrier, and that of a sum of a threshold and a stretch.
_ROUNDED_RATE, _ROUNDED_DISTANCE = 16.0 * _EPSILON, 1e-14
# Last coefficients of the integrals for H, in those of its table: errors of integrals are about their square.
_OF_TABLE = 20.0


class ThermalLife(LawLife):
    """The Life of contacts that break by heat, each at its own rate h(x; x_s).

    Born at r, a contact whose largest |x| was m still holds with the probability

        E = integral over x_s > m of P_c(x_s) e^(-A(x_s)) / S(|r|),

    A the integral of h over the time since its birth, the integrated rate; of independent or linked stiffness;
    `coefficient_limit`: see Life.
    """

    pair_work = 6  # measured

    def __init__(self, contacts: Contacts, coefficient_limit: float = COEFFICIENT_LIMIT) -> None:
        super().__init__(contacts)
        self._contacts = contacts
        self.coefficient_limit = coefficient_limit
        self.largest_birth_stretch = self.largest_stretch
        self._weights = -np.diff(self.law.sf(self.panels))  # of the thresholds on each panel
        self.neglected = float(np.minimum(self._weights, _NO_WEIGHT).sum())

    def rounded_away(self, velocity: float) -> Array:
        """Bounds of what the strongest contacts would add to the integrals of E and K over the distance since birth,
        shape (2,): a fraction of 3e-14, which rounding in sums over thresholds loses. Each breaks at its threshold, or
        before A is e^3 = 20."""
        assert self._contacts.thermal is not None
        # thresholds up to lengths beyond which no law has weight
        x = float(self.law.isf(_ROUNDED_FRACTION)) * np.geomspace(1.0, 1e60, 2001)
        stiffness = self._contacts.relative_stiffness(x)
        weight = -np.diff(self.law.sf(x), append=0.0)
        log_integral = np.log(velocity) + _SURELY_BROKEN  # of h over the stretch
        with np.errstate(all="ignore"):
            broken_at = self._contacts.thermal.rates.reached(log_integral, 0.0, x, stiffness)
        broken_at = np.fmin(broken_at, x)  # nan where barriers overflow
        return np.array([weight @ broken_at, weight @ (stiffness * broken_at**2)])

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """See Life."""
        sums = np.zeros((2, born.size))
        error = self.error
        for some, moves in history.by_birth():
            integrated = IntegratedRate(self._contacts, born[some], moves.legs())
            per_survival = 1.0 / self.law.sf(np.abs(born[some]))
            sums[:, some], sums_error = self._sums(integrated, per_survival, side[some])
            error = max(error, sums_error)
        survival, by_stiffness = sums
        force = by_stiffness * (born + history.now)
        return Survivors(np.minimum(survival, 1.0), force, error)

    def _sums(
        self, integrated: IntegratedRate, per_survival: Array, side: Array
    ) -> tuple[Array, float]:
        """Sums over thresholds of P_c e^-A, and of this times k_i/<k> where linked, shape (1 or 2, n); and the error.
        P_c is multiplied by `per_survival`, shape (n,): 1/(the survival of P_c at birth)."""
        every = np.arange(per_survival.size)
        is_linked = self._contacts.stiffness == "linked"

        def survival(contact: Rows, threshold: Array) -> Array:
            log_integrated = np.minimum(integrated.log(contact, threshold), _ZERO_FROM)
            fraction = (per_survival[contact, None] * np.exp(-np.exp(log_integrated)))[None]
            if not is_linked:
                return fraction
            by_stiffness = fraction * self._contacts.relative_stiffness(threshold)
            return np.concatenate([fraction, by_stiffness])

        def survival_by_density(contact: Rows, threshold: Array) -> Array:
            return survival(contact, threshold) * finite_density(self.law, threshold)

        least = np.maximum(integrated.furthest, SMALLEST)
        log_integrated = integrated.log(every, np.maximum(self.panels, least[:, None]))
        counted = self._weights * per_survival[:, None] > _NO_WEIGHT
        # as a function of the threshold A falls as the barrier grows, and may rise before: it has no least value inside
        # a panel, which is left out where A is large at both ends
        counted &= np.minimum(log_integrated[:, 1:], log_integrated[:, :-1]) < _NEGLIGIBLE_FROM
        few = np.maximum(per_survival * self.law.sf(least), FEW)
        # a tenth, as the error of these sums is one of several
        accuracy = max(0.1 * self.coefficient_limit, _FINEST) * few
        sums, missed, _ = integrals_above(
            survival_by_density, least, self.panels, counted, accuracy
        )
        for position, weight in zip(self.atoms, self.atom_weights, strict=True):
            each = survival(every, np.full((every.size, 1), position))[..., 0]
            sums += weight * each * (side < position * (1.0 - TIE))
        return sums, MARGIN * float(missed.max(initial=0.0))


class MeanRateLife(LawLife):
    """The Life of contacts with P_T = P + H/v (paper, Eqs. temper2 and temper4).

    H(x), the integral of h(x; x_s) P_c(x_s) over x_s > |x|, is the rate of all contacts, and

        E = product over all outward moves of S(|x_end|)/S(|x_begin|) exp(-integral of H over time),

    an outward move being one on which |x| grows beyond |r|. As in App. C, a contact that was pulled back and moves
    outward once more may break at thresholds that it has passed before; on one leg the product is S(|x|)/S(|r|).
    Contacts have independent stiffness; `coefficient_limit`: see Life.
    """

    pair_work = 6  # measured

    def __init__(self, contacts: Contacts, coefficient_limit: float = COEFFICIENT_LIMIT) -> None:
        """Tabulate the mean rate H and its integral."""
        super().__init__(contacts)
        assert contacts.thermal is not None
        self.coefficient_limit = coefficient_limit
        self.largest_birth_stretch = self.largest_stretch
        rates = self._rates = contacts.thermal.rates
        self._accuracy = 0.1 * coefficient_limit  # relative last coefficients of H in its table
        self._table = self._tabulated()
        # an error of H counts by its part of L, the integral of H, and one of ln L changes the survival e^-L by at most
        # 1/e of it
        table = self._table
        at = table.begin + _CHECKED_AT * table.widths
        off = np.abs(self.rate(at) - self.mean_rate(at)[0]) + self._above(at, checked=1).missed[0]
        least = _NEVER * rates.scale * self.largest_stretch
        integral = np.maximum(self.rate_integral(table.edges[1:]), least)
        self.error = float((np.cumsum(off * table.widths) / integral).max(initial=0.0)) / np.e

    def _tabulated(self) -> Table:
        """The table of H up to the largest stretch."""
        rates, far = self._rates, self.largest_stretch
        edges = np.unique(np.concatenate([[0.0, far], self.bends, self.panels]))
        # relative rounding of h, divided by the accuracy; halving cannot reduce it
        barrier = float(np.log(rates.scale) - rates.log_rate(0.0, far, 1.0))
        rounding = _ROUNDED_RATE * max(barrier, 1.0) / self._accuracy

        def looser(values: Array, widths: Array) -> Array:
            largest = np.maximum(np.abs(values[0]).max(axis=1), _NEVER * rates.scale)
            # near a bend panels get narrow and add little to L: those below 1e-3 of all widths are asked for less
            return np.asarray(largest / np.minimum(1.0, widths / (1e-3 * far)))

        return Table(
            self.mean_rate,
            edges[edges <= far],
            self._accuracy,
            1e-13 * far,  # narrower panels are rounding
            size=14,  # coefficients on a panel
            looser=looser,
            rounding=rounding,
        )

    def rate(self, x: Array) -> Array:
        """H at x >= 0, from the table; same shape."""
        return np.asarray(self._table(x)[0])

    def rate_integral(self, x: Array) -> Array:
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

        def rate_by_density(row: Rows, threshold: Array) -> Array:
            rate = self._rates.rate(x[row, None], threshold, 1.0)
            return (rate * finite_density(self.law, threshold))[None]

        # right below an edge the distance of thresholds from x suffers from rounding
        away = np.append(self.panels, np.inf)[np.searchsorted(self.panels, x, "right")] - x
        rounded = _ROUNDED_DISTANCE * x
        accuracy = np.maximum(_OF_TABLE * self._accuracy, rounded / np.maximum(away, rounded))
        least = np.maximum(x, SMALLEST)
        return integrals_above(rate_by_density, least, self.panels, True, accuracy, True, checked)

    def cold_survival(self, begin: Array, end: Array, first: Array, side: Array) -> Array:
        """Fraction that meets no threshold on a straight move; |r| = first at birth; arrays that broadcast."""
        # an outward move through 0 begins at |r|; one towards 0 has the factor 1
        least = np.where(begin * end < 0.0, first, np.maximum(np.abs(begin), first))
        largest = np.maximum(np.abs(end), least)
        before = self.threshold_survival(least, side)
        after = self.threshold_survival(largest, side)
        return np.divide(after, before, out=np.zeros_like(before), where=before > 0.0)

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """See Life."""
        survival = np.zeros(born.size)
        error = self.error
        for some, moves in history.by_birth():
            displacement, duration, speed = moves.legs()
            x = born[some, None] + displacement
            rests = speed == 0.0
            per_speed = 1.0 / np.where(rests, np.inf, np.abs(speed))
            integral = self.rate_integral(x)
            over_time = np.abs(np.diff(integral)) * per_speed
            over_time[:, rests] = duration[:, rests] * self.rate(np.abs(x[:, 1:][:, rests]))
            # may exceed the difference
            rounding = _EPSILON * np.abs(integral[:, 1:]) * per_speed * (duration > 0.0)
            cold = self.cold_survival(
                x[:, :-1], x[:, 1:], np.abs(born[some, None]), side[some, None]
            )
            survival[some] = np.minimum(cold.prod(axis=1), 1.0) * np.exp(-over_time.sum(axis=1))
            rounded = survival[some] * rounding.sum(axis=1)
            error = max(error, float(rounded.max(initial=0.0)))
        return Survivors(survival, survival * (born + history.now), error)
