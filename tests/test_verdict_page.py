"""The page of `mesofriction verdict` says what ended it, what each number is worth, and what to do instead."""

import re
import time
from dataclasses import replace
from typing import Any

import numba
import numpy as np
import pytest
from conftest import slow

import master
from master.soft.in_time.refining import NO_SLIP_YET
from origins import Contacts, Delay, InputError, Thermal, gaussian
from tests.verdicts import WIDE, judged, reading, verdict_on
from toolkit.processes.signals import TimeIsUp, no_longer_than
from toolkit.scene.scale import scale_of
from toolkit.verdict import answers, judge
from toolkit.verdict.picture import draw_verdict
from toolkit.verdict.sliders.budget import Budget, too_long
from toolkit.verdict.sliders.follow import follow
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import not_followed
from toolkit.verdict.text import of_delay
from toolkit.verdict.text.table import in_units
from toolkit.verdict.text.words import page

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")

HEAT = {"law": "eyring", "width": 0.03, "attempt_frequency": 1e12}
GROWING = {"beta": 0.03, "time": 1.0}
THRESHOLDS = {"kind": "gaussian", "mean": 1.0, "std": 0.3}


@pytest.mark.slow  # quick: what is left undone, below
def test_where_steps_end_the_page_does_not_ask_for_more_time(
    capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No slider has slipped by then, so that the same holds under all rules, and is not found out for each."""
    monkeypatch.setattr("master.soft.in_time.contacts.MOST_STEPS", 80)
    solve, asked = master.solve, list[str]()

    def counted(*arguments: Any, **named: Any) -> Any:
        asked.append(named["slip"])
        return solve(*arguments, **named)

    monkeypatch.setattr(master, "solve", counted)
    contacts = {"thresholds": THRESHOLDS, "thermal": HEAT, "strengthening": GROWING}
    told = judged(capsys, contacts=contacts, drive={"spring": 1e-3, "velocity": 1.0})[1]
    assert asked == ["reset"]
    reason = r"20 steps lead to t = [\d.]+, and more are not taken, however much time there is"
    stable = (
        "steady sliding is stable on this machine, and whether the slider comes to it is not known"
    )
    assert re.search(rf"\nnot decided \({reason}: {NO_SLIP_YET}; {stable}\)\n", told)
    assert "wall_time" not in told and "end the path sooner" not in told
    hint = "leave out [contacts.strengthening] or [contacts.thermal], or give a drive.spring"
    assert hint in told and "F_k, F_s and K* of the table hold all the same" in told
    assert "not decided if any slip rule acts: 20 steps" in told
    # in seconds where the scene is in metres
    metres = scale_of(Contacts(gaussian(1.0, 0.3)), None)
    metres = replace(metres, length_unit="m", time_unit="s")
    assert "lead to t = 1,218 s, and X = 47.8682 µm" in in_units(
        "lead to t = 1218, and X = 4.78682e-05", metres
    )


def test_more_digits_of_k_that_take_long_are_given_up_and_the_first_ones_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of contacts that grow and break by heat the finer tolerance takes a hundred times as long as the first one."""
    find, contacts = master.propensity, Contacts(gaussian(1.0, 0.3))

    def slow(*arguments: Any, tolerance: float, **named: Any) -> Any:
        if tolerance < judge.RESAMPLED_TOLERANCE:
            time.sleep(30.0)
        found = find(*arguments, tolerance=tolerance, **named)
        return replace(found, critical_spring_error=1e-4, run_time=1e-3)

    monkeypatch.setattr(master, "propensity", slow)
    began = time.monotonic()
    found = judge.propensity_of(contacts, 1.0, Budget(0.4, strict=True), judge.SOLVED_TO)
    assert time.monotonic() - began < 10.0
    assert found.critical_spring_error == 1e-4 and found.critical_spring > 0.0


def test_a_limit_of_time_within_another_leaves_that_as_it_was() -> None:
    """The outer one holds again after the inner one, and ends that where it is over first."""
    for inner, runs in ((0.02, 5.0), (5.0, 5.0)):
        began = time.monotonic()
        with pytest.raises(TimeIsUp), no_longer_than(0.1):
            with pytest.raises(TimeIsUp), no_longer_than(inner):
                time.sleep(runs)
            time.sleep(5.0)
        assert 0.09 < time.monotonic() - began < 4.0


def test_a_kernel_that_is_being_compiled_as_the_time_is_over_is_compiled_first() -> None:
    """The half-made kernel ended in "no compiled object yet", a traceback, when it was asked for again."""

    @numba.njit
    def total(values: Any) -> float:
        out = 0.0
        for value in values:
            out += value
        return out

    with pytest.raises(TimeIsUp), no_longer_than(0.001):
        total(np.ones(3))
        time.sleep(5.0)
    assert len(total.signatures) == 1 and total(np.ones(4)) == 4.0


def test_a_time_that_is_used_up_is_not_compared_with_what_is_left() -> None:
    assert (
        too_long(0.021, 0.0).removesuffix(": raise it")
        == "were not followed: wall_time is used up (60 s where none is given)"
    )
    assert too_long(40.0, 3.0).startswith("would take some 40 s, where 3 s are left: raise wall")


def of_a_mass(machine: Machine, delay: float) -> answers.Answer:
    """The answer of a slider with mass that slips, with contacts that wait so long."""
    slips = replace(
        not_followed("mass", ""), kind="stick-slip", before=0.8, after=-0.2, slips=5, error=1e-6
    )
    return reading(slips, contacts=WIDE.replace(delay=Delay(delay)), machine=machine, kinetic=0.6)


def test_what_another_delay_does_is_said_in_whole_sentences() -> None:
    """A slip lasts π (M/K)^(1/2) = 0.314, far less than the 800 in which the drive loads this spring to the force
    before it, which contacts that do not wait bear, and not to F_s, 0.6; or more than the 0.08 on a faster drive."""
    slow = of_delay.of_short_delays(of_a_mass(Machine(1e-3, 1e-5, 1e-5, 1.0), 1e-3))
    slow = slow.replace(" units of time", "")
    assert re.fullmatch(
        r"\. With a delay far below \S+, (in|above) which .*, contacts re-form in effect at once; with one far above "
        r"the 0\.31\d of a slip, and far below the 800 in which the drive loads the spring to the force before a slip, "
        r"0\.800 N_c<k>·length, only after the slip",
        slow,
    )
    fast = of_delay.of_short_delays(of_a_mass(Machine(1e-3, 1e-5, 1e-5, 1e4), 1e-3))
    assert (
        "with no delay do they all re-form between one slip and the next, as a slip lasts" in fast
    )
    fast = fast.replace(" units of time", "")
    assert "longer than the 0.08 in which the drive loads the spring to the force before a" in fast


def test_what_the_solver_refuses_is_not_mended_by_a_damping_or_a_delay(
    capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of exact thresholds in heat, which take minutes: the page does not ask for more of the machine."""
    solve, why = master.solve, "exact thresholds beside a mass are followed with no law but a delay"

    def refusing(*arguments: Any, **named: Any) -> Any:
        if named.get("mass") is not None:
            raise InputError(f"contacts: {why}, not with thermal")
        return solve(*arguments, **named)

    monkeypatch.setattr(master, "solve", refusing)
    contacts = {"thresholds": THRESHOLDS, "strengthening": GROWING}
    drive = {"spring": 3.0, "mass": 1e-3, "velocity": 1.0}
    told = judged(capsys, contacts=contacts, drive=drive)[1]
    assert "was not followed, for the reason told here. " not in told
    (line,) = (one for one in told.splitlines() if one.startswith("  the slip rule: "))
    assert line.endswith("was not followed, for the reason told here")
    assert line.startswith("  the slip rule: smooth if any slip rule acts. ")
    assert "give drive.damping" not in told
    assert told.count(why) == 2  # in the headline and where what is left undone is listed


def test_an_error_above_the_force_stands_beside_it() -> None:
    """Swings that are left after slips that shrank are the error of the force of smooth sliding."""
    answer = of_a_mass(Machine(0.5, 2e-5, 5e-3, 1.0), 0.2)
    smooth = replace(answer.behaviours[0], kind="smooth", before=1e-3, after=1e-3)
    smooth = replace(smooth, success=True, slips=13, shrinks_by=0.05, error=0.8)
    own = replace(answer, behaviours=(smooth,), kinetic=answers.Quantity(1e-3, 1e-9))
    text = page(verdict_on(own))
    assert text[2].startswith("smooth at 0.00 ± 0.80 N_c<k>·length (")
    assert "the path ends while they swing by more than the force" in text[2]
    (line,) = (one for one in text if one.startswith("  forces of the slider (mass)"))
    assert line.endswith("at most 8e+02, more than the force")


def test_of_many_cycles_the_last_ones_are_drawn_again() -> None:
    """Of 200 slips of 1, of which the first fell by ten times as much, those from 194 on fill a panel of their own."""
    answer = of_a_mass(Machine(0.5, 2e-5, 5e-3, 1.0), 0.2)
    cycles = np.repeat(np.arange(200.0), 2)[1:]
    force = np.where(np.arange(cycles.size) % 2, 0.2, np.where(cycles < 3.0, 8.0, 0.8))
    slips = replace(answer.behaviours[0], rule="reset", drive=cycles, force=force, period=1.0)
    found = verdict_on(replace(answer, behaviours=(slips,)))
    axes = {one.get_label(): one for one in draw_verdict(found).axes}
    late = axes["late"].lines[0].get_xdata()
    assert late.min() == pytest.approx(199.0 - 6.0) and late.max() == 199.0
    assert axes["trace"].lines[0].get_xdata().size == cycles.size
    assert axes["late"].get_ylim()[1] < 1.0 < 8.0 < axes["trace"].get_ylim()[1]
    few = replace(slips, drive=cycles / 20.0)
    found = verdict_on(replace(answer, behaviours=(few,)))
    assert "late" not in {one.get_label() for one in draw_verdict(found).axes}


def test_a_delay_that_is_not_given_is_asked_for_also_where_nobody_knows_what_one_does() -> None:
    """A slip of this mass takes as long as the time between slips, so that no slip rule tells of a long delay."""
    smooth = replace(not_followed("mass", ""), kind="smooth", before=0.5, after=0.5, error=1e-6)
    own = reading(smooth, machine=Machine(1e-3, 1e-5, 1e-5, 1.0), kinetic=0.5, spring=1.0)
    unknown = not_followed("reform-after", "a slip of this mass takes as long as the time between")
    text = page(verdict_on(own, other=unknown))
    asked = "  the contacts' delay: none is given, so that they form again at once; give [contacts.delay]"
    assert asked in text


def test_a_damping_that_would_help_is_told_without_the_path(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The reason alone stood on the page, as what to do with the path was cut, and this with it."""
    hint = "end the path sooner, or give a larger damping (3 or more)"

    def refusing(*_: Any, **__: Any) -> Any:
        raise InputError(f"path[-1] = 9: a slider with mass takes 2000 steps; {hint}")

    monkeypatch.setattr(master, "solve", refusing)
    machine, contacts = Machine(0.5, 0.02, 1e-3, 1.0), Contacts(gaussian(1.0, 0.3))
    known = RigidSlider(0.5, 0.4, 1e-6, 1.0, 2.0)
    told = follow(machine, contacts, "mass", known, 1e4)
    assert told.refused
    assert told.message == "a slider with mass takes 2000 steps; give a larger damping (3 or more)"


@pytest.mark.parametrize("is_f_k", [True, slow(False)])
def test_smooth_sliding_within_its_error_of_f_k_is_told_at_f_k(is_f_k: bool) -> None:
    """130 ± 10 mN stood where F_k was known to be 133.6 mN: on coarse steps the slider's force has the error of these,
    and tends to F_k without mass and damping. A force that is not F_k within its error stays as it is."""
    contacts = Contacts(
        gaussian(1.0, 0.2), thermal=Thermal("eyring", width=0.03, attempt_frequency=1.0)
    )
    kinetic = master.steady_state(contacts, velocity=1e-3)
    machine, off = Machine(1.0, None, 0.0, 1e-3), kinetic.force_error * contacts.mean_threshold
    rigid = RigidSlider(kinetic.force, kinetic.force, off, 0.1, 1.0)
    if not is_f_k:
        rigid = replace(rigid, kinetic=0.3)
    rough = follow(machine, contacts, "reset", rigid, 1e4, tolerance_in_time=0.05)
    if not is_f_k:
        assert rough.before == rough.force[-1] and rough.error > 1e-5
        return
    assert rough.kind == "smooth" and rough.before == rough.after == kinetic.force
    assert rough.error == pytest.approx(kinetic.force_error) and rough.error < 1e-5
    assert rough.force[-1] != kinetic.force and abs(rough.force[-1] - kinetic.force) < 0.05
