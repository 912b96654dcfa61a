"""First passage of a threshold that ages towards any law, by its diffusion equation above the moving stretch.

The density u(ξ, t) of the thresholds of contacts that still hold lies between the level |S|, S = start + t, where it is
absorbed, and the upper wall. On η = (ξ - |S|)/(wall - |S|) the equation

    ∂u/∂t = D_X ∂/∂ξ (U' + ∂/∂ξ) u,     u(|S|, t) = 0,     breaks g = D_X ∂u/∂ξ at |S|

is solved by spectral elements, at a temperature with the rate of breaking h(S; ξ)/v beside it, and in time by
collocation at the Radau points of each step (four of them: order 7 at the steps' ends, and whatever is stiff is
damped). A second, finer solution tells the error.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre
from scipy.linalg import solve_banded

from master.potential import Potential
from master.spectral_elements import SpectralElements
from origins import InputError, Thresholds
from origins.quadrature import panel_edges

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
    """

    advance: Array
    survival: Array
    rate: Array
    error: float


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
    steps = np.diff(coarse.advance)
    halves = np.repeat(0.5 * steps, 2)
    fine = _march(problem, 1.2 * size, accuracy, halves)
    # order 7 in time and 8 in space: what is left is some 1/13 of the difference, or less
    error = _LEFT * float(np.abs(fine.survival[::2] - coarse.survival).max())
    return DiffusionPassage(fine.advance, fine.survival, fine.rate, error)


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


def _elements(problem: _Problem, size: float) -> SpectralElements:
    """Elements over η: of `size` (a length), and ever smaller ones towards the level."""
    span = problem.wall - abs(problem.start)
    at_level = float(problem.fresh.pdf(abs(problem.start) + 1e-9 * span)) * span
    size = max(size, span * _DEGREE / _MOST_NODES)
    thinnest = min(0.25 * problem.diffusion / span, 1e-11 / max(at_level, 1e-11), size / span)
    graded = thinnest * 3.0 ** np.arange(np.ceil(np.log(size / span / thinnest) / np.log(3.0)))
    begin = float(graded[-1]) if graded.size else 0.0
    # nothing is narrow far beyond both laws' bulk: elements there grow with the distance
    even = min(max((problem.bulk - abs(problem.start)) / span, begin + 2.0 * size / span), 1.0)
    edges = [0.0, *graded[:-1], *np.linspace(begin, even, max(int(np.ceil((even - begin) * span / size)), 2) + 1)]
    while edges[-1] < 1.0:
        edges.append(edges[-1] + size / span + _GROWTH * (edges[-1] - even))
    edges[-1] = 1.0
    return SpectralElements(np.unique(edges), _DEGREE)


def _march(problem: _Problem, size: float, accuracy: float, steps: Array | None = None) -> DiffusionPassage:
    elements = _elements(problem, size)
    step_of = _Step(problem, elements)
    span = problem.wall - abs(problem.start)
    law_edges = (panel_edges(problem.fresh) - abs(problem.start)) / span
    held = float(problem.fresh.sf(abs(problem.start)))
    q = elements.project(lambda eta: problem.fresh.pdf(abs(problem.start) + span * eta) * span / held, law_edges)
    q[0] = 0.0
    t, times, survival = 0.0, [0.0], [1.0]
    rate = [step_of.breaks(q, 0.0)]
    # the highest term of a step is of order 4, the error at its end of order 7
    aim = accuracy ** (_STAGES / (2.0 * _STAGES - 1.0))
    # before the first step ends, no more than 1e-11 of them break
    at_level = max(float(problem.fresh.pdf(abs(problem.start) + 1e-9 * span)), 1e-3 / span)
    step = min(1e-9 * span, (1e-11 / at_level) ** 2 / problem.diffusion)
    kink = max(-problem.start, 0.0)
    while (steps is None and survival[-1] > problem.spent) or (steps is not None and len(times) <= steps.size):
        if steps is not None:
            step = float(steps[len(times) - 1])
        elif t < kink:
            step = min(step, kink - t)
        stages = step_of(q, t, step)
        if steps is None:
            top = step_of.highest(q, stages) / survival[-1]
            if top > 4.0 * aim:
                step *= 0.5
                continue
            following = step * float(np.clip(0.9 * (aim / max(top, 1e-300)) ** (1.0 / _STAGES), 0.3, 2.0))
        t = kink if t < kink <= t + step * (1.0 + 1e-12) else t + step
        q = stages[:, -1]
        times.append(t)
        survival.append(float(elements.weights @ q))
        rate.append(step_of.breaks(q, t))
        if steps is None:
            step = following
        if len(times) > 2 * _MOST_STEPS:
            raise InputError(f"ageing: first passage needs more than {_MOST_STEPS} steps; use smoother laws")
    return DiffusionPassage(np.array(times), np.array(survival), np.array(rate), 0.0)


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

    def flow(self, t: float) -> Array:
        """Elements' parts of the rate of change at t, before division by the weights."""
        problem, elements = self._problem, self._elements
        at = problem.start + t
        level, sign = abs(at), -1.0 if at < 0.0 else 1.0
        span = problem.wall - level
        slope = problem.potential.slope(level + span * elements.nodes)
        drift = sign * (1.0 - elements.nodes) / span + problem.diffusion / span * slope
        # nothing stands at the level, where the slope may be infinite
        drift[0] = 0.0
        flow = elements.flow(drift, problem.diffusion / span**2)
        return flow if problem.hazard is None else flow - elements.diagonal(self._early(t))

    def _early(self, t: float) -> Array:
        """Rate of breaking before the level is met, at the nodes."""
        problem = self._problem
        assert problem.hazard is not None
        level = abs(problem.start + t)
        return problem.hazard(level, level + (problem.wall - level) * self._elements.nodes)

    def breaks(self, q: Array, t: float) -> float:
        """Breaks per unit of advance: what leaves through the level, and before that."""
        met = float(self.flow(t)[0, 0] @ q[: self._elements.degree + 1])
        return met if self._problem.hazard is None else met + float(self._elements.weights @ (self._early(t) * q))

    def __call__(self, q: Array, t: float, step: float) -> Array:
        """Values at the stages, shape (n, 4); the last one is the end of the step."""
        size, s = q.size, _STAGES
        # the kink of |S| ends a step: within one the level moves one way
        inside = np.minimum(self._points, 1.0 - 1e-12) if self._problem.start + t < 0.0 else self._points
        flows = np.stack([self.flow(t + c * step) for c in inside])
        parts = -step * self._matrix[:, :, None, None, None] * flows[None]
        band = np.bincount(self._place, parts.ravel(), minlength=(2 * self._band + 1) * size * s)
        band[self._diagonal] += np.repeat(self._elements.weights, s)
        right = np.repeat(self._elements.weights * q, s)
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
