"""The protocol of rates: all that solvers use of the law by which contacts break below their threshold."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Protocol, runtime_checkable

import numpy as np

from origins.errors import TEMPERATURE, positive
from origins.thresholds.law import Array

Numbers = float | Array

# ln of the integral of h at which no contact holds any more; its exponential is still finite
LARGEST_EXPONENT = 650.0
# of formulas: the logarithm of 0 is -inf, and what underflows or overflows is meant to
quiet = np.errstate(divide="ignore", over="ignore")


@runtime_checkable
class RateLaw(Protocol):
    """The rate h(x; x_s) at which a contact breaks below its threshold (paper, Eq. temper1).

    Methods take numbers or arrays that broadcast, and return their common shape. Arguments are not checked, and no
    method warns. x, near and far are stretches (lengths), 0 <= x <= threshold; the rate of a contact that is stretched
    backward is that of |x|. `threshold` is x_s > 0 (a length), `stiffness` k_i/<k> > 0 (no unit). At a constant speed
    v a contact survives the way from near to far with the probability exp(-J/v), J = exp(log_passed).

    A law of your own is a subclass of RateLaw. It defines `name`, as messages call it, `scale`, per time, which no rate
    exceeds, `log_rate`, `log_passed` and `reached`, and inherits `rate` and `separable`; docs/extending.md has one.
    Give it to origins.Contacts as `thermal`. For the ensemble it may define `compiled()`, which returns an
    origins.laws.compiled.CompiledRates: without it each break takes some microseconds.

    separable : whether ln h, at one stiffness, is a function of x plus one of the threshold. The integrals of two
        contacts with the same history then have the same ratio for every history.
    """

    separable: ClassVar[bool] = False

    @property
    def name(self) -> str: ...

    @property
    def scale(self) -> float: ...

    @abstractmethod
    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers) -> Array:
        """ln h, h per time, to 1e-13 of max(1, |ln h|): finite where h underflows, -inf where h = 0."""

    @abstractmethod
    def log_passed(
        self, near: Numbers, far: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """ln J, J the integral of h over the stretches from near to far >= near (a length per time), -inf where equal.

        To 1e-13 of max(1, |ln|), also where near ~ far: do not subtract two large integrals.
        """

    @abstractmethod
    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch at which ln J, integrated from near, is log_amount; the threshold where it stays below.

        Accurate to 1e-12 of the threshold, or in the integral up to the stretch.
        """

    def rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers) -> Array:
        """h, per time; 0 where it underflows."""
        return np.exp(self.log_rate(x, threshold, stiffness))


@dataclass(frozen=True)
class ActivatedRates(RateLaw):
    """A rate with an attempt frequency ω (per time) and a barrier that a temperature T = k_BT/<k> overcomes.

    T is a length squared. Raises InputError unless both are finite and above zero.
    """

    temperature: float
    attempt_frequency: float = 1.0

    def __post_init__(self) -> None:
        positive("temperature", self.temperature, TEMPERATURE)
        positive("attempt_frequency", self.attempt_frequency)

    @property
    def scale(self) -> float:
        """ω, which no rate exceeds."""
        return self.attempt_frequency

    @property
    def log_scale(self) -> float:
        """ln ω."""
        return float(np.log(self.attempt_frequency))

    @property
    def spring(self) -> float:
        """k/2k_BT at mean stiffness, per length squared."""
        return 0.5 / self.temperature
