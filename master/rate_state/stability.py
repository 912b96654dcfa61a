"""Below which spring smooth sliding is unstable: by rate and state, and by the solved answer itself.

A slider on a spring K slides smoothly at v, but for a small disturbance that grows as e^(pX). That of its ln v is p
times that of its place. So with R(X), the change of force for each factor e of the speed, at the slip X after a step,
K + p T(p) = 0, where T(p) = R(0) + ∫ R'(X) e^(-pX) dX. At the critical spring p = iq is imaginary: Re T(iq) = 0 and
K = q Im T(iq). With rate and state R = a - b (1 - e^(-X/D_c)), and K = (b - a)/D_c.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from master.rate_state.traces import VelocityStep
from origins.thresholds.law import Array

# per mean slip of a life: wave numbers q that are looked at
_LEAST_WAVE, _MOST_WAVE, _WAVES = 1e-2, 1e3, 2000
# straight pieces, between neighbours of the slips at which the response is known, of the smooth curve through them
_FINER = 4


class CriticalSpring(NamedTuple):
    """K/(N_c <k>), and how far other readings of the same answers are from it."""

    value: float
    error: float


def critical_spring_of(steps: Sequence[VelocityStep], unit: float) -> CriticalSpring:
    """The spring below which smooth sliding is unstable, by the mean answer to small steps up and down; 0 where it is
    stable on every spring. Its error: how far each step alone is from it, and the answer taken as straight between the
    slips at which it is known. `unit`: a length, the mean threshold."""
    from scipy.interpolate import PchipInterpolator

    known, each = steps[0].slip, [one.response for one in steps]
    mean = np.mean(each, axis=0)
    places = np.arange((known.size - 1) * _FINER + 1) / _FINER
    slip = np.interp(places, np.arange(known.size), known)
    value = _largest(slip, PchipInterpolator(known, mean)(slip), unit)
    others = [_largest(known, one, unit) for one in (mean, *each)]
    return CriticalSpring(value, max(abs(other - value) for other in others))


def _largest(slip: Array, response: Array, unit: float) -> float:
    """The largest spring at which Re T = 0, of a response that is straight between its points."""
    waves = np.geomspace(_LEAST_WAVE, _MOST_WAVE, _WAVES) / unit
    answer = transform(slip, response, waves)
    turns = np.flatnonzero(np.diff(np.sign(answer.real)))
    share = answer.real[turns] / (answer.real[turns] - answer.real[turns + 1])
    springs = waves * answer.imag
    crossed = (1.0 - share) * springs[turns] + share * springs[turns + 1]
    # where the force does not rise at first, the fastest disturbances decide: Re T goes to 0 with 1/q
    fastest = springs[-1] if answer.real[-1] <= 0.0 else 0.0
    return float(max(crossed.max(initial=0.0), fastest, 0.0))


def transform(slip: Array, response: Array, waves: Array) -> Array:
    """T(iq) at wave numbers q (1/length), of a response that is straight between its points."""
    rates = np.diff(response) / np.diff(slip)
    phases = np.exp(-1j * waves[:, None] * slip)
    return response[0] + (rates * (phases[:, :-1] - phases[:, 1:])).sum(axis=1) / (1j * waves)
