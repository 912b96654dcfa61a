"""What stretches and thresholds the contacts have that hold: counted where asked for, the contacts not kept."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

BINS = 4096


@dataclass(frozen=True)
class Histogram:
    """Contacts that hold at one point of the path; all arrays of shape (4096,) but for edges, of one more.

    point : index into the path; position : X there, a length.
    stretch_edges, threshold_edges : lengths.
    stretches : Q(x; X), fraction of all contacts per length in each bin of stretches; stretch_error : its standard
    error. thresholds : P_xs(x), density of the thresholds of those contacts that hold, per length; threshold_error.
    count : contacts that hold there.
    """

    point: int
    position: float
    stretch_edges: Array
    stretches: Array
    stretch_error: Array
    threshold_edges: Array
    thresholds: Array
    threshold_error: Array
    count: int


def histogram(point: int, position: float, longest: float, counts: npt.NDArray[Any], n: int) -> Histogram:
    """From counts (2, bins) of n contacts: stretches between -longest and longest, thresholds up to longest."""
    held = int(counts[0].sum())
    stretches, thresholds = _density(counts[0], n, -longest, longest), _density(counts[1], max(held, 1), 0.0, longest)
    return Histogram(point, position, *stretches, *thresholds, held)


def _density(counts: npt.NDArray[Any], total: int, low: float, high: float) -> tuple[Array, Array, Array]:
    """Edges, density and its standard error."""
    share, width = counts / total, (high - low) / BINS
    return np.linspace(low, high, BINS + 1), share / width, np.sqrt(share * (1.0 - share) / total) / width


class Made(Sequence[Histogram]):
    """Histograms that are made, or read, each when it is asked for: all of them at once might not fit."""

    def __init__(self, size: int, make: Callable[[int], Histogram]) -> None:
        self._size, self._make = size, make

    def __len__(self) -> int:
        return self._size

    @overload
    def __getitem__(self, index: int) -> Histogram: ...
    @overload
    def __getitem__(self, index: slice) -> list[Histogram]: ...
    def __getitem__(self, index: int | slice) -> Histogram | list[Histogram]:
        chosen = range(self._size)[index]
        return self._make(chosen) if isinstance(chosen, int) else [self._make(k) for k in chosen]
