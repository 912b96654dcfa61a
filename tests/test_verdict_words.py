"""What a verdict's numbers are worth, word by word: digits, errors, slips that were seen; and refusals in one line."""

import json
import re
import warnings
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from master import propensity, solve, steady_state
from master.soft.inertia.foretold import enough_damping
from origins import (
    Contacts,
    Delay,
    Material,
    Thermal,
    from_topography,
    gaussian,
    strengthening,
)
from origins.drive import Drive
from origins.laws.temperature import TooHot
from tests.scenes import ROUGH, said, write
from tests.verdicts import HEAVY, LIGHT, NUMBER, reading, slips, text_of, told, verdict_on
from toolkit.results.slips import still_changing
from toolkit.running.progress import Progress
from toolkit.scene.messages import with_units_of
from toolkit.scene.scale import Scale
from toolkit.scene.scene import load_scene
from toolkit.verdict import answers
from toolkit.verdict.picture import draw_verdict
from toolkit.verdict.sliders.budget import at_most, without_useless_damping
from toolkit.verdict.sliders.follow import STILL_SWINGS, follow
from toolkit.verdict.sliders.late import shrinking
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour, Finite, not_followed
from toolkit.verdict.sliders.slips_in_time import SlipsOfMass
from toolkit.verdict.sliders.told import behaviour_of
from toolkit.verdict.slips_in_words import hidden_by, kind_of_trace, swinging
from toolkit.verdict.text.hangs_on import dependence
from toolkit.verdict.text.k_star import of_critical_spring
from toolkit.verdict.text.over_load import of_spread
from toolkit.verdict.text.spread import other_samples, range_of_force
from toolkit.verdict.text.table import in_units, table
from toolkit.verdict.text.undone import with_rules
from toolkit.verdict.text.words import page, sentence
from toolkit.verdict.trace import last_cycles
from toolkit.verdict.with_mass import closely, rests_after

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")


def test_numbers_have_two_digits_where_other_samples_change_them_by_more_than_a_tenth() -> None:
    """The range over readings and what is smooth, beside ± 0.15, as the table's numbers."""
    vague = answers.Quantity(0.5123, 1e-9, 0.15)
    found = told(slips("instant", kind="smooth", before=0.5123, after=0.5123), kinetic=vague)
    other = replace(found.own, name="other", kinetic=replace(vague, value=0.5234))
    text = page(replace(found, answers=(found.own, other)))
    assert text[2].startswith("smooth at 0.51 N_c<k>·length; other samples would change F_k by ±")
    (row,) = (one for one in text if one.startswith("kinetic friction F_k"))
    assert re.search(r"0\.51 N_c<k>·length +± 0\.15 .* 0\.51 \S+ to 0\.52", row)
    wide = replace(vague, sampling=0.08)
    own = replace(found.own, kinetic=wide, static=wide)
    assert page(replace(found, answers=(own,)))[2].startswith("smooth at 0.51 N_c<k>·length")
    # readings differ by what their own errors, which are small, let know
    exact = replace(vague, sampling=None)
    own = replace(found.own, kinetic=exact, static=exact)
    other = replace(other, kinetic=replace(exact, value=0.8), static=replace(exact, value=0.8))
    text = page(replace(found, answers=(own, other)))[2]
    assert (
        text
        == "smooth at 0.512 N_c<k>·length; F_k of the 2 readings is 0.512 N_c<k>·length to "
        + ("0.800 N_c<k>·length")
    )


def test_a_range_of_forces_has_the_digits_of_their_errors() -> None:
    """Forces before slips of contacts that wait, each known to a tenth, and F_k of a rigid slider to 1e-9; the error of
    one between both ends is told, too, as it may be beyond them."""
    own = told(slips("mass", before=2.09, error=0.3), delay=Delay(5.0)).own
    other = replace(own, name="b", behaviours=(slips("mass", before=3.13, error=0.3),))
    verdict = replace(told(), answers=(own, other))
    assert range_of_force(verdict).endswith(
        "is 2.1 N_c<k>·length to 3.1 N_c<k>·length, with errors of up to 0.30 N_c<k>·length"
    )
    sharp = (slips("mass", before=3.13, error=1e-5),)
    verdict = replace(told(), answers=(own, replace(other, behaviours=sharp)))
    assert "is 2.1 N_c<k>·length to 3.130 N_c<k>·length, with" in range_of_force(verdict)
    between = replace(other, name="c", behaviours=(slips("mass", before=3.05, error=0.3),))
    own, other = (replace(one, behaviours=sharp) for one in (own, other))
    own = replace(own, behaviours=(replace(sharp[0], before=2.09),))
    for given, told_too in (((own, other), False), ((own, other, between), True)):
        said = range_of_force(replace(verdict, answers=given))
        assert (
            "is 2.090 N_c<k>·length to 3.130" in said
            and ("with errors of up to" in said) == told_too
        )
    # ends that lie nearer to each other than their errors are none
    near = replace(own, behaviours=(slips("mass", before=2.99, error=0.3),))
    said = range_of_force(replace(verdict, answers=(near, other)))
    assert said.endswith("is 2.7 N_c<k>·length to 3.3 N_c<k>·length, with the error of each")


