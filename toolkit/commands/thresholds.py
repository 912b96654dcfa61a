"""mesofriction thresholds SCENE: P_c, its survival and hazard as a picture; moments and propensity as a table."""

import argparse
from contextlib import closing, nullcontext
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from toolkit.results.describe import Description

ALL_RANKS = True
_SYMBOLS = {
    "mean": "<x_s>",
    "onset_power": "m",
    "kinetic_force": "F_k/(N<k>)",
    "critical_spring": "K*/(N<k>)",
    "static_to_kinetic": "F_s/F_k",
    "decoherence_length": "X*",
    "mean_stiffness": "<k>",
    "mean_force_threshold": "<f_s>",
    "friction_coefficient": "F_k/load",
    "kinetic_stress": "F_k/area",
    "plasticity_index": "psi",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """SCENE and --out."""
    parser.add_argument(
        "scene", metavar="SCENE", help="a scene file, or the name of a shipped scene"
    )
    parser.add_argument(
        "--out", metavar="DIR", help="folder for picture and table (default: ./NAME-output)"
    )


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print the table; write thresholds.png and thresholds.json."""
    from toolkit.pictures.run import save_thresholds_picture
    from toolkit.results.describe import describe
    from toolkit.results.files import write_json
    from toolkit.results.folders import write_folder
    from toolkit.results.records import sample_curve
    from toolkit.running.leftovers import check_beside
    from toolkit.running.progress import Refinement
    from toolkit.running.ranks import on_root
    from toolkit.scene.scene import load_scene

    scene = load_scene(arguments.scene, solved=False, comm=comm)
    folder = arguments.out or f"{scene.name}-output"
    on_root(comm, lambda: check_beside(folder, scene.name, scene.text))
    speed = scene.sliding
    with closing(Refinement(None, what="thresholds")) if comm is None else nullcontext():
        found = on_root(comm, lambda: describe(scene.contacts, speed.value, speed.chosen))
    curve = sample_curve(scene.contacts.thresholds)
    title = scene.title or scene.name
    record = {"name": scene.name, "title": scene.title, "scene": scene.text, **asdict(found)}
    writers = {
        "thresholds.png": lambda path: save_thresholds_picture(
            curve, scene.contacts.thresholds, title, path
        ),
        "thresholds.json": lambda path: write_json(record, path),
    }
    on_root(comm, lambda: write_folder(folder, writers))
    print("\n".join([title, *lines(found), f"written to {folder}"]))
    return 0


def lines(found: "Description") -> list[str]:
    """The table as lines of text."""
    from toolkit.scene.interfaces import with_error

    names = {
        name: f"{name.replace('_', ' ')} {_SYMBOLS.get(name, '')}".rstrip()
        for name in found.numbers
    }
    width = max(map(len, names.values())) + 2
    out = []
    for name, number in found.numbers.items():
        value = with_error(number.value, number.error or 0.0, 8)
        out.append(f"  {names[name]:{width}}{value} {number.unit}".rstrip())
    return [
        *out,
        *(f"  {note}" for note in found.notes),
        f"  {'run time':{width}}{found.run_time:.2g} s",
    ]
