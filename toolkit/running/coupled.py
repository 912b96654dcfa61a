"""An ensemble on a soft slider: what is kept of it, and its slips beside those of the master equation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from toolkit.results.records import CoupledRecord, Result, SoftRecord
from toolkit.scene.interfaces import with_error

if TYPE_CHECKING:
    from toolkit.scene.scene import Scene
    from toolkit.scene.tables import EqTable

_SHOWN = 10  # slips that are told one by one
_DIGITS = 7
_PILOT = 4096  # contacts
_EACH = 4e-8  # s for a break or a start, on a core of 2024; twice as long on an old one
_BEFORE = 2e-3  # s for a replica, however few its contacts
_BYTES = 24  # of a contact, at most


def coupled_lines(scene: Scene, asked: EqTable, comm: Any, done: int) -> list[str]:
    """What such an ensemble will take, foretold by one replica of few contacts; `done` of them need
    not be followed again."""
    from toolkit.running.runner import make_ensemble

    few = min(asked.contacts, _PILOT)
    pilot = make_ensemble(scene, asked, comm, n_contacts=few, n_replicas=1, wall_time=None)
    for _ in pilot:
        pass
    found, total = pilot.result(), asked.contacts * asked.replicas
    ranks = min(1 if comm is None else comm.Get_size(), asked.replicas)
    events = (found.breaks + found.contacts) / found.contacts * (total - done)
    seconds = (events * _EACH + (asked.replicas - done / asked.contacts) * _BEFORE) / ranks
    return [
        f"contacts        {total:,} in {asked.replicas:,} replicas"
        + (f", {done:,} of them done before" if done else ""),
        f"breaks          {found.breaks / found.contacts * total:.2g}, as {few:,} contacts tell",
        f"run time        {seconds:.1g} s on {ranks} rank(s), which share the replicas; [master] and "
        "compilation not counted",
        f"memory          {asked.contacts * _BYTES / 1e6:.0f} MB for each rank, besides what Python takes",
    ]


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
    if not isinstance(solved, SoftRecord) or not isinstance(eq, CoupledRecord):
        return []
    slips, found = eq.slips, []
    for number, (drive, drop) in enumerate(zip(solved.slip_drive, solved.slips.drop, strict=True)):
        have = int((slips.number == number).sum())
        if have:
            own = *slips.mean("drive", number), *slips.mean("drop", number)
            found.append(SlipBeside(number, float(drive), float(drop), *own, have))
    return found


def slip_lines(result: Result) -> list[str]:
    """The comparison slip by slip, as lines of text; none where it is not of soft sliders."""
    solved, eq = result.master, result.eq
    if not isinstance(eq, CoupledRecord):
        return []
    replicas, own = len(eq.forces), eq.slip_number.size
    sizes = f"avalanches of at least {eq.slip_fraction:g} of the contacts"
    if not isinstance(solved, SoftRecord):
        return [f"slips   {own} in {replicas} replicas: {sizes}"]
    beside = slips_beside(result)
    lines = [_line(slip, replicas, result.mean_threshold) for slip in beside[:_SHOWN]]
    if len(beside) > _SHOWN:
        lines.append(f"slips   and {len(beside) - _SHOWN} more, in result.h5")
    scale = (eq.contacts / replicas) ** (-2.0 / 3.0)
    lines.append(
        f"slips   {solved.slip_drive.size} of the master equation, {own} of eq in {replicas} replicas: {sizes}; N "
        f"contacts slip late by some N^(-2/3) = {scale:.1e} of <x_s>, more at each slip, and the more the softer the "
        "spring"
    )
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
