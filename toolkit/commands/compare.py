"""mesofriction compare SCENE...: how prone to stick-slip each scene is, as one table and one picture."""

import argparse
from typing import Any

ALL_RANKS = True


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print the table; write compare.png, compare.txt and compare.json; 1 where a solver missed its tolerance."""
    from origins.errors import refuse
    from toolkit.judge.compare import compare, naming, plain_numbers, table
    from toolkit.pictures.compare import save_comparison
    from toolkit.results.files import write_json, write_lines
    from toolkit.results.folders import check_folder, write_folder
    from toolkit.running.ranks import on_root
    from toolkit.scene.scene import load_scene

    scenes: dict[str, Any] = {}
    for given in arguments.scene:
        with naming(given):
            scene = load_scene(given, comm=comm)
        if scene.name in scenes:
            rule = "two scenes of this name could not be told apart; rename one of the files"
            refuse("scenes", scene.name, rule)
        scenes[scene.name] = scene
    folder = arguments.out or "compare-output"
    on_root(comm, lambda: check_folder(folder))
    verdicts = compare(list(scenes.values()), comm, told=comm is None or comm.Get_rank() == 0)
    lines = table(verdicts)
    writers: dict[str, Any] = {
        "compare.png": lambda path: save_comparison(verdicts, list(scenes.values()), path),
        "compare.txt": lambda path: write_lines(lines, path),
        "compare.json": lambda path: write_json({"scenes": plain_numbers(verdicts)}, path),
    }
    on_root(comm, lambda: write_folder(folder, writers))
    print("\n".join([*lines, f"written to {folder}"]))
    return 0 if all(verdict.result.success for verdict in verdicts) else 1
