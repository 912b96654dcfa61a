"""Rate and state of a scene as one page: a table of the numbers, how well the law holds, and springs."""

from collections.abc import Iterator

import numpy as np

from master.rate_state.result import CONSTANT, Parameter, RateState
from toolkit.rate_state.judge import Judged
from toolkit.scene.scale import spoken, with_uncertainty, written
from toolkit.verdict.text.table import in_columns

# of a number: a larger numerical error stands beside it
RELATIVE = 0.01


def page(judged: Judged) -> list[str]:
    """Title, table, and what the law misses, each in a sentence."""
    found, scale = judged.found, judged.scale
    up = found.steps[0]
    speeds = [spoken(speed, scale.speed_unit) for speed in (up.before, up.after)]
    said = f"Rate and state at {spoken(found.velocity, scale.speed_unit)}, from steps between {' and '.join(speeds)}"
    lines = [judged.title, "", said, "", *table(judged), "", *_of_readings(found), ""]
    lines += [*_of_law(judged), *_of_rests(judged), *_of_springs(judged)]
    if not found.success:
        lines.append(f"not as asked: {found.message}")
    return [*lines, "", f"run time {found.run_time:.1f} s"]


def table(judged: Judged) -> list[str]:
    """Each number, its part of the load, how far other readings of the same answers are, and where it is constant."""
    load = judged.scale.load is not None
    head = ["", "value", *(["over the load"] * load), "other readings"]
    rows = [[*head, f"constant within {CONSTANT:.0%}"], *_rows(judged)]
    return in_columns(rows)


def _of_readings(found: RateState) -> list[str]:
    """What the numbers are, and what stands behind their "±", which is no numerical error."""
    named = {"a": found.a, "b": found.b, "a - b": found.a_minus_b, "D_c": found.slip_distance}
    own = [
        f"{name} {one.error / abs(one.value):.1g}"
        for name, one in named.items()
        if one.value and one.known
    ]
    return [
        "a: first maximum after a step; b: a less the change of F_k; D_c: of the law nearest to the force after it",
        "±: how far other readings of the same answers are; numerical errors, parts of the number: "
        + (", ".join(own) or "not known"),
    ]


def _rows(judged: Judged) -> Iterator[list[str]]:
    """The rows of the table below its head."""
    found, scale = judged.found, judged.scale
    force = scale.force_unit
    kinetic, error = found.kinetic_force * scale.force, found.kinetic_force_error * scale.force
    own = _over_load(judged, found.kinetic_force)
    yield ["kinetic friction F_k", written(kinetic, force, error, 4), *own, "", ""]
    named = {
        "direct effect a": found.a,
        "evolution effect b": found.b,
        "a - b = dF_k/d ln v": found.a_minus_b,
    }
    for name, number in named.items():
        load = _over_load(judged, number.value)
        yield [name, *_cells(number, force, scale.force, load), _span(number, judged)]
    distance = found.slip_distance
    blank = [""] * len(own)
    yield [
        "slip distance D_c",
        *_cells(distance, scale.length_unit, 1.0, blank),
        _span(distance, judged),
    ]
    if (healing := found.healing) is not None:
        ends = [spoken(end, scale.time_unit) for end in (healing.low, healing.high)]
        rests = f"rests of {' to '.join(ends)}"
        load = _over_load(judged, healing.value)
        rests *= healing.known
        yield ["healing, a decade of rest", *_cells(healing, force, scale.force, load), rests]


def _cells(number: Parameter, unit: str, factor: float, load: list[str]) -> list[str]:
    """A number with its numerical error where that is not small, its part of the `load`, and how far other readings
    are, in a unit; none of them where the error is larger than the number."""
    if not number.known:
        return ["not known", *("" for _ in load), ""]
    value, error = number.value * factor, number.error * factor
    said = written(value, unit, error)
    if error > RELATIVE * abs(value) > 0.0:
        said = with_uncertainty(value, error, unit, digits=3)
    other = f"± {written(number.definition * factor, unit, digits=2)}"
    return [said, *load, other * bool(np.isfinite(number.definition))]


