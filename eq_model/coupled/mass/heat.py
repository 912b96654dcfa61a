"""Contacts that also break by heat on a slider with mass: proposals at rates above their own, as on a spring.

Levels and proposals are those of coupled/heat.py. A contact's window is all |x| up to a *reach*, at its threshold or
before, and its level is above its rate at any of them, wherever the slider swings: exact whatever the reach is. A
contact that the slider takes to its reach breaks there if that is its threshold, and else gets a farther reach. Until a
proposal the motion is closed as ever, and no step follows the rate of a slider that rings.
"""

import numpy as np

from eq_model.compiling import bare, real, whole
from eq_model.coupled.ages import threshold_of
from eq_model.coupled.heat import (
    by_heat,
    draw_budget,
    leave_all,
    level_of,
    proposed,
    set_level,
    stiffness_of,
)
from eq_model.coupled.mass.nearest import set_place


@bare
def _begin(heat, s):  # type: ignore[no-untyped-def]
    """No contact holds yet, and the first proposal is drawn."""
    leave_all(heat)
    draw_budget(heat, s)


@bare
def _reach(heat, ages, contact, s, allowed):  # type: ignore[no-untyped-def]
    """The |x| up to which a contact has a level of at most `allowed`, or the one above that of its rates up to now; its
    threshold at most. The contact has that level from now on."""
    k = stiffness_of(heat, ages, contact)
    y, oldest = threshold_of(ages, contact, s.now), threshold_of(ages, contact, heat.end)
    here, most = abs(s.at - ages.zero[contact]), whole(np.rint(y))
    allowed, way = max(allowed, level_of(heat, 0, here, y, oldest, k) + 1), max(most - here, 1)
    level = level_of(heat, 0, here + way, y, oldest, k)
    while level > allowed and way > 1:
        way >>= 1
        level = level_of(heat, 0, here + way, y, oldest, k)
    set_level(heat, contact, level)
    return min(here + way, most)


@bare
def _propose(heat, s, contacts):  # type: ignore[no-untyped-def]
    """The contact that breaks by heat now, or -1 if none does."""
    contact, accepted, rare = proposed(heat, contacts.ages, s)
    if accepted:
        return contact
    if rare:
        reach = _reach(heat, contacts.ages, contact, s, 1)
        set_place(contacts.ahead, contact, contacts.ages.zero[contact] + reach)
        set_place(contacts.behind, contact, reach - contacts.ages.zero[contact])
    return whole(-1)


# reach_of(heat, ages, contact, s): the |x| at which a contact is looked at anew
reach_of = by_heat(
    lambda heat, ages, contact, s: _reach(heat, ages, contact, s, heat.allowed),
    lambda heat, ages, contact, s: whole(np.rint(threshold_of(ages, contact, s.now))),
)
# the stiffness of a contact with these places, which without heat are at its threshold
stiffness_by_places = by_heat(
    lambda heat, ages, contact, ahead, behind, mean: stiffness_of(heat, ages, contact),
    lambda heat, ages, contact, ahead, behind, mean: (
        0.5 * real(ahead + behind) / mean if mean > 0.0 else 1.0
    ),
)
propose = by_heat(
    lambda heat, s, contacts: _propose(heat, s, contacts),
    lambda heat, s, contacts: whole(-1),
)
begin_heat = by_heat(lambda heat, s: _begin(heat, s), lambda heat, s: None)
