"""Paths far beyond where contacts have forgotten their start: the kinetic force, once nothing else is left of it."""

import mpmath
import numpy as np
import pytest
import scipy.stats
from counted_calls import CountedCalls
from phase_type import gaussian_force

import master
import origins
from origins import Contacts, Delay, Thermal, gaussian, gaussian_start, identical, mixture, rectangular

WIDE = gaussian(1.0, 0.2)
CASES = {
    "cold": (Contacts(gaussian(1.0, 0.05), gaussian_start(0.1, 0.025)), 1.0),
    "delay": (Contacts(rectangular(0.5, 1.5), 0.3, delay=Delay(0.3)), 2.0),
    "linked, behind": (Contacts(WIDE, -0.3, reforming=-0.2, stiffness="linked"), 1.0),
    "an exact value": (Contacts(mixture([gaussian(1.0, 0.1), identical(0.8)], [0.7, 0.3])), 1.0),
    "warm": (Contacts(gaussian(1.0, 0.05), thermal=Thermal("stiff", 0.01, 10.0)), 1.0),
    "creep": (Contacts(gaussian(1.0, 0.05), thermal=Thermal("soft", 0.1)), 1e-7),
    "creep, paper": (Contacts(gaussian(1.0, 0.05), thermal=Thermal("soft", 0.1, closure="paper")), 1e-4),
}


@pytest.mark.parametrize("name", CASES)
def test_far_on_the_force_is_the_kinetic_one_at_any_distance(name: str) -> None:
    contacts, speed = CASES[name]
    steady = master.steady_state(contacts, velocity=speed)
    with CountedCalls() as told:
        far = master.solve(contacts, steady.cycle_length * np.geomspace(2e4, 1e12, 7), 1e-8, velocity=speed)
    assert far.success and far.force_error <= 1e-8, far.message
    np.testing.assert_allclose(far.force, steady.force, atol=1e-8)
    np.testing.assert_allclose(far.holding, steady.holding, atol=1e-8)
    assert told.number < 1_000_000  # below 100,000; of 1e12 breaks, more than there are
    x = np.linspace(0.05, 1.2, 5) * steady.cycle_length
    spread = far.distribution(1e11 * steady.cycle_length)
    if not spread.delta_weights.sum() > 1e-9:
        np.testing.assert_allclose(spread.density(x), steady.distribution(x), atol=1e-5 / steady.cycle_length)


@pytest.mark.parametrize("std", [0.05, 0.1])
def test_nothing_is_handed_over_too_early(std: float) -> None:
    contacts = Contacts(gaussian(1.0, std), gaussian_start(0.1, 0.025))
    x = np.append(np.linspace(0.0, 900.0, 7001), 5e3)
    found = master.solve(contacts, x, 1e-9)
    exact = gaussian_force(x[:-1], 1.0, std, 0.1, 0.025)
    assert found.success
    assert np.abs(found.force[:-1] - exact).max() <= found.force_error


def test_what_is_never_forgotten_is_not_handed_over() -> None:
    single = master.solve(Contacts(identical(1.0)), [0.25, 3_000.25], 1e-6)
    np.testing.assert_allclose(single.force, 0.25, atol=1e-6)
    # narrow thresholds take long to forget
    path = np.array([4000.0, 4000.5])
    narrow = master.solve(Contacts(gaussian(1.0, 0.004)), path, 1e-9)
    off = np.abs(narrow.force - gaussian_force(path, 1.0, 0.004))
    assert off.max() <= narrow.force_error < 1e-7 and np.ptp(narrow.force) > 1e-5


RATES, SHARES = 10.0 ** -np.arange(0.0, 8.0, 2.0), np.array([0.9, 0.09, 0.009, 0.001])


def hyperexponential_force(path: np.ndarray) -> list[float]:
    """F(X) of thresholds that are exponential at one of RATES, by eigenvectors: p' = p (r a - diag r) is symmetric once
    scaled, and each phase's stretch is its p folded with e^(-rX)."""
    with mpmath.workdps(60):
        rates, shares = ([mpmath.mpf(float(value)) for value in row] for row in (RATES, SHARES))
        shares = [share / sum(shares) for share in shares]
        scale = [mpmath.sqrt(share / rate) for share, rate in zip(shares, rates, strict=True)]
        size = range(len(rates))
        matrix = mpmath.matrix(len(rates))
        for i in size:
            for j in size:
                matrix[i, j] = scale[i] * rates[i] * shares[j] / scale[j] - (rates[i] if i == j else 0)
        values, vectors = mpmath.eigsy((matrix + matrix.T) / 2)
        forces = []
        for x in (mpmath.mpf(float(value)) for value in path):
            total = mpmath.mpf(0)
            for k in size:
                begun = sum(shares[i] / scale[i] * vectors[i, k] for i in size)
                for i in size:
                    s, r = values[k], -rates[i]
                    folded = x * mpmath.exp(s * x) if s == r else (mpmath.exp(s * x) - mpmath.exp(r * x)) / (s - r)
                    total += begun * vectors[i, k] * scale[i] * folded
            forces.append(float(total))
        return forces


def test_lives_of_all_lengths_are_followed_by_steps_wider_than_most() -> None:
    law = origins.mixture([scipy.stats.expon(scale=1.0 / rate) for rate in RATES], SHARES / SHARES.sum())
    contacts = Contacts(law)
    for end in (3e5, 1e8):
        path = np.geomspace(1e-6, 1.0, 25) * end * contacts.mean_threshold
        found = master.solve(contacts, path, 1e-6)
        off = np.abs(found.force - hyperexponential_force(path)).max() / contacts.mean_threshold
        assert found.success and off <= found.force_error, found.message


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_contacts_hot_enough_to_break_a_million_times_on_the_way(law: str) -> None:
    contacts = Contacts(WIDE, thermal=Thermal(law, 0.1, 1e12))
    path = np.array([0.002, 0.01, 0.5, 5.0, 1e3])
    with CountedCalls() as told:
        found = master.solve(contacts, path)
    assert found.success and told.number < 1_000_000, found.message
    # nearer lattices, none of which is too wide for what lives for so long
    near = master.solve(contacts, path[:1], 1e-12)
    assert abs(found.force[0] - near.force[0]) <= found.force_error + near.force_error
    np.testing.assert_allclose(found.force[3:], master.steady_state(contacts).force, atol=found.force_error)


def test_waves_that_hardly_fade_are_followed() -> None:
    path = np.linspace(3e4 - 3.0, 3e4, 60)
    found = master.solve(Contacts(gaussian(1.0, 0.002)), path, 1e-4)
    off = np.abs(found.force - gaussian_force(path, 1.0, 0.002)).max()
    assert off <= found.force_error < 1e-3
