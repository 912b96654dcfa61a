"""First passage: survival of contacts whose thresholds age towards a normal law, on any motion.

A contact is born at t = 0 with a fresh threshold. It breaks where its |stretch|, the level, first meets its threshold.
If thresholds went on ageing when they are met, all that are below the level at t would have been met at some instant
before: with b the breaks per unit of time,

    P(below at t | fresh) = integral_0^t b(τ) P(below at t | met at τ) dτ,       E(t) = 1 - integral_0^t b dτ.

That is number conservation again, and both probabilities are known in closed form, as free thresholds are an
Ornstein-Uhlenbeck process. It is solved panel by panel. A segment of the motion ends where the speed of the level
changes; with ρ the root of the time since the segment began, 2 ρ b is smooth in ρ, and a Legendre series on each panel.
(With shares above the level E stands on the right, too; where the level recedes all terms are near 1, and b is lost.)
"""

from copy import copy
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.special import ndtr

from master.motion import middle_of
from master.numerics import polynomials
from master.numerics.averages import Integrals, integrals_above
from master.numerics.polynomials import Rows
from master.survival.life import MARGIN
from origins import Ageing, Thresholds
from origins.errors import InputError, refuse
from origins.thresholds.law import Array
from origins.thresholds.quadrature import finite_density, panel_edges

# Nodes and weights on (0, 1) of the integral over fresh thresholds.
_INNER, _INNER_WEIGHTS = polynomials.gauss(12).nodes, polynomials.gauss(12).series[:, 0]
# Share of the contacts below which none is taken to hold: rounding of a survival. And below which a panel's breaks are
# left out: some hundred of them are not seen beside that.
_NOTHING, _FEWEST = 1e-14, 1e-18
# Most relaxations of thresholds while the slider moves by one length: panels are a tenth of one at first.
_MOST_RELAXED = 1e10
# Least diffusion, in mean fresh thresholds times the speed: less moves no threshold by its rounding.
_LEAST_DIFFUSION = 1e-28
# Standard deviations of the final law beyond the furthest threshold within which all of them stay: normal tails.
_ALL_WITHIN = 12.0
# e^-LOG_MET of the thresholds are met after so long that a level which recedes at the speed u has outrun the others: a
# threshold spreads by (4 D t)^(1/2), the level goes u t, and e^-(u t)²/4Dt is e^-40 at t = 160 D/u².
_LOG_MET = 40.0
# Part of the shortest time in which a survival changes that the root of the first panel's end is.
_FIRST_PART = 0.1
# A panel whose last coefficients hardly fell since it was halved, and are below _ROUNDED, resolves rounding only.
_HARDLY, _ROUNDED = 0.3, 1e-9
# Factor on the width of the next panel after a good one, and after one on which hardly any contact breaks.
_WIDER, _FAR_WIDER, _HARDLY_ANY = 2.0, 16.0, 1e-3
# Relative rounding of an age, a sum of durations.
_ROUNDED_AGE = 1e-12
# A smooth law takes some 50 panels.
_MOST_PANELS = 4000


class _Segment(NamedTuple):
    """A part of the motion in which the stretch keeps its sign: time since the birth and level at its beginning, speed
    of the level, and the root of the duration."""

    begin: float
    level: float
    slope: float
    root: float


class _Panel(NamedTuple):
    """Legendre coefficients of 2 ρ b between `low` and low + width, ρ being the root of the time since this segment
    began, and the shares that hold at `low` and that break. A part beyond the segment's end does not count."""

    segment: int
    low: float
    width: float
    holds: float
    breaks: float
    series: Array


