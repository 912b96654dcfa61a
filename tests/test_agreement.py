"""The two solvers as witnesses of one model: seeds of the ensemble against the master equation in its exact closures.

Points of one path share contacts, so their errors go together: Hotelling's T^2 judges them all at once.
"""

from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
import scipy.stats
from conftest import slow
from rate_laws import Tilted

import eq_model
import master
import origins
import toolkit
from eq_model.closest import closest
from origins import Ageing, Contacts, Delay, Thermal
from origins.laws.compiled import CompiledRates

SEEDS, LEVEL = 60, 1e-3
WIDE = origins.gaussian(1.0, 0.2)
SOFT, STIFF = Thermal("soft", 0.05), Thermal("stiff", 0.05)
EYRING = Thermal("eyring", width=0.1)
START = origins.gaussian_start(-0.1, 0.2)
GRAINS = origins.growing_grains(alpha=1.0, B=1.0, age=4.0)
YOUNG, AGEING = origins.gaussian(0.5, 0.1), Ageing(origins.gaussian(0.8, 0.2), 1e-2)
GAP = origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7])
ATOM = origins.mixture([origins.identical(0.95), origins.gaussian(1.05, 0.1)], [0.25, 0.75])
FORWARD = np.linspace(0.35, 4.5, 12)
TURN = np.array([0.5, 0.7, 0.9, 0.3, 0.0, -0.3])
LOOP = np.concatenate([np.linspace(0.4, 1.4, 6), np.linspace(1.0, -1.2, 7), [-0.8, 0.0, 0.6]])
HELD, WHEN = np.array([0.6, 1.2, 1.2, 1.6, 2.2]), np.array([0.6, 1.2, 30.0, 30.4, 31.0])
WAVES = np.array([0.95, 1.0, 1.05, 1.9, 2.0, 2.1, 2.9, 3.0, 3.1, 4.0, 4.3, 5.0])
GAPS = np.array([0.3, 0.45, 0.6, 0.95, 1.05, 1.2, 1.4, 1.6, 1.9, 2.1, 2.4, 2.8, 3.1, 4.0])
ATOMS = np.array([0.9, 0.94, 0.96, 1.1, 1.3, 1.85, 1.92, 2.1, 2.3, 2.8, 2.9, 3.1, 3.9, 4.2])


@dataclass(frozen=True)
class Case:
    """Contacts, at most 20 points where the force differs between them, and what is asked of both solvers."""

    contacts: Contacts
    path: np.ndarray = field(default_factory=lambda: FORWARD)
    drive: dict[str, Any] = field(default_factory=dict)
    tolerance: float = 1e-7
    number: int = 3000


def strengthening(beta: float, start: Any = 0.0, **laws: Any) -> Contacts:
    """Contacts whose thresholds grow with the logarithm of their age."""
    return Contacts(origins.strengthening(WIDE, beta, 2.0), start, **laws)


