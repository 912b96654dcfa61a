"""Sliders on the border at which steady sliding begins to swing: chance decides whether their swings count as slips."""

import numpy as np

from origins.drive import RISE
from toolkit.scene.scale import told_contacts, written
from toolkit.verdict.answers import Verdict
from toolkit.verdict.sliders.machine import Machine
from toolkit.verdict.sliders.records import Finite
from toolkit.verdict.sliders.steady import friction_falls
from toolkit.verdict.text.kinds import damped

# times the least fall that counts as a slip, up to which chance decides whether falls do; and times friction's fall
# with the speed that damping is at most on the border, or the other way round: beyond it swings die out, or grow
NEAR, ALIKE = 3.0, 2.0


def on_the_border(verdict: Verdict) -> list[str]:
    """That chance decides between small slips and sliding, with what the damping and friction's fall are.

    A swing whose force is the least that counts as a slip, s = RISE <x_s>, has the speed V = s/(K M)^(1/2). Damping
    takes γ V there, and friction gives V times its fall with the speed; N contacts bear F_k only to F_k N^(-1/2), by
    chance. Where the former differ by less than that, and slips are as small, the slider is on the border.
    """
    own, machine = verdict.own, verdict.own.machine
    if machine is None or not machine.mass or not own.contacts.waiting_time:
        return []
    machine = damped(own)
    few = [one for one in verdict.finite if one.rule == "mass" and one.kind != "unknown"]
    if not few or not _is_near(few[0], machine, verdict):
        return []
    each = friction_falls(machine, own.contacts), machine.damping
    falls, rises = (f"{one * own.scale.spring:.3g} {own.scale.damping_unit}" for one in each)
    least = written(RISE * own.contacts.mean_threshold * own.scale.force, own.scale.force_unit)
    return [
        f"on the border: friction falls with the speed by {falls}, the damping is {rises}, and by chance the force of "
        f"{told_contacts(few[0].contacts)} falls by {least} or more, which counts as a slip, or by less"
    ]


def _is_near(few: Finite, machine: Machine, verdict: Verdict) -> bool:
    """Whether these contacts slip by little, or slide, where damping and friction's fall differ by less than chance."""
    own, mean = verdict.own, verdict.own.contacts.mean_threshold
    # slips before those that slide are of the start, and may be of any size
    if few.kind != "smooth" and few.before - few.after > NEAR * RISE * mean:
        return False
    speed = RISE * mean / np.sqrt(machine.spring * (machine.mass or np.inf))
    low, high = sorted((machine.damping, friction_falls(machine, own.contacts)))
    by_chance = own.kinetic.value / np.sqrt(few.contacts)
    return bool(high < ALIKE * low and (high - low) * speed < by_chance)
