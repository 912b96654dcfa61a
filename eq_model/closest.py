"""The paper's own algorithm (Sec. II): find the contact closest to breaking, shift all by the distance to its break.

It is the plain twin of an ensemble without laws, with the same statistics; every break takes a pass over all contacts.
"""

from itertools import chain, count

import numpy as np
import numpy.typing as npt

from origins import Contacts, Drive
from origins.contacts import check_contacts
from origins.errors import whole
from origins.start import FormationLaw
from origins.thresholds.law import Array


def closest(
    contacts: Contacts, path: npt.ArrayLike, *, n_contacts: int, seed: int = 0
) -> tuple[Array, int]:
    """Mean stretch of n_contacts contacts at each point of `path` (lengths, shape (n,)), and the number of breaks.

    Raises InputError for a path that does not go forward from 0 and for n_contacts below 1.
    """
    check_contacts(contacts, "eq_model.closest")
    positions = Drive(path).only_forward("the algorithm of the closest contact").path
    generator = np.random.default_rng(whole("seed", seed, 0))
    births = FormationLaw("start", contacts.start, contacts.thresholds)
    x, threshold = births.draw(whole("n_contacts", n_contacts, 1), generator)
    gap = threshold - x
    fresh = chain.from_iterable(contacts.thresholds.rvs(1024, generator) for _ in count())
    force, breaks, here = np.empty(positions.size), 0, 0.0
    for j, goal in enumerate(positions):
        holds_to_goal = False
        while not holds_to_goal:
            i = int(np.argmin(gap))
            holds_to_goal = here + gap[i] > goal
            step = goal - here if holds_to_goal else gap[i]
            x += step
            gap -= step
            here += step
            if not holds_to_goal:
                x[i], gap[i] = 0.0, next(fresh)
                breaks += 1
        here, force[j] = goal, x.mean()
    return force, breaks