CASES = {
    "gaussian, A02's start": Case(
        Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, 0.025)), WAVES
    ),
    "rectangular": Case(Contacts(origins.rectangular(0.5, 1.5)), np.linspace(0.6, 4.4, 20)),
    "gap": Case(Contacts(GAP), GAPS),
    "exact value": Case(Contacts(ATOM), ATOMS),
    "start wider than steady sliding": Case(
        Contacts(origins.persson(1.0, 0.5), scipy.stats.uniform(-0.9, 2.0)),
        np.linspace(0.0, 3.8, 20),
    ),
    "start below zero": Case(Contacts(WIDE, -0.9), np.linspace(1.85, 5.0, 12)),
    "soft": Case(Contacts(WIDE, START, thermal=SOFT)),
    "eyring, slow": Case(
        Contacts(WIDE, START, thermal=Thermal("eyring", width=0.1)), drive={"velocity": 1e-3}
    ),
    "delay": Case(Contacts(WIDE, delay=Delay(0.3))),
    "all but ageing": Case(
        Contacts(WIDE, 0.2, STIFF, None, Delay(0.2), 0.1, "linked"), tolerance=1e-5
    ),
    "ageing, turning": Case(Contacts(YOUNG, ageing=AGEING), TURN, {"velocity": 2.0}, 1e-4, 400),
    # the kernel of cold grains, too
    "growing grains, soft": Case(Contacts(GRAINS, 0.1, SOFT), tolerance=1e-5, number=1000),
    "grains, an end": Case(Contacts(GRAINS), np.array([1.0, 2.0]), {"velocity": 0.5}, 1e-5, 9000),
    "growing grains, turning": Case(Contacts(GRAINS), TURN, tolerance=1e-4, number=400),
    "hold, soft": Case(Contacts(WIDE, thermal=SOFT), HELD, {"time": WHEN}, 1e-5, 1000),
    "strengthening": Case(strengthening(0.1, START), drive={"velocity": 0.1}),
    "strengthening, turning": Case(strengthening(0.1), TURN, {"velocity": 0.1}, 1e-5, 1000),
    # its kernel is that of cold contacts whose thresholds grow, too; with eyring's rates below it has one of its own
    "strengthening, soft, delay": Case(
        strengthening(0.1, thermal=SOFT, delay=Delay(0.3)),
        drive={"velocity": 0.5},
        tolerance=1e-5,
        number=1000,
    ),
}
SLOW = {
    "growing grains, stiff": Case(Contacts(GRAINS, 0.1, STIFF), tolerance=1e-5, number=1000),
    "loop, a law of the tests' own": Case(
        Contacts(WIDE, START, thermal=Tilted(0.1, 0.4)), LOOP, tolerance=1e-4, number=800
    ),
    "stiff, slow": Case(Contacts(WIDE, thermal=STIFF), drive={"velocity": 0.1}, tolerance=1e-6),
    "re-forming": Case(Contacts(WIDE, reforming=origins.boltzmann_reforming(0.05))),
    "ageing, delay": Case(
        Contacts(YOUNG, 0.1, None, Ageing(origins.gaussian(0.8, 0.05), 1e-2), Delay(0.2)),
        FORWARD[1:],  # before, hardly a contact of 300 breaks, so that forces do not scatter
        tolerance=1e-4,
        number=300,
    ),
    "ageing, hold": Case(
        Contacts(YOUNG, ageing=AGEING), HELD[:4] * 0.6, {"time": WHEN[:4] * 0.1}, 1e-4, 400
    ),
    "growing grains, delay": Case(Contacts(GRAINS, 0.1, delay=Delay(0.2)), tolerance=1e-5),
    "loop, soft": Case(Contacts(WIDE, thermal=SOFT), LOOP, tolerance=1e-5),
    "strengthening, hold, eyring": Case(
        strengthening(0.1, thermal=EYRING), HELD, {"time": WHEN}, 1e-5, 1000
    ),
}


def judge(samples: np.ndarray, expected: np.ndarray) -> float:
    """Probability of a larger T^2 when the rows of samples have the expected mean: exact for normal rows."""
    seeds, points = samples.shape
    assert points <= 20
    # in standard errors first: forces at different X may differ by orders of magnitude in their scatter
    z = np.sqrt(seeds) * (samples.mean(axis=0) - expected) / samples.std(axis=0, ddof=1)
    square = z @ np.linalg.solve(np.corrcoef(samples.T), z)
    statistic = square * (seeds - points) / (points * (seeds - 1))
    return float(scipy.stats.f.sf(statistic, points, seeds - points))


@cache
def runs_of(name: str) -> list[Any]:
    """Results of a case's seeds."""
    case = (CASES | SLOW)[name]
    asked: dict[str, Any] = {"n_contacts": case.number, **case.drive}
    seeds = range(10_000, 10_000 + SEEDS)
    return [eq_model.simulate(case.contacts, case.path, seed=seed, **asked) for seed in seeds]


# thresholds that age by the cheapest of their cases
# each law by itself, and most of them on paths that turn or rest
QUICK = {*CASES, "ageing, delay"} - {"eyring, slow", "growing grains, soft", "ageing, turning"}
QUICK -= {"gap", "rectangular", "grains, an end", "strengthening, turning"}


@pytest.mark.parametrize(
    "name",
    [slow(name, when=name not in QUICK) for name in (*CASES, *SLOW)],
)
def test_all_points_at_once(name: str) -> None:
    case = (CASES | SLOW)[name]
    exact = master.solve(case.contacts, case.path, case.tolerance, **case.drive)
    assert exact.success
    runs = runs_of(name)
    force, errors, holding = (
        np.array([getattr(run, one) for run in runs])
        for one in ("force", "force_standard_error", "holding")
    )
    together = np.sqrt((errors**2).sum(axis=0)) / SEEDS
    own = exact.force_error * case.contacts.mean_threshold
    # more is asked of the master equation than the seeds together can tell
    assert own < 0.1 * together.max()
    assert judge(force, exact.force) > LEVEL
    assert (np.abs(force.mean(axis=0) - exact.force) < 5.0 * together + own).all()
    spread = np.hypot(holding.std(axis=0, ddof=1) / np.sqrt(SEEDS), 1e-5)
    assert (np.abs(holding.mean(axis=0) - exact.holding) < 5.0 * spread).all()
    # the error that is reported is the spread over seeds, to one in a million at each of some 300 points
    ratio = force.var(axis=0, ddof=1) / (errors**2).mean(axis=0)
    low, high = scipy.stats.chi2.ppf([5e-7, 1.0 - 5e-7], SEEDS - 1) / (SEEDS - 1)
    often = together > 0.3 * together.max()  # of few breaks more is claimed than scatters
    assert (ratio[often] > low).all() and (ratio < high).all()


