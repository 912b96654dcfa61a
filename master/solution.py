"""What `solve` returns for a rigid slider, and Q(x;X) read from it."""

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from master.motion import Motion
from master.numerics import polynomials
from master.renewal.march import March
from master.renewal.past import Past
from origins import InputError
from origins.brief import brief
from origins.errors import finite, refuse
from origins.thresholds.law import Array


@dataclass(frozen=True)
class StretchDistribution:
    """Density of stretches at one instant, and the delta functions beside it.

    delta_positions, delta_weights : stretches (lengths) of finite shares of the contacts, and these shares, shape (n,).
    """

    delta_positions: Array
    delta_weights: Array
    _march: March = field(repr=False)
    _time: float = field(repr=False)

    def density(self, x: npt.ArrayLike) -> Array:
        """Q(x;X) per length at stretches x (lengths), without the deltas; same shape as x.

        A contact born at s, at the stretch r, has the stretch x = r + X(t) - X(s), so that births at the rate b(s)
        (that of the breaks one delay before) contribute the density E(t, s) b(s) / |dX/ds| at x.
        """
        shape, x = np.shape(x), np.ravel(np.asarray(x, dtype=float))
        density = self._of_start(x)
        for leg in np.flatnonzero(self._march.motion.speeds).tolist():
            density += self._born_on(leg, x)
        return density.reshape(shape)[()]

    def _of_start(self, x: Array) -> Array:
        """Of contacts that have held since t = 0, when they had the stretches x - X(t), shape (n,)."""
        march, density = self._march, np.zeros(x.size)
        motion, life, start = march.motion, march.life, march.lumps[0].law
        if start.is_single:
            return density
        now, (low, high) = np.full((1, 1), self._time), start.span
        origin = x - motion.at(now)[0, 0]
        # beyond the span the survival is not known
        within = (origin > low) & (origin < high) & (np.abs(origin) < life.largest_stretch)
        here = np.flatnonzero(within)
        history = motion.history(now, np.zeros((here.size, 1)))
        survival = life.survival_and_force(origin[here, None], history).survival[:, 0]
        density[here] = start.pdf(origin[here]) * survival
        return density

    def _born_on(self, leg: int, x: Array) -> Array:
        """Of contacts born on a leg on which the slider moves, at stretches x, shape (n,)."""
        march, density = self._march, np.zeros(x.size)
        motion, solved = march.motion, march.solved
        law, delay = march.births.law, march.births.delay
        now, speed = np.full((1, 1), self._time), float(motion.speeds[leg])
        first, last = max(motion.times[leg], delay), min(motion.times[leg + 1], self._time)
        # X(s) = X(t) + r - x
        place = law.mean() + motion.at(now)[0, 0] - x
        s = motion.times[leg] + (place - motion.positions[leg]) / speed
        here = np.flatnonzero((s > first) & (s <= last))
        broken_at = s[here] - delay
        panel = np.maximum(np.searchsorted(solved.begin, broken_at) - 1, 0)
        on_panel = np.minimum((broken_at - solved.begin[panel]) / solved.width[panel], 1.0)
        slopes = solved.breaks[panel] @ polynomials.SLOPES.T / solved.width[panel, None]
        rate = polynomials.legendre_sum(slopes, 2.0 * on_panel[:, None] - 1.0)[:, 0]
        survival = march.life.survival_and_force(law, motion.history(now, s[here, None])).survival
        density[here] = survival[:, 0] * rate / abs(speed)
        return density


