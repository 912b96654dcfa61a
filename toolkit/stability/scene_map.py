"""Where a scene may be trusted: each of its numbers, pushed up and down by decades, through both solvers."""

import time
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from origins.errors import InputError
from toolkit.processes.signals import TooMuchWork, no_longer_than
from toolkit.scene.scene import Scene, load_scene
from toolkit.stability.case import (
    WITNESSES,
    Case,
    CaseAnswer,
    Question,
    Row,
    Truth,
    simulated,
    solved,
)
from toolkit.stability.pushes import (
    DECADES,
    FEWEST,
    Push,
    column,
    factor_of,
    is_of_ensemble,
    label,
    not_pushed,
    numbers,
    searches,
)
from toolkit.stability.table import VERDICTS, answered, uncounted
from toolkit.stability.table import line as row_as_line
from toolkit.stability.work import within_work

LETTERS = dict(zip(VERDICTS, "etslrw", strict=True))  # of verdicts in the picture
# verdicts of answers as good as asked
GOOD = "exact", "within tolerance"
_POINTS = 24  # of the path, at which both solvers are compared
# N K³ below which contacts that are so few slip on springs on which infinitely many slide (docs/sliders.md)
_ENOUGH = 50.0
_BEFORE = 0.9  # of the drive up to the first slip: beyond, ensembles of another size slip elsewhere
# the first slip is looked for in the first 1/8 of the path, then 1/4, 1/2, and all of it, for so many CPU-s each
_PARTS, _FIRST_SLIP = (8, 4, 2, 1), 5.0
WORK = 600.0  # CPU-s for a map; each number has its share of what those before have left


def scene_map(
    scene: Scene,
    say: Callable[[str], None],
    found: list[Row] | None = None,
    count: Callable[[int, int], None] = uncounted,
) -> list[Row]:
    """The rows of the scene as it is, then of each of its numbers times 0.1, 0.01, ... and 10, 100, ..., which end at
    the first that is not answered within the tolerance, or that comes after the number's share of WORK; each is said as
    soon as it is known.

    A row's group is the key, its case the factor and the value. Rows are appended to `found`, which holds those of an
    interrupted map, too; `count` is told how many numbers are done, and of how many. Raises InputError for a scene
    without a path.
    """
    scene = scene.one("stability")
    coupled = scene.drive.spring is not None  # without a drive this says what is missing
    found = [] if found is None else found
    of_both, of_ensemble = partial(_case, scene), _ensembles(scene)

    def asked(group: str, name: str, changes: Mapping[str, Any]) -> bool:
        """Whether the scene with these changes is answered, by the solvers that they concern."""
        ask = of_ensemble if is_of_ensemble(group) else of_both
        own = answered(ask(group, name, changes), say)
        found.extend(own)
        return all(row.verdict in GOOD for row in own if _decides(row))

    work, clock = time.process_time(), time.monotonic()

    def remaining() -> float:
        """CPU-s for what is still to be asked: of WORK, and of the scene's wall_time at the pace so far."""
        worked, took = time.process_time() - work, time.monotonic() - clock
        more = np.inf if scene.wall_time is None else scene.wall_time - took
        return float(min(WORK - worked, more * worked / max(took, 1e-3)))

    def push(key: str, one: Push, end: float) -> bool:
        """Whether a number's new value is answered before `end`, in s of CPU time."""
        share, late, good = end - time.process_time(), True, False
        # of a wall_time an answer that takes its number's share is cut, as it may take that of all others
        limit = None if scene.wall_time is None else share
        with suppress(TooMuchWork):
            if share >= 0.0:
                with no_longer_than(limit, TooMuchWork):
                    good = asked(key, one.name, {key: one.value})
                late = False
        if late:
            found.append(_not_asked(key, one.name, scene.wall_time))
            say(row_as_line(found[-1]))
        return good

    tables = tomllib.loads(scene.text)
    all_numbers = list(numbers(tables, coupled))
    for line in not_pushed(tables, coupled):
        say(line)
    say("as it is")
    asked("as it is", "x 1", {})
    ways = [searches(key, value, scene) for key, value in all_numbers]
    left = sum(map(len, ways))  # searches still to be done
    for done, ((key, value), own) in enumerate(zip(all_numbers, ways, strict=True)):
        say(f"{key} = {value}")
        for way in own:
            end = time.process_time() + remaining() / left
            left -= 1
            all(push(key, one, end) for one in way)  # up to the first that is not answered
        count(done + 1, len(all_numbers))
    for line in trusted(found):
        say(line)
    return found


