"""Number conservation on a slider that moves steadily forward, to tolerances that slopes ask for."""

from __future__ import annotations

import numpy as np

from master.lives.life import Life
from master.motion.motion import Motion
from master.renewal.march import March
from master.rigid import FINEST, GRAINS, longest_stretch, march_of
from master.steady.steady import births_of
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


class Forward:
    """Marches of contacts from their start to X = `horizon`, at one speed.

    Parameters
    ----------
    contacts : Contacts
    life : Life
        Theirs.
    births : Travel
        The table of births, such as `births_table` makes.
    velocity : float
        v > 0, length per time.
    horizon : float
        A length.

    Attributes
    ----------
    wait : float
        The way that the slider goes while a broken contact is out, a length.
    finest : float
        The finest tolerance of a march, in mean thresholds.
    """

    def __init__(
        self, contacts: Contacts, life: Life, births: Travel, velocity: float, horizon: float
    ) -> None:
        self._contacts, self._life, self._velocity = contacts, life, velocity
        self._motion = Motion(np.array([0.0, horizon / velocity]), np.array([0.0, horizon]))
        self.wait = velocity * contacts.waiting_time
        first = max(abs(end) for end in contacts.start.span)
        # with heat contacts break long before they are as long as they may be
        self._most = max(first + births.most, LEAST_STRETCH * contacts.mean_threshold)
        stretch = min(longest_stretch(contacts, self._motion, life), self._most)
        # a life may learn how good it is as it is asked for the stretches of the start
        now = np.array([[horizon / velocity]])
        life.left(contacts.start, self._motion.history(now, np.zeros((1, 1))))
        lost = np.maximum(-np.diff(births.table(births.table.edges)[0]), 0.0)
        self._grain = float(births.table.widths @ lost / lost.sum())
        told = max(FINEST, TOLD * (life.error + (0.0 if life.quick else births.table.error)))
        self.finest = told * stretch / contacts.mean_threshold

    def march(self, tolerance: float) -> March:
        """The march to a tolerance of the force in mean thresholds; its begins and widths are ways."""
        tolerance = max(tolerance, self.finest)
        given = self._contacts, self._motion, self._life, tolerance
        march = march_of(*given, most=self._most)
        # an error of a slope is one of the force over the width of a panel: no narrower ones than need be
        march.grain = march.grain if self._life.quick else GRAINS * self._grain
        march.run()
        for lengths in (march.begin, march.width):
            lengths[:] = [self._velocity * length for length in lengths]
        return march