def test_a_range_beside_slips_of_the_areas_contacts_is_of_infinitely_many() -> None:
    """The answer, 0.580 ± 0.005 by the contacts of the area, lay out of a range of 0.6034 to 0.6213, unsaid."""
    given = told(slips("reset", before=0.6034, error=1e-5), delay=Delay(5.0))
    other = replace(given.own, name="b", behaviours=(slips("reset", before=0.6213, error=1e-5),))
    few = Finite("reset", 500, "stick-slip", 0.58, 5e-3, 0.0, 5e-3, 9.0, period=60.0)
    verdict = replace(given, answers=(given.own, other))
    plainly = "the force before a slip over all 2 readings is 0.6034 N"
    assert range_of_force(verdict).startswith(plainly)
    said = range_of_force(replace(verdict, finite=(few,)))
    assert said.startswith("the force before a slip with infinitely many contacts over all 2")
    assert said.endswith("is 0.603 N_c<k>·length to 0.621 N_c<k>·length")


def test_rules_with_errors_of_their_own_stand_apart_in_the_headline() -> None:
    """The same forces, one known to 1e-2 and one to 0.1; as one they would both have the larger error."""
    apart = page(told(slips("reset", error=1e-2), slips("reform-after", error=0.1)))[2]
    assert "0.60 ± 0.01 N_c<k>·length down to 0 N_c<k>·length if a slip renews" in apart
    assert "stick-slip: 0.60 ± 0.10 N_c<k>·length down to 0" in apart
    assert apart.endswith("if contacts re-form after the slip")
    alike = page(told(slips("reset", error=1e-2), slips("reform-after", error=1e-2)))[2]
    assert alike.count("±") == 1


def test_a_slip_that_begins_past_the_peak_of_the_force_tells_the_peak() -> None:
    """Near K* the sentence told the force at a slip's begin as if it were the static one: 0.578 beside an F_s of 0.690
    on a spring of 1 beside a K* of 1.036."""
    contacts = Contacts(gaussian(1.0, 0.2))
    solved = solve(contacts, np.linspace(0.0, 4.0, 201), spring=1.0, slip="reset", tolerance=1e-6)
    near = behaviour_of("reset", solved, 1.0, 1.0, "")
    static = propensity(contacts).static_to_kinetic * steady_state(contacts).force
    assert (near.before, static) == pytest.approx((0.578, 0.690), abs=1e-3)
    assert near.peak == pytest.approx(static, rel=1e-3)
    unit = "N_c<k>·length"
    for before, peak, says in (
        (0.5, 0.6, f", past the peak F_s = 0.6000 {unit}, down"),
        (0.5, 0.55, f", past a peak of 0.55 {unit}, down"),
        (0.6, 0.6, " down"),
    ):
        text = page(told(slips("reset", before=before, peak=peak)))[2]
        assert text.startswith(f"stick-slip: {before:.4f} {unit}{says} to 0 {unit}")


def test_a_fast_drive_in_metres_names_the_heat_of_sliding() -> None:
    """A drive of 1 m/s passed without a word: contacts are not warmed by sliding."""
    found = told(slips("reset"))
    own = replace(found.own, scale=replace(found.own.scale, length_unit="m", time_unit="s"))
    for velocity, hot in ((1.0, True), (1e-3, False)):
        lines = dependence(replace(found, answers=(own,), velocity=velocity))
        named = [one for one in lines if one.startswith("heat of sliding, which is left out: ")]
        assert bool(named) is hot and all("at 1.00 m/s" in one for one in named)


def test_periods_without_si_units_are_in_units_of_length_and_time() -> None:
    """They were told as "every 70.0 length, 70.0 time"."""
    text = page(told(slips("reset", period=70.0)))[2]
    assert "every 70.00 units of length, 70.00 units of time at 1.00" in text


@pytest.mark.parametrize("other", [(0.7, 0.4), (0.9, 0.3)])
def test_slips_of_two_sizes_are_not_told_as_one_range(other: tuple[float, float]) -> None:
    """Slips of 0.6 to 0 and 0.7 to 0.4 stood as 0.6 to 0.7 down to 0 to 0.4; so may those of one drop."""
    before, after = other
    text = page(told(slips("reset"), slips("instant", before=before, after=after)))
    (said,) = (one for one in text if one.startswith("stick-slip"))
    first, second = said.split("; ")
    assert "0.6000 N_c<k>·length down to 0 " in first
    assert f"{before:.4f} N_c<k>·length down to {after:.4f}" in second


def test_few_slips_say_how_many_and_why_they_tell() -> None:
    """Of two by the master equation the regime's reason; of three of the ensemble that they are of four sliders."""
    why = "2 slips up to the end of the path, and a reset leaves contacts that slip again"
    text = text_of(told(slips("reset", slips=2, message=f"{why}; up to 100% of them")))
    assert re.search(rf"\nslips seen \(reset\) +{why}\n", text)
    text = text_of(told(slips("reset", slips=3, contacts=2000, message="by 4 sliders")))
    assert re.search(r"\nslips seen \(reset\) +3 slips of each of 4 sliders\n", text)
    assert "slips seen" not in text_of(told(slips("reset", slips=5)))


def test_what_is_not_known_has_no_error() -> None:
    """K* was not found in time: its error is not told beside those of F_k and F_s."""
    found = told(slips("reset"))
    late = replace(found, answers=(replace(found.own, critical_spring=answers.UNKNOWN),))
    assert "  F_k, F_s and K*: at most 2e-09" in page(found)
    assert "  F_k and F_s: at most 2e-09" in page(late)
    nothing = replace(late.own, static=answers.UNKNOWN)
    assert "  F_k: at most 2e-09" in page(replace(late, answers=(nothing,)))


def test_k_star_has_the_same_digits_in_the_answer_and_in_the_table() -> None:
    own = told(machine=LIGHT).own
    critical = answers.Quantity(0.43872246, 1e-8)
    own = replace(own, machine=None, behaviours=(), critical_spring=critical)
    text = page(replace(told(), answers=(own,)))
    assert "softer than K* = 0.4387 N_c<k>;" in text[2]
    assert any(re.fullmatch(r"slips at least once below.* 0\.4387 N_c<k>", one) for one in text)


