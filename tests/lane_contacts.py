"""One contact at a time through the compiled laws of the ensemble."""

from typing import Any

import numpy as np
from numba import njit

from eq_model.contact import Break, Contact, life
from eq_model.draws.streams import make_stream
from eq_model.lattice import make_way
from eq_model.physics import law_of
from origins import Contacts, Drive


@njit
def _life(law, contact, way, counts):  # type: ignore[no-untyped-def]
    return life(law, contact, way, counts)


class Lane:
    """Contacts of one kind on one drive; lengths are those of the drive."""

    def __init__(self, contacts: Contacts, drive: Drive, reach: float = 8.0) -> None:
        self.way = make_way(drive, 1.0, reach, exact=False)
        self.law, self.contacts = law_of(contacts, self.way, 0), contacts
        # time at which each leg begins, and that of the end
        self.times = np.append(0.0, np.cumsum(self.way.paces * np.diff(self.way.begins)))

    def follow(
        self,
        x: float,
        threshold: float,
        exposure: float,
        *,
        born: float = 0.0,
        fresh: bool = True,
        block: int = 0,
    ) -> tuple[float, float]:
        """Time and stretch at which a contact breaks; inf where it holds to the end of the drive."""
        leg = int(np.searchsorted(self.times, born, side="right")) - 1
        clock = int(self.way.begins[leg] + (born - self.times[leg]) / self.way.paces[leg])
        contact = Contact(
            np.int64(clock),
            np.int64(leg),
            np.int64(round(x / self.way.unit)),
            np.int64(round(threshold / self.way.unit)),
            float(np.log(exposure)),
            float(self.contacts.relative_stiffness(threshold)),
            fresh,
            np.int64(0),
            np.int64(0),
            make_stream(1, block),
        )
        counts: Any = np.zeros((0, 2, 8), np.uint32)
        found: Break = _life(self.law, contact, self.way, counts)
        if found.clock > self.way.begins[-1]:
            return np.inf, np.inf
        moved = found.clock - self.way.begins[found.leg]
        place = self.way.positions[found.leg] + self.way.directions[found.leg] * moved
        first = self.way.positions[leg] + self.way.directions[leg] * (clock - self.way.begins[leg])
        return self.times[found.leg] + moved * self.way.paces[found.leg], x + (
            place - first
        ) * self.way.unit
