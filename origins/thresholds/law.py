"""Thresholds: the law P_c(x) of the stretch at which a contact breaks. The class says what a new law must define."""

from functools import cached_property
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, refuse, whole
from origins.thresholds.numerical import Array, Function, NumericalLaw

RandomState: TypeAlias = "int | np.random.Generator | None"


@runtime_checkable
class ThresholdLaw(Protocol):
    """All that solvers use of the law P_c(x) of the thresholds x_s >= 0 (lengths) at which contacts break.

    A law may have a density, exact single values (`atoms`), or both. The methods take numbers or arrays of any shape
    and return that shape; outside the support they give the limits 0, 1 and -inf. origins.Thresholds, which all
    origins of thresholds return, explains each of them and conforms to this protocol.

    Required accuracy, a relative 1e-10 of the exact value: pdf where it does not underflow, sf (also where it is
    small, so never as 1 - cdf), logsf (finite where sf underflows, accurate also where sf is near 1), mean, and sf at
    isf(q), or isf itself to 1e-12; logpdf to 1e-10 of max(1, |logpdf|). isf raises InputError for q outside [0, 1].
    """

    def pdf(self, x: npt.ArrayLike) -> Array: ...
    def logpdf(self, x: npt.ArrayLike) -> Array: ...
    def sf(self, x: npt.ArrayLike) -> Array: ...
    def logsf(self, x: npt.ArrayLike) -> Array: ...
    def isf(self, q: npt.ArrayLike) -> Array: ...
    def mean(self) -> float: ...
    def support(self) -> tuple[float, float]: ...
    @property
    def atoms(self) -> tuple[Array, Array]: ...
    @property
    def breakpoints(self) -> Array: ...
    @property
    def onset_power(self) -> float: ...