def test_k_star_of_a_slider_with_mass_promises_no_slip() -> None:
    assert of_critical_spring(told(machine=LIGHT).own).startswith("slips at least once below")
    assert of_critical_spring(told(machine=HEAVY).own).startswith("balance unstable somewhere")
    waits = told(machine=HEAVY, delay=Delay(1.0)).own
    assert of_critical_spring(waits).startswith("K*, the steepest fall")
    figure = draw_verdict(told(slips("mass", kind="smooth"), machine=HEAVY))
    assert figure.axes[-1].get_xlabel().startswith("balance unstable somewhere")


def test_the_panel_of_a_slip_says_when_the_slider_rests_or_that_it_still_moves() -> None:
    """Contacts come back after 0.5, in the second half of the first swing, and hold; without damping, after 50, the
    panel ends before."""
    for delay, damping, rests in ((0.5, 2e-4, True), (50.0, 0.0, False)):
        contacts = Contacts(gaussian(1.0, 0.3), delay=Delay(delay))
        machine = replace(HEAVY, damping=damping)
        begun = slips("mass", in_time=SlipsOfMass(0.314, first_slip=79.0), contacts=2000)
        begun = replace(begun, drive=np.array([0.0, 80.0]), force=np.array([0.0, 0.8]))
        found = closely(begun, machine, contacts, 1e9)
        after = rests_after(found, machine)
        assert np.isnan(after) != rests
        if rests:
            assert 0.3 < after < 4.0
        verdict = told(found, machine=machine, delay=Delay(delay))
        (panel,) = (one for one in draw_verdict(verdict).axes if one.get_label() == "slip")
        label = panel.lines[1].get_label()
        assert ("at rest after" in label) == rests and ("still moving" in label) != rests


def test_a_slider_rests_no_earlier_than_the_page_says_that_its_slip_ends() -> None:
    """One that has all but 1.5 % of its way behind it after 0.8 of its slip's time was at rest from then on."""
    seconds = np.linspace(0.0, 10.0, 1001)
    moved = np.interp(seconds, [0.0, 0.8, 1.0], [0.0, 98.5, 100.0])
    drive = 80.0 + seconds
    found = replace(slips("mass"), slip_drive=drive, slip_force=HEAVY.spring * (drive - moved))
    assert rests_after(replace(found, in_time=SlipsOfMass(1.0)), HEAVY) == 1.0


def test_the_first_slip_has_the_digits_of_f_s_beside_it() -> None:
    """Readings a factor of two apart left it two digits: it began at 0.25 under an F_s of 0.248."""
    first = slips("mass", kind="smooth", in_time=SlipsOfMass(0.3, first_forces=(0.24829, 0.19777)))
    own = reading(first, machine=HEAVY, kinetic=0.2, static=0.24823)
    other = reading(slips("mass", kind="smooth"), machine=HEAVY, kinetic=0.1, static=0.12, name="b")
    rows = [re.split("  +", line) for line in table(verdict_on(own, other))]
    cells = {name: value for name, value, *_ in rows if name}
    assert cells["static friction F_s"].startswith("0.248 ")
    assert (
        cells["first slip (mass)"].startswith("0.248 ")
        and " to 0.198 " in cells["first slip (mass)"]
    )


def test_a_first_slip_above_f_s_by_the_mass_says_so() -> None:
    """v (K M)^(1/2) = 1e-3 and 2e-4 of the damping explain 1e-3, and not 1e-2."""
    for force, explained in ((0.601, True), (0.61, False)):
        first = SlipsOfMass(0.3, first_forces=(force, 0.4))
        text = text_of(told(slips("mass", kind="smooth", slips=1, in_time=first), machine=HEAVY))
        assert ("the first slip begins 0.0010 N_c<k>·length above F_s" in text) == explained
        assert ("v (K M)^(1/2) = 0.0010 N_c<k>·length more, and by " in text) == explained


def test_a_mass_that_was_not_followed_stands_before_what_the_rules_say_without_it() -> None:
    slides = slips("instant", kind="smooth", slips=0, after=0.6)
    for more, before in (({}, True), ({"slips": 2}, False)):
        mass = replace(not_followed("mass", "the slider rings"), **more)
        said = page(told(mass, slips("reset"), slides, machine=HEAVY))[2]
        without = "not decided, as the slider with its mass was not followed: without it "
        decides = "what contacts do in a slip decides: "
        each = "stick-slip if a slip renews all contacts, smooth if contacts re-form at once"
        assert said.startswith(f"{without}{decides}{each}" if before else decides), said


def test_the_last_part_of_a_way_of_few_cycles_is_a_part_of_it() -> None:
    """Of 6.6 cycles with swings that a line cannot draw not six, which are nearly all, but one or two."""
    drive = np.linspace(0.0, 6.6, 400)
    force = np.where(np.arange(400) % 2, 0.5, -0.3)
    begin = last_cycles(told(slips("mass", drive=drive, force=force, period=1.0), machine=HEAVY))
    assert begin is not None and 1.4 <= 6.6 - begin <= 2.0  # so that one slip is among them


def test_forces_of_slips_say_that_they_were_not_resampled() -> None:
    """An empty cell beside F_s ± 5.7 µN was read as a force that other samples do not change."""
    vague = answers.Quantity(0.5123, 1e-9, 0.015)
    rows = page(told(slips("reset"), kinetic=vague))
    (before,) = (row for row in rows if row.startswith("force before a slip (reset)"))
    assert before.endswith("not resampled")
    assert not any("not resampled" in row for row in page(told(slips("reset"))))


