"""Why slips begin at another force than the static friction of the table. On a spring near K* one begins below it, past
the peak of the force, which `slip_rows.past_peak` tells."""

import numpy as np

from origins.contacts import Contacts
from toolkit.scene.scale import written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.text.kinds import damped

# of F_s: by more than that a slip begins above it, and not by rounding or an error
ABOVE_STATIC = 1e-3
# times v (K M)^(1/2) and the damping's share, the most that the spring pulls by: more is no inertia, but for errors
MORE = 1.01


def why_above(verdict: Verdict) -> list[str]:
    """Why slips begin above F_s, or of islands at another force, in a sentence below the table, beside both; none where
    they do not."""
    own = verdict.own
    slipping = [one for one in own.behaviours if one.slips and one.kind != "smooth"]
    highest = max((abs(one.before) for one in slipping), default=0.0)
    static, small = own.static.value, ABOVE_STATIC * own.static.value
    if own.smoothed and slipping and not own.contacts.in_time and abs(highest - static) > small:
        return [
            "F_s is that of the smooth law through the islands' barriers, and the force before a slip that of sliders "
            "with the barriers themselves"
        ]
    if own.machine is None or not highest > static + small:
        return _by_inertia(own)
    followed = own.contacts
    if all(one.without_heat for one in slipping):
        followed = followed.replace(thermal=None)  # heat is no cause of what was found without it
    if own.contacts.in_time:
        whose = "F_s is that of a rigid slider as fast as the drive"
        return [f"the force before a slip is above F_s: {whose}; {_why_above(followed)}"]
    if own.contacts.start.is_single:
        return _by_inertia(own)
    return [
        "slips begin above F_s, which is of contacts as they start, with different stretches: after a slip all start "
        "again at x = 0, and break more nearly together"
    ]


def _by_inertia(own: Answer) -> list[str]:
    """That the first slip of a mass begins above F_s by what the spring needs to make the mass as fast as its drive;
    none where it does not, or by more."""
    if own.machine is None or own.machine.mass is None:
        return []
    forces = own.behaviours[0].in_time.first_forces
    if forces is None:
        return []
    machine, static, force = damped(own), own.static.value, own.scale.force
    lag, borne = (
        machine.velocity * np.sqrt(machine.spring * own.machine.mass),
        machine.damping * machine.velocity,
    )
    above = forces[0] - static
    if not ABOVE_STATIC * static < above <= MORE * (lag + borne):
        return []
    each = (written(one * force, own.scale.force_unit, digits=2) for one in (above, lag, borne))
    more, most, bears = each
    damping = f", and by {bears} for the damping" * bool(borne)
    return [
        f"the first slip begins {more} above F_s: until the mass is as fast as its drive the spring pulls by up to "
        f"v (K M)^(1/2) = {most} more{damping}; a fall of that size is a swing "
        "of the mass"
    ]


def _why_above(contacts: Contacts) -> str:
    """Why contacts on which time acts hold a slider that sticks to more than F_s."""
    if not contacts.in_time:
        return "heat, which lowers F_s, is left out of the slips"
    if set(contacts.held_in_time) - {"thermal"}:
        return "contacts grow stronger while one sticks"
    if contacts.thermal is not None:
        return (
            "heat breaks weak contacts while one sticks, and those that hold until the slip are "
            "mostly strong"
        )
    return "all contacts hold one that sticks, and some wait where it slides"
