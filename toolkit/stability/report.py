"""What `mesofriction stability` prints and writes."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from toolkit.results.files import write_json
from toolkit.results.folders import check_folder, write_folder
from toolkit.scene.scene import Scene
from toolkit.stability.case import Row
from toolkit.stability.scene_map import draw_map, scene_map
from toolkit.stability.table import (
    draw_table,
    extreme_cases,
    plain,
    stability,
    summary,
    write_table,
)


def report_stability(scene: Scene | None, folder: str, say: Callable[[str], None]) -> list[Row]:
    """The rows of the shipped extreme cases, or of those around `scene`; each line is given to `say` as it is known.
    Writes stability.txt, .csv, .json and .png into `folder`, which is checked before the work. Raises InputError."""
    check_folder(folder)
    lines = list[str]()

    def say_and_keep(line: str) -> None:
        lines.append(line)
        say(line)

    if scene is None:
        found = stability(extreme_cases(), say_and_keep)
    else:
        found = scene_map(scene, say_and_keep)
    say_and_keep(summary(found))
    figure = draw_table(found) if scene is None else draw_map(found)

    def write_text(path: Path) -> None:
        path.write_text("\n".join([*lines, ""]), encoding="utf-8")

    writers: dict[str, Any] = {
        "stability.txt": write_text,
        "stability.csv": partial(write_table, found),
        "stability.json": lambda path: write_json({"rows": plain(found)}, path),
        "stability.png": partial(figure.savefig, dpi=130, format="png"),
    }
    write_folder(folder, writers)
    return found
