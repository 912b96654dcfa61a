"""The easiest way on for an island whose atoms or height follow: ASE's LBFGS and its climbing-image elastic bands."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from origins.errors import InputError
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

    from origins.domains.moving_island import MovingIsland

_KNOWN = 1e-9  # in scales.energy: minima nearer than this are the same
_STEPS = ((1, 0), (0, 1), (1, 1), (1, -1))  # periods that bands lead over
_IMAGES = 11
_SHAKE = 0.02  # radians
_LOOSE, _TIGHT = 1e-2, 1e-10  # of the greatest force: left by ASE, and by Newton's method after it
_MOST_STEPS, _BAND_STEPS = 2000, 300  # of a relaxation, of a band: Newton's method does the rest
_DENSE = 60  # directions up to which Newton's method takes a whole matrix
_MOST_MINIMA = 10


@dataclass(frozen=True)
class Scales:
    """radian, the shorter period over 2 pi; force, the greatest on one atom; noise, rounding of energies."""

    radian: float
    force: float
    noise: float

    @property
    def energy(self) -> float:
        return self.radian * self.force


@dataclass(frozen=True)
class Ends:
    """Where the minimum and the saddle are, points of the island, and what is not known of their energies."""

    minimum: Array
    saddle: Array
    error: float


def by_bands(island: MovingIsland, scales: Scales, periods: Array) -> Ends:
    """The lowest minimum found from 16 places and along the bands, and the lowest top of four bands."""
    starts = [np.array([i, j]) / 4.0 @ periods for i in range(4) for j in range(4)]
    found = (_relaxed(island, scales, island.points + flat(shift)) for shift in starts)
    lowest = _level(island, scales, min(found, key=island.energy_at))
    for _ in range(_MOST_MINIMA):
        tops = []
        for step in np.array(_STEPS) @ periods:
            top, lower = _band(island, scales, lowest, flat(step))
            if island.energy_at(lower) < island.energy_at(lowest) - _KNOWN * scales.energy:
                lowest = lower
                break
            tops.append(top)
        else:
            return Ends(lowest, min(tops, key=island.energy_at), 0.0)
    raise InputError(
        "atoms: bands lead to ever lower minima; take rigid=True or atoms that hold together more stiffly"
    )


def _image(island: MovingIsland, scales: Scales, points: Array) -> ase.Atoms:
    """The points as Atoms of their own, lengths in scales.radian, energies in scales.energy."""
    import ase

    from origins.domains.moving_island import IslandCalculator

    image = ase.Atoms(numbers=np.zeros(len(points), dtype=int), positions=points / scales.radian)
    image.calc = IslandCalculator(island, scales.radian, scales.energy)
    return image


def _relaxed(island: MovingIsland, scales: Scales, points: Array) -> Array:
    """The minimum that ASE's LBFGS finds from `points`."""
    from ase.optimize import LBFGS

    image = _image(island, scales, points)
    if not LBFGS(image, logfile=os.devnull).run(fmax=_LOOSE, steps=_MOST_STEPS):
        raise RuntimeError("the forces on the island do not vanish: no minimum was found")
    return island.unturned(image.positions * scales.radian)


def _level(island: MovingIsland, scales: Scales, points: Array) -> Array:
    """Where the forces vanish, beside `points`; these themselves where none is found."""
    from scipy.optimize import root

    basis = island.basis()

    def forces(q: Array) -> Array:
        there = points + scales.radian * (basis @ q).reshape(points.shape)
        return island.evaluate(there)[1].ravel() @ basis / scales.force

    size = basis.shape[1]
    if size > _DENSE:
        found = root(
            forces, np.zeros(size), method="krylov", options={"fatol": _TIGHT, "maxiter": 200}
        )
    else:
        found = root(forces, np.zeros(size), method="hybr", options={"xtol": 1e-15})
    moved = points + scales.radian * (basis @ found.x).reshape(points.shape)
    settled = np.abs(forces(found.x)).max() <= 1e-8 and np.abs(found.x).max() <= 0.5
    return island.unturned(moved) if settled else points


def _band(island: MovingIsland, scales: Scales, minimum: Array, step: Array) -> tuple[Array, Array]:
    """The top of the way over one step, by ASE's climbing-image NEB, and the lowest minimum beside it."""
    from ase.mep import NEB
    from ase.optimize import FIRE

    shake, basis = np.random.default_rng(0), island.basis()
    images = []
    for share in np.linspace(0.0, 1.0, _IMAGES):
        # a band of one symmetry could not leave it
        noise = _SHAKE * scales.radian * (basis @ shake.standard_normal(basis.shape[1]))
        inner = 0.0 if share in (0.0, 1.0) else 1.0
        images.append(
            _image(island, scales, minimum + share * step + inner * noise.reshape(minimum.shape))
        )
    band = NEB(images, climb=True, method="improvedtangent")
    FIRE(band, logfile=os.devnull).run(fmax=_LOOSE, steps=_BAND_STEPS)
    energies = np.array([image.get_potential_energy() for image in images])
    top = images[int(energies[1:-1].argmax()) + 1].positions * scales.radian
    low = images[int(energies[1:-1].argmin()) + 1]
    lower = minimum
    if low.get_potential_energy() < energies[0] - _KNOWN:
        lower = _level(island, scales, _relaxed(island, scales, low.positions * scales.radian))
    return _level(island, scales, top), lower


def flat(shift: Array) -> Array:
    """Shifts along x and y, shape (..., 2), as shifts in space."""
    return np.concatenate([shift, np.zeros((*shift.shape[:-1], 1))], axis=-1)
