"""A slider with mass on contacts that heat breaks or whose thresholds grow, in small equal steps of time: plain numpy.

Numbers of contacts are kept for each birth and cell of thresholds; what a step breaks forms at its middle. The slider
is moved by the velocity Verlet rule, half a kick, a move, half a kick: nothing is searched for, and no balance solved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from plain_in_time import Pulled

GONE = 1e-9  # share of the contacts below which those born together are dropped


class Heavy(NamedTuple):
    """M/(N_c<k>) and γ/(N_c<k>) of the slider, and the speed of its drive, which is straight from the balance on."""

    mass: float
    damping: float
    speed: float


def swung(of: Pulled, heavy: Heavy, end: float, steps: int, cells: int) -> np.ndarray:
    """K (X_T - X), dX/dt and the contacts' force at the ends of all steps, shape (3, steps), with so many cells of
    thresholds; no delay is taken."""
    law, h, spring = of.law, end / steps, of.spring
    edges = np.linspace(0.0, law.isf(1e-12), cells + 1)
    middle, fresh = 0.5 * (edges[1:] + edges[:-1]), -np.diff(law.sf(edges))
    origin, born_at = np.array([-of.start]), np.array([-of.age])
    # the largest |x| over the growth so far, in fresh thresholds, and the contacts by birth and cell
    met = np.abs([of.start]) / of.growth(np.array([of.age]))
    held = (fresh * (1.0 - _passed(met, edges)))[None, 0] / law.sf(met)[0]
    x, v, out = 0.0, 0.0, np.empty((3, steps))
    force = float(held.sum(axis=1) @ (x - origin))
    pull = of.start

    for n in range(steps):
        now, age = n * h, (n + 0.5) * h - born_at
        v += 0.5 * h * (pull - force - heavy.damping * v) / heavy.mass
        begin, x = x - origin, x + h * v
        stretch = x - origin
        before, met = met, np.maximum(met, np.abs(stretch) / of.growth((n + 1) * h - born_at))
        kept, left = 1.0 - _passed(before, edges), 1.0 - _passed(met, edges)
        part = np.divide(left, kept, out=np.zeros(kept.shape), where=kept > 0.0)
        if of.thermal is not None:
            halfway = np.abs(0.5 * (begin + stretch))[:, None]
            threshold = np.maximum(middle * of.growth(age)[:, None], halfway)
            part = part * np.exp(-h * of.thermal.rates.rate(halfway, threshold, 1.0))
        total = held.sum()
        held = held * part
        born = total - held.sum()
        held = np.vstack([held, born * fresh])
        origin, born_at = np.append(origin, x - 0.5 * h * v), np.append(born_at, now + 0.5 * h)
        met = np.append(met, np.abs(0.5 * h * v))
        force = float(held.sum(axis=1) @ (x - origin))
        pull = spring * (of.start / spring + heavy.speed * (now + h) - x)
        v += 0.5 * h * (pull - force) / heavy.mass
        v /= 1.0 + 0.5 * h * heavy.damping / heavy.mass
        out[:, n] = pull, v, force
        stays = held.sum(axis=1) > GONE * h
        held, origin, born_at, met = held[stays], origin[stays], born_at[stays], met[stays]
        held /= held.sum()
    return out


def _passed(met: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Which part of each cell lies below these fresh thresholds (n,), shape (n, cells)."""
    return np.clip((met[:, None] - edges[:-1]) / np.diff(edges), 0.0, 1.0)
