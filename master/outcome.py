"""Whether a solution is as good as was asked, in words; and who hears of its error on the way."""

from collections.abc import Callable

from origins import Contacts

Progress = Callable[[float], None]
"""Called with the error estimate, in mean thresholds, that a solution has after each refinement."""


def unheard(error: float) -> None:
    """Nobody is told."""


def outcome(contacts: Contacts, error: float, tolerance: float, reason: str) -> tuple[bool, str]:
    """Success and message of a solution with an error estimate, both in mean thresholds; `reason` says why it stopped
    short of the tolerance."""
    success = bool(error <= tolerance)
    message = f"error estimate {error:.1e} is within the tolerance {tolerance:.1e}" if success else reason
    if contacts.cut_weight > 0.0:
        message += f"; a starting weight of {contacts.cut_weight:.1e} beyond every threshold was cut off"
    return success, message
