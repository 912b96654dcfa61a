"""The kinetic force along speeds, temperatures, rates of ageing and delays, in one call.

A delay does not change what happens between birth and break: with C the slider's travel from one to
the other, v tau its travel during the delay and F_0 the force without delay, F_k = F_0 C/(C + v tau).
So points that differ only in the delay share one steady state, as do all at which C and F_0 agree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.outcome import WELL, judged
from master.steady.points import Along, Points
from master.steady.steady import steady_state
from master.steady.sums import summed
from master.steady.travel import check_finite
from origins import Contacts
from origins.contacts import LAWS, check_contacts
from origins.errors import refuse

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class KineticCurve(Along):
    """Smooth sliding at many points; `success` where the force is known to a relative 1e-3.

    Attributes, beside those of `Along`
    ----------
    force : array
        F_k/(N_c <k>), a length.
    force_error : array
        Its error in units of the mean threshold.
    holding, holding_error : array
        Fraction of the contacts that hold, C/(C + v tau_m), and its error.
    """

    force: Array
    force_error: Array
    holding: Array
    holding_error: Array


def kinetic_curve(
    contacts: Contacts,
    velocity: npt.ArrayLike = 1.0,
    *,
    temperature: npt.ArrayLike | None = None,
    rate: npt.ArrayLike | None = None,
    delay: npt.ArrayLike | None = None,
) -> KineticCurve:
    """F_k(v), F_k(T), F_k(D) or N_c(tau_m) of contacts, whatever their laws.

    Parameters
    ----------
    contacts : Contacts
        With any laws that `steady_state` takes; the start does not matter.
    velocity : float or array
        v > 0, length per time.
    temperature, rate, delay : float or array, optional
        In place of the contacts' own: T >= 0 of their thermal law, D >= 0 of their ageing,
        tau_m >= 0 of their delay (they need not have one); 0 switches the law off; None: their own.
        Arrays broadcast: velocity[:, None] and temperature give a table.

    Contacts that break by heat (closure "exact") and re-form relaxed are summed at all speeds
    together; every other distinct point is solved individually.

    Raises InputError as `steady_state` does, for values that are not finite or too small, for
    shapes that do not broadcast, for a temperature or a rate of contacts without that law, and for
    speeds so low that squares of stretches at a break underflow.
    """
    check_contacts(contacts, "master.kinetic_curve", LAWS, own_rates=True)
    points = Points(contacts, velocity, temperature, rate, delay)
    cases, which = points.distinct(waits=False)
    steady = np.empty((4, len(cases)))
    for laws in np.unique(cases[:, 1:], axis=0):
        these = np.flatnonzero((cases[:, 1:] == laws).all(axis=1))
        steady[:, these] = _at_once(points.contacts(cases[these[0]]), cases[these, 0])
    force, force_error, length, length_error = steady[:, which].reshape(4, *points.shape)
    # contacts with grains are out until these pin again, in addition to the delay
    pinned = points.contacts(np.zeros(4)).waiting_time
    speeds, waits = points.rows[[0, 3]].reshape(2, *points.shape)
    holding = length / (length + speeds * (waits + pinned))
    off = holding * (1.0 - holding) * length_error / length
    force_error = force_error * holding + force * off
    force = force * holding
    return KineticCurve(
        **points.outcome(*judged("F_k", force_error / force, WELL)),
        force=force,
        force_error=force_error / contacts.mean_threshold,
        holding=holding,
        holding_error=off + 4e-16,  # the round-off of the share that holds
    )


def _at_once(contacts: Contacts, speeds: Array) -> Array:
    """Force, its error, C and its error (lengths) at each speed without delay, shape (4, n)."""
    check_finite(contacts)
    out = np.full((4, speeds.size), np.nan)
    thermal = contacts.thermal
    by_heat = thermal is not None and thermal.closure == "exact"
    if by_heat and not {"ageing", "grains", "reforming"}.intersection(contacts.laws):
        sums = summed(contacts, speeds)
        lost = ~(sums.area > 0.0)
        if lost.any():
            refuse(
                "velocity",
                float(speeds[lost].max()),
                "contacts break before they have moved lengths whose squares are numbers; slide "
                "faster, and of many speeds leave such ones out",
            )
        force = sums.area / sums.length
        off = (sums.area_error + force * sums.length_error) / sums.length
        out = np.stack([force, off, sums.length, sums.length_error])
    unit = contacts.mean_threshold
    # points not known well enough from the sums over all speeds are solved individually
    for i in np.flatnonzero(~(out[1] <= 1e-9 * out[0])):
        one = steady_state(contacts, velocity=float(speeds[i]))
        if not one.force_error * unit >= out[1, i]:
            out[:2, i] = np.array([one.force, one.force_error * unit]) / one.holding
            out[2:, i] = one.cycle_length, one.cycle_length_error * unit
    return out
