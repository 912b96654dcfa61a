"""The line between stick-slip and smooth sliding: K* along speeds, temperatures, ageing, delays."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.outcome import judged
from master.steady.points import Along, Points, changed
from master.steady.travel import check_finite
from master.stick_slip.extremes import critical_spring
from origins import Contacts
from origins.contacts import LAWS, check_contacts
from origins.errors import check_tolerance

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class PhaseLine(Along):
    """K* at many points; `success` where its error relative to 1 + K* is within the tolerance.

    Attributes, beside those of `Along`
    ----------
    critical_spring, critical_spring_error : array
        K*/(N_c <k>) and its error: softer springs stick and slip, others slide smoothly. 0 where
        the force never falls: no spring slips; inf where it drops at one X: every spring slips.
    """

    critical_spring: Array
    critical_spring_error: Array


def phase_line(
    contacts: Contacts,
    velocity: npt.ArrayLike = 1.0,
    *,
    temperature: npt.ArrayLike | None = None,
    rate: npt.ArrayLike | None = None,
    delay: npt.ArrayLike | None = None,
    tolerance: float = 1e-6,
) -> PhaseLine:
    """K*(v, T) of contacts on a slider that moves forward from their start (paper, Eq. Q16).

    Parameters
    ----------
    contacts : Contacts
        With any laws that `propensity` takes; the start matters.
    velocity, temperature, rate, delay : float or array
        As in master.kinetic_curve.
    tolerance : float
        Largest allowed error of K*, relative to 1 + K*.

    v is the speed of the slider itself: that of a soft slider's drive is 1 + F'/K times higher
    while the force rises.

    Raises InputError as `propensity` does, and for points as `kinetic_curve` does.
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.phase_line", LAWS, own_rates=True)
    tolerance = check_tolerance("tolerance", tolerance)
    points = Points(contacts, velocity, temperature, rate, delay)
    check_finite(contacts)
    speeds, *others = points.rows
    # the speed matters only with heat, ageing, grains or a delay
    tells = np.any(others, axis=0) | (contacts.thermal is not None) & (points.temperature is None)
    speeds = np.where(tells | (contacts.grains is not None), speeds, 1.0)
    cases, which = np.unique(np.stack([speeds, *others], axis=1), axis=0, return_inverse=True)
    found = np.empty((2, len(cases)))
    for i, (speed, heat, spread, wait) in enumerate(cases.tolist()):
        single = changed(contacts, heat, spread, wait, contacts.start)
        found[:, i] = critical_spring(single, speed, tolerance)
    spring, error = (row[which.reshape(-1)].reshape(points.shape) for row in found)
    success, message = judged("K*", error / (1.0 + spring), tolerance)
    return PhaseLine(
        velocity=points.velocity,
        temperature=points.temperature,
        rate=points.rate,
        delay=points.delay,
        run_time=time.perf_counter() - began,
        success=success,
        message=message,
        critical_spring=spring,
        critical_spring_error=error,
    )