def test_friction_over_the_load_says_how_far_it_is_from_half_of_one_contacts() -> None:
    """By GW with "amontons" breaking forces are 0.4 of the load, and F_k/load a quarter above half of that; by Persson
    with "paper" k is proportional to x_s, and F_k is half of it. Sums over thresholds are moments of P_c."""
    for name, more in (("rough-gw-amontons", True), ("rough-persson-paper", False)):
        contacts = load_scene(name).contacts
        law, surface = contacts.thresholds, contacts.interface
        own = replace(told().own, contacts=contacts)
        said = of_spread(replace(told(), answers=(own,)))
        over = surface.mean_stiffness * law.moment(2) / (law.mean() * surface.mean_force_threshold)
        assert bool(said) is more and (over > 1.2) is more
        for line in said:
            assert line.startswith(
                f"F_k/load is {over:.2f} times half of all breaking forces, 0.200"
            )
            linked = steady_state(contacts.replace(stiffness="linked"), velocity=1.0).force
            times = linked / steady_state(contacts, velocity=1.0).force
            assert line.endswith(f'"linked", F_k is {times:.2f} times this') and times > 2.0
    linked = replace(own, contacts=contacts.replace(stiffness="linked"))
    assert not of_spread(replace(told(), answers=(linked,)))


def test_slips_that_go_on_to_die_out_are_not_told_as_over() -> None:
    """Where the path ends while they still swing: "slips 11 times, and then no more" was told."""
    dying = slips(
        "instant",
        kind="smooth",
        before=0.5,
        after=0.5,
        slips=11,
        shrinks_by=0.06,
        swings=(0.3, 0.7),
    )
    found = told(dying)
    assert "slips 11 times on the way that was followed, ever less" in text_of(found)
    assert kind_of_trace(dying) == "slips that die out, smooth in the end"


def test_a_swing_that_outlives_the_path_is_named() -> None:
    """M = 1e-4, K = 1e-2 and γ = 2e-4: a swing takes 2π(M/K)^(1/2) = 0.628, and dies away in 2M/γ = 1."""
    drive = np.linspace(0.0, 100.0, 5000)
    swings = replace(not_followed("mass", STILL_SWINGS), drive=drive, force=np.sin(drive))
    page_text = text_of(told(swings, machine=HEAVY))
    assert "at the path's end, by 2.0 N_c<k>·length: a swing takes 0.628 units of time" in page_text
    assert "dies away by a factor e in 1 units of time, so that a larger drive.damping" in page_text


def test_the_sentence_names_what_decides() -> None:
    """Slip rules that tell of another reading, as its mass is not decided, said that assumptions decide on this one."""
    heavy = slips("mass", kind="smooth", before=0.5, after=0.5, slips=0)
    light = [slips("reset"), replace(heavy, rule="instant")]
    found = told(heavy, machine=HEAVY)

    def said(other: list[Behaviour], verdict: answers.Verdict = found) -> str:
        both = verdict.own, replace(verdict.own, name="other", behaviours=tuple(other))
        return sentence(replace(verdict, answers=both))

    undecided = said([not_followed("mass", "late"), *light])
    assert "decide" not in undecided.partition("; ")[0] and "smooth at 0.5" in undecided
    begin = "the reading of the surface decides: smooth by own, stick-slip by 1 other reading"
    assert said([slips("mass")]).startswith(begin)
    begin = (
        "what contacts do in a slip decides: stick-slip if a slip renews all contacts, smooth if"
    )
    assert said(light, told(*light)).startswith(begin)


def test_what_is_too_hot_is_told_on_the_page_alone(capsys: Any) -> None:
    """A warning of the contacts stood above it, with the place in the code, once for each copy of them."""
    contacts = {"thermal": {"law": "soft", "temperature": 150.0, "attempt_frequency": 1.0}}
    contacts["thresholds"] = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    drive = {"spring": 0.5, "velocity": 10.0}
    with warnings.catch_warnings():
        warnings.simplefilter("error", TooHot)
        file = write(contacts=contacts, drive=drive, verdict={"rules": ["reset"]})
        status, out, _ = said(capsys, "verdict", file)
    assert status == 0 and "barriers are 0.003" in "\n".join(out)


def test_without_a_machine_the_springs_have_an_axis_of_short_ticks_and_infinity_is_a_word() -> None:
    """K* known to 1e-9 had ticks of ten digits, on one another; an infinite one stood as inf N_c<k>."""
    for value in (0.4401, np.inf):
        own = replace(told().own, critical_spring=answers.Quantity(value, 1e-9), machine=None)
        found = replace(told(), answers=(own,))
        figure, text = draw_verdict(found), text_of(found)
        figure.canvas.draw()
        low, high = figure.axes[-1].get_xlim()
        assert high > 9.0 * low
        shown = figure.axes[-1].get_xticklabels(which="both")
        assert max(len(one.get_text()) for one in shown) <= 4
        every = "slips at least once on every spring, as K* is infinite; whether slips go on"
        assert (every in text) is bool(np.isinf(value)) and "K* = inf" not in text
        assert "What it hangs on" not in text  # nothing
    narrow = Contacts(gaussian(1.0, 1e-3))
    own = replace(own, contacts=narrow)
    law = draw_verdict(replace(found, answers=(own,))).axes[0]
    low, high = law.get_xlim()  # a peak in the middle, not at the left of a long axis
    assert 0.3 < (1.0 - low) / (high - low) < 0.6


