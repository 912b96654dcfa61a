"""Slips of an ensemble on a soft slider beside those of the master equation, one by one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.results.records import Result, SoftRecord, is_coupled
from toolkit.scene.interfaces import with_error

_SHOWN = 10  # slips that are told one by one
_DIGITS = 7


class SlipBeside(NamedTuple):
    """One slip of the master equation beside those of the replicas, which have means and standard errors (lengths).

    drive, drop : X_T, and how far the force falls, of the master equation; have : how many replicas slip as often.
    """

    number: int
    drive: float
    drop: float
    mean_drive: float
    drive_error: float
    mean_drop: float
    drop_error: float
    have: int


def slips_beside(result: Result) -> list[SlipBeside]:
    """Slips in turn, of a result that has both solvers' on a soft slider; none of others."""
    solved, eq = result.master, result.eq
    if not isinstance(solved, SoftRecord) or not is_coupled(eq):
        return []
    slips, found = eq.slips, []
    for number, (drive, drop) in enumerate(zip(solved.slips.drive, solved.slips.drop, strict=True)):
        if have := int((slips.number == number).sum()):
            own = *slips.mean("drive", number), *slips.mean("drop", number)
            found.append(SlipBeside(number, float(drive), float(drop), *own, have))
    return found


def slip_lines(result: Result) -> list[str]:
    """The comparison slip by slip, as lines of text; none where it is not of soft sliders."""
    solved, eq = result.master, result.eq
    if not is_coupled(eq):
        return []
    replicas, own = len(eq.forces), eq.slips.number.size
    least = f"avalanches of at least {eq.slip_fraction:g} of the contacts"
    sizes = f"in {replicas} replicas: {least}"
    if not isinstance(solved, SoftRecord):
        return [f"slips   {own} {sizes}"]
    beside = slips_beside(result)
    lines = [_line(slip, replicas, result.mean_threshold) for slip in beside[:_SHOWN]]
    if len(beside) > _SHOWN:
        lines.append(f"slips   and {len(beside) - _SHOWN} more, in result.h5")
    number, late = solved.slips.drive.size, "N contacts slip late by some N^(-2/3)/K"
    if number:
        # of a slip on a spring K the force falls by K times the way
        spring = abs(solved.slips.drop[0] / (solved.slips.after[0] - solved.slips.before[0]))
        scale = (eq.contacts / replicas) ** (-2.0 / 3.0) / spring
        late += f" = {scale:.1e} of <x_s>, more at each slip"
    lines.append(f"slips   {number} of the master equation, {own} of eq {sizes}; {late}")
    return lines


def _line(slip: SlipBeside, replicas: int, unit: float) -> str:
    off = slip.mean_drive - slip.drive
    drive = with_error(slip.mean_drive, slip.drive_error, _DIGITS)
    drop = with_error(slip.mean_drop, slip.drop_error, _DIGITS)
    known = 0.0 < slip.drive_error < np.inf
    scatter = f": {off / slip.drive_error:.1f} standard errors" if known else ""
    return (
        f"slip {slip.number + 1:<3}X_T {slip.drive:.9g}, eq {drive} in {slip.have} of {replicas} "
        f"replicas, {'late' if off >= 0.0 else 'early'} by {abs(off) / unit:.1e} of <x_s>{scatter}; "
        f"falls by {slip.drop:.6g}, eq {drop}"
    )
