"""Persson's thresholds: local normal stress turned into stretch (paper, Eq. PcPersson3)."""

from functools import cached_property

import numpy as np
from scipy.special import erf, exprel, gamma

from origins.errors import non_negative, positive, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.numerical import NumericalLaw

_FURTHEST = 1e6  # centre over width
_HEAVY = 40.0  # a above which nothing to speak of lies near x = 0


def persson(centre: float, width: float) -> Thresholds:
    """P_c ~ x {exp[-((x^2 - c^2)/w^2)^2] - exp[-((x^2 + c^2)/w^2)^2]} (paper, Eq. PcPersson3).

    c = centre >= 0 and w = width > 0 are lengths, else InputError. centre = 0 is the limit of light load,
    P_c ~ x^3 exp(-(x/w)^4). Heavy load tends to a normal law of standard deviation w²/(2^(3/2) c); centre/width above
    1e6, where that nears the round-off of x, is refused.
    """
    centre, width = non_negative("centre", centre), positive("width", width)
    if centre > _FURTHEST * width:
        one = f"take identical, value = {centre:g}"
        refuse(
            "centre", centre, f"is more than {_FURTHEST:g} widths: one value to round-off; {one}"
        )
    return Persson(centre, width)


class Persson(Thresholds):
    """Written in f = (x/w)^2 and a = (c/w)^2, where P_c dx ~ {exp[-(f - a)^2] - exp[-(f + a)^2]} df."""

    onset_power = 3.0

    def __init__(self, centre: float, width: float) -> None:
        self.centre, self.width = centre, width
        self._a = (centre / width) ** 2
        # (2a/sqrt(pi)) / erf(a), 1 at a = 0
        kappa = 2.0 * self._a / np.sqrt(np.pi) / float(erf(self._a)) if self._a > 0.0 else 1.0
        self._log_front = float(np.log(4.0 * kappa / width))
        # a law far narrower than its centre keeps its digits as a function of x - c
        self._origin = centre if self._a > _HEAVY else 0.0

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    @cached_property
    def _numerical(self) -> NumericalLaw:
        return NumericalLaw(
            self._log_beside, 0.0, np.inf, [self.centre], self.onset_power, self._origin
        )

    def _log_beside(self, y: Array) -> Array:
        """log P_c at the distance y from the origin."""
        x = y + self._origin
        away = y if self._origin else x - self.centre
        u = x / self.width
        with np.errstate(divide="ignore", over="ignore"):
            off = away / self.width * ((x + self.centre) / self.width)  # f - a
            return (
                self._log_front
                + 3.0 * np.log(u)
                + np.log(exprel(-4.0 * self._a * u * u))
                - off * off
            )

    def _logpdf(self, x: Array) -> Array:
        return self._log_beside(x - self._origin)

    def _moment(self, n: int) -> float:
        return float(self.width**n * gamma(1.0 + n / 4.0)) if self._a == 0.0 else super()._moment(n)
