"""Sliders with mass on single contacts that heat breaks, with draws of their own, in small equal steps: plain numpy.

All replicas are followed side by side, by the velocity Verlet rule. In the middle of a step those contacts break that
chance takes at their rates of then, and those that reach their thresholds within the step; so all is of second order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from origins import Contacts
from origins.start import FormationLaw


class HeavyInHeat(NamedTuple):
    """A slider's spring, mass and damping, and its drive's points and their times."""

    spring: float
    mass: float
    damping: float
    path: np.ndarray
    time: np.ndarray


def stepped(
    contacts: Contacts, of: HeavyInHeat, n: int, replicas: int, steps: int, seed: int
) -> np.ndarray:
    """X, the spring's force, the share that holds, dX/dt, the contacts' force and the energy released by breaks at the
    path's points, shape (6, replicas, points)."""
    draw, law, growth = np.random.default_rng(seed), contacts.thermal.rates, contacts.strengthening
    births = FormationLaw("start", contacts.start, contacts.thresholds)
    stretch, threshold = (each.reshape(replicas, n) for each in births.draw(replicas * n, draw))
    zero, k, back = (
        -stretch,
        contacts.relative_stiffness(threshold),
        np.full((replicas, n), -np.inf),
    )
    born, grown, share = np.zeros((replicas, n)), np.ones(1), 1.0
    if growth is not None:
        born -= growth.start_pinned_for
        share = 1.0 / float(growth.factor(growth.start_pinned_for))
    threshold *= share  # of contacts that are fresh
    delay = 0.0 if contacts.delay is None else contacts.delay.time
    begin = -(k * zero).mean(1) / of.spring
    x, v, released = np.zeros((3, replicas))
    told = list[list[np.ndarray]]()
    clock, h = np.append(0.0, of.time), of.time[-1] / steps

    def pull(now: float) -> np.ndarray:
        leg = min(max(int(np.searchsorted(clock, now)), 1), of.time.size)
        before = begin if leg == 1 else of.path[leg - 2]
        share = (now - clock[leg - 1]) / (clock[leg] - clock[leg - 1])
        return of.spring * (before + share * (of.path[leg - 1] - before) - x)

    def force() -> np.ndarray:
        return np.where(back < 0.0, k * (x[:, None] - zero), 0.0).mean(1)

    for step in range(steps):
        v += 0.5 * h * (pull(step * h) - force() - of.damping * v) / of.mass
        x += 0.5 * h * v
        now = (step + 0.5) * h
        # contacts whose delay is over
        forms = (back > 0.0) & (back <= now)
        zero, back = np.where(forms, x[:, None], zero), np.where(forms, -np.inf, back)
        holds, born = back < 0.0, np.where(forms, now, born)
        if growth is not None:
            grown = growth.factor(now - born)
        y = threshold * grown
        now_x, later = x[:, None] - zero, (x + 0.5 * h * v)[:, None] - zero
        rate = np.exp(law.log_rate(np.minimum(np.abs(now_x), y), y, k))
        reached = holds & (np.abs(later) >= y)
        broken = reached | (holds & (draw.random(rate.shape) < -np.expm1(-rate * h)))
        at = np.where(reached, np.copysign(y, later), now_x)
        released += np.where(broken, 0.5 * k * at**2, 0.0).mean(1)
        zero = np.where(broken, zero + at, zero)
        born, back = (
            np.where(broken, now, born),
            np.where(broken & (delay > 0.0), now + delay, back),
        )
        threshold[broken] = share * contacts.thresholds.rvs(int(broken.sum()), draw)
        k = np.where(broken, contacts.relative_stiffness(threshold), k)
        x += 0.5 * h * v
        v += 0.5 * h * (pull((step + 1) * h) - force()) / of.mass
        v /= 1.0 + 0.5 * h * of.damping / of.mass
        if (step + 1) * h >= of.time[len(told)] * (1.0 - 1e-12):
            told.append(
                [
                    x.copy(),
                    pull((step + 1) * h),
                    (back < 0.0).mean(1),
                    v.copy(),
                    force(),
                    released.copy(),
                ]
            )
    return np.moveaxis(np.array(told), 0, 2)
