"""Errors of the energies of a slider with mass, by parts.

No run knows by itself what its energies miss. As of the force two runs with other tolerances, or steps, tell it by what
they differ in; an error of the force that none of them shows counts on the whole way; and what is missing of the
balance of energy may be missing of any part that is a sum along the motion.
"""

from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from origins.brief import brief
from origins.energy import Energy
from origins.thresholds.law import Array

# Parts that are sums along the motion, or follow from its speed or the contacts: the others follow from X.
SUMMED = "contacts", "kinetic", "damped", "released"


@dataclass(frozen=True)
class EnergyError:
    """Estimates from above of the largest errors of the parts of an Energy at the points of the path, per N_c<k>
    (lengths squared), floats: inf where they are not known, nan where an older result does not tell them."""

    drive: float = np.nan
    spring: float = np.nan
    contacts: float = np.nan
    kinetic: float = np.nan
    damped: float = np.nan
    released: float = np.nan

    __repr__ = brief

    def with_more(self, error: float) -> "EnergyError":
        """With this error more of each part but the drive's and the spring's, which follow from X."""
        return replace(self, **{name: getattr(self, name) + error for name in SUMMED})


PARTS = tuple(field.name for field in fields(EnergyError))
UNKNOWN = EnergyError(**dict.fromkeys(PARTS, np.inf))


class Unseen(NamedTuple):
    """Errors of energies that no other run shows.

    of_force, beside : of the spring's force as it is told, at all points, and beside slips as well (lengths)
    of_contacts : of the force of the contacts, all along the way (a length)
    by_time, at_begin : what a part changes by in the time by which that of a slip is not known, in the slip and at its
        begin, where contacts break (lengths squared)
    """

    of_force: float
    beside: float
    of_contacts: float
    by_time: float
    at_begin: float


class Ways(NamedTuple):
    """Ways (lengths): of the drive; of the slider, which goes back in slips; of its longest slip; and of contacts.
    1/K, and the largest force of the spring (a length), tell what that stores."""

    driven: float
    slid: float
    of_slip: float
    of_contacts: float
    per_spring: float
    largest: float

    @classmethod
    def of(cls, path: Array, slips: Array, spring: float, force: Array, unit: float) -> "Ways":
        """Of a drive that passes these places (n,), a slider with slips by these ways and these forces of its spring,
        and contacts of this mean threshold."""
        driven, each = float(np.abs(np.diff(path)).sum()), np.abs(slips)
        largest = float(np.abs(force).max(initial=0.0))
        longest = max(float(each.max(initial=0.0)), unit)
        return cls(driven, driven + float(each.sum()), longest, unit, 1.0 / spring, largest)


def energy_errors(
    changes: dict[str, float], told: Energy, unseen: Unseen, ways: Ways
) -> EnergyError:
    """Errors of energies that were told, by how much each part changes in other runs or steps, by its name (lengths
    squared). Those of the drive and of the spring follow from X, and so from the error of the spring's force. What is
    missing of the balance may be missing of any of the others."""
    beside = unseen.beside
    missing = float(np.abs(told.missing).max(initial=0.0)) + unseen.at_begin
    by_force = {
        "drive": unseen.of_force * ways.driven + beside * ways.largest * ways.per_spring,
        "spring": (ways.largest + 0.5 * beside) * beside * ways.per_spring,
        # of a slider that sticks they are stretched otherwise by as much as its X is off
        "contacts": missing + (unseen.of_contacts + unseen.of_force) * ways.of_contacts,
        "kinetic": missing + unseen.by_time + unseen.of_contacts * ways.of_slip,
        "damped": missing + unseen.by_time + unseen.of_contacts * ways.slid,
        "released": missing + unseen.by_time + unseen.of_contacts * ways.slid,
    }
    return EnergyError(**{name: changes[name] + error for name, error in by_force.items()})
