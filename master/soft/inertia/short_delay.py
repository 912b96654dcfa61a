"""A delay so short that it only takes from the damping: it is left out, and its effect on the motion is known.

Steady sliding at the speed V has the friction F_k/(1 + τ V/<x_s>), to first order in the delay F_k - g V with
g = F_k τ/<x_s>: the motion is that of contacts that form at once, under the damping γ - g. That costs nothing where
panels of time would follow oscillations that the delay hardly changes, thousands of them on the spring of a machine.
"""

from typing import NamedTuple

import numpy as np

from master.soft.inertia.foretold import oscillations
from master.soft.inertia.record import Record
from master.soft.inertia.run import Run
from origins import Contacts
from origins.drive import Drive
from origins.thresholds.law import Array

# Part of the damping that the delay may take: near 1 terms of second order decide whether sliding is stable.
MOST_TAKEN = 0.5
# Share τ V/<x_s> of the contacts that wait at the largest speed, up to which the delay is taken to first order.
MOST_WAITING = 0.1
# Spring, in N_c<k>, up to which it is tried: on stiffer ones slips pass so few thresholds that none is steady.
SOFT = 0.03
# Way after which sliding is nearly steady, in mean thresholds; before that the delay changes the force as much, but in
# another way. Of 20 random machines on springs from 1e-4 to 0.03, held beside panels of time, the true error was at
# most a quarter of the one that is told.
UNSTEADY = 30.0
# Density of a normal law at its mean, per standard deviation; and a variance in place of 0 (lengths squared).
PEAK, TINY = 0.4, 1e-300
# Parts of the tolerance: that the error of leaving it out may have, and that of the motions with and without it, whose
# difference need not be known well.
OF_TOLERANCE, OF_RUN = 0.5, 0.5


class ShortDelay(NamedTuple):
    """What is solved in place of contacts with a delay.

    contacts, drive : without it, under the damping that it leaves
    waiting : τ/<x_s>, per speed the share of the contacts that wait, to first order
    taken : g/(γ - g), by which the energy that this damping takes is too small
    unsure : part of what the delay changes that is not known
    error, of_holding : of the force, in mean thresholds, and of the share that holds
    """

    contacts: Contacts
    drive: Drive
    waiting: float
    taken: float
    unsure: float
    error: float
    of_holding: float

    def correct(self, record: Record) -> None:
        """What the delay changes in the results at the asked times beside the force: the share that holds, as in steady
        sliding, and the energy of the damping, of which contacts that break release as much less."""
        record.holding /= 1.0 + self.waiting * np.abs(record.speed)
        record.on_contacts -= self.taken * record.damped
        record.damped *= 1.0 + self.taken

    def of_energy(self, damped: Array) -> float:
        """The error of energies (length squared) where the damping, as it is told, has taken these."""
        return self.taken * self.unsure * float(np.nanmax(damped, initial=0.0))

    @property
    def message(self) -> str:
        """What is said of it."""
        return f"the delay is taken as a part of the damping, which changes the force by at most {self.error:.1e}"


def short_delay(
    contacts: Contacts, drive: Drive, tolerance: float, until: float
) -> ShortDelay | None:
    """The same without the delay, where that is known to half of the tolerance.

    Its error is a part of the change that the delay makes, between the damping γ and γ - g: what is of second order,
    twice the share that waits at the largest speed, and the part of the way that is not steady.
    """
    spring, unit, law = float(drive.spring or 0.0), contacts.mean_threshold, contacts.thresholds
    waiting = contacts.waiting_time / unit
    takes = waiting * 0.5 * law.moment(2) / unit
    if spring > SOFT or takes > MOST_TAKEN * drive.damping or law.atoms[0].size:
        return None
    without = contacts.replace(delay=None)
    damped = Drive(
        drive.path,
        drive.velocity,
        drive.time,
        drive.spring,
        mass=drive.mass,
        damping=drive.damping - takes,
    )
    if oscillations(without, damped)[0]:
        return None
    run = Run(without, damped, tolerance, OF_RUN, until)
    if run.stopped:
        return None
    undelayed = Run(without, drive, tolerance, OF_RUN, until)
    changes = run.differ(undelayed).force
    if undelayed.stopped or not np.isfinite(changes):
        return None
    slips, pulled = run.slips(0.0), fastest_of(drive)
    fastest = max(
        pulled,
        *(float(np.abs(one).max(initial=0.0)) for one in (run.record.speed, slips.top_speed)),
    )
    waits = waiting * fastest
    distance = min(float(np.abs(slips.after - slips.before).min(initial=np.inf)), unit / spring)
    unsure = 2.0 * waits + UNSTEADY * unit / distance
    error = changes * unsure + waiting * pulled
    if waits > MOST_WAITING or error > OF_TOLERANCE * tolerance:
        return None
    # contacts of narrow thresholds break at once, and a share of the peak of the law waits
    width = np.sqrt(max(law.moment(2) - law.mean() ** 2, TINY))
    of_holding = 2.0 * waits * max(1.0, PEAK * unit / width)
    taken = takes / (drive.damping - takes)
    return ShortDelay(without, damped, waiting, taken, unsure, error, of_holding)


def fastest_of(drive: Drive) -> float:
    """The largest speed of a drive."""
    times = drive.arrival_times(0.0)
    distances = np.abs(np.diff(drive.path, prepend=0.0))
    lasts = np.diff(times, prepend=0.0)
    return float(np.divide(distances, lasts, out=np.zeros(distances.size), where=lasts > 0.0).max())
