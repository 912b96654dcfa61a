"""Speed of the ensemble: nanoseconds per break. Run: python tests/bench/bench_eq.py

Run times are wall clock, tables included, compilation not; the best of three, so run it on an idle machine.
"""

import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

import eq_model
import origins

ORIGINS = {
    "gaussian, std 0.05": origins.gaussian(mean=1.0, std=0.05),
    "rectangular 0.5-1.5": origins.rectangular(0.5, 1.5),
    "gw_elastic (Weibull 4/3)": origins.gw_elastic(1.0),
    "lubricated": origins.lubricated(1.0),
    "unequal mixture, gap": origins.mixture(
        [origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7]
    ),
}
SHARED = """
from mpi4py import MPI
import numpy as np, eq_model, origins
fresh, soft = origins.gaussian(mean=1.0, std=0.05), origins.Thermal("soft", 0.05)
contacts, n = {shared}
run = [eq_model.simulate(contacts, np.linspace(0.0, 100.0, 501), n_contacts=n, comm=MPI.COMM_WORLD) for _ in range(3)]
if MPI.COMM_WORLD.Get_rank() == 0:
    print(min(r.run_time for r in run))
"""


def per_break(
    thresholds: origins.Thresholds, length: float, n_contacts: int, start: object = None
) -> float:
    """Nanoseconds per break on 501 points to length mean thresholds, one core, best of three."""
    contacts = origins.Contacts(thresholds, start=start)
    path = np.linspace(0.0, length * contacts.mean_threshold, 501)
    runs = [eq_model.simulate(contacts, path, n_contacts=n_contacts) for _ in range(3)]
    return min(run.run_time for run in runs) / runs[0].breaks * 1e9


def two_ranks(shared: str) -> float | None:
    """Throughput of two ranks over that of one, or None where there is no mpiexec."""
    beside = Path(sys.executable).with_name("mpiexec")
    launcher = str(beside) if beside.exists() else shutil.which("mpiexec")
    if launcher is None:
        return None
    times = []
    for ranks in (1, 2):
        command = [launcher, "-n", str(ranks), sys.executable, "-c", SHARED.format(shared=shared)]
        times.append(
            float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        )
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
        (
            "linked, soft, re-forming",
            origins.Contacts(fresh, None, soft, None, None, 0.1, "linked"),
            path,
            100_000,
        ),
        ("turning, soft", origins.Contacts(fresh, thermal=soft), turning, 100_000),
        (
            "growing grains",
            origins.Contacts(origins.growing_grains(1.0, 1.0, age=4.0)),
            path,
            3_000,
        ),
        ("ageing", origins.Contacts(fresh, ageing=ageing), path, 10_000),
    ):
        best, steps = np.inf, 0.0
        for _ in range(3):
            ensemble = eq_model.Ensemble(contacts, way, n_contacts=count)
            for _ in ensemble:
                pass
            run = ensemble.result()
            best, steps = (
                min(best, run.run_time / run.breaks * 1e9),
                ensemble.state.steps / run.breaks,
            )
        print(f"{name:28s}{best:10.1f}{steps:25.1f}")


def main() -> None:
    """Print the tables."""
    start = origins.gaussian_start(mean=0.0, std=0.025)
    print(
        f"{'ns per break, one core':28s}{'X = 100':>10s}{'X = 5':>10s}{'X = 5, Gaussian start':>25s}"
    )
    hundred = []
    for name, law in ORIGINS.items():
        hundred.append(per_break(law, 100.0, 3_000_000))
        short, begun = per_break(law, 5.0, 4_000_000), per_break(law, 5.0, 4_000_000, start)
        print(f"{name:28s}{hundred[-1]:10.2f}{short:10.2f}{begun:25.2f}")
    print(f"worst at X = 100: {max(hundred):.2f}")
    laws()
    law = ORIGINS["gaussian, std 0.05"]
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    run = eq_model.simulate(
        origins.Contacts(law), np.linspace(0.0, 100.0, 501), n_contacts=10_100_000
    )
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(
        f"{run.breaks:.3g} breaks in one call: {run.run_time:.2f} s, peak memory grown by {grown / 1024:.1f} MB"
    )
    for name, shared in (
        ("gaussian", "origins.Contacts(fresh), 2_000_000"),
        ("soft", "origins.Contacts(fresh, thermal=soft), 600_000"),
        (
            "linked, soft, re-forming",
            'origins.Contacts(fresh, None, soft, None, None, 0.1, "linked"), 40_000',
        ),
        (
            "ageing",
            "origins.Contacts(fresh, ageing=origins.Ageing(origins.gaussian(1.2, 0.05), 1e-3)), 10_000",
        ),
    ):
        speedup = two_ranks(shared)
        told = (
            "no mpiexec here" if speedup is None else f"{speedup:.2f} times the throughput of one"
        )
        print(f"two ranks, {name}: {told}")


if __name__ == "__main__":
    main()
