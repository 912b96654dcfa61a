"""What the first sentence of a verdict, its table and its picture say: slips of few contacts, K* of a scan, the first
slip of a mass, and heat that is left out; and that a verdict ends in time."""

import re
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats

import master
from origins import Contacts, InputError, Thermal, from_samples, gaussian, mixture
from tests.scenes import ROUGH, write
from tests.verdicts import HEAVY, slips, told
from toolkit.scene.scene import load_scene
from toolkit.verdict.answers import Quantity
from toolkit.verdict.files import plain
from toolkit.verdict.judge import verdict
from toolkit.verdict.picture import draw_verdict
from toolkit.verdict.sliders.budget import Budget
from toolkit.verdict.sliders.follow import follow
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Finite
from toolkit.verdict.sliders.slips_in_time import SlipsOfMass
from toolkit.verdict.sliders.told import behaviour_of
from toolkit.verdict.text.words import page, sentence
from toolkit.verdict.uncertainty import to_digits, with_sampling

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")

# 2 % of the contacts break at a tenth of the stretch of the others
FEW_WEAK = Contacts(mixture([gaussian(0.1, 3e-4), gaussian(1.0, 0.3)], [0.02, 0.98]))


def test_falls_of_few_contacts_are_no_slips_of_the_slider() -> None:
    """A reset of all contacts whenever 2 % of them break came back 457 times, and was not decided."""
    known = RigidSlider(0.65, 0.54, 0.0, 1.66, 1.0)
    pulled = follow(Machine(0.5, None, 0.0, 1.0), FEW_WEAK, "reset", known, 1e4)
    assert (pulled.kind, pulled.success) == ("undecided", True)
    # nearly all of the weak ones: the others wait for more
    assert 0.015 < pulled.few_break < 0.02
    slides = slips("instant", kind="smooth", slips=1, before=0.5, after=0.5)
    answer, after = sentence(told(pulled, slides)).split("; ")
    assert answer == "smooth at 0.5000 N_c<k>·length if contacts re-form at once"
    assert after.startswith("no stick-slip, as at most 1.7% of the contacts break in each of ")
    assert after.endswith("if a slip renews all contacts")
    text = "\n".join(page(told(pulled, slides)))
    assert "not decided" not in text and "force before a slip (reset: of few contacts)" in text
    alone = sentence(told(pulled))
    assert alone.startswith("no stick-slip, as at most 1.7% of the contacts break")
    assert (
        "falls of few contacts"
        in draw_verdict(told(pulled)).axes[0].get_legend().get_texts()[0].get_text()
    )


def test_k_star_of_a_scan_has_two_digits_in_the_sentence_too() -> None:
    """Another patch or step changes it by orders of magnitude; that of a law that is given is known."""
    scene = write(contacts={"thresholds": ROUGH}, drive={"area": 1e-6}, master=None)
    found = verdict(load_scene(scene, False))
    lines = page(found)
    assert lines[2].startswith("slips at least once on a spring softer than K* = ")
    (row,) = (line for line in lines if line.startswith("slips at least once below the spring K*"))
    number = (
        lines[2]
        .removeprefix("slips at least once on a spring softer than K* = ")
        .partition(" (")[0]
    )
    assert number in row and re.fullmatch(r"(?:\d\.\d|[1-9]\d0?) k?N/m", number)


@pytest.mark.parametrize("kind", ["smooth", "stick-slip"])
def test_the_first_slip_of_a_mass_has_its_forces(kind: str) -> None:
    """Contacts that began together bear more than those of later slips, and than steady sliding."""
    later = {"before": 0.5, "after": 0.5 if kind == "smooth" else -0.2}
    begins = SlipsOfMass(first_forces=(0.61, -0.3))
    first = slips("mass", kind=kind, in_time=begins, error=1e-3, **later)
    rows = [
        line for line in page(told(first, machine=HEAVY)) if line.startswith("first slip (mass)")
    ]
    assert len(rows) == 1
    assert rows[0].split(maxsplit=3)[-1] == "0.6100 N_c<k>·length down to -0.3000 N_c<k>·length"
    ends = later["before"], later["after"]
    alike = replace(first, in_time=SlipsOfMass(first_forces=ends))
    unknown = replace(first, in_time=replace(begins, first_error=0.5))
    for one in (alike, unknown) if kind == "stick-slip" else (alike,):
        shown = any("first slip (mass)" in line for line in page(told(one, machine=HEAVY)))
        assert shown is (kind == "smooth")
    chance = page(told(replace(first, in_time=replace(begins, first_error=0.02)), machine=HEAVY))
    (row,) = (line for line in chance if line.startswith("first slip (mass)"))
    assert "0.61 ± 0.02 N_c<k>·length down to -0.30 ± 0.02 N_c<k>·length" in row


