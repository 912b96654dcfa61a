"""Greenwood-Williamson thresholds for exponential heights: Weibull laws (paper, Eqs. GW3, GW4)."""

from origins.errors import positive
from origins.thresholds.generalised_gamma import GeneralisedGamma
from origins.thresholds.law import Thresholds


def gw_elastic(B: float) -> Thresholds:
    """Elastic contacts, P_c ~ x^(1/3) exp(-B x^(4/3)) (paper, Eq. GW3).

    B is in length^(-4/3); InputError unless it is finite and above zero.
    """
    return Weibull(4.0 / 3.0, positive("B", B), 1.0 / 3.0)


def gw_plastic(B: float) -> Thresholds:
    """Plastic contacts, P_c ~ x exp(-B x^2) (paper, Eq. GW4).

    B is in length^-2; InputError unless it is finite and above zero.
    """
    return Weibull(2.0, positive("B", B), 1.0)


class Weibull(GeneralisedGamma):
    """S(x) = exp(-rate x^shape); power = shape - 1 is the onset."""

    def __init__(self, shape: float, rate: float, power: float) -> None:
        super().__init__(rate ** (-1.0 / shape), power, shape, order=1.0)
