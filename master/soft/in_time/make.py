"""Which memory the laws of contacts ask for."""

from __future__ import annotations

from master.soft.in_time.ageing import AgeingMemory
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.grains import GrainMemory, WarmGrainMemory
from master.soft.in_time.heat import MeanRateMemory, ProportionalMemory
from master.soft.in_time.memory import ColdMemory, Memory
from master.soft.in_time.spent import SpentMemory
from origins import Contacts


class Maker:
    """Makes cohorts of some contacts on finer and finer inner meshes, each mesh once.

    Parameters
    ----------
    contacts : Contacts
    fastest : float
        Largest speed of the drive.
    """

    def __init__(self, contacts: Contacts, fastest: float) -> None:
        self._contacts, self._fastest = contacts, fastest
        self._memories: dict[int, Memory] = {}

    def all(self, level: int, reset: bool = False) -> Cohorts:
        """All contacts at X = 0, none born yet, as they start or as a reset leaves them.

        Inner meshes are halved `level` times.
        """
        contacts = self._contacts
        mesh = 0 if contacts.grains is None and contacts.ageing is None else level
        if mesh not in self._memories:
            self._memories[mesh] = _memory(contacts, mesh, self._fastest)
        return Cohorts.of(contacts, self._memories[mesh], level, reset)


def _memory(contacts: Contacts, level: int, fastest: float) -> Memory:
    """What the law of single contacts keeps of the past; of some on finer meshes with each level."""
    thermal = contacts.thermal
    if contacts.ageing is not None:
        return AgeingMemory(contacts, level, fastest)
    if contacts.grains is not None:
        kind = GrainMemory if thermal is None else WarmGrainMemory
        return kind(contacts, level)
    if thermal is None:
        return ColdMemory(contacts)
    if thermal.closure == "paper":
        return MeanRateMemory(contacts)
    if thermal.rates.separable and contacts.stiffness == "independent":
        return ProportionalMemory(contacts)
    return SpentMemory(contacts)
