"""Speed of barriers of rigid islands, against the energy map. Run: python tests/bench/bench_domains.py

Run times are wall clock on one core, the best of three, so run it on an idle machine.
"""

import time
from collections.abc import Callable

import numpy as np

import origins

A = 2.5
GRID = 50


def best(work: Callable[[], object]) -> float:
    """Seconds, the best of three."""
    times = []
    for _ in range(3):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return min(times)


def mapped(island: object, angle: float, substrate: origins.Substrate) -> float:
    """The naive way: U on 50 x 50 points, every atom at every point; highest of each row's or column's lowest."""
    cos, sin = np.cos(angle), np.sin(angle)
    points = island.get_positions()[:, :2] @ [[cos, sin], [-sin, cos]]
    share = np.stack(np.meshgrid(*[np.arange(GRID) / GRID] * 2, indexing="ij"), axis=-1) @ substrate.cell
    energy = np.array([[substrate.energy(points + shift).sum() for shift in row] for row in share])
    return float(min(energy.min(0).max(), energy.min(1).max()) - energy.min())


def closed_sums() -> None:
    """Barriers per second by closed sums."""
    rng = np.random.default_rng(0)
    angle = rng.uniform(0.0, 2.0 * np.pi, 1_000_000)
    sizes = {
        "1 atom": (1, 1),
        "90 atoms": (10, 9),
        "1,089 atoms": (33, 33),
        "10^7 atoms": (3162, 3163),
        "sizes all different": (rng.integers(1, 3000, angle.size), rng.integers(1, 3000, angle.size)),
    }
    for name, (n_i, n_j) in sizes.items():
        seconds = best(lambda n_i=n_i, n_j=n_j: origins.triangular_barrier(A, n_i, n_j, angle))
        print(f"  {name:22}{angle.size / seconds / 1e6:8.2f} million barriers per second")


def by_atoms() -> None:
    """Microseconds per angle for an island of 1,089 atoms."""
    island, square = origins.triangular_island(A, 33, 33), origins.square_substrate()
    angle = np.linspace(0.0, 1.0, 500)
    naive = best(lambda: mapped(island, 0.3, square))
    sums = best(lambda: origins.structure_factors(island, angle)) / angle.size
    whole = best(lambda: origins.barrier(island, angle, square)) / angle.size
    print(f"  map on {GRID} x {GRID} points  {naive * 1e6:12.1f} us")
    print(f"  structure factors     {sums * 1e6:12.1f} us")
    print(f"  barrier               {whole * 1e6:12.1f} us   ({naive / whole:.0f} times faster)")
    exact = float(origins.barrier(island, 0.3, square))
    print(f"  the map's barrier is off by {abs(mapped(island, 0.3, square) / exact - 1.0):.1e} of it")


def searched() -> None:
    """Microseconds per barrier where the lowest saddle is searched for."""
    angle = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 2000)
    richer = origins.fourier_substrate(
        [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0], [2.0, 0.0], [0.0, 2.0]], [1.0, 1.0, 0.3, 0.3, 0.2, 0.2]
    )
    for name, substrate in (("three cosines", origins.hexagonal_substrate()), ("six waves", richer)):
        seconds = best(lambda substrate=substrate: origins.triangular_barrier(A, 10, 9, angle, substrate))
        print(f"  {name:22}{seconds / angle.size * 1e6:12.1f} us")


if __name__ == "__main__":
    print("closed sums, sin x + sin y:")
    closed_sums()
    print("1,089 atoms, sin x + sin y, one angle:")
    by_atoms()
    print("the lowest saddle of a general landscape, one island:")
    searched()
    law = best(lambda: origins.domains(A, mean_atoms=100.0, stiffness=1.0, samples=100_000))
    print(f"P_c of 100,000 islands: {law:.2f} s")
