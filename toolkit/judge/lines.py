"""The comparison of scenes as lines of text."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from toolkit.judge.compare import FORCES, SHOWN, SPRINGS, ComparedScene, common_unit
from toolkit.judge.describe import onset_in_words
from toolkit.scene.interfaces import Number
from toolkit.scene.scale import SHARED, guarded, with_error, written
from toolkit.verdict.answers import Quantity
from toolkit.verdict.text.table import in_columns, row
from toolkit.verdict.uncertainty import two_digits

# of a number: a larger error stands beside it
PRECISE = 1e-3
# heads of the columns, in the order of SHOWN and of the ensemble's evidence, and what each means
_HEADS = {
    "power m": "power m: P_c ~ x^m at small thresholds x",
    "K*/(N_c<k>)": "N_c<k>: stiffness of all contacts",
    "F_s/F_k": "F_s, F_k: static and kinetic friction",
    "X*/<x_s>": "X*: way on which contacts forget that they started together; <x_s>: mean threshold",
    "F_k/(N_c<k><x_s>)": "",
    "F_k/load": "F_k/load: by P_c alone",
}
_EVIDENCE = {
    "peak/F_k simulated": "peak/F_k: largest force on the path over F_k, by the ensemble (simulated) and by the "
    "master equation (solved)",
    "solved": "",
    "apart": "apart: by so many standard errors at most, about 3 by chance",
}


def table(compared: Sequence[ComparedScene]) -> list[str]:
    """The comparison as lines of text: where readings disagree on stick-slip, and whose order is not decided; each
    number to a digit beyond that which the widest of its uncertainties leaves, and below it how far it goes over the
    readings; then notes, and run times."""
    heads, unit, names = [*_HEADS], common_unit(compared), list(SHOWN)
    if unit != SHARED:
        heads += [f"K* ({unit})", f"F_k ({'N' if unit == 'N/m' else 'Pa'})"]
        names += [SPRINGS[unit], FORCES[unit]]
    heads += _EVIDENCE
    rows, notes = [["", "scene", *heads]], dict[str, list[str]]()
    for rank, scene in enumerate(compared, start=1):
        cells, ranges = _numbers_of(scene, names)
        rows.append([str(rank), scene.name, *cells, *_of_evidence(scene)])
        if len(scene.readings) > 1:
            rows.append(["", f"over {len(scene.readings)} readings", *ranges])
        for note in _notes_on(scene):
            notes.setdefault(note, []).append(scene.name)
    said = [f"{', '.join(whose)}: {note}" for note, whose in notes.items()]
    started = {one.name: one.result.asked.contacts.start for one in compared}
    if any(start != started[compared[0].name] for start in started.values()):
        names = [name for name, start in started.items() if start is not None]
        hint = "K* and F_s/F_k depend on it; compare scenes of one start"
        said.append(
            f"starts differ, and contacts of {', '.join(names)} do not start relaxed: {hint}"
        )
    if unit == "N/m³":
        said.append(
            "ranked by K* per nominal area (N/m³); give each drive.area, and K* is ranked in N/m of these areas"
        )
    # columns that no scene fills, as of an ensemble where none has one, are left out
    told = [at for at in range(len(rows[0])) if any(any(row[at : at + 1]) for row in rows[1:])]
    rows = [[row[at] for at in told if at < len(row)] for row in rows]
    head_names = rows[0]
    head, *lines = in_columns(rows, ">")
    first = [*disagreements(compared), *undecided_order(compared)]
    meant = (_HEADS | _EVIDENCE).get
    meanings = [meant(name) for name in head_names]
    said.insert(0, "; ".join(filter(None, [*_of_critical_spring(compared), *meanings])))
    said.append(f"run times: {', '.join(map(_run_times, compared))}")
    return [*first, head, "-" * len(head), *lines, *said]


def _numbers_of(scene: ComparedScene, names: Sequence[str]) -> tuple[list[str], list[str]]:
    """The numbers of these names of a scene, by its own reading and over all of them."""
    cells, ranges = list[str](), list[str]()
    for name in names:
        write = _writer_of(scene) if name in SPRINGS.values() else guarded
        value, over = _cells([one.numbers[name] for one in scene.readings], write)
        if name in SPRINGS.values() and any(one.unknown for one in scene.readings):
            value, over = _of_answered(scene, name)
        if name == "onset_power" and value:
            value = onset_in_words(scene.own.numbers[name], 4)
        cells.append(value)
        ranges.append(over)
    return cells, ranges


def _of_evidence(scene: ComparedScene) -> list[str]:
    """The largest force by the ensemble, by the master equation, and by how much they are apart; none without one."""
    if (seen := scene.evidence) is None:
        return []
    worst, expected, error = (
        seen[name] for name in ("worst_deviation", "expected", "static_to_kinetic_error")
    )
    return [
        with_error(seen["static_to_kinetic"], error, 6),
        "" if expected is None else written(expected, "", error, 6 if error else 3),
        "" if worst is None else f"{worst:.1f}",
    ]


def _notes_on(scene: ComparedScene) -> Iterator[str]:
    """Conditions and cautions of a scene, what is not compared or left out of it, and its readings."""
    yield from (*scene.conditions, *scene.cautions)
    if scene.evidence is not None and scene.evidence["not_compared"] is not None:
        why = scene.evidence["not_compared"]
        yield f"simulated and solved forces are not compared: {why}"
    for why in dict.fromkeys(scene.left_out.values()):
        names_of = [name for name, its in scene.left_out.items() if its == why]
        yield f"left out: {'; '.join(names_of)}: {why}"
    if (many := len(scene.readings)) > 1:
        names_of = sorted(one.name for one in scene.readings)
        what = "contact model/threshold law and step of the points"
        yield f"the {many} readings, {what}, are {'; '.join(names_of)}"


def _run_times(scene: ComparedScene) -> str:
    """How long a scene took, and its ensemble."""
    took = f"{scene.name} {scene.found.run_time:.2g} s"
    seen = scene.evidence
    return took if seen is None else f"{took} and its ensemble {seen['run_time']:.2g} s"


def _of_critical_spring(compared: Sequence[ComparedScene]) -> Iterator[str]:
    """What K* tells of these scenes' sliders."""
    # of contacts that depend on time a slider may creep on softer springs, and slide smoothly
    in_time = any(one.conditions for one in compared)
    yield f"K*: steepest fall of the force{' of a rigid slider' * in_time}"
    if not in_time:
        yield f"a slider{' without mass' * any(one.mass for one in compared)} on a softer spring slips at least once"
    if any(one.mass for one in compared):
        yield "with a mass the balance is unstable somewhere on a softer spring, and it slips or slides: see verdict"


