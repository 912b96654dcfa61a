"""How prone to stick-slip: K*, F_s/F_k, X* and the onset power of P_c, each with its error; and the
line between stick-slip and smooth sliding: K* along speeds, temperatures, ageing, delays."""

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.outcome import judged
from master.steady.kinetic import Along, Points
from master.stick_slip.extremes import FOR_SLOPE, extremes, unit_of
from master.stick_slip.roots import decoherence_length
from origins import Contacts, InputError
from origins.contacts import LAWS, check_contacts
from origins.errors import between, check_tolerance, positive
from origins.thresholds.law import Array


@dataclass(frozen=True)
class Propensity:
    """Measures of stick-slip propensity for a start, a law of thresholds and the laws of contacts.

    critical_spring : K*/(N_c <k>) = max over X of -dF/dX (paper Eq. Q16): at T = 0 a slider on a softer spring slips
        at least once from the start. 0 where the force never falls; inf where it drops or its slope diverges.
    static_to_kinetic : F_s/F_k, the largest force divided by the kinetic one; 1 where the force never exceeds it.
    decoherence_length : X* (a length) of the slowest term e^{-X/X*} in F - F_k; inf where none decays exponentially.
    onset_power : m of P_c(x) ~ (x - a)^m at its lower end.
    critical_spring_error and the others : estimates from above of absolute errors, in the unit of the value itself.
    run_time : s.
    success, message : whether the errors of K* (relative to 1 + K*) and of F_s (in mean thresholds; with heat, unless
        grains grow, in mean distances from birth to break) are within the tolerance, and the accuracy reached.
    """

    critical_spring: float
    critical_spring_error: float
    static_to_kinetic: float
    static_to_kinetic_error: float
    decoherence_length: float
    decoherence_length_error: float
    onset_power: float
    onset_power_error: float
    run_time: float
    success: bool
    message: str


def propensity(
    contacts: Contacts,
    tolerance: float = 1e-8,
    *,
    velocity: float = 1.0,
    wall_time: float | None = None,
) -> Propensity:
    """Stick-slip propensity of contacts on a slider that moves forward from their start.

    contacts : with any laws but the paper's closure of ageing; the start matters.
    tolerance : largest allowed error: of K* relative to 1 + K*, and of F_s in the unit given at `success`.
    velocity : v > 0, length per time; it matters only with heat, ageing, grains or a delay.
    wall_time : s; K* and F_s that are not found by then are nan, with errors of inf; the table of what survives,
        which laws in time need first, is not cut short. None: as long as it takes.

    F(X) is followed for ten mean thresholds, with heat ten mean distances from birth to break; where generations of
    breaks do not overlap, along the first, or the first two where contacts re-form elsewhere than relaxed; and up to
    100 times as far where more than 1e-6 of the contacts live longer. It is followed no further than the contacts of
    the start, and then one longest life: beyond, F is a mean of its values before. Errors bound what may follow, too.

    Raises InputError where <x_s^2> is infinite: there is no kinetic force to compare with; and where contacts re-form
    so far behind x = 0 that the kinetic force is not above 0.
    """
    began = time.perf_counter()
    tolerance = check_tolerance("tolerance", tolerance)
    check_contacts(contacts, "master.propensity", LAWS, own_rates=True)
    velocity = between("velocity", velocity, 1e-100, 1e100)
    until = np.inf if wall_time is None else time.monotonic() + positive("wall_time", wall_time)
    fall, static, cycle = extremes(contacts, velocity, tolerance, until)
    kinetic, off = cycle.force()
    if not kinetic > 0.0:
        fault = f"contacts form again behind x = 0 and bear {kinetic:.3g} in steady sliding"
        hint = "of which no F_s is a multiple; ask master.phase_line for K* alone"
        raise InputError(f"reforming: {fault}, {hint}")
    length, length_error = decoherence_length(cycle)
    # where F(X) falls nowhere F_k is its largest value
    ratio = max(static.value / kinetic, 1.0) if fall.value > 0.0 else 1.0
    ratio_error = (static.error + ratio * off) / kinetic
    if late := bool(np.isnan(fall.value)):
        ratio, ratio_error = np.nan, np.inf
    sure_spring, spring_message = judged("K*", fall.error / (1.0 + fall.value), tolerance)
    if not sure_spring and cycle.survival_error > FOR_SLOPE * tolerance:
        spring_message += (
            f", as survivals are known to {cycle.survival_error:.1e}, and slopes to less"
        )
    sure_static, static_message = judged("F_s", static.error / unit_of(cycle), tolerance)
    return Propensity(
        critical_spring=fall.value,
        critical_spring_error=fall.error,
        static_to_kinetic=ratio,
        static_to_kinetic_error=ratio_error,
        decoherence_length=length,
        decoherence_length_error=length_error,
        onset_power=contacts.thresholds.onset_power,
        onset_power_error=contacts.thresholds.onset_power_error,
        run_time=time.perf_counter() - began,
        success=bool(sure_spring and sure_static),
        message="stopped by wall_time" if late else f"{spring_message}; {static_message}",
    )


@dataclass(frozen=True, repr=False)
class PhaseLine(Along):
    """K* at many points; `success` where its error relative to 1 + K* is within the tolerance.

    critical_spring : K*/(N_c <k>), and critical_spring_error, the absolute error: as in `Propensity`. With 0 a slider
        slips on no spring, with inf on every one.
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

    contacts : with any laws that `propensity` takes; the start matters.
    velocity, temperature, rate, delay : numbers or arrays, as in master.kinetic_curve.
    tolerance : largest allowed error of K*, relative to 1 + K*.

    v is the speed of the slider itself: that of a soft slider's drive is 1 + F'/K times higher while the force rises.
    Raises InputError as `propensity` does, and for points as `kinetic_curve` does.
    """
    check_contacts(contacts, "master.phase_line", LAWS, own_rates=True)
    tolerance = check_tolerance("tolerance", tolerance)
    points = Points(contacts, velocity=velocity, temperature=temperature, rate=rate, delay=delay)
    cases, which = np.unique(points.rows, axis=0, return_inverse=True)
    found = np.empty((2, len(cases)))
    for i, (speed, *laws) in enumerate(cases):
        found[:, i] = extremes(points.contacts(*laws), float(speed), tolerance).fall[:2]
    spring, error = found[:, which.ravel()].reshape(2, *points.shape)
    return PhaseLine(
        **points.outcome(*judged("K*", error / (1.0 + spring), tolerance)),
        critical_spring=spring,
        critical_spring_error=error,
    )
