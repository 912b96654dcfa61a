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

    The mean of both ways is an even function of ε = ln(v_after/v_before), so that `larger` steps about the same speed
    are off by ε_l² where these are by ε_s²: by both the transform is extrapolated to ε = 0.

    Disturbances so fast that the sign of Re T is not known, by the error of the forces and by what the slips leave out,
    are not looked at. The error is the sum of what follows. What steps that are not small do: all that the
    extrapolation changes, or, without larger steps, how far each way alone is from the mean. What the slips do: the
    answer taken as straight between those at which it is known. What an error of the forces does that moves T by as
    much, in any direction of the complex plane. And what swings on beyond the end, by what is seen to be left there.
    """
    waves = np.geomspace(_LEAST_WAVE, _MOST_WAVE, _WAVES) / unit
    slips, mean, small = steps[0].slip, _mean(steps), abs(steps[0].log_ratio)
    smooth, plain = _of_curve(steps, waves), transform(slips, mean, waves)
    shift = steps[0].error / small
    # of q T, which is a spring
    sampled = np.maximum.accumulate(waves * np.abs(smooth - plain))
    significant = np.flatnonzero(waves * np.abs(smooth.real) > sampled + waves * shift)
    known = slice(significant[-1] + 1 if significant.size else None)
    waves, smooth, plain, sampled = waves[known], smooth[known], plain[known], sampled[known]
    answer, of_steps = smooth, _largest(waves, smooth).spring
    if larger:
        order = (larger[0].log_ratio / small) ** 2 - 1.0
        answer = smooth + (smooth - _of_curve(larger, waves)) / order
    value, wave = _largest(waves, answer)
    left_out = abs(value - of_steps)
    if not larger:
        each = (_largest(waves, transform(slips, one.response, waves)).spring for one in steps)
        left_out = max(abs(spring - _largest(waves, plain).spring) for spring in each)
    straight = abs(_largest(waves, plain).spring - of_steps)
    of_slips = max(straight, float(np.interp(wave, waves, sampled)))
    # the transform of a constant is that constant
    moved = (_largest(waves, answer + sign * shift).spring for sign in (-1, 1))
    of_forces = float(np.hypot(wave * shift, max(abs(spring - value) for spring in moved)))
    swings = 0.0
    if wave * unit < _SWINGS:
        # what is left over the last wave swings on at about this wave number, and decays as it did
        off = np.abs(mean - np.mean([one.slope for one in steps]))
        left = off[slips >= slips[-1] - 2.0 * np.pi / max(wave, _LEAST_WAVE / unit)].max()
        fallen = np.log(off.max() / left) if left else np.inf
        swings = 0.5 * wave**2 * float(left * slips[-1] / max(fallen, 1.0))
    return CriticalSpring(value, of_slips + of_forces + swings + left_out)


def _of_curve(steps: Sequence[VelocityStep], waves: Array) -> Array:
    """T at wave numbers, of a smooth curve through the mean answer of these steps."""
    from scipy.interpolate import PchipInterpolator

    slips = steps[0].slip
    places = np.arange((slips.size - 1) * _FINER + 1) / _FINER
    slip = np.interp(places, np.arange(slips.size), slips)
    return transform(slip, PchipInterpolator(slips, _mean(steps))(slip), waves)


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
