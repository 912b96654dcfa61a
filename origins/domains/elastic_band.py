"""Nudged elastic bands by ASE, and the saddles on them.

Importing this file imports ase, so only functions do.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from ase.mep import NEB
from ase.optimize import FIRE

from origins.domains.level_points import LevelPoint, Scales, relax, settle
from origins.domains.moving_island import MovingIsland
from origins.errors import InputError
from origins.thresholds.law import Array

_SPACING = 0.9  # between images, in radians of the period for the atom that moves farthest
_LEAST_IMAGES, _MOST_IMAGES = 5, 500
_MOST_STEPS = 100
_LOOSE = 0.02  # force left on a band, of the substrate's
_TIGHTER = 0.3
_MOST_TRIES, _MOST_PIECES = 4, 200
_SAMPLES = 16  # of the energy between two images
_SHORT = 0.05  # of the height of the way
_SAME = 0.1  # minima nearer than this, in radians of the period, are one


@dataclass
class _Piece:
    """A path from one minimum to another, to be followed over the saddles between."""

    first: LevelPoint
    path: Array
    last: LevelPoint
    tries: int = 0
    slack: bool = True  # whether a band is to be laid before minima are looked for


def highest_saddle(
    island: MovingIsland,
    scales: Scales,
    start: LevelPoint,
    guess: Array,
    *,
    limit: float = np.inf,
    cut_first: bool = False,
) -> tuple[LevelPoint, LevelPoint]:
    """The highest saddle on the way from a minimum to its copy, and the lowest minimum passed.

    A band is laid along `guess`, of shape (n, m, 3), and cut at every minimum it passes; with `cut_first` `guess` is
    cut before that. Every saddle counted has been left on both sides for the two minima it joins. The saddle is
    `start` itself where the way stays level. A way is left at the first saddle as high as `limit`. Raises InputError
    where a saddle is not found.
    """
    highest = lowest = start
    todo = [_Piece(start, guess, replace(start, points=guess[-1]), slack=not cut_first)]
    height = None
    for _ in range(_MOST_PIECES):
        if not todo:
            return highest, lowest
        piece = todo.pop()
        band = _spaced(piece.path, scales, piece.tries)
        if piece.slack:
            band = _relaxed(island, scales, start.stiffest, band, piece.tries)
        profile = _profile(island, band)
        top = int(profile.energies.argmax())
        height = profile.energies[top] - start.energy if height is None else height
        if height <= scales.noise or profile.energies[top] < highest.energy - _SHORT * (highest.energy - start.energy):
            continue
        chain = _chain(island, scales, piece, profile, 0.02 * height + scales.noise)
        lowest = min(lowest, *(point for point, _ in chain), key=lambda point: point.energy)
        if len(chain) > 2 or not piece.slack:
            todo += [_Piece(first, profile.part(first, i, k, last), last) for (first, i), (last, k) in pairwise(chain)]
            continue
        saddle = settle(island, scales, profile.places[top], 1)
        # the profile may be a little too low between images
        lower = saddle is None or saddle.energy <= highest.energy
        if lower and profile.energies[top] < highest.energy - scales.noise:
            continue
        rest = None
        if saddle is not None and saddle.ways_down == 1:
            if saddle.energy >= limit:
                return saddle, lowest
            push = 0.2 * scales.radian * saddle.modes[:, 0].reshape(-1, 3)
            push *= np.sqrt(len(push)) / max(1.0, np.abs(push).max())
            sides = [relax(island, scales, saddle.points + sign * push, saddle.stiffest) for sign in (1.0, -1.0)]
            rest = _rest(scales, piece, profile, top, saddle, sides)
        if saddle is not None and rest is not None:
            highest = max(highest, saddle, key=lambda point: point.energy)
            todo += rest
        elif piece.tries < _MOST_TRIES:
            todo.append(replace(piece, path=band, tries=piece.tries + 1))
        else:
            break
    raise InputError(
        "atoms: the elastic band between two minima finds no saddle; atoms that hold together more stiffly, fewer of "
        "them, or rigid=True may help"
    )


def _rest(
    scales: Scales, piece: _Piece, profile: "_Profile", top: int, saddle: LevelPoint, sides: list[LevelPoint]
) -> list[_Piece] | None:
    """What remains of a piece once a saddle joins the minima `sides`; None where it lies off the piece."""
    if _apart(saddle.points, profile.places[top]) > 2.0 * scales.radian:
        return None
    ends = piece.first.points, piece.last.points
    before, after = min(
        (sides, sides[::-1]), key=lambda pair: _apart(pair[0].points, ends[0]) + _apart(pair[1].points, ends[1])
    )
    rest = []
    if _apart(before.points, ends[0]) > _SAME * scales.radian:
        rest.append(_Piece(piece.first, profile.part(piece.first, 0, top, before), before, piece.tries + 1))
    if _apart(after.points, ends[1]) > _SAME * scales.radian:
        path = profile.part(after, top, len(profile.places) - 1, piece.last)
        rest.append(_Piece(after, path, piece.last, piece.tries + 1))
    return rest


def _chain(
    island: MovingIsland, scales: Scales, piece: _Piece, profile: "_Profile", depth: float
) -> list[tuple[LevelPoint, int]]:
    """Minima that the band passes, its ends among them, and where; no two the same."""
    chain = [(piece.first, 0)]
    ends = [(relax(island, scales, profile.places[k], piece.first.stiffest), k) for k in profile.valleys(depth)]
    for point, place in [*ends, (piece.last, len(profile.places) - 1)]:
        same = [k for k, (known, _) in enumerate(chain) if _apart(known.points, point.points) < _SAME * scales.radian]
        if same:
            # a loop, which leads nowhere
            del chain[same[0] + 1 :]
        else:
            chain.append((point, place))
    return chain


def _apart(one: Array, other: Array) -> float:
    """How far the atom that moves farthest is from one place to another."""
    return float(np.linalg.norm(one - other, axis=-1).max())


def _widest(band: Array) -> float:
    return float(np.linalg.norm(np.diff(band, axis=0), axis=-1).max())


def _spaced(band: Array, scales: Scales, finer: int) -> Array:
    """The same path with as many images as it needs, even by its farthest atom; ends kept."""
    lengths = np.linalg.norm(np.diff(band, axis=0), axis=-1).max(axis=-1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    count = max(_LEAST_IMAGES, int(np.ceil(along[-1] / (_SPACING * scales.radian)))) + 2 * finer
    if count > _MOST_IMAGES:
        raise InputError(f"atoms: the elastic band needs over {_MOST_IMAGES} images; take fewer atoms or rigid=True")
    places = np.linspace(0.0, along[-1], count + 1)
    flat = band.reshape(len(band), -1)
    return np.column_stack([np.interp(places, along, column) for column in flat.T]).reshape(count + 1, *band.shape[1:])


def _relaxed(island: MovingIsland, scales: Scales, stiffest: float, band: Array, tries: int) -> Array:
    """The band after ASE's NEB has let it slip off the heights, as low as it came."""
    images = [island.image(points) for points in band]
    energies = [image.get_potential_energy() for image in images]
    height = max(energies) - min(energies[0], energies[-1])
    if height <= scales.noise:
        return band
    neb = NEB(images, k=0.2 * stiffest, method="improvedtangent")
    pace = 1.0 / np.sqrt(stiffest)
    reach = 0.3 * scales.radian * np.sqrt(band[..., 0].size)
    enough = _LOOSE * _TIGHTER**tries * min(scales.force, height / scales.radian)
    optimizer = FIRE(neb, logfile=None, dt=0.2 * pace, dtmax=0.5 * pace, maxstep=reach)
    best, least = band, np.inf
    for done in optimizer.irun(fmax=enough, steps=_MOST_STEPS * (1 + tries)):
        top = max(image.get_potential_energy() for image in images)
        if done or top < least:
            best, least = np.array([image.positions for image in images]), top
    return best


