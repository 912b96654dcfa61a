"""What a verdict on a slider with mass hangs on: its damping, and how it swings."""

from collections.abc import Iterator

import numpy as np

from toolkit.scene.scale import spoken, written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.sliders.follow import DAMPED, SETTLED_IN, STILL_SWINGS
from toolkit.verdict.sliders.late import EVER_RARER
from toolkit.verdict.sliders.machine import critical_damping, half_a_swing
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.sliders.steady import friction_decides, friction_falls, time_constant
from toolkit.verdict.text.kinds import GENERAL, UNSIZED, Line, damped
from toolkit.verdict.text.slip_rows import drop_of, regained_by


def of_a_mass(verdict: Verdict) -> Iterator[Line]:
    """The damping that was taken, where none is given; and the swing after a slip."""
    own = verdict.own
    unit = own.scale.damping_unit
    for behaviour in own.behaviours:
        if behaviour.damping is not None and own.machine is not None:
            part = behaviour.damping / critical_damping(own.machine)
            yield Line(
                UNSIZED,
                f"the damping: none is given, and without one{_or_with_little(part)} the slider rings for too long: "
                f"give drive.damping, the machine's own{_of_too_little(own, behaviour.damping)}",
                ". The assumed one is no property of the machine. With less the force falls farther in a slip, and the "
                "slider rings longer; F_k and F_s are the same",
            )
        if behaviour.kind == EVER_RARER and own.machine is not None:
            each = friction_falls(own.machine, own.contacts), own.machine.damping
            falls, rises = (f"{one * own.scale.spring:.3g} {unit}" for one in each)
            said = f"friction falls with the speed by {falls}, and the damping is {rises}"
            yield Line(
                GENERAL,
                f"steady sliding is stable against slow changes of the speed: {said}; contacts that broke together draw"
                " apart. Whether quick swings of the mass stay, far smaller than slips, is not looked at",
            )
        if (regained := regained_by(verdict, behaviour)) is not None:
            drop, force = drop_of(behaviour) * own.scale.force, own.scale.force_unit
            back = drop - (remaining := regained * own.scale.force)
            yield Line(
                GENERAL,
                "the slider rings after a slip, while its contacts are out: the spring regains less than the drop",
                f". Of that, {written(drop, force)}, it swings back by {written(back, force)} before it sticks, and "
                f"the period is that of the other {written(remaining, force)}",
            )


def why_no_more_slips(own: Answer) -> str:
    """Why a slider on a spring softer than K* slips no more."""
    machine, delay, force = own.machine, own.contacts.delay, own.scale.force
    if machine is not None and machine.mass is not None:
        borne = machine.damping * machine.velocity
        if borne > own.static.value - own.kinetic.value > 0.0:
            return f"as the damping bears {written(borne * force, own.scale.force_unit)} at the drive's speed"
        loaded = own.static.value / machine.spring
        if delay is not None and delay.time * machine.velocity > loaded:
            return "as contacts wait on a longer way of the drive than they would need to load the spring to F_s"
    return "as contacts have forgotten their start"


def _or_with_little(part: float) -> str:
    """The part of critical damping that was tried before the one that was taken, see DAMPED; "" for the first one."""
    return ", or with a tenth of critical damping," * (part > 0.5 * (min(DAMPED) + max(DAMPED)))


def _of_too_little(own: Answer, damping: float) -> str:
    """Below which damping steady sliding with the given delay is unstable; "" where there is none, and where friction
    decides nothing."""
    if own.machine is None or not friction_decides(own.machine, own.contacts):
        return ""
    falls = friction_falls(own.machine, own.contacts)
    if not falls:
        return ""
    cold = ", without heat," * (own.contacts.thermal is not None)
    least = (
        f"{falls * own.scale.spring:.3g} {own.scale.damping_unit}{', as here,' * (damping < falls)}"
    )
    return (
        f". Below {least} friction of contacts with this delay{cold} falls with the speed by more than the damping "
        "rises: steady sliding is unstable"
    )


def of_a_swing(answer: Answer, slider: Behaviour) -> str:
    """By how much a slider that is not decided still swings where its path ends, how long a swing takes, in which time
    it dies away, and what ends it sooner; "" of others."""
    if slider.message != STILL_SWINGS or not slider.drive.size:
        return ""
    machine, scale = damped(answer), answer.scale
    late = slider.drive >= slider.drive[-1] - slider.drive[-1] / SETTLED_IN
    size = written(np.ptp(slider.force[late]) * scale.force, scale.force_unit, digits=2)
    each, lasts = 2.0 * half_a_swing(machine), time_constant(machine)
    each_text, lasts_text = (spoken(one, scale.time_unit) for one in (each, lasts))
    return (
        f", by {size}: a swing takes {each_text}, and dies away by a factor e in {lasts_text}, so that a larger "
        "drive.damping, or a smaller drive.mass, would tell"
    )
