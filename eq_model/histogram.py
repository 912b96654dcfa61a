"""Histograms of stretches and thresholds of the contacts that hold, at chosen points of the path."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.errors import refuse
from origins.thresholds.law import Array

BINS = 4096


@dataclass(frozen=True)
class Histogram:
    """Contacts that hold at one point of the path; arrays of shape (4096,), edges of shape (4097,).

    The bins of stretches extend to the largest |x| that path, start and re-forming allow, those of thresholds to 2^-54
    of the law's weight. They have equal widths, except for laws with wide tails: beyond 64 times the mean threshold (or
    the mean stretch of start or re-forming, or the mean of the final thresholds) all contacts are counted in the wide
    outermost bins. A density is the mean over its bin, so that the sum of density times width is that of all contacts.

    point : index into the path; position : X there, a length.
    stretch_edges, threshold_edges : lengths, increasing.
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


def chosen_points(histograms: npt.ArrayLike, size: int) -> npt.NDArray[np.intp]:
    """Indices of points of a path of this size, checked; raises InputError, named histograms."""
    points = np.atleast_1d(np.asarray(histograms, None if np.size(histograms) else np.intp))
    whole = points.ndim == 1 and points.dtype.kind in "iu"
    if not whole or (points < -size).any() or (points >= size).any():
        rule = f"must be indices of points of the path, such as [0, {size - 1}]"
        refuse("histograms", histograms, rule)
    if points.size > 2000:
        refuse("histograms", f"{points.size} points", "must be at most 2000, which take 65 MB")
    return np.asarray(points % size, dtype=np.intp)


def make_edges(reach: float, largest: float, contacts: Contacts) -> tuple[Array, Array]:
    """Edges of bins for stretches that cannot exceed `reach` and thresholds that cannot exceed `largest` (lengths)."""
    typical = max(contacts.mean_threshold, abs(contacts.start.mean()))
    if contacts.ageing is not None:
        typical = max(typical, contacts.ageing.final.mean())
    if contacts.grains is not None:  # all are typical
        typical = largest
    # 1 % more, so that stretches of exactly `reach` lie within a bin, not at its edge
    # equal bins extend over 64 typical lengths, so that each is at most 1/32 of one wide
    reach, wide = min(1.01 * reach, largest) or largest, 64.0 * typical
    stretch = np.linspace(-min(reach, wide), min(reach, wide), BINS + 1)
    threshold = np.linspace(0.0, min(largest, wide), BINS + 1)
    stretch[0], stretch[-1], threshold[-1] = -reach, reach, largest
    return stretch, threshold


def histogram(
    point: int, position: float, edges: tuple[Array, Array], counts: npt.NDArray[Any], n: int
) -> Histogram:
    """The histogram with counts (2, bins) of n contacts."""
    held = int(counts[0].sum())
    fields: list[Any] = [point, position]
    for own, seen, total in zip(edges, counts, (n, max(held, 1)), strict=True):
        share, width = seen / total, np.diff(own)
        fields += [own, share / width, np.sqrt(share * (1.0 - share) / total) / width]
    fields.append(held)
    return Histogram(*fields)
