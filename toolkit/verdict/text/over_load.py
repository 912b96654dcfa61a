"""Why friction over the load is not half of the coefficient of one contact."""

from origins.roughness.interface import Interface
from toolkit.scene.scale import written
from toolkit.verdict.answers import Verdict

# of half of the breaking forces: by more than that F_k differs from it, and the page says why
_APART = 0.01


def of_spread(verdict: Verdict) -> list[str]:
    """How far F_k of a rough surface is from half of all breaking forces, which contacts of one threshold would bear on
    average, in a sentence below the table; none where thresholds hardly change it, where k is linked to the threshold,
    which has a line of its own, and where time acts on the contacts."""
    own = verdict.own
    surface = own.contacts.thresholds.interface
    if not isinstance(surface, Interface) or own.contacts.in_time:
        return []
    if own.contacts.stiffness == "linked":
        return []
    half = surface.contact_density * surface.mean_force_threshold / (2.0 * surface.pressure)
    over = surface.friction_coefficient / half
    if abs(over - 1.0) < _APART:
        return []
    law = own.contacts.thresholds
    if_linked = law.moment(3) / law.mean() / law.moment(2)
    return [
        f"F_k/load is {over:.2f} times half of all breaking forces, {written(half, '')} of the load: strong contacts "
        "hold over a longer way than weak ones, and each contact has the mean stiffness <k>, whatever its threshold; "
        'if strong contacts are stiffer in proportion, contacts.stiffness = "linked", '
        f"F_k is {if_linked:.2f} times this"
    ]
