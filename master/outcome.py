"""Whether a solution meets its tolerance, as a flag and a message; and the progress callback."""

import time
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from origins import Contacts

WELL = 1e-3  # largest relative error of a force that counts as success, where there is no tolerance
# In so many of its estimated errors a number that is pinned by conservation may be off: an estimate is one of size.
NUMBERS = 10.0
# Excess of the number, in tolerances, above which it is no matter of steps: theirs was up to 1.4 (measured).
FAULT = 30.0
Progress = Callable[[float], None]
"""Called with the error estimate, in mean thresholds, that a solution has after each refinement."""


class StoppedError(Exception):
    """The slider cannot be followed any further, for the reason that the message gives."""


class FaultError(StoppedError):
    """What was found cannot be, whatever was asked: a fault of the program."""


def stop_after(until: float) -> None:
    """Raise StoppedError after this reading of time.monotonic()."""
    if time.monotonic() > until:
        raise StoppedError("stopped by wall_time")


def unheard(error: float) -> None:
    """The default progress callback: do nothing."""


def outcome(
    contacts: Contacts, error: float, tolerance: float, reason: str, what: str = ""
) -> tuple[bool, str]:
    """Success and message of a solution; error and tolerance are in mean thresholds, and `reason`
    says why the tolerance was missed, where it was. `what` : whose error it is, if not the force's,
    as " of holding"."""
    success = bool(error <= tolerance)
    within = f"error estimate {error:.1e}{what} is within the tolerance {tolerance:.1e}"
    message = within if success else reason
    start, thresholds = contacts.cut_weight, contacts.thresholds.cut_weight
    if start > 0.0:
        message += f"; a starting weight of {start:.1e} beyond every threshold was cut off"
    if thresholds > 0.0:
        message += f"; a weight of {thresholds:.1e} of the thresholds at or below x = 0 was cut off"
    return success, message


def unconserved(holding: npt.NDArray[np.float64], tolerance: float, error: float) -> str:
    """A message where more contacts hold than there are, beyond the tolerance and NUMBERS times the error of their
    number (shares of the contacts), else "". Conservation pins the number, but for steps that are too long: by more
    than FAULT tolerances only a fault of the program exceeds it."""
    most = float(holding.max(initial=0.0))
    if most <= 1.0 + max(tolerance, NUMBERS * error):
        return ""
    reason = f"number is not conserved: holding reaches {most:.6g}"
    if most <= 1.0 + FAULT * tolerance:
        return f"{reason}, above the tolerance {tolerance:.1e}; take a smaller one"
    return f"{reason}, a fault of the program"


def judged(what: str, errors: npt.ArrayLike, tolerance: float) -> tuple[npt.NDArray[np.bool_], str]:
    """Whether each error is within the tolerance (in the same unit), and a message with the largest
    error and the number of points that miss the tolerance."""
    each = np.asarray(errors, dtype=float)
    good, worst = each <= tolerance, float(each.max(initial=0.0))
    if good.all():
        return good, f"{what} known to {worst:.1e}, within {tolerance:.1e}"
    where = f" at {np.count_nonzero(~good)} of {good.size} points" if good.size > 1 else ""
    return good, f"{what} known to {worst:.1e} only{where}, above {tolerance:.1e}"
