"""mesofriction thresholds SCENE: P_c, its survival and hazard as a picture; moments and propensity as a table."""

import argparse
from contextlib import closing
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from toolkit.judge.describe import Description

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


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print the table; write thresholds.png and thresholds.json."""
    from origins.errors import refuse
    from toolkit.judge.describe import describe
    from toolkit.pictures.thresholds import save_thresholds_picture
    from toolkit.results.files import another, write_json
    from toolkit.results.folders import write_folder
    from toolkit.results.records import sample_curve
    from toolkit.running.progress import Progress
    from toolkit.running.ranks import on_root
    from toolkit.running.runner import until
    from toolkit.scene.scene import load_scene

    scene = load_scene(arguments.scene, solved=False, comm=comm)
    folder = arguments.out or f"{scene.name}-output"

    def look() -> None:
        """What a run may have taken hours for is not taken away for a table."""
        if (whose := another(folder, scene.name, scene.text)) is not None:
            rule = f"holds the result of {whose}; choose another, or run this scene there"
            refuse("out", str(folder), rule)

    on_root(comm, look)
    speed, law = scene.sliding, scene.contacts.thresholds

    def describe_it() -> "Description":
        with closing(Progress("thresholds")), until(scene.deadline(), scene, "[contacts]"):
            return describe(scene.contacts, speed.value, speed.chosen)

    found = on_root(comm, describe_it)
    curve, title = sample_curve(law), scene.title or scene.name
    record = {"name": scene.name, "title": scene.title, "scene": scene.text, **asdict(found)}
    writers: dict[str, Any] = {
        "thresholds.png": lambda path: save_thresholds_picture(curve, law, title, path),
        "thresholds.json": lambda path: write_json(record, path),
    }
    on_root(comm, lambda: write_folder(folder, writers))
    print("\n".join([title, *lines(found), f"written to {folder}"]))
    return 0


def lines(found: "Description") -> list[str]:
    """The table as lines of text."""
    from toolkit.scene.interfaces import with_error

    names = [
        f"{name.replace('_', ' ')} {_SYMBOLS.get(name, '')}".rstrip() for name in found.numbers
    ]
    width = max(map(len, names)) + 2
    out = []
    for name, number in zip(names, found.numbers.values(), strict=True):
        value = with_error(number.value, number.error or 0.0, 8)
        out.append(f"  {name:{width}}{value} {number.unit}".rstrip())
    out += [f"  {note}" for note in found.notes]
    return [*out, f"  {'run time':{width}}{found.run_time:.2g} s"]
