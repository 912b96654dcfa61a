"""Growing grains one by one in numpy, in small steps: what the master equation of them is held against."""

import numpy as np

from origins import Contacts

_SIZES = 1.0 - np.concatenate([np.linspace(1.0, 0.02, 4000), np.geomspace(0.02, 1e-4, 4000)[1:]])
_LARGE = 0.05  # of all contacts, which an avalanche at a standing drive breaks: a slip
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


def along(
    contacts: Contacts, path: np.ndarray, time: np.ndarray, count: int, step: float, seed: int = 1
) -> np.ndarray:
    """Mean stretch and fraction that holds, each with its standard error, at the points of a path from 0 on, reached at
    these times; `step` is one of time. Shape (2, 2, n)."""
    generator = np.random.default_rng(seed)
    grains, wait, start = contacts.grains, contacts.waiting_time, contacts.start
    first = grains.growth.first_pinning_time
    x = np.full(count, start.mean()) if start.is_single else start.ppf(generator.random(count))
    own = np.asarray(grains.hazard(np.abs(x), grains.age)) + generator.exponential(size=count)
    pinned, clock, told = np.full(count, first - grains.age), 0.0, []
    for travel, duration in zip(np.diff(path, prepend=0.0), np.diff(time, prepend=0.0), strict=True):
        steps = int(np.ceil(duration / step))
        dx, dt = travel / steps, duration / steps
        for _ in range(steps):
            clock += dt
            x += dx
            new = np.flatnonzero((pinned > clock - dt) & (pinned <= clock))
            x[new], own[new] = dx / dt * (clock - pinned[new]), generator.exponential(size=new.size)
            holds = np.flatnonzero(pinned <= clock)
            age = first + clock - pinned[holds]
            breaks = np.abs(x[holds]) >= thresholds(contacts, own[holds], age)
            if contacts.thermal is not None:
                since = np.minimum(clock - pinned[holds], dt)
                middle, then = x[holds] - 0.5 * dx / dt * since, age - 0.5 * since
                spent = rate(contacts, middle, thresholds(contacts, own[holds], then)) * since
                breaks |= generator.random(holds.size) < -np.expm1(-spent)
            broken = holds[breaks]
            # those that pinned within the step never held, others broke somewhere in it
            late = np.where(np.isin(broken, new), pinned[broken], clock - dt * generator.random(broken.size))
            pinned[broken] = late + wait
        force, holding = np.where(pinned > clock, 0.0, x), pinned <= clock
        told.append([(one.mean(), max(one.std(), 1e-2) / np.sqrt(count)) for one in (force, holding)])
    return np.array(told).transpose(1, 2, 0)


def deviation(contacts: Contacts, solved, told: np.ndarray) -> float:
    """The largest difference of force and fraction that holds, in standard errors with the solution's own."""
    own = solved.force_error * contacts.mean_threshold
    rows = zip(told, (solved.force, solved.holding), strict=True)
    return max(float((np.abs(mean - found) / (error + own)).max()) for (mean, error), found in rows)


def pulled_by_a_spring(
    contacts: Contacts, path: np.ndarray, velocity: float, spring: float, rule: str, step: float, count: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Slips (drive, slider before and after, force before and after), shape (5, m), and the force at drive positions
    `path`; with the drive standing the slider follows until nothing more breaks, and what breaks waits."""
    generator = np.random.default_rng(seed)
    grains, wait = contacts.grains, contacts.waiting_time
    first = grains.growth.first_pinning_time
    x = np.full(count, contacts.start.mean())
    own = np.asarray(grains.hazard(np.abs(x), grains.age)) + generator.exponential(size=count)
    place, drive, clock, dt = 0.0, float(x.mean()) / spring, 0.0, step / velocity
    pinned = np.full(count, first - grains.age)  # when, or when it will be
    slips, force = [], []
    while len(force) < path.size:
        began, was = drive, spring * (drive - place)
        drive, clock = drive + step, clock + dt
        held = pinned <= clock - dt
        travel = spring * step / (spring + held.mean())
        x[held] += travel
        place += travel
        new = ~held & (pinned <= clock)
        x[new], own[new] = travel * (clock - pinned[new]) / dt, generator.exponential(size=int(new.sum()))
        holds = pinned <= clock
        limit = np.zeros(count)
        limit[holds] = thresholds(contacts, own[holds], first + clock - pinned[holds])
        gone = holds & (np.abs(x) >= limit)
        if contacts.thermal is not None:
            since = np.minimum(clock - pinned[holds], dt)
            middle, age = x[holds] - 0.5 * travel * since / dt, first + clock - 0.5 * since - pinned[holds]
            spent = rate(contacts, middle, thresholds(contacts, own[holds], age)) * since
            gone[holds] |= generator.random(int(holds.sum())) < -np.expm1(-spent)
        pinned[gone] = np.where(new[gone], pinned[gone], clock - dt * generator.random(int(gone.sum()))) + wait
        holds &= ~gone
        holds |= gone & (pinned <= clock)
        lost, stood = 0, place
        while True:
            rest = spring * (drive - place) - x[holds].sum() / count
            travel = rest / (spring + holds.mean())
            if abs(travel) < 1e-13:
                break
            x[holds] += travel
            place += travel
            gone = holds & (np.abs(x) >= limit)
            if not gone.any():
                break
            lost += int(gone.sum())
            pinned[gone], holds = clock + wait, holds & ~gone
        slipped = lost > _LARGE * count
        if slipped and rule == "reset":
            place, pinned, x, own = drive, np.full(count, clock), np.zeros(count), generator.exponential(size=count)
        if slipped:
            slips.append([drive - 0.5 * step, stood, place, was, spring * (drive - place)])
        while len(force) < path.size and path[len(force)] <= drive:
            share, at = (path[len(force)] - began) / step, spring * (drive - place)
            force.append(spring * (path[len(force)] - place) if slipped else (1.0 - share) * was + share * at)
    return np.array(slips).reshape(-1, 5).T, np.array(force)
