"""One scene in units of its mean threshold: the law, the first breaks, the atomic chain."""

from typing import TYPE_CHECKING

from master.atomic import AtomicChain
from master.first import FirstBreaks
from master.law import Law
from origins import Contacts

if TYPE_CHECKING:
    from master.ageing_start import AgeingStart

_BEYOND = 1.7  # lattices reach past the last position, at most by 24 of the coarsest steps


class Problem:
    """What does not depend on the lattice, up to X = `end` and for errors well below `tolerance` (both in
    units of the mean threshold)."""

    starting: "AgeingStart | None" = None  # where contacts that hold at X = 0 do not break as the law says

    def __init__(self, contacts: Contacts, end: float, tolerance: float) -> None:
        self.contacts = contacts
        self.unit = contacts.mean_threshold
        self.end = end
        self.law = Law(contacts, _BEYOND * end + max(contacts.start.span[1], 0.0) / self.unit)
        self.first = self._first(_BEYOND * end, 1e-4 * tolerance)
        # corners of the law or of the first breaks above X = 0 make errors uneven
        self.rough = self.law.rough or self.first.has_corners
        self.chain = AtomicChain(self.law, self.first.atoms, self.first.atom_weights, end)

    def _first(self, end: float, accuracy: float) -> FirstBreaks:
        return FirstBreaks(self.contacts, self.law, end, accuracy)