def _not_asked(group: str, name: str, wall_time: float | None) -> Row:
    """In place of an answer for which no time is left."""
    said = f"not asked: a map has {WORK:.0f} CPU-seconds, and each number its share"
    if wall_time is not None:
        said = f"not answered in its number's share of wall_time = {wall_time:g} s"
    solver = "ensemble" if is_of_ensemble(group) else "master"
    return Row(group, name, solver, "slow", np.nan, np.nan, np.nan, 0.0, "", said)


def not_asked(scene: Scene, found: list[Row]) -> str:
    """What of a map that ends with these rows was not asked, in words."""
    coupled = scene.drive.spring is not None
    last, keys = found[-1], [key for key, _ in numbers(tomllib.loads(scene.text), coupled)]
    begun = [key for key in keys if any(row.group == key for row in found)]
    remaining = ", ".join(keys[len(begun) :])
    after = f"what follows on {last.case} of {last.group}" if begun else ""
    return f"not asked: {'; '.join(filter(None, (after, remaining)))}"


def trusted(found: list[Row]) -> Iterator[str]:
    """Between which values each number may be trusted, in words."""
    plain = [row for row in found if row.group == "as it is" and _decides(row)]
    if any(row.verdict not in GOOD for row in plain):
        yield f"not answered within the tolerance as it is: {plain[0].said}"
        return
    for key in dict.fromkeys(row.group for row in found if row.group != "as it is"):
        own = [row for row in found if row.group == key and _decides(row)]
        good = sorted((row.case for row in own if row.verdict in GOOD), key=column)
        late = sorted((row.case for row in own if row.verdict == "slow"), key=column)
        zero = not own[0].case.startswith("x ")
        if not is_of_ensemble(key):  # it is answered as it is
            good = sorted([*good, "0" if zero else "x 1"], key=column)
        ends = " to ".join(dict.fromkeys(map(factor_of, good[:1] + good[-1:])))
        between = f"at {ends}{'' if zero else ' times its value'}" if good else "nowhere"
        beyond = ", ".join(case.partition(":")[0].removeprefix("x ") for case in late)
        beyond = f"; not answered in its time at {beyond}" if late else ""
        yield f"{key}: answered within the tolerance {between}{beyond}"


def _decides(row: Row) -> bool:
    """Whether a row tells if a value is answered: of the ensemble it does where no other answer depends on that."""
    return row.solver != "ensemble" or is_of_ensemble(row.group)


def _case(scene: Scene, group: str, name: str, changes: Mapping[str, Any]) -> Case:
    """The scene with these changes as a case of the table; soft sliders are compared up to their first slip."""
    try:
        other = load_scene(scene, changes=changes)
        drive, unit = other.drive, other.contacts.mean_threshold
    except InputError as refusal:
        return Case(group, name, _refused(refusal), np.zeros(1))
    contacts = FEWEST
    path = np.interp(
        np.linspace(0.0, 1.0, _POINTS), np.linspace(0.0, 1.0, drive.path.size), drive.path
    )
    keywords = {name: value for name, value in drive.keywords().items() if value is not None}
    if drive.time is not None or not drive.forward:  # the turns and rests are points of the path
        path = drive.path
    if drive.spring is not None:
        slip = first_slip(other, path, keywords)
        before = np.logical_and.accumulate(path <= _BEFORE * slip)
        before[0] = True
        path = path[before]
        if drive.time is not None:
            keywords["time"] = drive.time[before]
        end = min(_BEFORE * slip, float(drive.path[-1]))
        if drive.time is None and drive.forward and drive.path[0] < end:
            # points of its own, as the first slip may come before the second point of the path
            path = np.linspace(drive.path[0], end, _POINTS)
        if np.isinf(slip) and FEWEST * drive.spring**3 < _ENOUGH:
            contacts = 0  # no second road
    tolerance = 1e-4 if other.master is None else other.master.tolerance
    return Case(
        group,
        name,
        lambda: other.contacts,
        path / unit,
        # no exact value: the other solver is the reference
        None,
        keywords,
        tolerance,
        n_contacts=contacts,
    )


