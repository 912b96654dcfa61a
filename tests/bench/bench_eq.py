"""Speed of the ensemble: nanoseconds per break, against the paper's own algorithm. Run: python tests/bench/bench_eq.py

Run times are wall clock, tables included, compilation not; the best of three, so run it on an idle machine.
"""

import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from numba import njit

import eq_model
import origins
from eq_model.closest import closest, draw_start

ORIGINS = {
    "gaussian, std 0.05": origins.gaussian(mean=1.0, std=0.05),
    "rectangular 0.5-1.5": origins.rectangular(0.5, 1.5),
    "gw_elastic (Weibull 4/3)": origins.gw_elastic(1.0),
    "lubricated": origins.lubricated(1.0),
    "unequal mixture, gap": origins.mixture(
        [origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7]
    ),
}
CONTACTS = 10_000  # of the paper's algorithm
SHARED = """
from mpi4py import MPI
import numpy as np, eq_model, origins
contacts = origins.Contacts(origins.gaussian(mean=1.0, std=0.05))
run = [eq_model.simulate(contacts, np.linspace(0.0, 100.0, 501), n_contacts=2_000_000, comm=MPI.COMM_WORLD)
       for _ in range(3)]
if MPI.COMM_WORLD.Get_rank() == 0:
    print(min(r.run_time for r in run))
"""


def per_break(thresholds: origins.Thresholds, length: float, n_contacts: int, start: object = None) -> float:
    """Nanoseconds per break on 501 points to length mean thresholds, one core, best of three."""
    contacts = origins.Contacts(thresholds, start=start)
    path = np.linspace(0.0, length * contacts.mean_threshold, 501)
    runs = [eq_model.simulate(contacts, path, n_contacts=n_contacts) for _ in range(3)]
    return min(run.run_time for run in runs) / runs[0].breaks * 1e9


@njit
def paper_algorithm(x, gap, fresh):  # type: ignore[no-untyped-def]
    """The paper's algorithm compiled: one break for each fresh threshold; the mean stretch at the end."""
    for threshold in fresh:
        closest_one, step = 0, gap[0]
        for i in range(gap.size):
            if gap[i] < step:
                closest_one, step = i, gap[i]
        for i in range(gap.size):
            x[i] += step
            gap[i] -= step
        x[closest_one], gap[closest_one] = 0.0, threshold
    return x.mean()


def paper_compiled(thresholds: origins.Thresholds, breaks: int = 20_000) -> float:
    """Nanoseconds per break of the paper's algorithm compiled with numba."""
    generator = np.random.default_rng(0)
    best = np.inf
    for count in (10, breaks, breaks):
        x, gap = draw_start(origins.Contacts(thresholds), CONTACTS, generator)
        fresh = thresholds.rvs(count, generator)
        started = time.perf_counter()
        paper_algorithm(x, gap, fresh)
        if count > 10:
            best = min(best, time.perf_counter() - started)
    return best / breaks * 1e9


def paper_numpy(thresholds: origins.Thresholds) -> float:
    """Nanoseconds per break of the plain twin, eq_model.closest."""
    started = time.perf_counter()
    _, breaks = closest(origins.Contacts(thresholds), 0.98, n_contacts=CONTACTS)
    return (time.perf_counter() - started) / breaks * 1e9


def two_ranks() -> float | None:
    """Throughput of two ranks over that of one, or None where there is no mpiexec."""
    beside = Path(sys.executable).with_name("mpiexec")
    launcher = str(beside) if beside.exists() else shutil.which("mpiexec")
    if launcher is None:
        return None
    times = []
    for ranks in (1, 2):
        command = [launcher, "-n", str(ranks), sys.executable, "-c", SHARED]
        times.append(float(subprocess.run(command, capture_output=True, text=True, check=True).stdout))
    return times[0] / times[1]


def laws() -> None:
    """Contacts with laws of their own, X = 100, and what a life costs where it is followed by itself."""
    fresh, path = origins.gaussian(mean=1.0, std=0.05), np.linspace(0.0, 100.0, 501)
    soft, stiff = (origins.Thermal(law, 0.05) for law in ("soft", "stiff"))
    ageing = origins.Ageing(origins.gaussian(1.2, 0.05), rate=1e-3)
    turning = np.concatenate([np.linspace(0.0, 50.0, 251), np.linspace(50.0, 0.0, 251)])
    print(f"\n{'ns per break, one core':28s}{'X = 100':>10s}{'inner steps per break':>25s}")
    for name, contacts, way, count in (
        ("soft contacts", origins.Contacts(fresh, thermal=soft), path, 1_000_000),
        ("stiff contacts", origins.Contacts(fresh, thermal=stiff), path, 1_000_000),
        ("delay", origins.Contacts(fresh, delay=origins.Delay(0.2)), path, 300_000),
        ("linked, soft, re-forming", origins.Contacts(fresh, None, soft, None, None, 0.1, "linked"), path, 100_000),
        ("turning, soft", origins.Contacts(fresh, thermal=soft), turning, 100_000),
        ("ageing", origins.Contacts(fresh, ageing=ageing), path, 10_000),
    ):
        best, steps = np.inf, 0.0
        for _ in range(3):
            ensemble = eq_model.Ensemble(contacts, way, n_contacts=count)
            for _ in ensemble:
                pass
            run = ensemble.result()
            best, steps = min(best, run.run_time / run.breaks * 1e9), ensemble.state.steps / run.breaks
        print(f"{name:28s}{best:10.1f}{steps:25.1f}")


def main() -> None:
    """Print the tables."""
    start = origins.gaussian_start(mean=0.0, std=0.025)
    print(f"{'ns per break, one core':28s}{'X = 100':>10s}{'X = 5':>10s}{'X = 5, Gaussian start':>25s}")
    hundred = []
    for name, law in ORIGINS.items():
        hundred.append(per_break(law, 100.0, 3_000_000))
        short, begun = per_break(law, 5.0, 4_000_000), per_break(law, 5.0, 4_000_000, start)
        print(f"{name:28s}{hundred[-1]:10.2f}{short:10.2f}{begun:25.2f}")
    print(f"worst at X = 100: {max(hundred):.2f}")
    laws()
    law = ORIGINS["gaussian, std 0.05"]
    compiled, plain = paper_compiled(law), paper_numpy(law)
    print(f"\nthe paper's algorithm, {CONTACTS} contacts, Gaussian: compiled {compiled:.0f} ns per break, ", end="")
    print(f"{compiled / hundred[0]:.0f} times the ensemble; numpy {plain:.0f}, {plain / hundred[0]:.0f} times")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    run = eq_model.simulate(origins.Contacts(law), np.linspace(0.0, 100.0, 501), n_contacts=10_100_000)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(f"{run.breaks:.3g} breaks in one call: {run.run_time:.2f} s, peak memory grown by {grown / 1024:.1f} MB")
    speedup = two_ranks()
    print("two ranks: no mpiexec here" if speedup is None else f"two ranks: {speedup:.2f} times the throughput of one")


if __name__ == "__main__":
    main()