def test_the_picture_ends_behind_what_happens_and_its_title_is_short() -> None:
    """A slider that slides smoothly behind a tenth of its path; slips go on to the end."""
    drive = np.linspace(0.0, 60.0, 6001)
    slides = slips("mass", kind="smooth", before=0.5, after=0.5, slips=0, drive=drive, damping=2e-4)
    slides = replace(slides, force=np.minimum(0.1 * drive, 0.5))
    figure = draw_verdict(told(slides, machine=HEAVY))
    trace = figure.axes[0]
    assert trace.get_xlim()[1] == pytest.approx(10.0, rel=0.05)
    assert [one.get_text() for one in trace.texts] == [
        "all goes on like this up to 60 units of length"
    ]
    assert "assumed damping" not in figure.get_suptitle()
    # the error of a trace is a force, and no formula that lines of the legend would break
    rough = draw_verdict(told(replace(slides, error=0.01, success=False), machine=HEAVY)).axes[0]
    (label,) = (one.get_text() for one in rough.get_legend().get_texts())
    assert label.replace("\n", " ").endswith(": smooth, error 0.010 N_c<k>·length")
    stick = slips("reset", drive=drive, force=drive % 2.0, period=2.0)
    for each in ((stick,), (stick, replace(slides, rule="instant"))):
        trace = draw_verdict(told(*each)).axes[0]
        assert trace.get_xlim()[1] > 60.0 and not trace.texts


def test_the_last_cycles_are_drawn_where_another_path_ends_before_them() -> None:
    """Of a mass: 60 cycles of infinitely many contacts, 10 of the area's, which slip from a larger force."""
    drive = np.linspace(0.0, 60.0, 6001)
    long = slips("mass", before=0.9, after=0.1, drive=drive, force=drive % 1.0, period=1.0)
    few = Finite("mass", 300, "stick-slip", 0.5, 1e-3, 0.1, 1e-3, 10.0, period=1.0)
    few = replace(few, drive=drive[:1000], force=0.5 * (drive[:1000] % 1.0))
    found = told(long, machine=HEAVY)
    number = replace(found.own, scale=replace(found.own.scale, contacts=300.0))
    found = replace(found, answers=(number,), finite=(few,))
    trace, late = draw_verdict(found).axes[:2]
    assert len(trace.get_lines()) == 2 and len(late.get_lines()) == 1


def test_a_machine_without_units_is_refused_before_its_surface_is_read(capsys: Any) -> None:
    """There is no such scan, which would be told if it were looked for."""
    law = {"kind": "from-topography", "model": "gw", "law": "amontons", "pressure": 1e6}
    law |= {"surface": {"kind": "scan", "file": "none.di"}}
    law |= {"material": {"contact_modulus": 1e9, "shear_modulus": 1e9, "local_friction": 0.4}}
    area = {"area": 1e-6}
    refused: list[tuple[dict[str, Any], str]] = [
        ({"spring": 50.0} | area, r"drive\.spring = 50\.0: has no unit; of a surface write"),
        ({"spring": "50 N/mm2"} | area, r"drive\.spring = '50 N/mm2': unit N/mm2 is not known"),
        ({"spring": "50 N/m"}, r"drive\.spring = '50 N/m': needs drive\.area"),
        ({"spring": "50 N/m", "mass": 0.1} | area, r"drive\.mass = 0\.1: has no unit"),
        ({"spring": "50 N/m", "slip": "rest"} | area, r"drive\.slip = 'rest': must be \"reset\", "),
    ]
    for drive, says in refused:
        scene = write(contacts={"thresholds": law}, drive=drive, master=None)
        status, _, (line,) = said(capsys, "verdict", scene)
        assert status == 2 and re.search(says, line)
    complete = {"spring": "50 N/m"} | area
    for command, drive, sweep in (
        ("verdict", complete, None),
        ("thresholds", complete, None),
        ("run", {"spring": "50 N/m", "to": 1e-3}, {"drive.area": [1e-6, 2e-6]}),
        ("run", complete | {"slip": "", "to": 1e-3}, {"drive.slip": ["reset", "instant"]}),
    ):
        scene = write(contacts={"thresholds": law}, drive=drive, sweep=sweep)
        _, _, (line,) = said(capsys, command, scene)
        assert "none.di" in line


def test_the_end_of_a_key_is_told_in_whole(capsys: Any) -> None:
    for end, whole in (
        ("mean_atoms", None),
        ("thresholds.std", "contacts.thresholds.std"),
        ("slip", "drive.slip"),
    ):
        status, _, (line,) = said(capsys, "run", "stick-slip", "--set", f"{end}=0.1")
        no_such = "unknown key" in line and whole is None  # of other thresholds
        assert status == 2 and (no_such or line.endswith(f"is no whole key; write {whole}"))
    _, _, (line,) = said(capsys, "run", "stick-slip", "--set", "tolerance=0.1")
    assert line.endswith("write eq.tolerance or master.tolerance")
    _, _, (line,) = said(capsys, "run", "stick-slip", "--set", "kelvin=300.0")
    assert "unknown key" in line  # and not sweep.kelvin, where nothing is swept
    _, _, (line,) = said(capsys, "show", "gw-gaussian", "--set", "thresholds.shape=0.1")
    assert "unknown key" in line


def test_a_unit_that_the_shell_took_apart_is_told_with_its_quotes(capsys: Any) -> None:
    words = "verdict", "stick-slip", "--set", "drive.spring=50", "N/m"
    status, _, (line,) = said(capsys, *words)
    assert status == 2 and line.endswith("""write --set drive.spring='"50 N/m"'""")
    first = "verdict", "--set", "drive.mass=1e-9", "N_c<k>", "s2", "stick-slip"
    _, _, (line,) = said(capsys, *first)
    assert line.endswith("""write --set drive.mass='"1e-9 N_c<k> s2"'""")
    _, _, (line,) = said(capsys, "run", "stick-slip", "another")
    assert line == "mesofriction: another: not known here; mesofriction run --help says what is"


