"""What is asked of laws of one's own under a spring, and what steps resolve there."""

import numpy as np

from master.motion import Motion
from master.soft.in_time.memory import Scales, scales_of
from master.survival.make import why_no_life
from origins import Contacts, InputError

# Births change over this many of the narrowest widths of P_c; and first step of a hold, in the time of the whole drive,
# or in that in which it moves by so much, whichever is less.
WIDTHS_OF_BIRTHS, FIRST = 2.0, 0.05


def refuse_without_life(contacts: Contacts) -> None:
    """InputError where a law has no life on a slider that changes its speed."""
    if refusal := why_no_life(contacts, one_leg=False):
        raise InputError(f"{refusal} (on a spring the slider's speed changes)")


def scales_along(contacts: Contacts, motion: Motion | None) -> Scales:
    """What steps resolve where nothing tells over what time the thresholds of a law of one's own change."""
    length = WIDTHS_OF_BIRTHS * scales_of(contacts).length
    if motion is None:
        return Scales(length)
    fastest = float(np.abs(motion.speeds).max())
    return Scales(
        length, FIRST * min(float(motion.times[-1]), length / fastest if fastest else np.inf)
    )
