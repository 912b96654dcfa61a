"""Minima and saddles of an island's energy: ASE's LBFGS brings it near, Newton's method to rounding.

Importing this file imports ase, so only functions do.
"""

from dataclasses import dataclass

import numpy as np
from ase.optimize import LBFGS

from origins.domains.moving_island import MovingIsland
from origins.thresholds.law import Array

_PROBE = 1e-4  # of a radian of the period, for curvatures by differences of forces
_MOST_HESSIANS, _MOST_STEPS = 100, 12
_MOST_RELAXATION, _NEAR = 300, 0.03  # steps of LBFGS, and the force on an atom at which Newton's method takes over
_FLAT = 1e-6
_CLOSE = 1e-15  # error of an energy to aim at, in units of the substrate's energy


@dataclass(frozen=True)
class Scales:
    """What is large and small: a radian of the period, the strongest force on one atom, the rounding of energies."""

    radian: float
    force: float
    noise: float

    @property
    def energy(self) -> float:
        return self.force * self.radian


@dataclass(frozen=True)
class LevelPoint:
    """A point without force: its energy, how far that may be off, and the number of directions that lead down."""

    points: Array
    energy: float
    error: float
    ways_down: int
    modes: Array  # as columns, the softest first
    stiffest: float


def relax(island: MovingIsland, scales: Scales, points: Array, stiffest: float) -> LevelPoint:
    """The minimum that `points` lead down to; `stiffest` is the largest curvature, energy per length squared."""
    for _ in range(5):
        image = island.image(points)
        # ASE's annotation leaves out the None that its optimizers take for silence
        optimizer = LBFGS(image, logfile=None, alpha=stiffest)  # type: ignore[arg-type]
        optimizer.maxstep = 0.3 * scales.radian  # given to it, ASE takes more than 1 for a mistake
        # on a flat top forces are small to begin with
        here = float(np.linalg.norm(image.get_forces(), axis=1).max())
        optimizer.run(fmax=min(_NEAR * scales.force, max(0.1 * here, _FLAT * scales.force)), steps=_MOST_RELAXATION)
        found = settle(island, scales, image.positions, 0)
        if found is None:
            break
        if found.ways_down == 0:
            return found
        # on a ridge by symmetry
        points = found.points + 0.3 * scales.radian * found.modes[:, 0].reshape(-1, 3)
        stiffest = found.stiffest
    raise RuntimeError(
        "forces did not vanish on the way down to a minimum: those of the calculator are not smooth, not those of its "
        "energy, or nothing holds the atoms"
    )


def settle(island: MovingIsland, scales: Scales, points: Array, climbing: int) -> LevelPoint | None:
    """The point without force near `points`, upwards along the `climbing` softest modes; None where none is found."""
    basis, points = island.basis(), island.unturned(points)
    best = np.inf
    for _ in range(_MOST_HESSIANS):
        curvatures, modes = np.linalg.eigh(_hessian(island, scales, points, basis))
        directions = basis @ modes
        flat = flattest(island, scales)
        sizes = np.maximum(np.abs(curvatures), flat)
        sizes[:climbing] *= -1.0
        last, before = np.inf, points
        for count in range(_MOST_STEPS):
            energy, forces = island.evaluate(points)
            along = directions.T @ forces.ravel()
            error = float(0.5 * (along**2 / np.abs(sizes)).sum())
            stalled = error >= best and error < 1e-9 * scales.energy
            if stalled or error <= _CLOSE * scales.energy + 0.01 * scales.noise:
                if count == 0:
                    down = int((curvatures < -10.0 * flat).sum())
                    stiffest = float(np.abs(curvatures).max())
                    return LevelPoint(points, energy, error + scales.noise, down, directions, stiffest)
                break
            if error > 0.5 * last:
                # a step by old curvatures that led astray is taken back
                points = points if count == 1 else before
                break
            last, best, before = error, min(best, error), points
            step = (directions @ (along / sizes)).reshape(-1, 3)
            points = points + step * min(1.0, 0.5 * scales.radian / np.linalg.norm(step, axis=1).max())
    return None


def flattest(island: MovingIsland, scales: Scales) -> float:
    """The least curvature that differences of forces tell from rounding."""
    return float(20.0 * np.finfo(float).eps * len(island.moving) * scales.force / (_PROBE * scales.radian))


def stiffest(island: MovingIsland, scales: Scales, points: Array) -> float:
    """The largest curvature at `points`, energy per length squared."""
    return float(np.abs(np.linalg.eigvalsh(_hessian(island, scales, points, island.basis()))).max())


def level_place(island: MovingIsland, scales: Scales, points: Array) -> LevelPoint:
    """`points` as they are, where the energy is level all round but for rounding."""
    return LevelPoint(points, island.evaluate(points)[0], scales.noise, 0, island.basis(), 0.0)


def _hessian(island: MovingIsland, scales: Scales, points: Array, basis: Array) -> Array:
    step = _PROBE * scales.radian
    rows = []
    for direction in basis.T:
        shift = step * direction.reshape(-1, 3)
        ahead, behind = island.evaluate(points + shift)[1], island.evaluate(points - shift)[1]
        rows.append((behind - ahead).ravel() @ basis / (2.0 * step))
    hessian = np.array(rows)
    return 0.5 * (hessian + hessian.T)
