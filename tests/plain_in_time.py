"""A slider that a spring pulls along any path, in equal steps of time: the plainest form of master/soft/in_time."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from origins import Thermal, Thresholds

CELLS = 200  # of thresholds
NEAR = 4.0  # travel in a step, in that of the drive, beyond which a slip has begun


class Pulled(NamedTuple):
    """What is pulled, and by which spring (K/(N_c<k>)): thresholds at the age a are fresh ones times growth(a)."""

    law: Thresholds
    spring: float
    thermal: Thermal | None = None
    delay: float = 0.0  # a whole number of steps
    growth: Callable[[np.ndarray], np.ndarray] = np.ones_like
    start: float = 0.0  # stretch of all contacts at t = 0, and their age
    age: float = 0.0


def pulled(of: Pulled, times: list[float], places: list[float], steps: int) -> np.ndarray:
    """F/(N_c<k>) after each step of a drive that begins at balance and goes straight from place to place; second order
    where nothing slips. Where no X near the last one is a balance all contacts are replaced, as under "reset", at the
    end of the step. All times are ends of steps. Each cohort is born relaxed in the middle of its step."""
    law, step = of.law, times[-1] / steps
    wait = round(of.delay / step)
    edges = np.linspace(0.0, law.isf(1e-12), CELLS + 1)
    beyond, fresh = law.sf(edges), 0.5 * (edges[1:] + edges[:-1])
    # of each cohort, the start first: X and t at birth, the largest fresh threshold whose contacts have broken, the
    # share of all contacts, and the integral of their rates until now
    birthplace, born_at = np.array([-of.start]), np.array([-of.age])
    least = np.abs([of.start]) / of.growth(np.array([of.age]))
    share, integral = 1.0 / law.sf(least), np.zeros((1, CELLS))
    now, position, out = 0.0, 0.0, 0.0
    forces, breaks = list[float](), list[float]()

    def after_step(x: float) -> tuple[np.ndarray, ...]:
        """The cohorts, and a new one, after a step to X = x; and each one's survival."""
        born_x = np.append(birthplace, 0.5 * (position + x))
        born_t = np.append(born_at, now + 0.5 * step)
        met = np.abs(x - born_x) / of.growth(now + step - born_t)
        met = np.maximum(np.append(least, 0.0), met)
        if of.thermal is None:
            integrals, survival = np.zeros((share.size + 1, 1)), law.sf(met)
        else:
            integrals = np.vstack([integral, np.zeros(CELLS)])
            begin = np.append(position - birthplace, 0.0)
            halfway = np.abs(0.5 * (begin + x - born_x))
            duration = np.append(np.full(share.size, step), 0.5 * step)
            threshold = fresh * of.growth(now + step - born_t - 0.5 * duration)[:, None]
            rate = of.thermal.rates.rate(halfway[:, None], threshold, 1.0)
            integrals = integrals + rate * duration[:, None]
            unmet = law.sf(met)[:, None]
            weight = np.maximum(np.minimum(unmet, beyond[:-1]) - beyond[1:], 0.0)
            survival = (weight * np.exp(-integrals)).sum(axis=1)
        if wait:  # what broke a delay ago is born
            born = breaks[-wait] if len(breaks) >= wait else 0.0
        else:  # as many as make all contacts hold
            born = (1.0 - share @ survival[:-1]) / survival[-1]
        return born_x, born_t, met, np.append(share, born), integrals, survival

    balance = of.start / of.spring
    drive = balance + np.interp(step * np.arange(1, steps + 1), times, places)
    # farther than the slider goes in a step, unless it slips
    furthest = NEAR * float(np.abs(np.diff(places) / np.diff(times)).max()) * step
    for n, load in enumerate(of.spring * drive, 1):

        def imbalance(x: float, load: float = load) -> float:
            born_x, _, _, shares, _, survival = after_step(x)
            return load - of.spring * x - shares @ (survival * (x - born_x))

        if imbalance(position + furthest) > 0.0:
            now, position, out = n * step, float(drive[n - 1]), 0.0
            birthplace, born_at, least = np.array([position]), np.array([now]), np.zeros(1)
            share, integral = np.ones(1), np.zeros((1, CELLS))
            forces.append(0.0)
            breaks.append(0.0)
            continue
        x = float(brentq(imbalance, position - furthest, position + furthest, xtol=1e-13))
        birthplace, born_at, least, share, integral, survival = after_step(x)
        breaks.append(1.0 - share @ survival - out + share[-1])
        now, position, out = n * step, x, 1.0 - share @ survival
        forces.append(load - of.spring * x)
    return np.array(forces)
