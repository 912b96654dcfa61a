"""`solve` of contacts with heat: a rate law of a test's own, and limits that are known exactly."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from rate_laws import Tilted
from scipy.integrate import quad

import master
from origins import Contacts, Thermal, gaussian
from origins.laws.thermal import GivenRates

LAW = gaussian(1.0, 0.2)
TILTED = Tilted(alpha=0.1, omega=3.0)


def test_first_contacts_of_a_rate_law_by_quadrature() -> None:
    """What breaks in a hold forms again relaxed, so that the force is that of the first contacts."""
    start, time = 0.4, np.array([0.0, 1.0, 30.0])
    contacts = Contacts(LAW, start, thermal=GivenRates(TILTED))
    solved = master.solve(contacts, np.zeros(time.size), 1e-7, time=time)

    def held(t: float) -> float:
        def share(threshold: float) -> float:
            return float(LAW.pdf(threshold) * np.exp(-t * TILTED.rate(start, threshold, 1.0)))

        edges = np.append(start, np.linspace(0.45, 3.0, 60))
        return sum(quad(share, a, b, epsabs=1e-13, epsrel=1e-12)[0] for a, b in pairwise(edges))

    exact = start * np.array([held(t) for t in time]) / LAW.sf(start)
    assert solved.success, solved.message
    assert np.abs(solved.force - exact).max() <= solved.force_error


def test_far_on_the_force_is_the_kinetic_force() -> None:
    contacts = Contacts(LAW, thermal=GivenRates(TILTED))
    nodes, weights = np.polynomial.legendre.leggauss(200)
    x, share = 1.4 * (nodes + 1.0), 1.4 * weights
    # thresholds above each x, up to 9 standard deviations beyond the mean
    above = 0.5 * (2.8 - x)[:, None]
    threshold = x[:, None] + above * (nodes + 1.0)
    passed = np.exp(TILTED.log_passed(0.0, x[:, None], threshold, 1.0))
    held = (LAW.pdf(threshold) * np.exp(-passed) * above * weights).sum(axis=1)
    kinetic = (share * x * held).sum() / (share * held).sum()
    solved = master.solve(contacts, [30.0, 40.0], 1e-7)
    assert solved.success, solved.message
    assert np.abs(solved.force - kinetic).max() <= solved.force_error + 1e-12


def test_a_path_is_the_same_however_it_is_told() -> None:
    """Points in time that a speed would give, with a hold too short to be felt, and a turn."""
    contacts = Contacts(LAW, thermal=GivenRates(TILTED))
    path = np.array([0.5, 1.0, 1.5, 1.0, 0.2])
    time = np.array([0.5, 1.0, 1.5, 2.0, 2.8])
    plain = master.solve(contacts, path, 1e-6)
    later = np.insert(time + np.where(time > 1.0, 1e-9, 0.0), 2, 1.0 + 1e-9)
    held = master.solve(contacts, np.insert(path, 2, 1.0), 1e-6, time=later)
    assert plain.success and held.success
    apart = np.abs(np.delete(held.force, 2) - plain.force).max()
    # in 1e-9 of time as little breaks
    assert apart <= plain.force_error + held.force_error + 1e-8


def test_a_dozen_velocity_steps_before_a_turn() -> None:
    """Legs as long as what the survival is smooth over: no polynomial of a low degree follows it on them."""
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Thermal("stiff", 0.0076, 410.0, "paper"))
    path = np.append(np.linspace(0.0, -1.3, 11), [-1.28, -1.26, -1.25, -1.2])
    time = np.cumsum(np.append(0.0, [0.9, 1.1, 1.0, 1.2, 0.3, 0.9, 1.0, 0.5, 1.1, 0.7, 0.4, 0.9, 1.3, 0.6]))
    fine, rough = (master.solve(contacts, path, tolerance, time=time) for tolerance in (1e-6, 1e-4))
    assert fine.success
    assert np.abs(fine.force - rough.force).max() < fine.force_error + rough.force_error
