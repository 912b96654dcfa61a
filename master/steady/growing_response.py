"""How the force of steady sliding answers a small disturbance where contacts grow stronger as they break by heat.

As master/steady/response.py, whose closed integrals of the rate hold at one threshold: here that of a contact of age t
is x_s(t) = x_s0 g(t), at the stretch a that of t = a/v. With h_x, the slope of its rate in the stretch, and r = h_x/v,
a disturbance ε e^(pX) of the slider changes the stretch of a contact that has come as far as a by (1 - e^(-pa)) times
itself, and A, the integral of its rate, by D times itself:

    dD/da = -p D + r (1 - e^(-pa)).

One that reaches its threshold at the stretch b breaks there by d = -(1 - e^(-pb))/(1 - x_s0 g'/v) later. The number of
contacts stays, which tells the births, B ε e^(pX) of one; C is the integral of the survival E, a sum over thresholds is
understood, and E(b), where heat leaves any, is the share that reaches its threshold:

    B ∫ E e^(-pa) da = ∫ E D da - E(b) d,
    C G = B ∫ a E e^(-pa) da - ∫ a E D da + ∫ E (1 - e^(-pa)) da + b E(b) d.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.laws.proportional import ProportionalGrowth
from origins.thresholds.law import Array

# A at the ends of steps along a: ln A rises evenly from where 1e-7 of the contacts have broken to where none is left.
LOG_LEAST, LOG_MOST, STEPS = -16.0, 3.8, 800
# Stretches at which A is first found, evenly up to the threshold; and the fewest of them on which A must rise from its
# least to its most, as ln A is a straight line between them.
_COARSE, _FEWEST = 3000, 30
# Relative step of a threshold by which the slope of a rate in it is found, and of an age for that of the growth.
_STEP = 1e-5
# pa below which averages are taken by their series.
_SMALL = 1e-4
# Turns until the stretch at which a contact meets its threshold is known to rounding: each leaves a part x_s0 g'/v.
_TURNS = 100


def growing_response(
    contacts: Contacts, velocity: float, waves: Array, ranks: Array, weight: Array
) -> Array:
    """G(iq)/(N_c <k>), complex, at wave numbers q > 0 (1/length, shape (n,)), of contacts that grow and break by heat;
    `ranks`, `weight`: of thresholds at birth, shape (m,). nan where steps of A do not resolve the rates."""
    growth, wave = contacts.changing, 1j * np.asarray(waves)
    assert contacts.thermal is not None and isinstance(growth, ProportionalGrowth)
    x = np.asarray(growth.fresh.ppf(ranks))
    fractions = np.stack([weight, weight * contacts.relative_stiffness(x)]) / weight.sum()
    stiffness = fractions[1] / fractions[0]

    def threshold(a: Array) -> Array:
        return np.asarray(x * growth.factor(a / velocity))

    def log_rate(a: Array, at: Array) -> Array:
        """ln h/v at these stretches and thresholds, whose last axis is that of x."""
        with np.errstate(all="ignore"):
            return np.asarray(contacts.thermal.rates.log_rate(a, at, stiffness)) - np.log(velocity)  # type: ignore[union-attr]

    end = x.copy()
    for _ in range(_TURNS):
        end = threshold(end)
    a, passed = _steps_of(end, lambda stretch: log_rate(stretch, threshold(stretch)))
    if not a.size:
        return np.full(wave.size, np.nan + 0j)
    survivals, middle = np.exp(-passed), 0.5 * (a[1:] + a[:-1])
    fall = -np.diff(survivals, axis=0)
    at_end = survivals[-1]
    # dh = h_x da + h_s dx_s, so that h_x da is known as exactly as h
    at, rise = threshold(a), np.diff(threshold(a), axis=0)
    rate, above = np.exp(log_rate(a, at)), np.exp(log_rate(a, at * (1.0 + _STEP)))
    by_threshold = np.where(np.isfinite(above), above - rate, 0.0) / (at * _STEP)
    rises = np.diff(rate, axis=0) - 0.5 * (by_threshold[1:] + by_threshold[:-1]) * rise
    fell_at_end = fractions * at_end
    length, of_stiffness = (
        (part * ((fall * middle).sum(axis=0) + at_end * a[-1])).sum() for part in fractions
    )

    def gained(step: int, of: Averages, until: Array) -> tuple[Array, Array]:
        gains = rises[step][:, None]
        return gains * (of.rest - until * of.first), gains * (of.mean - until * of.turned)

    sums, until = summed_along(a, survivals, fall, fractions, wave, gained)
    broken = sums.broken + fell_at_end @ until
    stretched = sums.stretched + (fell_at_end[1] * a[-1]) @ until
    ages = a[-1] / velocity
    slope = x * (growth.factor(ages * (1.0 + _STEP)) - growth.factor(ages)) / (ages * _STEP)
    later = -(1.0 - until) / (1.0 - slope / velocity)[:, None]
    survival, by_stiffness = (fractions.sum(axis=1)[:, None] - broken) / wave
    first_moment = (by_stiffness - stretched) / wave
    births = (sums.answered - fell_at_end[0] @ later) / survival
    force = births * first_moment - sums.pulled + of_stiffness - by_stiffness
    return np.asarray((force + (fell_at_end[1] * a[-1]) @ later) / length)


def _steps_of(end: Array, log_rate: Callable[[Array], Array]) -> tuple[Array, Array]:
    """Stretches at the ends of steps, from 0 to `end` at most (n_steps + 1, m), and A there; both empty where A rises
    too steeply. `log_rate` : ln h/v at stretches, of their shape."""
    coarse = end * np.linspace(0.0, 1.0, _COARSE + 1)[1:, None]
    logs = np.clip(np.nan_to_num(log_rate(coarse), nan=-700.0), -700.0, 700.0)
    rise = np.diff(logs, axis=0)
    # of an exponential between two of them; the first part is short, and bears nothing
    steep = np.abs(rise) > 1e-6
    means = np.where(steep, np.expm1(rise) / np.where(steep, rise, 1.0), 1.0 + 0.5 * rise)
    parts = np.exp(np.minimum(logs[:-1], 300.0)) * means * np.diff(coarse, axis=0)
    first = np.exp(np.minimum(logs[:1], 300.0)) * coarse[:1]
    log_amount = np.log(np.maximum(np.cumsum(np.append(first, parts, axis=0), axis=0), 1e-300))
    asked = np.linspace(LOG_LEAST, LOG_MOST, STEPS)
    inside = ((log_amount > LOG_LEAST) & (log_amount < LOG_MOST)).sum(axis=0)
    if (inside < _FEWEST).any():
        return np.empty((0, end.size)), np.empty((0, end.size))
    a = np.stack([np.interp(asked, log_amount[:, k], coarse[:, k]) for k in range(end.size)], 1)
    passed = np.minimum(np.exp(asked)[:, None], np.exp(np.minimum(log_amount[-1], LOG_MOST)))
    zero = np.zeros((1, end.size))
    return np.append(zero, a, axis=0), np.append(zero, passed, axis=0)


class Averages(NamedTuple):
    """Of a step along a, with u = p times its length: `turned` is e^(-u); `mean`, `rest` and `first` are the means of
    e^(-us), of (1 - e^(-us))/u and of s e^(-us) over its parts s from 0 to 1."""

    turned: Array
    mean: Array
    rest: Array
    first: Array


class Summed(NamedTuple):
    """Sums along all steps, over thresholds; complex, shape (n,), of contacts and of their stiffness (2, n).

    broken, stretched : of e^(-pa) where contacts break, and of their stiffness times the stretch there
    answered, pulled : integrals of E D of contacts, and of a E D of their stiffness
    """

    broken: Array
    stretched: Array
    answered: Array
    pulled: Array


def summed_along(
    a: Array,
    survivals: Array,
    fall: Array,
    fractions: Array,
    wave: npt.NDArray[Any],
    gained: Callable[[int, Averages, Array], tuple[Array, Array]],
) -> tuple[Summed, Array]:
    """The sums along steps, and e^(-pa) at the last end, shape (m, n).

    a, survivals : stretches at the ends of steps, and E there, shape (n_steps + 1, m); fall : of E on each step
    fractions : of contacts at each threshold, and of their stiffness, shape (2, m); wave : p (1/length, shape (n,))
    gained : what D gains on a step, in the mean and at its end, by its averages and e^(-pa) at its begin
    """
    travel, middle = np.diff(a, axis=0), 0.5 * (a[1:] + a[:-1])
    # E and a E: their means on each step, and a twelfth of their changes, as those of D go along with them
    both = np.stack([survivals, a * survivals])
    on_step, along = 0.5 * (both[:, 1:] + both[:, :-1]), np.diff(both, axis=1) / 12.0
    broken = np.zeros((2, wave.size), dtype=complex)
    stretched, answered, pulled = (np.zeros(wave.size, dtype=complex) for _ in range(3))
    change = np.zeros((a.shape[1], wave.size), dtype=complex)  # D
    until = np.ones_like(change)  # e^(-pa) at the begin of the step
    for step in range(len(travel)):
        of = _averages(travel[step][:, None] * wave)
        fell = until * of.mean * fall[step][:, None]
        broken += fractions @ fell
        stretched += (fractions[1] * middle[step]) @ fell
        in_mean, at_end = gained(step, of, until)
        mean_change, after = change * of.mean + in_mean, change * of.turned + at_end
        weights = fractions * travel[step]
        answered += (weights[0] * on_step[0, step]) @ mean_change
        answered += (weights[0] * along[0, step]) @ (after - change)
        pulled += (weights[1] * on_step[1, step]) @ mean_change
        pulled += (weights[1] * along[1, step]) @ (after - change)
        change = after
        until *= of.turned
    return Summed(broken, stretched, answered, pulled), until


def _averages(p_a: npt.NDArray[Any]) -> Averages:
    """The averages at p a of steps; by their series, to 1e-8, where that is small."""
    turned, far = np.exp(-p_a), np.abs(p_a) > _SMALL
    mean, rest, first = 1.0 - 0.5 * p_a, 0.5 - p_a / 6.0, 0.5 - p_a / 3.0
    mean[far] = (1.0 - turned[far]) / p_a[far]
    rest[far] = (1.0 - mean[far]) / p_a[far]
    first[far] = (mean[far] - turned[far]) / p_a[far]
    return Averages(turned, mean, rest, first)
