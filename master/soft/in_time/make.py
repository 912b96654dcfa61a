"""Choice of the memory for the laws of contacts."""

from __future__ import annotations

from master.soft.in_time.ageing import AgeingMemory
from master.soft.in_time.grains import GrainMemory, WarmGrainMemory
from master.soft.in_time.heat import ProportionalMemory
from master.soft.in_time.memory import Memory
from master.soft.in_time.spent import SpentMemory
from origins import Contacts, InputError


def memory_of(contacts: Contacts, level: int, fastest: float) -> Memory:
    """The memory of contacts on a drive of at most this speed; its meshes are halved with each level."""
    thermal = contacts.thermal
    if contacts.ageing is not None:
        return AgeingMemory(contacts, level, fastest)
    if contacts.grains is not None:
        kind = GrainMemory if thermal is None else WarmGrainMemory
        return kind(contacts, level)
    if thermal is None:
        return Memory(contacts)
    if thermal.closure == "paper":
        raise InputError(
            'contacts.thermal: closure = "paper" is not followed under a spring; use closure = "exact"'
        )
    if thermal.rates.separable and contacts.stiffness == "independent":
        return ProportionalMemory(contacts)
    return SpentMemory(contacts, level)
