"""What is told of slips that take time, those of a slider with mass."""

from typing import Any

import numpy as np


def of_slips_in_time(slips: Any) -> dict[str, Any]:
    """Fields of a Behaviour: how long the last slip takes and its top speed; where the first one begins, and the forces
    before and after it, with their error. All None, and the error 0, where slips take no time, and where there is none.
    """
    forces, error = _first_forces(slips) if _take_time(slips) else (None, 0.0)
    return {
        "slip_time": _last_of(slips, "duration"),
        "top_speed": _last_of(slips, "top_speed"),
        "first_slip": first_of(slips),
        "first_forces": forces,
        "first_error": error,
    }


def first_of(slips: Any) -> float | None:
    """Where the drive stands as the first slip of all contacts begins, of an ensemble that of its first slider; None
    without a slip, and for slips that take no time."""
    if not _take_time(slips):
        return None
    if hasattr(slips, "replica"):
        return float(slips.drive[slips.replica == slips.replica[0]][0])
    return float(slips.drive[slips.main[0]])


def _first_forces(slips: Any) -> tuple[tuple[float, float], float]:
    """The force before the first slip of all contacts, and after it (lengths), of slips that take time; of an ensemble
    their means over sliders, and the larger standard error of both (0 of one slider)."""
    first = slips.number == 0 if hasattr(slips, "replica") else slips.main[:1]
    both = np.array([slips.force_before[first], slips.force_after[first]])
    before, after = both.mean(axis=1).tolist()
    many = both.shape[1]
    error = float(both.std(axis=1, ddof=1).max()) / many**0.5 if many > 1 else 0.0
    return (before, after), error


def _take_time(slips: Any) -> bool:
    """Whether there are slips, and these take time."""
    return getattr(slips, "duration", None) is not None and bool(slips.drive.size)


def _last_of(slips: Any, name: str) -> float | None:
    """A property of the last slip, where the solution has it: slips without mass take no time."""
    values = getattr(slips, name, None)
    return None if values is None or not len(values) else float(values[-1])
