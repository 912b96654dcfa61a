"""Sliders whose slip from F_s is so long that their contacts have forgotten their start when it ends."""

import numpy as np

from origins.contacts import Contacts
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour

# lengths of memory, beyond that of ln(1/K), after which what is left of F - F_k is rounding, e^-30; and the largest
# spring, in N_c<k>, of which this is told: its slider has moved by K of its drive's way when it slips
FORGOTTEN, SOFTEST = 30.0, 1e-3


def forgets_its_start(machine: Machine, contacts: Contacts, rigid: RigidSlider) -> bool:
    """Whether the slip from F_s is so long that the contacts have forgotten their start when it ends.

    Without laws in time F of contacts that re-form at once hangs on the slider's position alone, and tends to F_k: a
    spring that falls from F_s lets the slider go on by (F_s - F_k)/K, over which F - F_k decays. F falls nowhere as
    steeply as K then, and no slip follows. Exact thresholds may keep their order, and are not told of.
    """
    if contacts.in_time or contacts.reforming is not None or contacts.thresholds.atoms[0].size:
        return False
    distance = (rigid.static - rigid.kinetic) / machine.spring
    needed = FORGOTTEN + np.log(1.0 / machine.spring)
    return machine.spring < SOFTEST and distance > needed * rigid.memory


def after_forgetting(
    machine: Machine, contacts: Contacts, rigid: RigidSlider, found: Behaviour
) -> Behaviour:
    """Sliding at F_k after the slip from F_s; its error is that of F_k, and of the slider's way up to F_s."""
    mean, begin = contacts.mean_threshold, contacts.start.mean()
    slip = rigid.static / machine.spring
    distance = (rigid.static - rigid.kinetic) / machine.spring / mean
    # what is known of smaller slips on the way up to F_s, as that they shrink, tells nothing of the one from there
    told = Behaviour(
        rule=found.rule,
        kind="smooth",
        before=rigid.kinetic,
        after=rigid.kinetic,
        period=None,
        slips=1,
        error=rigid.kinetic_error / mean + machine.spring,
        success=True,
        message=f"its slip from F_s goes on for {distance:.1e} mean thresholds, after which the contacts have "
        "forgotten their start and F is F_k; smaller slips before it were not followed",
        drive=np.array([begin / machine.spring, slip, slip, 2.0 * slip]),
        force=np.array([begin, rigid.static, rigid.kinetic, rigid.kinetic]),
        run_time=found.run_time,
    )
    return told.in_place_of(found)
