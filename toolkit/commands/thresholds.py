"""mesofriction thresholds SCENE: P_c, its survival and hazard as a picture, its moments as a table."""

import argparse
from dataclasses import fields
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from origins import Thresholds

ALL_RANKS = False


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """SCENE and --out."""
    parser.add_argument("scene", metavar="SCENE", help="a scene file, or the name of a shipped scene")
    parser.add_argument("--out", metavar="DIR", help="folder for picture and table (default: ./NAME-output)")


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print the table; write thresholds.png and thresholds.json."""
    from toolkit.files import write_json
    from toolkit.folders import write_folder
    from toolkit.plots import save_thresholds_picture
    from toolkit.results import sample_curve
    from toolkit.scene import load_scene

    scene = load_scene(arguments.scene, solved=False)
    folder = arguments.out or f"{scene.name}-output"
    thresholds = scene.contacts.thresholds
    numbers = table(thresholds)
    curve = sample_curve(thresholds)
    title = scene.title or scene.name
    write_folder(
        folder,
        {
            "thresholds.png": lambda path: save_thresholds_picture(curve, title, path),
            "thresholds.json": lambda path: write_json({"name": scene.name, "title": scene.title, **numbers}, path),
        },
    )
    print(title)
    for name, value in numbers.items():
        print(f"  {name.replace('_', ' '):26} {value:.6g}")
    print(f"written to {folder}")
    return 0


def table(thresholds: "Thresholds") -> dict[str, float]:
    """Moments, quantiles and onset of a law; lengths in the scene's unit; of a surface also the interface, in SI units.

    The kinetic force per N_c<k> is <x_s^2>/(2<x_s>): the mean stretch of a contact in steady sliding.
    """
    mean, second = thresholds.mean(), thresholds.moment(2)
    lower, upper = thresholds.support()
    numbers = {
        "mean": mean,
        "standard_deviation": thresholds.std(),
        "second_moment": second,
        "third_moment": thresholds.moment(3),
        "lower_end": lower,
        "upper_end": upper,
        "one_in_a_hundred_below": float(thresholds.ppf(0.01)),
        "median": float(thresholds.ppf(0.5)),
        "one_in_a_hundred_above": float(thresholds.isf(0.01)),
        "onset_power": thresholds.onset_power,
        "kinetic_force": second / (2.0 * mean),
    }
    if thresholds.interface is not None:
        values = {field.name: getattr(thresholds.interface, field.name) for field in fields(thresholds.interface)}
        numbers |= {name: value for name, value in values.items() if isinstance(value, float)}
    return numbers
