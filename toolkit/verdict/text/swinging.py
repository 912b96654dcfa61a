"""Between which delays of its contacts a slider with mass swings or slips, as friction falls with the speed."""

import numpy as np

from toolkit.scene.scale import spoken
from toolkit.verdict.answers import Answer
from toolkit.verdict.sliders.steady import unstable_delays
from toolkit.verdict.text.kinds import damped

# part by which heat changes F_k, above which friction without heat tells nothing of it
HEAT_MATTERS = 0.1


def unstable_of(own: Answer) -> tuple[float, float] | None:
    """See `unstable_delays`, of the own reading with the damping that it was followed with; None, too, where heat
    changes friction much."""
    if own.machine is None:
        return None
    if own.cold and abs(own.kinetic.value - own.cold.value) > HEAT_MATTERS * own.cold.value:
        return None
    return unstable_delays(damped(own), own.contacts)


def among_them(own: Answer) -> bool:
    """Whether the own delay is an unstable one."""
    band = unstable_of(own)
    return band is not None and band[0] < own.contacts.waiting_time < band[1]


def swinging_delays(own: Answer, longest: float = np.inf) -> str:
    """Between which delays of the contacts, up to the `longest`, friction falls with the speed by more than the damping
    rises, in words; "" where there are none, and where that decides nothing."""
    band = unstable_of(own)
    if band is None:
        return ""
    low, high = band[0], min(band[1], longest)
    unit, cold = own.scale.time_unit, "without heat, " * (own.contacts.thermal is not None)
    if np.isinf(high):
        return f"{cold}with any delay"
    if not low:
        return f"{cold}with a delay of up to {spoken(high, unit)}"
    return f"{cold}with a delay between {spoken(low, unit)} and {spoken(high, unit)}"


def of_swings(own: Answer, longest: float = np.inf) -> str:
    """What a slider does with such delays, in a sentence that follows another one; "" where there are none."""
    between = swinging_delays(own, longest)
    if not between:
        return ""
    among = among_them(own)
    # a slider that sticks first slips from F_s, which the fall of friction about a steady speed does not end
    slides = own.behaviours[0].kind == "smooth" and bool(own.contacts.waiting_time) and not among
    longer = "; with somewhat longer ones it may go on to slip once it has begun" * (not slides)
    said = (
        f"{between[0].upper()}{between[1:]}{', as with this one,' * among} friction falls with the speed by more than "
        f"the damping rises, so that the slider swings or slips{longer * ('between' in between)}"
    )
    return f". {said}{' (not followed)' * (not among)}"
