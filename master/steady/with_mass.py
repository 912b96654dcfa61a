"""Whether steady sliding of a slider with mass is stable against small disturbances, where heat breaks its contacts.

A slider at X = v t + ε e^(pX), on a spring K, with the mass M and the damping γ, moves so by itself where

    D(p) = M v^2 p^2 + γ v p + K + G(p) = 0,

G being the answer of the contacts' force (master/steady/response.py), which has no poles where p has a positive real
part. As q goes from 0 to infinity D(iq) goes from K to -M v^2 q^2. No zero has a positive real part if its argument
rises by π on the way, and without a mass, where it ends at K + G(∞), if it comes back to 0 (the argument principle):
with each passing of the imaginary axis it changes by π, forth or back. A passing is clear where D is farther from 0
than G may be off.

An example: G = 0, as of contacts at T = 0, K = 1, M v^2 = 1, γ v = 0.1. D passes the axis once, at q = 1, upwards at
0.1 i: half a turn, stable. With γ v = -0.1 it passes at -0.1 i, half a turn back, and the swing grows by e^(0.05 X).
"""

import numpy as np
from scipy.interpolate import make_interp_spline

from master.steady.response import response
from origins import Contacts
from origins.thresholds.law import Array

# Wave numbers per inverse mean threshold at which G is found where nothing asks for more, and so many in each decade.
_LEAST, _MOST, _PER_DECADE = 1e-3, 300.0, 12
# Wave number below which G is a i q + c q^2 to a thousandth, a and c being those at it: the sums there cancel out.
_SLOW = 1e-2
# Parts of the wave number of mass and spring, and times that of mass and contacts which only stretch, that are in it.
_BELOW, _ABOVE = 0.1, 10.0
# Part of G by which D may be off: sums are off by some 1e-3 of it, as measured, and a curve through them by as much.
_OFF = 0.02
# Points of the curve between two neighbours.
_FINER = 40


def sliding_is_stable(
    contacts: Contacts, velocity: float, spring: float, mass: float = 0.0, damping: float = 0.0
) -> bool | None:
    """Whether small disturbances of steady sliding at this speed decay, of contacts that `has_response` takes; None
    where that is not clear. Spring, mass and damping per N_c<k>."""
    unit, inertia = contacts.mean_threshold, mass * velocity**2
    waves = np.array([_LEAST, _MOST]) / unit
    if mass:
        waves[0] = min(waves[0], _BELOW * np.sqrt(spring / inertia))
        waves[1] = max(waves[1], _ABOVE * np.sqrt((spring + 1.0) / inertia))
    decades = float(np.log10(waves[1] / waves[0]))
    wave = np.geomspace(waves[0], waves[1], round(_PER_DECADE * decades) + 1)
    summed = np.maximum(wave, _SLOW / unit)
    slower, answer = wave / summed, response(contacts, velocity, summed)
    answer = answer.real * slower**2 + 1j * answer.imag * slower
    return decays(wave, answer, spring, inertia, damping * velocity)


def decays(wave: Array, answer: Array, spring: float, inertia: float, drag: float) -> bool | None:
    """Whether disturbances decay, by G at wave numbers (shape (n,)) from where D is K to where it is as at infinity;
    None where that is not clear. `inertia`, `drag` : M v^2 and γ v."""
    if not np.isfinite(answer).all():
        return None
    finer = np.interp(
        np.arange((wave.size - 1) * _FINER + 1) / _FINER, np.arange(wave.size), np.log(wave)
    )
    curve = make_interp_spline(np.log(wave), np.stack([answer.real, answer.imag], axis=1), k=3)(
        finer
    )
    q, g = np.exp(finer), curve[:, 0] + 1j * curve[:, 1]
    d = spring - inertia * q**2 + 1j * drag * q + g
    ahead = np.sign(d.real)
    at = np.flatnonzero(ahead[1:] != ahead[:-1])
    part = d.real[at] / (d.real[at] - d.real[at + 1])
    on_axis = d.imag[at] + part * (d.imag[at + 1] - d.imag[at])
    clear = np.abs(on_axis) > _OFF * np.abs(g[at])
    # the ends are beyond all passings
    ends = ahead[0] > 0.0 and (ahead[-1] < 0.0) == bool(inertia)
    if not (clear.all() and ends):
        return None
    half_turns = (np.sign(on_axis) * ahead[at]).sum()
    return bool(half_turns == bool(inertia))
