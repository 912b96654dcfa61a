"""What stands beside the answer: how far its forces reach over the readings, and what other samples would change."""

from origins.roughness.interface import Interface
from origins.samples.from_samples import sampled_parts
from toolkit.running.resampled import RATHER_LARGE, known_to
from toolkit.scene.scale import prefixed_like, written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.of_area import finite_told_apart
from toolkit.verdict.sliders.budget import HOW_TO_GIVE_MORE_TIME
from toolkit.verdict.uncertainty import (
    WORTH_TELLING,
    is_vague,
    to_digits,
    uncertainties_of,
    widest_uncertainty,
)


def widest(verdict: Verdict) -> list[str]:
    """The widest uncertainty of the forces in words, where it is not the numerical error, which stands beside them."""
    uncertainties, own = uncertainties_of(verdict), verdict.own
    scale, widest_one = own.scale, max(uncertainties)
    if widest_one < WORTH_TELLING or widest_one == uncertainties.numerical:
        return []
    if uncertainties.sampling > uncertainties.readings:
        slips = any(one.kind == "stick-slip" for one in own.behaviours)
        told = own.static if slips and own.static.sampling else own.kinetic
        each = ((told.sampling or 0.0) * scale.force, told.value * scale.force)
        error = prefixed_like(*each, scale.force_unit)
        force = "F_k" if told is own.kinetic else "F_s"
        whose = " of a rigid slider" * bool(own.contacts.in_time and own.machine)
        return [f"other samples would change {force}{whose} by ± {error}"]
    return [range_of_force(verdict, f" of the {len(verdict.answers)} readings")]


def range_of_force(verdict: Verdict, whose: str = "") -> str:
    """F_k over all readings, whose they are, from the least to the largest; where contacts depend on time, and stick
    and slip, the force before a slip of readings that do under a rule that decides the own one, if there are several,
    as F_k is that of a rigid slider as fast as the drive. Beside slips of the area's contacts it says that it is of
    infinitely many, and has no more digits than these."""
    scale, uncertainty, answers = verdict.own.scale, widest_uncertainty(verdict), verdict.answers
    forces = [(one.kinetic.value * one.scale.force, 0.0) for one in answers]
    what, off, befores = f"F_k{whose}", 0.0, list[list[tuple[float, float]]]()
    rules = {each.rule for each in verdict.own.behaviours if each.kind != "undecided"}
    for one in answers:
        unit = one.scale.force
        slips = [each for each in one.behaviours if each.kind == "stick-slip"]
        slipping = [each for each in slips if each.rule in rules]
        errors = (each.error * one.contacts.mean_threshold * unit for each in slipping)
        befores.append(
            list(zip((abs(each.before) * unit for each in slipping), errors, strict=True))
        )
    slip = sum(map(bool, befores))
    if verdict.own.contacts.in_time and befores[0] and slip > 1:
        off = _error_of_area(verdict) * scale.force
        forces = [one for each in befores for one in each]
        whom = " with infinitely many contacts" * bool(off)
        by = f"all {slip}" if slip == len(answers) else f"the {slip} of {len(answers)}"
        what = f"the force before a slip{whom} over {by} readings{' that slip' * (slip < len(answers))}"
    # each to the digit of its own error, or that of the answer, where that is the wider one
    ends = (
        to_digits(force, scale.force_unit, uncertainty * force, max(error, off), is_vague(verdict))
        for force, error in (min(forces), max(forces))
    )
    said = f"{what} is {' to '.join(dict.fromkeys(ends))}"
    # readings between both ends may be known less well, as of a few contacts that stand for many
    force, error = max(forces, key=lambda one: one[1])
    (low, _), (high, _) = min(forces), max(forces)
    if error > max(high - low, WORTH_TELLING * force):  # which are no ends of a range
        low, high = min(max(f - e, 0.0) for f, e in forces), max(f + e for f, e in forces)
        each = (written(end, scale.force_unit, digits=2) for end in (low, high))
        return f"{what} is {' to '.join(each)}, with the error of each"
    if error > WORTH_TELLING * force:
        said += f", with errors of up to {prefixed_like(error, force, scale.force_unit)}"
    return said


def _error_of_area(verdict: Verdict) -> float:
    """The error of the force before a slip of the area's contacts, F/(N_c <k>) (a length), where the answer is theirs,
    and that of all readings infinitely many's; else 0."""
    if any(one.contacts is not None for each in verdict.answers for one in each.behaviours):
        return 0.0
    slips = [one for one in finite_told_apart(verdict).values() if one.kind == "stick-slip"]
    return max((one.before_error for one in slips), default=0.0)


def other_samples(verdict: Verdict) -> list[str]:
    """What the column of other samples holds, and where nothing is known of them, why; none of a law that is given."""
    law = verdict.own.contacts.thresholds
    if drawn := sum(part.n_samples for part in sampled_parts(law)):
        if verdict.own.kinetic.sampling:
            return [f"other samples: one standard error, {_by_which_road(verdict.own, drawn)}"]
        if verdict.stopped is not None:
            return [f"other samples: interrupted before the {drawn:,} thresholds were resampled"]
        return [
            f"other samples: no time was left to resample the {drawn:,} thresholds; {HOW_TO_GIVE_MORE_TIME}"
        ]
    if isinstance(law.interface, Interface):
        said = "other samples: one surface is one sample (n = 1), which tells nothing of others"
        return [said + _of_the_scan(verdict)]
    return []


def _by_which_road(own: Answer, drawn: int) -> str:
    """Whether the errors of other samples are of moments, or of how many resamplings, and how well these know them."""
    if not (count := max(own.kinetic.resampled, own.static.resampled)):
        return f"by the moments of the {drawn:,} thresholds"
    how = f"by {count} resamplings of the {drawn:,} thresholds, known to ± {known_to(count):.0%}"
    whole = how if own.kinetic.resampled else f"of F_k by moments, else {how}"
    return f"{whole}; {RATHER_LARGE}"


def _of_the_scan(verdict: Verdict) -> str:
    """How few contacts the scan itself holds, by which their number differs from patch to patch; "" without a scan."""
    found = list[float]()
    for one in verdict.answers:
        surface = one.contacts.interface
        if isinstance(surface, Interface) and surface.moments.size is not None:
            found.append(
                surface.contact_density * surface.moments.size[0] * surface.moments.size[1]
            )
    if not found:
        return ""
    ends = dict.fromkeys(written(one, "", digits=2) for one in (min(found), max(found)))
    chance = 100.0 * found[0] ** -0.5
    return (
        f"; the scan itself would hold some {' to '.join(ends)} contacts, and by chance a patch of its size holds "
        f"{chance:.2g}% more or fewer"
    )
