"""Reading: force, holding share and stretches at any moment, from the solved panels of a march."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.edges import CLOSE
from master.renewal.march import March

Array = npt.NDArray[np.float64]


def _felt(march: March, t: Array) -> Array:
    """Times t, those after breaks became steady replaced by the time when they did.

    Nothing changes from then on, while times and numbers of breaks lose digits far along the path.
    """
    return np.minimum(t, march.settled) if march.motion.one_leg else t


def force(march: March, t: Array) -> Array:
    """Force at times t, shape (n,) (paper, Eq. Q6); where it jumps, after the jump."""
    t = _felt(march, t)
    return _read(march, np.array(march.force), t)


def holding(march: March, t: Array) -> Array:
    """Share of the contacts that hold at times t: all but those that broke within the last delay."""
    delay, t = march.births.delay, _felt(march, t)
    if not delay > 0.0:
        return np.ones(t.size)
    return 1.0 - broken(march, t) + broken(march, t - delay)


def broken(march: March, t: Array) -> Array:
    """Breaks per contact up to times t, those of lumps included; 0 before t = 0."""
    breaks = np.array(march.breaks)
    before = np.append(0.0, np.cumsum(breaks[:-1, -1]))
    out = _read(march, before[:, None] + breaks, np.maximum(t, 0.0))
    for lump in march.lumps[1:]:
        out = out + lump.weight * (t >= lump.time - march.births.delay)
    return np.where(t < 0.0, 0.0, out)


def _read(march: March, values: Array, t: Array) -> Array:
    begin, width = np.array(march.begin), np.array(march.width)
    near = begin * (1.0 - CLOSE) - CLOSE * width.min()
    panel = np.clip(np.searchsorted(near, t, "right") - 1, 0, begin.size - 1)
    share = np.clip((t - begin[panel]) / width[panel], 0.0, 1.0)
    return np.asarray(np.einsum("ij,ij->i", rule.values(share), values[panel]))


def density(march: March, t: float, x: Array) -> Array:
    """Density of stretches x, shape (n,), at the time t; re-forming at one stretch r.

    A contact born at s has the stretch x = r + X(t) - X(s), so that births at the rate dJ/ds (that of
    the breaks one delay before) contribute the density E(t, s) (dJ/ds) / |dX/ds| at x.
    """
    motion, life, law, delay = march.motion, march.life, march.births.law, march.births.delay
    t = float(_felt(march, np.array(t)))
    now, start = float(motion.at(np.array(t))), march.lumps[0].law
    at, out = np.full((1, 1), t), np.zeros(x.size)
    if not start.is_single:
        origin, (low, high) = x - now, start.span
        inside = np.flatnonzero((np.abs(origin) < life.reach) & (origin > low) & (origin < high))
        history = motion.history(at, np.zeros((inside.size, 1)))
        held = life.left(origin[inside, None], history)[0, :, 0]
        out[inside] = start.pdf(origin[inside]) * held
    begin, width = np.array(march.begin), np.array(march.width)
    slopes = np.array(march.breaks) @ rule.SLOPES.T
    for leg in np.flatnonzero(motion.speeds):
        first, last = max(motion.times[leg], delay), min(motion.times[leg + 1], t)
        speed = float(motion.speeds[leg])
        s = motion.times[leg] + (law.mean() + now - x - motion.positions[leg]) / speed
        here = np.flatnonzero((s > first) & (s <= last))
        panel = np.maximum(np.searchsorted(begin, s[here] - delay) - 1, 0)
        share = np.minimum((s[here] - delay - begin[panel]) / width[panel], 1.0)
        rate = rule.legendre_sum(slopes[panel], 2.0 * share[:, None] - 1.0)[:, 0] / width[panel]
        held = life.left(law, motion.history(at, s[here, None]))[0, :, 0]
        out[here] += held * rate / abs(speed)
    return out


def deltas(march: March, t: float) -> dict[float, float]:
    """Stretches (lengths) that a finite share of the contacts has at the time t, and these shares.

    They are those of lumps, and of births in holds: contacts born in one hold share one stretch.
    """
    t, motion, law = float(_felt(march, np.array(t))), march.motion, march.births.law
    at, found = np.full((1, 1), t), dict[float, float]()
    for lump in march.lumps:
        if lump.time <= t and lump.law.is_single:
            history = motion.history(at, np.full((1, 1), lump.time))
            stretch = float(lump.law.mean() + history.now[0, 0])
            held = float(march.life.left(lump.law, history)[0, 0, 0])
            found[stretch] = found.get(stretch, 0.0) + lump.weight * held
    for leg in np.flatnonzero((motion.speeds == 0.0) & (motion.times[:-1] < t)):
        stretch = float(law.mean() + motion.at(np.array(t)) - motion.positions[leg])
        found[stretch] = found.get(stretch, 0.0) + march.held(int(leg), t)
    return {stretch: share for stretch, share in found.items() if share > 1e-18}
