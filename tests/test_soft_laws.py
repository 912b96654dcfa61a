"""Soft sliders with temperature, delay and re-forming: every slip, and what comes of holds."""

from typing import Any

import numpy as np
import pytest

import master
from master.soft.regime import regime
from master.soft.slips import Slips
from origins import (
    Ageing,
    Contacts,
    Delay,
    Drive,
    InputError,
    Thermal,
    gaussian,
    gaussian_start,
    gw_plastic,
)
from origins.drive import SlipRule

WIDE = gaussian(1.0, 0.2)
SOFT = Thermal("soft", 0.1)
PATH = np.linspace(0.0, 3.6, 37)[1:]


@pytest.mark.parametrize("rule", ["instant", "reform-after"])
def test_without_rates_every_slip_is_that_of_cohorts(rule: SlipRule) -> None:
    path = PATH[:30]
    exact = master.solve(Contacts(WIDE), path, 1e-8, spring=0.4, slip=rule)
    never = Contacts(WIDE, thermal=Thermal("soft", 0.1, 1e-12))
    solved = master.solve(never, path, 1e-2, spring=0.4, slip=rule)
    assert solved.success, solved.message
    slips, known = solved.slips, exact.slips
    assert slips.drive.size == known.drive.size >= 1
    assert np.abs(slips.drive - known.drive).max() * 0.4 <= solved.force_error
    assert np.abs(slips.force_after - known.force_after).max() <= solved.force_error
    assert np.abs(solved.force - exact.force).max() <= solved.force_error


def test_where_nothing_slips_the_force_is_that_of_the_sliders_own_motion() -> None:
    contacts = Contacts(WIDE, 0.1, thermal=SOFT)
    path = np.linspace(0.0, 1.5, 76)[1:]
    soft = master.solve(contacts, path, 1e-2, velocity=0.3, spring=2.0)
    assert soft.success and not soft.slips.drive.size and soft.regime.verdict == "smooth"
    assert soft.balance == pytest.approx(0.05)
    clock = np.abs(np.diff(path, prepend=0.05)).cumsum() / 0.3
    rigid = master.solve(contacts, soft.position, 1e-2, time=clock)
    # straight between the points, which the slider's own motion is not
    assert np.abs(rigid.force - soft.force).max() < 3e-4


def test_stiff_contacts_far_hotter_than_the_drive_is_fast_let_the_force_settle_at_the_kinetic_one() -> (
    None
):
    contacts = Contacts(gaussian(1.0, 0.1), thermal=Thermal("stiff", 0.1, 1e4))
    soft = master.solve(contacts, np.linspace(0.0, 0.16, 3), 1e-3, spring=1.0)
    assert soft.success and soft.regime.verdict == "smooth"
    assert 0.9 < soft.force[-1] / master.steady_state(contacts).force < 1.01


@pytest.mark.parametrize("spring", [1e-6, 0.3])
def test_a_spring_however_soft_slips_as_without_ageing_where_nothing_has_time_to_age(
    spring: float,
) -> None:
    path = np.linspace(0.0, 1.2 * (1.0 / spring + 1.0), 25)
    plain = master.solve(Contacts(WIDE), path, 1e-9, spring=spring)
    aged = master.solve(
        Contacts(WIDE, ageing=Ageing(gaussian(1.5, 0.3), 1e-14)), path, 1e-3, spring=spring
    )
    assert aged.success and aged.nodes < 100
    assert np.abs(aged.slips.drive - plain.slips.drive).max() <= aged.slips.drive_error
    assert np.abs(aged.force - plain.force).max() <= aged.force_error


def test_a_path_that_takes_too_many_steps_is_refused_before_long() -> None:
    far = r"\d+ steps led to a time of [\d.]+ only, and more are not taken on; end the path sooner"
    with pytest.raises(InputError, match=rf"^path\[-1\] = 500\.0: {far}$"):
        master.solve(Contacts(WIDE, thermal=SOFT), [0.0, 500.0], 1e-2, spring=3.0)


def test_a_slower_drive_slips_at_a_smaller_force_and_in_the_end_not_at_all() -> None:
    contacts = Contacts(WIDE, thermal=SOFT)
    slow, slower = (
        master.solve(contacts, PATH[:27], 1e-2, velocity=v, spring=0.4, slip="reset")
        for v in (1.0, 0.1)
    )
    cold = master.solve(Contacts(WIDE), PATH[:27], 1e-6, spring=0.4, slip="reset")
    assert cold.slips.force_before[0] > slow.slips.force_before[0] + 0.01
    assert slow.slips.after[0] == pytest.approx(slow.slips.drive[0], abs=1e-12)
    assert slower.success and not slower.slips.drive.size and slower.regime.verdict == "undecided"


def test_a_slider_that_creeps_as_fast_as_the_drive_is_smooth_below_the_rigid_critical_spring() -> (
    None
):
    """Until its force stays as it is, only why nothing can be told."""
    contacts = Contacts(WIDE, thermal=SOFT)
    early, late = (
        master.solve(contacts, np.linspace(0.0, end, 25), 1e-2, velocity=0.1, spring=0.4)
        for end in (2.7, 8.0)
    )
    assert (
        not early.slips.drive.size
        and not late.slips.drive.size
        and late.regime.stiffness_ratio < 1.0
    )
    assert early.regime.verdict == "undecided" and "K < K*" in early.regime.reason
    assert late.regime.verdict == "smooth", late.regime.reason
    assert late.force[-1] == pytest.approx(
        master.steady_state(contacts, velocity=0.1).force, rel=0.02
    )


