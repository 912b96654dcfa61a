"""ChangingLife: what a law by which thresholds change offers the master equation beside its survival."""

from __future__ import annotations

from master.motion import Motion
from master.survival.life import Life
from origins import Contacts


class ChangingLife(Life):
    """A Life of contacts whose thresholds change while they hold; LIVES of master.survival.make has it by their law."""

    @classmethod
    def made(
        cls, contacts: Contacts, tolerance: float, motion: Motion, until: float
    ) -> ChangingLife:
        """The life on a motion; arguments as those of make.life_of."""
        raise NotImplementedError

    @classmethod
    def why_not(cls, contacts: Contacts, one_leg: bool = True) -> str:
        """Why these contacts have no such life on a rigid slider that keeps its speed (`one_leg`), or on one that turns
        or rests, and what to do instead; "" where they have one."""
        return ""

    @classmethod
    def longest(cls, contacts: Contacts, velocity: float) -> float:
        """A time after which no contact holds on a slider of this speed v > 0; InputError where none ever does."""
        raise NotImplementedError
