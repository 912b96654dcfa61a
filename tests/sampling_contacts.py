"""Discrete contacts under steady forward motion, drawn one by one and exactly: no time step, no shared code with
master."""

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.births import Births
from origins.start import as_start

Array = npt.NDArray[np.float64]


def sample(
    contacts: Contacts, path: Array, velocity: float, count: int, seed: int = 1
) -> tuple[Array, Array, Array]:
    """Mean force per contact at each X, its standard error (with that of what happens to fewer than one), holding."""
    generator = np.random.default_rng(seed)
    delay = 0.0 if contacts.delay is None else velocity * contacts.delay.time
    again = contacts.reforming or Births("reforming", as_start(None), contacts.thresholds)
    stretch, threshold = Births("start", contacts.start, contacts.thresholds).draw(count, generator)
    force, holding = np.zeros((path.size, count)), np.zeros((path.size, count), dtype=bool)
    alive, born = np.arange(count), np.zeros(count)
    while alive.size:
        stiffness = contacts.relative_stiffness(threshold)
        at = threshold
        if contacts.thermal is not None:
            amount = velocity * generator.exponential(size=alive.size)
            at = contacts.thermal.inverse(amount, threshold, stretch, stiffness)
        broken = born + np.maximum(at - stretch, 0.0)
        for row, x in enumerate(path):
            on = (born <= x) & (x < broken)
            force[row, alive[on]] += (stiffness * np.ones(alive.size) * (stretch + x - born))[on]
            holding[row, alive[on]] = True
        born = broken + delay
        left = born < path[-1]
        alive, born = alive[left], born[left]
        stretch, threshold = again.draw(alive.size, generator)
    lone = np.minimum(path, contacts.mean_threshold) / count
    return force.mean(axis=1), force.std(axis=1) / np.sqrt(count) + lone, holding.mean(axis=1)
