"""Structure factors: closed geometric sums against sums over atoms in long precision, 1 atom to 10^7."""

import numpy as np
import pytest

import origins
from origins.domains.structure_factors import (
    structure_factors,
    triangular_structure_factors,
)

LONG = np.longdouble
COMMENSURATE = [2 * np.pi, 4 * np.pi, np.pi, 4 * np.pi / np.sqrt(3.0), 2 * np.pi / np.sqrt(3.0)]


def atom_by_atom(a: float, n_i: int, n_j: int, angle: float, wavevectors: np.ndarray) -> np.ndarray:
    """The sum over the atoms of the paper's island about their centre, in long precision."""
    j = np.repeat(np.arange(n_j), n_i)
    i = np.tile(np.arange(n_i), n_j) - j // 2
    x, y = (i + LONG(0.5) * j) * LONG(a), j * (LONG(a) * np.sqrt(LONG(3)) / 2)
    x, y = x - x.mean(), y - y.mean()
    cos, sin = np.cos(LONG(angle)), np.sin(LONG(angle))
    phases = [g[0] * (cos * x - sin * y) + g[1] * (sin * x + cos * y) for g in wavevectors]
    return np.array([complex(np.cos(phase).sum(), np.sin(phase).sum()) for phase in phases])


def row_by_row(a: float, n_i: int, n_j: int, angle: float) -> np.ndarray:
    """The same for sin x + sin y as a sum over one row times a sum over rows, for islands of very many atoms."""
    cos, sin = np.cos(LONG(angle)), np.sin(LONG(angle))
    h = LONG(a) * np.sqrt(LONG(3)) / 2
    i, j = np.arange(n_i) - LONG(n_i - 1) / 2, np.arange(n_j) - LONG(n_j - 1) / 2
    shift = LONG(0.5) * (np.arange(n_j) % 2)
    shift = shift - shift.mean()
    found = []
    for along, up in ((cos, -sin), (sin, cos)):
        row = np.exp(1j * (along * LONG(a) * i)).sum()
        found.append(complex(row * np.exp(1j * (along * LONG(a) * shift + up * h * j)).sum()))
    return np.array(found)


def test_a_thousand_random_islands() -> None:
    rng = np.random.default_rng(0)
    square = np.eye(2)
    for case in range(1000):
        a = rng.choice(COMMENSURATE) if case % 5 == 0 else rng.uniform(0.1, 20.0)
        n_i, n_j = (int(n) for n in rng.integers(1, 60, 2))
        angle = (
            rng.choice([0.0, np.pi / 6, np.pi / 2, np.pi])
            if case % 3 == 0
            else rng.uniform(-10.0, 10.0)
        )
        waves = rng.normal(size=(3, 2)) if case % 2 else square
        expected = atom_by_atom(a, n_i, n_j, angle, waves)
        closed = triangular_structure_factors(a, n_i, n_j, angle, waves)
        assert np.abs(closed - expected).max() < 1e-12 * n_i * n_j
        if case % 10 == 0:
            summed = structure_factors(origins.triangular_island(a, n_i, n_j), angle, waves)
            assert np.abs(summed - expected).max() < 1e-12 * n_i * n_j


@pytest.mark.parametrize(
    "a, n_i, n_j, angle",
    [
        (2.5, 3162, 3163, 0.3),
        (2 * np.pi, 3162, 3163, 0.0),
        (4 * np.pi / np.sqrt(3.0), 1, 10**6, 0.0),
    ],
)
def test_ten_million_atoms(a: float, n_i: int, n_j: int, angle: float) -> None:
    expected = row_by_row(a, n_i, n_j, angle)
    closed = triangular_structure_factors(a, n_i, n_j, angle)
    # at 10^6 in a row the last bit of a alone is worth 1e-16 of a phase of 6e6
    assert np.abs(closed - expected).max() < 1e-12 * n_i * n_j * max(1.0, max(n_i, n_j) / 1e4)


def test_shapes_broadcast() -> None:
    n_i, angle = np.array([[3], [4]]), np.array([0.1, 0.2, 0.3])
    factors = triangular_structure_factors(
        2.5, n_i, 5, angle, [[1.0, 0.0], [0.3, 0.2], [0.0, 2.0], [0.0, 0.0]]
    )
    assert factors.shape == (2, 3, 4)
    assert factors[1, 2, 1] == pytest.approx(
        triangular_structure_factors(2.5, 4, 5, 0.3, [[0.3, 0.2]])[0], rel=1e-13
    )
    np.testing.assert_allclose(factors[..., 3], n_i * 5.0 + 0j * angle, rtol=1e-15)
    island = origins.triangular_island(2.5, 4, 5)
    summed = structure_factors(island, [[0.1, 0.2], [0.3, 0.4]])
    assert summed.shape == (2, 2, 2) and structure_factors(island, 0.3).shape == (2,)
    np.testing.assert_allclose(summed[1, 0], structure_factors(island, 0.3), rtol=1e-13)
