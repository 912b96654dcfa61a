"""The panel of K* below the picture of a sweep, along the keys on which K* hangs."""

from typing import Any

import numpy as np

from toolkit.pictures.keys import last_words
from toolkit.pictures.points import FLAT, column_with_error, plot_points
from toolkit.results.points import SweepRecord
from toolkit.results.records import Result
from toolkit.scene.scale import written

_ALIKE = 1e-6  # of K*: values nearer to each other are one, but for the tolerance of its search


def plot_points_spring(axes: Any, result: Result) -> Any:
    """K* along the keys of the sweep on which it hangs, from 0: below it stick-slip."""
    return plot_points(axes, result, "critical_spring", keys_of_spring(result))


def keys_of_spring(result: Result) -> list[str]:
    """The keys of a sweep on which K* hangs: along it changes by more than its error where all others stand still."""
    sweep: Any = result.sweep
    value, error = column_with_error(result, "critical_spring")
    if not (np.isfinite(value).all() and error.max() <= FLAT * value.max()):
        return [*sweep.along]
    least, keys = max(2.0 * error.max(), _ALIKE * value.max()), list[str]()
    for key in sweep.along:
        others = [sweep[other].ravel() for other in sweep.along if other != key]
        same = dict[tuple[Any, ...], list[int]]()
        for row, own in enumerate(zip(*others, strict=True) if others else [()] * value.size):
            same.setdefault(own, []).append(row)
        if any(np.ptp(value[rows]) > least for rows in same.values()):
            keys.append(key)
    return keys


def flat_spring(result: Result) -> str:
    """On which of the keys swept K* does not hang, in a sentence, with its value where it hangs on none of them; ""
    where it hangs on all, or is not known."""
    sweep: Any = result.sweep
    keys, named = keys_of_spring(result), last_words([*sweep.along])
    flat = ", ".join(named[key] for key in sweep.along if key not in keys)
    if keys or not flat:
        return f"K* does not depend on {flat}" if flat else ""
    value, _ = column_with_error(result, "critical_spring")
    # samples, whose scatter a sweep does not look at, seldom tell K* to more than two digits
    digits = 2 if result.asked.contacts.thresholds.get("kind") == "from-samples" else 4
    text = written(float(np.median(value)), result.scale.spring_unit, digits=digits)
    return f"K* = {text}, which does not depend on {flat}"


def with_spring(sweep: object) -> bool:
    """Whether a sweep has K* somewhere."""
    own = sweep.columns.get("critical_spring") if isinstance(sweep, SweepRecord) else None
    return own is not None and bool(np.isfinite(own).any())
