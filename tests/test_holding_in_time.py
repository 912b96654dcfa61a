"""The share that holds under a spring with a delay, read from breaks, near slips that come later in one slider."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import master
from master.soft.followed import ErrorPart, Followed
from master.soft.in_time.answer.aligned import aligned_holding
from master.soft.in_time.answer.reading import read_holding
from master.soft.in_time.steps import Node
from origins import Contacts, Delay, Drive, Thermal, gaussian

DELAY, STEPS = 0.3, 9
SHARE = 0.5  # of the contacts that breaks up to the slip


def broken(time: Any, slip: float) -> Any:
    """Breaks per contact, ever faster up to a slip in which all others break, and none after it."""
    before = SHARE * (1.0 - np.sqrt(np.maximum(1.0 - time / slip, 0.0)))
    return np.where(time < slip, before, 1.0)


def sections_of(slip: float, begin: float = 0.0) -> list[list[Node]]:
    """From `begin` to a slip, in steps of even travel, and on to twice as late; no node tells the share that holds."""
    sizes = np.linspace(0.0, 1.0, STEPS)
    up_to = slip * (1.0 - (1.0 - sizes) ** 2)
    parts = [(sizes, up_to, SHARE * sizes)]
    for first, last in ((slip, slip + DELAY), (slip + DELAY, 2.0 * slip)):
        parts.append((sizes, first + (last - first) * sizes, np.ones(STEPS)))
    columns = [(size, begin + time, broke) for size, time, broke in parts]
    return [
        [Node(s, t, 0.0, 0.0, 0.0, b) for s, t, b in zip(*three, strict=True)] for three in columns
    ]


def exact(time: Any, slip: float) -> Any:
    return 1.0 - broken(time, slip) + np.where(time < DELAY, 0.0, broken(time - DELAY, slip))


def test_the_share_that_holds_follows_from_breaks_on_both_sides() -> None:
    """To rounding, though a step up to the slip is as long as the delay; what broke before all contacts are replaced,
    at t = 2, does not come back."""
    sections = sections_of(1.0) + sections_of(1.0, begin=2.0)
    time = np.array([0.0, 0.2, 0.31, 0.9, 0.999, 1.0, 1.2, 1.299, 1.301, 1.9])
    told = read_holding(sections, np.append(time, 2.0 + time), DELAY)
    assert told == pytest.approx(np.tile(exact(time, 1.0), 2), abs=1e-12)


def test_slips_that_come_later_in_one_slider_leave_the_share_its_limit() -> None:
    """Errors of a slip's time fall by four: the share is that of its limit, t = 1, though beside the slip and a delay
    later it differs by more at one time."""
    late = 1.0 + 1e-2 * np.array([16.0, 4.0, 1.0])
    sliders: Any = [
        SimpleNamespace(
            sections=sections_of(slip),
            contacts=SimpleNamespace(delay=DELAY, memory=SimpleNamespace(safety=3.0)),
            motion=SimpleNamespace(times=np.array([0.0, 2.0])),
        )
        for slip in late
    ]
    time = np.array([0.05, 0.9, 0.99, 1.01, 1.25, 1.29, 1.31, 1.6])
    found = aligned_holding(sliders, late[:, None], time)
    assert found is not None
    plain = [read_holding(each.sections, time, DELAY) for each in sliders]
    at_one_time = plain[2] + (plain[2] - plain[1]) / 3.0
    error = np.abs(found.holding - exact(time, 1.0))
    assert error.max() < 2e-3 < 2e-2 < np.abs(at_one_time - exact(time, 1.0)).max()
    assert (error < 3.0 * found.changes.min(axis=0) + 1e-12).all()
    assert aligned_holding(sliders, np.empty((3, 0)), time) is None


def test_where_only_the_share_that_holds_misses_its_tolerance_the_force_is_said_to_be_known() -> (
    None
):
    """And a solution tells both errors, of which `success` is judged by the larger."""
    contacts = Contacts(gaussian(1.0, 0.2), delay=Delay(0.3))
    found: Any = master.solve(contacts, [0.5, 4.0, 5.0], 1e-3, spring=0.3)
    assert found.success and 0.0 < found.holding_error <= 1e-3
    still: Any = master.solve(contacts.replace(delay=None), [0.5, 4.0, 5.0], 1e-3, spring=0.3)
    assert still.holding_error == 0.0
    parts = (ErrorPart("steps", 2e-6),)
    force, slips = np.array([0.5]), found.slips
    told = Followed(0.0, force, force, slips, 2e-6, 9, parts, of_holding=ErrorPart("slips", 5e-4))
    success, message = told.outcome(contacts, Drive([1.0], spring=0.3), 1e-4, "X_T")
    assert not success and "error estimate 5.0e-04 of holding is above" in message
    assert message.endswith("; the force is known to 2.0e-06 mean thresholds")


@pytest.mark.slow  # quick: the share that holds follows from breaks, above
def test_on_the_spring_of_a_machine_the_share_that_holds_takes_no_finer_steps() -> None:
    """Than the force: they were halved once more, as beside slips the share did not settle."""
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.01, 1.0), delay=Delay(1e3))
    path: Any = np.linspace(0.0, 18150.0, 23)
    found = master.solve(contacts, path, 1e-4, spring=1e-4, slip="reset")
    assert found.success and found.nodes < 1000, found.message


@pytest.mark.slow  # quick: slips that come later in one slider leave the share its limit, above
def test_beside_a_slip_the_share_that_holds_is_as_accurate_as_if_the_drive_were_off_by_its_error() -> (
    None
):
    """By `drive_error`, as the force is: what the share changes by on that way is no error of it. Steps were halved
    once more for it, or without success."""
    contacts, slip, delay = Contacts(gaussian(1.0, 0.2), delay=Delay(100.0)), 677.79, 100.0
    near = delay * np.array([-0.1, -0.03, -0.01, -0.003, 0.003, 0.01, 0.03, 0.1])
    path = np.concatenate([[200.0, 500.0], slip + near, slip + delay + near, [1000.0]])
    told: Any = master.solve(contacts, path, 1.5e-4, spring=1e-3, slip="reset")
    assert told.success and told.nodes < 100, told.message
    off = told.slips.drive_error * np.linspace(-1.0, 1.0, 41)
    moved = np.add.outer(path, off)
    fine: Any = master.solve(contacts, np.unique(moved), 1.5e-5, spring=1e-3, slip="reset")
    holding = np.interp(moved, fine.path, fine.holding)
    beyond = np.maximum(holding.min(axis=1) - told.holding, told.holding - holding.max(axis=1))
    assert fine.success and beyond.max() <= told.holding_error + fine.holding_error
    assert np.ptp(holding, axis=1).max() > 3.0 * told.holding_error
