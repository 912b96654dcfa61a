"""Contacts whose thresholds grow with age: each keeps its quantile in the law of the coalescing grains."""

from functools import cached_property

import numpy as np
import numpy.typing as npt

from origins.errors import positive, refuse
from origins.grains.film import GrainGrowth
from origins.grains.lifshitz_slyozov import hazard_beyond, invert_beyond
from origins.laws.growing import GrowingThresholds
from origins.laws.timed_law import LINKED
from origins.thresholds.law import Array, Thresholds

_FASTEST = 1e50  # in units of 1/(B^(1/2) tau_m): powers of speeds must stay finite


class GrainContact(GrowingThresholds):
    """Contacts that keep their quantile u for life: the threshold is Q(u; age), Q the quantile of P_c at that age.

    Exact Jacobian. A contact pins from the age tau_m on, at stretch 0, and breaks where it first meets its threshold:
    sliding at `velocity` after a time `rest` it has the age tau_m + rest + x/velocity at stretch x, and holds beyond x
    with the probability exp(-hazard(x, age)). It then carries no force for tau_m, until its new grains pin; one that
    is stretched faster than its threshold grows never holds, and waits once more.

    growth : of the grains; age : that of all contacts at X = 0, a time above tau_m, which origins.Contacts needs.
    Raises InputError for anything but a GrainGrowth, and for an age at which no grain pins.
    """

    law = "grains"
    waiting = "grains grow, unpinned, for so long that "
    begins_at_0 = True
    keeps_tail = False  # there is a largest grain

    def __init__(self, growth: GrainGrowth, age: float | None = None) -> None:
        if not isinstance(growth, GrainGrowth):
            refuse("growth", growth, "must be as origins.GrainGrowth(alpha=1.0, B=1.0)")
        self.growth, self.age = growth, age
        self.first_pinning_time = self.time_unit = growth.first_pinning_time
        if age is not None and positive("age", age) <= growth.first_pinning_time:
            refuse("age", age, f"no grain pins before {growth.first_pinning_time:.12g}")

    @property
    def apart(self) -> dict[str, str]:
        """See TimedLaw."""
        form_at_0 = "reforming: contacts form again as their grains pin, where all thresholds are 0"
        at_birth = "thresholds that grow: <x_s> at birth is 0"
        return super().apart | {
            "stiffness": f'{LINKED} {at_birth}; use "independent"',
            "reforming": f"{form_at_0}; leave it out",
        }

    def __repr__(self) -> str:
        """Its arguments."""
        return f"GrainContact({self.growth!r}, age={self.age})"

    def largest_threshold(self, fresh: float, ratio: float, duration: float) -> float:
        """See ChangingThresholds: that of the largest grain, at the age of the oldest contacts."""
        return max(fresh, self.typical_threshold(fresh, duration))

    def typical_threshold(self, fresh: float, duration: float) -> float:
        """See ChangingThresholds: the largest one, as all up to it are typical. InputError without an age at X = 0."""
        assert self.age is not None
        return float(self.quantile(1.0, self.age + duration))

    @cached_property
    def at_start(self) -> Thresholds:  # type: ignore[override]
        """P_c at X = 0. InputError where the age there is not given."""
        if self.age is None:
            refuse("age", None, "give that of contacts at X = 0, above growth.first_pinning_time")
        return self.growth.thresholds(self.age)

    def hazard(self, x: npt.ArrayLike, age: npt.ArrayLike) -> Array:
        """-ln of the fraction of contacts of `age` whose thresholds exceed x >= 0 (a length); shapes broadcast. Of
        those that pinned together exp(-h) still hold, h the largest so far; up to tau_m it is infinite, but at 0."""
        pinned_for = np.maximum(np.asarray(age) - self.first_pinning_time, 0.0)
        return self.hazard_at(np.asarray(x, dtype=float), pinned_for)[()]

    def hazard_at(self, x: Array | float, pinned_for: Array | float) -> Array:
        """See GrowingThresholds."""
        # of the largest grain's diameter over the film's thickness, beyond 1
        x, excess = np.broadcast_arrays(x, self.growth.excess_after(pinned_for))
        s = np.sqrt(float(self.growth.B)) * np.abs(x)
        over = s * (s / (1.0 + np.hypot(1.0, s)))  # diameter of the breaking grain over d, less 1
        within = (over < excess) & (over > 0.0)
        out, over, excess = np.where(over > 0.0, np.inf, 0.0), over[within], excess[within]
        out[within] = hazard_beyond(over / excess * ((1.0 + excess) / (excess - over)), excess)
        return out

    def threshold_at(self, hazard: Array | float, pinned_for: Array | float) -> Array:
        """See GrowingThresholds."""
        hazard, excess = np.broadcast_arrays(hazard, self.growth.excess_after(pinned_for))
        q = invert_beyond(np.minimum(hazard, 1e300), excess)
        # the largest grain has an infinite hazard
        fraction = np.where(np.isinf(hazard), 1.0, q * excess / (1.0 + excess + q * excess))
        return np.sqrt(excess * fraction * (excess * fraction + 2.0) / self.growth.B)

    def quantile(self, u: npt.ArrayLike, age: npt.ArrayLike) -> Array:
        """Threshold (a length) of the contact of quantile u in [0, 1] at `age`; shapes broadcast. It rises with age,
        from 0 at tau_m. InputError for ages below tau_m, at which no grain pins."""
        u, age = np.asarray(u, dtype=float), np.asarray(age, dtype=float)
        if (bad := ~((u >= 0.0) & (u <= 1.0))).any():
            refuse("u", u[bad].flat[0], "must be a quantile between 0 and 1")
        first = self.first_pinning_time
        if (bad := ~((age >= first) & (age < np.inf))).any():
            refuse("age", age[bad].flat[0], f"no grain pins before {first:.12g}")
        with np.errstate(divide="ignore"):
            return self.threshold_at(-np.log1p(-u), age - first)[()]

    def lost_hazard(self, velocity: float) -> float:
        """h = (9/2) B (velocity tau_m)²: a share exp(-h) of the contacts ever holds if sliding begins as they pin."""
        with np.errstate(over="ignore"):
            return float(4.5 * np.square(self._relative(velocity)))

    def check_speed(self, velocity: float) -> None:
        """InputError for speeds so far from that at which thresholds grow that their powers overflow."""
        if not 1.0 / _FASTEST < (ratio := self._relative(velocity)) < _FASTEST:
            hint = f"of that at which thresholds grow, beyond {1.0 / _FASTEST:g} to {_FASTEST:g}"
            refuse("velocity", velocity, f"is {ratio:.3g} {hint}")

    def _relative(self, velocity: float) -> float:
        return velocity * self.first_pinning_time * float(np.sqrt(float(self.growth.B)))

    @property
    def quick_width(self) -> float:  # type: ignore[override]
        """Width (a length) of the narrowest interval with a tenth of the stretches at which contacts break that
        slide as fast as grains grow: few hold, and at small stretches."""
        return 0.0504 / float(np.sqrt(float(self.growth.B)))  # at B^(1/2) v tau_m = 1


def growing_grains(alpha: float, B: float, age: float) -> GrainContact:
    """Contacts whose thresholds grow with their age, in place of thresholds in origins.Contacts (paper, Sec. VI).

    alpha, B : rho = 2<r>/d = alpha age^(1/3), in time^(-1/3); B as grains has it, in length^-2.
    age : of all contacts at X = 0 since coalescence began, above tau_m = (2/(3 alpha))³; a broken one begins at 0.
    Raises InputError for a value not above zero, and for an age at which no grain pins.
    """
    return GrainContact(GrainGrowth(alpha, B), age)