def _ensembles(scene: Scene) -> Callable[[str, str, Mapping[str, Any]], Question]:
    """Makes cases in which ensembles of the scene's own size, with some changes of [eq], answer the scene as it is."""
    own_case = cache(partial(_case, scene, "", "", {}))

    @cache
    def truth() -> Truth:
        case = own_case()
        contacts = case.contacts()
        answer = solved(case, contacts, case.path * contacts.mean_threshold)
        return Truth(answer.values, answer.error, WITNESSES["master"])

    def ask(changes: Mapping[str, Any]) -> CaseAnswer:
        eq, case = load_scene(scene, changes=changes).eq, own_case()
        if eq is None or not case.n_contacts:
            hint = "few contacts slip on this spring, where infinitely many do not"
            raise InputError(f"eq.contacts: {hint}: no answer stands beside theirs")
        # on a spring the scatter of replicas is known from so many as elsewhere in the map
        many = {} if coupled else {"n_replicas": eq.replicas, "tolerance": eq.tolerance}
        case = replace(case, n_contacts=eq.contacts, of_ensemble=many)
        contacts = case.contacts()
        return simulated(case, contacts, case.path * contacts.mean_threshold)

    coupled = scene.drive.spring is not None
    return lambda group, name, changes: Question(
        group, name, "ensemble", partial(ask, changes), truth
    )


def _refused(refusal: InputError) -> Callable[[], Any]:
    """In place of contacts that cannot be made."""

    def fail() -> Any:
        raise refusal

    return fail


def first_slip(scene: Scene, path: Any, keywords: Mapping[str, Any]) -> float:
    """The drive's position at the first slip by the master equation, infinite where there is none or none is known; it
    is looked for in longer and longer parts of the path, as all slips after it would be solved for nothing."""
    import master

    for part in _PARTS:
        points = 1 + (path.size - 1) // part
        some = {key: one[:points] if key == "time" else one for key, one in keywords.items()}
        solve = partial(master.solve, scene.contacts, path[:points], 1e-4, **some)
        try:
            found = within_work(solve, _FIRST_SLIP)
        except InputError:
            continue
        if found.slips is not None and found.slips.drive.size:
            return float(found.slips.drive[0])
    return np.inf


def draw_map(found: list[Row]) -> Any:
    """Keys down the side, decades along, as colour and letter the verdict on the master equation, or on the ensemble
    for its own numbers."""
    from matplotlib.figure import Figure

    keys = [key for key in dict.fromkeys(row.group for row in found) if key != "as it is"]
    figure = Figure(figsize=(9, 2.0 + 0.32 * len(keys)), layout="constrained")
    axes = figure.subplots()
    for row in filter(_decides, found):
        decade, places = column(row.case), range(len(keys))
        for place in places if row.group == "as it is" else [keys.index(row.group)]:
            if row.group == "as it is" and is_of_ensemble(keys[place]):
                continue
            axes.barh(place, 0.92, left=decade - 0.46, height=0.86, color=VERDICTS[row.verdict])
            axes.text(decade, place, LETTERS[row.verdict], ha="center", va="center", color="white")
    names = {row.group: label(row.group, row.case) for row in found}
    axes.set_yticks(range(len(keys)), [names[key] for key in keys])
    axes.invert_yaxis()
    axes.set(xlabel="decades by which the number is pushed", xlim=(-DECADES - 0.6, DECADES + 0.6))
    for verdict, colour in VERDICTS.items():
        axes.bar(0.0, 0.0, color=colour, label=f"{LETTERS[verdict]}: {verdict}")
    figure.legend(loc="outside lower center", ncols=3, fontsize="small")
    return figure
