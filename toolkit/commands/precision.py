"""mesofriction precision SCENE: true error against run time of each solver the scene names, as table and picture."""

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import Any

ALL_RANKS = False


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """SCENE and --out."""
    parser.add_argument(
        "scene", metavar="SCENE", help="a scene file, or the name of a shipped scene"
    )
    parser.add_argument(
        "--out", metavar="DIR", help="folder for table and picture (default: ./NAME-output)"
    )


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print each point once it is measured; write precision.png, precision.txt and precision.json."""
    from toolkit.judge.precision import Point, precision, table, table_head, table_line
    from toolkit.pictures.precision import save_precision
    from toolkit.results.files import write_json
    from toolkit.results.folders import check_folder, write_folder
    from toolkit.running.compiling_notice import CompilingNotice
    from toolkit.scene.scene import load_scene

    scene = load_scene(arguments.scene)
    folder = arguments.out or f"{scene.name}-output"
    check_folder(folder)  # refused before the work, not after it
    begun = False

    def show(point: Point) -> None:
        nonlocal begun
        if not begun:
            print("\n".join([scene.title or scene.name, *table_head()]))
            begun = True
        print(table_line(point), flush=True)

    with CompilingNotice():
        measured = precision(scene, report=show)
    lines = table(measured)
    numbers = {
        "name": measured.name,
        "title": measured.title,
        "reference": measured.reference.source,
        "reference_error": measured.reference.error,
        "points": [asdict(point) for point in measured.points],
        "notes": measured.notes,
    }
    write_folder(
        folder,
        {
            "precision.png": lambda path: save_precision(measured, path),
            "precision.txt": lambda path: _write_lines(lines, path),
            "precision.json": lambda path: write_json(numbers, path),
        },
    )
    print("\n".join(measured.notes))
    print(f"written to {folder}")
    return 0


def _write_lines(lines: list[str], path: Path) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
