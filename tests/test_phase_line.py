"""K* along speeds and temperatures, against the steepest fall of F(X) and the propensity at single points."""

import numpy as np
import pytest

import master
from origins import Ageing, Contacts, InputError, Thermal, gaussian, identical

NARROW = gaussian(1.0, 0.05)


def test_a_table_is_the_propensity_at_each_point_and_the_steepest_fall() -> None:
    contacts = Contacts(NARROW, thermal=Thermal("soft", 0.3))
    speeds, temperatures = np.array([0.3, 10.0]), np.array([0.0, 0.1, 0.3])
    line = master.phase_line(contacts, speeds[:, None], temperature=temperatures)
    assert line.critical_spring.shape == line.critical_spring_error.shape == (2, 3)
    # hotter or slower, smoother (Fig. A08e); cold, x P_c(x) - 1 at its largest
    assert (np.diff(line.critical_spring, axis=1) < 0.0).all()
    assert (np.diff(line.critical_spring, axis=0)[:, 1:] > 0.0).all()
    x = np.linspace(0.9, 1.1, 200_001)
    cold = (x * NARROW.pdf(x)).max() - 1.0
    assert (np.abs(line.critical_spring[:, 0] - cold) <= line.critical_spring_error[:, 0] + 1e-8).all()
    for i, j in ((0, 2), (1, 1)):
        warm = Contacts(NARROW, thermal=Thermal("soft", float(temperatures[j])))
        single = master.propensity(warm, velocity=float(speeds[i]))
        off = abs(line.critical_spring[i, j] - single.critical_spring)
        assert off <= line.critical_spring_error[i, j] + single.critical_spring_error < 1e-5
        path = np.linspace(0.9, 1.1, 2001)
        force = master.solve(warm, path, 1e-10, velocity=float(speeds[i])).force
        assert single.critical_spring == pytest.approx(-np.diff(force).min() / (path[1] - path[0]), rel=1e-5)


def test_slow_contacts_age_and_let_go_more_steeply() -> None:
    # the laws of Fig. A06; where ageing ends stick-slip is found by another road
    contacts = Contacts(gaussian(0.5, 0.05), 0.02, ageing=Ageing(gaussian(1.0, 0.02), 5e-4))
    line = master.phase_line(contacts, [2.0, 4.0], tolerance=1e-5)
    assert line.critical_spring[0] > line.critical_spring[1] + 0.1
    critical = master.critical_velocity(contacts, float(line.critical_spring[1]), 3.9, 4.1)
    slope = abs(line.critical_spring[1] - line.critical_spring[0]) / 2.0
    assert abs(critical.velocity - 4.0) <= critical.velocity_error + 2.0 * line.critical_spring_error[1] / slope
    assert critical.velocity_error < 0.01


def test_points_at_which_nothing_tells_are_one() -> None:
    line = master.phase_line(Contacts(NARROW, 0.1), np.geomspace(1e-6, 1e6, 50))
    assert np.ptp(line.critical_spring) == 0.0 and line.critical_spring[0] == pytest.approx(
        master.propensity(Contacts(NARROW, 0.1)).critical_spring, abs=1e-6
    )
    assert np.isinf(master.phase_line(Contacts(identical(1.0))).critical_spring)
    with pytest.raises(InputError, match="temperature: these contacts have no law for it"):
        master.phase_line(Contacts(NARROW), temperature=[0.1])
