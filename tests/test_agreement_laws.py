"""Contacts with laws of their own, on any path in time: the ensemble and the master equation as each other's witness.

100 seeds at most 20 points of a path, their correlations taken into account; the master equation in its exact closures.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

import eq_model
import master
import origins
import toolkit
from origins import Ageing, Contacts, Delay, Thermal
from tests.test_agreement import LEVEL, judge
from toolkit.commands import report
from toolkit.results.beside import deviation

SEEDS = 100
GAUSSIAN = origins.gaussian(1.0, 0.2)
SOFT, STIFF = Thermal("soft", 0.05), Thermal("stiff", 0.05)
START = origins.gaussian_start(-0.1, 0.2)
GRAINS = origins.growing_grains(alpha=1.0, B=1.0, age=4.0)
AGEING = Ageing(origins.gaussian(0.8, 0.05), 1e-2)
# wide in the end: the master equation takes a second on paths in time
YOUNG, WIDE = origins.gaussian(0.5, 0.1), Ageing(origins.gaussian(0.8, 0.2), 1e-2)
FORWARD = np.linspace(0.35, 4.5, 14)
LOOP = np.concatenate([np.linspace(0.4, 1.4, 6), np.linspace(1.0, -1.2, 7), np.linspace(-0.8, 0.6, 4)])
HELD, WHEN = np.array([0.6, 1.2, 1.2, 1.2, 1.6, 2.2, 2.8]), np.array([0.6, 1.2, 3.0, 30.0, 30.4, 31.0, 31.6])

TURN = np.array([0.5, 0.7, 0.9, 0.3, 0.0, -0.3])
WAIT, UNTIL = np.array([0.4, 0.6, 0.6, 0.75, 0.9, 1.2]), np.array([0.4, 0.6, 3.0, 3.15, 3.3, 3.6])


@dataclass(frozen=True)
class Case:
    contacts: Contacts
    path: np.ndarray = field(default_factory=lambda: FORWARD)
    drive: dict[str, Any] = field(default_factory=dict)
    tolerance: float = 1e-6
    number: int = 1000


CASES = {
    "soft": Case(Contacts(GAUSSIAN, START, thermal=SOFT)),
    "stiff, slow": Case(Contacts(GAUSSIAN, thermal=STIFF), drive={"velocity": 0.1}),
    "delay": Case(Contacts(GAUSSIAN, delay=Delay(0.3))),
    "re-forming": Case(Contacts(GAUSSIAN, reforming=origins.boltzmann_reforming(0.05))),
    "linked": Case(Contacts(GAUSSIAN, START, stiffness="linked")),
    "all but ageing": Case(
        Contacts(GAUSSIAN, 0.2, STIFF, None, Delay(0.2), 0.1, "linked"), tolerance=1e-5
    ),
    "ageing": Case(Contacts(origins.gaussian(0.5, 0.1), 0.1, ageing=AGEING), drive={"velocity": 2.0}, number=300),
    "ageing, soft, delay": Case(
        Contacts(origins.gaussian(0.5, 0.1), 0.1, SOFT, AGEING, Delay(0.2)), tolerance=1e-4, number=300
    ),
    "ageing, re-forming, delay": Case(
        Contacts(YOUNG, 0.1, ageing=AGEING, reforming=0.15, delay=Delay(0.1)), tolerance=1e-4, number=300
    ),
    "ageing, turning": Case(Contacts(YOUNG, ageing=WIDE), TURN, {"velocity": 2.0}, 3e-4, 300),
    "ageing, hold": Case(Contacts(YOUNG, ageing=WIDE), WAIT, {"time": UNTIL}, 3e-4, 300),
    "growing grains, delay": Case(Contacts(GRAINS, 0.1, delay=Delay(0.2)), tolerance=1e-5),
    "growing grains, loop": Case(Contacts(GRAINS), LOOP, tolerance=1e-4),
    "growing grains, stiff": Case(Contacts(GRAINS, 0.1, STIFF)),
    "loop": Case(Contacts(GAUSSIAN, START), LOOP),
    "loop, soft": Case(Contacts(GAUSSIAN, thermal=SOFT), LOOP, tolerance=1e-5),
    "loop, delay": Case(Contacts(GAUSSIAN, delay=Delay(0.3)), LOOP, tolerance=1e-5),
    "hold, soft": Case(Contacts(GAUSSIAN, thermal=SOFT), HELD, {"time": WHEN}, tolerance=1e-5),
}


@pytest.mark.parametrize("name", CASES)
def test_all_points_at_once(name: str) -> None:
    case = CASES[name]
    exact = master.solve(case.contacts, case.path, case.tolerance, **case.drive)
    assert exact.success
    runs = [
        eq_model.simulate(case.contacts, case.path, n_contacts=case.number, seed=seed, **case.drive)
        for seed in range(10_000, 10_000 + SEEDS)
    ]
    forces, errors = (np.array([getattr(run, name) for run in runs]) for name in ("force", "force_standard_error"))
    together = np.sqrt((errors**2).sum(axis=0)) / SEEDS
    own = exact.force_error * case.contacts.mean_threshold
    # more is asked of the master equation than the seeds together can tell
    assert own < 0.1 * together.max()
    assert judge(forces, exact.force) > LEVEL
    assert (np.abs(forces.mean(axis=0) - exact.force) < 5.0 * together + own).all()
    holding = np.array([run.holding for run in runs])
    spread = np.hypot(holding.std(axis=0, ddof=1) / np.sqrt(SEEDS), 1e-5)
    assert (np.abs(holding.mean(axis=0) - exact.holding) < 5.0 * spread).all()


WARM = {"law": "soft", "temperature": 0.3, "closure": "paper"}
OLD = {"rate": 5e-4, "closure": "paper", "final": {"kind": "gaussian", "mean": 1.0, "std": 0.02}}
BEGUN = {"kind": "gaussian", "mean": 0.1, "std": 0.025}
YOUNG_ONES, WIDE_ONES = ({"kind": "gaussian", "mean": mean, "std": std} for mean, std in ((0.5, 0.05), (1.0, 0.2)))


@pytest.mark.parametrize(
    ("contacts", "drive"),
    [
        # a soft contact's hazard is not the mean of those that hold at first
        ({"thresholds": WIDE_ONES, "thermal": WARM}, {"to": 4.5, "points": 14, "velocity": 0.1}),
        # a turn forgets what was survived
        ({"thresholds": WIDE_ONES, "thermal": WARM}, {"turns": [0.9, -0.9, 0.9], "points": 28}),
        # contacts have no common P_c
        ({"thresholds": YOUNG_ONES, "start": BEGUN, "ageing": OLD}, {"to": 0.75, "points": 16}),
    ],
    ids=["soft", "turning", "ageing"],
)
def test_the_papers_closures_are_found_out(contacts: dict[str, Any], drive: dict[str, Any]) -> None:
    """By how many standard errors, in the scene itself."""
    many = {"contacts": 100_000, "replicas": 1}
    result = toolkit.run({"contacts": contacts, "drive": drive, "master": {"tolerance": 1e-3}, "eq": many})
    apart = deviation(result).worst
    assert apart is not None and apart > 20.0
    said = report(result)[-1]
    assert f"at most {apart:.1f} standard errors" in said and "which single contacts do not follow" in said
