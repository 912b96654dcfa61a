"""Number conservation on a slider that moves steadily forward, to the tolerances that slopes need."""

from __future__ import annotations

import numpy as np

from master.lives.life import Life
from master.motion.motion import Motion
from master.renewal.births import births_of
from master.renewal.march import March
from master.rigid import FINEST, GRAINS, longest_stretch, march_of
from master.steady.travel import Travel
from origins import Contacts

# Accuracy of the tables in units of the tolerance of K*, and the finest: a slope loses some four
# digits.
FINEST_TABLE, ACCURACY = 1e-13, 1e-6
# Smallest value, in mean thresholds, that is taken for the longest stretch: a smaller one would make
# the march's tolerance finer than rounding.
LEAST_STRETCH = 0.1
# Finest tolerance of a march, in units of the error of the survival.
TOLD = 10.0


def births_table(contacts: Contacts, life: Life, velocity: float, tolerance: float) -> Travel:
    """The table of E and K, as accurate as a march needs for slopes of F to this tolerance."""
    accuracy = max(ACCURACY * tolerance, FINEST_TABLE)
    return Travel(contacts, life, births_of(contacts), velocity, accuracy)


def forward_march(
    contacts: Contacts, births: Travel, velocity: float, horizon: float, tolerance: float
) -> March:
    """The march of contacts from their start to X = `horizon` (a length), not yet run.

    births : from `births_table`
    tolerance : of the force, in mean thresholds; limited by the error of the survival
    """
    life, mean = births.life, contacts.mean_threshold
    motion = Motion(np.array([0.0, horizon / velocity]), np.array([0.0, horizon]))
    first = max(abs(end) for end in contacts.start.span)
    # with heat contacts break long before they reach the longest stretch
    most = max(first + births.most, LEAST_STRETCH * mean)
    # some lives know their error only after they were evaluated for the stretches of the start
    life.left(contacts.start, motion.history(motion.times[None, 1:], np.zeros((1, 1))))
    told = max(FINEST, TOLD * (life.error + (0.0 if life.quick else births.table.error)))
    finest = told * min(longest_stretch(contacts, motion, life), most) / mean
    march = march_of(contacts, motion, life, max(tolerance, finest), most=most)
    if not life.quick:
        # an error of the force divided by the panel's width is one of the slope: avoid narrow panels
        march.grain = GRAINS * births.grain
    return march
