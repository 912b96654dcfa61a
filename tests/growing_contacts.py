"""Growing grains one by one in numpy, in small steps: what the master equation of them is held against."""

import numpy as np

from origins import Contacts

_SIZES = 1.0 - np.concatenate([np.linspace(1.0, 0.02, 4000), np.geomspace(0.02, 1e-4, 4000)[1:]])
_PSI = 4.0 / 3.0 * np.log1p(_SIZES / 2.0) + 5.0 / 3.0 * np.log1p(-_SIZES) + _SIZES / (1.0 - _SIZES)


def thresholds(contacts: Contacts, hazard: np.ndarray, age: np.ndarray) -> np.ndarray:
    """Of contacts with these hazards of their quantiles, from the law of grain sizes as it is printed."""
    growth = contacts.grains.growth
    largest = np.cbrt(np.maximum(age / growth.first_pinning_time, 1.0))
    least = 1.0 / largest
    with np.errstate(divide="ignore", invalid="ignore"):
        before = 4.0 / 3.0 * np.log1p(least / 2.0) + 5.0 / 3.0 * np.log1p(-least) + least / (1.0 - least)
    size = largest * np.interp(hazard + before, _PSI, _SIZES)
    return np.sqrt(np.maximum(size * size - 1.0, 0.0) / growth.B)


def rate(contacts: Contacts, x: np.ndarray, threshold: np.ndarray) -> np.ndarray:
    """h as it is printed."""
    thermal, share = contacts.thermal, np.clip(1.0 - np.abs(x) / np.maximum(threshold, 1e-12), 0.0, 1.0)
    if thermal.law == "soft":
        barrier, factor = 0.5 * (threshold**2 - x**2), 1.0
    else:
        barrier, factor = 0.5 * threshold**2 * share**1.5, share**0.5
    return thermal.attempt_frequency * factor * np.exp(-np.maximum(barrier, 0.0) / thermal.temperature)


def pulled_steadily(
    contacts: Contacts, path: np.ndarray, velocity: float, count: int, step: float, seed: int = 1
) -> np.ndarray:
    """Mean stretch and fraction that holds, each with its standard error, at the points of a path from 0 on; shape
    (2, 2, n)."""
    generator = np.random.default_rng(seed)
    grains, wait = contacts.grains, contacts.waiting_time
    first = grains.growth.first_pinning_time
    start = contacts.start
    x = np.full(count, start.mean()) if start.is_single else start.ppf(generator.random(count))
    own = np.asarray(grains.hazard(np.abs(x), grains.age)) + generator.exponential(size=count)
    pinned, clock, place, told = np.full(count, first - grains.age), 0.0, 0.0, []
    for point in path:
        steps = int(np.ceil((point - place) / velocity / step))
        dt = (point - place) / velocity / steps
        for _ in range(steps):
            clock += dt
            x += velocity * dt
            new = np.flatnonzero((pinned > clock - dt) & (pinned <= clock))
            x[new], own[new] = velocity * (clock - pinned[new]), generator.exponential(size=new.size)
            holds = np.flatnonzero(pinned <= clock)
            age = first + clock - pinned[holds]
            breaks = np.abs(x[holds]) >= thresholds(contacts, own[holds], age)
            if contacts.thermal is not None:
                since = np.minimum(clock - pinned[holds], dt)
                middle, then = x[holds] - 0.5 * velocity * since, age - 0.5 * since
                spent = rate(contacts, middle, thresholds(contacts, own[holds], then)) * since
                breaks |= generator.random(holds.size) < -np.expm1(-spent)
            broken = holds[breaks]
            late = np.where(np.isin(broken, new), pinned[broken], clock - dt * generator.random(broken.size))
            pinned[broken] = late + wait
        place = point
        force, holding = np.where(pinned > clock, 0.0, x), pinned <= clock
        told.append([(one.mean(), max(one.std(), 1e-2) / np.sqrt(count)) for one in (force, holding)])
    return np.array(told).transpose(1, 2, 0)


def deviation(contacts: Contacts, solved, told: np.ndarray) -> float:
    """The largest difference of force and fraction that holds, in standard errors with the solution's own."""
    own = solved.force_error * contacts.mean_threshold
    rows = zip(told, (solved.force, solved.holding), strict=True)
    return max(float((np.abs(mean - found) / (error + own)).max()) for (mean, error), found in rows)
