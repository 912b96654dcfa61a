"""Sliders without mass whose contacts heat breaks a little below their thresholds, and which steps do not follow in
time: contacts without heat tell of them, and a bound on what heat changes tells how well.

While heat acts on contacts for a duration that is known, it changes the force at a place X by `effect` at most, however
fast the slider goes (master/soft/in_time/idle_heat.py): each contact breaks between a stretch up to which it is quiet
and its threshold. Without heat new contacts bear F(X) at the slider's place X, and from that follows:

    it slips     where F(X1) - F(X2) > K (X2 - X1) + 2 effect for some X1 < X2: with heat, too, the spring's force
                 would have to fall by more than the drive lets it. On a spring so soft that a slip passes all
                 thresholds it renews all contacts, so that each slip is as the first, begins at a force that is off by
                 `effect` at most, and comes as much earlier or later as the drive takes for that force
    it slides    where it slides smoothly without heat, at F_k: the force keeps between two bounds that are `effect`
                 apart, which is less than the fall that counts as a slip, RISE <x_s>

An example: thresholds 1 ± 0.2, T = 1e-5 <x_s>^2, 1e12 attempts while the drive goes on by 1, K = 1e-4. F falls from
0.690 to 0.387, and `effect` is 0.0024: it slips, from 0.690 ± 0.003.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from origins.contacts import Contacts
from origins.drive import RISE
from origins.errors import InputError
from toolkit.verdict.sliders.budget import loading_of
from toolkit.verdict.sliders.in_heat import SLIDES, rigid_at
from toolkit.verdict.sliders.machine import Behaviour, Machine, RigidSlider
from toolkit.verdict.sliders.told import PRECISE_ENOUGH

# springs, in N_c<k>, on which a slip passes all thresholds
SOFTEST = 0.03
# way of new contacts on which a fall of their force is looked for, in mean thresholds; points of it; tolerance of F
FALLS_WITHIN, POINTS, TOLERANCE = 6.0, 601, 1e-5
# part of contacts that may break before they count as quiet; it is in the effect
EARLY = 1e-5


def by_contacts_without_heat(
    machine: Machine,
    contacts: Contacts,
    rule: str,
    rigid: RigidSlider,
    until: float,
    without_heat: Callable[[Contacts, RigidSlider], Behaviour],
) -> Behaviour | None:
    """What the slider does by its contacts without heat, where these tell it; None where they do not.

    rigid : of contacts with heat; until : s of the monotonic clock; without_heat : follows the slider on these
    contacts, of which so much is known
    """
    from master.soft.in_time.idle_heat import largest_effect

    alone = set(contacts.laws) <= {"thermal", "stiffness"} and contacts.start.span == (0.0, 0.0)
    if machine.mass is not None or not alone or machine.spring > SOFTEST:
        return None
    bare, unit, slides = contacts.replace(thermal=None), contacts.mean_threshold, rule in SLIDES
    # no contact holds for longer than from slip to slip
    duration = loading_of(machine, contacts, rigid.static) / machine.velocity
    effect = largest_effect(contacts, duration, EARLY)  # in mean thresholds
    if not effect < (RISE if slides else PRECISE_ENOUGH):
        return None
    try:
        if not (slides or _falls(bare, machine.spring, 2.0 * effect * unit)):
            return None
        found = without_heat(bare, rigid_at(bare, machine.velocity, None, until))
    except InputError:
        return None
    renewed = found.kind == "stick-slip" and not found.after
    if not (found.success and (found.kind == "smooth" if slides else renewed)):
        return None
    return replace(
        found,
        error=found.error + effect,
        period_error=found.period_error + bool(found.period) * effect * unit / machine.spring,
        heat_left_out=effect,
    )


def _falls(contacts: Contacts, spring: float, most: float) -> bool:
    """Whether the force of new contacts, F/(N_c <k>), falls by more than this length beyond what a spring takes back.
    It is looked at at some places alone, of which that is true the more."""
    import master

    place = np.linspace(0.0, FALLS_WITHIN * contacts.mean_threshold, POINTS)
    load = master.solve(contacts, place, TOLERANCE).force + spring * place
    return bool((np.maximum.accumulate(load) - load).max() > most)
