"""Where a scene may be trusted: each of its numbers, pushed up and down by decades, through both solvers."""

import re
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np

from origins.errors import InputError
from toolkit.processes.signals import TooMuchWork, no_longer_than
from toolkit.scene.scene import Scene, load_scene
from toolkit.scene.tables import MasterTable
from toolkit.stability.case import Case, Row
from toolkit.stability.table import VERDICTS, answered, uncounted
from toolkit.stability.table import line as row_as_line
from toolkit.stability.work import within_work

LETTERS = dict(zip(VERDICTS, "etslrw", strict=True))  # of verdicts in the picture
DECADES = 6  # how far a number is pushed, each way
# verdicts of answers as good as asked
GOOD = "exact", "within tolerance"
# what says how a scene is computed, not what it is; a seed or a number of points has no decades
_COMPUTED = {"points", "seed", "number", "step", "area", "to", "histograms", "degree", "resamples"}
_TABLES = ("contacts", "drive", "master")
# why a number is not pushed
_FAR = "how far, how finely or over which area is asked"
_ZERO, _LIST = "zero has no decades", "lists are not pushed"
_QUANTITY = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)(\s+\S.*)")  # such as "50 N/m"
_POINTS = 24  # of the path, at which both solvers are compared
_CONTACTS = 5_000  # of the ensemble
_ALWAYS = f"the ensemble is a second road of {_CONTACTS:,} contacts here; precision tells what others cost and give"
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
    _ = scene.drive  # which says what is missing
    found = [] if found is None else found

    def asked(group: str, name: str, changes: Mapping[str, Any]) -> bool:
        """Whether both solvers answer the scene with these changes."""
        own = answered(_case(scene, group, name, changes), say)
        found.extend(own)
        return all(row.verdict in GOOD for row in own if row.solver != "ensemble")

    work, clock = time.process_time(), time.monotonic()

    def remaining() -> float:
        """CPU-s for what is still to be asked: of WORK, and of the scene's wall_time at the pace so far."""
        worked, took = time.process_time() - work, time.monotonic() - clock
        more = np.inf if scene.wall_time is None else scene.wall_time - took
        return float(min(WORK - worked, more * worked / max(took, 1e-3)))

    tables = tomllib.loads(scene.text)
    all_numbers = list(numbers(tables))
    for line in not_pushed(tables):
        say(line)
    say("as it is")
    asked("as it is", "x 1", {})
    for done, (key, value) in enumerate(all_numbers):
        say(f"{key} = {value}")
        for sign in (-1, 1):
            searches = 2 * (len(all_numbers) - done) - (sign > 0)  # with this one, still to be done
            own_end = time.process_time() + remaining() / searches
            for decade in range(1, DECADES + 1):
                other = times(value, 10.0 ** (sign * decade))
                shown = other if isinstance(other, str) else f"{other:.6g}"
                name = f"x 1e{sign * decade:+d}: {shown}"
                share, late, good = own_end - time.process_time(), True, False
                # of a wall_time an answer that takes its number's share is cut, as it may take that of all others
                limit = None if scene.wall_time is None else share
                with suppress(TooMuchWork):
                    if share >= 0.0:
                        with no_longer_than(limit, TooMuchWork):
                            good = asked(key, name, {key: other})
                        late = False
                if late:
                    found.append(_not_asked(key, name, scene.wall_time))
                    say(row_as_line(found[-1]))
                if not good:
                    break
        count(done + 1, len(all_numbers))
    for line in trusted(found):
        say(line)
    return found


def _not_asked(group: str, name: str, wall_time: float | None) -> Row:
    """In place of an answer for which no time is left."""
    said = f"not asked: a map has {WORK:.0f} CPU-seconds, and each number its share"
    if wall_time is not None:
        said = f"not answered in its number's share of wall_time = {wall_time:g} s"
    return Row(group, name, "master", "slow", np.nan, np.nan, np.nan, 0.0, "", said)


def not_asked(scene: Scene, found: list[Row]) -> str:
    """What of a map that ends with these rows was not asked, in words."""
    last, keys = found[-1], [key for key, _ in numbers(tomllib.loads(scene.text))]
    begun = [key for key in keys if any(row.group == key for row in found)]
    remaining = ", ".join(keys[len(begun) :])
    after = f"what follows on {last.case} of {last.group}" if begun else ""
    return f"not asked: {'; '.join(filter(None, (after, remaining)))}"