def test_what_a_solver_says_of_a_slider_with_mass_is_in_the_units_of_the_page() -> None:
    """Its damping is a time over N_c<k>; 2e6 N/m of these."""
    newtons = Scale(1.0, "N", 2e6, "N/m", "m", "s")
    why = "takes 9 steps to t = 518; give a larger damping (a hundredth of the critical one of a slider that sticks is "
    assert in_units(f"{why}5e-07)", newtons).endswith("of a slider that sticks is 1.00 N s/m)")
    usual = "mass = {}: rings (a tenth of the critical one of mass and spring is {}), or end the path before {}"
    given, told = ("5e-08", "5e-07", "0.005"), ("0.1 kg", "1.00 N s/m", "5.00 mm")
    assert with_units_of(newtons, usual.format(*given)) == usual.format(*told)
    far = "a slider with mass goes on by 3e-05 or more, in 4e+04 steps"
    assert "goes on by 30.0 µm or more" in in_units(far, newtons)


def test_a_verdict_in_units_of_the_own_contacts_stiffness_has_that_of_one_reading_for_all(
    capsys: Any,
) -> None:
    """Readings have different N_c<k>: forces and springs of all are those in newtons over that of the scene's own."""
    tables = {"master": None, "verdict": {"readings": ["gw/amontons", "persson/amontons"]}}
    tables["verdict"] |= {"rules": ["reset"]}
    drive = {"spring": "1e5 N/m", "area": 1e-8, "velocity": 1e-6}
    pages, found = list[str](), list[Any]()
    for units in ("SI", "N_c<k>"):
        name = write(thresholds=ROUGH, drive=drive, units=units, **tables)
        status, out, _ = said(capsys, "verdict", name)
        assert status == 0
        pages.append("\n".join(out))
        found.append(json.loads(Path("mine-output/verdict.json").read_text()))
    surface = load_scene("mine.toml", solved=False).contacts.interface
    together = surface.contact_density * 1e-8 * surface.mean_stiffness
    for one, shared in zip(*(each["readings"] for each in found), strict=True):
        assert shared["units"]["force"] == "N_c<k>·m" and shared["units"]["spring"] == "N_c<k>"
        for name in ("kinetic", "static", "critical_spring"):
            assert shared[name]["value"] * together == pytest.approx(one[name]["value"], rel=1e-9)
        for name in ("spring", "load"):
            assert shared[name] * together == pytest.approx(one[name], rel=1e-9)
        before = [each["behaviours"][0]["before"] for each in (shared, one)]
        assert before[0] * together == pytest.approx(before[1], rel=1e-9)
    mu = [re.search(r"F_k/load +(\S+)", text)[1] for text in pages]
    assert mu[0] == mu[1] and "mN" in pages[0]
    assert "N_c<k>·m" in pages[1] and not re.search(r"\d [mµn]?N\b", pages[1])


def test_progress_says_how_long_a_verdict_takes_at_most(capsys: Any) -> None:
    for given, says in ((90.0, "(wall_time 0:01:30)"), (None, "(some 60 s of work in all")):
        bar = Progress("verdict", most=at_most(given))
        bar.doing("reading 1 of 1")
        bar.close()
        line = capsys.readouterr().err
        told = rf"mesofriction: verdict: reading 1 of 1, after 0:\d\d:\d\d {re.escape(says)}.*\n"
        assert re.match(told, line)


def test_the_bound_of_heat_that_is_left_out_is_no_standard_error() -> None:
    """Nor has a slider that is not decided, and was not seen to slip, a force whose error could be told."""
    by_contacts = slips("reset", error=0.1, contacts=2000, message="by 4 sliders")
    cold = replace(by_contacts, heat_left_out=0.09, message="by 4 sliders without heat")
    said = "between sliders, with what heat that is left out may change"
    assert said in text_of(told(cold)) and said not in text_of(told(by_contacts))
    unknown = slips("reset", kind="undecided", slips=0, error=0.1)
    assert "forces of the slider" not in text_of(told(unknown, machine=LIGHT))


def test_a_slider_whose_heat_is_left_out_is_pulled_on_until_it_is_decided() -> None:
    """The bound of cold heat alone is above the tolerance. On a drive as fast as this the mass lags behind: the first
    path ends before it has slid, a longer one does not."""
    heat = Thermal(law="stiff", temperature=1e-7, attempt_frequency=1e6)
    contacts = Contacts(gaussian(1.0, 0.3), thermal=heat)
    machine = Machine(spring=0.01, mass=1.0, damping=0.2, velocity=30.0)
    found = follow(machine, contacts, "mass", RigidSlider(0.6, 0.545, 0, 0.44, 3.0), 1e9)
    assert found.heat_left_out is not None and found.error > 1e-3
    assert found.kind == "smooth" and found.drive[-1] > 1000.0


def test_contacts_that_slide_without_a_slip_have_no_few_slips() -> None:
    smooth = slips("mass", kind="smooth", slips=0, contacts=2000, message="by 4 sliders", error=0.1)
    smooth = replace(smooth, finite=Finite("mass", 2000, "smooth"))
    assert "each of which slipped" not in text_of(told(smooth, machine=HEAVY))


