"""What a figure finds: one number beside its exact value and the paper's word; and how all figures are drawn."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from origins.thresholds.law import Array

INKS = (
    "black",
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#56b4e9",
)  # told apart by the colour-blind
_DIGITS = 6  # of a number that is told, at most
FORCE = r"$F/(N_c\langle k\rangle)$"


@dataclass(frozen=True)
class Found:
    """A number that a figure shows.

    what : the quantity in words; value : what the toolkit finds, `off` by at most this (five standard errors, or the
    error that a solver claims and the rounding of the reference); exact : the reference, None where there is none;
    reference : whence it is. paper : what the paper prints, "" where it prints no such number; remark : a sentence
    where the paper's statement does not hold, or where a parameter is our own choice.
    """

    what: str
    value: float
    off: float
    exact: float | None
    reference: str
    paper: str = ""
    remark: str = ""

    @property
    def agrees(self) -> bool:
        """Whether value and exact differ by no more than `off`."""
        return self.exact is None or bool(abs(self.value - self.exact) <= self.off)

    def in_digits(self, number: float) -> str:
        """The value, or the exact one, to the digit after the first of `off`, in at most _DIGITS."""
        leading = int(np.floor(np.log10(abs(number)))) if number else 0
        first = int(np.floor(np.log10(self.off))) if self.off else leading - _DIGITS
        return f"{number:.{int(np.clip(1 - first, 0, _DIGITS - 1 - leading))}f}"


def waterfall(axes: Any, curves: Iterable[tuple[Array, Array]], down: float) -> None:
    """Densities against x, each moved right by 0.025 and down by `down` from the one before, as in the paper."""
    for number, (x, density) in enumerate(curves):
        style: dict[str, Any] = {"color": INKS[0], "lw": 0.6, "zorder": number}
        seen = (x > -0.12) & (x < 1.3)  # no more stretches of the figures' contacts
        place, moved = x[seen] + 0.025 * number, density[seen] - down * number
        axes.fill_between(place, -down * number, moved, color="white", zorder=number)
        axes.plot(place, moved, **style)
    axes.set(xlabel="$x$ (each moved by 0.025)", ylabel="$Q(x;X)$ (each moved down)")


def coarser(edges: Array, density: Array, together: int) -> tuple[Array, Array]:
    """A histogram's bin middles and densities with so many of its bins in one."""
    middles = 0.5 * (edges[1:] + edges[:-1])
    return middles.reshape(-1, together).mean(axis=1), density.reshape(-1, together).mean(axis=1)


def lettered(axes: Any, letter: str) -> None:
    """(a), (b) above the upper left corner."""
    axes.text(0.0, 1.01, f"({letter})", transform=axes.transAxes, va="bottom", weight="bold")


def normal_tail(z: Array | float) -> Any:
    """The probability that a standard normal number exceeds z."""
    from scipy.special import ndtr

    return ndtr(-np.asarray(z))
