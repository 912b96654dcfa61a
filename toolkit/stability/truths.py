"""Closed forms and quadratures that extreme cases are held against; none of them uses a solver."""

from collections.abc import Callable

import numpy as np
import scipy

from origins.contacts import Contacts
from origins.thresholds.law import Array, Thresholds
from toolkit.stability.case import Truth


def gaussian(contacts: Contacts, path: Array) -> Truth:
    """F of Gaussian thresholds from one stretch, which toolkit.judge.closed_form derives."""
    from toolkit.judge.closed_form import closed_form

    force, error = closed_form(contacts, path)
    return Truth(force / contacts.mean_threshold, error, "closed form")


def sawtooth(contacts: Contacts, path: Array) -> Truth:
    """F of one exact value from relaxed contacts: X less the thresholds that have broken."""
    unit = contacts.mean_threshold
    return Truth(np.mod(path / unit, 1.0), 4e-16 * np.abs(path / unit) + 1e-15, "closed form")


def steady(contacts: Contacts, path: Array) -> Truth:
    """F_k = <x_s²>/(2<x_s>) of thresholds at T = 0, for paths so long that F has settled."""
    law = contacts.thresholds
    value = 0.5 * law.moment(2) / law.mean() ** 2
    return Truth(np.full(path.shape, value), 1e-10 * value, "F_k from two moments")


def waiting(delay: float) -> Callable[[Contacts, Array], Truth]:
    """F_k at T = 0 where contacts wait for `delay` mean thresholds of the way: F_k <x_s>/(<x_s> + the wait)."""

    def truth(contacts: Contacts, path: Array) -> Truth:
        still = steady(contacts, path)
        return Truth(still.values / (1.0 + delay), still.error, "F_k and the share that waits")

    return truth


def without_laws(error: float, road: str) -> Callable[[Contacts, Array], Truth]:
    """F of the same Gaussian thresholds at T = 0 without any law, where laws move it by less than `error`."""
    return lambda contacts, path: Truth(
        gaussian(Contacts(contacts.thresholds), path).values, error, road
    )


def at_rates(passed: Callable[[Array, Array], Array]) -> Callable[[Contacts, Array], Truth]:
    """F_k of contacts that break at a rate of their stretch, by quadrature over stretches and thresholds; `passed` is
    the rate's integral from 0 to a stretch, of a threshold, both in mean thresholds, per mean threshold of the way."""

    def truth(contacts: Contacts, path: Array) -> Truth:
        law, unit = contacts.thresholds, contacts.mean_threshold
        first, last = float(law.ppf(1e-12)) / unit, float(law.isf(1e-12)) / unit
        node, weight = np.polynomial.legendre.leggauss(400)
        threshold, density = _stretched(node, weight, first, last)
        density = (density * law.pdf(threshold * unit))[:, None]
        # for each threshold stretches from 0 up to it, as survivals end there
        threshold = threshold[:, None]
        x, w = 0.5 * threshold * (node + 1.0), 0.5 * threshold * weight
        survival = density * w * np.exp(-passed(x, threshold))
        still = _mean_stretch(x, survival)
        return Truth(np.full(path.shape, still.values), still.error, still.road)

    return truth


def grown(law: Thresholds, beta: float, speed: float) -> Truth:
    """F_k of thresholds that grow, x_s0 (1 + β ln(1 + age)) with the age in τ_0, at a speed in <x_s>/τ_0: the mean of x
    over S(x/g), S the survival of x_s0, in mean thresholds of contacts of age 0."""
    unit, node, weight = law.mean(), *np.polynomial.legendre.leggauss(600)
    end = float(law.isf(1e-20)) / unit
    for _ in range(200):  # the largest threshold is that of an age which it decides
        end = float(law.isf(1e-20)) / unit * (1.0 + beta * np.log1p(end / speed))
    x, w = _stretched(node, weight, 0.0, end)
    survival = w * law.sf(x * unit / (1.0 + beta * np.log1p(x / speed)))
    return _mean_stretch(x, survival)


def slope_of_grown(law: Thresholds, beta: float, speed: float) -> Truth:
    """Their dF_k/dln v, which is a - b of rate and state, by differences over an e-fold and half of it."""
    wide, near = (
        (up.values - down.values) / (2.0 * step)
        for step in (0.2, 0.1)
        for up, down in [(grown(law, beta, speed * np.exp(s)) for s in (step, -step))]
    )
    value = float((4.0 * near - wide) / 3.0)
    return Truth(value, abs(value - float(near)) + 1e-8, "differences of F_k by quadrature")


