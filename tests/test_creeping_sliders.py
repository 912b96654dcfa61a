"""Sliders that creep on the spring of a machine, while their contacts age or heat breaks them: what steps in time must
resolve there, and when they stop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import slow
from scipy.optimize import brentq
from scipy.special import pbdv

import master
import origins
from master.motion import Motion
from master.soft.in_time.cells import Cells
from master.soft.in_time.decohered import Decohered, decohered
from master.soft.in_time.steps import Node
from master.steady import response
from origins import Ageing, Contacts, Delay, Drive, InputError, Thermal, gaussian

SOFTEST = 1e-6
# They age to thresholds of one width, in the unit of time D/w^2 = 1.
TO_OLD = Contacts(gaussian(0.5, 0.05), ageing=Ageing(gaussian(1.0, 0.02), 4e-4))


@pytest.mark.parametrize(("widths_below", "within"), [(3.0, 1e-4), (5.0, 5e-3), (6.0, 3e-2)])
def test_old_contacts_meet_a_level_far_below_their_thresholds_at_the_rate_of_an_eigenvalue(
    widths_below: float, within: float
) -> None:
    """Of an Ornstein-Uhlenbeck process before a level that absorbs it: D_nu(-g) = 0, on the coarsest cells. With ones
    that are as wide near the level as elsewhere the rate at 6 widths was off by a half."""
    rate = brentq(lambda nu: pbdv(nu, -widths_below)[0], 1e-14, 0.5, xtol=1e-20)
    cells, relaxed = Cells(TO_OLD, -1, 1.0), np.zeros(1)
    level = np.array([1.0 - 0.02 * widths_below])
    old = cells.stepped(cells.fresh(relaxed), relaxed, relaxed, 50.0)
    left = [cells.stepped(old, relaxed, level, 1e-3)]
    while len(left) < 41:
        left.append(cells.stepped(left[-1], level, level, 1.0))
    found = np.log(left[20].sum() / left[40].sum()) / 20.0
    assert found == pytest.approx(rate, rel=within)


@pytest.mark.slow
def test_three_slips_of_contacts_that_age_fast_on_the_spring_of_a_machine() -> None:
    """They creep before each slip, on which their rate of breaking grows by e on a fifth of a width. The force at a
    slip is that of steps halved four times, 0.88105; each reset is as the first."""
    young = Contacts(gaussian(0.5, 0.05), ageing=Ageing(gaussian(1.0, 0.02), 1e-2))
    path = np.linspace(0.0, 2.8e6, 50)[1:]
    found = master.solve(young, path, 1e-4, spring=SOFTEST, slip="reset")
    assert found.success and found.slips.drive.size == 3, found.message
    assert found.slips.force_before == pytest.approx(0.881051, abs=0.5 * found.force_error)
    assert found.slips.force_before == pytest.approx(0.881051, abs=1e-5)


def test_a_slide_that_the_finest_steps_would_not_tell_is_refused_before_they_are_taken() -> None:
    """Behind its slip it slides with the drive, where many of the births of a step break before its end: 1.3e-4 was
    told after 17 s of steps."""
    young = Contacts(gaussian(1.0, 0.37), ageing=Ageing(gaussian(1.3, 0.14), 0.047))
    path = np.linspace(0.8, 8.0, 9)
    with pytest.raises(
        InputError, match=r"^tolerance = 0\.0001: .* known to some 4\.3e-04 .*loosen it"
    ):
        master.solve(young, path, 1e-4, spring=0.2, slip="instant")


@pytest.mark.slow
def test_a_slip_with_fast_attempts_of_heat_on_the_spring_of_a_machine() -> None:
    """Breaks follow each other fast as the slip begins: F changed by 1e-4 within the accuracy of a step's balance."""
    hot = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.01, 1e3))
    path = np.linspace(0.0, 1.8e6, 50)[1:]
    found = master.solve(hot, path, 1e-4, spring=SOFTEST, slip="instant")
    assert found.success and found.slips.drive.size == 1, found.message
    kinetic = master.steady_state(hot, velocity=1.0).force
    assert abs(found.force[-1] - kinetic) <= found.force_error


@pytest.mark.parametrize(
    ("width", "temperature", "attempts", "known"),
    [(0.2, 0.02, 1e-3, (659_322.0, 183.0)), slow(0.3, 0.05, 1e-2, (596_531.0, 115.0))],
)
def test_behind_a_long_slip_in_weak_heat_the_slider_goes_on_with_its_drive(
    width: float, temperature: float, attempts: float, known: tuple[float, float]
) -> None:
    """In steps F is a little off F_k, which it sought in a hundred small slips, more than one path may have; heat
    changes F_k by 1e-5 at most. The slip is the one known by finer steps, and F behind it <x_s^2>/(2 <x_s>)."""
    law = gaussian(1.0, width)
    warm = Contacts(law, thermal=Thermal("soft", temperature, attempts))
    asked: dict[str, Any] = {"spring": SOFTEST, "slip": "instant"}
    found = master.solve(warm, [1.0e6, 2.0e6, 3.0e6], 1e-3, **asked)
    assert found.success and found.slips.drive.size == 1, found.message
    place, error = known  # at 2e-4
    assert found.slips.drive == pytest.approx(place, abs=found.slips.drive_error + error)
    assert found.force == pytest.approx(law.moment(2) / (2.0 * law.mean()), abs=2e-5)


