"""The subcommands of `mesofriction`: each takes its arguments and the communicator, and returns its exit status."""

import argparse
import textwrap
import time
import tomllib
from contextlib import closing
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from origins.errors import InputError, positive, refuse
from origins.roughness.interface import Interface
from toolkit.judge import compare as judge
from toolkit.judge import picture as pictures
from toolkit.judge import precision as ladders
from toolkit.judge.columns import KEYS, comparison_rows, precision_rows
from toolkit.judge.describe import SHARED_NUMBERS, Description, describe, in_units_of, table_of
from toolkit.judge.frontier import draw_picture as draw_precision
from toolkit.pictures.thresholds import save_thresholds_picture as draw_law
from toolkit.processes.ranks import on_root
from toolkit.results.files import another, write_json
from toolkit.results.folders import check_folder, write_folder
from toolkit.results.records import sample_curve
from toolkit.results.report import APART, agreeing, report
from toolkit.results.verdicts import contradiction
from toolkit.running import cost as costs
from toolkit.running import forecast, runner
from toolkit.running.checkpoint import say
from toolkit.running.progress import Progress
from toolkit.running.solvers import within
from toolkit.saving import pictures as picture
from toolkit.saving import read_formats, save_judgement, stale
from toolkit.scene.changes import read_changes
from toolkit.scene.interfaces import foreseen
from toolkit.scene.laws import inside
from toolkit.scene.of_samples import of_smoothing
from toolkit.scene.paper import numbers_in_paper, scene_of_figure
from toolkit.scene.scale import SHARED
from toolkit.scene.scene import SHIPPED, load_scene, read_scene, shipped_scenes
from toolkit.scene.tables import did_you_mean
from toolkit.scene.writing import written_out

# the other ranks wait
ON_ONE_RANK = (
    "copy",
    "cost",
    "figures",
    "precision",
    "rate_state",
    "scenes",
    "show",
    "stability",
    "verdict",
)


def scenes(arguments: argparse.Namespace) -> int:
    """Print names, titles and numbers of the paper's figures, on lines of 100 characters; long titles are wrapped."""
    width = max(map(len, shipped_scenes())) + 2
    for name in shipped_scenes():
        title = tomllib.loads((SHIPPED / f"{name}.toml").read_text(encoding="utf-8"))["title"]
        if numbers := numbers_in_paper(name):
            title += f" (Fig. {', '.join(map(str, numbers))})"
        print(textwrap.fill(f"{name:{width}}{title}", 100, subsequent_indent=" " * width))
    return 0


def figures(arguments: argparse.Namespace) -> int:
    """Draw the paper's figures that are named, or all; returns 1 where a number does not agree with its reference."""
    from toolkit.figures.paper import draw_figures, labels_of

    folder, formats = arguments.out or "paper-figures", read_formats(arguments.format)
    agree = draw_figures(labels_of(arguments.figure), folder, partial(print, flush=True), formats)
    print(f"written to {folder}")
    return 0 if agree else 1


def show(arguments: argparse.Namespace) -> int:
    """Print the scene with all defaults filled in."""
    found = read_scene(arguments.scene, changes=read_changes(arguments.changes))
    print(written_out(found.tables, found.folder), end="")
    return 0


def copy(arguments: argparse.Namespace) -> int:
    """Write a shipped scene, named by itself or by a figure of the paper, with its comments, into a file of the user's,
    which must not be there yet."""
    name = scene_of_figure(arguments.scene) or arguments.scene
    if name not in shipped_scenes():
        meant = did_you_mean(name, shipped_scenes())
        refuse("scene", name, f"is no shipped scene; {meant}`mesofriction scenes` lists them")
    given = arguments.file or "."
    file = Path(given)
    try:
        if file.is_dir() or given.endswith("/"):
            file.mkdir(parents=True, exist_ok=True)
            file /= f"{name}.toml"
        with file.open("x", encoding="utf-8") as stream:
            stream.write((SHIPPED / f"{name}.toml").read_text(encoding="utf-8"))
    except FileExistsError:
        refuse("file", str(file), "is there already, and is kept; name another")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        refuse("file", str(file), f"cannot be written: {why}")
    print(f"written to {file}; change it, then: mesofriction run {file}")
    return 0


