"""Number conservation in its plainest form: the equation that `master.solve` solves, step by step. Second order.

docs/equations.md derives it. All contacts that are born within a step dX count as born in its middle, so that each
integral over births is a sum over the steps before.
"""

import numpy as np
import numpy.typing as npt

from origins import Contacts, Drive
from origins.contacts import check_contacts
from origins.errors import positive, refuse
from origins.thresholds.law import Array

# Most steps: work grows with their square, to some 3 s.
MOST_STEPS = 20_000
# Stretches of the start, evenly spaced: the error of averages over them is some 1e-7 of its width.
STRETCHES = 2_000


def renewal_force(contacts: Contacts, path: npt.ArrayLike, step: float) -> Array:
    """F/(N_c <k>) on a rigid slider that moves forward at T = 0 (paper, Eq. Q5a; as number conservation).

    contacts : thresholds and starting stretches, without other laws; broken contacts form again at x = 0.
    path : slider positions X >= 0 that never turn back, shape (n,), lengths; any spacing.
    step : dX, a length. The error falls with its square, with dX itself where exact thresholds break.

    Returns the force, shape (n,), a length, straight between the steps. Raises InputError for a path as in
    `master.solve`, for a step that needs more than 20,000 steps, and for other laws of the contacts.
    """
    check_contacts(contacts, "master.paper.renewal_force")
    path, step = Drive(path).only_forward("number conservation").path, positive("step", step)
    count = int(np.ceil(float(path[-1]) / step))
    if count > MOST_STEPS:
        refuse("step", step, f"needs {count:,} steps, more than {MOST_STEPS:,}; write a larger one")
    x = np.linspace(0.0, step * count, count + 1)  # positions of the slider
    start_holding, force_of_start = of_start(contacts, x)
    middle = x[:-1] + 0.5 * step  # stretches of contacts born in the middle of a step before
    survival = contacts.thresholds.sf(middle)  # E, of contacts born at x = 0
    births, force = np.zeros(count), force_of_start.copy()
    for n in range(1, count + 1):
        before = births[: n - 1] @ survival[1:n][::-1]
        births[n - 1] = (1.0 - start_holding[n] - before) / survival[0]
        force[n] += births[:n] @ (middle * survival)[:n][::-1]  # K = x E
    return np.interp(path, x, force)


def of_start(contacts: Contacts, x: Array) -> tuple[Array, Array]:
    """G_0 and M_0 at slider positions x >= 0, shape (n,): the fraction of the contacts of the start that still holds,
    and their force (a length)."""
    start, law = contacts.start, contacts.thresholds
    stretch, weight = np.array([start.mean()]), np.ones(1)
    if not start.is_single:
        ends = np.linspace(*start.span, STRETCHES + 1)
        stretch, weight = 0.5 * (ends[1:] + ends[:-1]), np.diff(start.cdf(ends))
    # at its start a contact has a threshold above |stretch|
    weight = weight / weight.sum() / np.maximum(law.sf(np.abs(stretch)), 1e-300)
    holding, force = np.empty((2, x.size))
    for n, distance in enumerate(x):
        each = weight * law.sf(np.maximum(np.abs(stretch), np.abs(stretch + distance)))
        holding[n], force[n] = each.sum(), each @ (stretch + distance)
    return holding, force
