"""What kind of answer a solver gave, by what it has."""

from typing import Any


def is_known(solved: Any) -> bool:
    """Whether the force is known well enough to be drawn: to a tenth of <x_s>, where F_k is about half of it."""
    return bool(solved.success or solved.force_error < 0.1)


def is_coupled(eq: object) -> bool:
    """Whether an ensemble's answer is that of contacts on a soft slider."""
    return hasattr(eq, "avalanches")


def is_heavy(eq: object) -> bool:
    """Whether an ensemble's answer is that of contacts on a slider with mass, whose slips take time."""
    return hasattr(eq, "energy")