def run(arguments: argparse.Namespace, comm: Any) -> int:
    """Run every solver that the scene names, report, and write; returns 1 where a solver missed its tolerance, or where
    both disagree (results are written nevertheless)."""
    formats = read_formats(arguments.format)
    # before a forecast, too, which writes none
    positive("checkpoint", arguments.checkpoint)
    scene = load_scene(arguments.scene, comm=comm, changes=read_changes(arguments.changes))
    first = comm is None or comm.Get_rank() == 0
    before = [] if scene.grid is not None else foreseen(scene)
    folder = arguments.out or f"{scene.name}-output"
    if arguments.dry_run:
        for note in before if first else []:
            say(note)
        print("\n".join(forecast.forecast_lines(scene, folder, comm)))
        return 0
    # a folder that cannot be used is refused before the work
    with runner.open_checkpoint(folder, scene, comm, arguments.checkpoint) as kept:
        told = before if first else []
        result, finished = runner.solve(
            scene, comm, kept=kept, show_progress=first, say_before=told
        )
        said_before = {f"note    {note}" for note in before}
        try:
            runner.write(result, comm, kept, finished, formats)
        finally:  # a reader that has closed its end, as `head` does, must not cost the result
            print("\n".join(line for line in report(result) if line not in said_before))
    print(f"written to {folder}")
    for name in ("master", "eq", "sweep"):
        answer = getattr(result, name)
        if answer is not None and not answer.success and first:
            say(f"{name}: {answer.message}")
    return 0 if result.success and agreeing(result) and not contradiction(result) else 1


def thresholds(arguments: argparse.Namespace, comm: Any) -> int:
    """P_c, its survival and hazard as a picture, moments and propensity as a table; returns 1 where a number of the
    table misses its tolerance."""
    formats = read_formats(arguments.format)
    scene = load_scene(arguments.scene, False, comm, read_changes(arguments.changes))
    folder = arguments.out or f"{scene.name}-output"

    def describe_it() -> Description:
        if (whose := another(folder, scene.name, scene.text)) is not None:
            refuse("out", str(folder), f"holds the result of {whose}; choose another folder")
        check_folder(folder)  # before the work, not after it
        for note in foreseen(scene):
            say(note)
        shown = closing(Progress("thresholds", "resampled laws"))
        with shown as bar, within(scene.deadline(), scene, "[contacts]"):
            found = describe(scene.contacts, scene.sliding, bar.count)
        return replace(found, numbers=in_units_of(scene.scale, found.numbers))

    found = on_root(comm, describe_it)
    law, title = scene.contacts.thresholds, scene.title or scene.name
    record = {"name": scene.name, "title": scene.title, "scene": scene.text, **asdict(found)}
    writers: dict[str, Any] = {
        **picture("thresholds", partial(draw_law, law, sample_curve(law), title), formats),
        "thresholds.json": lambda path: write_json(record, path),
    }
    on_root(comm, lambda: write_folder(folder, writers, stale(["thresholds"], writers)))
    hidden = SHARED_NUMBERS if scene.scale.spring_unit != SHARED else ()
    kinds = isinstance(law.interface, Interface), of_smoothing(law)
    lines = table_of(found, scene.contacts.laws, hidden, *kinds)
    print("\n".join([title, *lines, f"written to {folder}"]))
    return 0 if found.success else 1


def compare(arguments: argparse.Namespace, comm: Any) -> int:
    """Propensity of each scene to stick-slip, as table and picture; returns 1 where a solver missed its tolerance."""
    from toolkit.judge.lines import table

    scenes, began = dict[str, Any](), time.monotonic()
    formats, changes = read_formats(arguments.format), read_changes(arguments.changes)
    for given in arguments.scene:
        with inside(given, {}):
            scene = judge.read(given, comm, changes).one("compare")
        if scene.name in scenes:
            refuse("scenes", scene.name, "two scenes have this name; rename one of the files")
        scenes[scene.name] = scene
    folder = arguments.out or "compare-output"
    on_root(comm, lambda: check_folder(folder))  # before the work, not after it
    compared = judge.compare(list(scenes.values()), comm, comm is None or comm.Get_rank() == 0)
    lines = table(compared)
    numbers: dict[str, Any] = {"keys": KEYS, "scenes": [one.plain() for one in compared]}
    lines[-1] += f"; the whole command {time.monotonic() - began:.2g} s"
    draw = partial(pictures.draw_comparison, compared)
    rows = comparison_rows(numbers["scenes"])
    on_root(comm, lambda: save_judgement(folder, "compare", draw, lines, numbers, rows, formats))
    print("\n".join([*lines, f"written to {folder}"]))
    return 0 if all(one.result.success and one.found.success for one in compared) else 1


