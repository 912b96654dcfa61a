"""Number conservation on a slider that moves steadily forward, to tolerances that slopes ask for."""

from __future__ import annotations

import numpy as np

from master.lives.life import Life
from master.motion.motion import Motion
from master.renewal.births import births_of
from master.renewal.march import March
from master.rigid import FINEST, GRAINS, longest_stretch, march_of
from master.steady.travel import Travel
from origins import Contacts

# Last coefficients of the tables, at least, and in units of the tolerance of K*: a slope loses some
# four digits.
FINEST_TABLE, ACCURACY = 1e-13, 1e-6
# Of the mean threshold: a march to less than what so long a stretch bears would follow rounding.
LEAST_STRETCH = 0.1
# Of the error of what is left of contacts, what a march tells.
TOLD = 10.0


def births_table(contacts: Contacts, life: Life, velocity: float, tolerance: float) -> Travel:
    """The table of births that a march of slopes to a tolerance needs."""
    accuracy = max(ACCURACY * tolerance, FINEST_TABLE)
    return Travel(life, births_of(contacts), velocity, accuracy)


def forward_march(
    contacts: Contacts, births: Travel, velocity: float, horizon: float, tolerance: float
) -> March:
    """The march of contacts from their start to X = `horizon` (a length), yet to be run.

    births : as `births_table` makes it
    tolerance : of the force, in mean thresholds; no finer one is taken than the life is known to
    """
    life, mean = births.life, contacts.mean_threshold
    motion = Motion(np.array([0.0, horizon / velocity]), np.array([0.0, horizon]))
    first = max(abs(end) for end in contacts.start.span)
    # with heat contacts break long before they are as long as they may be
    most = max(first + births.most, LEAST_STRETCH * mean)
    # a life may learn how good it is as it is asked for the stretches of the start
    life.left(contacts.start, motion.history(motion.times[None, 1:], np.zeros((1, 1))))
    told = max(FINEST, TOLD * (life.error + (0.0 if life.quick else births.table.error)))
    finest = told * min(longest_stretch(contacts, motion, life), most) / mean
    march = march_of(contacts, motion, life, max(tolerance, finest), most=most)
    if not life.quick:
        # an error of a slope is one of the force over the width of a panel: no narrower ones than need be
        march.grain = GRAINS * births.grain
    return march
