"""Laws of how contacts break below their threshold: one file each, and the list of those with a name."""

from origins.laws.soft import SoftRates
from origins.laws.stiff import StiffRates

# every law that origins.Thermal, and with it a scene file, knows by its name
RATE_LAWS: dict[str, type[SoftRates] | type[StiffRates]] = {
    law.name: law for law in (SoftRates, StiffRates)
}

__all__ = ["RATE_LAWS", "SoftRates", "StiffRates"]
