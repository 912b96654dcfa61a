"""The tables of docs/error-and-cost.md, and README's: python docs/error_and_cost.py [--errors | --costs] [SCENE ...]

Runs `mesofriction precision` and `mesofriction cost` of all shipped scenes, or of those that are named, whose
rows alone are then made anew; with `--errors` or `--costs` of one table alone. All take some ten minutes on two cores.
All times are CPU times, which hang little on what else the machine does.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from toolkit.running.cost import cost
from toolkit.scene.scene import shipped_scenes

PAGE = Path(__file__).with_name("error-and-cost.md")
README = Path(__file__).parents[1] / "README.md"
COMMAND = [sys.executable, "-P", "-m", "toolkit.command"]
ERRORS = "| scene | true error, run time: master at 1e-3 | finest | ensemble, largest | cheapest |"
COSTS = "| scene | start-up | run | memory | builds | imports, % of files | leaves out |"


def precision_of(scene: str) -> dict[str, Any] | str:
    """What precision.json holds, or the line with which the scene is refused."""
    with tempfile.TemporaryDirectory() as folder:
        # errors of a surface, too, in mean thresholds
        given = ["--set", 'units="N_c<k>"', "--out", f"{folder}/out"]
        words = [*COMMAND, "precision", scene, *given]
        env = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        done = subprocess.run(words, capture_output=True, text=True, env=env, check=False)
        file = Path(folder, "out", "precision.json")
        return json.loads(file.read_text()) if file.exists() else done.stderr.strip()


def point(one: dict[str, Any] | None, floor: float | None) -> str:
    """True error and run time of a run; the reference's own error where it tells no more. None: that is not known, as
    its run ended before, and no error is."""
    if one is None:
        return ""
    error = one["error"]
    known = "not known"
    if floor is not None:
        known = f"{error:.0e}" if error is not None and error >= floor else f"< {floor:.0e}"
    return f"{known}, {one['run_time']:.1g} s"


def error_row(scene: str, found: dict[str, Any] | str) -> str:
    """A line of the first table."""
    if isinstance(found, str):
        return f"| {scene} | {found.removeprefix('mesofriction: ')} |  |  |  |"
    own = {
        name: [p for p in found["points"] if p["method"] == name] for name in ("master", "ensemble")
    }
    floor = found["reference_error"]
    first = next((p for p in own["master"] if p["setting"] <= 1.01e-3), None)
    last = own["master"][-1] if own["master"] else None
    best = own["ensemble"][-1] if own["ensemble"] else None
    spans = [line for line in found["notes"] if line.startswith("cheapest: ")]
    only = [span["method"] for span in found.get("cheapest", [])] or ["master"]
    words = f"{only[0]} at every error"
    if spans:
        words = spans[0].removeprefix("cheapest: ").partition(";")[0]
    cells = [point(first, floor), point(last, floor), point(best, floor), words]
    return f"| {scene} | {' | '.join(cells)} |"


def cost_row(scene: str) -> str:
    """A line of the second table: of a run whose kernels one before it has compiled, into a cache of their own, as that
    of the machine holds those of other scenes, whose laws would be imported with them."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        found = cost(scene)
        if "numba" not in found["no_packages"]:
            found = cost(scene)
    del os.environ["NUMBA_CACHE_DIR"]
    start, _, run = found["stages"]
    shares = {room: 100.0 * some / every for room, (some, every) in found["rooms"].items()}
    files = ", ".join(f"{room} {share:.0f}" for room, share in shares.items())
    left = ", ".join([*found["no_solvers"], *found["no_laws"], *found["no_packages"]])
    times = [f"{start['cpu_seconds']:.2f} s", f"{run['cpu_seconds']:.2g} s"]
    cells = [*times, f"{run['memory']:.0f} MB"]
    return f"| {scene} | {' | '.join([*cells, ', '.join(found['builds']), files, left])} |"


def rows_of(text: str, name: str) -> dict[str, str]:
    """The lines between the marks of a table of this name, by the scene in their first cell."""
    inside = text.partition(f"<!-- {name} -->\n")[2].partition(f"<!-- end of {name} -->")[0]
    return {line.split(" | ")[0].removeprefix("| "): line for line in inside.splitlines()[2:]}


def with_rows(text: str, name: str, head: str, rows: list[str]) -> str:
    """The text with this table between its marks."""
    before, _, rest = text.partition(f"<!-- {name} -->\n")
    after = rest.partition(f"<!-- end of {name} -->")[2]
    table = "\n".join([head, "|---" * (head.count("|") - 1) + "|", *rows])
    return f"{before}<!-- {name} -->\n{table}\n<!-- end of {name} -->{after}"


def main(names: list[str]) -> None:
    """Write the rows of these scenes, or of all, into the page, and the page's rows of README's scenes into README."""
    scenes = [name for name in names if not name.startswith("--")] or shipped_scenes()
    with ThreadPoolExecutor(2) as pool:
        measured = [] if "--costs" in names else scenes
        pairs = zip(measured, pool.map(precision_of, measured), strict=True)
        errors = {scene: error_row(scene, found) for scene, found in pairs}
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = used.ru_utime + used.ru_stime
    costs = {} if "--errors" in names else {scene: cost_row(scene) for scene in scenes}
    page = PAGE.read_text(encoding="utf-8")
    for name, head, made in (("errors", ERRORS, errors), ("costs", COSTS, costs)):
        made = rows_of(page, name) | made
        page = with_rows(page, name, head, [made[one] for one in shipped_scenes() if one in made])
    PAGE.write_text(page, encoding="utf-8")
    readme, made = README.read_text(encoding="utf-8"), rows_of(page, "errors")
    shown = [made[scene] for scene in rows_of(readme, "errors")]
    README.write_text(with_rows(readme, "errors", ERRORS, shown), encoding="utf-8")
    print(f"precision of {len(errors)} scenes: {seconds:.0f} CPU-seconds", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
