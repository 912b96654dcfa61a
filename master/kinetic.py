"""The kinetic force along speeds, temperatures, rates of ageing and delays, in one call.

Waiting and what happens between a birth and its break are apart: with C the travel from the one to the other, ΔX_m that
of the wait and F_0 the force without it, F_k = F_0 C/(C + ΔX_m). So one steady state serves all delays, and one does
for all points at which nothing else tells.

A contact with the threshold ξ breaks at min(ξ, x), A(x; ξ) = v e with e from the exponential law of mean 1. In ln e the
stretch x is smooth at any temperature and speed, so two Gauss sums, over ln e and over ξ, give <x_b> and <k x_b^2> for
all speeds of one temperature together.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.cycle import LAWS
from master.points import Points, changed
from master.steady import steady_state
from origins import Contacts
from origins.contacts import check_contacts
from origins.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]

_LEAST, _MOST = -32.0, 7.0  # ln e: little is spent below, nothing is left above
_NEAR = -2.0  # ln A, less that of the threshold, from which a stiff contact's power 2/3 is felt
_BEFORE, _AFTER = 6.0, 4.5  # of ln e about 0, between which most breaks lie
_WIDER, _WIDEST = 1.3, 4.0
_RUNG = 1.0  # in k_BT
_UNTRIED, _TRIED = 1e-2, 0.7  # attempts on the way to a threshold, and the logarithm from one to the next edge
_TOP, _COARSE_TOP = np.cbrt([2.0, 1.6, 1.2, 0.85, 0.55, 0.28, 0.08, 0.0]), np.cbrt([2.0, 1.4, 0.9, 0.45, 0.0])
_TOLERANCE = 1e-9
_INVERSE = 1e-10  # relative error of a short stretch found from its amount
_ROUND_OFF = 4e-16


@dataclass(frozen=True)
class KineticCurve:
    """Smooth sliding at many points; arrays have the shape that the quantities asked for have together.

    Attributes
    ----------
    velocity : array
        v, length per time.
    temperature, rate, delay : array or None
        T = k_BT/<k> (a length squared), D (a length squared per time) and τ_m (a time); None where there is none.
    force : array
        F_k/(N_c <k>), a length.
    force_error : array
        Its error in units of the mean threshold, as a tolerance is: times contacts.mean_threshold it is a length.
    holding, holding_error : array
        Fraction of the contacts that hold, C/(C + v τ_m), and its error.
    run_time : float
        Seconds.
    """

    velocity: Array
    temperature: Array | None
    rate: Array | None
    delay: Array | None
    force: Array
    force_error: Array
    holding: Array
    holding_error: Array
    run_time: float


def kinetic_curve(
    contacts: Contacts,
    velocity: npt.ArrayLike = 1.0,
    *,
    temperature: npt.ArrayLike | None = None,
    rate: npt.ArrayLike | None = None,
    delay: npt.ArrayLike | None = None,
) -> KineticCurve:
    """F_k(v), F_k(T), F_k(D) or N_c(τ_m) of `contacts`, whatever their laws.

    Parameters
    ----------
    contacts : Contacts
        With any laws that `steady_state` takes; the start does not matter.
    velocity : float or array
        v > 0, length per time.
    temperature, rate, delay : float or array, optional
        In place of the contacts' own: T >= 0 of their thermal law, D >= 0 of their ageing, τ_m >= 0, whether they have
        a delay or not; 0: none. None: their own. Arrays broadcast: velocity[:, None] and temperature give a table.

    Temperature with closure "exact" and relaxed births is summed over all speeds together; where that is not good to
    1e-9 of the force, and with every other law that the speed tells, each point is solved for by itself.

    Raises InputError as `steady_state` does, for values that are not finite or too small, for shapes that do not fit,
    and for a temperature or a rate of contacts without that law.
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.kinetic_curve", (*LAWS, "grains"))
    points = Points(contacts, velocity, temperature, rate, delay)
    force, force_error, holding, holding_error = (row.reshape(points.shape) for row in _along(contacts, points))
    return KineticCurve(
        points.velocity,
        points.temperature,
        points.rate,
        points.delay,
        force,
        force_error / contacts.mean_threshold,
        holding,
        holding_error,
        time.perf_counter() - began,
    )


def _along(contacts: Contacts, points: Points) -> Array:
    """Force, its error (lengths), fraction that holds and its error, shape (4, n)."""
    speeds, heat, spread, wait = points.rows
    if contacts.grains is not None:
        return np.array([_growing(contacts, *at) for at in zip(speeds, wait, strict=True)]).T
    if contacts.thermal is None:  # only D/v tells, or nothing does
        columns = np.ones(speeds.size), heat, spread / speeds
    else:
        columns = np.where((heat > 0.0) | (spread > 0.0), speeds, 1.0), heat, spread
    cases, which = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    steady = np.empty((4, len(cases)))
    for temperature, diffusion in np.unique(cases[:, 1:], axis=0):
        these = np.flatnonzero((cases[:, 1] == temperature) & (cases[:, 2] == diffusion))
        single = changed(contacts, float(temperature), float(diffusion), 0.0)
        steady[:, these] = _at_once(single, cases[these, 0])
    force, force_error, length, length_error = steady[:, which.reshape(-1)]
    holding = length / (length + speeds * wait)
    off = holding * (1.0 - holding) * length_error / length
    return np.stack([force * holding, force_error * holding + force * off, holding, off + _ROUND_OFF])


