"""Laws of how contacts break below their threshold, one file each, and the list of their names."""

from typing import Literal

from origins.laws.soft import SoftRates
from origins.laws.stiff import StiffRates

# the laws that origins.Thermal and scene files take by name
RATE_LAWS: dict[Literal["soft", "stiff"], type[SoftRates] | type[StiffRates]] = {
    "soft": SoftRates,
    "stiff": StiffRates,
}

__all__ = ["RATE_LAWS", "SoftRates", "StiffRates"]
