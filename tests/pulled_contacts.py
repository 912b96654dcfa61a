"""Contacts one by one under a slider that a spring pulls, in small steps of the drive: the plain model."""

from dataclasses import dataclass

import numpy as np

from origins import Contacts
from origins.drive import SlipRule

LARGE = 0.05  # of all contacts, which an avalanche at a standing drive breaks: a slip


@dataclass
class Pulled:
    """Drive, slider and force before and after each slip, shape (5, m), and the force where it was asked for."""

    slips: np.ndarray
    force: np.ndarray


def pull(
    contacts: Contacts,
    path: np.ndarray,
    velocity: float,
    spring: float,
    rule: SlipRule,
    step: float,
    count: int,
    seed: int,
) -> Pulled:
    """Force at drive positions `path`; `step` is that of the drive, lengths.

    Within a step the drive moves on, contacts break at their own rates or where their thresholds meet them, by the
    Brownian bridge where those diffuse; then the slider follows with the drive standing until nothing more breaks.
    """
    generator = np.random.default_rng(seed)
    fresh, thermal, ageing = contacts.thresholds, contacts.thermal, contacts.ageing
    wait = 0.0 if contacts.delay is None else contacts.delay.time

    def thresholds(above: np.ndarray) -> np.ndarray:
        return np.asarray(fresh.isf(fresh.sf(np.abs(above)) * (1.0 - generator.random(above.size))))

    start = contacts.start
    x = (
        np.full(count, start.mean())
        if start.is_single
        else np.asarray(start.ppf(generator.random(count)))
    )
    limit, back = thresholds(x), np.full(count, -1.0)  # when a broken one is there again
    place, drive, dt = 0.0, float(x.mean()) / spring, step / velocity
    clock = 0.0
    slips: list[list[float]] = []
    force = np.zeros(path.size)
    known = 0
    while known < path.size:
        began, before = drive, place
        drive, clock = drive + step, clock + dt
        out = back > clock - dt
        held = ~out
        was = spring * (began - before)
        travel = spring * step / (spring + held.mean())
        old, moved = x[held], x[held] + travel
        new = limit[held]
        broken = np.zeros(old.size, dtype=bool)
        if ageing is not None:
            after = ageing.normal.draw(new, dt, generator.standard_normal(old.size))
            gaps = np.maximum((new - np.abs(old)) * (after - np.abs(moved)), 0.0)
            broken = generator.random(old.size) < np.exp(-gaps / (ageing.rate * dt))
            new = after
        broken |= np.abs(moved) >= new
        if thermal is not None:
            middle = np.minimum(np.abs(0.5 * (old + moved)), new)
            broken |= generator.random(old.size) < -np.expm1(-dt * thermal.rate(middle, new))
        x[held], limit[held] = moved, new
        place += travel
        gone = np.flatnonzero(held)[broken]
        returned = np.flatnonzero(out & (back <= clock))
        x[returned] = travel * (clock - back[returned]) / dt
        limit[returned] = thresholds(np.zeros(returned.size))
        if wait:
            back[gone] = clock - dt * generator.random(gone.size) + wait
        else:
            x[gone] = travel * generator.random(gone.size)
            limit[gone] = thresholds(np.zeros(gone.size))
        out = back > clock
        # the drive stands, the slider follows what broke
        lost, stood = 0, place
        aside = np.zeros(count, dtype=bool)
        late = wait > 0.0 or rule == "reform-after"
        while True:
            held = ~out & ~aside
            rest = spring * (drive - place) - x[held].sum() / count
            travel = rest / (spring + held.mean())
            if abs(travel) < 1e-13:
                break
            x[held] += travel
            place += travel
            gone = np.flatnonzero(held & (np.abs(x) >= limit))
            if not gone.size:
                break
            lost += gone.size
            if late:
                aside[gone] = True
            else:
                # the rest of the way they are there again
                x[gone], limit[gone] = x[gone] - limit[gone], thresholds(np.zeros(gone.size))
        slipped = lost > LARGE * count
        if slipped and rule == "reset":
            place, back[:] = drive, -1.0
            x, aside[:] = np.zeros(count), False
            limit = thresholds(x)
        if wait:
            back[aside] = clock + wait
        else:
            x[aside], limit[aside] = 0.0, thresholds(np.zeros(int(aside.sum())))
        if slipped:
            slips.append([drive - 0.5 * step, stood, place, was, spring * (drive - place)])
        while known < path.size and path[known] <= drive:
            share = (path[known] - began) / step
            now = spring * (drive - place)
            force[known] = (
                spring * (path[known] - place) if slipped else (1.0 - share) * was + share * now
            )
            known += 1
    return Pulled(np.array(slips).reshape(-1, 5).T, force)
