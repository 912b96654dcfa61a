"""Temperatures from 1e-6 to 1e3 and ω/v from 1e-12 to 1e12: 100 kinetic forces by mpmath, starts on either side of 0,
and the limits of the kinetic force as fitted exponents."""

import numpy as np
import pytest
from thermal_table import force, points, stored

import master
from origins import Contacts, Delay, Thermal, gaussian, gaussian_start, rectangular

NARROW = gaussian(1.0, 0.05)


def test_kinetic_forces_are_those_by_mpmath() -> None:
    rows = stored()
    assert [row[:4] for row in rows] == list(points()) and len(rows) == 100
    for law, closure, temperature, rate, known in rows:
        steady = master.steady_state(Contacts(NARROW, thermal=Thermal(law, temperature, rate, closure=closure)))
        assert steady.force == pytest.approx(known, rel=1e-9), (law, closure, temperature, rate)
        assert abs(steady.force - known) <= steady.force_error + 1e-11 * known
        assert steady.force_error <= 2e-7 * steady.force


@pytest.mark.parametrize("number", [50, 61])
def test_the_table_is_what_mpmath_says(number: int) -> None:
    *point, known = stored()[number]
    assert float(force(*point, count=6)) == pytest.approx(known, rel=1e-7)


@pytest.mark.parametrize("closure", ["exact", "paper"])
@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_starts_on_either_side_of_zero(law: str, closure: str) -> None:
    """From 0.5, -0.5 and around 0 to the same kinetic force; hot and slow contacts break at once, cold and fast ones
    at their thresholds."""
    for temperature, rate in [(1e-6, 1e12 if closure == "exact" else 1e3), (0.03, 1e6), (1e3, 30.0), (1e3, 1e-3)]:
        thermal = Thermal(law, temperature, rate, closure=closure)
        steady = master.steady_state(Contacts(NARROW, thermal=thermal))
        path = np.append(np.geomspace(1e-3, 1.0, 6), [1e3, 1e9]) * 40.0
        for start in (0.5, -0.5, gaussian_start(-0.1, 0.01)) if rate < 1.0 else (0.5, -0.5):
            found = master.solve(Contacts(NARROW, start, thermal=thermal), path, 1e-6)
            assert found.success, (temperature, rate, start, found.message)
            assert np.abs(found.force[-2:] - steady.force).max() <= 1e-6
            assert (np.abs(found.force) <= 1.3).all()


def fitted(x: np.ndarray, y: np.ndarray) -> float:
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_slow_sliding_is_linear_in_speed_and_logarithmic_before(law: str) -> None:
    contacts = Contacts(NARROW, thermal=Thermal(law, 0.1))
    slow = np.geomspace(1e-12, 1e-9, 7)
    creep = master.kinetic_curve(contacts, slow).force
    assert fitted(slow, creep) == pytest.approx(1.0, abs=1e-5)
    # in between, over three orders of magnitude, F_k is straight in ln v and its slope near T/(2 x_s)
    cold = Contacts(NARROW, thermal=Thermal("soft", 1e-3))
    speed = np.geomspace(1e-12, 1e-9, 7)
    force_at = master.kinetic_curve(cold, speed).force
    slope, _ = np.polyfit(np.log(speed), force_at, 1)
    straight = np.polyval(np.polyfit(np.log(speed), force_at, 1), np.log(speed))
    assert np.abs(force_at - straight).max() < 0.01 * np.ptp(force_at)
    assert slope == pytest.approx(0.5e-3, rel=0.05)


@pytest.mark.parametrize(
    ("law", "closure", "power"), [("soft", "exact", 2.0), ("stiff", "exact", 5.0 / 3.0), ("soft", "paper", 1.0)]
)
def test_fast_sliding_loses_force_as_a_power_of_temperature(law: str, closure: str, power: float) -> None:
    cold = master.steady_state(Contacts(NARROW)).force
    temperature = np.array([1e-6, 1e-5]) if closure == "paper" else np.array([1e-5, 1e-4])
    lost = [
        cold - master.steady_state(Contacts(NARROW, thermal=Thermal(law, float(t), closure=closure))).force
        for t in temperature
    ]
    assert fitted(temperature, np.array(lost)) == pytest.approx(power, abs=0.01)
    if (law, closure) == ("soft", "exact"):
        assert lost[0] == pytest.approx(0.5 * temperature[0] ** 2, rel=0.01)
        speed = np.geomspace(1e3, 1e5, 3)
        warm = master.kinetic_curve(Contacts(NARROW, thermal=Thermal(law, 0.1)), speed).force
        assert fitted(speed, cold - warm) == pytest.approx(-1.0, abs=0.01)


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_cold_rectangles_at_the_highest_rates(law: str) -> None:
    """Stretches at which they break are known to 1e-16, and p changes over 1e-6 of them: tables of p give but 5e-5."""
    thermal = Thermal(law, 1e-6, 1e12)
    # every contact breaks below its threshold, at A = e of the exponential law: trapezoids in ln e, Gauss in ξ
    u = np.arange(-36.0, 4.5, 0.05)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    x = thermal.inverse(np.exp(u), (1.0 + 0.5 * nodes)[:, None])
    chance = 0.05 * np.exp(u - np.exp(u))
    length, square = (float(0.5 * weights @ (x**n @ chance)) for n in (1, 2))
    contacts = Contacts(rectangular(0.5, 1.5), thermal=thermal, delay=Delay(0.5))
    found = master.steady_state(contacts)
    force = 0.5 * square / (length + 0.5)
    assert abs(found.force - force) <= found.force_error + 1e-12 < 1e-9
    assert abs(found.holding - length / (length + 0.5)) < 1e-9


def test_laws_far_beyond_the_lattice_leave_it_empty() -> None:
    """Contacts that hold for 1e-18 and wait for 0.3: positions in widths of the law are beyond whole numbers."""
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 1e3, 1e18), delay=Delay(0.3))
    found = master.solve(contacts, [1.0, 2.0])
    assert not found.success and "too narrow to follow" in found.message and (np.abs(found.force) < 1e-15).all()
