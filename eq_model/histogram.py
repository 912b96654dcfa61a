"""What stretches and thresholds the contacts have that hold: counted where asked for, the contacts not kept."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from origins import Contacts, GrainContact
from origins.errors import refuse

Array = npt.NDArray[np.float64]
Counts = npt.NDArray[np.unsignedinteger[Any]]

BINS = 4096
MOST = 2000  # points at which contacts are counted: the counts of all then take 65 MB, and 131 MB from 2^32 contacts on
_WIDE = 64.0  # typical lengths that bins alike are spread over: they are at most 1/32 of one wide


@dataclass(frozen=True)
class Histogram:
    """Contacts that hold at one point of the path; all arrays of shape (4096,) but for edges, of one more.

    Stretches are counted as far as path, start and re-forming can bring them, thresholds as far as the law is drawn, to
    2^-54 of its weight. Bins are alike, but for laws of wide tails: beyond 64 times the mean threshold (or the mean
    stretch of start or re-forming, or the mean of the thresholds in the end) all that is left is counted in the first
    and last bin of the stretches and the last one of the thresholds, which reach to the ends: a density is then the
    mean over such a bin, and the sum over bins of density times width is still all contacts.

    point : index into the path; position : X there, a length.
    stretch_edges, threshold_edges : lengths, rising.
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


def no_counts(points: int, contacts: int) -> Counts:
    """Zeros, shape (points, 2, BINS), that hold the counts of so many contacts."""
    return np.zeros((points, 2, BINS), np.uint32 if contacts < 1 << 32 else np.uint64)


def chosen_points(histograms: npt.ArrayLike, size: int) -> npt.NDArray[np.intp]:
    """Indices of points of a path of this size, checked; raises InputError, named histograms."""
    points = np.atleast_1d(np.asarray(histograms))
    if not points.size:
        return np.empty(0, np.intp)
    good = (
        points.ndim == 1
        and points.dtype.kind in "iu"
        and ((points >= -size) & (points < size)).all()
    )
    if not good:
        refuse(
            "histograms",
            histograms,
            f"must be indices of points of the path, such as [0, {size - 1}]",
        )
    if points.size > MOST:
        refuse("histograms", f"{points.size} points", f"must be at most {MOST}, which take 65 MB")
    return np.asarray(points % size, dtype=np.intp)


@dataclass(frozen=True)
class Range:
    """Where contacts are counted, lengths: stretches up to +-stretch and thresholds up to `threshold`, each of them
    (near, far): bins are alike up to near, and the last reaches to far."""

    stretch: tuple[float, float]
    threshold: tuple[float, float]

    def per(self, unit: float) -> tuple[float, float]:
        """Bins per unit of |x| and of thresholds, for the whole of either."""
        return BINS * unit / self.stretch[0], BINS * unit / self.threshold[0]


def make_range(reach: float, largest: float, contacts: Contacts) -> Range:
    """For stretches that cannot exceed `reach` and thresholds that cannot exceed `largest`."""
    typical = largest
    if not isinstance(contacts.grains, GrainContact):  # whose thresholds grow
        laws = [contacts.start] + ([contacts.reforming.law] if contacts.reforming else [])
        final = 0.0 if contacts.ageing is None else contacts.ageing.final.mean()
        typical = max(contacts.mean_threshold, final, *(abs(law.mean()) for law in laws))
    # a little more: contacts that have all come as far as that lie within a bin, not at its edge
    reach, wide = min(1.01 * reach, largest) or largest, _WIDE * typical
    return Range((min(reach, wide), reach), (min(largest, wide), largest))


def histogram(
    point: int, position: float, over: Range, counts: npt.NDArray[Any], n: int
) -> Histogram:
    """From counts (2, bins) of n contacts."""
    held, (near, far) = int(counts[0].sum()), over.stretch
    stretches = _density(counts[0], n, -near, near, -far, far)
    near, far = over.threshold
    thresholds = _density(counts[1], max(held, 1), 0.0, near, 0.0, far)
    return Histogram(point, position, *stretches, *thresholds, held)


def _density(
    counts: npt.NDArray[Any], total: int, low: float, high: float, least: float, most: float
) -> tuple[Array, Array, Array]:
    """Edges, density and its standard error."""
    edges = np.linspace(low, high, BINS + 1)
    edges[0], edges[-1] = least, most
    share, width = counts / total, np.diff(edges)
    return edges, share / width, np.sqrt(share * (1.0 - share) / total) / width


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
