"""The paper's own algorithm (Sec. II): find the contact closest to breaking, shift all by the distance to its break.

It is the plain twin of an ensemble without laws, with the same statistics; every break takes a pass over all contacts.
"""

import numpy as np
import numpy.typing as npt

from origins import Contacts, Drive
from origins.contacts import check_contacts
from origins.errors import whole
from origins.start import Births

Array = npt.NDArray[np.float64]


def closest(
    contacts: Contacts, path: npt.ArrayLike, *, n_contacts: int, seed: int = 0
) -> tuple[Array, int]:
    """Mean stretch of n_contacts contacts at each point of `path` (lengths, shape (n,)), and the number of breaks.

    Raises InputError for a path that does not go forward from 0 and for n_contacts below 1.
    """
    check_contacts(contacts, "eq_model.closest")
    positions = Drive(path).only_forward("the algorithm of the closest contact").path
    generator = np.random.default_rng(whole("seed", seed, 0))
    births = Births("start", contacts.start, contacts.thresholds)
    x, threshold = births.draw(whole("n_contacts", n_contacts, 1), generator)
    gap = threshold - x
    fresh, used = contacts.thresholds.rvs(1024, generator), 0
    force, breaks, here = np.empty(positions.size), 0, 0.0
    for j, goal in enumerate(positions):
        while True:
            i = int(np.argmin(gap))
            step = gap[i]
            if here + step > goal:
                break
            x += step
            gap -= step
            here += step
            if used == fresh.size:
                fresh, used = contacts.thresholds.rvs(1024, generator), 0
            x[i], gap[i] = 0.0, fresh[used]
            used += 1
            breaks += 1
        step = goal - here
        x += step
        gap -= step
        here = goal
        force[j] = x.mean()
    return force, breaks
