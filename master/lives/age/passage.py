"""First passage, at one speed: how long contacts hold whose thresholds age towards a normal law.

A contact stands at `start` at t = 0, its threshold being fresh; its stretch grows at one speed, and
it breaks where |stretch| first meets its threshold. With 2ψ the flux of master.lives.age.passage_flux,
the breaks g per unit of the way t obey an equation of the second kind without a singular kernel,

    g(t) = 2ψ(t | fresh, 0) - integral_0^t g(τ) 2ψ(t | |stretch(τ)|, τ) dτ

(Buonocore, Nobile and Ricciardi, Adv. Appl. Prob. 19, 784, 1987). It is marched in panels, on each
of which 2 s g is a Legendre series in s = t^(1/2): g is smooth in s from the first contact on.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.lives.age.passage_flux import ParabolaFlux
from master.lives.age.passage_panels import NODES, SERIES, SHARE, Phase, cut_panel, cuts_towards
from origins import Ageing, Thresholds
from origins.errors import InputError, refuse

Array = npt.NDArray[np.float64]

# Survival at which the table ends and a Gaussian tail goes on.
SPENT = 1e-12
# Survival that counts as none: the reach of the table.
NOTHING = 1e-17
# Of the largest coefficient of a panel: what rounded exponents leave of it.
NOISE = 2e-14
# Error of every answer that rounding leaves.
ROUND_OFF = 1e-14
# D/v over the mean threshold below which nothing is known to diffuse by floating point.
AT_REST = 1e-28
# Panels of one march; a smooth law takes some 50.
MOST_PANELS = 4000
# Standard deviations of the final law above all thresholds at which the march ends at the latest.
BEYOND_ALL = 12.0
# Where thresholds of these quantiles, and values this many standard deviations beside exact ones,
# meet the level if nothing is random, the breaks may set in: panels end there.
QUANTILES = np.array([1e-12, 1e-6, 1e-3, 0.03, 0.25, 0.5])
BESIDE = np.array([-9.0, -4.0, -1.5, 1.5, 4.0, 9.0])
BELOW_MEAN = np.array([12.0, 8.0, 4.0, 0.0])


class Passage:
    """E(lag) of contacts born together whose thresholds age towards a Gaussian final law.

    Parameters
    ----------
    fresh : Thresholds
        P_ci, conditional on being above |start|; exact values allowed.
    ageing : Ageing
        With a Gaussian final law (`normal` is not None), uncut.
    velocity : float
        v > 0, a length per time.
    start : float
        Stretch at the birth (a length); from below 0 it comes to 0 first.
    accuracy : float
        Survival that a panel may miss.

    Attributes
    ----------
    reach_lag : float
        Time after which the survival is below 1e-17.
    error : float
        Estimate of the largest error of the survival.

    Raises InputError where no threshold lies above |start|, and where the fresh thresholds are so
    far from the final law that their breaks are beyond floating point.
    """

    def __init__(
        self,
        fresh: Thresholds,
        ageing: Ageing,
        velocity: float,
        start: float = 0.0,
        accuracy: float = 1e-13,
    ) -> None:
        normal = ageing.normal
        assert normal is not None and velocity > 0.0
        if not float(fresh.sf(abs(start))) > 0.0:
            refuse("start", start, "lies beyond every threshold; contacts there hold nothing")
        diffusion = max(ageing.rate / velocity, AT_REST * fresh.mean())
        self.velocity, self.accuracy, self.diffusion = velocity, accuracy, diffusion
        self.flux = ParabolaFlux(fresh, normal.mean, normal.std, diffusion, abs(start))
        # the kernel of the integral equation changes within a part of that way
        self._finest = 0.5 * min(4.0 * diffusion, 1.0 / self.flux.rate)
        self.phases: list[Phase] = []
        self._left, self.error = 1.0, ROUND_OFF
        if start < 0.0:
            self._march(Phase(0.0, -start, -1.0), -start)
        if self._left > 1.001 * SPENT:
            level = max(start, 0.0)
            furthest = max(float(fresh.isf(1e-16)), normal.mean) + BEYOND_ALL * normal.std
            self._march(Phase(max(-start, 0.0), level, 1.0), furthest - level)
        self._finish(start)

    def survival(self, lag: Array) -> Array:
        """E at times `lag` >= 0 since the birth, same shape."""
        way = np.asarray(lag, dtype=float) * self.velocity
        out = np.ones(way.shape)
        for phase in self.phases:
            here = way > phase.begin
            out[here] = phase.survival(np.sqrt(way[here] - phase.begin))
        far = way > self._end
        beyond = way[far] - self._end
        out[far] = self._left * np.exp(-self._hazard * beyond - 0.5 * self._slope * beyond**2)
        return np.clip(out, 0.0, 1.0)

    def _finish(self, start: float) -> None:
        """The Gaussian tail beyond the table, and what holds at the panels' ends, of sum 1."""
        last = self.phases[-1]
        density, change = last.density_at_end()
        self._end = last.begin + last.edges[-1] ** 2
        if self._left > 1.001 * SPENT or self._left <= 0.0 or density <= 0.0:
            # all have broken: what seems left was lost to rounding
            self.error += abs(self._left)
            self._left = 0.0
        broken = sum(phase.broken for phase in self.phases)
        if not broken > 0.0:
            raise InputError(
                f"ageing: contacts that hold at x = {start:g} have fresh thresholds far from the "
                f"final law, mean {self.flux.mean:g}, std {self.flux.std:g}, and their breaks are "
                "beyond floating point"
            )
        self._hazard, self._slope, reach = 0.0, 0.0, 0.0
        if self._left > 0.0:
            self._hazard = density / self._left
            self._slope = max(change / self._left + self._hazard**2, 0.0)
            rest = np.log(self._left / NOTHING)
            root = np.sqrt(self._hazard**2 + 2.0 * self._slope * rest)
            reach = 2.0 * rest / (self._hazard + root)
        self.reach_lag = (self._end + reach) / self.velocity
        after = self._left
        for phase in self.phases[::-1]:
            after = phase.finish(after, (1.0 - self._left) / broken)

    def _march(self, phase: Phase, length: float) -> None:
        """Panels of the phase until the level has gone `length` or next to nothing is left."""
        self.phases.append(phase)
        last = np.sqrt(length)
        marks = self._marks(phase)
        std, rate = self.flux.std, self.flux.rate
        width = 0.1 * np.sqrt(min(self.diffusion, 1.0 / rate, 0.1 * std))
        left = 0.0
        while left < last and self._left > 1.001 * SPENT:
            ahead = marks[marks > left * (1.0 + 1e-12)]
            room = min(last, float(ahead[0]) if ahead.size else np.inf) - left
            step = room if width > 0.9 * room else min(width, 0.5 * room)
            series = self._panel(phase, left, step)
            tail = float(np.abs(series[-2:]).max()) * step
            aim = max(self.accuracy, NOISE * float(np.abs(series).max()) * step)
            if tail > aim and step > 1e-9 * (left + step):
                width = 0.5 * step
                continue
            right = left + step
            if self._left - float(series[0]) * step < SPENT:
                right, series = cut_panel(left, right, series, self._left - SPENT)
            phase.add(right, series)
            self._left -= float(series[0]) * (right - left)
            self.error += tail
            left = right
            early = float(np.abs(series[-6:]).max()) * step
            width = step * (2.0 if early < aim else 1.3 if tail < 0.1 * aim else 1.0)
            if len(phase.series) > MOST_PANELS:
                raise InputError(
                    f"ageing: the first passage needs more than {MOST_PANELS} panels; use a "
                    "smoother law of fresh thresholds"
                )

    def _marks(self, phase: Phase) -> Array:
        """s at which breaks may set in within less than a panel so far: where thresholds would meet
        the level if nothing were random."""
        if phase.sign < 0.0:
            return np.empty(0)
        flux, fresh = self.flux, self.flux.fresh
        quantiles = np.concatenate([fresh.ppf(QUANTILES), fresh.isf(QUANTILES)])
        corners = fresh.breakpoints
        exact = np.concatenate([flux.values, corners[corners > phase.level]])
        at = self._meetings(exact, phase)
        spread = flux.std * np.sqrt(-np.expm1(-2.0 * flux.rate * (at + phase.begin)))
        beside = (at[:, None] + spread[:, None] * BESIDE).ravel()
        goal = flux.mean - BELOW_MEAN * flux.std - phase.level
        marks = np.concatenate([self._meetings(quantiles, phase), at, beside, goal])
        marks = np.unique(np.sqrt(marks[marks > 0.0]))
        # marks closer than rounding tell nothing
        return marks[np.diff(marks, prepend=-1.0) > 1e-9 * marks]

    def _meetings(self, values: Array, phase: Phase) -> Array:
        """Way in the phase after which thresholds that start from `values` and relax without chance
        meet the level."""
        flux = self.flux
        low, high = np.zeros(values.size), np.maximum(values, flux.mean) - phase.level
        for _ in range(60):
            t = 0.5 * (low + high)
            decay = np.exp(-flux.rate * (t + phase.begin))
            above = flux.mean + (values - flux.mean) * decay > phase.level + t
            low, high = np.where(above, t, low), np.where(above, high, t)
        return high[high > 0.0]

    def _panel(self, phase: Phase, left: float, width: float) -> Array:
        """Legendre coefficients of 2 s g on a panel, from the fresh and all that broke before."""
        s = left + width * SHARE
        t = s * s
        level = phase.level + phase.sign * t
        known = self.flux.from_fresh(t + phase.begin, level, phase.sign)
        for earlier in self.phases[:-1]:
            known -= self._from_earlier(earlier, phase, t, level)
        cuts = cuts_towards(s, np.array(phase.edges), s, self._finest)
        elapsed = cuts.below * (s[cuts.row, None] + cuts.node)
        counts = self.flux.counts(level[cuts.row], phase.sign * elapsed, elapsed)
        row, node, weight = cuts.row[counts], cuts.node[counts], cuts.weight[counts]
        elapsed = elapsed[counts]
        weight = weight * self.flux.from_level(
            level[row, None], phase.sign, phase.sign * elapsed, elapsed
        )
        own = node[:, 0] > left
        if not own.all():
            old = (weight[~own] * phase.value(node[~own])).sum(axis=-1)
            known -= np.bincount(row[~own], weights=old, minlength=NODES)
        basis = legendre.legvander((2.0 * (node[own] - left)) / width - 1.0, NODES - 1)
        kernel = np.zeros((NODES, NODES))
        np.add.at(kernel, row[own], np.einsum("nq,nqk->nk", weight[own], basis))
        matrix = SERIES + 2.0 * s[:, None] * kernel
        return np.asarray(np.linalg.solve(matrix, 2.0 * s * known), dtype=float)

    def _from_earlier(self, earlier: Phase, phase: Phase, t: Array, level: Array) -> Array:
        """What those that broke while the level came down would add to the flux at ways t up."""
        edges = np.array(earlier.edges)
        top = np.full(t.size, edges[-1])
        cuts = cuts_towards(top, edges, np.sqrt(t), self._finest)
        back = cuts.below * (top[cuts.row, None] + cuts.node)  # the level came down by that much
        rise, elapsed = t[cuts.row, None] - back, t[cuts.row, None] + back
        counts = self.flux.counts(level[cuts.row], rise, elapsed)
        row, node = cuts.row[counts], cuts.node[counts]
        flux = self.flux.from_level(level[row, None], phase.sign, rise[counts], elapsed[counts])
        parts = (cuts.weight[counts] * flux * earlier.value(node)).sum(axis=-1)
        return np.asarray(np.bincount(row, weights=parts, minlength=t.size), dtype=float)
