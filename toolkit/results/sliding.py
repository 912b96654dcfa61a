"""How an ensemble's sliders slide at the end of their path: their force, its scatter, whether it still rises, and
whether they may slip again."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from origins.thresholds.law import Array
from toolkit.results.slips import WITHOUT, regained_at

# mean thresholds of the slider's way, after which it slides; before, it may only be stretching its contacts
SLID = 10.0
# slips of a slider, of which the last ones tell when the next is due
DUE = 4
# part of what a drive adds to the spring's pull on a slider that sticks: a force that rises by more still rises
STILL = 0.5
# standard errors, by the scatter of the sliders, above which a rise is no chance
JERKS = 4.0


@dataclass(frozen=True)
class LateForce:
    """Mean force of sliders, F/(N_c <k>), with its standard error (lengths), and whether it still `rises`."""

    mean: float
    error: float
    rises: bool


def has_slid(found: Any, mean: float) -> bool:
    """Whether each slider of an ensemble has moved by so many thresholds that its contacts have formed anew."""
    return bool((found.positions[:, -1] - found.positions[:, 0]).min() >= SLID * mean)


def mean_forces(found: Any, late: Array) -> Array:
    """The mean force of each slider over these last points of the path; with a mass by the work of the drive, as few
    points may miss what swings between them."""
    if not hasattr(found, "energy"):
        return np.asarray(found.forces[:, late].mean(axis=1))
    work = found.energy.drive[:, late]
    return np.asarray((work[:, -1] - work[:, 0]) / np.ptp(found.path[late]))


def next_due(slips: Any, periods: float) -> float:
    """The drive's place by which another slip is due, so many periods behind the last one of a slider; -inf where none
    slipped DUE times. With a mass a slider may slide for longer than its spring takes to regain what a slip took."""
    due = [-np.inf]
    for replica in np.unique(slips.replica):
        own = slips.drive[slips.replica == replica]
        if own.size >= DUE:
            due.append(own[-1] + periods * float(np.median(np.diff(own[-DUE:]))))
    return float(max(due))


def may_go_on(found: Any, spring: float, settling: float, few: int) -> bool:
    """Whether sliders that slip, some of them more than `few` times, may do so again beyond their path: this spring has
    not regained what a slip took, or another is due, and the slider not slid along `settling` since."""
    if not found.slips.drive.size or found.slips.number.max() < few:
        return False
    over = max(regained_at(found.slips, spring, WITHOUT), next_due(found.slips, WITHOUT))
    return over + settling > float(found.path[-1])


def scatter_of(forces: Array) -> float:
    """The standard deviation between sliders of forces of shape (sliders, drive), at each place of the drive, as all of
    them may still rise, or swing as one."""
    return float(np.sqrt(forces.var(axis=0, ddof=1).mean()))


def late_force(forces: Array, drive: Array, spring: float, lives: float) -> LateForce:
    """The force of sliders on a `spring`, of shape (sliders, drive), whose contacts form anew so many times there."""
    each, rise = forces.mean(axis=1), forces[:, -1] - forces[:, 0]
    many = len(forces)
    jerks = JERKS * float(rise.std(ddof=1)) / many**0.5  # of sliders that go on step by step
    still = max(STILL * spring * float(drive[-1] - drive[0]), jerks)
    # no less than if each slider had another force in each life of its contacts
    least = scatter_of(forces) / (many * lives) ** 0.5
    error = max(float(each.std(ddof=1)) / many**0.5, least)
    return LateForce(float(each.mean()), error, float(rise.mean()) > still)