def test_a_mass_tells_the_forces_of_its_first_slip() -> None:
    """That of relaxed contacts begins at F_s, with a mass a little later."""
    wide, path = Contacts(gaussian(1.0, 0.3)), [0.0, 70.0]
    pulled = {"velocity": 1.0, "spring": 1e-2, "mass": 1e-4, "damping": 2e-4}
    found = behaviour_of("mass", master.solve(wide, path, 1e-2, **pulled), 1.0, 1.0, "")
    light: Any = master.solve(wide, path, 1e-6, spring=1e-2, slip="instant")
    assert found.in_time.first_forces is not None
    before, after = found.in_time.first_forces
    assert before == pytest.approx(light.slips.force_before[0], rel=0.02) and after < before


def test_the_legend_says_that_heat_was_left_out() -> None:
    """By a bound that is told on the page; a trace of contacts that heat breaks says nothing."""
    heat = Thermal(law="stiff", temperature=1e-7, attempt_frequency=1e6)
    trace = {"drive": np.linspace(0.0, 60.0, 5), "force": np.linspace(0.0, 0.6, 5)}
    for left_out, there in ((1e-4, True), (None, False)):
        one = slips("mass", heat_left_out=left_out, **trace)
        figure = draw_verdict(told(one, machine=HEAVY, thermal=heat))
        (legend,) = figure.axes[0].get_legend().get_texts()
        assert ("without heat" in legend.get_text().replace("\n", " ")) is there


def test_work_of_a_verdict_ends_with_its_part_of_the_time() -> None:
    """Steady sliding of islands in heat, and another delay of contacts, went on for as long as they took."""

    def goes_on(part: Budget) -> str:
        time.sleep(600.0)
        return "never"

    assert Budget(0.05, strict=True).spend(0.5, goes_on) is None
    assert Budget(0.0, strict=True).spend(1.0, lambda part: "too late") is None
    assert Budget(1e4, strict=True).spend(0.5, lambda part: part.remaining()) == pytest.approx(
        5e3, rel=0.1
    )


def test_k_star_that_is_not_found_in_time_is_not_known() -> None:
    hot = Contacts(gaussian(1.0, 0.3), thermal=Thermal("soft", 1e-2, 1.0))
    late = master.propensity(hot, 1e-3, wall_time=1e-9)
    assert np.isnan([late.critical_spring, late.static_to_kinetic]).all() and not late.success
    assert late.critical_spring_error == late.static_to_kinetic_error == np.inf
    assert late.message == "stopped by wall_time"
    with pytest.raises(InputError, match="wall_time = 0"):
        master.propensity(hot, wall_time=0.0)


def test_resampled_laws_end_with_the_time(monkeypatch: Any) -> None:
    """They are solved by threads, which nobody else ends: a verdict waited for those that had begun."""
    asked, real = list[float](), master.propensity

    def propensity(contacts: Contacts, **named: Any) -> Any:
        asked.append(named["wall_time"])
        return real(contacts, **named | {"wall_time": 1e-9})

    monkeypatch.setattr(master, "propensity", propensity)
    law = from_samples(np.random.default_rng(1).gamma(4.0, 0.25, 40))
    number = Quantity(0.5, 1e-9)
    found = with_sampling(Contacts(law), 1.0, 3 * [number], Budget(30.0, strict=True))
    assert asked and max(asked) <= 30.0
    # F_k has a closed form, and the others are not known
    assert found[0].sampling and found[1:] == 2 * [number]


def test_an_answer_beside_a_bound_on_heat_is_one() -> None:
    """Of a slider with mass whose heat is left out the bound, 0.07 <x_s>, was above what a verdict takes: status 1."""
    hot = Contacts(gaussian(1.0, 0.35), thermal=Thermal("stiff", 5.6e-6, 5e6))
    asked = {"spring": 3e-3, "mass": 28.0, "damping": 6e-2, "velocity": 1.0}
    solved: Any = master.solve(hot, np.linspace(0.0, 1300.0, 300), 1e-3, **asked)
    assert not solved.success and 0.05 < solved.heat_left_out < solved.force_error < 0.1
    found = behaviour_of("mass", solved, 1.0, hot.mean_threshold, "")
    assert (found.kind, found.success) == ("smooth", True)
    assert found.error == pytest.approx(solved.force_error)
    number = np.inf if found.heat_left_out is None else found.heat_left_out
    assert number == solved.heat_left_out


