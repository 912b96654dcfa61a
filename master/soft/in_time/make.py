"""Which cohorts the laws of contacts ask for."""

from __future__ import annotations

from master.soft.in_time.ageing import AgeingCohorts
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.grains import GrainMemory, WarmGrainMemory
from master.soft.in_time.heat import MeanRateMemory, ProportionalMemory
from master.soft.in_time.memory import ColdMemory, Memory
from master.soft.in_time.spent import SpentMemory
from master.soft.in_time.strands import StrandCohorts
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
        again = None if contacts.reforming is None else contacts.reforming.law
        self._fresh = contacts
        if contacts.grains is None:
            self._fresh = contacts.replace(start=again)
        self._memories: dict[int, Memory] = {}

    def all(self, level: int) -> Cohorts:
        """All contacts at X = 0, none born yet; meshes are halved `level` times."""
        return self._cohorts(self._contacts, level)

    def fresh(self, level: int) -> Cohorts:
        """The same contacts where all have just formed again: what a reset leaves."""
        return self._cohorts(self._fresh, level, reset=True)

    def _cohorts(self, contacts: Contacts, level: int, reset: bool = False) -> Cohorts:
        if contacts.ageing is not None:
            return AgeingCohorts.of(contacts, level, self._fastest)
        mesh = 0 if contacts.grains is None else level
        if mesh not in self._memories:
            self._memories[mesh] = _memory(self._contacts, mesh)
        return StrandCohorts.of(contacts, self._memories[mesh], level, reset)


def _memory(contacts: Contacts, level: int) -> Memory:
    """What the law of single contacts keeps of the past; of grains alone on finer meshes."""
    thermal = contacts.thermal
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
