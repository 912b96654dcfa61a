"""The barriers of islands beside heat: their own, and the one that heat overcomes where a contact is a spring."""

from typing import NamedTuple

import numpy as np

from origins.contacts import Contacts, Thermal

# K, at which barriers are told where no temperature is given, and in k_BT there those that heat overcomes in a minute
# at 1e12 attempts a second, about; and by how much a barrier, in k_BT, is another one: heat breaks e³ times as often
_WARM, _OVERCOME, _ANOTHER = 300.0, 30.0, 3.0


class Barriers(NamedTuple):
    """Mean barriers of islands, k_BT: their own, at 300 K where no temperature is given; and the energy at which heat
    breaks a contact, k x_s²/2."""

    own: float
    at_break: float


def of_barriers(contacts: Contacts) -> list[str]:
    """A note on the barriers of islands, which are not those that heat overcomes, or which it would where none is
    given; else none."""
    own, at_break = barriers_of(contacts)
    if contacts.thermal is None and own < _OVERCOME:
        return [
            f"all is told at T = 0: the islands' own barriers are on average {own:.2g} k_BT at {_WARM:.0f} K, "
            f"which heat overcomes: give contacts.thermal{_whose_barrier(own)}"
        ]
    if np.isnan(at_break):
        return []
    said = f"the islands' own barriers are on average {own:.2g} k_BT, and heat overcomes "
    said += f"{at_break:.2g} k_BT here, the energy k x_s²/2 of a contact as it breaks"
    if _heat_by_another_barrier(contacts):
        said += f': [contacts.thermal] law = "eyring" with width = {1.0 / own:.2g} has their mean barrier'
    return [said]


def _whose_barrier(own: float) -> str:
    """Which law of heat to choose for islands whose own barriers are so many k_BT; "" where none has so low a one."""
    if own < 1.0:
        return ""
    width = f'law = "eyring" with width = {1.0 / own:.2g}'
    return (
        f', {width} of the same mean barrier; that of "soft" and "stiff" is another one, k x_s²/2'
    )


def barriers_of(contacts: Contacts) -> Barriers:
    """The mean barriers of the contacts of islands, in k_BT; nan where they are not known, or are no islands."""
    law, thermal, surface = contacts.thresholds, contacts.thermal, contacts.interface
    if law.domains is None:
        return Barriers(np.nan, np.nan)
    stiffness = law.domains.mean_stiffness if surface is None else surface.mean_stiffness
    own = float(law.domains.barriers[law.domains.barriers > 0.0].mean()) / stiffness
    if thermal is None:
        warm = np.nan if surface is None else surface.temperature(kelvin=_WARM)
        return Barriers(own / warm, np.nan)
    if not isinstance(thermal, Thermal) or thermal.temperature is None:
        return Barriers(np.nan, np.nan)
    linked = contacts.stiffness == "linked"
    square = law.moment(3) / law.mean() if linked else law.moment(2)
    return Barriers(own / thermal.temperature, square / (2.0 * thermal.temperature))


def of_other_barriers(contacts: Contacts) -> list[str]:
    """The note where heat matters by one of the two barriers of islands, and much less by the other; else none."""
    return of_barriers(contacts) if _heat_by_another_barrier(contacts) else []


def of_cold(contacts: Contacts) -> list[str]:
    """In a few words, that islands are told at T = 0 whose barriers heat overcomes; else none."""
    if contacts.thermal is None and (own := barriers_of(contacts).own) < _OVERCOME:
        return [
            f"all at T = 0: at {_WARM:.0f} K heat overcomes the islands' barriers, {own:.2g} k_BT"
        ]
    return []


def _heat_by_another_barrier(contacts: Contacts) -> bool:
    """Whether heat matters by one of the two barriers of islands, and much less by the other."""
    barriers = barriers_of(contacts)
    return min(barriers) < _OVERCOME and abs(barriers.own - barriers.at_break) > _ANOTHER
