"""Contacts that break by heat, one by one, under a slider that a spring pulls: the plain model in small steps."""

from typing import NamedTuple

import numpy as np

from origins import Contacts

LARGE = 0.05  # of all contacts, which an avalanche at a standing drive breaks: a slip


class Pulled(NamedTuple):
    """Where the drive stands at the first slip, the force after it, and the forces that were asked for."""

    first: float
    force_after: float
    force: np.ndarray


def pull(
    contacts: Contacts, path: np.ndarray, velocity: float, spring: float, count: int, seed: int
) -> Pulled:
    """Force at drive positions `path`, in 300 steps of the drive; broken contacts are back at once.

    Within a step the drive moves on, and contacts break at their own rates or where their
    thresholds meet them; then the slider follows with the drive standing until nothing more breaks.
    """
    generator = np.random.default_rng(seed)
    step = path[-1] / 300
    x, limit = np.zeros(count), contacts.thresholds.isf(1.0 - generator.random(count))
    place, slips, loads, drives = 0.0, list[tuple[float, float]](), [0.0], [0.0]

    def renewed(broken: np.ndarray, stretch: np.ndarray) -> None:
        x[broken] = stretch
        limit[broken] = contacts.thresholds.isf(1.0 - generator.random(broken.sum()))

    for drive in step * np.arange(1, 301):
        travel = spring * step / (spring + 1.0)
        middle = np.minimum(np.abs(x + 0.5 * travel), limit)
        spent = step / velocity * contacts.thermal.rate(middle, limit)
        x += travel
        place += travel
        broken = (np.abs(x) >= limit) | (generator.random(count) < -np.expm1(-spent))
        renewed(broken, travel * generator.random(broken.sum()))
        lost = 0
        while abs(travel := (spring * (drive - place) - x.mean()) / (spring + 1.0)) > 1e-13:
            x += travel
            place += travel
            broken = np.abs(x) >= limit
            # the rest of the way they are there again
            renewed(broken, (x - limit)[broken])
            lost += broken.sum()
            if not broken.any():
                break
        loads.append(spring * (drive - place))
        drives.append(drive)
        if lost > LARGE * count:
            slips.append((drive - 0.5 * step, loads[-1]))
    return Pulled(*slips[0], np.interp(path, drives, loads))
