"""Contacts that age, by finite volumes: the density of y = threshold - x, that vanishes where the stretch meets it.

With the master equation, which follows first passages by integral equations, it shares the law of ageing alone.
"""

import numpy as np
from scipy.linalg import solve_banded

from origins.contacts import Contacts
from origins.errors import InputError
from origins.thresholds.law import Array

_CELLS = 96  # of y on the coarsest steps, narrow at 0 and wider and wider beyond
_FORGOTTEN = 1e-15  # share of fresh thresholds beyond the last cell
_SPREAD = 9.0  # standard deviations of the diffusion that are kept


def aged_lives(
    contacts: Contacts, velocity: float, travel: Array, halvings: int
) -> tuple[Array, Array]:
    """Density of breaks per length, and force, of contacts that formed relaxed, by the even way since.

    By steps of Crank and Nicolson, of which the error is of the second order in the step and in 1/_CELLS, which
    `halvings` doubles. Raises InputError for starts of their own and for heat, for the paper's closure, and for final
    thresholds that are not Gaussian.
    """
    law, ageing = contacts.thresholds, contacts.ageing
    normal = None if ageing is None or ageing.closure == "paper" else ageing.normal
    relaxed = contacts.start.is_single and contacts.start.mean() == 0.0
    if normal is None or not normal.rate or contacts.thermal is not None or not relaxed:
        raise InputError(
            "ageing: only of relaxed contacts, in the exact closure, towards a Gaussian"
        )
    diffusion = normal.rate * normal.std**2
    step, time = travel[1] - travel[0], travel[-1] / velocity
    largest = float(law.isf(_FORGOTTEN))
    largest = max(largest, float(normal.mean_after(largest, time)))
    largest += _SPREAD * float(normal.std_after(time))
    # diffusion bends the density over this length, by which the stretch overtakes thresholds
    bend = 2.0 * diffusion / velocity
    edges = bend * np.expm1(np.linspace(0.0, np.log1p(largest / bend), 1 + _CELLS * 2**halvings))
    width, middle = np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    apart = np.diff(middle, prepend=0.0)  # from each cell to the one before it, or to the wall at 0
    # the weight of the cell before at the edge between
    before = np.append(0.0, (middle[1:] - edges[1:-1]) / apart[1:])

    def rates(stretch: float) -> Array:
        """What flows into each cell from the next, itself and the one before, per time, as solve_banded takes it."""
        drift = normal.rate * (normal.mean - stretch - edges[:-1]) - velocity
        from_before = drift * before + diffusion / apart
        from_itself = drift * (1.0 - before) - diffusion / apart
        from_before[0], from_itself[0] = 0.0, -diffusion / apart[0]
        banded = np.zeros((3, width.size))
        banded[0, 1:] = -from_itself[1:] / width[:-1]
        banded[1] = from_itself / width
        banded[1, :-1] -= from_before[1:] / width[:-1]
        banded[2, :-1] = from_before[1:] / width[1:]
        return banded

    density, half, now = -np.diff(law.sf(edges)) / width, 0.5 * step / velocity, rates(0.0)
    breaks, survival = np.empty_like(travel), np.empty_like(travel)
    for k, stretch in enumerate(travel):
        if k:
            right_side = density * (1.0 + half * now[1])
            right_side[:-1] += half * now[0, 1:] * density[1:]
            right_side[1:] += half * now[2, :-1] * density[:-1]
            now = rates(stretch)
            unknown = -half * now
            unknown[1] += 1.0
            density = solve_banded((1, 1), unknown, right_side, check_finite=False)
        breaks[k] = diffusion * density[0] / (apart[0] * velocity)
        survival[k] = width @ density
    return breaks, travel * survival
