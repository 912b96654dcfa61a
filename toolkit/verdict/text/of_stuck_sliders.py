"""Why sliders that stick bear other forces than the rigid one of the table, where time acts on their contacts."""

from collections.abc import Iterator

from toolkit.scene.scale import written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.text.above_static import why_above
from toolkit.verdict.text.kinds import GENERAL, UNSIZED, Line
from toolkit.verdict.text.table import HOLDING


def of_a_stuck_slider(verdict: Verdict) -> Iterator[Line]:
    """Why the table's forces are not those of the slips."""
    own = verdict.own
    if own.machine is None or not own.contacts.in_time:
        return
    static, slipping = own.static.value, [one for one in own.behaviours if one.slips]
    # names of the table's rows say it, and a sentence below it of forces before a slip
    above = not slipping or bool(why_above(verdict))
    apart = max((abs(abs(one.before) - static) for one in slipping), default=0.0) / static
    yield Line(
        UNSIZED if own.static.unknown else apart,
        "F_s, F_k and K* of the table are those of a rigid slider as fast as the drive: what a stuck slider reaches "
        "is the force before a slip",
        ". One that sticks is slower, and contacts that wait, break by heat or age bear another force"
        + _of_waiting(own),
        above=above,
    )
    if own.contacts.changing is not None:
        yield Line(
            GENERAL,
            "K* is where the force of new contacts falls most steeply. On which springs steady sliding of contacts "
            "that have grown stronger is unstable, `mesofriction rate-state` tells (the critical spring)",
        )


def _of_waiting(own: Answer) -> str:
    """Why F_k of contacts that wait is smaller than without a delay."""
    if own.holding > HOLDING:
        return ""
    scale = own.scale
    waits = (own.machine.velocity if own.machine else 0.0) * own.contacts.waiting_time
    holds = waits * own.holding / (1.0 - own.holding)  # on average, also where heat or age act
    each = (written(one, scale.length_unit) for one in (waits, holds))
    return (
        ". F_k is smaller than without a delay, as a contact waits while the drive goes on by {}, and holds while it "
        "goes on by {}: {:.2g}% of them hold".format(*each, 100.0 * own.holding)
    )


def above_critical_spring(verdict: Verdict) -> Iterator[Line]:
    """Why a slider on whose contacts time acts slips on a spring above K* of the table."""
    own = verdict.own
    speed = own.scale.speed(verdict.velocity)
    late = own.critical_spring.unknown or own.critical_spring.lost
    slips = any(one.kind == "stick-slip" for one in own.behaviours)
    if not (slips and own.contacts.in_time and own.machine) or late or own.softer:
        return
    why = "one that sticks and slips has other speeds, and K* hangs on the speed"
    if own.contacts.waiting_time:
        why = "in a slip it is faster, and contacts that wait on a longer way let the force fall more steeply"
    yield Line(
        GENERAL,
        f"the slider slips on a spring above K* of the table, which is of one at {speed}: {why}",
    )