@dataclass(frozen=True)
class Solution:
    """F along the path of a rigid slider, with an estimate of its error.

    path : slider positions X, shape (n,), lengths; time : when they are reached, shape (n,).
    force : F/(N_c <k>), the mean of k_i x_i/<k> over all contacts, also those that are out, shape (n,), a length.
    force_error : estimate from above of its largest error over the path, in units of the mean threshold.
    holding : fraction of contacts that hold, shape (n,): 1 without delay and growing grains.
    run_time : s; nodes : number of instants at which number conservation was solved.
    success : whether force_error is at or below the requested tolerance.
    message : the accuracy reached, or why it was missed; any weight cut off the start or the thresholds.
    """

    path: Array
    force: Array
    time: Array
    force_error: float
    holding: Array
    run_time: float
    nodes: int
    success: bool
    message: str
    _march: March = field(repr=False)
    _by_index: bool = field(repr=False)
    _arrivals: Array = field(repr=False)

    __repr__ = brief

    def distribution(self, where: float, leg: int | None = None) -> StretchDistribution:
        """Q(x;X) at one point of the path.

        where : X (a length), between 0 and the path's end; the index of a point of the path where
            X alone does not fix the instant: with `time`, or where contacts with laws turn round
        leg : which straight leg of a path that turns round, counted from 0; may be omitted where
            the path passes X only once

        No error is given with Q: that of the survivals is dropped here, and force_error is one of F alone.

        Raises InputError where the path does not pass X; for contacts that re-form at many stretches; and, along
        paths of several legs, for contacts that age or whose thresholds grow: Q is not computed there.
        """
        march = self._march
        if march.life.no_density and not march.motion.one_leg:
            raise InputError(march.life.no_density)
        if not march.births.law.is_single:
            raise InputError("contacts.reforming: Q(x;X) is not known with many stretches")
        if self._by_index and leg is not None:
            refuse("leg", leg, "is that of a position X; here `where` is the index of a point")
        time = self._point(where) if self._by_index else self._passing(march.motion, where, leg)
        time = min(time, march.steady_since)
        found = _deltas(march, time)
        return StretchDistribution(np.array(list(found)), np.array([*found.values()]), march, time)

    def _point(self, point: float) -> float:
        """Time at which the path reaches the point with this index."""
        whole = isinstance(point, int | np.integer) and not isinstance(point, bool)
        if not whole or not 0 <= point < self.path.size:
            refuse("where", point, f"must be the index of a point, from 0 to {self.path.size - 1}")
        return float(self._arrivals[int(point)])

    def _passing(self, motion: Motion, position: float, leg: int | None) -> float:
        """Time at which the slider passes X = position, on the given leg if there are several."""
        position = finite("where", position)
        slack = 1e-12 * (1.0 + np.abs(motion.positions).max())  # positions are rounded
        low, high = np.sort([motion.positions[:-1], motion.positions[1:]], axis=0)
        legs = np.flatnonzero((low - slack <= position) & (position <= high + slack))
        if leg is not None:
            legs = legs[legs == leg]
        if not legs.size:
            fault = f"the path, between {low.min():g} and {high.max():g}, does not come there"
            if leg is not None:
                refuse("leg", leg, f"{fault}; {motion.speeds.size} legs are counted from 0")
            refuse("where", position, fault)
        # a hold is passed as it begins
        distances, speeds = position - motion.positions[legs], motion.speeds[legs]
        lasting = np.divide(distances, speeds, out=np.zeros(legs.size), where=speeds != 0.0)
        times = np.clip(motion.times[legs] + lasting, motion.times[legs], motion.times[legs + 1])
        # a turning point ends one leg and begins the next
        apart = legs[np.append(True, np.diff(times) > 0.0)]
        if apart.size > 1:
            several = ", ".join(map(str, apart))
            refuse("where", position, f"is passed on legs {several}; choose, as in leg={legs[0]}")
        return float(times[0])


def _deltas(march: March, t: float) -> dict[float, float]:
    """Stretches (lengths) that finite shares of the contacts have at the time t, those of lumps and of births in one
    hold each, and these shares."""
    motion, law = march.motion, march.births.law
    at, found = np.full((1, 1), t), dict[float, float]()
    for lump in march.lumps:
        if lump.birth <= t and lump.law.is_single:
            history = motion.history(at, np.full((1, 1), lump.birth))
            stretch = float(lump.law.mean() + history.now[0, 0])
            survival = float(march.life.survival_and_force(lump.law, history).survival[0, 0])
            found[stretch] = found.get(stretch, 0.0) + lump.weight * survival
    for leg in np.flatnonzero((motion.speeds == 0.0) & (motion.times[:-1] < t)):
        stretch = float(law.mean() + motion.at(np.array(t)) - motion.positions[leg])
        found[stretch] = found.get(stretch, 0.0) + _holding_of_leg(march, int(leg), t)
    return {stretch: weight for stretch, weight in found.items() if weight > 1e-18}


def _holding_of_leg(march: March, leg: int, t: float) -> float:
    """Share of all contacts that were born on a leg and hold at the time t."""
    solved, motion = march.solved, march.motion
    panels = solved.pick(slice(int(np.searchsorted(solved.begin, t))))
    legs, now = motion.leg(panels.middle_of_births(march.births.delay)), int(motion.leg(t))
    panels = replace(panels, breaks=panels.breaks * (legs == leg)[:, None])
    past, x = Past(replace(march.births, until=np.inf)), np.array([[t - motion.times[now]]])
    past.enter(now, panels)
    earlier = past.at(now, x, [])
    own = march.births_on_leg(x[0], now, panels.pick(slice(past.first_panel, None)))
    return float(earlier[0, 0, 0] + own[0, 0])
