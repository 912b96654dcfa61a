"""What tests of solvers share: paths, an answer held to its claim, quadrature by Gauss nodes, the same bits."""

import dataclasses
from collections.abc import Iterable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import eq_model
import master
import origins

Array = npt.NDArray[np.float64]
# After so many seconds a solver that would not end has failed; the slowest of the slow tests solve for some 200.
WALL_TIME = 300.0


def through(corners: Iterable[float], points: int) -> Array:
    """A path from corner to corner, `points` to each straight piece."""
    at = list(corners)
    return np.concatenate([at[:1], *[np.linspace(a, b, points)[1:] for a, b in pairwise(at)]])


def held_to_claim(
    contacts: origins.Contacts,
    path: npt.ArrayLike,
    tolerance: float,
    exact: Any,
    more: float = 0.0,
    **drive: Any,
) -> master.Solution:
    """Solve, and compare the force with what it should be: success, within the error claimed.

    exact : forces at the path, or a solution of its own, whose claim is granted
    more : what the reference may be off by, lengths
    """
    found = master.solve(contacts, path, tolerance, wall_time=WALL_TIME, **drive)
    assert found.success, found.message
    force, granted = exact, 0.0
    if hasattr(exact, "force_error"):
        force, granted = exact.force, exact.force_error
    allowed = (found.force_error + granted) * contacts.mean_threshold + more
    assert np.abs(found.force - force).max() <= allowed
    assert found.force_error <= tolerance
    return found


def gauss(edges: npt.ArrayLike, count: int = 20) -> tuple[Array, Array]:
    """Nodes and weights of Gauss and Legendre, so many on each piece between edges."""
    ends = np.asarray(edges, float)
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = 0.5 * np.diff(ends)[:, None]
    return (ends[:-1, None] + half * (nodes + 1.0)).ravel(), (half * weights).ravel()


def oscillator(t: Array, spring: float, mass: float, damping: float) -> tuple[Array, float]:
    """X of a slider from rest at times t while nothing breaks and the drive's speed is 1, in closed form by the roots
    of m r² + c r + S = 0; and the largest |r|."""
    stiff = spring + 1.0
    drift = spring / stiff
    roots = one, two = np.roots([mass, damping, stiff]).astype(complex)
    lag = damping * drift / stiff
    first = (-drift - two * lag) / (one - two)
    x = drift * t - lag + (first * np.exp(one * t) + (lag - first) * np.exp(two * t)).real
    return x, float(np.abs(roots).max())


CLOCKS = ("run_time", "compile_time", "breaks_per_rank")  # what no two runs have in common


def same_bits(one: Any, other: Any, *but: str) -> None:
    """Two records of a solver are the same but for clocks and `but`, records within them and lists of these too."""
    for field in dataclasses.fields(one):
        mine, yours = getattr(one, field.name), getattr(other, field.name)
        if field.name in (*CLOCKS, *but):
            continue
        if dataclasses.is_dataclass(mine):
            same_bits(mine, yours)
        elif isinstance(mine, dict):
            assert {name: np.asarray(own).tolist() for name, own in mine.items()} == {
                name: np.asarray(own).tolist() for name, own in yours.items()
            }
        elif field.name == "histograms":
            for first, second in zip(mine, yours, strict=True):
                same_bits(first, second)
        else:
            assert np.array_equal(mine, yours, equal_nan=isinstance(mine, np.ndarray)), field.name


class FirstSlip(NamedTuple):
    """The force along a path, and of its only slip X_T, the forces before and after it and the duration, all in one
    array of shape (n + 4,); and their errors."""

    value: Array
    error: Array

    def apart(self, other: "FirstSlip") -> float:
        """How far the two differ at most, in both errors."""
        off = np.abs(self.value - other.value) / np.hypot(self.error, other.error)
        return float(off.max())


# the slip's numbers, as both solvers name them
OF_SLIP = "drive", "force_before", "force_after", "duration"


def first_slip_of_contacts(
    contacts: origins.Contacts, path: npt.ArrayLike, **drive: Any
) -> FirstSlip:
    """By the ensemble, from 4,000 and 32,000 contacts extrapolated to infinitely many, as N^(-2/3)."""
    runs = [
        eq_model.simulate(contacts, path, n_contacts=n, n_replicas=replicas, seed=1, **drive)
        for n, replicas in ((4_000, 60), (32_000, 20))
    ]
    slips = np.array([[one.slips.mean(name, 0) for name in OF_SLIP] for one in runs])
    rows = np.array([[one.force, one.force_standard_error] for one in runs]).transpose(0, 2, 1)
    many = np.concatenate([rows, slips], axis=1)
    first, second = 4_000.0 ** (-2 / 3), 32_000.0 ** (-2 / 3)
    weights = np.array([-second, first]) / (first - second)
    return FirstSlip(weights @ many[..., 0], np.hypot(*(weights[:, None] * many[..., 1])))


def first_slip_of_master(
    contacts: origins.Contacts, path: npt.ArrayLike, tolerance: float, **drive: Any
) -> FirstSlip:
    """By the master equation, with its claims."""
    solved: Any = master.solve(contacts, path, tolerance, **drive)
    assert solved.success and solved.slips.drive.size == 1
    slip = [getattr(solved.slips, name)[0] for name in OF_SLIP]
    claim = np.full(solved.force.size + len(slip), solved.force_error)
    claim[[-4, -1]] = solved.slips.drive_error, solved.slips.duration_error
    return FirstSlip(np.r_[solved.force, slip], claim)