class Passage:
    """Survival of contacts born together whose thresholds age towards a Gaussian final law.

    fresh : law of thresholds at birth, of which those above |start| hold; exact values allowed
    ageing : with an uncut Gaussian final law (`normal` is not None)
    fastest : largest speed of `move`, a length per time
    start : stretch at the birth (a length)
    accuracy : largest error of the survival from one panel
    age, stretch, left : time since the birth, stretch and share that holds now
    error : estimate of the largest error of the survival

    Raises InputError where no threshold lies above |start|, thresholds relax too often, or `move` takes 4,000 panels.
    """

    def __init__(
        self, fresh: Thresholds, ageing: Ageing, fastest: float, start: float, accuracy: float
    ) -> None:
        """Begin at the birth; InputError for a start beyond every threshold."""
        normal = ageing.normal
        assert normal is not None
        least = abs(start)
        if not float(fresh.sf(least)) > 0.0:
            refuse("start", start, "lies beyond every threshold; contacts there hold nothing")
        # less ageing has no effect in floating point
        self._diffusion = max(ageing.rate, _LEAST_DIFFUSION * fresh.mean() * fastest)
        self._mean, self._std, self._pull = normal.mean, normal.std, self._diffusion / normal.std**2
        if self._pull * normal.mean > _MOST_RELAXED * fastest > 0.0:
            hint = f"relaxes thresholds 1e10 times while the slider moves by one at the speed {fastest:g}"
            refuse("rate", ageing.rate, f"{hint}, too often to follow; slide faster")
        self.age, self.stretch, self.surviving = 0.0, start, 1.0
        self.error = self._tails = self._missed = 0.0
        # the fresh thresholds of contacts that hold at first: exact values, and edges of the others
        self._fresh, self._fresh_survival, above = (
            fresh,
            float(fresh.sf(least)),
            fresh.atoms[0] > least,
        )
        self._values, self._weights = (part[above] for part in fresh.atoms)
        self._pieces = np.unique(np.maximum(np.append(panel_edges(fresh), least), least))
        # fresh thresholds above the rounding of 1, and as far as the final law spreads any
        self._furthest = max(float(fresh.isf(1e-16)), normal.mean) + _ALL_WITHIN * normal.std
        # of the last coefficients of integrals over earlier breaks, whose errors are far smaller
        self._resolved = min(100.0 * accuracy, 1e-8)
        self._accuracy, self._segments, self._panels = accuracy, list[_Segment](), list[_Panel]()

    def move(self, speed: float, duration: float) -> None:
        """Go on at the speed dX/dt for a time."""
        turn = -self.stretch / speed if speed * self.stretch < 0.0 else np.inf
        if turn < duration:
            self.move(speed, turn)
            self.stretch, duration = 0.0, duration - turn
        if duration > 0.0:
            slope = float(np.sign(self.stretch)) * speed if self.stretch else abs(speed)
            self._segments.append(_Segment(self.age, abs(self.stretch), slope, duration**0.5))
            self._march(self._segments[-1])
            self.age += duration
            self.stretch += speed * duration

    def survival(self, age: Array) -> Array:
        """E at these ages, same shape; 0 beyond now."""
        begins = [self._segments[panel.segment].begin for panel in self._panels]
        begin, (low, width, holds) = np.array(begins), np.array([p[1:4] for p in self._panels]).T
        panel = np.maximum(np.searchsorted(begin + low * low, age, "right") - 1, 0)
        rho = np.sqrt(np.maximum(age - begin[panel], 0.0))
        broken = legendre.legint(np.array([each.series for each in self._panels]).T, lbnd=-1.0)
        z = np.minimum(2.0 * (rho - low[panel]) / width[panel] - 1.0, 1.0)
        now = holds[panel] - 0.5 * width[panel] * legendre.legval(z, broken[:, panel], tensor=False)
        followed = age <= self.age * (1.0 + _ROUNDED_AGE)
        return np.minimum(now, 1.0) * ((now > _NOTHING) & followed)

    def at(self, age: float, stretch: float) -> "Passage":
        """These contacts at an earlier age, when they had this stretch."""
        out, out.age, out.stretch = copy(self), age, stretch
        out.surviving = float(self.survival(np.array([age]))[0])
        kept = [each for each in self._segments if each.begin <= age]
        ends = [min(each.root, float(np.sqrt(age - each.begin))) for each in kept]
        out._segments = [each._replace(root=end) for each, end in zip(kept, ends, strict=True)]
        out._panels = [p for p in self._panels if p.segment < len(kept) and p.low < ends[p.segment]]
        return out

    def _march(self, here: _Segment) -> None:
        """Add the panels of the last segment, until hardly any contact holds."""
        speed, last = abs(here.slope), here.root
        # the speed at which the level recedes from all thresholds; see _LOG_MET
        recedes = -here.slope - self._pull * max(self._furthest - self._mean, 0.0)
        if recedes > 0.0:
            last = min(last, float(np.sqrt(4.0 * _LOG_MET * self._diffusion)) / recedes)
        # over the length D/v diffusion is as fast as the slider; a tenth of the final width resolves that law
        least = min(self._diffusion / speed, 0.1 * self._std) / speed if speed else np.inf
        first = _FIRST_PART * float(np.sqrt(min(1.0 / self._pull, least)))
        few = bool(self._panels) and abs(self._panels[-1].breaks) < self._accuracy  # near the level
        width, low, before = max(first, 0.25 * last) if few else first, 0.0, np.inf
        while last - low > 1e-12 * last and self.surviving > _NOTHING:  # less is rounding
            step = min(width, last - low)
            series = self._panel(low, step)
            # the last coefficients, in the integral of the density
            early, tail = (
                np.abs(series[-k:]).max() * step / (2.0 * polynomials.DEGREE) for k in (6, 2)
            )
            rounded = _HARDLY * before < tail < _ROUNDED
            # no change is faster than that for which the first panel was made: it is halved twice at most
            if tail > self._accuracy and not rounded and step > 0.3 * first:
                width, before = 0.5 * step, tail
                continue
            breaks = float(series[0]) * step  # the first coefficient is the mean
            panel = _Panel(len(self._segments) - 1, low, step, self.surviving, breaks, series)
            self._panels.append(panel)
            low, self.surviving = low + step, self.surviving - breaks
            self._tails += float(tail)
            self.error = self._tails + self._missed
            wider = _FAR_WIDER if breaks < _HARDLY_ANY * self._accuracy else _WIDER
            width, before = step * (wider if early < self._accuracy or rounded else 1.0), np.inf
            if len(self._panels) > _MOST_PANELS:
                raise InputError("ageing: needs 4000 panels; use smoother fresh thresholds")

    def _panel(self, low: float, width: float) -> Array:
        """Legendre coefficients of 2 ρ b on a panel of the last segment, from the shares below at its nodes."""
        here, rho = self._segments[-1], low + width * polynomials.NODES
        level = here.level + here.slope * rho * rho
        below = self._below_from_fresh(here.begin + rho * rho, level)
        new = _Panel(len(self._segments) - 1, low, width, 0.0, 0.0, np.zeros(polynomials.DEGREE))
        felt = [panel for panel in self._panels if abs(panel.breaks) > _FEWEST]
        own, earlier = self._met([new], rho, level, True), self._met([*felt, new], rho, level)
        try:
            series = np.linalg.solve(own.value.T, below - earlier.value[0])
        except np.linalg.LinAlgError:  # thresholds that all lie far from the stretch, or on it
            hint = "fresh and final thresholds lie too far apart for their widths to be followed in master"
            raise InputError(
                f"ageing: {hint}; the ensemble, eq_model.simulate, takes them"
            ) from None
        missed = earlier.missed[0] + np.abs(series) @ own.missed
        self._missed = max(self._missed, MARGIN * float(missed.max()))
        return np.asarray(series, dtype=float)

    def _met(self, panels: list[_Panel], rho: Array, level: Array, each: bool = False) -> Integrals:
        """The share below the level now, at rho (n,) on the last segment, of what broke on some panels, one function of
        n ranges; `each`: if 2 ρ b were each of the Legendre polynomials of the first panel, DEGREE functions.

        Integrated over y = -c: c is ρ on the last segment, and on those before ρ less the roots of all later durations.
        Near now, the lower end of y, `below` is a series in the root of the distance from there.
        """
        of_segments = np.array(self._segments).T  # by the fields of _Segment
        begin, start = of_segments[:2]  # time and level at each one's beginning
        slope, root = of_segments[2:]  # of the level, and of the duration
        first = np.append(-np.cumsum(root[-2::-1])[::-1], 0.0)  # c where each segment begins
        segment, low, width = (np.array(part) for part in list(zip(*panels, strict=True))[:3])
        high = first[segment] + np.minimum(low + width, root[segment])
        low, series = first[segment] + low, np.array([panel.series for panel in panels])

        def met(row: Rows, y: Array) -> Array:
            panel = np.searchsorted(low, -middle_of(y)[:, 0], "right") - 1
            k, z = segment[panel, None], -2.0 * (y + low[panel, None]) / width[panel, None] - 1.0
            now, then = rho[row, None], (y + first[k]) ** 2  # root of a time on the segment, a time
            own = k == root.size - 1
            before = np.where(own, (now + y) * (now - y), now**2 + begin[-1] - begin[k] - then)
            rise = np.where(own, slope[-1] * before, level[row, None] - start[k] - slope[k] * then)
            below = self._below(level[row, None], rise, before)
            if each:
                return np.moveaxis(legendre.legvander(z, polynomials.DEGREE - 1), -1, 0) * below
            return np.asarray(polynomials.legendre_sum(series[panel], z) * below)[None]

        edges = -np.stack([high, low], axis=1)[::-1].ravel()
        felt = np.arange(edges.size - 1) % 2 == 0
        if each:  # pieces begin shorter near now, where `below` is steepest
            fractions, felt = np.array([0.0, 0.25**3, 0.25**2, 0.25, 1.0]), np.ones(4, dtype=bool)
            edges = -rho[:, None] + (rho - low)[:, None] * fractions
        checked = 0 if len(self._panels) % 8 else 1  # the error is measured on one panel in eight
        return integrals_above(met, -rho, edges, felt, self._resolved, checked=checked)

    def _below_from_fresh(self, time: Array, level: Array) -> Array:
        """Share below `level` of the thresholds that were fresh the times `time` > 0 ago, all of shape (n,)."""
        level, time = level[:, None], time[:, None]
        decay, relaxed = np.exp(-self._pull * time), -np.expm1(-2.0 * self._pull * time)
        offset, std = level - self._mean, self._std * np.sqrt(relaxed)
        # from one to the next of these fresh thresholds, what `ndtr` takes changes by 1
        steep = self._mean + (offset + std * np.arange(-9.0, 9.5)) / np.maximum(decay, 1e-150)
        steep = np.clip(steep, self._pieces[0], self._pieces[-1])
        ends = np.concatenate([np.tile(self._pieces, (time.size, 1)), steep], axis=1)
        row, low, high = polynomials.Pieces.between(ends)
        values = low[:, None] + (high - low)[:, None] * _INNER
        below = self._below(level[row], level[row] - values, time[row])
        each = finite_density(self._fresh, values) * below @ _INNER_WEIGHTS
        spread = np.bincount(row, each * (high - low), time.size)
        exact = self._below(level, level - self._values, time) @ self._weights
        return np.asarray((spread + exact) / self._fresh_survival)

    def _below(self, level: Array, rise: Array, time: Array) -> Array:
        """Share below a level now of the thresholds that were `rise` below it a time ago; the shapes broadcast."""
        time = np.maximum(time, 0.0)  # a difference, which may be rounded
        decay, lost = np.exp(-self._pull * time), -np.expm1(-self._pull * time)
        distance = (level - self._mean) * lost + rise * decay
        # at time 0 all count as at the level
        return np.asarray(ndtr(distance / (self._std * np.sqrt(lost * (1.0 + decay)) + 1e-300)))