@dataclass(frozen=True)
class _Profile:
    """Energies along a band, cubic between images by the forces there, and the points they belong to."""

    places: Array
    energies: Array

    def part(self, first: LevelPoint, begin: int, end: int, last: LevelPoint) -> Array:
        """The path from one place to another, its ends put into minima."""
        return np.concatenate([first.points[None], self.places[begin + 1 : end], last.points[None]])

    def valleys(self, depth: float) -> list[int]:
        """Places lower by `depth` than the highest on either side of them, one between two such heights."""
        found: list[int] = []
        energies = self.energies
        low, top = 0, 0  # deepest since the last height, height before it
        for k in range(1, len(energies)):
            if energies[k] > energies[low] + depth:
                if energies[low] < energies[top] - depth:
                    found.append(low)
                    top = low = k
                elif energies[k] > energies[top]:
                    top = low = k
            elif energies[k] < energies[low]:
                low = k
        return [k for k in found if k > 0]


def _profile(island: MovingIsland, band: Array) -> _Profile:
    values = [island.evaluate(points) for points in band]
    t = np.arange(_SAMPLES) / _SAMPLES
    places, energies = [], []
    for k, step in enumerate(np.diff(band, axis=0)):
        (low, force), (high, next_force) = values[k], values[k + 1]
        a, b = -(force * step).sum(), -(next_force * step).sum()
        cubic = low * (1 + 2 * t) * (1 - t) ** 2 + high * t**2 * (3 - 2 * t) + a * t * (1 - t) ** 2 - b * t**2 * (1 - t)
        energies.append(cubic)
        places.append(band[k] + t[:, None, None] * step)
    return _Profile(np.concatenate([*places, band[-1:]]), np.append(np.concatenate(energies), values[-1][0]))
