"""`mesofriction figures`: draws the paper's figures and tells the number that each of them is held by."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from origins.errors import refuse
from toolkit.figures import ageing, heat, sliding, stretches, surfaces
from toolkit.figures.found import Found
from toolkit.results.files import write_json
from toolkit.results.folders import check_folder, write_folder
from toolkit.saving import pictures, stale
from toolkit.scene.paper import PAPER_FIGURES, figures_called
from toolkit.scene.scale import rounded_up

# each draws on an empty matplotlib Figure
DRAW: dict[str, Callable[[Any], Found]] = {
    "A02a": stretches.a02a,
    "A02b": stretches.a02b,
    "A02c": stretches.a02c,
    "A03a": stretches.a03a,
    "A03b": stretches.a03b,
    "A03c": stretches.a03c,
    "A08a": heat.a08a,
    "A08b": heat.a08b,
    "A08c": heat.a08c,
    "A08d": heat.a08d,
    "A08e": heat.a08e,
    "A04": ageing.a04,
    "A05": ageing.a05,
    "A06": ageing.a06,
    "A10a": surfaces.a10a,
    "A10b": surfaces.a10b,
    "PcPersson": surfaces.persson,
    "A12": surfaces.a12,
    "A02d": stretches.a02d,
    "A09": sliding.a09,
    "A13a": sliding.a13a,
    "A13b": sliding.a13b,
    "delta12": sliding.delta12,
}


def labels_of(names: Iterable[str]) -> list[str]:
    """The labels that these names mean, in the paper's order; all where there are none. Raises InputError."""
    chosen = set[str]()
    for name in names:
        if not (found := figures_called(name)):
            refuse("figure", name, f"is none of the paper's figures with data: {', '.join(DRAW)}")
        chosen.update(found)
    return [label for label in PAPER_FIGURES if label in chosen or not chosen]


def draw_figures(
    labels: Iterable[str], folder: str, say: Callable[[str], None], formats: Sequence[str] = ()
) -> bool:
    """Write <label>.png of each, in `formats`, too, figures.txt and figures.json into the folder, and `say` each number
    as it is found. Pictures of these labels in other formats, of an earlier call, are removed.

    Returns whether all numbers agree with their references. Raises InputError for a folder that cannot be written to.
    """
    from matplotlib.figure import Figure

    check_folder(folder)  # before the work, not after it
    lines, numbers = list[str](), dict[str, Any]()
    for label in labels:
        began, figure = time.perf_counter(), Figure(layout="constrained")
        found = DRAW[label](figure)
        number = PAPER_FIGURES[label].number
        figure.suptitle(f"Fig. {number} ({label})", fontsize="medium")
        writers = pictures(label, partial(_save_figure, figure), formats)
        write_folder(folder, writers, stale([label], writers))
        own = in_words(label, number, found)
        say("\n".join(own))
        lines += own
        run_time = time.perf_counter() - began
        about = {"number": number, "scenes": PAPER_FIGURES[label].scenes}
        numbers[label] = about | asdict(found) | {"agrees": found.agrees, "run_time": run_time}
    text = "\n".join([*lines, ""])
    tables: dict[str, Any] = {
        "figures.txt": lambda path: path.write_text(text, encoding="utf-8"),
        "figures.json": lambda path: write_json(numbers, path),
    }
    write_folder(folder, tables)
    return all(one["agrees"] for one in numbers.values())


def _save_figure(figure: Any, path: Path) -> None:
    figure.savefig(path, dpi=110, format=path.suffix[1:])


def in_words(label: str, number: int, found: Found) -> list[str]:
    """Two or three lines: the number beside its reference, the paper's word, the remark."""
    text = f"{found.what}: {found.in_digits(found.value)}"
    if found.exact is not None:
        exact = found.in_digits(found.exact)
        text += f", exact {exact} ({found.reference}), within {rounded_up(found.off):.1g}"
        text += "" if found.agrees else ": THEY DO NOT AGREE"
    lines = [f"Fig. {number:<3}{label:10}{text}"]
    lines += [f"{'':18}the paper: {found.paper}"] if found.paper else []
    return lines + ([f"{'':18}{found.remark}"] if found.remark else [])
