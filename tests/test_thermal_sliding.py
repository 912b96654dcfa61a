"""Rigid sliding at a temperature, closure "exact": against mpmath, known limits, and discrete contacts."""

from functools import cache

import mpmath
import numpy as np
import pytest
import scipy.stats

import master
from origins import Contacts, InputError, Thermal, gaussian, gaussian_start, identical, mixture, rectangular
from tests.sampling_contacts import sample

PATH = np.linspace(0.05, 4.0, 21) + 0.013


def by_mpmath(law: str, temperature: float, rate: float, std: float = 0.05, linked: bool = False):
    """F_k of Gaussian thresholds of mean 1 from its double integral, 30 digits, panels placed by hand."""
    with mpmath.workdps(25):
        a2, std_ = 1 / (2 * mpmath.mpf(temperature)), mpmath.mpf(std)
        log_rate = mpmath.log(mpmath.mpf(rate))

        def spent(x, xi):
            if law == "soft":
                a = mpmath.sqrt(a2)
                grown = mpmath.sqrt(mpmath.pi) / 2 * mpmath.erfi(a * x) / a
                return mpmath.exp(log_rate - a2 * xi**2) * grown
            c = a2 * xi**2
            u = (1 - x / xi) ** mpmath.mpf(1.5)
            return mpmath.exp(log_rate) * 2 * xi / 3 * (mpmath.exp(-c * u) - mpmath.exp(-c)) / c

        def moments(xi):
            """Integrals of the survival and of x times it, for one threshold."""
            middle = xi
            low, high = mpmath.mpf(0), xi
            if spent(xi, xi) > 1:
                for _ in range(80):
                    middle = (low + high) / 2
                    low, high = (middle, high) if spent(middle, xi) < 1 else (low, middle)
            width = min(middle / 8, 4 * mpmath.mpf(temperature) / xi)
            cuts = {mpmath.mpf(0), xi}
            cuts |= {middle + k * width for k in (-6, -3, -1.5, -0.5, 0.5, 1.5, 3) if 0 < middle + k * width < xi}
            cuts |= {middle * k for k in (0.3, 0.7, 2, 5) if 0 < middle * k < xi}
            cuts = sorted(cuts)

            @cache
            def survival(x):
                return mpmath.exp(-spent(x, xi))

            held = [survival, lambda x: x * survival(x)]
            return [mpmath.quad(function, cuts, method="gauss-legendre", maxdegree=5) for function in held]

        # Gauss-Hermite over the thresholds: eleven standard deviations from 0 nothing is cut
        nodes, weights = np.polynomial.hermite.hermgauss(40)
        total = [mpmath.mpf(0), mpmath.mpf(0)]
        for node, weight in zip(nodes, weights, strict=True):
            if weight > 1e-19:
                xi = 1 + mpmath.sqrt(2) * std_ * mpmath.mpf(float(node))
                for n, value in enumerate(moments(xi)):
                    total[n] += mpmath.mpf(float(weight)) * value
        return float(total[1] / total[0])


@pytest.mark.parametrize("law", ["soft", "stiff"])
@pytest.mark.parametrize(("temperature", "rate"), [(0.1, 1.0), (1.0, 1e-3), (0.03, 1e4), (1e3, 1e12)])
def test_kinetic_force_against_mpmath(law: str, temperature: float, rate: float) -> None:
    steady = master.steady_state(Contacts(gaussian(1.0, 0.05), thermal=Thermal(law, temperature, rate)))
    exact = by_mpmath(law, temperature, rate)
    assert steady.force == pytest.approx(exact, rel=1e-9)
    assert steady.force_error < 1e-9 * steady.force


@pytest.mark.parametrize(
    "contacts",
    [
        Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.1)),
        Contacts(gaussian(1.0, 0.2), 0.3, thermal=Thermal("stiff", 0.01, 1e3)),
        Contacts(gaussian(1.0, 0.2), -0.4, thermal=Thermal("soft", 0.3, 10.0)),
        Contacts(rectangular(0.5, 1.5), -0.7, thermal=Thermal("stiff", 0.1)),
        Contacts(identical(1.0), -0.3, thermal=Thermal("soft", 0.1)),
        Contacts(identical(1.0), gaussian_start(0.1, 0.05), thermal=Thermal("stiff", 0.1)),
        Contacts(mixture([gaussian(1.0, 0.1), identical(0.8)], [0.7, 0.3]), thermal=Thermal("soft", 0.03, 10.0)),
        Contacts(gaussian(1.0, 0.2), gaussian_start(0.0, 0.2), thermal=Thermal("soft", 0.2, 1.0)),
    ],
)
def test_transients_are_those_of_discrete_contacts(contacts: Contacts) -> None:
    solved = master.solve(contacts, PATH, 1e-7, velocity=1.0)
    assert solved.success, solved.message
    force, error, _ = sample(contacts, PATH, 1.0, 100_000)
    assert (np.abs(solved.force - force) < 5.0 * (error + solved.force_error)).all()