def test_contacts_that_break_in_a_slip_wait_out_their_delay() -> None:
    contacts = Contacts(WIDE, delay=Delay(0.2))
    path = np.linspace(2.4, 2.8, 25)
    solved = master.solve(contacts, path, 1e-2, spring=0.4, slip="instant")
    same = master.solve(contacts, path, 1e-2, spring=0.4, slip="reform-after")
    np.testing.assert_array_equal(solved.force, same.force)
    slip = solved.slips.drive[0]
    out = (path > slip) & (path < slip + 0.19)
    # all that slips leave holding are those few that are strongest
    assert solved.holding[out].max() < 0.2 and solved.holding[path > slip + 0.21].min() > 0.8
    assert np.abs(solved.force - 0.4 * (path - solved.position)).max() < 1e-12


def test_a_drive_that_holds_lets_the_slider_creep() -> None:
    path, time = np.array([0.9, 0.9, 0.9, 1.6]), np.array([0.9, 10.0, 100.0, 100.7])
    solved = master.solve(Contacts(WIDE, thermal=SOFT), path, 1e-2, time=time, spring=1.5)
    assert solved.success, solved.message
    assert (np.diff(solved.position) > 0.0).all() and (np.diff(solved.force[:3]) < 0.0).all()
    assert solved.force[2] < 0.4 * solved.force[0] and solved.force[3] > solved.force[2] + 0.3


def test_what_has_no_answer_is_said() -> None:
    with pytest.raises(
        InputError, match=r"^slip = 'reform-after': takes contacts that form again at x = 0"
    ):
        master.solve(Contacts(WIDE, reforming=0.1), PATH, spring=0.4, slip="reform-after")
    with pytest.raises(
        InputError,
        match=r"^path\[0\] = 0.0: at time 0 the drive stands where it balances the start",
    ):
        master.solve(Contacts(WIDE, 0.2, thermal=SOFT), [0.0, 2.0], time=[0.0, 1.0], spring=0.4)
    with pytest.raises(InputError, match='closure = "paper" is not followed under a spring'):
        master.solve(
            Contacts(WIDE, thermal=Thermal("soft", 0.1, closure="paper")), PATH, spring=0.4
        )
    cold = Contacts(WIDE, thermal=Thermal("stiff", 1e-4))
    with pytest.raises(
        InputError, match=r"^thermal: contacts of stiff rates that break within so thin a skin"
    ):
        master.solve(cold, PATH, 1e-3, spring=0.4)


def test_a_start_whose_mean_is_nothing_but_rounding_does_not_slip() -> None:
    path = np.linspace(0.0, 2.5, 6)
    centred, beside = (
        master.solve(
            Contacts(WIDE, gaussian_start(mean, 0.05), reforming=0.1), path, 1e-3, spring=0.4
        )
        for mean in (0.0, 1e-6)
    )
    assert not centred.slips.drive.size and centred.success
    assert (
        np.abs(centred.force - beside.force).max() < 2e-6 + centred.force_error + beside.force_error
    )
    alone = master.solve(Contacts(WIDE, delay=Delay(0.2)), [0.0], spring=1.0)
    assert alone.success and alone.force.tolist() == [0.0]


@pytest.mark.parametrize(
    "laws",
    [{"thermal": SOFT}, {"ageing": Ageing(gaussian(1.2, 0.1), 1e-2)}],
    ids=["temperature", "ageing"],
)
def test_one_reset_is_judged_alike_whatever_the_rates(laws: dict[str, Any]) -> None:
    """From relaxed contacts it repeats, as they are what it leaves; from others a second slip must show it."""
    path, once = np.linspace(0.0, 3.0, 31), np.array([1.9])
    drive = Drive(path, spring=0.5, slip="reset")
    slip = Slips(once, once, once, 0.6 * once, 0.0 * once, 1e-4)
    for start, verdict in ((None, "stick-slip"), (0.1, "undecided")):
        found = regime(Contacts(gaussian(1.0, 0.1), start, **laws), drive, slip, 1e-4)
        assert found.verdict == verdict and found.reason.startswith("one slip")


def test_slips_that_only_coarse_steps_find_leave_an_error_estimate() -> None:
    contacts = Contacts(gw_plastic(1.0), thermal=Thermal("soft", 0.11, 0.109))
    path = np.linspace(0.0, 13.0, 91)[1:]
    soft = master.solve(contacts, path, 1e-3, velocity=2.475, spring=0.05566)
    assert soft.success and not soft.slips.drive.size
    # on the slider's own way, straight between its points and between every other of them: of second order
    clock = path / 2.475
    fine, coarse = (
        master.solve(contacts, soft.position[some], 1e-4, time=clock[some])
        for some in (slice(None), slice(1, None, 2))
    )
    apart = np.abs(fine.force[1::2] - coarse.force).max()
    assert np.abs(fine.force - soft.force).max() <= apart + soft.force_error + fine.force_error
