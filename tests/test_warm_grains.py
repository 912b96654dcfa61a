"""Growing grains at a temperature and a steady speed, against contacts one by one and quadratures."""

import numpy as np
import pytest
from growing_contacts import along, deviation, rate, thresholds

import master
from master.lives.warm_grains import WarmGrainLife
from master.motion.motion import Motion
from origins import Contacts, Delay, Thermal, gaussian_start, growing_grains
from origins.start import SingleStart

GRAINS = growing_grains(1.0, 1.0, age=4.0)
PATH = np.linspace(0.0, 4.0, 21)[1:]


def survival(
    contacts: Contacts, velocity: float, at_start: bool, way: np.ndarray, accuracy: float
) -> tuple[np.ndarray, float]:
    """Share that holds after ways forward, of the start or of contacts that just pinned, and its error."""
    longest = 2.0 * float(way.max()) / velocity
    life = WarmGrainLife(contacts, longest, accuracy)
    history = Motion(np.array([0.0, longest]), np.array([0.0, velocity * longest])).history(
        way[:, None] / velocity, np.zeros((1, 1))
    )
    born = contacts.start if at_start else SingleStart(0.0)
    return life.left(born, history)[0, :, 0], life.error


CASES = [
    (Contacts(GRAINS, thermal=Thermal("soft", 0.1), delay=Delay(0.2)), 1.0),
    (Contacts(GRAINS, -0.3, thermal=Thermal("stiff", 0.05, 3.0)), 1.0),
    (Contacts(GRAINS, gaussian_start(0.3, 0.05), thermal=Thermal("soft", 0.03, 3.0)), 0.5),
]


@pytest.mark.parametrize("contacts, velocity", CASES)
def test_from_any_start_against_contacts_one_by_one(contacts: Contacts, velocity: float) -> None:
    solved = master.solve(contacts, PATH, 1e-7, velocity=velocity)
    assert solved.success, solved.message
    told = along(contacts, PATH, PATH / velocity, 4_000, 0.02 / velocity)
    assert deviation(contacts, solved, told) < 5.0


@pytest.mark.parametrize("law", ["soft", "stiff"])
@pytest.mark.parametrize("start", [0.0, 0.3])
def test_first_breaks_by_quadrature(law: str, start: float) -> None:
    """A start that stands alone: E is an average over quantiles of exp(-A), A by a fine sum along the way."""
    velocity, contacts = 0.7, Contacts(GRAINS, start, thermal=Thermal(law, 0.1, 2.0))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    before, travel = float(GRAINS.hazard(start, 4.0)), 0.5
    least = max(float(GRAINS.hazard(start + travel, 4.0 + travel / velocity)), before)
    # quantiles that hold so far, over the root of what is beyond the weakest of them
    edges = np.array([0.0, 0.1, 0.3, 1.0, 2.0, 3.5, 5.0, 6.3])
    root = (edges[:-1, None] + np.diff(edges)[:, None] * 0.5 * (nodes + 1.0)).ravel()
    share = (np.diff(edges)[:, None] * 0.5 * weights).ravel() * 2.0 * root
    hazard = least + root**2
    # the way in the root of what is left of it, as stiff contacts have a root at their threshold
    left = 0.5 * (nodes + 1.0)
    way, part = travel * (1.0 - left**2), travel * weights * left
    spent = sum(
        rate(contacts, start + w, thresholds(contacts, hazard, 4.0 + w / velocity)) * p / velocity
        for w, p in zip(way, part, strict=True)
    )
    held = float(share @ np.exp(before - hazard - spent))
    found, error = survival(contacts, velocity, True, np.array([travel]), 1e-9)
    assert found[0] == pytest.approx(held, abs=3e-6) and error < 1e-8


def test_steady_sliding_and_what_follows_from_it() -> None:
    contacts, velocity = Contacts(GRAINS, thermal=Thermal("soft", 0.1)), 1.0
    steady = master.steady_state(contacts, velocity=velocity)
    far = master.solve(contacts, [30.0], 1e-9, velocity=velocity)
    assert far.force[0] == pytest.approx(steady.force, abs=1e-8) and steady.force_error < 1e-9
    assert far.holding[0] == pytest.approx(steady.holding, abs=1e-8)
    curve = master.kinetic_curve(contacts, velocity, temperature=[0.0, 1e-3, 0.1, 1.0])
    assert curve.force[2] == steady.force and (np.diff(curve.force) < 0.0).all()
    assert curve.force[0] == master.steady_state(Contacts(GRAINS), velocity=velocity).force
    told = master.propensity(contacts, velocity=velocity)
    line = master.phase_line(contacts, velocity, temperature=[0.0, 0.1], tolerance=1e-8)
    assert line.critical_spring[1] == pytest.approx(told.critical_spring, abs=1e-7)
    # heat takes those that have just pinned too, which cold would bear what others drop
    assert told.critical_spring_error < 2e-7 and line.critical_spring[0] < line.critical_spring[1]


def test_errors_are_near_the_true_ones_at_a_temperature() -> None:
    """What is left out of kinks is counted: before, it was all that was told."""
    contacts = Contacts(GRAINS, thermal=Thermal("soft", 0.1))
    solved = master.solve(contacts, PATH, 1e-8)
    finer = master.solve(contacts, PATH, 1e-11)
    off = np.abs(solved.force - finer.force).max() / contacts.mean_threshold
    assert off < solved.force_error + finer.force_error < 100.0 * off


def test_cold_grains_that_are_met_before_any_rate_is_felt() -> None:
    """Young and hardly stretched: as without a temperature."""
    grains = growing_grains(1.0, 1.0, age=0.31)
    mean = Contacts(grains).mean_threshold
    path = np.array([3.0, 20.0, 60.0]) * mean
    cold, none = (
        master.solve(Contacts(grains, thermal=thermal), path, 1e-4, velocity=mean)
        for thermal in (Thermal("soft", 1e-8 * mean**2), None)
    )
    assert cold.success and np.abs(cold.force - none.force).max() < (cold.force_error + none.force_error + 1e-6) * mean
