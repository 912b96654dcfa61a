"""Contacts counted by stretch and threshold at chosen points of the path, as kernels pass them."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare


class Watch(NamedTuple):
    """The chosen points, in the order of the clock."""

    before: npt.NDArray[np.int64]  # (bins + 2,): how many of them lie before each bin
    moments: npt.NDArray[np.int64]  # (m,): the last moments that count
    places: npt.NDArray[np.int64]  # (m,): slider there
    per_stretch: float  # histogram bins per unit of |x|
    per_threshold: float


@bare
def look_at(k, birth, threshold, watch, counts):  # type: ignore[no-untyped-def]
    """Count a contact at the k-th watched point.

    birth : slider where the contact is relaxed (whole). counts : (points, 2, bins), of stretches of
    either sign and of thresholds.
    """
    many = counts.shape[2]
    x = np.float64(watch.places[k] - birth) * (0.5 * watch.per_stretch) + 0.5 * many
    y = threshold * watch.per_threshold
    counts[k, 0, np.int64(min(max(np.floor(x), 0.0), many - 1.0))] += 1
    counts[k, 1, np.int64(min(max(y, 0.0), many - 1.0))] += 1


@bare
def look(born, broken, birth, threshold, watch, counts):  # type: ignore[no-untyped-def]
    """Count a contact at the watched points from the bin `born` to before the bin `broken`."""
    for k in range(watch.before[born], watch.before[broken]):
        look_at(k, birth, threshold, watch, counts)
