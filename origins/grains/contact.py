"""A contact whose threshold grows while it slides: each keeps its quantile of the coalescing grains' law."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from origins.errors import non_negative, positive, refuse
from origins.grains.growth import GrainGrowth
from origins.grains.lifshitz_slyozov import hazard_beyond, invert_beyond
from origins.thresholds.inversion import invert_hazard
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import gauss

_FASTEST = 1e50  # in units of 1/(B^(1/2) tau_m)
_STEPS = 100
_LEAST = 1e-300


class GrainContact:
    """Contacts that keep their quantile u for life: the threshold is Q(u; age), Q the quantile of P_c at that age.

    Exact Jacobian. A contact pins from the age tau_m on, at stretch 0. Where it rests there for a time `rest` and then
    slides at `velocity`, its age at stretch x is tau_m + rest + x/velocity; it breaks where it first meets its
    threshold.

    origins.Contacts takes it in the place of thresholds. A contact that breaks is then out for tau_m, until its new
    grains pin; one whose threshold grows more slowly than it is stretched never holds, and is out once more.

    Parameters
    ----------
    growth : GrainGrowth
    age : float, optional
        Time since coalescence began of all contacts at X = 0, above tau_m; what origins.Contacts needs to know.

    Raises InputError for anything but a GrainGrowth, and for an age at which no grain pins.
    """

    interface = None  # no rough surface behind them

    def __init__(self, growth: GrainGrowth, age: float | None = None) -> None:
        if not isinstance(growth, GrainGrowth):
            refuse("growth", growth, "must be growth, such as origins.GrainGrowth(alpha=1.0, B=1.0)")
        self.growth = growth
        self.age = None if age is None else positive("age", age)
        if self.age is not None and self.age <= growth.first_pinning_time:
            refuse("age", age, f"no grain pins before the age (2/(3 alpha))³ = {growth.first_pinning_time:.12g}")

    @property
    def at_start(self) -> Thresholds:
        """P_c at X = 0. InputError where the age there is not given."""
        if self.age is None:
            refuse("age", None, "is missing; give the contacts' age at X = 0, above growth.first_pinning_time")
        return self.growth.thresholds(self.age)

    def hazard(self, x: npt.ArrayLike, age: npt.ArrayLike) -> Array:
        """-ln of the fraction of contacts of `age` whose thresholds exceed x >= 0 (a length); shapes broadcast.

        As each contact keeps its quantile, exp(-(the most this ever was)) of those that pinned together still hold.
        Up to tau_m it is infinite but for x = 0.
        """
        stretch, since = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(age, dtype=float))
        first = self.growth.first_pinning_time
        excess = np.expm1(np.log1p(np.maximum(since - first, 0.0) / first) / 3.0)
        s = np.sqrt(self.growth.B) * stretch
        over = s * (s / (1.0 + np.hypot(1.0, s)))  # of the grain that breaks over the film
        left = excess - over
        out = np.where(over > 0.0, np.inf, 0.0)
        held = (left > 0.0) & (over > 0.0)
        largest = 1.0 + excess[held]
        q = over[held] / excess[held] * (largest / left[held])
        out[held] = hazard_beyond(q, 1.0 / largest, excess[held] / largest)
        return out[()]

    def lost_hazard(self, velocity: float) -> float:
        """(9/2) B (velocity tau_m)²: exp(-this) is the fraction of contacts that hold at all where sliding begins as
        they pin."""
        with np.errstate(over="ignore"):
            return float(4.5 * self.growth.B * np.float64(velocity * self.growth.first_pinning_time) ** 2)

    def quantile(self, u: npt.ArrayLike, age: npt.ArrayLike) -> Array:
        """Threshold (a length) of the contact of quantile u in [0, 1] at `age`; shapes broadcast.

        It rises with age, from 0 at tau_m. InputError for ages below tau_m, at which no grain pins.
        """
        first = self.growth.first_pinning_time
        ranks, ages = np.broadcast_arrays(_ranks(u), np.asarray(age, dtype=float))
        bad = ~((ages >= first) & np.isfinite(ages))
        if bad.any():
            rule = f"no grain pins before the age (2/(3 alpha))³ = {first:.12g}"
            refuse("age", ages[bad].flat[0], rule)
        excess = np.expm1(np.log1p((ages - first) / first) / 3.0)
        largest = 1.0 + excess
        with np.errstate(divide="ignore"):
            hazard = -np.log1p(-ranks)
        finite = np.minimum(hazard, 1e300)
        q = invert_beyond(finite, 1.0 / largest, excess / largest)
        with np.errstate(over="ignore", invalid="ignore"):  # where the hazard is infinite
            gap = np.where(np.isfinite(hazard), excess * (q * excess / (largest + q * excess)), excess)
        return (np.sqrt(gap * (gap + 2.0) / self.growth.B))[()]

    def breaking(self, velocity: float, rest: float = 0.0) -> SlidingGrains:
        """Law of the stretch at which contacts break that hold at all; see SlidingGrains.

        velocity > 0 is a length per time, rest >= 0 a time; else InputError, as where no contact holds.
        """
        law = self._sliding(velocity, rest)
        if law.held_fraction < _LEAST:
            fraction = f"exp(-{law.lost_hazard:.4g})"
            refuse(
                "velocity",
                velocity,
                f"none holds but a fraction {fraction}: they are stretched before their grains have grown; slide more "
                "slowly, and of many speeds leave such ones out",
            )
        return law

    def survival(self, x: npt.ArrayLike, velocity: float, rest: float = 0.0) -> Array:
        """E(x): probability that a contact holds beyond stretch x (a length), those that never hold included."""
        law = self._sliding(velocity, rest)
        return np.where(np.asarray(x) < 0.0, 1.0, law.held_fraction * law.sf(x))[()]

    def _sliding(self, velocity: float, rest: float) -> SlidingGrains:
        return SlidingGrains(self.growth, positive("velocity", velocity), non_negative("rest", rest))


class SlidingGrains(Thresholds):
    """Stretches at which sliding contacts break, where the threshold of each grows with its age.

    The hazard at the meeting, psi(y) - psi(y0) with y0 falling as age^(-1/3), rises with the stretch whatever velocity
    and rest are: every quantile meets its threshold once, and E(x) is the survival of P_c at the age of stretch x.

    Without rest thresholds grow as x from 0 on, and those whose growth is slower than the sliding never hold. This is
    the law of the others.

    Attributes
    ----------
    lost_hazard : float
        (9/2) B (velocity tau_m)² without rest, 0 with.
    held_fraction : float
        exp(-lost_hazard), the fraction of contacts that hold at all.
    """

    def __init__(self, growth: GrainGrowth, velocity: float, rest: float) -> None:
        first = growth.first_pinning_time
        self._reach = velocity * first  # the length slid in tau_m
        self._rest = rest / first
        self._root_b = float(np.sqrt(growth.B))
        if not 1.0 / _FASTEST < self._root_b * self._reach < _FASTEST:
            share = f"{self._root_b * self._reach:.3g} of that at which thresholds grow"
            refuse("velocity", velocity, f"is {share}; take between {1.0 / _FASTEST:g} and {_FASTEST:g} of it")
        self._beta = (self._root_b * self._reach) ** 2
        self.lost_hazard = GrainContact(growth).lost_hazard(velocity) if rest == 0.0 else 0.0
        self.held_fraction = float(np.exp(-self.lost_hazard))
        self.onset_power = 0.0 if rest == 0.0 else 1.0
        exact = np.longdouble(velocity) * np.longdouble(first)
        furthest = _end(np.longdouble(growth.B) * exact * exact, np.longdouble(rest) / np.longdouble(first))
        end = exact * furthest
        self._upper = float(end)
        # beside the end a distance is a difference: what the float lacks is kept
        self._upper_rest = float(end - np.longdouble(self._upper))
        self._upper_size = float(np.cbrt(1.0 + self._rest + furthest))

    def support(self) -> tuple[float, float]:
        return 0.0, self._upper

    def _sizes(self, x: Array) -> tuple[Array, Array, Array, Array]:
        """n0 = m0 - 1, k, m0 - k and q, of the largest grain m0 and the one k that breaks; m0 = k beyond the end."""
        n0 = np.expm1(np.log1p(self._rest + x / self._reach) / 3.0)
        s = self._root_b * x
        k = np.hypot(1.0, s)
        # from the end m0² - k² is a product, near 0 a difference of small numbers
        far, other = self._upper_size, 1.0 + n0
        fall = self._root_b * (self._upper + x) * self._root_b
        fall = fall - (far + other) / ((far * far + far * other + other * other) * self._reach)
        product = ((self._upper - x) + self._upper_rest) * fall / (other + k)
        left = np.maximum(np.where(x > 0.5 * self._upper, product, n0 - s * (s / (1.0 + k))), 0.0)
        with np.errstate(divide="ignore"):
            q = (s / n0) * (s / (1.0 + k)) * ((1.0 + n0) / left)
        return n0, k, left, q

    def _rise(self, x: Array) -> Array:
        """d hazard/dx: what growing grains and a growing threshold leave over, without a difference; inf at the end."""
        if self.lost_hazard > 0.0:
            # the limit at 0, at a stretch that is nothing beside all lengths there are
            x = np.maximum(x, 1e-30 * min(self._reach, self._upper))
        n0, k, left, q = self._sizes(x)
        n, m0, place = left / k, 1.0 + n0, x / self._reach
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = q * (9.0 + 12.0 * n0 + 6.0 * n * m0) + n0 / n * (12.0 + 18.0 * n0 + 4.0 * n0 * n0)
            rise += 2.0 * n0 * (n0 + m0 * (k - 1.0) / k)
            rise *= q / ((3.0 + 3.0 * n0 + n0 * n0) * (3.0 + 2.0 * n) * (3.0 + 2.0 * n0))
            rested = self._rest * place / (self._rest + place)
            rise += 3.0 * self._beta * rested * m0**3 / (k * k * n * n * (3.0 + 2.0 * n))
        return np.where(left > 0.0, rise / (m0**3 * self._reach), np.inf)

    def _hazard(self, x: Array) -> Array:
        out = np.full(x.shape, np.inf)
        near = (x < 0.25 * min(self._reach, self._upper)) & (self.lost_hazard > 0.0)
        nodes, weights = gauss(np.zeros(int(near.sum())), x[near])
        out[near] = (weights * self._rise(nodes)).sum(-1)
        n0, _, left, q = self._sizes(x[~near])
        m0, held = 1.0 + n0, left > 0.0
        far = np.full(left.shape, np.inf)
        far[held] = hazard_beyond(q[held], 1.0 / m0[held], n0[held] / m0[held]) - self.lost_hazard
        out[~near] = far
        return out

    def _logpdf(self, x: Array) -> Array:
        hazard, rise = self._hazard(x), self._rise(x)
        out = np.full(x.shape, -np.inf)
        held = np.isfinite(hazard) & np.isfinite(rise)
        with np.errstate(divide="ignore"):
            out[held] = np.log(rise[held]) - hazard[held]
        return out

    def _cdf(self, x: Array) -> Array:
        return -np.expm1(-self._hazard(x))

    def _sf(self, x: Array) -> Array:
        return np.exp(-self._hazard(x))

    def _logsf(self, x: Array) -> Array:
        return -self._hazard(x)

    def _from_hazard(self, hazard: Array) -> Array:
        flat = hazard.ravel()
        ends = np.zeros(flat.shape), np.full(flat.shape, self._upper)
        return invert_hazard(self, flat, *ends, 0.5 * ends[1]).reshape(hazard.shape)


def _end(beta: np.longdouble, rest: np.longdouble) -> np.longdouble:
    """The stretch, in units of velocity tau_m, at which even the largest grain breaks; beta = B (velocity tau_m)²."""
    # two bounds from above; the equation is convex, so that Newton comes down from them
    least = (1.0 / 3.0 + np.sqrt(1.0 / 9.0 + 2.0 / 3.0 * beta * rest)) / beta
    x = min(least, max(1.0 + rest, np.sqrt(2.0) * beta**-0.75))
    two_thirds = np.longdouble(2.0) / 3.0
    for _ in range(_STEPS):
        log_age = np.log1p(rest + x)
        value = beta * x * x - np.expm1(two_thirds * log_age)
        step = value / (2.0 * beta * x - two_thirds * np.exp(-0.5 * two_thirds * log_age))
        x -= step
        if not step > 1e-18 * x:
            break
    return x


def _ranks(u: npt.ArrayLike) -> Array:
    ranks = np.asarray(u, dtype=float)
    bad = ~((ranks >= 0.0) & (ranks <= 1.0))
    if bad.any():
        refuse("u", ranks[bad].flat[0], "must be a quantile between 0 and 1")
    return ranks


def growing_grains(alpha: float, B: float, age: float) -> GrainContact:
    """Contacts whose thresholds grow with their age, in place of thresholds in origins.Contacts (paper, Sec. VI).

    Parameters
    ----------
    alpha : float
        rho = 2<r>/d = alpha age^(1/3), in time^(-1/3).
    B : float
        As grains has it, in length^-2.
    age : float
        Of all contacts at X = 0 since coalescence began, above tau_m = (2/(3 alpha))³; a broken one begins at 0.

    Raises InputError for a value not above zero, and for an age at which no grain pins.
    """
    return GrainContact(GrainGrowth(alpha, B), age)
