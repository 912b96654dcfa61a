"""Thresholds of a thin lubricant film, fitted to molecular dynamics (paper, Eq. Pcrotate)."""

from origins.errors import finite, positive, refuse
from origins.thresholds.generalised_gamma import GeneralisedGamma
from origins.thresholds.law import Thresholds

_STEEPEST = 100.0
_SLOWEST = 0.1


def lubricated(width: float, power: float = 3.0, decay: float = 2.0) -> Thresholds:
    """P_c ~ x^power exp(-(x/width)^decay), a generalised gamma law; left out, the fit (paper, Eq. Pcrotate).

    width is a length above zero, power a number above -1 and up to 100, decay one from 0.1 to 100; else InputError.
    Forces distributed as f^a exp(-f/f0) with f_s = c x_s² give power = 2a + 1, decay = 2 and width = (f0/c)^(1/2).
    """
    width, power, decay = positive("width", width), finite("power", power), finite("decay", decay)
    if not -1.0 < power <= _STEEPEST:
        refuse("power", power, f"must be above -1, or P_c has no norm, and at most {_STEEPEST:g}")
    if not _SLOWEST <= decay <= _STEEPEST:
        refuse("decay", decay, f"must lie between {_SLOWEST:g} and {_STEEPEST:g}")
    return GeneralisedGamma(width, power, decay)