def _over_load(judged: Judged, force: float) -> list[str]:
    """A force as a coefficient; nothing where there is no load."""
    load = judged.scale.load
    return [] if load is None else [f"{force * judged.scale.force / load:.3g}"]


def _span(number: Parameter, judged: Judged) -> str:
    """The speeds between which a number is constant; "below" and "above" those at which it was not looked at."""
    unit, speeds = judged.scale.speed_unit, judged.found.scan.velocity
    if not number.known:
        return ""
    if number.low == number.high:
        return f"at {spoken(judged.found.velocity, unit)} alone"
    below = "below " if number.low <= speeds[0] else ""
    above = "above " if number.high >= speeds[-1] else ""
    return f"{below}{spoken(number.low, unit)} to {above}{spoken(number.high, unit)}"


def _of_law(judged: Judged) -> Iterator[str]:
    """How far the law is from the solved force, and where."""
    found, unit = judged.found, judged.scale.length_unit
    if not np.isfinite(found.slip_distance.value):
        return
    larger = "a" if abs(found.a.value) >= abs(found.b.value) else "b"
    slip = found.misfit.slip
    after = f"{spoken(slip, unit)} after a step" if slip else "at the step"
    yield (
        f"The {found.law.evolution} law with these numbers is off by at most {found.misfit.share:.0%} of {larger}, "
        f"{after}:"
    )
    if not found.direct_slip:
        yield "the force does not rise at first, so that a is 0, and does not evolve as one exponential."
        return
    later = found.misfit_later
    slip = found.direct_slip / judged.mean_threshold
    yield (
        f"it has the direct effect at once, which takes contacts a slip of {spoken(found.direct_slip, unit)}, "
        f"{slip:.2g} <x_s>; beyond, it is off by at most {later.share:.0%}, {spoken(later.slip, unit)} after a step."
    )


def _of_rests(judged: Judged) -> Iterator[str]:
    """How the law's rise after a rest differs from the solved one."""
    found, scale = judged.found, judged.scale
    if not found.rests or not np.isfinite(found.slip_distance.value):
        return
    rises = np.array([one.peak for one in found.rests]) - found.kinetic_force
    law = found.law_rests - found.kinetic_force
    top = int(np.argmax(rises))
    forces = [written(each * scale.force, scale.force_unit) for each in (rises[top], law[top])]
    yield (
        f"After a rest of {spoken(found.rests[top].time, scale.time_unit)} the force rises to {forces[0]} above F_k, "
        f"by the ageing law to {forces[1]}."
    )
    if rises[-1] < 0.99 * rises[top]:
        yield "After longer rests it rises to less: contacts that break at rest form again relaxed."


def _of_springs(judged: Judged) -> Iterator[str]:
    """Three critical springs: of the law, of the solved answer, and from the start."""
    found, scale = judged.found, judged.scale

    def spring(value: float, error: float) -> str:
        """Where it is unstable, by a critical spring K/(N_c <k>) and its error."""
        if not np.isfinite(error) or error > abs(value) > 0.0:
            return "on springs that are not known"
        if not value:
            return "on no spring"
        value, error = value * scale.spring, error * scale.spring
        if error > RELATIVE * value:
            return f"on springs softer than {with_uncertainty(value, error, scale.spring_unit, 3)}"
        return f"on springs softer than {written(value, scale.spring_unit)}"

    by_law = spring(found.critical_spring, found.critical_spring_error)
    solved = spring(found.critical_spring_solved, found.critical_spring_solved_error)
    yield f"Smooth sliding is unstable {solved}, by the solved answer to a small step; {by_law}, by (b - a)/D_c."
    if "not known" in solved and "not known" in by_law:
        yield (
            "Of contacts in heat, `mesofriction verdict` of the scene with a drive.spring tells, without steps, below "
            "which spring small swings of steady sliding grow."
        )
    if np.isnan(judged.critical_spring) or not judged.critical_spring:
        return
    own = spring(judged.critical_spring, judged.critical_spring_error)
    falls = f"From the scene's start the force of a rigid slider falls faster than the spring's {own}, K*"
    yield f"{falls}: there a slider may slip once, or creep on."
