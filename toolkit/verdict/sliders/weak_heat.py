"""Sliders without mass whose contacts heat breaks a little below their thresholds, and which steps do not follow in
time: contacts without heat tell of them, and a bound on what heat changes tells how well.

While heat acts on contacts for a duration that is known, it changes the force at a place X by `effect` at most, however
fast the slider goes (master/soft/in_time/idle_heat.py): each contact breaks between a stretch up to which it is quiet
and its threshold. Without heat new contacts bear F(X) at the slider's place X, and from that follows:

    it slips     where F(X1) - F(X2) > K (X2 - X1) + 2 effect behind the X1 at which the first slip begins: with heat,
                 too, the spring's force would have to fall by more than the drive lets it. Before X1 the force has to
                 rise by so much that heat brings no slip about. Or rigid sliders in heat have that fall, too
                 (master/soft/left_out.py tells both). On a spring so soft that a slip passes all thresholds it renews
                 all contacts, so that each slip is as the first, begins at a force that is off by `effect` at most,
                 and comes as much earlier or later as the drive takes for that
    it slides    where it slides smoothly without heat, at F_k: the force keeps between two bounds that are `effect`
                 apart, which is less than the fall that counts as a slip, RISE <x_s>

An example: thresholds 1 ± 0.2, T = 1e-5 <x_s>^2, 1e12 attempts while the drive goes on by 1, K = 1e-4. F falls from
0.690 to 0.387, and `effect` is 0.0024: it slips, from 0.690 ± 0.003.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from origins.contacts import Contacts
from origins.drive import RISE, Drive
from origins.errors import InputError
from toolkit.verdict.sliders.in_heat import SLIDES, rigid_at
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.sliders.told import PRECISE_ENOUGH
from toolkit.verdict.sliders.ways import loading_of

# springs, in N_c<k>, on which a slip passes all thresholds
SOFTEST = 0.03
# path on which the first slip is looked at, in loadings, which end within the second; and the tolerance of its force
PART_OF_SECOND, TOLERANCE = 1.5, 1e-6
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
    loading = loading_of(machine, contacts, rigid.static)
    duration = loading / machine.velocity
    effect = largest_effect(contacts, duration, EARLY)  # in mean thresholds
    if not effect < (RISE if slides else PRECISE_ENOUGH):
        return None
    try:
        if not (slides or _slips_surely(contacts, machine, rule, loading, effect * unit, until)):
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


def _slips_surely(
    contacts: Contacts, machine: Machine, rule: str, loading: float, effect: float, until: float
) -> bool:
    """Whether the first slip without heat, within so much of the drive's path, comes with heat, too, which changes the
    force by `effect` at most (both lengths), and none before it."""
    from master.soft.cold import ColdSlider

    path = np.array([0.0, PART_OF_SECOND * loading])
    drive = Drive(path, machine.velocity, spring=machine.spring, slip=rule)  # type: ignore[arg-type]
    bare = contacts.replace(thermal=None)
    slider = ColdSlider(bare, drive, TOLERANCE, until, effect, contacts)
    return bool(slider.follow().slips.drive.size) and not slider.unsure_slip
