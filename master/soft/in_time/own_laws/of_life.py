"""Any law that has a life, under a spring: each group keeps where and when it was born, and asks for its survival along
the slider's way since.

Steps are tried before one is taken, so that ways branch: each place knows the one before it.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.motion import History, Motion
from master.outcome import FaultError
from master.soft.in_time.memory import Memory, warm_nodes
from master.soft.in_time.own_laws.along import refuse_without_life, scales_along
from master.soft.in_time.threshold_cells import StraightMove
from master.survival.make import life_of
from origins import Contacts, InputError
from origins.thresholds.law import Array

# A life asks when a contact was where. So steps of a slip, which take no time, take this part of the time since the
# oldest birth: 1e5 times its rounding. And the place of those just born, which is not known yet.
IN_SLIP, BORN = 1e-11, -1.0


class Place(NamedTuple):
    """Where a tried step ends: the number of the place where it begins, its time and its travel."""

    before: int
    lasts: float
    travel: float


class LifeMemory(Memory):
    """Of any law that has a life for sliders that turn and rest: asks it for contacts with the way since their birth.

    That takes as many operations for each group as steps since its birth.

    motion : of the drive, None where it stands
    """

    error = 1e-9  # by the time that slips take here

    def __init__(self, contacts: Contacts, halvings: int, motion: Motion | None) -> None:
        refuse_without_life(contacts)
        if contacts.older_at_start:
            raise InputError(
                f"contacts.{', '.join(contacts.in_time)}: contacts of the start are older than others, of which a "
                "spring asks no life; start with contacts that have just formed, or leave the spring out"
            )
        self._life = None if motion is None else life_of(contacts, motion=motion)
        self._whole = 0.0 if motion is None else float(motion.times[-1])
        self._places, self.width, self.starts = list[Place](), 3, warm_nodes(halvings)
        self.largest_stretch = contacts.thresholds.support()[1]
        self.scales = scales_along(contacts, motion)

    def start(self, stretch: Array) -> Array:
        """See Memory; those just born have no place yet: it is that of the others, from which the next step begins."""
        return np.stack([*np.full((2, stretch.size), BORN), stretch], axis=1)

    def advance(self, record: Array, leg: StraightMove) -> Array:
        places, out = self._places, record.copy()
        here = int(record[0, 0])
        if here == BORN:  # all are new
            here = len(places)
            places.append(Place(here, 0.0, 0.0))
        out[out[:, 1] == BORN, 1] = here
        out[:, 0] = len(places)
        places.append(Place(here, leg.duration, float(leg.end[0] - leg.begin[0])))
        return out

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        survival, old = np.ones(stretch.size), record[:, 1] != BORN
        force = stretch.copy()
        if old.any():
            if self._life is None:
                raise FaultError(
                    "contacts were moved on no known motion of the drive, a fault of the program"
                )
            history = self._history(int(record[0, 0]), record[old, 1].astype(int))
            born = record[old, 2]
            found = self._life.survivors(born, history.largest(born), history)
            survival[old], force[old] = found.survival, found.force
            self.error = max(self.error, found.error)
        return np.stack([survival, force])

    def _history(self, now: int, births: npt.NDArray[np.intp]) -> History:
        """The moves of contacts from these places up to now."""
        first, way = int(births.min()), [now]
        while way[-1] != first:
            way.append(self._places[way[-1]].before)
        way.reverse()
        _, lasts, travel = np.array([self._places[place] for place in way[1:]]).T
        times = np.append(0.0, np.cumsum(lasts))
        shortest = IN_SLIP * np.maximum(times[1:], float(lasts.max()) or self._whole)
        times = np.append(0.0, np.cumsum(np.maximum(lasts, shortest)))
        motion = Motion(times, np.append(0.0, np.cumsum(travel)))
        since = times[np.searchsorted(way, births)][:, None]
        return motion.history(np.full(since.shape, times[-1]), since).pick(slice(None))
