"""Whether a solution is as good as was asked, in words."""

from origins import Contacts


def outcome(contacts: Contacts, error: float, tolerance: float, reason: str) -> tuple[bool, str]:
    """Success and message of a solution with an error estimate, both in mean thresholds; `reason` says why it stopped
    short of the tolerance."""
    success = bool(error <= tolerance)
    message = f"error estimate {error:.1e} is within the tolerance {tolerance:.1e}" if success else reason
    if contacts.cut_weight > 0.0:
        message += f"; a starting weight of {contacts.cut_weight:.1e} beyond every threshold was cut off"
    return success, message
