"""K* in words: what it tells of a slider, and below which spring one without a machine slips."""

import numpy as np

from toolkit.scene.scale import prefixed_like, told_contacts
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.sliders.budget import NO_FORCES
from toolkit.verdict.uncertainty import two_digits, writer_of_springs

# N K³, K in N_c<k>, above which sliding on springs stiffer than K* is smooth (docs/sliders.md)
SMOOTH_ABOVE = 50.0


def of_critical_spring(own: Answer) -> str:
    """What K* tells of the machine's slider."""
    # one that sticks is slower than the drive: of contacts that depend on time K* promises no slip
    if own.contacts.in_time:
        return "K*, the steepest fall of the force"
    # nor with a mass, whose slip hangs on more
    if own.machine is not None and own.machine.mass:
        return "balance unstable somewhere on springs below K*"
    return "slips at least once below the spring K*"


def of_chance(own: Answer) -> tuple[str, str] | None:
    """How many contacts the area holds, and up to about which spring, above K*, so many may slip by chance, as written:
    up to N K³ = SMOOTH_ABOVE. None where their number is not known, where that is below K*, and where time acts on the
    contacts, of which the rule tells nothing."""
    number, critical = own.scale.contacts, own.critical_spring
    if number is None or own.contacts.in_time or critical.unknown or critical.lost:
        return None
    stiffest = (SMOOTH_ABOVE / number) ** (1.0 / 3.0)
    if stiffest <= critical.value:
        return None
    return told_contacts(number), two_digits(stiffest * own.scale.spring, own.scale.spring_unit)


def without_spring(verdict: Verdict) -> str:
    """Below which spring the interface slips, over all readings."""
    if verdict.own.smoothed:
        return (
            "slips on springs softer than K*, which is not known: it hangs on the smoothing of P_c of these islands; "
            "give drive.spring for a verdict on a machine"
        )
    if verdict.own.critical_spring.unknown:
        return NO_FORCES
    if verdict.own.critical_spring.lost:
        return (
            "slips on springs softer than K*, which is not known: its numerical error is as large as itself; give "
            "drive.spring for a verdict on a machine"
        )
    with_spring = [answer for answer in verdict.answers if not answer.critical_spring.lost]
    springs = [answer.critical_spring.value * answer.scale.spring for answer in with_spring]
    own, unit, spread = springs[0], verdict.own.scale.spring_unit, max(springs) - min(springs)
    if not np.isfinite(spread):
        spread = 0.0
    sampling = (verdict.own.critical_spring.sampling or 0.0) * verdict.own.scale.spring
    # as in the table
    spread = max(spread, sampling, verdict.own.critical_spring.error * verdict.own.scale.spring)
    # of contacts that depend on time a slider may creep on softer springs, and slide smoothly
    whose = (
        "the force of a rigid slider falls most steeply at" if verdict.own.contacts.in_time else ""
    )
    to_digits = writer_of_springs(verdict.own)
    said = f"{whose or 'slips at least once on a spring softer than'} K* = {to_digits(own, unit, spread)}"
    if np.isinf(own):
        said = (
            "the force of a rigid slider falls at one place"
            if whose
            else "slips at least once on every spring"
        )
        said += ", as K* is infinite"
    if sampling >= own:
        said += f" ± {prefixed_like(sampling, own, unit)} by other samples, which may slip"
    if len(springs) > 1:
        ends = {to_digits(one, unit, spread): one for one in (min(springs), max(springs))}
        over = f"from {' to '.join(ends)}" if len(ends) > 1 else "the same"
        said += f" ({over} over {len(springs)} readings)"
    ask = "give drive.spring for a verdict on a machine"
    if whose:
        return f"{said}; on a softer spring a slider may slip, or creep and slide smoothly; {ask}"
    if chance := of_chance(verdict.own):
        number, stiffest = chance
        said += f", if contacts are infinitely many; the {number} of the area may slip by chance "
        said += f"on stiffer ones, too, up to some {stiffest}"
    return (
        f"{said}; whether slips go on hangs on mass, damping and delay, or on the slip rule: {ask}"
    )
