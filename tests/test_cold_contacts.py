"""Contacts at room temperature: barriers of thousands of k_BT, tried 1e12 times a second, on any path."""

import numpy as np
import pytest

import master
from origins import Contacts, Delay, Thermal, Thresholds, gaussian, identical
from tests.moving_contacts import move

WIDE = gaussian(1.0, 0.2)
ROOM = Thermal("soft", 1e-4, 1e12)


@pytest.mark.parametrize("kind", ["soft", "stiff"])
def test_a_hold_of_years_breaks_in_the_logarithm_of_time(kind: str) -> None:
    """Broken ones stay out: what holds is a sum over thresholds, of which each has spent what rates tell."""
    thermal = Thermal(kind, 1e-4, 1e12)  # type: ignore[arg-type]
    time = np.append(0.8, 0.8 + np.logspace(-6.0, 9.0, 6))
    solved = master.solve(Contacts(WIDE, thermal=thermal, delay=Delay(1e12)), np.full(7, 0.8), 1e-4, time=time)
    assert solved.success, solved.message
    # right above the stretch in the root of the way, where rates of stiff contacts have a root
    cuts = np.append(np.linspace(0.0, 0.25, 1500), np.linspace(0.25, 1.2, 60)[1:])[:, None]
    nodes, weights = np.polynomial.legendre.leggauss(8)
    roots, weights = cuts[:-1] + np.diff(cuts, axis=0) * 0.5 * (nodes + 1.0), 0.5 * np.diff(cuts, axis=0) * weights
    limit = 0.8 + roots * roots
    moved, rate = thermal.cumulative(0.8, limit, 0.0), thermal.rate(0.8, limit)
    for lasts, held in zip(time - 0.8, solved.holding, strict=True):
        known = float((weights * 2.0 * roots * WIDE.pdf(limit) * np.exp(-moved - lasts * rate)).sum())
        assert abs(held - known) < solved.force_error + 1e-9
    # even in ln t: so thick a layer for each factor
    fallen = -np.diff(solved.holding[3:])
    assert fallen.max() < 1.25 * fallen.min() and fallen.min() > 1e-4


def test_a_soft_slider_slips_a_little_before_it_would_without_temperature() -> None:
    path = np.linspace(0.0, 2.8, 15)[1:]
    plain = master.solve(Contacts(WIDE), path, 1e-8, spring=0.4)
    thermal = Thermal("soft", 1e-5, 1e12)
    solved = master.solve(Contacts(WIDE, thermal=thermal), path, 1e-3, spring=0.4)
    assert solved.success and solved.slips.drive.size == 1
    # each threshold counts as if less by what it takes to break on that way
    sooner = thermal.temperature * np.log(thermal.attempt_frequency * thermal.temperature)
    assert 0.0 < (plain.slips.drive - solved.slips.drive)[0] < 10.0 * sooner + solved.slips.drive_error


def test_a_soft_slider_that_does_not_slip_bears_what_its_own_motion_tells() -> None:
    drive = np.linspace(0.0, 2.6, 14)[1:]
    contacts = Contacts(WIDE, thermal=Thermal("soft", 1e-4, 1e12))
    solved = master.solve(contacts, drive, 1e-3, spring=3.0)
    rigid = master.solve(contacts, solved.position, 1e-8)
    assert solved.success and not solved.slips.drive.size
    # at another speed contacts break a layer sooner or later, as thick as k_BT times its logarithm
    assert np.abs(rigid.force - solved.force).max() < solved.force_error + 2e-4


def test_a_spring_a_little_stiffer_than_critical_holds_the_slider() -> None:
    """At T = 1e-8 heat blurs an onset by one part in ten thousand, not by more."""
    cold = Contacts(WIDE, thermal=Thermal("soft", 1e-8, 1e12))
    path = np.linspace(0.0, 1.75, 11)[1:]
    plain = master.solve(Contacts(WIDE), path, 1e-9, spring=1.041)  # 1.005 K*
    heated = master.solve(cold, path, 1e-3, spring=1.041)
    assert heated.success and not heated.slips.drive.size and not plain.slips.drive.size
    assert np.abs(heated.force - plain.force).max() <= heated.force_error + 1e-4


@pytest.mark.parametrize(
    ("law", "path", "time"),
    [
        (WIDE, [0.8, 0.8], [1e4, 2e4]),
        (WIDE, [0.8, 0.8, 0.9], [1e3, 1e3 + 1e-9, 1e3 + 0.1]),
        (WIDE, [0.8, 0.8, 0.9, 0.9], [1.0, 1e6, 1e6 + 1.0, 1e6 + 2.0]),
        (identical(1.0), [0.5, 0.5], [1.0, 2.0]),
    ],
)
def test_attempts_closer_than_times_are_rounded(law: Thresholds, path: list[float], time: list[float]) -> None:
    contacts = Contacts(law, thermal=ROOM)
    solution = master.solve(contacts, path, 1e-4, time=time)
    assert solution.success
    force, error, _ = move(contacts, np.array(path), np.array(time), 20_000)
    assert (np.abs(solution.force - force) < 4.5 * error + solution.force_error).all()
