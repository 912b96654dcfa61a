"""The kinetic force at many speeds, in one call.

A contact with the threshold ξ breaks at min(ξ, x), A(x; ξ) = v e with e from the exponential law of mean 1. In ln e the
stretch x is smooth at any temperature and speed, so two Gauss sums, over ln e and over ξ, give <x_b> and <k x_b^2> for
all speeds together.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.cycle import LAWS, Cycle
from master.steady import steady_of
from origins import Contacts
from origins.contacts import check_contacts
from origins.errors import finite_array, refuse
from origins.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]

_LEAST, _MOST = -32.0, 7.0  # ln e: little is spent below, nothing is left above
_TOP = np.cbrt([2.0, 1.4, 0.9, 0.45, 0.0])
_TOLERANCE = 1e-9
_INVERSE = 1e-10  # relative error of a stretch found from its amount


@dataclass(frozen=True)
class KineticCurve:
    """Smooth sliding at many speeds.

    Attributes
    ----------
    velocity : array of shape (n,)
    force : array of shape (n,)
        F_k/(N_c <k>), a length.
    force_error : array of shape (n,)
        Its error in units of the mean threshold.
    holding : array of shape (n,)
        Fraction of the contacts that hold.
    run_time : float
        Seconds.
    """

    velocity: Array
    force: Array
    force_error: Array
    holding: Array
    run_time: float


def kinetic_curve(contacts: Contacts, velocity: npt.ArrayLike) -> KineticCurve:
    """F_k(v) of `contacts` at speeds of shape (n,), each above zero (length per time).

    Temperature with closure "exact" and relaxed births is summed over all speeds together; where that is not good to
    1e-9 of the force, and with every other law that speed tells, each speed is solved for by itself.

    Raises InputError as `steady_state` does, and for speeds that are not finite and above zero.
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.kinetic_curve", LAWS)
    speeds = finite_array("velocity", velocity)
    if (speeds <= 0.0).any():
        refuse("velocity", float(speeds[speeds <= 0.0][0]), "must be above zero")
    force, error, holding = (np.full(speeds.size, np.nan) for _ in range(3))
    thermal = contacts.thermal
    if thermal is not None and thermal.closure == "exact" and contacts.reforming is None:
        wait = 0.0 if contacts.delay is None else contacts.delay.time
        fine, coarse = (_moments(contacts, speeds, fine) for fine in (True, False))
        found, other = (0.5 * square / (length + wait * speeds) for length, square in (fine, coarse))
        # the finer panels are far better than what they differ from
        off = np.abs(found - other) + _INVERSE * found
        sure = off <= _TOLERANCE * found
        force[sure], error[sure] = found[sure], off[sure] / contacts.mean_threshold
        holding[sure] = (fine[0] / (fine[0] + wait * speeds))[sure]
    for i in np.flatnonzero(np.isnan(force)):
        steady = steady_of(contacts, Cycle(contacts, float(speeds[i])))
        force[i], error[i], holding[i] = steady.force, steady.force_error, steady.holding
        if thermal is None and contacts.delay is None and contacts.ageing is None:
            force[:], error[:], holding[:] = steady.force, steady.force_error, steady.holding
            break
    return KineticCurve(speeds, force, error, holding, time.perf_counter() - began)


def _moments(contacts: Contacts, speeds: Array, fine: bool) -> tuple[Array, Array]:
    """<x_b> and <k x_b^2> at each speed, relaxed births."""
    thermal, law = contacts.thermal, contacts.thresholds
    assert thermal is not None
    positions, shares = law.atoms
    if float(shares.sum()) < 1.0 - 1e-14:
        # slow contacts hold on to their strongest thresholds: the far tail counts
        edges = panel_edges(law, accuracy=1e-12 if fine else 1e-8, tail=1e-30 if fine else 1e-20)
        nodes, weights = gauss(edges[:-1], edges[1:])
        mass = (weights * law.pdf(nodes)).ravel()
        felt = mass > (1e-26 if fine else 1e-18)
        positions, shares = np.append(nodes.ravel()[felt], positions), np.append(mass[felt], shares)
    stiffness = contacts.relative_stiffness(positions)
    log_all = thermal.log_cumulative(positions, positions, stiffness=stiffness)
    # ln A below that of the threshold, the same for all speeds; by cube roots where a stiff contact's x has a power 2/3
    deepest = _LEAST - max(float(log_all.max() - np.log(speeds.min())), 0.0)
    left = np.linspace(deepest, -2.0, 2 + int((-2.0 - deepest) / (0.6 if fine else 0.85)))
    below, width = gauss(left[:-1], left[1:])
    roots, across = gauss(_TOP[1:], _TOP[:-1])
    below = np.append(below.ravel(), -(roots.ravel() ** 3))
    width = np.append(width.ravel(), (3.0 * roots * roots * across).ravel())
    amount = log_all[:, None] + below
    x = thermal.inverse(np.exp(amount), positions[:, None], stiffness=stiffness[:, None])
    length, square = np.zeros(speeds.size), np.zeros(speeds.size)
    ends, mixed = (shares * positions, shares * stiffness * positions**2)
    first, second = shares[:, None] * width * x, (shares * stiffness)[:, None] * width * x * x
    for i, log_speed in enumerate(np.log(speeds)):
        used = (below > _LEAST - (log_all.max() - log_speed)) & (below < _MOST - (log_all.min() - log_speed))
        power = np.minimum(amount[:, used] - log_speed, _MOST)
        weight = np.exp(power - np.exp(power))
        rest = np.exp(-np.exp(np.minimum(log_all - log_speed, _MOST)))
        length[i] = float((weight * first[:, used]).sum() + rest @ ends)
        square[i] = float((weight * second[:, used]).sum() + rest @ mixed)
    return length, square