@pytest.mark.slow
def test_behind_a_long_slip_on_a_stiffer_spring_steps_lead_to_the_same_force(
    monkeypatch: Any,
) -> None:
    """A slip of eighty thresholds, of which steps go on to F_k; and one of a drive that goes back."""
    warm = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.02, 1e-3))
    asked: dict[str, Any] = {"spring": 2e-3, "slip": "instant"}
    path = np.linspace(0.0, 400.0, 31)
    at_once = master.solve(warm, path, 2e-3, **asked)
    back = master.solve(warm, -path, 2e-3, **asked)
    monkeypatch.setattr(Decohered, "slid_to_end", lambda *asked: None)
    in_steps = master.solve(warm, path, 2e-3, **asked)
    assert at_once.success and in_steps.success and at_once.nodes < 0.5 * in_steps.nodes
    off = at_once.force_error + in_steps.force_error
    assert at_once.force == pytest.approx(in_steps.force, abs=off)
    assert back.force == pytest.approx(-at_once.force, abs=1e-9)


@pytest.mark.parametrize("off", [0.0, 0.01])
def test_a_force_behind_a_long_slip_that_is_not_that_of_steady_sliding_is_an_error(
    off: float,
) -> None:
    """Breaks may seem steady along a threshold before they are, as while strong contacts are not met."""
    warm, path = (
        Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.02, 1e-3)),
        np.array([2.0e6]),
    )
    long = decohered(warm, Drive(path, spring=SOFTEST, slip="instant"), 16, 1e-3)
    begin = Node(0.0, 7.0e5, 0.52 + off, 1.0, 1.0e5)
    assert long is not None
    on = long.slid_to_end(begin, Motion(np.array([0.0, 2.0e6]), np.array([0.0, 2.0e6])), np.inf)
    assert on is not None and on.error == pytest.approx(off, abs=1e-5)
    assert on.sections[0][-1].position == pytest.approx(2.0e6 - 0.52 / SOFTEST, abs=1.0)


def test_resets_that_are_repeated_take_no_steps() -> None:
    """Twenty slips in heat, each of which leaves all contacts new, are those of the first few."""
    hot = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.01, 1e-2))
    asked: dict[str, Any] = {"spring": SOFTEST, "slip": "reset"}
    few = master.solve(hot, [2.0e6], 1e-2, **asked)
    many = master.solve(hot, [1.5e7], 1e-2, **asked)
    assert many.success and many.slips.drive.size > 20, many.message
    periods, off = np.diff(many.slips.drive), few.slips.period_error
    assert np.ptp(periods) < 1e-9 * periods[0]
    assert periods[0] == pytest.approx(few.slips.period, abs=off)


def test_wall_time_ends_the_search_for_speeds_at_which_creep_is_stable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By a clock that tells how often the answer to a disturbance was asked for: a fast drive asks at each decade of
    the speed down to that of the slider."""
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Thermal("eyring", width=0.03))
    answered, answer = list[float](), response.response

    def counted(contacts: origins.Contacts, velocity: float, waves: np.ndarray) -> np.ndarray:
        answered.append(velocity)
        return answer(contacts, velocity, waves)

    monkeypatch.setattr(response, "response", counted)
    monkeypatch.setattr("time.monotonic", lambda: float(len(answered)))
    asked: dict[str, Any] = {"velocity": 1e-4, "spring": 3e-3, "slip": "instant"}
    path = [0.0, 192.0, 1920.0]
    assert master.solve(contacts, path, 1e-2, wall_time=1e9, **asked).success
    assert len(answered) > 3
    answered.clear()
    found = master.solve(contacts, path, 1e-2, wall_time=1.5, **asked)
    assert not found.success and "wall_time" in found.message and len(answered) <= 2


@pytest.mark.parametrize("slip", ["reform-after", "instant"])
def test_a_long_delay_on_a_soft_spring_in_heat_is_refused_before_the_work(slip: Any) -> None:
    """Steps would take thousands of them, and a shorter delay is followed."""
    heat, path = Thermal("soft", 0.01, 1e-2), [2e4]
    slow = Contacts(gaussian(1.0, 0.2), thermal=heat, delay=Delay(1e3))
    asked: dict[str, Any] = {"spring": 1e-4, "slip": slip, "wall_time": 60.0}
    told = r"path\[-1\] = 20000.*: contacts come back one by one .* moves by 1e\+03 mean .* from 900 on"
    with pytest.raises(InputError, match=told + '; end the path before .* or take "reset"'):
        master.solve(slow, path, 1e-2, **asked)
    # a shorter one is followed, or one of which heat breaks the contacts before a slip
    quick = slow.replace(delay=Delay(1.0))
    assert np.isfinite(master.solve(quick, [5e3], 1e-2, **asked).force_error)