def test_only_the_ratio_of_rate_and_speed_counts_and_lengths_only_scale() -> None:
    here = master.solve(Contacts(gaussian(1.0, 0.1), -0.2, thermal=Thermal("soft", 0.1, 1.0)), PATH, 1e-9)
    fast = Contacts(gaussian(1.0, 0.1), -0.2, thermal=Thermal("soft", 0.1, 1e9))
    np.testing.assert_allclose(master.solve(fast, PATH, 1e-9, velocity=1e9).force, here.force, atol=1e-9)
    small = Contacts(gaussian(1e-9, 1e-10), -0.2e-9, thermal=Thermal("soft", 0.1e-18, 1.0))
    np.testing.assert_allclose(master.solve(small, PATH * 1e-9, 1e-9, velocity=1e-9).force * 1e9, here.force, atol=1e-9)


def test_propensity_and_steady_force_agree_with_a_long_path() -> None:
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.1))
    steady, judged = master.steady_state(contacts, velocity=0.5), master.propensity(contacts, velocity=0.5)
    long = master.solve(contacts, [30.0], 1e-10, velocity=0.5)
    assert long.force[0] == pytest.approx(steady.force, abs=1e-10)
    cold = master.propensity(Contacts(gaussian(1.0, 0.2)))
    assert judged.critical_spring < cold.critical_spring
    assert judged.decoherence_length < cold.decoherence_length
    path = np.linspace(0.5, 1.2, 400)
    highest = master.solve(contacts, path, 1e-9, velocity=0.5).force.max()
    assert judged.static_to_kinetic == pytest.approx(highest / steady.force, rel=1e-5)


def arcsine_by_angles(thermal: Thermal) -> tuple[float, float]:
    """C and F_k of arcsine thresholds between 1/2 and 3/2, which are 1 + cos(t)/2 with t even on (0, π)."""
    nodes, weights = np.polynomial.legendre.leggauss(40)

    def angles(low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
        """Dense towards `high`, where a stiff contact's rate has a root."""
        root = (nodes + 1.0) / 2.0
        return high + (low - high) * root**2, (high - low) * root * weights

    def held(x: float) -> float:
        last = np.pi if x <= 0.5 else np.arccos(2.0 * (x - 1.0))
        parts = [angles(0.0, last)] + ([angles(last, np.pi)] if x > 0.5 else [])
        if thermal.closure == "exact":
            parts = parts[:1]
        total = 0.0
        for t, share in parts:
            threshold = 1.0 + 0.5 * np.cos(t)
            spent = thermal.cumulative(np.minimum(x, threshold), threshold)
            total += float(share @ (spent if thermal.closure == "paper" else np.exp(-spent))) / np.pi
        return last / np.pi * np.exp(-total) if thermal.closure == "paper" else total

    begin, share = 0.25 * (nodes + 1.0), 0.25 * weights
    t, turn = angles(0.0, np.pi)
    x, dx = np.append(begin, 1.0 + 0.5 * np.cos(t)), np.append(share, turn * 0.5 * np.sin(t))
    left = np.array([held(float(at)) for at in x])
    return float(dx @ left), float(dx @ (left * x) / (dx @ left))


@pytest.mark.parametrize("closure", ["exact", "paper"])
@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_thresholds_whose_density_diverges_below_them(law: str, closure: str) -> None:
    thermal = Thermal(law, 0.1, closure=closure)
    contacts = Contacts(scipy.stats.arcsine(loc=0.5), thermal=thermal)
    found = master.steady_state(contacts)
    length, force = arcsine_by_angles(thermal)
    assert abs(found.cycle_length - length) <= found.cycle_length_error < 1e-6
    assert abs(found.force - force) <= found.force_error < 2e-6
    if (law, closure) == ("soft", "paper"):  # the force falls without bound right there
        assert master.phase_line(contacts, 0.5).critical_spring == np.inf


def test_a_speed_at_which_no_length_is_left_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"velocity = 1e-300: contacts break by themselves"):
        master.solve(Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.1)), [0.0, 1.0], velocity=1e-300)
