"""What is told of slips that take time, those of a slider with mass."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class SlipsOfMass:
    """What slips tell that take time; all None, and the error 0, of others, and where there is none.

    slip_time, top_speed : of the last main slip
    first_slip, first_forces : X_T as the first main slip begins, of an ensemble that of its first slider, and the
        spring force before and after it, of an ensemble the mean over sliders (lengths)
    first_error : of these forces, one standard error between sliders (a length), 0 of one
    """

    slip_time: float | None = None
    top_speed: float | None = None
    first_slip: float | None = None
    first_forces: tuple[float, float] | None = None
    first_error: float = 0.0


def slips_in_time(slips: Any) -> SlipsOfMass:
    """What these slips tell; of an ensemble they are its main ones."""
    if not _take_time(slips):
        return SlipsOfMass()
    main = _main(slips)
    forces, error = _first_forces(slips)
    return SlipsOfMass(
        slip_time=float(slips.duration[main[-1]]),
        top_speed=float(slips.top_speed[main[-1]]),
        first_slip=float(slips.drive[main[0]]),
        first_forces=forces,
        first_error=error,
    )


def _main(slips: Any) -> npt.NDArray[np.int_]:
    """Indices of the main ones, of an ensemble all."""
    return np.arange(slips.drive.size) if hasattr(slips, "replica") else np.asarray(slips.main)


def first_of(slips: Any) -> float | None:
    """Where the drive stands as the first main slip begins, of an ensemble that of its first slider; None without a
    slip, and for slips that take no time."""
    return float(slips.drive[_main(slips)[0]]) if _take_time(slips) else None


def _first_forces(slips: Any) -> tuple[tuple[float, float], float]:
    """The force before the first main slip, and after it (lengths), of slips that take time; of an ensemble their means
    over sliders, and the larger standard error of both (0 of one slider)."""
    first = slips.number == 0 if hasattr(slips, "replica") else slips.main[:1]
    both = np.array([slips.force_before[first], slips.force_after[first]])
    before, after = both.mean(axis=1).tolist()
    many = both.shape[1]
    error = float(both.std(axis=1, ddof=1).max()) / many**0.5 if many > 1 else 0.0
    return (before, after), error


def _take_time(slips: Any) -> bool:
    """Whether there are slips, and these take time."""
    return getattr(slips, "duration", None) is not None and bool(slips.drive.size)
