"""One scene in units of its mean stretch at a break: the law, the first breaks, the atomic chain."""

from master.atomic import AtomicChain
from master.cycle import Cycle
from master.first import FirstBreaks
from master.law import Law
from origins import Contacts

_BEYOND = 1.7  # lattices reach past the last position, at most by 24 of the coarsest steps


class Problem:
    """What does not depend on the lattice, up to X = `end` and for errors well below `tolerance` (both in
    units of the cycle's length)."""

    def __init__(self, contacts: Contacts, end: float, tolerance: float, cycle: Cycle | None = None) -> None:
        self.contacts = contacts
        self.cycle = cycle = Cycle(contacts) if cycle is None else cycle
        self.unit = cycle.unit
        self.end = end
        furthest = _BEYOND * end
        self.law = Law(contacts, furthest + max(contacts.start.span[1], 0.0) / self.unit, cycle.law, self.unit)
        self.first = self._first(furthest, 1e-4 * tolerance)
        # corners of the law or of the first breaks above X = 0 make errors uneven
        self.rough = self.law.rough or self.first.has_corners
        self.chain = AtomicChain(self.law, self.first.atoms, self.first.atom_weights, end)

    def _first(self, end: float, accuracy: float) -> FirstBreaks:
        contacts, breaking = self.contacts, self.cycle.breaking
        if breaking is None or contacts.start.span == (0.0, 0.0):
            return FirstBreaks(contacts, self.law, end, accuracy)
        from master.thermal_first import ThermalFirstBreaks

        return ThermalFirstBreaks(contacts, self.law, breaking, end, accuracy)