def before_breaks(
    spring: float, mass: float, damping: float, contacts: Contacts, path: Array
) -> Truth:
    """The spring's force on a slider with mass before any contact breaks, in N_c<k> and mean thresholds: an oscillator
    from rest on a drive of speed 1."""
    time, total = path / contacts.mean_threshold, 1.0 + spring
    lag = (
        spring * damping / total
    )  # by which damping pulls back steady motion at the speed K/(1 + K)
    half = 0.5 * damping / mass
    apart = np.sqrt(complex(half**2 - total / mass))
    fast = -half - apart
    slow = total / mass / fast  # the product of both is known without loss of digits
    # X = w t - s + a e^(slow t) + b e^(fast t), at rest at 0
    speed, shift = spring / total, lag / total
    a = (speed + shift * fast) / (fast - slow)
    swing = a * np.exp(slow * time) + (shift - a) * np.exp(fast * time)
    x = (speed * time - shift + swing).real
    floor = 1e-15 * (1.0 + spring * time.max())
    return Truth(spring * (time - x), floor, "an oscillator, in closed form")


def _mean_stretch(x: Array, survival: Array) -> Truth:
    """F_k as the mean of stretches in steady sliding, of which so many contacts hold."""
    value = float((x * survival).sum() / survival.sum())
    return Truth(value, 1e-9 * value, "F_k by quadrature")


def _stretched(node: Array, weight: Array, first: float, last: float) -> tuple[Array, Array]:
    """Nodes and weights of [-1, 1] on [first, last]."""
    half = 0.5 * (last - first)
    return first + half * (node + 1.0), half * weight


def steady_at_last(contacts: Contacts, path: Array) -> Truth:
    """F = X before any break, and F_k at the last point."""
    last = steady(contacts, path[-1:]).values[0]
    return Truth(np.append(path[:-1] / contacts.mean_threshold, last), 1e-9, "F_k from two moments")


def all_gone_at_last(contacts: Contacts, path: Array) -> Truth:
    """Relaxed contacts that form at rest bear nothing: F = 0 at the last point; nothing is said of those before."""
    values = np.append(np.zeros(path.size - 1), 0.0)
    errors = np.append(np.full(path.size - 1, np.inf), 1e-9)
    return Truth(values, errors, "no stretched contact holds for so long")


def no_break(contacts: Contacts, path: Array) -> Truth:
    """F where no contact breaks: the mean start and the way."""
    return Truth(
        (contacts.start.mean() + path) / contacts.mean_threshold, 1e-14, "no contact breaks: F is X"
    )


def critical(law: Thresholds) -> Truth:
    """K*/N<k> of relaxed contacts at T = 0, max(x P_c(x)) - 1, where F falls most before any contact breaks twice."""
    ends = (float(law.ppf(0.01)), float(law.ppf(0.99)))
    found = scipy.optimize.minimize_scalar(
        lambda x: -x * float(law.pdf(x)), bounds=ends, options={"xatol": 1e-12}
    )
    return Truth(-float(found.fun) - 1.0, 1e-9, "max x P_c(x) - 1")


def first_maximum(contacts: Contacts) -> Truth:
    """The first maximum of F, at which a slider on a soft spring lets go."""
    path = np.linspace(0.7, 1.1, 400_001) * contacts.mean_threshold
    highest = gaussian(contacts, path).values.max()
    return Truth(np.array([highest]), 2e-9, "the first maximum of F, in closed form")


def pulled(spring: float, contacts: Contacts, path: Array, near: float = 1e-6) -> Truth:
    """F of Gaussian thresholds on a spring, whose contacts re-form at once in a slip: the slider stands at the first X
    at which F(X) + K X reaches K X_T, as F hangs on X alone. Nothing is said of points at which K X_T is within `near`
    mean thresholds of a slip's."""
    unit, drive = contacts.mean_threshold, path / contacts.mean_threshold

    def balance(x: Array) -> Array:
        return gaussian(contacts, x * unit).values + spring * x

    grid = np.linspace(0.0, drive[-1] + 1.0, 20_001)
    highest = np.maximum.accumulate(balance(grid))
    levels, steps = np.unique(highest, return_counts=True)
    slips = levels[steps > 10]  # a slip leaps over many steps of the grid
    apart = np.abs(spring * drive[:, None] - slips).min(axis=1, initial=np.inf)
    high = grid[np.searchsorted(highest, spring * drive)]
    low = np.maximum(high - grid[1], 0.0)
    for _ in range(50):
        middle = 0.5 * (low + high)
        balanced = balance(np.append(middle, grid[-1]))[:-1] >= spring * drive
        low, high = np.where(balanced, low, middle), np.where(balanced, middle, high)
    error = np.where(apart <= near, np.inf, 1e-12 * (1.0 + spring))
    return Truth(spring * (drive - high), error, "F of the rigid slider, in closed form")