class Thresholds:
    """Distribution of breaking thresholds x_s >= 0 (a length), with the names and meanings of a frozen scipy.stats one.

    A family defines, for arrays x inside its support:

    - required: one of `_log_weight(x)`, the log of the density up to a constant, or of `_logpdf(x)` and `_pdf(x)`, both
      normalised. Densities are also evaluated at finite ends of the support. They must be accurate to a relative
      1e-10, logarithms to 1e-10 max(1, |log|), also where the density underflows.
    - required where they differ from the defaults here: `support()` (or `_support`), `breakpoints` inside the support,
      `onset_power`, `atoms`.
    - optional, where a closed form is shorter or faster than the NumericalLaw of the density, which gives the rest:
      `_cdf` together with `_sf` (each to a relative 1e-10 where it is small, never as 1 less the other; also asked at
      the support's lower end), `_logsf` (finite where the survival underflows), `_quantiles(below, above)` (1e-12 in
      x, or 1e-10 in the probability) and `_moment(n, centre)` (1e-10). A family with atoms defines `_cdf` and `_sf`,
      one whose tail is a power of x these and `_logsf`: there the NumericalLaw ends before the survival underflows.

    Raises InputError, with the family's name, where its survival leaves [0, 1].

    onset_power : m in P_c(x) ~ (x - a)^m at the lower end a of the support; inf where P_c rises slower than any power,
        or where nothing continuous begins there.
    onset_power_error : its error: 0 where the family defines it, else that of the fit.
    interface : Interface, load, contact density, stiffness and friction in SI units, where the law is a surface's.
    in_metres : whether its lengths are metres without that, as of samples whose unit is given.
    domains : DomainSamples, barriers, angles and sizes of the islands, where the law is that of rotated domains.
    cut_weight : weight of a given distribution at or below x = 0 that was cut off; the rest is normalised.
    asked_itself : whether solvers ask for the survival at each point; else they make a table of it, of some thousand
        points, as one takes longer than a look-up, some 0.1 µs.
    """

    onset_power: float = np.inf
    onset_power_error: float = 0.0
    interface: Any = None
    in_metres: bool = False
    domains: Any = None
    cut_weight: float = 0.0
    asked_itself: bool = True
    _support: tuple[float, float] = (0.0, np.inf)

    def __repr__(self) -> str:
        """The family, its mean, width and ends, such as Gaussian(mean=1, std=0.1, support=(0, inf))."""
        try:
            lower, upper = self.support()
            numbers = (
                f"mean={self.mean():.6g}, std={self.std():.6g}, support=({lower:.6g}, {upper:.6g})"
            )
        except (
            ValueError
        ):  # of a law whose numbers are out of reach; a refusal is a ValueError, too
            numbers = "..."
        return f"{type(self).__name__}({numbers})"

    def support(self) -> tuple[float, float]:
        """Ends (lower, upper) of the support; upper may be inf."""
        return self._support

    @cached_property
    def breakpoints(self) -> Array:
        """Sorted finite points where P_c or one of its derivatives is not smooth, the support's ends included."""
        return np.array([end for end in self.support() if np.isfinite(end)])

    @cached_property
    def atoms(self) -> tuple[Array, Array]:
        """(positions, weights) of the exact single values in the law; empty where it is continuous."""
        return np.empty(0), np.empty(0)

    @cached_property
    def _numerical(self) -> NumericalLaw:
        """The law computed from the density; InputError where a density that must be normalised is not."""
        ends = self.support()
        numerical = NumericalLaw(self._log_weight, *ends, self.breakpoints, self.onset_power)
        normalised = type(self)._log_weight is Thresholds._log_weight
        if normalised and not abs(numerical.log_whole) < 1e-6:  # more than rounding explains
            adds_up = f"its density adds up to {np.exp(numerical.log_whole):.6g}, not to 1"
            hint = "state it as _log_weight, which need not be normalised"
            raise InputError(f"{type(self).__name__}: {adds_up}; {hint}")
        return numerical

    def _log_weight(self, x: Array) -> Array:
        return self._logpdf(x)

    def _logpdf(self, x: Array) -> Array:
        if type(self)._pdf is Thresholds._pdf:
            return self._numerical.logpdf(x)
        density = self._pdf(x)
        with np.errstate(divide="ignore"):  # the last digits before underflow are no smooth density
            return np.log(np.where(density > 1e-300, density, 0.0))

    def _pdf(self, x: Array) -> Array:
        with np.errstate(over="ignore"):  # where the density diverges
            return np.exp(self._logpdf(x))

    def _cdf(self, x: Array) -> Array:
        return self._numerical.cdf(x)

    def _sf(self, x: Array) -> Array:
        return self._numerical.sf(x)

    def _logsf(self, x: Array) -> Array:
        if type(self)._sf is Thresholds._sf:
            return self._numerical.logsf(x)
        with np.errstate(divide="ignore"):
            return np.log(self._sf(x))

    def _quantiles(self, below: Array, above: Array) -> Array:
        """The least floats of the support with these weights below and above them, the smaller of which is exact.

        They are left ends of gaps and places of atoms, too. The bits of floats above zero, read as whole numbers,
        count them in order: 64 halvings find one among all. For few, 15 places at once take hardly longer than one.
        """
        if type(self)._cdf is Thresholds._cdf:
            return self._numerical.quantiles(below, above)
        lower, upper = self.support()
        low = np.full(below.size, lower).view(np.int64) - 1
        high = np.full(below.size, upper).view(np.int64)
        from_below, column = below < above, np.arange(below.size)
        steps = np.arange(17 if below.size < 32 else 3)[:, None]
        while (high - low > 1).any():
            places = low + np.maximum((high - low) // steps[-1], 1) * steps
            places = np.append(np.minimum(places[:-1], high), high[None], axis=0)
            x = places[1:-1].view(np.float64)
            beyond = np.empty(x.shape, dtype=bool)
            beyond[:, from_below] = self.cdf(x[:, from_below]) >= below[from_below]
            beyond[:, ~from_below] = self.sf(x[:, ~from_below]) <= above[~from_below]
            first = (~beyond).sum(axis=0)
            low, high = places[first, column], places[first + 1, column]
        return high.view(np.float64)

    def _moment(self, n: float, centre: float = 0.0) -> float:
        return self._numerical.moment(n, centre)

    def pdf(self, x: npt.ArrayLike) -> Array:
        """Density P_c(x), per length; atoms left out, the limit from inside at the support's ends. Shape as x."""
        return self._inside(self._pdf, x, 0.0)

    def logpdf(self, x: npt.ArrayLike) -> Array:
        """log P_c(x), finite where P_c underflows."""
        return self._inside(self._logpdf, x, -np.inf)

    def cdf(self, x: npt.ArrayLike) -> Array:
        """Probability that a threshold is at most x."""
        return self._inside(self._cdf, x, 0.0, 1.0)

    def sf(self, x: npt.ArrayLike) -> Array:
        """Survival: probability that a threshold exceeds x."""
        survival = self._inside(self._sf, x, 1.0, 0.0)
        bad = np.abs(survival - 0.5) > 0.5 + 1e-9  # by more than rounding
        if bad.any():
            at, value = np.asarray(x)[bad].flat[0], survival[bad].flat[0]
            fault = f"its survival at x = {at:.6g} is {value:.6g}, outside 0 to 1; mend its _sf"
            raise InputError(f"{type(self).__name__}: {fault}")
        return survival

    def logsf(self, x: npt.ArrayLike) -> Array:
        """log of the survival, finite where it underflows."""

        return self._inside(self._log_survival, x, 0.0, -np.inf)

    def _log_survival(self, x: Array) -> Array:
        """As `logsf` inside the support, with as many digits near 0, of a survival near 1, as elsewhere."""
        own, without = type(self), Thresholds
        if (own._cdf, own._sf, own._logsf) == (without._cdf, without._sf, without._logsf):
            return self._numerical.logsf(x)
        log_survival = self._logsf(x)
        near_one = log_survival > -0.5  # the cdf has more digits there
        log_survival[near_one] = np.log1p(-self._cdf(x[near_one]))
        return log_survival

    def ppf(self, q: npt.ArrayLike) -> Array:
        """Threshold below which a fraction q lies. InputError for q outside [0, 1]."""
        return self._probable(q, from_below=True)

    def isf(self, q: npt.ArrayLike) -> Array:
        """Threshold above which a fraction q lies, accurate for tiny q. InputError for q outside [0, 1]."""
        return self._probable(q, from_below=False)

    def moment(self, n: int) -> float:
        """<x_s^n>, n = 0, 1, 2, ..., a length to the power n; inf where it does not exist."""
        n = whole("n", n, 0)
        return 1.0 if n == 0 else float(self._moment(n))

    def mean(self) -> float:
        """<x_s>, a length."""
        return self.moment(1)

    def std(self) -> float:
        """Standard deviation of x_s, a length."""
        return float(np.sqrt(self._moment(2, self.mean())))

    def rvs(
        self, size: int | tuple[int, ...] | None = None, random_state: RandomState = None
    ) -> Array:
        """Independent thresholds; random_state is None, a seed or a numpy Generator."""
        return self.isf(1.0 - np.random.default_rng(random_state).random(size))

    def _inside(
        self, inner: Function, x: npt.ArrayLike, below: float, above: float | None = None
    ) -> Array:
        """inner(x) inside the support, else limits; densities, of one limit only, at its upper end, too."""
        x = np.asarray(x, dtype=float)
        lower, upper = self.support()
        within = (x >= lower) & (x < upper)
        if above is None:
            within |= (x == upper) & np.isfinite(x)
        if x.ndim and x.size and within.all():
            return inner(x)
        # a NaN compares false everywhere and stays NaN
        out = np.where(x >= upper, below if above is None else above, np.where(x < lower, below, x))
        if within.any():
            out[within] = inner(x[within])
        return out[()]

    def _probable(self, q: npt.ArrayLike, from_below: bool) -> Array:
        """Thresholds with a weight q on one side, and the support's ends at q = 0 and 1."""
        q = np.asarray(q, dtype=float)
        if not (good := (q >= 0.0) & (q <= 1.0)).all():
            refuse("q", q[~good].flat[0], "must be a probability between 0 and 1")
        out = np.where((q == 0.0) == from_below, *self.support())
        within = (q > 0.0) & (q < 1.0)
        if within.any():
            sides = q[within], 1.0 - q[within]
            out[within] = self._quantiles(*(sides if from_below else sides[::-1]))
        return out[()]
