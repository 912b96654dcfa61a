"""The line between stick-slip and smooth sliding: K* along speeds, temperatures, ageing, delays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.outcome import judged
from master.steady.kinetic import Along, Points
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
    check_contacts(contacts, "master.phase_line", LAWS, own_rates=True)
    tolerance = check_tolerance("tolerance", tolerance)
    points = Points(contacts, velocity, temperature, rate, delay)
    check_finite(contacts)
    cases, which = points.distinct(waits=True)
    found = np.empty((2, len(cases)))
    for i, case in enumerate(cases):
        single = points.contacts(case, contacts.start)
        found[:, i] = critical_spring(single, float(case[0]), tolerance)
    spring, error = found[:, which].reshape(2, *points.shape)
    return PhaseLine(
        **points.outcome(*judged("K*", error / (1.0 + spring), tolerance)),
        critical_spring=spring,
        critical_spring_error=error,
    )
