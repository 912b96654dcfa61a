"""mesofriction compare SCENE...: how prone to stick-slip each scene is, as one table and one picture."""

import argparse
from contextlib import closing, nullcontext
from dataclasses import asdict, fields
from typing import Any

ALL_RANKS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """SCENE... and --out."""
    parser.add_argument(
        "scenes", metavar="SCENE", nargs="+", help="scene files, or names of shipped scenes"
    )
    parser.add_argument(
        "--out", metavar="DIR", help="folder for table and picture (default: ./compare-output)"
    )


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print the table; write compare.png, compare.txt and compare.json; 1 where a solver missed its tolerance."""
    from origins.errors import refuse
    from toolkit.judge.compare import compare, naming, table
    from toolkit.results.files import write_json
    from toolkit.results.folders import check_folder, write_folder
    from toolkit.running.compiling_notice import CompilingNotice
    from toolkit.running.progress import Progress
    from toolkit.running.ranks import on_root
    from toolkit.scene.scene import load_scene

    scenes = []
    for scene in arguments.scenes:
        with naming(scene):
            scenes.append(load_scene(scene, comm=comm))
    for index, scene in enumerate(scenes):
        if scene.name in [other.name for other in scenes[:index]]:
            refuse(
                "scenes",
                scene.name,
                "two scenes of this name could not be told apart; rename one of the files",
            )
    folder = arguments.out or "compare-output"
    on_root(comm, lambda: check_folder(folder))
    first = comm is None or comm.Get_rank() == 0
    with CompilingNotice() if first else nullcontext(), closing(Progress()) as progress:
        verdicts = compare(scenes, comm, progress if first else None)
    lines = table(verdicts)
    numbers = {"scenes": [_numbers(verdict) for verdict in verdicts]}

    def write() -> None:
        from toolkit.pictures.compare import save_comparison

        write_folder(
            folder,
            {
                "compare.png": lambda path: save_comparison(verdicts, scenes, path),
                "compare.txt": lambda path: _write_lines(lines, path),
                "compare.json": lambda path: write_json(numbers, path),
            },
        )

    on_root(comm, write)
    print("\n".join(lines))
    print(f"written to {folder}")
    return 0 if all(verdict.result.success for verdict in verdicts) else 1


def _numbers(verdict: Any) -> dict[str, Any]:
    plain = {
        field.name: getattr(verdict, field.name)
        for field in fields(verdict)
        if field.name != "result"
    }
    if verdict.evidence is not None:
        plain["evidence"] = asdict(verdict.evidence)
    return plain


def _write_lines(lines: list[str], path: Any) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
