"""Order of convergence, fitted for every method that steps forward on a lattice or a grid: one table.

Other places where an order is fitted: diffusion on cells and its propagator in tests/test_ageing.py and
test_q15_transient.py, first passage in test_first_passage.py.
"""

from collections.abc import Callable

import numpy as np
import pytest

import master
from master._old.cohort import starting
from master._old.cohorts import Course, solve_cohorts
from master._old.cycle import Cycle
from master._old.law import Law
from master._old.leg import State
from master._old.moves import moves
from master._old.problem import Problem
from master._old.renewal import LaterReleased
from master.paper.explicit import explicit
from master.paper.explicit_loop import explicit_loop
from master.paper.q15_transient import paper_transient
from origins import Ageing, Contacts, Delay, Thermal, gaussian, gaussian_start, rectangular

Run = Callable[[float], np.ndarray]

PATH = np.sort(np.random.default_rng(4).uniform(0.0, 4.0, 300))
LOOP = np.concatenate([np.linspace(0.0, 1.2, 25), np.linspace(1.15, -1.2, 40), np.linspace(-1.15, 1.0, 40)])
GAUSS, START = gaussian(1.0, 0.1), gaussian_start(0.1, 0.05)
PAPER = Thermal("soft", 0.3, closure="paper")


def on_a_grid(contacts: Contacts, breaking: str) -> tuple[Run, np.ndarray | None]:
    return lambda h: explicit(contacts, PATH, h, breaking).force, master.solve(contacts, PATH, 1e-8).force


def on_a_lattice(contacts: Contacts) -> tuple[Run, np.ndarray | None]:
    """What later generations release: the lattice of `solve`, its steps given."""
    cycle = Cycle(contacts)
    x = np.linspace(0.0, 4.0, 3001) / cycle.unit
    problem = Problem(contacts, float(x[-1]), 1e-12, cycle)
    exact = LaterReleased(problem, 0.004 if not problem.rough else 0.0004, x, 1e-14)(x)
    return lambda h: LaterReleased(problem, h, x, 1e-14)(x), exact


def in_cohorts(contacts: Contacts) -> tuple[Run, np.ndarray | None]:
    law = Law(contacts, 8.0)
    begin = State(0.0, [starting(contacts, law)])

    def run(h: float) -> np.ndarray:
        return Course(law, begin, moves(LOOP), LOOP, [h] * 3, 1e-14, None).force()

    return run, solve_cohorts(contacts, LOOP, 1e-10).force


def ageing_as_printed() -> tuple[Run, np.ndarray | None]:
    ageing = Ageing(gaussian(1.0, 0.02), 5e-4, closure="paper")
    contacts, path = Contacts(gaussian(0.5, 0.05), gaussian_start(0.1, 0.025), ageing=ageing), np.array([0.35, 0.6])
    return lambda h: paper_transient(contacts, path, h, cells=8).force, None


def loop_as_printed() -> tuple[Run, np.ndarray | None]:
    contacts = Contacts(GAUSS, START)
    return lambda h: explicit_loop(contacts, LOOP, h).force, None


NEAR_ZERO = gaussian_start(0.0, 0.04)
COARSE, FINE = 0.02 / 2.0 ** np.arange(4.0), 0.1 / np.array([3.0, 3.5, 4.0, 4.5, 5.0])
FINER = 0.1 / np.geomspace(3.5, 10.0, 6)  # where between its nodes errors are largest depends on the step
METHODS: dict[str, tuple[float, np.ndarray, Callable[[], tuple[Run, np.ndarray | None]]]] = {
    "explicit": (1.0, COARSE, lambda: on_a_grid(Contacts(GAUSS, START), "survival")),
    "explicit, printed": (1.0, COARSE, lambda: on_a_grid(Contacts(GAUSS, START), "printed")),
    "explicit, warm": (1.0, COARSE, lambda: on_a_grid(Contacts(GAUSS, START, thermal=PAPER), "survival")),
    "explicit, warm, printed": (1.0, COARSE, lambda: on_a_grid(Contacts(GAUSS, START, thermal=PAPER), "printed")),
    "explicit, delay": (1.0, COARSE, lambda: on_a_grid(Contacts(GAUSS, START, delay=Delay(0.32)), "survival")),
    "explicit loop": (1.0, COARSE, loop_as_printed),
    "lattice": (8.0, FINER, lambda: on_a_lattice(Contacts(GAUSS, START))),
    "lattice, warm": (8.0, FINER, lambda: on_a_lattice(Contacts(GAUSS, START, thermal=Thermal("soft", 0.02)))),
    "lattice, delay": (8.0, FINER, lambda: on_a_lattice(Contacts(GAUSS, START, delay=Delay(0.3)))),
    "lattice, re-forming": (8.0, FINER, lambda: on_a_lattice(Contacts(GAUSS, START, reforming=NEAR_ZERO))),
    "lattice, linked": (8.0, FINER, lambda: on_a_lattice(Contacts(GAUSS, START, stiffness="linked"))),
    "lattice, jumps": (3.0, 0.02 / 1.5 ** np.arange(6.0), lambda: on_a_lattice(Contacts(rectangular(0.5, 1.5)))),
    "cohorts": (8.0, FINE, lambda: in_cohorts(Contacts(gaussian(1.0, 0.1)))),
    "ageing as printed": (2.0, 0.7 / np.array([70.0, 140.0, 280.0, 560.0]), ageing_as_printed),
}


@pytest.mark.parametrize("name", METHODS)
def test_order_is_the_one_stated(name: str) -> None:
    stated, steps, method = METHODS[name]
    run, exact = method()
    answers = [run(float(h)) for h in steps]
    if exact is None:  # no other road to the same answer: what the steps themselves tend to
        ratio = (steps[-2] / steps[-1]) ** stated
        exact = (ratio * answers[-1] - answers[-2]) / (ratio - 1.0)
        answers, steps = answers[:-1], steps[:-1]
    errors = [np.abs(answer - exact).max() for answer in answers]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(order - stated) <= 0.2, (order, errors)
