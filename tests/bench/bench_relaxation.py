"""Barriers of 1,000 random islands by ASE's relaxation and elastic bands, against the closed form.

Run: python tests/bench/bench_relaxation.py
"""

import time

import numpy as np

import origins

ISLANDS = 1000


def main() -> None:
    rng = np.random.default_rng(7)
    calculator = origins.substrate_calculator(origins.square_substrate())
    off, promised, evaluations, atoms = (np.empty(ISLANDS) for _ in range(4))
    began = time.perf_counter()
    for case in range(ISLANDS):
        a, angle = float(rng.uniform(1.5, 7.0)), float(rng.uniform(0.0, 2.0 * np.pi))
        n_i, n_j = (int(n) for n in rng.integers(1, 21, 2))
        island = origins.triangular_island(a, n_i, n_j)
        island.rotate(np.degrees(angle), "z", center="COM")
        found = origins.relaxed_barrier(island, calculator)
        off[case] = abs(found.barrier - origins.triangular_barrier(a, n_i, n_j, angle))
        promised[case], evaluations[case], atoms[case] = found.barrier_error, found.evaluations, len(island)
    took = (time.perf_counter() - began) / ISLANDS
    beyond = int((off > promised).sum())
    print(f"{ISLANDS} islands of {atoms.mean():.0f} atoms: off by {off.max():.1e}, {beyond} beyond the estimate")
    print(f"{took * 1e3:.0f} ms and {evaluations.mean():.0f} evaluations each")


if __name__ == "__main__":
    main()
