"""The same contacts by the methods a user would write or take from a library: nanoseconds per break of each.

Run: python tests/bench/other_ways.py
"""

import importlib.util
import time
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

import eq_model
import origins
from eq_model.closest import closest, draw_start

CONTACTS = 10_000
LAW = origins.gaussian(mean=1.0, std=0.05)
Array = npt.NDArray[np.float64]


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


def paper_compiled(breaks: int = 20_000) -> float:
    """Of the paper's algorithm compiled with numba."""
    generator, best = np.random.default_rng(0), np.inf
    for count in (10, breaks, breaks):
        x, gap = draw_start(origins.Contacts(LAW), CONTACTS, generator)
        fresh = LAW.rvs(count, generator)
        started = time.perf_counter()
        paper_algorithm(x, gap, fresh)
        if count > 10:
            best = min(best, time.perf_counter() - started)
    return best / breaks * 1e9


def paper_numpy() -> float:
    """Of the plain twin, eq_model.closest."""
    started = time.perf_counter()
    _, breaks = closest(origins.Contacts(LAW), 0.98, n_contacts=CONTACTS)
    return (time.perf_counter() - started) / breaks * 1e9


def mesa(breaks: int = 20_000) -> tuple[str, float, float]:
    """Of Mesa, each contact an agent that schedules its own break: version, nanoseconds, mean stretch at the end."""
    import mesa as library
    from mesa.experimental.devs import DEVSimulator

    class Contact(library.Agent):  # type: ignore[misc]
        def __init__(self, model: Any) -> None:
            super().__init__(model)
            self.form()

        def form(self) -> None:
            self.born = self.model.simulator.time
            self.model.breaks += 1
            self.model.simulator.schedule_event_relative(self.form, self.model.draw())

    class Surface(library.Model):  # type: ignore[misc]
        def __init__(self, simulator: Any) -> None:
            super().__init__(seed=1)
            self.simulator, self.breaks = simulator, -CONTACTS
            simulator.setup(self)
            self.fresh = iter(LAW.rvs(CONTACTS + 2 * breaks, np.random.default_rng(0)).tolist())
            for _ in range(CONTACTS):
                Contact(self)

        def draw(self) -> float:
            return next(self.fresh)

    simulator = DEVSimulator()
    surface = Surface(simulator)
    started = time.perf_counter()
    simulator.run_until(breaks / CONTACTS)
    seconds = time.perf_counter() - started
    stretch = breaks / CONTACTS - np.mean([agent.born for agent in surface.agents])
    return library.__version__, seconds / surface.breaks * 1e9, float(stretch)


def main() -> None:
    """Print the table: each way beside the ensemble, in one run."""
    contacts, path = origins.Contacts(LAW), np.linspace(0.0, 100.0, 501)
    runs = [eq_model.simulate(contacts, path, n_contacts=3_000_000) for _ in range(3)]
    own = min(run.run_time for run in runs) / runs[0].breaks * 1e9
    rows = {
        "ensemble": own,
        "the paper's, compiled": paper_compiled(),
        "the paper's, numpy": paper_numpy(),
    }
    if importlib.util.find_spec("mesa") is None:
        print("Mesa is not installed (pip install mesa): its row is left out")
    else:
        version, rows["Mesa"], stretch = mesa()
        expected = eq_model.simulate(contacts, [2.0], n_contacts=1_000_000).force[0]
        print(f"Mesa {version}: mean stretch {stretch:.4f} at X = 2, the ensemble's {expected:.4f}")
    print(f"{f'{CONTACTS} contacts, Gaussian':34s}{'ns per break':>14s}{'ensemble':>10s}")
    for name, cost in rows.items():
        print(f"{name:34s}{cost:14.1f}{cost / own:9.0f}x")


if __name__ == "__main__":
    main()
