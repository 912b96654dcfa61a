"""mesofriction precision SCENE: true error against run time of each solver the scene names, as table and picture."""

import argparse
from dataclasses import asdict
from typing import Any

ALL_RANKS = False


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print each point once it is measured; write precision.png, precision.txt and precision.json."""
    from toolkit.judge.precision import Point, precision, table, table_head, table_line
    from toolkit.pictures.precision import save_precision
    from toolkit.results.files import write_json, write_lines
    from toolkit.results.folders import check_folder, write_folder
    from toolkit.running.runner import until
    from toolkit.scene.scene import load_scene

    scene = load_scene(arguments.scene)
    folder = arguments.out or f"{scene.name}-output"
    check_folder(folder)  # refused before the work, not after it
    head = [scene.title or scene.name, *table_head()]

    def show(point: Point) -> None:
        print("\n".join([*head, table_line(point)]), flush=True)
        head.clear()

    with until(scene.deadline(), scene, "[precision]"):
        measured = precision(scene, report=show)
    against = {"reference": measured.reference.source, "reference_error": measured.reference.error}
    numbers = {"name": measured.name, "title": measured.title, **against}
    numbers |= {"points": [asdict(one) for one in measured.points], "notes": measured.notes}
    writers: dict[str, Any] = {
        "precision.png": lambda path: save_precision(measured, path),
        "precision.txt": lambda path: write_lines(table(measured), path),
        "precision.json": lambda path: write_json(numbers, path),
    }
    write_folder(folder, writers)
    print("\n".join([*measured.notes, f"written to {folder}"]))
    return 0
