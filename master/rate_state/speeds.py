"""Over which speeds the numbers of rate and state are constant."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from master.rate_state.law import EvolutionLaw
from master.rate_state.reading import read_steps
from master.rate_state.result import SpeedScan
from master.rate_state.traces import steps_about
from master.steady.kinetic import kinetic_curve
from origins import Contacts
from origins.errors import InputError
from origins.thresholds.law import Array

# ln of the factor of the speed for the slope of F_k
SLOPE_STEP = 0.25
# Error of that slope, in errors of F_k over SLOPE_STEP, where all four are off in the worst way: 4/3 from the near
# difference, which has the weight 4/3, and 1/6 from the far one.
SLOPE_OF_ERRORS = 1.5


class Range(NamedTuple):
    """The ends between which a number is constant, speeds or times at rest."""

    low: float
    high: float


class Slope(NamedTuple):
    """dF_k/d ln v, a force, and its error."""

    value: float
    error: float


def slope_at(contacts: Contacts, velocity: float) -> Slope:
    """dF_k/d ln v from F_k at speeds a factor e^(1/4) and e^(1/2) to either side, of fourth order in these."""
    powers = SLOPE_STEP * np.array([-2.0, -1.0, 1.0, 2.0])
    curve = kinetic_curve(contacts, velocity * np.exp(powers))
    near = float(curve.force[2] - curve.force[1]) / (2.0 * SLOPE_STEP)
    far = float(curve.force[3] - curve.force[0]) / (4.0 * SLOPE_STEP)
    off = float(np.max(curve.force_error)) * contacts.mean_threshold
    of_forces = SLOPE_OF_ERRORS * off / SLOPE_STEP
    return Slope(near + (near - far) / 3.0, abs(near - far) / 3.0 + of_forces)


def fill_scan(
    scan: SpeedScan,
    contacts: Contacts,
    ratio: float,
    evolution: EvolutionLaw,
    tolerance: float,
    progress: Callable[[str], None],
) -> None:
    """Solve for the numbers that the scan lacks, in place; they stay NaN where the contacts cannot be followed or do
    not become steady."""
    for number, speed in enumerate(scan.velocity):
        if np.isfinite(scan.a[number]):
            continue
        progress(f"steps about speed {number + 1} of {scan.velocity.size}")
        try:
            steps = steps_about(contacts, float(speed), ratio, tolerance)
        except InputError:
            continue
        if steps[0].settled:
            scan.keep(number, read_steps(steps, evolution))


def constant_between(at: Array, values: Array, middle: int, room: float) -> Range:
    """The ends between which values change by less than `room` from that at the index `middle`, between points by
    ln; values that are NaN end it."""
    ends = list[float]()
    for direction in (-1, 1):
        last = middle
        while (
            0 <= (after := last + direction) < at.size
            and abs(values[after] - values[middle]) < room
        ):
            last = after
        end = float(at[last])
        if 0 <= after < at.size and np.isfinite(values[after]):
            one, other = (abs(values[k] - values[middle]) for k in (last, after))
            end *= float((at[after] / at[last]) ** ((room - one) / (other - one)))
        ends.append(end)
    return Range(*ends)