def trusted(found: list[Row]) -> Iterator[str]:
    """Between which factors each number may be trusted, in words; rows of the ensemble do not count."""
    plain = [row for row in found if row.group == "as it is" and row.solver != "ensemble"]
    if any(row.verdict not in GOOD for row in plain):
        yield f"not answered within the tolerance as it is: {plain[0].said}"
        return
    for key in dict.fromkeys(row.group for row in found):
        own = [row for row in found if row.group == key and row.solver != "ensemble"]
        decades = [0, *(_decade(row) for row in own if row.verdict in GOOD)]
        if key != "as it is":
            first, last = 10.0 ** min(decades), 10.0 ** max(decades)
            late = [_decade(row) for row in own if row.verdict == "slow"]
            at = ", ".join(f"1e{decade:+d}" for decade in sorted(late))
            beyond = f"; not answered in its time at {at}" if late else ""
            yield f"{key}: answered within the tolerance at {first:g} to {last:g} times its value{beyond}"


def _case(scene: Scene, group: str, name: str, changes: Mapping[str, Any]) -> Case:
    """The scene with these changes as a case of the table; soft sliders are compared up to their first slip."""
    try:
        other = load_scene(scene, changes=changes)
        drive, unit = other.drive, other.contacts.mean_threshold
    except InputError as refusal:
        return Case(group, name, _refused(refusal), np.zeros(1))
    contacts = _CONTACTS
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
        if np.isinf(slip) and _CONTACTS * drive.spring**3 < _ENOUGH:
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


def numbers(tables: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Keys of [contacts], [drive] and [master], such as "contacts.thresholds.std", with their numbers, or texts of a
    number with its unit."""
    for key, value in _numbers_of(tables):
        if not _why_not(key, value):
            yield key, value


def not_pushed(tables: Mapping[str, Any]) -> Iterator[str]:
    """Which numbers of a scene a map leaves as they are, and why, a line for each reason."""
    kept = dict[str, list[str]]()
    for key, value in _numbers_of(tables):
        if why := _why_not(key, value):
            kept.setdefault(why, []).append(key)
    if "eq" in tables:
        kept[_ALWAYS] = [f"eq.{name}" for name in tables["eq"]] or ["eq"]
    for why, keys in kept.items():
        yield f"not pushed: {', '.join(keys)}: {why}"


def _why_not(key: str, value: Any) -> str:
    """Why a number is not pushed; "" where it is."""
    if key.rsplit(".", 1)[-1] in _COMPUTED:
        return _FAR
    if isinstance(value, list):
        return _LIST
    return "" if value else _ZERO


def _numbers_of(tables: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """All keys with numbers, or with lists of numbers, and the tolerance where [master] stands without one."""
    for table in _TABLES:
        own = tables.get(table, {})
        if table == "master" and table in tables:
            own = {"tolerance": MasterTable().tolerance} | own
        yield from _numbers_in(table, own)


def _numbers_in(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _numbers_in(f"{key}.{name}", inner)
    elif isinstance(value, list) and any(isinstance(inner, Mapping) for inner in value):
        for place, inner in enumerate(value):
            yield from _numbers_in(f"{key}[{place}]", inner)
    elif isinstance(value, bool):
        return
    elif isinstance(value, int | float | list) or _QUANTITY.fullmatch(str(value)):
        yield key, value


def times(value: Any, factor: float) -> Any:
    """A number, or the number of a text with its unit, times the factor."""
    if isinstance(value, str):
        number, unit = _QUANTITY.fullmatch(value).groups()  # type: ignore[union-attr]
        return f"{float(number) * factor:.12g}{unit}"
    return float(f"{value * factor:.12g}")


def _decade(row: Row) -> int:
    """By how many decades the number of a row is pushed."""
    return round(np.log10(float(row.case.split(":")[0].removeprefix("x "))))


def draw_map(found: list[Row]) -> Any:
    """Keys down the side, decades along, the master equation's verdict as colour and letter."""
    from matplotlib.figure import Figure

    keys = [key for key in dict.fromkeys(row.group for row in found) if key != "as it is"]
    figure = Figure(figsize=(9, 2.0 + 0.32 * len(keys)), layout="constrained")
    axes = figure.subplots()
    for row in found:
        if row.solver == "ensemble":
            continue
        decade = _decade(row)
        places = range(len(keys)) if row.group == "as it is" else [keys.index(row.group)]
        for place in places:
            axes.barh(place, 0.92, left=decade - 0.46, height=0.86, color=VERDICTS[row.verdict])
            axes.text(decade, place, LETTERS[row.verdict], ha="center", va="center", color="white")
    axes.set_yticks(range(len(keys)), keys)
    axes.invert_yaxis()
    axes.set(xlabel="decades by which the number is pushed", xlim=(-DECADES - 0.6, DECADES + 0.6))
    for verdict, colour in VERDICTS.items():
        axes.bar(0.0, 0.0, color=colour, label=f"{LETTERS[verdict]}: {verdict}")
    figure.legend(loc="outside lower center", ncols=3, fontsize="small")
    return figure
