"""How the force of steady sliding answers a small disturbance of the slider's place, where heat breaks contacts.

A slider at X = v t + ε e^(pX) bears F_k + ε G e^(pX). A contact that has come as far as a since its birth is off by
ε (e^(pX) - e^(pX - pa)), and so is its rate h, by h' times this; what it has survived follows, and the births from the
number of contacts, which stays. With E(a) the survival, C its integral, A the integral of h dt = h da/v,

    w(a) = ∫ e^(-p (a - z)) dA(z) up to a,
    G = (p/C) [ ∫ a E w da - (∫ E w da) (∫ a E e^(-pa) da)/(∫ E e^(-pa) da) ],

sums over thresholds being understood. G -> p dF_k/d ln v for slow disturbances, and the part of the force that heat
breaks for fast ones: what breaks at its threshold breaks at the same places, and answers nothing.

On a spring K the disturbance grows where K + G(p) = 0 with a positive real part of p. As G has no poles there (a rigid
slider forgets), none does if K + G(iq) does not pass the negative real axis as q goes from 0 to infinity (Nyquist).
"""

import numpy as np

from master.outcome import stop_after
from master.steady.growing_response import Averages, growing_response, summed_along
from origins import Contacts
from origins.laws.proportional import ProportionalGrowth
from origins.thresholds.law import Array
from origins.thresholds.quadrature import gauss

# Ranks between which thresholds are summed, by Gauss nodes: denser where few contacts are.
_RANKS = np.array([0.0, 1e-6, 1e-4, 1e-2, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1.0 - 1e-4, 1.0 - 1e-6])
# A at the ends of steps along a: ln A rises evenly from where 1e-7 of the contacts have broken to where none is left.
_LOG_LEAST, _LOG_MOST, _STEPS = -16.0, 3.8, 266
# Wave numbers q per inverse mean threshold: slower disturbances see F_k(v), faster ones contacts that only stretch.
_WAVES = np.geomspace(1e-3, 300.0, 64)
# Least angle of K + G to the negative real axis, as a sine; sums above are off by some 1e-3 (measured).
_CLEAR = 0.02


def has_response(contacts: Contacts) -> bool:
    """Whether `response` takes these contacts: heat, by the closure "exact", breaks them, under no other law but growth
    by one factor."""
    thermal, growth = contacts.thermal, contacts.changing
    grows = {growth.law} if isinstance(growth, ProportionalGrowth) else set()
    alone = set(contacts.laws) - grows <= {"thermal", "stiffness"}
    return alone and thermal is not None and thermal.closure != "paper"


def response(contacts: Contacts, velocity: float, waves: Array) -> Array:
    """G(iq)/(N_c <k>), complex, at wave numbers q > 0 (1/length, shape (n,)), of contacts with heat and no other law
    but growth, which form again at once and relaxed; velocity: length per time. To some 1e-3 of its size."""
    assert contacts.thermal is not None
    law, rates, wave = contacts.thresholds, contacts.thermal.rates, 1j * np.asarray(waves)
    ranks, weight = (each.ravel() for each in gauss(_RANKS[:-1], _RANKS[1:]))
    if contacts.changing is not None:
        return growing_response(contacts, velocity, waves, ranks, weight)
    x = np.asarray(law.ppf(ranks))
    fractions = np.stack([weight, weight * contacts.relative_stiffness(x)]) / weight.sum()
    stiffness, log_v, log_a = (
        fractions[1] / fractions[0],
        np.log(velocity),
        np.linspace(_LOG_LEAST, _LOG_MOST, _STEPS),
    )
    with np.errstate(all="ignore"):
        at = [rates.reached(log_v + each, 0.0, x, stiffness) for each in log_a]
        most = np.exp(np.minimum(rates.log_passed(0.0, x, x, stiffness) - log_v, _LOG_MOST))
    a = np.minimum(np.array([np.zeros(x.size), *at]), x)
    passed = np.minimum(np.append(0.0, np.exp(log_a))[:, None], most)
    survivals = np.exp(-passed)
    fall = -np.diff(survivals, axis=0)
    fall[-1] += survivals[-1]  # those that are left break at their thresholds
    breaks = np.diff(passed, axis=0)

    def gained(step: int, of: Averages, until: Array) -> tuple[Array, Array]:
        """What w gains along the step, on which h is constant."""
        return breaks[step][:, None] * of.rest, breaks[step][:, None] * of.mean

    sums, _ = summed_along(a, survivals, fall, fractions, wave, gained)
    on_step = 0.5 * (survivals[1:] + survivals[:-1])
    length = fractions[0] @ (on_step * np.diff(a, axis=0)).sum(axis=0)
    survival, by_stiffness = (fractions.sum(axis=1)[:, None] - sums.broken) / wave
    first = (by_stiffness - sums.stretched) / wave
    return np.asarray(wave / length * (sums.pulled - sums.answered * first / survival))


def is_stable(contacts: Contacts, velocity: float, spring: float, until: float = np.inf) -> bool:
    """Whether small disturbances of steady sliding at this speed decay on a spring K/(N_c <k>), clearly. StoppedError
    after `until`, a reading of time.monotonic(): creep asks this of a hundred speeds, for seconds together."""
    stop_after(until)
    answer = spring + response(contacts, velocity, _WAVES / contacts.mean_threshold)
    back = ~(answer.real >= 0.0)  # or not known
    return bool((answer.imag[back] > _CLEAR * np.abs(answer[back])).all())