def test_the_title_of_a_picture_ends_before_a_reason_that_is_cut() -> None:
    why = slips(
        "mass", kind="undecided", slips=0, message="takes 9 steps; give a damping (5 of it)"
    )
    figure = draw_verdict(told(why, machine=HEAVY))
    assert figure.get_suptitle().splitlines()[1] == "not decided (takes 9 steps)"
    why = replace(why, message="takes 9 (5; of it) steps")
    figure = draw_verdict(told(why, machine=HEAVY))
    assert figure.get_suptitle().splitlines()[1] == "not decided"


def test_forces_with_another_delay_say_that_they_are_without_heat() -> None:
    slides = slips("mass", kind="smooth", slips=1, before=0.5, after=0.5)
    heat = Thermal(law="stiff", temperature=1e-7, attempt_frequency=1e6)
    warm = replace(told(slides, machine=HEAVY, thermal=heat), turned=slips("mass", before=0.9))
    assert re.search(r"make it stick-slip: 0\.9\S* .*·length, without heat$", page(warm)[3])
    cold = replace(told(slides, machine=HEAVY), turned=slips("mass", before=0.9))
    assert "make it stick-slip" in page(cold)[3] and "heat" not in page(cold)[3]


def test_what_a_solver_tells_in_mean_thresholds_is_told_in_newtons_and_metres() -> None:
    """A mean threshold of 4 nm and 2.5e6 N/m in all: 10 mN of force. Bare numbers stay where there are no metres."""
    newtons = Scale(2.5e6, "N", length_unit="m", time_unit="s", spring_unit="N/m")
    note = "heat is left out: it may change the force by up to 1.3e-02 mean thresholds"
    assert in_units(note, newtons, 4e-9) == note.replace("1.3e-02 mean thresholds", "130 µN")
    slip = "its slip from F_s goes on for 1.2e+06 mean thresholds, after which"
    assert "goes on for 4.8 mm, after" in in_units(slip, newtons, 4e-9)
    missed = "error estimate 5.3e-03 is above the tolerance 1.0e-03, most of it"
    told = in_units(missed, newtons, 4e-9)
    assert told == "error estimate 53 µN is above the tolerance 10 µN, most of it"
    for one in (note, slip, missed):
        assert in_units(one, Scale(), 4e-9) == in_units(one, newtons) == one


def test_no_damping_is_asked_for_that_no_machine_has() -> None:
    """A hundredth of the critical damping of a slider that sticks, 1e-4 N_c<k>, may be far above that of mass and
    spring, 2 (K M)^(1/2) = 2e-3."""
    for asked, kept in ((1e-3, True), (0.1, False)):
        hint = f"; give a larger damping (a hundredth of the critical one of a slider that sticks is {asked})"
        why = f"takes 2001 steps, and no more are taken on{hint}"
        found = without_useless_damping(why, HEAVY)
        assert found == (why if kept else why.replace(hint, ""))
    # the solver says so itself, and a verdict leaves that out
    drive = Drive([0.0, 1.0], mass=HEAVY.mass, spring=1e-6, damping=1e-6)
    warned = f"the slider rings; give a damping, or a larger one ({enough_damping(drive)})"
    assert warned.endswith(" is 0.0002, 10 times that of mass and spring: another machine)")
    soft = replace(HEAVY, spring=1e-6)
    assert without_useless_damping(warned, soft) == "the slider rings"
    assert without_useless_damping(warned, HEAVY) == warned


def test_contacts_that_strengthen_have_another_spring_below_which_they_slip_on() -> None:
    """K* is of new contacts; the page says which command tells of those that have grown."""
    asked = "`mesofriction rate-state` tells (the critical spring)"
    waiting = told(slips("mass"), machine=HEAVY, delay=Delay(1.0))
    growing = Contacts(strengthening(gaussian(1.0, 0.3), beta=0.03, time=1e-4))
    grown = replace(waiting, answers=(replace(waiting.own, contacts=growing),))
    assert asked in "".join(page(grown)) and asked not in "".join(page(waiting))


def test_beside_a_mass_no_sentence_names_a_slip_rule() -> None:
    """Where the mass alone decides there is no other; where slip rules are told beside it each has its own."""
    late = not_followed("mass", "takes 9 steps")
    alone, beside = told(late, machine=HEAVY), told(late, slips("reset"), machine=HEAVY)
    assert "not decided: takes 9 steps" in text_of(alone)
    line = "not decided if mass, damping and delay decide: takes 9 steps"
    assert line in text_of(beside)
    said = "what 9 contacts do if <rule> is not known"
    assert with_rules(said, ["mass"], alone.own) == "what 9 contacts do is not known"
    assert "if a slip renews all contacts is" in with_rules(said, ["reset"], beside.own)


def test_the_factor_between_readings_has_the_digits_that_their_errors_leave() -> None:
    """558 of two K* that are exact is some 560, and of one that is known to a half some 600."""
    own = told(slips("reset"), kinetic=replace(NUMBER, value=0.5)).own
    for error, factor in ((1e-3, "some 560"), (0.6, "some 600")):
        critical = answers.Quantity(0.44 * 558.0, error * 0.44 * 558.0)
        other = replace(own, name="b", critical_spring=critical)
        lines = text_of(replace(told(), answers=(own, other)))
        assert f"K* differs by a factor of {factor} over 2 readings" in lines


def test_slips_that_still_grow_say_so() -> None:
    """Of four sliders with three slips each, in the headline and the table; not where it may be chance."""
    number, replica = np.tile(np.arange(3), 4), np.repeat(np.arange(4), 3)
    noise = np.random.default_rng(1).normal(0.0, 1.0, 12)
    for scatter, told_so in ((1e-3, True), (0.05, False)):
        befores = np.array([0.21, 0.23, 0.24])[number] + scatter * noise
        each = SimpleNamespace(force_before=befores, replica=replica, number=number)
        assert bool(still_changing(each, 4)) == told_so
    few = Finite("mass", 1000, "stick-slip", before=0.24, still_changing=(0.21, 0.23, 0.24))
    said = page(told(slips("mass", slips=3, contacts=1000, finite=few)))
    assert ", still growing: 0.21" in said[2]
    (row,) = (one for one in said if one.startswith("slips seen (mass)"))
    assert "3 slips of each of 4 sliders, still growing: 0.210" in row