def test_a_force_that_begins_with_1_is_not_rounded_by_half_of_its_error() -> None:
    """106 ± 11 mN stood as 110 mN in a range over readings."""
    for value, error, text in (
        (0.106, 0.011, "106 mN"),
        (0.106, 0.05, "110 mN"),
        (0.313, 0.03, "310 mN"),
    ):
        assert to_digits(value, "N", 0.0, error) == text


@pytest.mark.slow  # 10 s; quick: resets of few contacts, above
def test_slips_of_few_contacts_that_come_back_together_may_grow_to_all_of_them() -> None:
    """At first 4 % of the contacts break together, late slips are of nearly all."""
    start = mixture([gaussian(0.4, 0.002), stats.uniform(0.0, 0.9)], [0.03, 0.97])
    contacts, machine = Contacts(gaussian(1.0, 0.005), start=start), Machine(1.7, None, 0.0, 1.0)
    rigid = RigidSlider(0.5 * 1.0955, 0.5, 0.0, 2.3, 1.0)
    pulled = follow(machine, contacts, "reform-after", rigid, 1e4)
    assert pulled.kind == "stick-slip" and pulled.few_break is None


def test_a_page_says_that_no_number_was_found_in_time() -> None:
    unknown = Quantity(np.nan, np.inf)
    found = told(slips("reset", kind="undecided", slips=0))
    own = replace(found.own, kinetic=unknown, static=unknown, critical_spring=unknown)
    assert "neither force nor K* was found in time" in "\n".join(
        page(replace(found, answers=(own,)))
    )


def test_each_number_of_a_slider_has_its_unit_in_verdict_json() -> None:
    """The swings of a sliding force, a border of stability and an assumed damping were written in solver units, beside
    forces in newtons."""
    lengths = {"period": 3.0, "period_error": 0.1}
    times = {"slip_time": 0.5}
    one = slips(
        "mass",
        before=0.5,
        after=0.25,
        swings=(0.4, 0.6),
        in_time=SlipsOfMass(0.5, first_forces=(0.7, 0.3), first_error=0.01),
        delay=0.2,
        unstable_below=0.01,
        damping=0.1,
        **lengths,
    )
    verdict = told(one, machine=Machine(0.01, 1.0, 0.0, 1.0))
    scale = replace(verdict.own.scale, force=10.0, force_unit="N", spring=1e3, spring_unit="N/m")
    verdict = replace(verdict, answers=(replace(verdict.own, scale=scale),))
    reading = plain(verdict)["readings"][0]
    found = reading["behaviours"][0]
    assert {name: found[name] for name in lengths | times} == lengths | times and found[
        "delay"
    ] == 0.2
    assert (found["before"], found["after"]) == pytest.approx((5.0, 2.5))
    assert found["swings"] == pytest.approx([4.0, 6.0])
    assert found["first_forces"] == pytest.approx([7.0, 3.0])
    assert found["first_error"] == pytest.approx(0.1)
    assert (found["unstable_below"], found["damping"]) == pytest.approx((10.0, 100.0))
    assert reading["units"]["damping"] == "N s/m"
    none = plain(told(slips("reset")))["readings"][0]["behaviours"][0]
    assert none["swings"] is none["unstable_below"] is none["damping"] is None


def test_verdict_json_says_what_its_keys_mean() -> None:
    """Each key but the scene's and the reading's names, and errors that are told beside their numbers."""
    few = Finite("reset", 500, "stick-slip", before=0.6, before_error=0.1)
    found = plain(replace(told(slips("reset")), finite=(few,)))
    reading = found["readings"][0]
    each = [found, reading, reading["kinetic"], *reading["behaviours"], *found["finite"]]
    keys = {name for one in each for name in one} - {"keys", "name", "title", "reading"}
    meant = found["keys"]
    beside = {f"{name}_error" for name in ("before", "after", "period", "late", "first")}
    beside |= {"sampling"}
    assert all(any(f"`{name}`" in said for said in meant.values()) for name in beside)
    assert keys - beside == set(meant) - {"interrupted"} and len(keys) > 50
