"""First passage of a threshold that ages towards any law, by its diffusion equation above the moving stretch.

The density u(ξ, t) of the thresholds of contacts that still hold lies between the level |S|, S = start + t, where it is
absorbed, and the upper wall. On η = (ξ - |S|)/(wall - |S|) the equation

    ∂u/∂t = D_X ∂/∂ξ (U' + ∂/∂ξ) u,     u(|S|, t) = 0,     breaks g = D_X ∂u/∂ξ at |S|

is solved by spectral elements, at a temperature with the rate of breaking h(S; ξ)/v beside it, and in time by
collocation at the Radau points of each step (four of them: order 7 at the steps' ends, and whatever is stiff is
damped). A second, finer solution tells the error.

Where the final law begins at a wall above |S| nothing breaks at it: thresholds lie between the walls, and nothing flows
through either. Once |S| is there they are met all along a density that does not vanish, at a rate ~ t^(-1/2) at first.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre
from scipy.linalg import solve_banded

from master._old.potential import Potential
from master._old.spectral_elements import SpectralElements
from origins import InputError, Thresholds
from origins.thresholds.quadrature import panel_edges

Array = npt.NDArray[np.float64]
Hazard = Callable[[float, Array], Array]

_STAGES = 4
_DEGREE = 8
_FAR = 1e-16
_FEW = 1e-4
_GROWTH = 0.3
_DECILES = np.linspace(0.05, 0.95, 10)
_MOST_NODES = 6000
_MOST_STEPS = 3000
_LEFT = 0.25
_EASY = 1e-8
_ULPS = 1e-13
_ALL = 1e-6
_TO_THE_WALL = 0.2
_AT_A_WALL = 1e-5  # of the range, thinner elements there cost digits


@dataclass(frozen=True)
class DiffusionPassage:
    """Survival and breaks of contacts that stand at `start` at t = 0, at the ends of steps.

    Attributes
    ----------
    advance : array (n,), t from 0 on (lengths)
    survival : array (n,)
    rate : array (n,), g per length
    error : float
        Estimate of the survival's.
    begins : float
        Advance before which none break; `advance` counts from there.
    roots : tuple of int
        Ends of steps from which on the survival is a series in the root of what has passed since.
    steps : array (m,), all that were taken, those before `begins` too.
    """

    advance: Array
    survival: Array
    rate: Array
    error: float
    begins: float
    roots: tuple[int, ...]
    steps: Array


def diffusion_passage(
    fresh: Thresholds,
    final: Thresholds,
    diffusion: float,
    start: float = 0.0,
    spent: float = 1e-12,
    accuracy: float = 1e-7,
    hazard: Hazard | None = None,
) -> DiffusionPassage:
    """Breaks of contacts whose fresh thresholds, from `fresh` above |start|, diffuse towards `final`.

    diffusion is D_X = D/v > 0, a length; hazard(x, ξ), if there is one, the rate per length at which contacts of a
    stretch x >= 0 and thresholds ξ of shape (n,) break before they meet. Raises InputError for fresh thresholds with
    exact single values. Corners of either law, and features of less than a 700th of the range, cost accuracy; the
    error says how much.
    """
    if fresh.atoms[0].size:
        raise InputError(
            f"thresholds: hold the single value {fresh.atoms[0][0]:g}: only towards a Gaussian final law can such "
            "diffuse; use a fresh law with a density"
        )
    wall = _wall(fresh, final)
    potential = Potential(final, wall)
    problem = _Problem(fresh, potential, diffusion, start, wall, _bulk(fresh, final), spent, hazard)
    # corners are blurred until the level comes to them; where it turns away first, the fresh law ends in one
    corners = fresh.breakpoints[fresh.breakpoints > abs(start)]
    corners = np.append(corners, -start) if start < 0.0 and float(fresh.cdf(-start)) > accuracy else corners
    blurred = np.sqrt(2.0 * diffusion * (corners - start))
    narrow = min(narrowest(fresh), narrowest(final), float(blurred.min(initial=np.inf)))
    size = narrow * min(accuracy / _EASY, 1.0) ** (1.0 / _DEGREE)
    coarse = _march(problem, 1.6 * size, accuracy)
    fine = _march(problem, 1.2 * size, accuracy, np.repeat(0.5 * coarse.steps, 2))
    # order 7 in time and 8 in space: what is left is some 1/13 of the difference, or less
    error = _LEFT * float(np.abs(fine.survival[::2] - coarse.survival).max())
    return replace(fine, error=error)


@dataclass(frozen=True)
class _Problem:
    fresh: Thresholds
    potential: Potential
    diffusion: float
    start: float
    wall: float
    bulk: float
    spent: float
    hazard: Hazard | None = None

    @property
    def lower(self) -> float:
        """Where thresholds begin."""
        return float(self.potential.edges[0])

    @property
    def bottom(self) -> float:
        """Where those begin that hold at t = 0."""
        return max(abs(self.start), self.lower)

    def legs(self) -> list[tuple[float, int, float]]:
        """Stretch where each leg begins, whether the lowest threshold there may be goes down (-1), stays or goes up
        with |S| on it, and its length."""
        lower, at, legs = self.lower, self.start, []
        if at < -lower:
            legs.append((at, -1, -lower - at))
            at = -lower
        if at < lower:
            legs.append((at, 0, lower - at))
            at = lower
        # at the upper wall none are left
        return [*legs, (at, 1, (self.wall - at) * (1.0 - _ALL))]


def _wall(fresh: Thresholds, final: Thresholds) -> float:
    """Where thresholds end, or where so few lie beyond that none need be followed."""
    upper = final.support()[1]
    far = max(float(fresh.isf(_FAR)), float(final.isf(_FAR)))
    return min(upper, far)


def _bulk(fresh: Thresholds, final: Thresholds) -> float:
    """What few thresholds exceed."""
    return max(float(fresh.isf(_FEW)), float(final.isf(_FEW)))


def narrowest(law: Thresholds) -> float:
    """Width of a Gaussian as sharp as the sharpest tenth of the weight."""
    spread = np.diff(law.ppf(_DECILES))
    return float(spread[spread > 0.0].min(initial=law.mean())) / 0.25


def _at_level(problem: _Problem, least: float) -> float:
    """Density of thresholds where they are met first."""
    span, law = problem.wall - problem.bottom, problem.fresh
    density = float(law.pdf(problem.bottom + 1e-9 * span))
    if abs(problem.start) < problem.lower:
        # by then some have come to the wall
        density = max(density, float(problem.potential.final.pdf(problem.bottom + 1e-9 * span)))
    return max(density, least / span)


def _elements(problem: _Problem, size: float, met: bool = True) -> SpectralElements:
    """Elements over η: of `size` (a length), ever smaller ones towards a level at which they are met."""
    span = problem.wall - problem.bottom
    at_level = _at_level(problem, 1e-11) * span
    size = max(size, span * _DEGREE / _MOST_NODES)
    thinnest = min(0.25 * problem.diffusion / span, 1e-11 / at_level, size / span)
    if not met:
        # the density is smooth at a wall, or a power
        thinnest = max(thinnest, min(_AT_A_WALL, size / span))
    graded = thinnest * 3.0 ** np.arange(np.ceil(np.log(size / span / thinnest) / np.log(3.0)))
    begin = float(graded[-1]) if graded.size else 0.0
    # nothing is narrow far beyond both laws' bulk: elements there grow with the distance
    even = min(max((problem.bulk - problem.bottom) / span, begin + 2.0 * size / span), 1.0)
    edges = [0.0, *graded[:-1], *np.linspace(begin, even, max(int(np.ceil((even - begin) * span / size)), 2) + 1)]
    while edges[-1] < 1.0:
        edges.append(edges[-1] + size / span + _GROWTH * (edges[-1] - even))
    edges[-1] = 1.0
    return SpectralElements(np.unique(edges), _DEGREE)


def _march(problem: _Problem, size: float, accuracy: float, steps: Array | None = None) -> DiffusionPassage:
    legs = problem.legs()
    elements = _elements(problem, size, legs[0][1] != 0)
    step_of = _Step(problem, elements)
    span = problem.wall - problem.bottom
    law_edges = (panel_edges(problem.fresh) - problem.bottom) / span
    held = float(problem.fresh.sf(abs(problem.start)))
    q = elements.project(lambda eta: problem.fresh.pdf(problem.bottom + span * eta) * span / held, law_edges)
    # the highest term of a step is of order 4, the error at its end of order 7
    aim = accuracy ** (_STAGES / (2.0 * _STAGES - 1.0))
    # before the first step ends, no more than 1e-11 of them break
    first = min(1e-9 * span, (1e-11 / _at_level(problem, 1e-3)) ** 2 / problem.diffusion)
    step, taken, begins, survived = first, 0, 0.0, 1.0
    times, survival, rate, roots, sizes = [0.0], [1.0], [0.0], [0], []
    for k, (begin, way, length) in enumerate(legs):
        if (survived <= problem.spent) if steps is None else taken == steps.size:
            break
        if k and problem.lower > 0.0:
            before, elements = elements, _elements(problem, size, way != 0)
            q, step_of = elements.project(partial(before.at, q), before.edges), _Step(problem, elements)
            if way:
                # thresholds at the wall are met at once
                step = max(first, _ULPS * times[-1])
                roots.append(len(times) - 1)
        if k == 1 and way and problem.lower > 0.0 and problem.hazard is None:
            begins, times, survival, rate, roots, step = times[-1], [0.0], [1.0], [0.0], [0], first
        offset, t = times[-1], 0.0
        if way:
            q[0] = 0.0
        if not taken:
            rate[0] = step_of.breaks(q, begin, way)
        while t < length and (survived > problem.spent if steps is None else taken < steps.size):
            if steps is not None:
                step = float(steps[taken])
            elif way > 0:
                # what is left between the level and the wall falls ever faster
                step = min(step, _TO_THE_WALL * (problem.wall - begin - t))
            step = min(step, length - t)
            stages = step_of(q, begin + t, way, step)
            if steps is None:
                top = step_of.highest(q, stages) / survived
                if top > 4.0 * aim:
                    step *= 0.5
                    continue
                following = step * float(np.clip(0.9 * (aim / max(top, 1e-300)) ** (1.0 / _STAGES), 0.3, 2.0))
            t = length if t + step * (1.0 + 1e-12) >= length else t + step
            q, taken = stages[:, -1], taken + 1
            survived = float(elements.weights @ q)
            sizes.append(step)
            times.append(offset + t)
            survival.append(survived)
            rate.append(step_of.breaks(q, begin + t, way))
            if steps is None:
                step = following
            if taken > 2 * _MOST_STEPS:
                raise InputError(f"ageing: first passage needs more than {_MOST_STEPS} steps; use smoother laws")
    advance, found = np.array(times), np.array(survival)
    return DiffusionPassage(advance, found, np.array(rate), 0.0, begins, tuple(roots), np.array(sizes))


class _Step:
    """One step of collocation: all stages at once, as a banded system in which they lie side by side."""

    def __init__(self, problem: _Problem, elements: SpectralElements) -> None:
        self._problem, self._elements = problem, elements
        self._points, self._matrix = _radau()
        size, s = elements.nodes.size, _STAGES
        self._band = elements.degree * s + s - 1
        rows = elements.index[:, :, None] * s
        columns = elements.index[:, None, :] * s
        stage = np.arange(s)
        row = rows[None, None] + stage[:, None, None, None, None]
        column = columns[None, None] + stage[None, :, None, None, None]
        row, column = np.broadcast_arrays(row, column)
        self._place = ((self._band + row - column) * (size * s) + column).ravel()
        self._diagonal = self._band * size * s + np.arange(size * s)
        near = np.arange(min(size * s, self._band + s))
        self._first = np.concatenate([(self._band + i - near) * (size * s) + near for i in range(s)])
        self._first = self._first[np.concatenate([np.abs(i - near) <= self._band for i in range(s)])]

    def flow(self, at: float, way: int) -> Array:
        """Elements' parts of the rate of change at the stretch `at`, before division by the weights; way : see legs."""
        problem, elements = self._problem, self._elements
        level = max(abs(at), problem.lower)
        span = problem.wall - level
        slope = problem.potential.slope(level + span * elements.nodes)
        drift = way * (1.0 - elements.nodes) / span + problem.diffusion / span * slope
        if way or problem.potential.is_singular:
            # nothing stands there, and the slope may be infinite
            drift[0] = 0.0
        flow = elements.flow(drift, problem.diffusion / span**2)
        return flow if problem.hazard is None else flow - elements.diagonal(self._early(at))

    def _early(self, at: float) -> Array:
        """Rate of breaking before the level is met, at the nodes."""
        problem = self._problem
        assert problem.hazard is not None
        level = max(abs(at), problem.lower)
        return problem.hazard(abs(at), level + (problem.wall - level) * self._elements.nodes)

    def breaks(self, q: Array, at: float, way: int) -> float:
        """Breaks per unit of advance: what leaves through the level, and before that."""
        met = float(self.flow(at, way)[0, 0] @ q[: self._elements.degree + 1]) if way else 0.0
        return met if self._problem.hazard is None else met + float(self._elements.weights @ (self._early(at) * q))

    def __call__(self, q: Array, at: float, way: int, step: float) -> Array:
        """Values at the stages, shape (n, 4); the last one is the end of the step."""
        size, s = q.size, _STAGES
        flows = np.stack([self.flow(at + c * step, way) for c in self._points])
        parts = -step * self._matrix[:, :, None, None, None] * flows[None]
        band = np.bincount(self._place, parts.ravel(), minlength=(2 * self._band + 1) * size * s)
        band[self._diagonal] += np.repeat(self._elements.weights, s)
        right = np.repeat(self._elements.weights * q, s)
        if way:
            band[self._first] = 0.0
            band[self._diagonal[:s]] = 1.0
            right[:s] = 0.0
        shape = (2 * self._band + 1, size * s)
        both = (self._band, self._band)
        found = solve_banded(both, band.reshape(shape), right, overwrite_ab=True, overwrite_b=True, check_finite=False)
        return found.reshape(size, s)

    def highest(self, q: Array, stages: Array) -> float:
        """Weight of the highest term of the step's polynomial."""
        last = np.linalg.inv(legendre.legvander(2.0 * np.append(0.0, self._points) - 1.0, _STAGES))[-1]
        return float(self._elements.weights @ np.abs(q * last[0] + stages @ last[1:]))


@lru_cache
def _radau() -> tuple[Array, Array]:
    """Points of (0, 1] and the integrals of their Lagrange polynomials from 0 to each."""
    series = np.zeros(_STAGES + 1)
    series[-2:] = -1.0, 1.0
    points = 0.5 * (np.sort(legendre.legroots(series).real) + 1.0)
    points[-1] = 1.0
    powers = np.arange(_STAGES)
    integrals = points[:, None] ** (powers + 1.0) / (powers + 1.0)
    return points, integrals @ np.linalg.inv(points[:, None] ** powers)
