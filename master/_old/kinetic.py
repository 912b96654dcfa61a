"""The kinetic force along speeds, temperatures, rates of ageing and delays, in one call.

Waiting and what happens between a birth and its break are apart: with C the travel from the one to the other, ΔX_m that
of the wait and F_0 the force without it, F_k = F_0 C/(C + ΔX_m). So one steady state serves all delays, and one does
for all points at which nothing else tells.
Breaks at rates are summed for all speeds of one temperature together, and temperatures share the panels of their law.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.break_sums import law_edges, summable, summed
from master._old.points import Points, changed
from master._old.steady import check_finite, steady_state
from master.outcome import WELL, judged
from origins import Contacts
from origins.brief import brief
from origins.contacts import LAWS, check_contacts
from origins.errors import refuse

Array = npt.NDArray[np.float64]

_TOLERANCE = 1e-9
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
    success : array of bool
        Whether the force is known to a thousandth of itself at each point: no tolerance is asked for.
    message : str
        In words: what was reached, and at how many points not that.
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
    success: npt.NDArray[np.bool_]
    message: str

    __repr__ = brief


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

    Temperature with closure "exact" is summed over all speeds together; where that is not good to 1e-9 of the force of
    contacts that form again relaxed, and with every other law that the speed tells, as with births at one stretch that
    is not 0, each point is solved for by itself.

    Raises InputError as `steady_state` does, for values that are not finite or too small, for shapes that do not fit,
    for a temperature or a rate of contacts without that law, and for speeds so low that squares of stretches at a
    break are below all numbers.
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.kinetic_curve", LAWS)
    points = Points(contacts, velocity, temperature, rate, delay)
    force, force_error, holding, holding_error = (row.reshape(points.shape) for row in _along(contacts, points))
    success, message = judged("F_k", force_error / force, WELL)
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
        success,
        message,
    )


def _along(contacts: Contacts, points: Points) -> Array:
    """Force, its error (lengths), fraction that holds and its error, shape (4, n)."""
    speeds, heat, spread, wait = points.rows
    if contacts.grains is not None:
        return np.array([_growing(contacts, *at) for at in zip(speeds, heat, wait, strict=True)]).T
    if contacts.thermal is None:  # only D/v tells, or nothing does
        columns = np.ones(speeds.size), heat, spread / speeds
    else:
        columns = np.where((heat > 0.0) | (spread > 0.0), speeds, 1.0), heat, spread
    cases, which = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    steady = np.empty((4, len(cases)))
    edges = law_edges(contacts.thresholds) if summable(contacts) else None
    for temperature, diffusion in np.unique(cases[:, 1:], axis=0):
        these = np.flatnonzero((cases[:, 1] == temperature) & (cases[:, 2] == diffusion))
        single = changed(contacts, float(temperature), float(diffusion), 0.0)
        steady[:, these] = _at_once(single, cases[these, 0], edges)
    force, force_error, length, length_error = steady[:, which.reshape(-1)]
    holding = length / (length + speeds * wait)
    off = holding * (1.0 - holding) * length_error / length
    return np.stack([force * holding, force_error * holding + force * off, holding, off + _ROUND_OFF])


def _growing(
    contacts: Contacts, speed: float, temperature: float, wait: float
) -> tuple[float, float, float, float]:
    """The same at one point: thresholds that grow with age and what is out depend on the speed together."""
    steady = steady_state(changed(contacts, temperature, 0.0, wait), velocity=speed)
    off = steady.holding * (1.0 - steady.holding) * steady.cycle_length_error / steady.cycle_length
    unit = steady.mean_threshold
    return steady.force, steady.force_error * unit, steady.holding, off * unit + _ROUND_OFF


def _at_once(contacts: Contacts, speeds: Array, edges: Array | None) -> Array:
    """Force, its error, C and its error (lengths) at each speed, shape (4, n); `edges` of panels over thresholds."""
    check_finite(contacts)
    out = np.full((4, speeds.size), np.nan)
    if summable(contacts):
        sums = summed(contacts, speeds, edges)
        # births at many stretches are summed for single points as well
        sure = (sums[1] <= _TOLERANCE * sums[0]) | (contacts.reforming is not None)
        out[:, sure] = sums[:, sure]
        if np.isinf(sums[1]).any():
            refuse(
                "velocity",
                float(speeds[np.isinf(sums[1])].max()),
                "contacts break within stretches whose squares are below all numbers; slide faster, and of many speeds "
                "leave such ones out",
            )
    for i in np.flatnonzero(np.isnan(out[0])):
        steady = steady_state(contacts, velocity=float(speeds[i]))
        unit = contacts.mean_threshold
        out[:, i] = steady.force, steady.force_error * unit, steady.cycle_length, steady.cycle_length_error * unit
    return out