def _writer_of(scene: ComparedScene) -> Callable[[float, str, float], str]:
    """How K* of a scene is written: of a scan with two digits, as in its verdict, as another patch or step may change
    it by orders of magnitude."""
    return two_digits if scene.of_a_scan else guarded


def _cells(each: Sequence[Number], write: Callable[[float, str, float], str]) -> tuple[str, str]:
    """A number by the scene's own reading, with its error where that is seen, and its range over all readings; `write`
    as `row` takes it."""
    own, quantities = each[0], [Quantity(one.value, one.error or 0.0) for one in each]
    _, value, _, ranges = row("", quantities, [1.0] * len(each), "", write=write)
    if quantities[0].error > PRECISE * abs(own.value):
        value = with_error(own.value, quantities[0].error, 4)
    return {"not known": ""}.get(value, value), ranges


def _of_answered(scene: ComparedScene, name: str) -> tuple[str, str]:
    """K*, and its range over the readings, where it is not known by some: these are in no range, and of the scene's own
    reading it is told below which value it is."""
    answered = [one.numbers[name] for one in scene.readings if not one.unknown]
    value, over = _cells(answered, _writer_of(scene)) if answered else ("", "not known")
    if scene.own.smoothed:
        value = "hangs on smoothing"
    elif scene.own.unknown:
        own, over = scene.own.numbers[name], value if len(answered) == 1 else over
        value = f"not known, below {own.value + (own.error or 0.0):.2g}"
    return value, over


def disagreements(compared: Sequence[ComparedScene]) -> list[str]:
    """A sentence for each scene whose readings disagree on stick-slip of its machine."""
    said = list[str]()
    for scene in compared:
        decided = [one for one in scene.readings if one.softer is not None]
        slip = [one.name for one in decided if one.softer]
        if 0 < len(slip) < len(decided) and scene.own.softer is not None:
            own = "slips" if scene.own.softer else "does not slip"
            whose = "a slider without mass" if scene.mass else "a slider"
            said.append(
                f"{scene.name}: readings disagree on stick-slip: on its spring {whose} slips by {len(slip)} of "
                f"{len(decided)} readings; by its own, {scene.own.name}, it {own}"
            )
    return said


def undecided_order(compared: Sequence[ComparedScene]) -> list[str]:
    """Scenes without a K*, and a sentence for those whose K* reach over one another, as far as readings and errors go:
    their rank tells nothing. Infinite ones are ranked by F_s/F_k."""
    unit, said, named = common_unit(compared), list[str](), set[str]()
    unranked = [one.name for one in compared if one.own.smoothed]
    if unranked:
        said.append(
            f"no rank by K* of {', '.join(unranked)}: it hangs on the smoothing of P_c, and is no number of the islands"
        )
    ends = {one.name: range_of_spring(one, unit) for one in compared if not one.own.smoothed}
    for name, (low, high) in ends.items():
        alike = [name]
        for other, (lower, higher) in list(ends.items())[list(ends).index(name) + 1 :]:
            if max(low, lower) <= min(high, higher) < np.inf:
                low, high = max(low, lower), min(high, higher)
                alike.append(other)
        if len(alike) == 1 or named.issuperset(alike):
            continue
        named |= {*alike}
        readings_by_span = dict[str, list[str]]()
        for one in alike:
            write = _writer_of(next(scene for scene in compared if scene.name == one))
            each_end = (write(end, unit, float(np.ptp(ends[one]))) for end in ends[one])
            span = " to ".join(dict.fromkeys(each_end))
            readings_by_span.setdefault(span, []).append(one)
        each = "; ".join(
            f"{span} for {', '.join(whose)}" for span, whose in readings_by_span.items()
        )
        if len(readings_by_span) == 1:
            each = f"{next(iter(readings_by_span))} for each"
        many = f"{', '.join(alike[:-1])} and {alike[-1]}"
        single = all(len(one.readings) == 1 for one in compared if one.name in alike)
        over = "with their errors" if single else "over readings and errors"
        said.append(f"order undecided between {many}: {over} K* is {each}")
    return said


def range_of_spring(scene: ComparedScene, unit: str) -> tuple[float, float]:
    """From where to where K* goes over the readings, with its errors, two of those that are standard errors."""
    many, ends = (2.0 if scene.found.sampled else 1.0), list[float]()
    for one in (reading.spring(unit) for reading in scene.readings):
        off = many * (one.error or 0.0) if np.isfinite(one.value) else 0.0
        ends += [max(one.value - off, 0.0), one.value + off]
    return min(ends), max(ends)
