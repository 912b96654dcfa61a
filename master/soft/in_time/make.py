"""Which cohorts the laws of contacts ask for."""

from __future__ import annotations

from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.heat import MeanRateMemory, ProportionalMemory
from master.soft.in_time.memory import ColdMemory, Memory
from master.soft.in_time.spent import SpentMemory
from master.soft.in_time.strands import StrandCohorts
from origins import Contacts


def cohorts_of(contacts: Contacts, level: int) -> Cohorts:
    """All contacts at X = 0, none born yet; inner meshes are halved `level` times."""
    return StrandCohorts.of(contacts, _memory(contacts, level), level)


def fresh_cohorts_of(contacts: Contacts, level: int) -> Cohorts:
    """The same contacts where all have just formed again: what a reset leaves."""
    again = None if contacts.reforming is None else contacts.reforming.law
    return cohorts_of(contacts.replace(start=again), level)


def _memory(contacts: Contacts, level: int) -> Memory:
    """What the law of single contacts keeps of the past."""
    thermal = contacts.thermal
    if thermal is None:
        return ColdMemory(contacts)
    if thermal.closure == "paper":
        return MeanRateMemory(contacts)
    if thermal.rates.separable and contacts.stiffness == "independent":
        return ProportionalMemory(contacts)
    return SpentMemory(contacts)
