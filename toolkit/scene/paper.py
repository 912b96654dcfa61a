"""The paper's figures: the label in its LaTeX, the number in its PDF, and the shipped scenes with their parameters."""

import re
from typing import NamedTuple


class PaperFigure(NamedTuple):
    """One figure that shows data; the first of `scenes` is the one that its label names."""

    number: int
    scenes: tuple[str, ...]


# Figure 1 (A01) is a sketch of the model
PAPER_FIGURES = {
    "A02a": PaperFigure(2, ("gaussian",)),
    "A02b": PaperFigure(3, ("gaussian",)),
    "A02c": PaperFigure(4, ("gaussian",)),
    "A03a": PaperFigure(5, ("gaussian",)),
    "A03b": PaperFigure(6, ("gaussian",)),
    "A03c": PaperFigure(7, ("gaussian",)),
    "A08a": PaperFigure(8, ("thermal-paper",)),
    "A08b": PaperFigure(9, ("thermal-paper",)),
    "A08c": PaperFigure(10, ("kinetic-force",)),
    "A08d": PaperFigure(11, ("thermal-soft", "thermal-paper")),
    "A08e": PaperFigure(12, ("thermal-soft",)),
    "A04": PaperFigure(13, ("ageing-paper", "ageing")),
    "A05": PaperFigure(14, ("ageing-speeds",)),
    "A06": PaperFigure(15, ("ageing-springs",)),
    "A10a": PaperFigure(16, ("gw-elastic", "gw-plastic")),
    "A10b": PaperFigure(17, ("gw-elastic", "gw-plastic")),
    "PcPersson": PaperFigure(18, ("persson", "persson-wide")),
    "A12": PaperFigure(19, ("grains",)),
    "A02d": PaperFigure(20, ("rectangular",)),
    "A09": PaperFigure(21, ("friction-loop-wide",)),
    "A13a": PaperFigure(22, ("delay",)),
    "A13b": PaperFigure(23, ("delays",)),
    "delta12": PaperFigure(24, ("one-peak", "two-peaks")),
}
_BY_NAME = {label.lower(): label for label in PAPER_FIGURES}
_BY_NAME |= {f"fig{figure.number}": label for label, figure in PAPER_FIGURES.items()}


def figures_called(name: str) -> list[str]:
    """Labels of the figures that a name means: one of `A08c`, `figA08c`, `fig10`, or all that begin with `A08`."""
    plain = re.sub(r"[\s._-]", "", name.lower())
    for label in (plain, plain.removeprefix("figure"), plain.removeprefix("fig")):
        if label in _BY_NAME:
            return [_BY_NAME[label]]
    start = plain.removeprefix("fig")
    return [label for label in PAPER_FIGURES if start and label.lower().startswith(start)]


def scene_of_figure(name: str) -> str | None:
    """The shipped scene of the one figure that `name` means, or None."""
    labels = figures_called(name)
    return PAPER_FIGURES[labels[0]].scenes[0] if len(labels) == 1 else None


def numbers_in_paper(scene: str) -> list[int]:
    """Numbers of the paper's figures whose parameters a shipped scene has."""
    return sorted(one.number for one in PAPER_FIGURES.values() if scene in one.scenes)
