"""(Q3back), (Q4back), (Q5aback): the paper's friction loop (App. C), stepped forward and back.

It is kept as the plain twin of `master.solve` on a path that turns round. Backward motion is
forward motion with P_b(x) = P(-x): breaking depends on x alone, and a survivor's past is forgotten.
A contact that was pulled to 0.9 and back to -0.5 is treated as if its threshold could be 0.6, which
it would not have survived. So after a turn this differs from the discrete model: with P_c(1, 0.2)
the force is off by 0.04 where turns are at +-3, by 0.18 where they are at +-0.9.
"""

import numpy as np
import numpy.typing as npt

from master.paper.explicit import Breaking, ExplicitSolution, followed, largest_stretch
from origins import Contacts
from origins.contacts import check_contacts
from origins.errors import finite_array


def explicit_loop(
    contacts: Contacts, path: npt.ArrayLike, step: float, breaking: Breaking = "survival"
) -> ExplicitSolution:
    """F along a path that turns, T = 0, dx = dX = step (paper, Eqs. Q3back, Q4back and Q5aback).

    Parameters
    ----------
    contacts : Contacts
        Thresholds and starting stretches.
    path : array of shape (n,)
        Slider positions X (lengths) from X = 0 on, straight between points, of either sign. Turning
        points are moved to the nearest multiple of `step`.
    step : float
        dx = dX (a length).
    breaking : "survival" or "printed"
        As in `explicit`.

    Raises InputError for a path that is not finite, for `step` and `breaking` as `explicit` does.
    """
    check_contacts(contacts, "master.paper.explicit_loop")
    positions = finite_array("path", path)
    reach = largest_stretch(contacts, float(np.ptp(np.append(positions, 0.0))))
    return followed(contacts, positions, (-reach, reach), step, breaking)
