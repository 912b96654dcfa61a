"""Whether steady sliding of a slider with mass is stable against small disturbances, where heat breaks its contacts.

A slider at X = v t + ε e^(pX), on a spring K, with the mass M and the damping γ, moves so by itself where

    D(p) = M v^2 p^2 + γ v p + K + G(p) = 0,

G being the answer of the contacts' force (master/steady/response.py), which has no poles where p has a positive real
part. As q goes from 0 to infinity D(iq) goes from K to -M v^2 q^2. No zero has a positive real part if its argument
rises by π on the way, and without a mass, where it ends at K + G(∞), if it comes back to 0 (the argument principle):
with each passing of the imaginary axis it changes by π, forth or back. A passing is clear where D is farther from 0
than G may be off. `is_stable` of response.py, for creep without a mass, asks less: that D keeps off the negative real
axis, which is enough for stability, and tells no instability.

An example: G = 0, as of contacts at T = 0, K = 1, M v^2 = 1, γ v = 0.1. D passes the axis once, at q = 1, upwards at
0.1 i: half a turn, stable. With γ v = -0.1 it passes at -0.1 i, half a turn back, and the swing grows by e^(0.05 X).
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from master.steady.response import response
from master.steady.steady import steady_state
from origins import Contacts
from origins.thresholds.law import Array

# Least and largest wave number, per inverse mean threshold, at which G is found where nothing asks for more, and how
# many there are in each decade.
_LEAST, _MOST, _PER_DECADE = 1e-3, 300.0, 12
# Below this wave number, in the same unit, G is taken as a i q + c q^2, with c from G at it, and a = dF_k/d ln v from
# F_k at speeds so far apart: that is so to a thousandth, and sums of G there are differences of nearly equal numbers.
# Where contacts live for far less than a mean threshold nothing but rounding is left of them.
_SLOW, _APART = 1e-2, 0.05
# The wave numbers reach from this part of that at which the mass swings on the spring alone, to so many times that at
# which it swings on spring and contacts that stretch and do not break.
_BELOW, _ABOVE = 0.1, 10.0
# Up to this wave number, in the same unit, G is found at each half of one, too: it swings once in 2 pi of them, the
# farther the narrower the law of thresholds is.
_SWINGS = 40.0
# Part of G by which a curve through every other wave number may miss G at those left out: the curve through all of them
# is then off by about a tenth as much.
_HALF = 0.2
# Part of G by which D may be off: sums are off by some 1e-3 of it, as measured, and a curve through them by as much.
_OFF = 0.02
# Points of the curve between two neighbours.
_FINER = 40
# The stiffest spring that is looked at, in N_c<k>; how many springs are, evenly in ln K; and how often the distance of
# the last unstable one to the next is halved.
STIFFEST, SPRINGS, HALVINGS = 10.0, 60, 6


def sliding_is_stable(
    contacts: Contacts, velocity: float, spring: float, mass: float = 0.0, damping: float = 0.0
) -> bool | None:
    """Whether small disturbances of steady sliding at this speed decay, of contacts that `has_response` takes; None
    where that is not clear. Spring, mass and damping per N_c<k>."""
    inertia = mass * velocity**2
    found = _answer(contacts, velocity, np.array([spring, spring]), inertia)
    return decays(found.wave, found.answer, spring, inertia, damping * velocity, found.noise)


def unstable_below(
    contacts: Contacts, velocity: float, spring: float, mass: float = 0.0, damping: float = 0.0
) -> float:
    """The spring, per N_c<k>, below which steady sliding is unstable on those as stiff as `spring` or stiffer: 0 where
    it is stable on that one, nan where that is not clear. The others as in `sliding_is_stable`."""
    inertia, springs = mass * velocity**2, np.geomspace(spring, max(STIFFEST, spring), SPRINGS)
    found = _answer(contacts, velocity, springs[[0, -1]], inertia)

    def stable(one: float) -> bool | None:
        return decays(found.wave, found.answer, one, inertia, damping * velocity, found.noise)

    if (first := stable(spring)) is not False:
        return 0.0 if first else float("nan")
    clear = next((k for k, one in enumerate(springs) if stable(float(one)) is not False), SPRINGS)
    if clear == SPRINGS:
        return float(springs[-1])
    low, high = np.log(springs[clear - 1 : clear + 1]).tolist()
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(float(np.exp(middle))) is False else (low, middle)
    return float(np.exp(low))


class _Answer(NamedTuple):
    """G, `answer`, at wave numbers (1/length, shape (n,)), and by how much rounding may make it wrong, `noise`."""

    wave: Array
    answer: Array
    noise: Array


def _answer(contacts: Contacts, velocity: float, springs: Array, inertia: float) -> _Answer:
    """G at wave numbers for springs from the softest to the stiffest of these two."""
    unit = contacts.mean_threshold
    waves = np.array([_LEAST, _MOST]) / unit
    if inertia:
        waves[0] = min(waves[0], _BELOW * np.sqrt(springs[0] / inertia))
        waves[1] = max(waves[1], _ABOVE * np.sqrt((springs[1] + 1.0) / inertia))
    decades = float(np.log10(waves[1] / waves[0]))
    wave = np.geomspace(waves[0], waves[1], round(_PER_DECADE * decades) + 1)
    wave = np.union1d(wave, np.arange(1.0, _SWINGS, 0.5) / unit)
    summed = np.maximum(wave, _SLOW / unit)
    slower, answer = wave / summed, response(contacts, velocity, summed)
    answer = answer.real * slower**2 + 1j * answer.imag * slower
    noise, slow = np.zeros_like(wave), wave < summed
    if contacts.changing is None and slow.any():
        speeds = velocity * np.exp([-_APART, _APART])
        low, high = (steady_state(contacts, velocity=one).force for one in speeds.tolist())
        slope = (high - low) / (2.0 * _APART)
        first = int(np.flatnonzero(~slow)[0])
        # a curve through values beyond the first swings below it, too
        noise = np.minimum(wave / wave[first], 1.0) * abs(answer.imag[first] - slope * wave[first])
        answer[slow] = answer.real[slow] + 1j * slope * wave[slow]
    return _Answer(wave, answer, noise)


def decays(
    wave: Array,
    answer: Array,
    spring: float,
    inertia: float,
    drag: float,
    noise: Array | None = None,
) -> bool | None:
    """Whether disturbances decay, by G at wave numbers (shape (n,)) from where D is K to where it is as at infinity,
    and its `noise` there; None where that is not clear. `inertia`, `drag` : M v^2 and γ v."""
    noise = np.zeros_like(wave) if noise is None else noise
    if not np.isfinite(answer).all():
        return None
    rest = spring - inertia * wave**2 + 1j * drag * wave
    # where the rest is larger than this, D is off 0 whatever G is
    matters = np.abs(rest) < 2.0 * (np.abs(answer) + noise)
    off = np.abs(_curve(wave[::2], answer[::2], np.log(wave[1::2])) - answer[1::2])
    seen = (off < _HALF * np.abs(answer[1::2])) | ~matters[1::2]
    if not seen.all():
        return None
    finer = np.interp(
        np.arange((wave.size - 1) * _FINER + 1) / _FINER, np.arange(wave.size), np.log(wave)
    )
    q, g = np.exp(finer), _curve(wave, answer, finer)
    d = spring - inertia * q**2 + 1j * drag * q + g
    ahead = np.sign(d.real)
    at = np.flatnonzero(ahead[1:] != ahead[:-1])
    part = d.real[at] / (d.real[at] - d.real[at + 1])
    on_axis = d.imag[at] + part * (d.imag[at + 1] - d.imag[at])
    clear = np.abs(on_axis) > _OFF * np.abs(g[at]) + np.interp(q[at], wave, noise)
    # the ends are beyond all passings
    ends = ahead[0] > 0.0 and (ahead[-1] < 0.0) == bool(inertia)
    if not (clear.all() and ends):
        return None
    half_turns = (np.sign(on_axis) * ahead[at]).sum()
    return bool(half_turns == bool(inertia))


def _curve(wave: Array, answer: Array, log_wave: Array) -> Array:
    """G at these ln q, between those at which it is known."""
    parts = np.stack([answer.real, answer.imag], axis=1)
    curve = make_interp_spline(np.log(wave), parts, k=3)(log_wave)
    return np.asarray(curve[:, 0] + 1j * curve[:, 1])