def test_a_scan_tells_how_few_contacts_it_would_hold_itself() -> None:
    """A density of contacts times its own size, from the least to the largest over the readings."""
    heights = 1e-9 * np.random.default_rng(3).standard_normal((64, 48))
    material = Material(contact_modulus=1e9, shear_modulus=1e9, local_friction=0.3)
    laws = [
        from_topography(heights, 1e-8, model="gw", law="amontons", pressure=p, material=material)
        for p in (1e5, 6e5)
    ]
    each = [replace(told(slips("reset")).own, contacts=Contacts(law)) for law in laws]
    (line,) = other_samples(replace(told(), answers=tuple(each)))
    few, many = (law.interface.contact_density * 64e-8 * 48e-8 for law in laws)
    assert 1.0 < 2.0 * few < many < 100.0
    assert f"would hold some {few:.2g} to {many:.2g} contacts" in line
    assert f"its size holds {100.0 * few**-0.5:.2g}% more or fewer" in line


def test_a_slider_that_is_not_decided_stands_beside_k_star() -> None:
    """Below K* = 0.44 and above it, below the table, once; its contacts of the area, which are not known either, have
    no line of their own with another remedy."""
    late = not_followed("instant", "takes 9 steps; loosen it")
    few = Finite("instant", 1000, "unknown", message="1e12 breaks are more than are followed here")
    for spring, where in (
        (1e-2, "below K*, 0.44 N_c<k>: it slips at least once"),
        (2.0, "above K*"),
    ):
        found = told(slips("reset"), late, machine=replace(LIGHT, spring=spring))
        lines = page(replace(found, finite=(few,)))
        (line,) = (one for one in lines if one.startswith("K, "))
        assert where in line and "if contacts re-form at once is not known" in line
        text = "\n".join(lines)
        assert "  not decided if contacts re-form at once: takes 9 steps" in text
        assert "1e12 breaks" not in text and "undecided" not in text
    assert not any(one.startswith("K, ") for one in page(told(slips("reset"))))


def test_smooth_sliding_that_is_unstable_says_so() -> None:
    """In heat that was followed, and in heat that was left out; not on a spring on which it is stable."""
    slides = slips("instant", kind="smooth", slips=0, before=0.5, after=0.5, unstable_below=0.2)
    for left_out, how in ((None, "by less than 0.020 N"), (1e-4, "as heat is left out")):
        said = text_of(told(replace(slides, heat_left_out=left_out)))
        # how far a slider swings that was not followed nobody knows: it may be by more than counts as a slip
        swings = "swinging by less than 0.020 N" if left_out is None else "swinging, as heat"
        assert f"\nsmooth at 0.5000 N_c<k>·length, or {swings}" in said
        assert ("(how far was not followed)" in said) is (left_out is not None)
        assert "steady sliding grow by heat on springs below 0.20 N_c<k>" in said and how in said
    stable = text_of(told(replace(slides, unstable_below=0.0)))
    assert "steady sliding grow" not in stable and "or swinging" not in stable
    # nor is more told of it in the headline than is known
    rough = sentence(told(replace(slides, heat_left_out=0.05, error=0.05)))
    assert rough.startswith("smooth at 0.50") and "or swinging" not in rough


def test_a_swing_too_small_to_be_written_is_told_by_how_wide_it_is() -> None:
    ends, drive = (0.50001, 0.50003), np.array([0.0, 9.0])
    slides = slips("mass", kind="smooth", slips=0, before=0.5, after=0.5, swings=ends, drive=drive)
    answer = told(slides).own
    said = swinging(replace(answer, machine=HEAVY), slides)
    assert said.startswith(", still swinging by 2.0e-05 N_c<k>·length after 9.0 ")


@pytest.mark.parametrize(("part", "told_as"), [(0.0312, "3.1%"), (0.2057, "21%"), (2e-7, "2e-05%")])
def test_drops_that_shrink_by_next_to_nothing_are_not_said_to_shrink_by_0(
    part: float, told_as: str
) -> None:
    said = shrinking(slips("mass", shrinks_by=part))
    assert said == f", each drop {told_as} smaller than the one before"
    assert not shrinking(slips("mass"))


def test_a_force_that_its_error_hides_is_told_by_the_largest_that_it_may_be() -> None:
    """12 µN ± 220 µN is no number; one above its error is."""
    assert hidden_by(0.22e-3, [12e-6], "N") == "less than 300 µN"
    assert hidden_by(0.22e-3, [12e-6, 0.3e-3], "N") == hidden_by(0.22e-3, [0.0], "N") == ""


@pytest.mark.parametrize(("damping", "ask"), [(0.0, "drive.damping"), (1e-3, "a larger damping")])
def test_a_mass_that_rings_too_long_asks_for_a_damping(damping: float, ask: str) -> None:
    """And for no delay, which would not end it."""
    rings = not_followed(
        "mass", "after a slip the slider rings 2e+06 times, and at most 1e+06 may come"
    )
    machine = Machine(1e-2, 1e-4, damping, 1.0)
    once = slips("instant", kind="smooth", after=0.6)
    said = " ".join(dependence(told(rings, slips("reset"), once, machine=machine)))
    assert f"was not followed; give {ask}" in said