def test_each_rate_law_of_ones_own_breaks_contacts_at_its_own_rates() -> None:
    """One kernel serves all: the second law of a process had the rates of the first, 60 standard errors off."""
    path = np.array([0.5, 1.0, 2.0])
    for alpha in (0.05, 0.2):
        contacts = Contacts(WIDE, thermal=Tilted(alpha))
        exact = master.solve(contacts, path, 1e-6, velocity=0.1)
        drawn = eq_model.simulate(contacts, path, velocity=0.1, n_contacts=2000, seed=1)
        off = np.abs(drawn.force - exact.force)
        assert exact.success and (off < 5.0 * drawn.force_standard_error).all()


class Twin(Tilted):
    """A law whose compiled functions have settings of a class with the name of another law's."""

    def compiled(self) -> CompiledRates:
        of_soft = SOFT.rates.compiled()
        own = type(of_soft.law)
        return of_soft._replace(
            law=NamedTuple(own.__name__, own.__annotations__.items())(*of_soft.law)
        )


def test_settings_of_two_laws_may_not_have_classes_of_one_name() -> None:
    """Numba takes both for one class, and the second law would break contacts at the rates of the first."""
    eq_model.simulate(Contacts(WIDE, thermal=SOFT), [0.5], n_contacts=10)
    with pytest.raises(origins.InputError, match="are a class SoftLaw, as those of another law"):
        eq_model.simulate(Contacts(WIDE, thermal=Twin()), [0.5], n_contacts=10)


@pytest.mark.parametrize("name", ["strengthening", "strengthening, turning"])
def test_a_growth_that_is_a_tenth_slower_is_told_apart(name: str) -> None:
    """By the same seeds: the test of all points at once has the power to see a wrong law of strengthening."""
    case, force = CASES[name], np.array([run.force for run in runs_of(name)])
    slower = strengthening(0.09, case.contacts.start)
    wrong = master.solve(slower, case.path, case.tolerance, **case.drive)
    assert wrong.success and judge(force, wrong.force) < 1e-3 * LEVEL


@pytest.mark.parametrize("start", [0.123, -0.7])
def test_before_the_first_break_they_agree_to_round_off(start: float) -> None:
    contacts = Contacts(origins.gaussian(1.0, 0.02), start)
    path = np.linspace(0.0, 0.37 if start >= 0.0 else 1.4, 20)
    run = eq_model.simulate(contacts, path, n_contacts=1000)
    assert run.breaks == 0
    assert (run.force_standard_error == 0.0).all() and (run.holding == 1.0).all()
    assert np.abs(run.force - master.solve(contacts, path).force).max() < 1e-14


@pytest.mark.parametrize("name", ["gaussian, A02's start", slow("gap"), "start below zero"])
def test_the_papers_algorithm_agrees_with_the_master_equation(name: str) -> None:
    case, points = CASES[name], slice(1, None, 3)
    path = case.path[points]
    runs = [closest(case.contacts, path, n_contacts=20, seed=seed)[0] for seed in range(100)]
    assert judge(np.array(runs), master.solve(case.contacts, path, 1e-9).force) > LEVEL


THERMAL = {"law": "soft", "temperature": 0.3, "closure": "paper"}
OLD = {"kind": "gaussian", "mean": 1.0, "std": 0.02}
WARM = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}, "thermal": THERMAL}
AGED = {
    "thresholds": {"kind": "gaussian", "mean": 0.5, "std": 0.05},
    "start": {"kind": "gaussian", "mean": 0.1, "std": 0.025},
    "ageing": {"rate": 5e-4, "closure": "paper", "final": OLD},
}


@pytest.mark.parametrize(
    ("contacts", "drive"),
    [
        # a soft contact's hazard is not the mean of those that hold at first
        (WARM, {"to": 4.5, "points": 14, "velocity": 0.1}),
        # a turn forgets what was survived
        (WARM, {"turns": [0.9, -0.9, 0.9], "points": 28}),
        # contacts have no common P_c
        (AGED, {"to": 0.75, "points": 16}),
    ],
    ids=["soft", "turning", "ageing"],
)
def test_the_papers_closures_are_found_out(contacts: dict[str, Any], drive: dict[str, Any]) -> None:
    """By many standard errors, in the scene itself."""
    many = {"contacts": 100_000, "replicas": 1}
    scene = {"contacts": contacts, "drive": drive, "master": {"tolerance": 1e-3}, "eq": many}
    found = toolkit.run(scene)
    claimed = found.eq.force_standard_error + 1e-6
    assert (np.abs(found.eq.force - found.master.force) / claimed).max() > 20.0