def verdict(arguments: argparse.Namespace) -> int:
    """Whether the scene's interface sticks and slips on its machine: one page, a picture, tables; returns 1 where a
    solver missed its tolerance."""
    from toolkit.verdict.report import report_verdict

    changes, formats = read_changes(arguments.changes), read_formats(arguments.format)
    return 0 if report_verdict(arguments.scene, changes, arguments.out, formats).success else 1


def rate_state(arguments: argparse.Namespace) -> int:
    """a, b and D_c of the scene's contacts, from velocity steps and rests: one page, a picture, tables; returns 1 where
    an answer is not known to its tolerance."""
    from toolkit.rate_state.report import report_rate_state
    from toolkit.rate_state.words import page

    formats = read_formats(arguments.format)
    scene = load_scene(arguments.scene, False, changes=read_changes(arguments.changes))
    folder = arguments.out or f"{scene.name}-output"
    found = report_rate_state(scene, folder, formats)
    print("\n".join([*page(found), f"written to {folder}"]))
    return 0 if found.found.success else 1


def cost(arguments: argparse.Namespace) -> int:
    """What the scene imports, builds and runs, its memory, and what it leaves out, of one run in another process."""
    found = costs.cost(arguments.scene, read_changes(arguments.changes))
    print("\n".join(costs.cost_lines(found)))
    return 0


def precision(arguments: argparse.Namespace) -> int:
    """True error against run time of each method that takes the scene, as picture and table; each line is printed once
    it is measured. Returns 1 where the ensemble contradicts the master equation. Without a scene, whether error bars
    hold over drawn cases; then 1 where they do not."""
    formats = read_formats(arguments.format)
    if arguments.coverage:
        return _coverage(arguments, formats)
    for option, given in (("--cases", arguments.cases), ("--seed", arguments.seed)):
        if given is not None:
            use = f"mesofriction precision --coverage {option} {given}"
            refuse(option, given, f"is of --coverage, which draws cases; leave it out, or: {use}")
    if arguments.scene is None:
        raise InputError(
            "scene: is missing; name one, or ask for mesofriction precision --coverage"
        )
    scene = load_scene(arguments.scene, changes=read_changes(arguments.changes))
    folder, lines = arguments.out or f"{scene.name}-output", list[str]()
    check_folder(folder)  # before the work, not after it

    def say_it(line: str) -> None:
        lines.append(line)
        print(line, flush=True)

    with within(scene.deadline(), scene, "[precision]"):
        found = ladders.precision(scene, say_it)
    draw = partial(draw_precision, found)
    rows = precision_rows(found)
    save_judgement(folder, "precision", draw, [*lines, *found["notes"]], found, rows, formats)
    print("\n".join([*found["notes"], f"written to {folder}"]))
    worst = (found["witness"] or {}).get("worst_deviation")
    return 0 if (worst or 0.0) < APART else 1


def _coverage(arguments: argparse.Namespace, formats: tuple[str, ...]) -> int:
    """Whether error bars hold over drawn cases; returns 1 where they do not."""
    from toolkit.stability.report import report_coverage

    if arguments.scene is not None or arguments.changes:
        given = arguments.scene or arguments.changes[0]
        refuse("--coverage", given, "draws its own cases; leave the scene and --set out")
    cases = 1000 if arguments.cases is None else arguments.cases
    seed = 1 if arguments.seed is None else arguments.seed
    if cases < 1:
        refuse("--cases", cases, "must be a number of cases above 0")
    if seed < 0:
        refuse("--seed", seed, "must be a whole number from 0 on")
    folder = arguments.out or "coverage-output"
    say_it = partial(print, flush=True)
    found = report_coverage(cases, seed, folder, say_it, formats)
    print(f"written to {folder}")
    return 0 if found.promise_kept and found.sigmas_kept else 1


def stability(arguments: argparse.Namespace) -> int:
    """Extreme cases, or those around a scene, through both solvers; returns 1 where an answer is wrong."""
    from toolkit.stability.report import report_stability

    if arguments.scene is None and arguments.changes:
        refuse(
            "--set", arguments.changes[0], "changes a scene; name one: mesofriction stability SCENE"
        )
    changes = read_changes(arguments.changes)
    scene = None if arguments.scene is None else load_scene(arguments.scene, changes=changes)
    folder = arguments.out or ("stability-output" if scene is None else f"{scene.name}-output")
    formats = read_formats(arguments.format)
    found = report_stability(scene, folder, partial(print, flush=True), formats)
    print(f"written to {folder}")
    return int(any(row.verdict == "wrong" for row in found))
