"""Discrete contacts on any path in time, drawn one by one and exactly: no time step, no shared code with master."""

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.births import Births
from origins.start import as_start

Array = npt.NDArray[np.float64]


def move(contacts: Contacts, path: Array, time: Array, count: int, seed: int = 1) -> tuple[Array, Array, Array]:
    """Mean force per contact at each point, its standard error, and what holds."""
    generator = np.random.default_rng(seed)
    again = contacts.reforming or Births("reforming", as_start(None), contacts.thresholds)
    stretch, threshold = Births("start", contacts.start, contacts.thresholds).draw(count, generator)
    wait = 0.0 if contacts.delay is None else contacts.delay.time
    # when each contact moves on from where it stands: those that wait do so later than now
    clock = np.zeros(count)
    rows = []
    now, at = 0.0, 0.0
    for end, goal in zip(time, path, strict=True):
        speed = (goal - at) / (end - now) if end > now else 0.0
        busy = np.flatnonzero(clock < end)
        while busy.size:
            left = end - clock[busy]
            lasts = _lasts(contacts, stretch[busy], threshold[busy], speed, generator)
            over = lasts < left
            stay, broken = busy[~over], busy[over]
            stretch[stay] += speed * left[~over]
            clock[stay] = end
            clock[broken] += lasts[over] + wait
            stretch[broken], threshold[broken] = again.draw(broken.size, generator)
            busy = broken[clock[broken] < end]
        holds = clock <= end
        force = np.where(holds, contacts.relative_stiffness(threshold) * stretch, 0.0)
        rows.append((force.mean(), force.std() / np.sqrt(count), holds.mean()))
        now, at = float(end), float(goal)
    force, error, holding = np.array(rows).T
    return force, error + contacts.mean_threshold / count, holding


def _lasts(contacts: Contacts, stretch: Array, threshold: Array, speed: float, generator: np.random.Generator) -> Array:
    """How long each holds on, from now on, if the slider keeps its speed; the exponential law has no memory."""
    size = stretch.size
    if speed == 0.0:
        if contacts.thermal is None:
            return np.full(size, np.inf)
        rate = contacts.thermal.rate(stretch, threshold, contacts.relative_stiffness(threshold))
        with np.errstate(divide="ignore", over="ignore"):  # those that never break
            return generator.exponential(size=size) / rate
    x = stretch * np.sign(speed)
    far = threshold
    if contacts.thermal is not None:
        amount = abs(speed) * generator.exponential(size=size)
        far = contacts.thermal.inverse(amount, threshold, x, contacts.relative_stiffness(threshold))
    return np.maximum(far - x, 0.0) / abs(speed)
