"""Choice of the memory for the laws of contacts."""

from __future__ import annotations

from master.soft.in_time.ageing import AgeingMemory
from master.soft.in_time.grains import GrainMemory
from master.soft.in_time.memory import MeanRateMemory, Memory
from origins import Contacts


def memory_of(contacts: Contacts, level: int, fastest: float) -> Memory:
    """The memory of contacts on a drive of at most this speed; its meshes are halved with each level."""
    if contacts.ageing is not None:
        return AgeingMemory(contacts, level, fastest)
    if contacts.grains is not None:
        return GrainMemory(contacts, level)
    if contacts.thermal is not None and contacts.thermal.closure == "paper":
        return MeanRateMemory(contacts)
    return Memory(contacts, level)
