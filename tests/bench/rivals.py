"""What a user would write or install instead of this toolkit, each as short as it can be for the same question.

The question is F(X) of Gaussian thresholds on a rigid slider that moves forward, Fig. 2 (A02a) of the paper, or the
force of so many single contacts. Each function here that gives F takes the path and a setting; those of contacts give
the mean force and the number of breaks.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit
from scipy import integrate, ndimage, signal
from scipy.special import ndtr

Array = npt.NDArray[np.float64]
MEAN, STD, START_STD = 1.0, 0.05, 0.025  # mean thresholds


def normal(x: Array, mean: float, std: float) -> Array:
    return np.exp(-0.5 * ((x - mean) / std) ** 2) / (np.sqrt(2.0 * np.pi) * std)


def upwind(path: Array, cells: int) -> Array:
    """F by scipy's solve_ivp on an upwind grid of stretches: dQ/dX = -dQ/dx - h Q, with what breaks put in at x = 0."""
    width = 1.6 / cells
    x = -0.2 + width * (np.arange(cells) + 0.5)
    hazard = normal(x, MEAN, STD) / np.maximum(ndtr((MEAN - x) / STD), 1e-300)
    zero = int(np.searchsorted(x, 0.0))

    def rates(_: float, density: Array) -> Array:
        gone = np.minimum(hazard, 4.0 / width) * density
        change = -(density - np.concatenate([[0.0], density[:-1]])) / width - gone
        change[zero] += gone.sum()
        return change

    begin = normal(x, 0.0, START_STD)
    found = integrate.solve_ivp(
        rates, (path[0], path[-1]), begin, t_eval=path, rtol=1e-5, atol=1e-8
    )
    return (x * width) @ found.y


def by_voles(path: Array, finer: int) -> Array:
    """F by voles' Volterra solver from the density of breaks, and a convolution for the force."""
    import voles

    step = (path[1] - path[0]) / finer
    way = step * np.arange(finer * (path.size - 1) + 1)
    spread = np.hypot(STD, START_STD)
    first, kernel = normal(way, MEAN, spread), normal(way, MEAN, STD)
    breaks = voles.solve_VIE_2(kernel_values=kernel, g_values=first, time_step=step)
    node, weight = np.polynomial.hermite_e.hermegauss(24)  # of starts, a Gaussian about 0
    x = way[:, None] + START_STD * node
    started = (x * ndtr((MEAN - x) / STD)) @ weight / np.sqrt(2.0 * np.pi)
    borne = way * ndtr((MEAN - way) / STD)
    return (started + step * signal.fftconvolve(breaks, borne)[: way.size])[::finer]


class Crowd(NamedTuple):
    """Mean force of single contacts at the points of the path, and how often they broke."""

    force: Array
    breaks: int


@njit
def _heap(path: Array, contacts: int, mean: float, std: float) -> tuple[Array, int]:
    """A binary heap of the places at which contacts break next, the usual event-driven loop."""
    place, born, count = np.empty(contacts), np.zeros(contacts), 0
    for i in range(contacts):
        place[i] = np.random.normal(mean, std)  # noqa: NPY002
    order = np.argsort(place)
    place, force, sum_born = place[order], np.empty(path.size), 0.0
    for k in range(path.size):
        while place[0] < path[k]:
            at = place[0]
            sum_born += at - born[0]
            count += 1
            due, i = at + np.random.normal(mean, std), 0  # noqa: NPY002
            while True:  # sift down
                child = 2 * i + 1
                if child >= contacts:
                    break
                if child + 1 < contacts and place[child + 1] < place[child]:
                    child += 1
                if place[child] >= due:
                    break
                place[i], born[i] = place[child], born[child]
                i = child
            place[i], born[i] = due, at
        force[k] = path[k] - sum_born / contacts
    return force, count


def heap(path: Array, contacts: int) -> Crowd:
    return Crowd(*_heap(path, contacts, MEAN, STD))


def agents(path: Array, contacts: int) -> Crowd:
    """The same by Mesa, an agent for each contact; raises ImportError where it is not installed."""
    import mesa

    class Contact(mesa.Agent):  # type: ignore[misc]
        def __init__(self, model: Any) -> None:
            super().__init__(model)
            self.x, self.limit = 0.0, model.rng.normal(MEAN, STD)

        def step(self) -> None:
            self.x += self.model.move
            if self.x > self.limit:
                self.x, self.limit = 0.0, self.model.rng.normal(MEAN, STD)
                self.model.breaks += 1

    model: Any = mesa.Model(rng=1)
    model.breaks, force = 0, np.zeros(path.size)
    Contact.create_agents(model, contacts)
    for k, model.move in enumerate(np.diff(path, prepend=0.0)):
        model.agents.do("step")
        force[k] = sum(agent.x for agent in model.agents) / contacts
    return Crowd(force, model.breaks)


def atomic_sums(ratio: float, long: int, wide: int, angle: float) -> float:
    """Barrier of a rigid triangular island on sin x + sin y, 2 min(|S_x|, |S_y|), by sums over all atoms."""
    i, j = np.meshgrid(np.arange(long), np.arange(wide), indexing="ij")
    x, y = ratio * (i + 0.5 * j - (j // 2)), ratio * np.sqrt(0.75) * j
    cos, sin = np.cos(angle), np.sin(angle)
    sums = [abs(np.exp(1j * at).sum()) for at in (cos * x - sin * y, sin * x + cos * y)]
    return 2.0 * float(min(sums))


def by_flake(ratio: float, long: int, wide: int, angle: float, points: int) -> float:
    """Barrier of the same island on cos G_1·r + cos G_2·r + cos G_3·r from FLAKE's map of points x points places of a
    cell (A. Silva and others, PyPI: flake-rigid): the level at which a minimum joins its copy in the next cell."""
    from flake.maps import translational_map
    from flake.substrate import substrate_from_params

    import origins

    substrate = origins.hexagonal_substrate()
    G, cell = substrate.wavevectors, substrate.cell
    # -ε/9 |sum of three waves|² holds their differences, which are the three G
    asked = {"well_shape": "sin", "epsilon": -4.5, "ks": [0.0 * G[0], G[0], -G[2]]}
    energy = substrate_from_params(asked | {"sub_basis": [[0.0, 0.0]]})[1]
    atoms = origins.triangular_island(ratio, long, wide).positions[:, :2]
    cos, sin = np.cos(angle), np.sin(angle)
    turned = (atoms - atoms.mean(axis=0)) @ np.array([[cos, sin], [-sin, cos]])
    shares = np.stack(np.meshgrid(*[np.arange(points) / points] * 2, indexing="ij"), -1)
    places = shares.reshape(-1, 2) @ cell
    found = translational_map(turned, energy, None, 0, 0, pos_cm_grid=places)["energy"]
    return lowest_pass(found.reshape(points, points))


def lowest_pass(energy: Array) -> float:
    """Least height over the lowest point of a periodic map at which a path leads to a copy of that point."""
    tiled, levels = np.tile(energy, (3, 3)), np.unique(energy)
    places = [np.add(np.unravel_index(energy.argmin(), energy.shape), energy.shape)]
    places += [
        places[0] + step * np.array(energy.shape) for step in ((0, 1), (1, 0), (1, 1), (1, -1))
    ]
    low, high = 0, levels.size - 1
    while low < high:
        middle = (low + high) // 2
        labels = ndimage.label(tiled <= levels[middle], np.ones((3, 3)))[0]
        own, *others = (labels[tuple(place)] for place in places)
        low, high = (low, middle) if own in others else (middle + 1, high)
    return float(levels[low] - levels[0])
