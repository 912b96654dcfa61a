"""What `mesofriction stability` and `precision --coverage` print and write."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict
from typing import Any

from origins.errors import refuse
from toolkit.processes.signals import Terminated, TimeIsUp, no_longer_than
from toolkit.results.folders import check_folder
from toolkit.running.progress import Progress
from toolkit.saving import save_judgement
from toolkit.scene.scene import Scene
from toolkit.stability.case import Row
from toolkit.stability.coverage import Coverage, as_lines, ask, coverage, plain_coverage
from toolkit.stability.scene_map import draw_map, not_asked, scene_map, trusted
from toolkit.stability.table import columns, draw_table, extreme_cases, stability, summary

Say = Callable[[str], None]


def report_stability(
    scene: Scene | None, folder: str, say: Say, formats: Sequence[str] = ()
) -> list[Row]:
    """The rows of the shipped extreme cases, or of those around `scene`; each line is given to `say` as it is known.
    Writes stability.txt, .csv, .json and .png into `folder`, which is checked before the work, and the picture in
    `formats`, too; of an interrupted table, or where the scene's wall_time is over, the rows that are known. Raises
    InputError, also where none is known by then."""
    check_folder(folder)
    lines, found, numbers = list[str](), list[Row](), dict[str, Any]()

    def say_and_keep(line: str) -> None:
        lines.append(line)
        say(line)

    def write(numbers: Mapping[str, Any]) -> None:
        figure = draw_table(found) if scene is None else draw_map(found)
        _save(folder, "stability", figure, lines, found, numbers, formats)

    try:
        with closing(Progress("stability", "cases" if scene is None else "numbers")) as bar:
            if scene is None:
                stability(extreme_cases(), say_and_keep, found, bar.count)
            else:
                with no_longer_than(scene.wall_time):
                    scene_map(scene, say_and_keep, found, bar.count)
    except TimeIsUp:
        if scene is None or not found:
            hint = "is over before the scene as it is is answered; give more"
            refuse("wall_time", scene and scene.wall_time, hint)
        for line in [*trusted(found), f"wall_time is over: {not_asked(scene, found)}"]:
            say_and_keep(line)
        numbers = {"stopped_by_wall_time": True}
    except (KeyboardInterrupt, Terminated) as stop:
        if found:
            lines.append(f"interrupted after {len(found)} answers: {summary(found)}")
            write({"interrupted": True})
            stop.add_note(f"the {len(found)} answers so far are written to {folder}")
        raise
    say_and_keep(summary(found))
    write(numbers)
    return found


def report_coverage(
    cases: int, seed: int, folder: str, say: Say, formats: Sequence[str] = ()
) -> Coverage:
    """How often error bars hold the true error, over so many drawn cases; what there is to tell is given to `say`.
    Writes coverage.txt, .csv, .json and .png as above, of an interrupted run of those known, too. Raises InputError."""
    check_folder(folder)
    rows = list[Row]()

    def write(lines: list[str], more: Mapping[str, Any]) -> None:
        numbers = {"cases": cases, "seed": seed, **more, **plain_coverage(coverage(rows))}
        _save(folder, "coverage", draw_table(rows, "Drawn cases"), lines, rows, numbers, formats)

    try:
        with closing(Progress("coverage", "cases")) as bar:
            ask(cases, seed, rows, bar.count)
    except (KeyboardInterrupt, Terminated) as stop:
        if rows:
            write(
                [*as_lines(rows), f"interrupted after {len(rows)} answers"], {"interrupted": True}
            )
            stop.add_note(f"the {len(rows)} answers so far are written to {folder}")
        raise
    lines = as_lines(rows)
    say("\n".join(lines))
    write(lines, {})
    return coverage(rows)


def _save(
    folder: str,
    name: str,
    figure: Any,
    lines: list[str],
    rows: list[Row],
    numbers: Mapping[str, Any],
    formats: Sequence[str],
) -> None:
    """Rows as a picture, text, JSON and CSV."""
    numbers = {**numbers, "rows": [asdict(row) for row in rows]}
    save_judgement(folder, name, lambda: figure, lines, numbers, columns(rows), formats)
