"""What stretches and thresholds the contacts have that hold: counted where asked for, the contacts not kept."""

from dataclasses import dataclass
from typing import Any

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
    whole = points.ndim == 1 and points.dtype.kind in "iu"
    if not whole or (points < -size).any() or (points >= size).any():
        rule = f"must be indices of points of the path, such as [0, {size - 1}]"
        refuse("histograms", histograms, rule)
    if points.size > MOST:
        refuse("histograms", f"{points.size} points", f"must be at most {MOST}, which take 65 MB")
    return np.asarray(points % size, dtype=np.intp)


def make_edges(reach: float, largest: float, contacts: Contacts) -> tuple[Array, Array]:
    """Edges of bins for stretches that cannot exceed `reach` and thresholds that cannot exceed `largest` (lengths)."""
    typical = largest
    if not isinstance(contacts.grains, GrainContact):  # whose thresholds grow
        laws = [contacts.start] + ([contacts.reforming.law] if contacts.reforming else [])
        final = 0.0 if contacts.ageing is None else contacts.ageing.final.mean()
        typical = max(contacts.mean_threshold, final, *(abs(law.mean()) for law in laws))
    # a little more: contacts that have all come as far as that lie within a bin, not at its edge
    reach, wide = min(1.01 * reach, largest) or largest, _WIDE * typical
    stretch = np.linspace(-min(reach, wide), min(reach, wide), BINS + 1)
    threshold = np.linspace(0.0, min(largest, wide), BINS + 1)
    stretch[0], stretch[-1], threshold[-1] = -reach, reach, largest
    return stretch, threshold


def histogram(
    point: int, position: float, edges: tuple[Array, Array], counts: npt.NDArray[Any], n: int
) -> Histogram:
    """From counts (2, bins) of n contacts."""
    held = int(counts[0].sum())
    told: list[Any] = [point, position]
    for own, seen, total in zip(edges, counts, (n, max(held, 1)), strict=True):
        share, width = seen / total, np.diff(own)
        told += [own, share / width, np.sqrt(share * (1.0 - share) / total) / width]
    told.append(held)
    return Histogram(*told)
