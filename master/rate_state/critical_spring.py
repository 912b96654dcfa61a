"""Below which spring smooth sliding is unstable: by rate and state, and by the solved answer itself.

A slider on a spring K slides smoothly at v, but for a small disturbance that grows as e^(pX). That of its ln v is p
times that of its place. So with R(X), the change of force for each factor e of the speed, at the slip X after a step,
K + p T(p) = 0, where T(p) = R(0) + ∫ R'(X) e^(-pX) dX. At the critical spring p = iq is imaginary: Re T(iq) = 0 and
K = q Im T(iq). With rate and state R = a - b (1 - e^(-X/D_c)), and K = (b - a)/D_c.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from master.rate_state.reading import TWICE
from master.rate_state.traces import VelocityStep
from origins.thresholds.law import Array

# per mean slip of a life: wave numbers q that are looked at; a straight line between neighbours is off by some 1e-4, as
# the transform swings with the answer's last slip
_LEAST_WAVE, _MOST_WAVE, _WAVES = 1e-2, 1e3, 2000
# straight pieces, between neighbours of the slips at which the response is known, of the smooth curve through them
_FINER = 4
# wave number, over that of a mean threshold, below which a disturbance may keep step with what is left at the end of an
# answer, which swings once in a life or about twice
_SWINGS = 15.0
# phases that are held at once, of 16 bytes each
_MOST_PHASES = 1_000_000


class CriticalSpring(NamedTuple):
    """K/(N_c <k>), and its error."""

    value: float
    error: float


UNKNOWN = CriticalSpring(np.nan, np.inf)


class Crossing(NamedTuple):
    """A spring at which Re T = 0, and the wave number of the disturbance that neither grows nor decays on it."""

    spring: float
    wave: float


def critical_spring_of(
    steps: Sequence[VelocityStep], unit: float, larger: Sequence[VelocityStep] = ()
) -> CriticalSpring:
    """The spring below which smooth sliding is unstable, by the mean answer to small steps up and down; 0 where it is
    stable on every spring. `unit`: a length, the mean threshold.

    Disturbances so fast that the sign of Re T is not known, by the error of the forces and by what the slips leave out,
    are not looked at. The error is the sum of three parts. What the steps leave out: the mean of both ways is an even
    function of ε = ln(v_after/v_before), so that `larger` steps about the same speed are off by ε_l² where these are by
    ε_s², and these by the difference times ε_s²/(ε_l² - ε_s²), taken twice for higher orders; without them, how far
    each way alone is from the mean, of first order in ε. What the slips do: the answer taken as straight between those
    at which it is known, and the error of the forces in Im T, also where they swing on beyond the end. And what that
    error does as a shift of the whole answer.
    """
    from scipy.interpolate import PchipInterpolator

    def of_answer(slip: Array, response: Array) -> float:
        """The largest spring by a response at these slips."""
        return _largest(waves, transform(slip, response, waves)).spring

    waves = np.geomspace(_LEAST_WAVE, _MOST_WAVE, _WAVES) / unit
    slips, mean = steps[0].slip, _mean(steps)
    places = np.arange((slips.size - 1) * _FINER + 1) / _FINER
    slip = np.interp(places, np.arange(slips.size), slips)
    smooth = transform(slip, PchipInterpolator(slips, mean)(slip), waves)
    plain = transform(slips, mean, waves)
    small, shift = abs(steps[0].log_ratio), steps[0].error / abs(steps[0].log_ratio)
    # of q T, which is a spring
    error = np.maximum.accumulate(waves * np.abs(smooth - plain)) + waves * shift
    significant = np.flatnonzero(waves * np.abs(smooth.real) > error)
    waves = waves[: significant[-1] + 1 if significant.size else None]
    smooth, plain = smooth[: waves.size], plain[: waves.size]
    value, wave = _largest(waves, smooth)
    # the transform of a constant is that constant
    moved = (_largest(waves, smooth + sign * shift).spring for sign in (-1, 1))
    shifted = max(abs(one - value) for one in moved)
    straight = _largest(waves, plain).spring
    if larger:
        apart = abs(of_answer(larger[0].slip, _mean(larger)) - straight)
        left_out = TWICE * apart / ((larger[0].log_ratio / small) ** 2 - 1.0)
    else:
        left_out = max(abs(of_answer(slips, one.response) - straight) for one in steps)
    transform_error = float(np.interp(wave, waves, error[: waves.size]))
    if wave * unit < _SWINGS:
        # what is left at the end swings on at about this wave number, and decays as it did
        fallen = np.log(np.abs(mean - mean[-1]).max() / shift) if shift else np.inf
        transform_error += 0.5 * wave**2 * shift * float(slips[-1] / max(fallen, 1.0))
    return CriticalSpring(value, max(abs(straight - value), transform_error) + shifted + left_out)


def _mean(steps: Sequence[VelocityStep]) -> Array:
    """The mean answer of steps up and down, known at the same slips, for each factor e of the speed."""
    return np.mean([one.response for one in steps], axis=0)


def _largest(waves: Array, answer: Array) -> Crossing:
    """The largest spring at which Re T = 0, of the transform at these wave numbers; 0 where there is none."""
    turns = np.flatnonzero(np.diff(np.sign(answer.real)))
    fraction = answer.real[turns] / (answer.real[turns] - answer.real[turns + 1])
    springs = waves * answer.imag
    crossed = (1.0 - fraction) * springs[turns] + fraction * springs[turns + 1]
    found = [Crossing(0.0, 0.0), *map(Crossing, crossed, waves[turns])]
    # where the force does not rise at first, the fastest disturbances decide: Re T goes to 0 with 1/q
    if answer.real[-1] <= 0.0:
        found.append(Crossing(springs[-1], waves[-1]))
    return Crossing(*map(float, max(found)))


def transform(slip: Array, response: Array, waves: Array) -> Array:
    """T(iq) at wave numbers q (1/length), of a response that is straight between its points."""
    rates, sums = np.diff(response) / np.diff(slip), np.empty(waves.size, dtype=complex)
    blocks = 1 + slip.size * waves.size // _MOST_PHASES
    for some in np.array_split(np.arange(waves.size), blocks):
        phases = np.exp(-1j * waves[some, None] * slip)
        sums[some] = (phases[:, :-1] - phases[:, 1:]) @ rates
    return response[0] + sums / (1j * waves)
