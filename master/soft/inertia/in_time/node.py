"""The state of a slider with mass at the end of a step."""

from typing import NamedTuple

from master.soft.inertia.record import Spent


class HeavyNode(NamedTuple):
    """The end of a step: the sum of the sizes of its section's steps so far, and the state there; from the time on
    these are columns of what is read. Energies are per N_c<k> (length squared), see master.soft.inertia.record.Record.
    """

    sizes_so_far: float
    time: float
    force: float
    holding: float
    position: float
    speed: float
    work: float
    damped: float
    on_contacts: float
    stored: float

    @property
    def spent(self) -> Spent:
        """The energies so far."""
        return Spent(self.work, self.damped, self.on_contacts)
