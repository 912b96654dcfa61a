"""The barrier an island must climb to move on, by ASE: relaxation and nudged elastic bands, for any calculator.

Where the closed form of a rigid island (triangular_barrier) or the exact search on a Fourier substrate (barrier)
holds, this is a second road to the same number; for other calculators and for flexible islands it is the only one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.domains.energy_map import SIZES, EnergyMap, Way, energy_map
from origins.errors import InputError, refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

    from origins.domains.level_points import LevelPoint, Scales
    from origins.domains.moving_island import MovingIsland

_MOST_FLEXIBLE = 1500
_DISC = 1.0  # steps of the map around a saddle
_KNOWN = 1e-9  # saddles nearer in energy than this are taken for one
_STEPS = ((1, 0), (0, 1), (1, 1), (1, -1))  # periods that straight bands lead over
_LONG = 1.2  # against the longer period
_LEVELS = 64  # places along a period
_SHAKE = 0.02  # radians
_MOST_MINIMA = 10


@dataclass(frozen=True, eq=False)
class RelaxedBarrier:
    """What relaxed_barrier found.

    Attributes
    ----------
    barrier : float
        Energy of the saddle above the minimum, at least zero.
    barrier_error : float
        How far it may be off by forces that remain and by rounding; it does not know of ways that were not found.
    minimum, saddle : ase.Atoms
        Copies of the atoms there, with their energy and forces.
    evaluations : int
        Calls of the calculator.
    run_time : float
        Seconds.
    """

    barrier: float
    barrier_error: float
    minimum: ase.Atoms
    saddle: ase.Atoms
    evaluations: int
    run_time: float


def relaxed_barrier(
    atoms: ase.Atoms,
    calculator: Any,
    *,
    rigid: bool = True,
    planar: bool = True,
    periods: npt.ArrayLike | None = None,
) -> RelaxedBarrier:
    """Lowest energy an island must climb to leave its lowest minimum for a copy of it, one period or more away.

    Parameters
    ----------
    atoms : ase.Atoms
        The island, turned as it shall stand (atoms.rotate). Atoms that FixAtoms holds are not part of it but of its
        surroundings, such as a slab. Left as they are.
    calculator : ASE calculator
        Energy and forces of all atoms: substrate_calculator, any other, or ASE's SumCalculator of several. Its units
        are those of the result.
    rigid : bool
        True moves the island as a whole, without turning it. False lets every atom move; the calculator must then
        hold the island together. Its orientation is held as by the crystal around it: sum_i r_i0 x u_i = 0, r_i0
        the atoms as given about their centre, u_i their displacements along the plane.
    planar : bool
        True keeps all heights z; False lets them follow the forces.
    periods : array of shape (2, 2)
        Two translations along x and y that change no energy. When left out: those a substrate_calculator knows, also
        within a SumCalculator; else the cell vectors of the atoms along which they are periodic.

    Energies are in the unit of the calculator, lengths in that of the atoms. For a rigid planar island a map of one
    cell shows where the lowest minimum and the lowest ways lie, and every way it tells apart that could be lower is
    tried. Otherwise minima are sought from 17 places and bands are laid along up to five ways: the barrier holds for
    the lowest found.

    With its atoms free both the minimum and the saddle of an island lie no higher than those of the rigid one, as its
    paths hold the rigid ones; the barrier, their difference, may lie on either side.

    Raises InputError for input that cannot be used and where no band settles, RuntimeError where forces do not vanish.
    """
    started = perf_counter()
    for name, value in (("rigid", rigid), ("planar", planar)):
        if not isinstance(value, bool):
            refuse(name, value, "must be True or False")
    for method in ("get_positions", "constraints", "cell"):
        if not hasattr(atoms, method):
            refuse("atoms", atoms, "must be an ase.Atoms, such as origins.triangular_island(2.5, 10, 9)")
    if not hasattr(calculator, "get_forces"):
        shown = type(calculator).__name__
        refuse("calculator", shown, "must be an ASE calculator, such as origins.substrate_calculator(substrate)")
    if len(atoms) == 0 or not np.isfinite(atoms.get_positions()).all():
        refuse("atoms", atoms, "must hold at least one atom, all at finite positions")
    from origins.domains.moving_island import MovingIsland

    cell = _periods(atoms, calculator, periods)
    slider = MovingIsland(atoms, calculator, rigid=True, planar=True)
    if not rigid and len(slider.moving) > _MOST_FLEXIBLE:
        refuse("atoms", atoms, f"may hold at most {_MOST_FLEXIBLE} atoms that move by themselves; take rigid=True")
    scales = _scales(slider, cell)
    island = slider if rigid and planar else MovingIsland(atoms, calculator, rigid, planar)
    found, least = None, SIZES[0]
    while found is None:
        if least > SIZES[-1]:
            raise RuntimeError("bands lead higher than the finest map they were laid on: a defect of this program")
        chart = energy_map(cell, lambda shift: _moved(slider, shift), scales.noise, least)
        scales = replace(scales, radian=chart.radian)
        found = _rigid(slider, scales, chart) if island is slider else _free(island, scales, chart)
        least = 2 * len(chart.energies)
    minimum, saddle = found
    height = saddle.energy - minimum.energy
    lowest, highest = island.atoms_at(minimum.points), island.atoms_at(saddle.points)
    calls = island.evaluations + (0 if island is slider else slider.evaluations)
    off = float(minimum.error + saddle.error)
    return RelaxedBarrier(max(float(height), 0.0), off, lowest, highest, calls, perf_counter() - started)


def _periods(atoms: ase.Atoms, calculator: Any, given: npt.ArrayLike | None) -> Array:
    if given is None:
        found = _known_periods(calculator)
        if found is None:
            cell = np.asarray(atoms.cell)[np.asarray(atoms.pbc)]
            flat = cell[np.abs(cell[:, 2]) <= 1e-9 * np.linalg.norm(cell, axis=1)][:, :2]
            found = flat if len(flat) == 2 else None
        if found is None:
            refuse("periods", None, "must be given, such as [[2.5, 0.0], [0.0, 2.5]]: no atoms or calculator tell")
        given = found
    try:
        periods: Array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        periods = np.empty(0)
    right = periods.shape == (2, 2) and np.isfinite(periods).all()
    if not right or not abs(np.linalg.det(periods)) > 1e-6 * (periods**2).sum():
        refuse("periods", given, "must be two vectors that are not parallel, such as [[2.5, 0.0], [0.0, 2.5]]")
    return periods


def _known_periods(calculator: Any) -> Array | None:
    """Periods of the calculator or of one within a sum of calculators."""
    if hasattr(calculator, "periods"):
        return np.asarray(calculator.periods)
    parts = getattr(getattr(calculator, "mixer", None), "calcs", ())
    known = [found for found in map(_known_periods, parts) if found is not None]
    if len(known) > 1 and any(found.shape != known[0].shape or (found != known[0]).any() for found in known[1:]):
        refuse("periods", None, "must be given, as the parts of the calculator have different ones")
    return known[0] if known else None


def _moved(slider: MovingIsland, shift: Array) -> tuple[float, Array]:
    energy, forces = slider.evaluate(slider.points + _flat(shift))
    return energy, forces[0, :2]


def _scales(slider: MovingIsland, periods: Array) -> Scales:
    from origins.domains.level_points import Scales

    places = [np.array([i + 0.37, j + 0.21]) / 3.0 @ periods for i in range(3) for j in range(3)]
    energies = [_moved(slider, place)[0] for place in places]
    force = slider.strongest
    if force == 0.0:
        refuse("calculator", "no force anywhere", "must give forces that change as the island moves")
    radian = float(np.linalg.norm(periods, axis=1).min() / (2.0 * np.pi))
    count, far = len(slider.moving), float(np.abs(slider.reach).max())
    eps = float(np.finfo(float).eps)
    noise = 8.0 * eps * (np.abs(energies).max() + count * force * (radian + far))
    for period in periods:
        off = max(abs(_moved(slider, place + period)[0] - was) for place, was in zip(places, energies, strict=True))
        if off > 1e-9 * force * radian + 4.0 * noise:
            shown = f"({period[0]:.6g}, {period[1]:.6g})"
            refuse("periods", periods, f"must leave energies as they are; moved by {shown} they change by {off:.2g}")
    return Scales(radian, force, noise)


def _rigid(slider: MovingIsland, scales: Scales, chart: EnergyMap) -> tuple[LevelPoint, LevelPoint] | None:
    """The lowest minimum, and the saddle of the lowest way; ways are closed one by one until none can be lower.

    None where a band strays from the way it was laid on: the map is too coarse for that.
    """
    from origins.domains.elastic_band import highest_saddle
    from origins.domains.level_points import level_place, relax, settle, stiffest

    if np.ptp(chart.energies) <= scales.noise:
        point = level_place(slider, scales, slider.points)
        return point, point
    starts = [slider.points + _flat(chart.displacements(node)) for node in chart.valleys()]
    minimum = min((relax(slider, scales, start, stiffest(slider, scales, start)) for start in starts), key=_energy)
    for step in np.array(_STEPS) @ chart.periods:
        if (ends := _channel(slider, scales, minimum, _flat(step))) is not None:
            return ends
    node = chart.nearest((minimum.points - slider.points)[0, :2])
    blocked = np.zeros(chart.energies.shape, dtype=bool)
    best: LevelPoint | None = None
    for _ in range(chart.energies.size):
        way = chart.lowest_way(node, blocked)
        if way is None or (best is not None and way.level - chart.margin >= best.energy):
            break
        path = slider.points + _flat(chart.displacements(way.nodes))
        top = path[chart.energies[tuple(way.nodes.T % len(chart.energies))].argmax()]
        # a saddle known already to be no lower needs no band
        saddle = None if best is None else settle(slider, scales, top[None], 1)
        if best is not None and saddle is not None and saddle.ways_down == 2 and saddle.energy >= best.energy:
            # over a peak between places closed already: no way of its own
            blocked |= chart.disc((top - slider.points[0])[:2], _DISC)
            continue
        if (
            best is None
            or saddle is None
            or saddle.ways_down != 1
            or saddle.energy < best.energy - _KNOWN * scales.energy
        ):
            guess = _between(minimum, path, _copy(chart, way))
            found, _ = highest_saddle(slider, scales, minimum, guess, cut_first=True)
            if found is minimum:
                return minimum, minimum
            if found.energy > way.level + chart.margin:
                return None
            saddle = found
            if best is None or saddle.energy < best.energy:
                best = saddle
        for place in (top, saddle.points[0]):
            blocked |= chart.disc((place - slider.points[0])[:2], _DISC)
    if best is None:
        raise RuntimeError("no way leads out of a minimum: a defect of this program")
    return minimum, best


def _channel(
    slider: MovingIsland, scales: Scales, minimum: LevelPoint, period: Array
) -> tuple[LevelPoint, LevelPoint] | None:
    """The lowest and the highest point along one period, where they differ by so little that forces tell no way."""
    from origins.domains.level_points import flattest

    flat = flattest(slider, scales) * scales.radian**2
    places, energies = [minimum.points], [minimum.energy]
    for t in np.arange(1, _LEVELS) / _LEVELS:
        places.append(minimum.points + t * period)
        energies.append(slider.evaluate(places[-1])[0])
        if energies[-1] > minimum.energy + flat:
            return None
    low, high = int(np.argmin(energies)), int(np.argmax(energies))
    error = scales.noise + 0.01 * (energies[high] - energies[low])  # of a wave between two of the places
    one, other = (replace(minimum, points=places[k], energy=energies[k], error=error) for k in (low, high))
    return one, other


def _free(island: MovingIsland, scales: Scales, chart: EnergyMap) -> tuple[LevelPoint, LevelPoint]:
    """The lowest minimum found from 16 places and along the bands, and the lowest saddle of five bands."""
    from origins.domains.elastic_band import highest_saddle
    from origins.domains.level_points import relax, stiffest

    n = len(chart.energies)
    nodes = [chart.valleys()[0], *((i, j) for i in range(0, n, n // 4) for j in range(0, n, n // 4))]
    starts = [island.points + _flat(chart.displacements(node)) for node in nodes]
    steep = stiffest(island, scales, starts[0])
    minimum = min((relax(island, scales, start, steep) for start in starts), key=_energy)
    shake, basis = np.random.default_rng(0), island.basis()
    for _ in range(_MOST_MINIMA):
        best: LevelPoint | None = None
        for shift in _ways_on(chart, (minimum.points - island.points).mean(axis=0)[:2]):
            path = minimum.points + _flat(shift)[:, None]
            # a band of one symmetry could not leave it
            noise = _SHAKE * scales.radian * shake.standard_normal((len(path) - 2, basis.shape[1]))
            path[1:-1] += (noise @ basis.T).reshape(-1, *path.shape[1:])
            limit = np.inf if best is None else best.energy
            saddle, lowest = highest_saddle(island, scales, minimum, path, limit=limit)
            if lowest.energy < minimum.energy - _KNOWN * scales.energy:
                minimum = lowest
                break
            if saddle.energy < limit:
                best = saddle
        else:
            assert best is not None  # the first band has no limit
            return minimum, best
    raise InputError("atoms: bands lead to ever lower minima; take rigid=True or atoms that hold together more stiffly")


def _ways_on(chart: EnergyMap, place: Array) -> list[Array]:
    """Displacements along the lowest way of the map from `place`, and straight over one period or two."""
    way = chart.lowest_way(chart.nearest(place))
    if way is None:
        raise RuntimeError("no way leads out of a minimum: a defect of this program")
    steps = np.array(_STEPS) @ chart.periods
    lengths = np.linalg.norm(steps, axis=1)
    short = lengths <= _LONG * lengths[:2].max()
    straight = [np.linspace(0.0, 1.0, 9)[:, None] * step for step in steps[short]]
    return [chart.displacements(way.nodes - way.nodes[0]), *straight]


def _energy(point: LevelPoint) -> float:
    return point.energy


def _flat(shift: Array) -> Array:
    return np.concatenate([shift, np.zeros((*shift.shape[:-1], 1))], axis=-1)


def _copy(chart: EnergyMap, way: Way) -> Array:
    return _flat(chart.displacements(way.nodes[-1] - way.nodes[0]))


def _between(minimum: LevelPoint, path: Array, shift: Array) -> Array:
    """The path (n, 3) of a centre, its ends put into the minimum and its copy; shape (n, 1, 3)."""
    path = path.copy()
    path[0], path[-1] = minimum.points[0], minimum.points[0] + shift
    return path[:, None]
