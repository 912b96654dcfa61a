"""Number conservation on a slider that moves steadily forward, with tables of what is left."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.motion.motion import History, Motion
from master.renewal.births import Births
from master.renewal.edges import edges
from master.renewal.march import March
from master.rigid import FINEST, GRAINS, longest_stretch
from master.steady.steady import births_of
from master.steady.travel import Travel
from origins import Contacts, InputError
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# Last coefficients of the tables, at least, and in units of the tolerance of K*: a slope loses some
# four digits.
FINEST_TABLE, ACCURACY = 1e-13, 1e-6
# Of the error of the tables, what a march on them tells.
TOLD = 10.0
# The least stretch by which errors of the number of breaks are weighed, in mean thresholds.
LEAST_STRETCH = 1e-3
TOO_MANY = (
    "thresholds: exact values break together more often than can be followed; give them a width, "
    "as in gaussian(mean, std)"
)


def births_table(contacts: Contacts, life: Life, velocity: float, tolerance: float) -> Travel:
    """The table of births that a march of slopes to a tolerance needs."""
    accuracy = max(ACCURACY * tolerance, FINEST_TABLE)
    return Travel(life, births_of(contacts), velocity, accuracy)


class ForwardLife:
    """A Life over the way since birth: contacts of the start, and of births, each by one table.

    In this picture all contacts are born at 0, and their "stretch" is the way that they have gone;
    `again` and `at_start` tell those of births and of the start apart.

    Parameters
    ----------
    life : Life
    births, start : Travel
        Tables of contacts born at the stretches of re-forming, and of the start.
    """

    quick = timeless = fresh_start = True
    pair_work = 1

    def __init__(self, life: Life, births: Travel, start: Travel) -> None:
        self.again, self.at_start = SingleStart(0.0), SingleStart(0.0)
        self._births, self._start = births, start
        both = births, start
        self.reach = max(travel.longest for travel in both)
        self.quiet = 0.0
        self.atoms: Array = np.unique(np.concatenate([travel.atoms for travel in both]))
        bends = np.concatenate([travel.bends for travel in both])
        self.bends: Array = np.unique(bends[bends <= self.reach])
        self.bend_sizes: Array = np.ones(self.bends.size)
        lost = -np.diff(births.table(births.table.edges)[0])
        weight = np.maximum(lost, 0.0)
        self.grain = float(births.table.widths @ weight / weight.sum())
        self.error = life.error + max(travel.table.error for travel in both)

    def marks(self, width: float) -> Array:
        """See Life."""
        return np.union1d(self.bends, self._births.table.fine(width))

    def atom_share(self, atom: float, stretch: float) -> float:
        """See Life; `atom` is the way after which contacts reach an exact threshold together."""
        at, before = np.array(atom), np.array(atom * (1.0 - 1e-9))
        tables = self._births.table, self._start.table
        return max(float(table(at, before)[0] - table(at)[0]) for table in tables)

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life; born is `again` or `at_start`."""
        travel = self._start if born is self.at_start else self._births
        way = history.now
        middle = way[:, way.shape[1] // 2, None]
        # at the end of a row a jump is not passed, or has been, as the middle of the row tells
        inwards = np.maximum(1e-14 * np.abs(middle - way), 4.0 * np.spacing(way))
        found = travel.table(np.maximum(way + np.clip(middle - way, -inwards, inwards), 0.0))
        found[1] *= travel.scale
        return found


class Forward:
    """Marches of contacts from their start to X = `horizon`, at one speed.

    Parameters
    ----------
    contacts : Contacts
    life : Life
        Theirs.
    births : Travel
        The table of births, such as `births_table` makes; read where `life` takes longer.
    velocity : float
        v > 0, length per time.
    horizon : float
        A length.

    Attributes
    ----------
    finest : float
        The finest tolerance of a march, in mean thresholds.
    """

    def __init__(
        self, contacts: Contacts, life: Life, births: Travel, velocity: float, horizon: float
    ) -> None:
        self.again, self.start, self.life = births.born, contacts.start, life
        if not life.quick:
            alike = births.born.is_single and contacts.start.span == births.born.span
            alike = alike and life.fresh_start
            start = births if alike else Travel(life, contacts.start, velocity, births.accuracy)
            self.life = forward = ForwardLife(life, births, start)
            self.again, self.start = forward.again, forward.at_start
        self.mean, self.wait = contacts.mean_threshold, velocity * contacts.waiting_time
        self.motion = Motion(np.array([0.0, horizon]), np.array([0.0, horizon]))
        first = max(abs(end) for end in contacts.start.span)
        most = min(first + births.most, longest_stretch(contacts, self.motion, life))
        self.stretch = max(most, LEAST_STRETCH * self.mean)
        self.finest = max(FINEST, TOLD * self.life.error) * self.stretch / self.mean

    def march(self, tolerance: float) -> March:
        """The march to a tolerance of the force in mean thresholds; its times are ways."""
        life = self.life
        allowed = max(tolerance, self.finest) * self.mean / self.stretch
        births = Births(life, self.again, self.motion, self.wait)
        found = edges(self.motion, life, self.start, self.again, self.wait, allowed)
        if found.too_many_lumps:
            raise InputError(TOO_MANY)
        grain = GRAINS * life.grain
        return March(births, self.start, found.times, allowed, grain, self.stretch).run()