def _growing(contacts: Contacts, speed: float, wait: float) -> tuple[float, float, float, float]:
    """The same at one speed, which thresholds that grow with age and what is out depend on together."""
    steady = steady_state(changed(contacts, 0.0, 0.0, wait), velocity=speed)
    off = steady.holding * (1.0 - steady.holding) * steady.cycle_length_error / steady.cycle_length
    unit = steady.mean_threshold
    return steady.force, steady.force_error * unit, steady.holding, off * unit + _ROUND_OFF


def _at_once(contacts: Contacts, speeds: Array) -> Array:
    """Force, its error, C and its error (lengths) at each speed, shape (4, n)."""
    out = np.full((4, speeds.size), np.nan)
    if summable(contacts):
        sums = summed(contacts, speeds)
        sure = sums[1] <= _TOLERANCE * sums[0]
        out[:, sure] = sums[:, sure]
    for i in np.flatnonzero(np.isnan(out[0])):
        steady = steady_state(contacts, velocity=float(speeds[i]))
        unit = contacts.mean_threshold
        out[:, i] = steady.force, steady.force_error * unit, steady.cycle_length, steady.cycle_length_error * unit
    return out


def summable(contacts: Contacts) -> bool:
    """Whether breaks are by a rate of each contact's own, and births relaxed."""
    thermal = contacts.thermal
    exact = thermal is not None and thermal.closure == "exact"
    return exact and contacts.reforming is None and contacts.ageing is None


def summed(contacts: Contacts, speeds: Array) -> Array:
    """Force without a wait, its error, C and its error (lengths) at each speed by the two sums, shape (4, n); of
    contacts that are `summable`."""
    (length, square), (other, other_square) = (_moments(contacts, speeds, fine) for fine in (True, False))
    force = 0.5 * square / length
    # the finer panels are far better than what they differ from
    off = np.abs(force - 0.5 * other_square / other) + _INVERSE * force
    return np.stack([force, off, length, np.abs(length - other) + _INVERSE * length])


def _moments(contacts: Contacts, speeds: Array, fine: bool) -> tuple[Array, Array]:
    """<x_b> and <k x_b^2> at each speed, relaxed births."""
    thermal, law = contacts.thermal, contacts.thresholds
    assert thermal is not None
    positions, shares = law.atoms
    if float(shares.sum()) < 1.0 - 1e-14:
        # slow contacts hold on to their strongest thresholds: the far tail counts
        edges = panel_edges(law, accuracy=1e-12 if fine else 1e-8, tail=1e-30 if fine else 1e-20)
        edges = _by_barriers(contacts, edges, float(speeds.min()), _RUNG if fine else 1.5 * _RUNG)
        nodes, weights = gauss(edges[:-1], edges[1:])
        mass = (weights * law.pdf(nodes)).ravel()
        felt = mass > (1e-26 if fine else 1e-18)
        positions, shares = np.append(nodes.ravel()[felt], positions), np.append(mass[felt], shares)
    stiffness = contacts.relative_stiffness(positions)
    log_all = thermal.log_cumulative(positions, positions, stiffness=stiffness)
    # ln A below that of the threshold, the same for all speeds; by cube roots where a stiff contact's x has a power 2/3
    deepest = _LEAST - max(float(log_all.max() - np.log(speeds.min())), 0.0)
    first, last = np.log(speeds.min()) - float(log_all.max()), np.log(speeds.max()) - float(log_all.min())
    edges = _panels(deepest, first - _BEFORE, last + _AFTER, 0.6 if fine else 0.85)
    below, width = (part.ravel() for part in gauss(edges[:-1], edges[1:]))
    if edges[-1] == _NEAR:
        top = _TOP if fine else _COARSE_TOP
        roots, across = gauss(top[1:], top[:-1])
        below = np.append(below, -(roots.ravel() ** 3))
        width = np.append(width, (3.0 * roots * roots * across).ravel())
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


def _panels(deepest: float, first: float, last: float, width: float) -> Array:
    """Edges from `deepest` up, at most to _NEAR: `width` apart between first and last, ever wider below, none above."""
    top = min(last, _NEAR)
    bottom = max(min(first, top - width), deepest)
    fine = np.linspace(bottom, top, 2 + int((top - bottom) / width))
    far = bottom - np.cumsum(np.minimum(width * _WIDER ** np.arange(1.0, 200.0), _WIDEST))
    return np.concatenate([[deepest] if bottom > deepest else [], far[far > deepest][::-1], fine])


def _by_barriers(contacts: Contacts, edges: Array, slowest: float, rung: float) -> Array:
    """Edges between thresholds, with those where the barrier of a relaxed contact is `rung` higher: from an amount that
    it spends at once to one that brings it close to its threshold, x goes within one k_BT. And with those between
    thresholds at which contacts have made some attempts, and more."""
    thermal = contacts.thermal
    assert thermal is not None
    lowest, highest = float(edges[0]), float(edges[-1])
    # what h spends on its way is at most that of an attempt at each moment
    spent = np.log(max(thermal.attempt_frequency * highest / slowest, 1.0))
    barriers = np.arange(rung, -_LEAST + spent + rung, rung)
    if contacts.stiffness == "linked":
        rungs = np.cbrt(2.0 * thermal.temperature * contacts.mean_threshold * barriers)
    else:
        rungs = np.sqrt(2.0 * thermal.temperature * barriers)
    # thresholds so low that they are reached before the first attempt
    least = max(lowest, _UNTRIED * slowest / thermal.attempt_frequency)
    steps = int(np.log(max(highest / least, 1.0)) / (_TRIED * rung))
    inner = np.append(rungs, np.geomspace(least, highest, 2 + steps))
    return np.unique(np.append(edges, inner[(inner > lowest) & (inner < highest)]))
