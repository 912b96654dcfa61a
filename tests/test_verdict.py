"""`mesofriction verdict`: the sentence, the table and the files hold what closed forms and the solvers say."""

import csv
import os
import re
import signal
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scipy import linalg, stats

import eq_model
import master
import origins
from master.soft import followed
from master.soft.turns import LegEnd, remedy_of
from origins import Contacts, Delay, InputError, gaussian, identical, mixture
from tests.scenes import CONSTANTS, GAUSSIAN, ROUGH, said, write
from tests.verdicts import (
    MACHINE,
    RESET,
    SOFT,
    STATED,
    WIDE,
    infinite,
    judged,
    raising,
    reading,
    rigid,
    text_of,
    verdict_on,
)
from toolkit.processes.signals import Terminated, TimeIsUp, no_longer_than
from toolkit.results.slips import spread_of
from toolkit.running.solvers import within
from toolkit.scene.of_samples import of_islands, of_samples, of_smoothing
from toolkit.scene.scale import Scale, guarded, scale_of, written
from toolkit.scene.scene import load_scene
from toolkit.verdict import answers, judge, uncertainty
from toolkit.verdict.files import plain
from toolkit.verdict.of_area import disagreeing, fall_of, late_force_of, with_more
from toolkit.verdict.picture import draw_verdict
from toolkit.verdict.sliders import ensemble
from toolkit.verdict.sliders.budget import NO_FORCES, NO_TIME, Budget, long_delay
from toolkit.verdict.sliders.ensemble import follow_by_contacts, sliders
from toolkit.verdict.sliders.finite import follow_finite
from toolkit.verdict.sliders.follow import follow
from toolkit.verdict.sliders.forgetting import after_forgetting
from toolkit.verdict.sliders.islands import follow_contacts, with_barriers
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour, Finite, not_followed
from toolkit.verdict.sliders.slips_in_time import SlipsOfMass
from toolkit.verdict.text import kinds
from toolkit.verdict.text.hangs_on import dependence
from toolkit.verdict.text.table import in_units
from toolkit.verdict.text.words import page, sentence
from toolkit.verdict.uncertainty import spring_to_digits
from toolkit.verdict.with_mass import follow_other_delay

GAUSSIAN_CONTACTS = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}}
# one picture of each kind
RENDERED = (
    "test_stick_slip_in_newtons",
    "test_smooth_on_a_stiff_spring",
    "test_few_contacts_slip_where_infinitely_many_slide",
    "test_an_undamped_slider_that_rings_is_told_of_with_some_damping[1.0]",
    "test_a_page_is_written_of_what_is_known_where_f_s_is_too_late[exact]",
)

pytestmark = pytest.mark.usefixtures("in_a_folder")


@pytest.fixture(autouse=True)
def _rendered(request: pytest.FixtureRequest) -> None:
    if request.node.name not in RENDERED:
        request.getfixturevalue("unrendered")


def test_stick_slip_in_newtons(capsys: Any) -> None:
    """From relaxed contacts a reset slips where the load F + K X of a rigid slider's F first falls, and the period is
    X + F/K there."""
    thresholds = ROUGH | {"model": "persson", "law": "paper", "patch_area": 1e-14}
    thresholds["material"] = CONSTANTS | {"force_coefficient": 2.42e10}
    verdict = RESET | {"readings": ["persson/paper"]}
    status, page, found = judged(capsys, thresholds=thresholds, drive=MACHINE, verdict=verdict)
    contacts = load_scene("mine.toml", solved=False).contacts
    surface, mean = contacts.interface, contacts.mean_threshold
    assert surface is not None
    together = surface.contact_density * 1e-6 * surface.mean_stiffness
    spring = 1e6 / together
    x = np.linspace(0.0, 1.5 * mean, 20_001)
    force = master.solve(contacts, x, 1e-10).force
    first = int(np.argmax(np.diff(force + spring * x) < 0.0))
    slips = found["readings"][0]["behaviours"][0]
    assert status == 0 and slips["kind"] == "stick-slip" and slips["slips"] >= 5
    assert slips["before"] == pytest.approx(force[first] * together, rel=1e-6)
    assert slips["period"] == pytest.approx(x[first] + force[first] / spring, rel=1e-6)
    assert page.splitlines()[2].startswith(
        f"stick-slip: {guarded(slips['before'], 'N', 1e-9)} down to 0 N"
    )


def test_smooth_on_a_stiff_spring(capsys: Any) -> None:
    """Above K* the slider ends at the kinetic force <x²>/2<x>."""
    drive = {"spring": 5.0}
    wide = {"kind": "gaussian", "mean": 1.0, "std": 0.3}
    status, page, found = judged(capsys, thresholds=wide, drive=drive)
    law = gaussian(1.0, 0.3)
    assert status == 0 and "smooth at" in page and "all rules agree" in page
    for one in found["readings"][0]["behaviours"]:
        assert one["after"] == pytest.approx(law.moment(2) / (2.0 * law.mean()), abs=2e-3)


def test_without_a_spring_it_says_below_which_one_the_interface_slips(capsys: Any) -> None:
    verdict = {"readings": ["gw/amontons", "persson/amontons", "gw/paper"]}
    tables = {"thresholds": ROUGH, "drive": {"area": 1e-6}, "verdict": verdict}
    status, page, found = judged(capsys, **tables)
    contacts = load_scene("mine.toml", solved=False).contacts
    scale = scale_of(contacts, 1e-6)
    own = master.propensity(contacts).critical_spring * scale.spring
    springs = [one["critical_spring"]["value"] for one in found["readings"]]
    said = written(own, "N/m", max(springs) - min(springs), digits=4)
    assert (
        status == 0
        and f"slips at least once on a spring softer than K* = {said} (from {said} to " in page
    )
    assert found["readings"][0]["critical_spring"]["value"] == pytest.approx(own, rel=1e-5)
    # the material lacks the constant of the paper's law, and the page says so
    assert len(found["readings"]) == 2 and "force_coefficient" in found["left_out"]["gw/paper"]
    assert not Path("mine-output/friction.csv").exists()


def test_few_contacts_slip_where_infinitely_many_slide(capsys: Any) -> None:
    """N K³ is far below 50, so that the ensemble slips above K*: the page tells of these contacts first."""
    surface = load_scene(write(thresholds=ROUGH, master=None), solved=False).contacts.interface
    assert surface is not None
    drive = {"spring": "0.02 N_c<k>", "area": 500.0 / surface.contact_density}
    tables = {"thresholds": ROUGH, "drive": drive, "verdict": RESET | {"readings": ["gw/amontons"]}}
    status, page, found = judged(capsys, **tables)
    own, (few,) = found["readings"][0], found["finite"]
    assert own["critical_spring"]["value"] < own["spring"]
    assert own["behaviours"][0]["kind"] == "smooth" and few["kind"] == "stick-slip"
    assert few["contacts"] == 500 and few["before"] > few["after"] >= 0.0
    first = page.splitlines()[2]
    drop = f"from {written(few['before'], 'N')} down to {written(few['after'], 'N')}"
    smooth = guarded(own["behaviours"][0]["after"], "N", 1e-9)
    told = f"500 contacts stick and slip, {drop}; disagree: infinitely many would slide smoothly"
    assert status == 0 and first == f"{told} at {smooth}"
    # one of their traces stands in the file, too
    fall = few["before"] - few["after"]
    with Path("mine-output/friction.csv").open(encoding="utf-8") as stream:
        _, *rows = csv.reader(stream)
    of_area = [float(row[2]) for row in rows if row[0] == "reset, 500 contacts"]
    assert max(of_area) > 0.9 * few["before"] and -np.diff(of_area).min() > 0.9 * fall
    assert "reset" in {row[0] for row in rows}


@pytest.mark.slow
def test_mass_and_delay_decide_in_place_of_a_slip_rule(capsys: Any) -> None:
    """With a long delay nothing holds in a slip of half a period of mass and spring, and the spring's force falls to
    about minus itself. The swing has died out when contacts form again: beside a tenth of that delay they break in it,
    and slips come at places that rounding decides.

    Both the master equation and the ensemble, which takes a second where the first does not end, tell of these slips.
    """
    drive = {"spring": 1e-3, "mass": 1e-3, "damping": 1e-4}
    contacts = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}}
    tables = {"contacts": contacts | {"delay": {"time": 300.0}}, "drive": drive}
    status, page, found = judged(capsys, **tables, wall_time=60.0)
    (slips,) = found["readings"][0]["behaviours"]
    assert status == 0 and slips["kind"] == "stick-slip" and page.count("stick-slip") >= 1
    assert slips["slip_time"] == pytest.approx(np.pi, rel=0.05)
    assert -1.0 < slips["after"] / slips["before"] < -0.6


@pytest.mark.slow
def test_of_other_readings_in_heat_it_is_told_whether_they_slip(capsys: Any) -> None:
    """A slider that creeps at F_k on a spring a million times softer than its contacts, by two contact models: that of
    the scene is known to a thousandth, the other as well as it takes to tell a slip."""
    heat = {"law": "eyring", "width": 0.03, "attempt_frequency": 1e12}
    material = CONSTANTS | {"shear_strength": 5e7}
    contacts = {"thresholds": ROUGH | {"material": material}, "thermal": heat}
    asked = {"readings": ["gw/amontons", "gw/strength"]}
    drive = MACHINE | {"spring": "50 N/m"}
    status, page, found = judged(capsys, contacts=contacts, drive=drive, verdict=asked)
    own, other = found["readings"]
    assert status == 0 and "not decided" not in page
    for each, most in ((own, 1e-3), (other, 0.03)):
        kinetic = each["kinetic"]["value"]
        for one in each["behaviours"]:
            assert one["kind"] == "smooth" and one["error"] < most
            assert one["after"] == pytest.approx(kinetic, rel=1e-4)


@pytest.mark.slow  # quick: what the solver refuses, in test_verdict_page.py
def test_a_mass_that_is_not_followed_is_told_in_words(capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr(judge, "RULES", ("reset",))  # of those without mass, one will do
    few = "toolkit.verdict.sliders.follow.few_in_heat_are_followed"
    monkeypatch.setattr(few, lambda *_: False)
    heat = {"law": "soft", "temperature": 0.01}
    contacts = {"thresholds": {"kind": "identical", "value": 1.0}, "thermal": heat}
    drive = {"spring": 1.0, "mass": 0.1, "damping": 0.5}
    status, page, found = judged(capsys, contacts=contacts, drive=drive)
    alone, *without_mass = found["readings"][0]["behaviours"]
    assert [one["rule"] for one in without_mass] == ["reset"]
    assert status == 1 and alone["kind"] == "undecided"
    assert "exact thresholds beside a mass" in page and "give the exact values a width" in page
    assert "np." not in page and "master.solve" not in page and "simulate" not in page


def test_slips_between_which_a_mass_slides_on_go_on(capsys: Any) -> None:
    """A slip takes 0.18 of the force, which the spring regains in a fifth of the way to the next: slips that came at
    each threshold were called over, and sliding smooth at F_k and what the damping bears, 1.0."""
    heat = {"law": "soft", "temperature": 0.01}
    contacts = {"thresholds": {"kind": "identical", "value": 1.0}, "thermal": heat}
    drive = {"spring": 1.0, "mass": 0.1, "damping": 0.5}
    status, _, found = judged(capsys, contacts=contacts, drive=drive)
    (alone,) = found["readings"][0]["behaviours"]
    assert status == 0 and alone["kind"] == "stick-slip"
    assert alone["period"] == pytest.approx(1.0, abs=0.01)
    # on a path of 60 the forces of 200,000 contacts swing from 1.177 to 1.000 behind 8, and hardly less behind 50
    assert alone["before"] == pytest.approx(1.177, abs=5e-3)
    assert alone["after"] == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize("part", [0.1, slow(1.0)])
def test_an_undamped_slider_that_rings_is_told_of_with_some_damping(
    part: float, capsys: Any, monkeypatch: Any
) -> None:
    """One that slides at v rings by v (M/K)^(1/2) for ever: the page says which damping was taken to end that, a tenth
    of the critical one, and all of it where it rings with that, too."""
    drive = {"spring": 1e-2, "mass": 1e-4, "velocity": 1e-3}
    critical = 2.0 * (1e-2 * 1e-4) ** 0.5
    table, solve = {"kind": "gaussian", "mean": 1.0, "std": 0.3}, master.solve

    def ringing(*arguments: Any, **named: Any) -> Any:
        if named.get("damping", critical) < 0.99 * part * critical:
            raise InputError("stopped as the slider rings for too long")
        return solve(*arguments, **named)

    monkeypatch.setattr(master, "solve", ringing)
    status, page, found = judged(capsys, thresholds=table, drive=drive)
    (slider,) = found["readings"][0]["behaviours"]
    assert status == 0 and slider["kind"] == "smooth"
    assert slider["damping"] == pytest.approx(part * critical)
    assert f" ({part:.0%} of critical; none is given)" in page and ": give drive.damping" in page


HEAVY = {"spring": "50 N/m", "mass": "0.1 kg", "area": 1e-6, "velocity": 1e-6}


@pytest.mark.slow
def test_a_heavy_slider_on_md_samples_is_answered_with_a_stated_damping(
    capsys: Any, monkeypatch: Any
) -> None:
    """Contacts of 2.5e8 N/m ring at 8 kHz under 0.1 kg, and none of that has to be known: after F_s the slider slides
    at F_k and what the damping bears, which is 2e-5 of it."""
    monkeypatch.setattr(uncertainty, "RESAMPLES", uncertainty.FEWEST)
    quantiles = stats.weibull_min(3.0).ppf((np.arange(150) + 0.5) / 150.0)
    law = {"kind": "from-samples", "f_s": list(quantiles), "unit": "nN", "stiffness": 5.0}
    stated = {"mean_stiffness": 5.0, "contact_density": 5e13}
    contacts = {"thresholds": law, "interface": stated}
    status, page, found = judged(capsys, contacts=contacts, drive=HEAVY)
    (slider,) = found["readings"][0]["behaviours"]
    assert status == 0 and slider["kind"] == "smooth", page
    assert "0.447 N s/m (10% of critical; none is given)" in page and "give drive.damping" in page
    # 5e7 contacts, and k cancels from F of many contacts: N_c <f_s^2>/2<f_s>
    kinetic = 5e7 * 1e-9 * 0.5 * (quantiles**2).mean() / quantiles.mean()
    assert slider["before"] == pytest.approx(kinetic, rel=0.02)
    borne = found["readings"][0]["kinetic"]["value"] + 0.447e-6
    assert slider["before"] == pytest.approx(borne, rel=1e-6)


@pytest.mark.slow
def test_a_heavy_slider_on_a_structure_is_answered_with_a_stated_damping(capsys: Any) -> None:
    """Flakes of 3.2e8 N/m: with a tenth of critical damping the slider turns thousands of times after its slip, and
    with all of it once. It slides at F_k and what the damping bears."""
    origins.circular_island(2.88, radius=16.0).write("flake.xyz")
    substrate = {"kind": "hexagonal", "amplitude": -3.2e-21, "period": 2.46e-10}
    law = {"kind": "domains", "law": "equal", "stiffness": 32.0, "samples": 4000}
    law |= {"island": {"kind": "file", "file": "flake.xyz", "unit": "Å"}, "substrate": substrate}
    stated = {"mean_stiffness": 32.0, "contact_density": 1e13}
    contacts = {"thresholds": law, "interface": stated}
    status, page, found = judged(capsys, contacts=contacts, drive=HEAVY, wall_time=300.0)
    (slider,) = found["readings"][0]["behaviours"]
    assert status == 0 and slider["kind"] == "smooth", page
    assert "of critical; none is given" in page and ": give drive.damping" in page
    critical = 2.0 * (50.0 * 0.1) ** 0.5
    part = 0.1 if "0.447 N s/m (10% of critical" in page else 1.0
    kinetic = found["readings"][0]["kinetic"]["value"]
    assert slider["before"] == pytest.approx(kinetic + part * critical * 1e-6, rel=1e-3)
    light = {name: value for name, value in HEAVY.items() if name != "mass"}
    at_once = judged(
        capsys, contacts=contacts, drive=light, verdict={"rules": ["instant"]}, wall_time=None
    )[2]
    (behaviour,) = at_once["readings"][0]["behaviours"]
    assert behaviour["kind"] == "smooth"
    assert behaviour["before"] == pytest.approx(kinetic, rel=1e-6)


def test_a_force_below_what_counts_as_a_slip_says_so() -> None:
    """Of contacts that hardly hold, as in strong heat: swings of 0.02 <x_s> are more than the force."""
    for force, small in ((0.019, True), (0.021, False)):
        slides = replace(infinite("smooth", 0), before=force, after=force)
        found = sentence(verdict_on(reading(slides, kinetic=force, spring=1.0)))
        counts = ", where swings of less than 0.020 N_c<k>·length would count as no slips"
        assert found.startswith("smooth at 0.0") and (counts in found) is small, found


def test_a_slider_that_has_not_slid_is_not_called_smooth() -> None:
    """The ensemble's path ends while its contacts are only stretched."""
    machine = Machine(spring=1e-3, mass=None, damping=0.0, velocity=1.0)
    contacts = Contacts(gaussian(1.0, 0.2))
    # of an F_s of 0.05, where it is 0.8: the drive stops before the first slip
    found = follow_finite(machine, contacts, 500.0, infinite("smooth", 0), 0.05, 60.0)
    assert found.kind == "unknown" and "before they slid" in found.message


def test_the_ensemble_takes_over_where_the_master_equation_does_not_end(
    capsys: Any, monkeypatch: Any
) -> None:
    """A slip takes half a period of mass and spring, and the page says whose slips they are."""
    drive = {"spring": 1e-3, "mass": 1e-3, "damping": 1e-4}
    contacts = {
        "thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2},
        "delay": {"time": 10.0},
    }

    monkeypatch.setattr(master, "solve", raising(InputError("mass: not in time")))
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.CONTACTS", 5000)
    _, page, found = judged(capsys, contacts=contacts, drive=drive)
    (slips,) = found["readings"][0]["behaviours"]
    assert slips["kind"] == "stick-slip" and "by the ensemble, 4 sliders" in page
    assert slips["slip_time"] == pytest.approx(np.pi, rel=0.05)
    # the spring swings to nearly minus its force and back while all contacts are out: the period has less than the drop
    drop, regained = slips["before"] - slips["after"], slips["period"] * drive["spring"]
    assert 1.5 < drop / regained < 2.5
    rows = dict(re.split(" {2,}", line)[:2] for line in page.splitlines() if "(mass)" in line)
    assert rows["drop of a slip (mass)"].startswith(f"{drop:.2f}"[:3])
    assert rows["of it regained over a period (mass)"].startswith(f"{regained:.2f}"[:3])
    assert "rings after a slip" in page and "F_s of a rigid slider at " in page


@pytest.mark.slow  # quick: the test before
def test_what_is_regained_over_a_long_delay_is_not_told(capsys: Any, monkeypatch: Any) -> None:
    """The drive goes on by 4 % of the period in it, and loads no spring."""

    monkeypatch.setattr(master, "solve", raising(InputError("mass: not in time")))
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.CONTACTS", 5000)
    drive = {"spring": 1e-3, "mass": 1e-3, "damping": 1e-4}
    wait = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}, "delay": {"time": 30.0}}
    _, page, _ = judged(capsys, contacts=wait, drive=drive)
    assert "drop of a slip (mass)" in page and "of it regained" not in page


@pytest.mark.slow  # quick: slips of few contacts are over once they slide, in test_fading_slips.py
def test_slips_on_the_way_to_sliding_are_not_called_stick_slip(monkeypatch: Any) -> None:
    """Contacts that re-form at once slip many times before they slide: on a longer way no slip follows, so that where
    infinitely many are not decided the slips of fewer contacts than there are tell nothing, and those of all that they
    slide."""
    machine = Machine(spring=0.1, mass=None, damping=0.0, velocity=1.0)
    contacts = Contacts(gaussian(1.0, 0.1))
    asked = replace(infinite("undecided", 2), rule="instant")
    found = follow_finite(machine, contacts, 1e5, asked, 0.8, 1e4)
    assert found.kind == "smooth" and found.slips > 8.0 and not found.rises
    kinetic = master.steady_state(contacts, velocity=1.0).force
    assert found.late == pytest.approx(kinetic, abs=1e-3)  # N^(-2/3) is 5e-4
    monkeypatch.setattr("toolkit.verdict.sliders.finite.MOST_CONTACTS", 20_000)
    found = follow_finite(machine, contacts, 1e5, asked, 0.8, 1e4)
    assert found.kind == "unknown" and "perhaps only until they slide" in found.message
    way = np.linspace(0.0, 100.0, 401)
    longer = eq_model.simulate(contacts, way, spring=0.1, slip="instant", n_contacts=100_000)
    assert longer.slips.drive.size > 8 and longer.slips.drive.max() < 30.0


@pytest.mark.parametrize("rule", ["reform-after", slow("reset")])
def test_one_slip_to_no_force_is_followed_until_it_is_known_whether_it_goes_on(
    rule: str, monkeypatch: Any
) -> None:
    """Above K* the spring is pulled far beyond 40 mean thresholds after a slip to no force: that was told as smooth, as
    the path ended. Held against other sliders on a longer way; where there is no time for more the slip is told."""
    spring, told = 1e-3, replace(infinite("smooth", 0), rule=rule, after=1.0)
    machine, contacts = Machine(spring, None, 0.0, 1.0), Contacts(stats.expon())
    found = follow_finite(machine, contacts, 2e4, told, 1.0, 1e4)
    own = eq_model.simulate(
        contacts, [0.0, 8e3], spring=spring, slip=rule, n_contacts=20_000, n_replicas=4, seed=5
    )
    assert own.slips.drop.size >= 24
    assert found.kind == "stick-slip" and found.slips >= 3.0 and found.after == 0.0
    before = own.slips.mean("force_before", 3)[0]
    assert abs(found.before - before) < 0.02 and abs(spring * found.period - before) < 0.02
    monkeypatch.setattr("toolkit.verdict.sliders.finite.SEVERAL", 1e6)  # too long for few, too
    cut = follow_finite(machine, contacts, 2e4, told, 1.0, 1e4)
    assert (cut.kind, cut.slips, cut.after) == ("unknown", 1.0, 0.0)
    assert "more than are followed here" in cut.message


def test_a_trace_that_is_followed_further_keeps_the_slope_of_its_loading() -> None:
    """Its points begin with the drive, and not where the force is taken as that of steady sliding: the first load was
    drawn as a line to there, seven times as long."""
    contacts, told = (
        Contacts(stats.expon()),
        replace(infinite("smooth", 0), rule="reset", after=1.0),
    )
    found = follow_finite(Machine(0.2, None, 0.0, 1.0), contacts, 2000.0, told, 1.0, 60.0)
    loading = np.linspace(0.0, 8.0, 33)
    exact = master.solve(contacts, loading, spring=0.2).force
    assert found.kind == "stick-slip"
    assert np.interp(loading, found.drive, found.force) == pytest.approx(exact, abs=0.04)


def test_few_contacts_that_re_form_at_once_bear_more_than_infinitely_many() -> None:
    """Exponential thresholds on a soft spring: the drive goes on until they have slid, and the force is that of a far
    longer way of other sliders."""
    machine, contacts = Machine(1e-3, None, 0.0, 1.0), Contacts(stats.expon())
    told = replace(infinite("smooth", 0), rule="instant", after=1.0)
    finite = follow_finite(machine, contacts, 1000.0, told, 1.0, 60.0)
    way = np.linspace(1.2e3, 1.5e3, 31)
    own = eq_model.simulate(
        contacts, way, spring=1e-3, slip="instant", n_contacts=1000, n_replicas=8, seed=5
    )
    exact, error = own.forces.mean(), own.forces.mean(axis=1).std(ddof=1) / 8**0.5
    assert abs(finite.late - exact) < 5.0 * (finite.late_error + error)
    scale = scale_of(contacts, None)
    assert "at the end they bear 1.07" in late_force_of(finite, 1.0, scale)
    rising = late_force_of(replace(finite, rises=True), 1.0, scale)
    assert "which still rises" in rising and not finite.rises
    assert not late_force_of(finite, finite.late + 2.0 * finite.late_error, scale)


@pytest.mark.slow  # quick: the test before
def test_few_contacts_on_a_softer_spring_are_pulled_further() -> None:
    """As they bear more."""
    machine, contacts = Machine(1e-3, None, 0.0, 1.0), Contacts(stats.expon())
    told = replace(infinite("smooth", 0), rule="instant", after=1.0)
    # softer ones are pulled further, as they bear more
    softer = follow_finite(replace(machine, spring=1e-4), contacts, 1000.0, told, 1.0, 60.0)
    way = np.linspace(1.3e4, 1.4e4, 21)
    own = eq_model.simulate(
        contacts, way, spring=1e-4, slip="instant", n_contacts=1000, n_replicas=4, seed=5
    )
    error = own.forces.mean(axis=1).std(ddof=1) / 4**0.5
    assert not softer.rises and softer.late > 1.0 + 7.5 * 1000 ** (-2 / 3)
    assert abs(softer.late - own.forces.mean()) < 5.0 * (softer.late_error + error)


def test_fewer_contacts_than_the_areas_are_pulled_as_far_as_they_need(monkeypatch: Any) -> None:
    """Where all of them would break too often, on the way of those that are followed; a refusal names the breaks of
    all."""
    told = replace(infinite("smooth", 0), rule="instant", after=1.0)
    contacts, spring = Contacts(stats.expon()), 1e-3
    monkeypatch.setattr("toolkit.verdict.sliders.budget.MOST_BREAKS", 5e6)
    found = follow_finite(Machine(spring, None, 0.0, 1.0), contacts, 5e4, told, 1.0, 60.0)
    assert 2e4 < found.contacts < 4e4 and found.kind == "smooth" and not found.rises
    needed = (1.0 + 7.5 * found.contacts ** (-2 / 3)) / spring + 1.0 + 40.0
    assert found.drive[-1] >= needed * (1.0 - 1e-9)
    found = follow_finite(Machine(1e-9, None, 0.0, 1.0), contacts, 1e4, told, 1.0, 60.0)
    breaks = 4e4 * (42.0 + 4.5 * 1e4 ** (-2 / 3) / 1e-9)
    assert found.message == f"some {breaks:.1g} breaks are more than are followed here"


def test_a_slow_machine_follows_fewer_contacts_than_its_pilot_promised(monkeypatch: Any) -> None:
    """Where all take longer than was expected the rest of the time is for a sixteenth of them, not for the pilot's."""
    real = ensemble.followed_within

    def slow(following: Any, seconds: float) -> Any:
        late = following.total > 4 * 8_000 or (following.total == 4 * 8_000 and seconds < 20.0)
        return None if late else real(following, seconds)

    monkeypatch.setattr(ensemble, "followed_within", slow)
    machine, contacts = Machine(1e-3, None, 0.0, 1.0), Contacts(stats.norm(1.0, 0.2))
    path = np.linspace(0.0, 2500.0, 50)
    for number, kept in ((64_000, 4_000), (16_000, 1_000), (8_000, 8_000)):
        found = sliders(machine, contacts, "reset", path, number, seconds=30.0)
        assert found.contacts == 4 * kept and len(np.unique(found.slips.replica)) == 4


@pytest.mark.parametrize("stop", [slow(KeyboardInterrupt), Terminated])
def test_an_interrupted_verdict_tells_what_is_known(
    stop: type[BaseException], capsys: Any, monkeypatch: Any
) -> None:
    """Of a slip rule, the number of contacts or the last reading; before anything is known nothing is written."""
    status, word = (130, "interrupted") if stop is KeyboardInterrupt else (143, "terminated")

    ends = raising(stop)
    drive = {"spring": "0.5 N_c<k>", "area": 1e-9, "velocity": 1e-6}
    given: dict[str, Any] = {"contacts": STATED, "drive": drive, "verdict": RESET}
    parts = {"follow_contacts": "before it was followed", "follow_finite": "before it was followed"}
    for name, told in parts.items():
        with monkeypatch.context() as patched:
            patched.setattr(f"toolkit.verdict.judge.{name}", ends)
            found_status, page, found = judged(capsys, **given)
        assert found_status == status and f"interrupted {told}" in page
        assert page.splitlines()[2] == "interrupted; this is what was known by then"
        assert found["interrupted"] and found["readings"][0]["kinetic"]["value"] > 0.0
    with monkeypatch.context() as patched:
        patched.setattr(master, "steady_state", ends)
        ended, out, err = said(capsys, "verdict", write(master=None, **given), "--out", "new")
    assert ended == status and not out and not Path("new").exists()
    assert err[-1] == f"mesofriction: {word}; nothing was written"
    number = signal.SIGINT if stop is KeyboardInterrupt else signal.SIGTERM
    with monkeypatch.context() as patched:
        # while it draws
        patched.setattr(
            "toolkit.verdict.picture.draw_springs", lambda *_: os.kill(os.getpid(), number)
        )
        ended, out, err = said(capsys, "verdict", write(master=None, **given), "--out", "drawn")
    assert ended == status and out[-1] == "written to drawn"
    assert err[-1] == f"mesofriction: {word}; the answer is written to drawn"


def by_hand(rule: str, number: int, spring: float, end: float) -> tuple[Any, Any]:
    """Exponential contacts on a spring, each break by hand: forces before and after each avalanche, and slips of a
    fifth of the contacts or more as drive, force before and fall. At balance K N (X_T - X) = n X - (sum of births)."""
    rng = np.random.default_rng(3)
    at, born = rng.exponential(size=number), np.zeros(number)  # where each breaks, inf while out
    pull, held, births = spring * number, number, 0.0
    trace, slips = list[tuple[float, float]](), list[tuple[float, ...]]()
    while True:
        first = float(at.min())
        drive = (first * (pull + held) - births) / pull
        if drive > end:
            return np.array(trace), np.array(slips)
        before, broken = pull * (drive - first) / number, list[int]()
        there = first
        while at[next_one := int(at.argmin())] <= there:
            x, at[next_one] = at[next_one], np.inf
            broken.append(next_one)
            births -= born[next_one]
            held -= 1
            if rule == "instant":
                at[next_one], born[next_one] = x + rng.exponential(), x
                births, held = births + x, held + 1
            there = (pull * drive + births) / (pull + held)
        if rule != "instant":
            at[broken], born[broken] = there + rng.exponential(size=len(broken)), there
            births, held = births + there * len(broken), number
        after = pull * (drive - there) / number
        trace += [(drive, before), (drive, after)]
        if len(broken) >= 0.2 * number:
            slips.append((drive, before, before - after))


def test_the_scatter_of_few_contacts_is_that_of_a_simulation_by_hand() -> None:
    """On a stiff spring their force fluctuates by some K/(K + 1) N^(-1/2), within three errors of a deviation from 40
    forces that hang together over a threshold; on a soft one slips of all contacts are told without far smaller ones.
    """
    contacts, told = Contacts(stats.expon()), infinite("smooth", 0)
    stiff = follow_finite(Machine(10.0, None, 0.0, 1.0), contacts, 200.0, told, 1.0, 60.0)
    trace, _ = by_hand("reform-after", 200, 10.0, 300.0)
    force = np.interp(np.linspace(5.0, 300.0, 9_000), *trace.T)
    assert stiff.kind == "smooth" and abs(stiff.late - force.mean()) < 5.0 * stiff.late_error
    assert stiff.fluctuation == pytest.approx(force.std(), rel=3.0 * 80**-0.5)
    assert force.std() == pytest.approx(200**-0.5 * 10.0 / 11.0, rel=0.2)
    told = replace(told, rule="reform-after")
    soft = follow_finite(Machine(0.03, None, 0.0, 1.0), contacts, 200.0, told, 1.0, 60.0)
    drive, before, fall = by_hand("reform-after", 200, 0.03, 1500.0)[1].T
    large = fall > 0.2 * fall.max()
    assert soft.kind == "stick-slip" and soft.smaller > 0 and 5 < (~large).sum() < large.sum()
    befores, drops, periods = soft.befores, soft.drops, soft.periods
    assert befores and drops and periods and befores.number >= 12
    for one, own in (
        (befores, before[large]),
        (drops, fall[large]),
        (periods, np.diff(drive[large])),
    ):
        error = own.std() * (1.0 / one.number + 1.0 / own.size) ** 0.5
        assert abs(one.mean - own.mean()) < 4.0 * error
        assert one.std == pytest.approx(own.std(), rel=0.6)


def test_sliders_that_would_take_too_long_are_not_followed() -> None:
    """A pilot of a twentieth of the contacts tells their time, and no time is left."""
    machine, contacts = (
        Machine(spring=0.5, mass=None, damping=0.0, velocity=1.0),
        gaussian(1.0, 0.2),
    )
    asked = infinite("stick-slip", 5)
    found = follow_finite(machine, Contacts(contacts), 1e4, asked, 0.8, seconds=0.0)
    assert (
        found.kind == "unknown"
        and "10,000 contacts were not followed: wall_time is used up (60 s" in found.message
    )


def test_readings_that_lack_a_constant_share_one_line(capsys: Any) -> None:
    """And a material with a hardness is read as plastic above it, too."""
    tables = {"thresholds": ROUGH, "drive": {"area": 1e-6}}
    tables["thresholds"] = ROUGH | {"material": CONSTANTS | {"hardness": 2e8}}
    _, page, found = judged(capsys, **tables)
    assert {"gw/amontons", "gw/amontons/mixed"} <= {one["reading"] for one in found["readings"]}
    assert page.count("left out: ") == 2 and "need material.force_coefficient, which is not" in page


def test_a_scan_with_gaps_has_a_verdict_that_tells_the_missing_share(capsys: Any) -> None:
    pytest.importorskip("SurfaceTopography")
    heights = 200.0 * origins.self_affine_surface((24, 24), 1.0, hurst=0.8, rms_slope=0.1, seed=1)
    heights[::9, ::9] = np.nan  # 9 of 576
    np.savetxt("gaps.txt", heights, header="Width: 10 µm\nHeight: 10 µm\nValue units: nm")
    tables = {"thresholds": ROUGH | {"surface": {"kind": "scan", "file": "gaps.txt"}}}
    tables |= {"drive": {"area": 1e-6}, "verdict": {"readings": ["gw/amontons"], "steps": [1]}}
    status, page, found = judged(capsys, **tables)
    assert status == 0 and [one["reading"] for one in found["readings"]] == ["gw/amontons"]
    assert "1.6% of the scan's points are missing: a slope counts where" in page


def test_many_contacts_do_what_infinitely_many_do(capsys: Any) -> None:
    """The mean force before a slip of 20,000 contacts lies within 5 standard errors and the late slip of N^(-2/3). The
    number stands in [eq], whose path is the verdict's own."""
    tables = {"drive": {"spring": 0.5}, "eq": {"contacts": 20_000}, "verdict": RESET}
    status, page, found = judged(capsys, **tables)
    (many,), master_says = found["finite"], found["readings"][0]["behaviours"][0]
    apart = abs(many["before"] - master_says["before"])
    assert apart < 5.0 * many["before_error"] + 20_000 ** (-2 / 3)
    assert status == 0 and many["kind"] == master_says["kind"] == "stick-slip"
    assert "20,000 contacts, if a slip renews all contacts: stick-slip" in page


def test_slips_stand_in_the_trace_at_their_own_places(capsys: Any) -> None:
    tables = {"drive": {"spring": 0.5}, "verdict": RESET}
    judged(capsys, **tables)
    with Path("mine-output/friction.csv").open(encoding="utf-8") as stream:
        head, *rows = list(csv.reader(stream))
    assert head == [
        "slip rule",
        "drive [length]",
        "spring force [N_c<k>·length]",
        "slider [length]",
        "time [time]",
    ]
    drive, force, slider, time = np.array([[float(word) for word in row[1:]] for row in rows]).T
    np.testing.assert_allclose(0.5 * (drive - slider), force, atol=1e-12)
    assert (time == drive).all() and np.diff(slider).min() > -1e-12
    steps = np.diff(force)
    slips = np.flatnonzero(steps < -0.1)
    assert slips.size >= 5 and np.all(np.diff(drive)[slips] == 0.0)


def test_where_the_slip_rule_decides_the_sentence_is_short_and_the_numbers_follow(
    capsys: Any,
) -> None:
    """K = 0.95 is below K* = 1.036: with a reset it slips for ever, else a few times."""
    tables = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}}
    status, page, found = judged(capsys, drive={"spring": 0.95}, **tables)
    _, _, said, *numbers = page.splitlines()
    assert status == 0 and said == found["verdict"] and len(said) < 160
    assert said.startswith(
        "what contacts do in a slip decides: stick-slip if a slip renews all contacts, "
    )
    assert "smooth if contacts re-form after the slip or contacts re-form at once" in said
    assert [line.strip() for line in numbers[:2]] == found["numbers"]
    assert found["numbers"][0].startswith("stick-slip: ") and "smooth at 0.5" in page


def test_one_number_has_the_same_digits_wherever_it_stands(capsys: Any) -> None:
    """F_k is known to a few per cent over the readings: three digits or four, in the sentence and in the table."""
    readings = {"readings": ["gw/amontons", "persson/amontons"], "rules": ["reset"]}
    drive = {"spring": "0.9 N_c<k>", "area": 1e-7}
    _, page, found = judged(capsys, thresholds=ROUGH, drive=drive, verdict=readings)
    one, other = (reading["kinetic"]["value"] for reading in found["readings"])
    assert abs(one - other) > 1e-3 * one
    (row,) = (line for line in page.splitlines() if line.startswith("kinetic friction"))
    said = re.split(" {2,}", row)[1]
    assert f"smooth at {said};" in page and said in (written(one, "N"), written(one, "N", digits=4))


def test_where_the_readings_decide_their_kinds_are_counted(capsys: Any) -> None:
    """K lies between the two readings' K*, far enough from both."""
    readings = {"readings": ["gw/amontons", "persson/amontons"], "rules": ["reset"]}
    _, _, found = judged(capsys, thresholds=ROUGH, drive={}, verdict=readings)
    surface = load_scene("mine.toml", solved=False).contacts.interface
    assert surface is not None
    springs = [one["critical_spring"]["value"] for one in found["readings"]]
    assert max(springs) > 2.0 * min(springs)
    between = np.sqrt(np.prod(springs)) / surface.per_area(1.0)
    drive = {"spring": f"{between:.6g} N_c<k>"}
    _, page, _ = judged(capsys, thresholds=ROUGH, drive=drive, verdict=readings)
    kinds = {"smooth by gw/amontons", "stick-slip by 1 other reading"}
    if springs[0] > springs[1]:
        kinds = {"stick-slip by gw/amontons", "smooth by 1 other reading"}
    assert all(kind in page for kind in kinds)


def test_a_speed_that_is_left_out_and_a_temperature_of_a_room_in_celsius_are_asked_about(
    capsys: Any,
) -> None:
    """1 m/s is fast for a machine in N/m: with laws in time it decides. 25 K are 25 °C as a rule."""
    heat = {"law": "soft", "temperature": {"kelvin": 25}, "attempt_frequency": 1e12}
    for drive, contacts, asks in (
        ({}, STATED | {"thermal": heat}, True),
        ({}, STATED, True),
        ({"velocity": 1e-6}, STATED, False),
    ):
        machine = {"spring": "0.2 N/m", "area": 4e-9} | drive  # of 2,000 contacts
        page, found = judged(capsys, contacts=contacts, drive=machine, verdict=RESET)[1:]
        told = [
            line.startswith("the speed: none is given, and 1 m/s") for line in found["hangs_on"]
        ]
        assert any(told[:2]) is any(told) is asks
        asked = "if 25 °C is meant, write kelvin = 298.15" in page
        assert asked is ("thermal" in contacts)


def test_few_samples_are_told_on_the_page(capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr(uncertainty, "of_resampled", lambda *_, **__: [])
    tables = {"thresholds": {"kind": "from-samples", "x_s": [0.9, 1.0, 1.3]}}
    _, page, _ = judged(capsys, drive={"spring": 5.0}, verdict=RESET, **tables)
    assert "few thresholds" in page and "3 samples" in page


@pytest.mark.slow  # quick: the page's errors of other samples, below; their size in test_samples.py
def test_samples_have_a_sampling_error_near_that_of_their_mean(capsys: Any) -> None:
    """F_k = <x²>/2<x> of n samples of a narrow law scatters as half their mean, std/(2 n^(1/2))."""
    samples = np.random.default_rng(1).normal(1.0, 0.1, 100).tolist()
    tables = {"thresholds": {"kind": "from-samples", "x_s": samples}, "drive": {"spring": 0.5}}
    _, page, found = judged(capsys, verdict=RESET, **tables)
    kinetic = found["readings"][0]["kinetic"]
    expected = 0.1 / (2.0 * 100**0.5)
    own = 0.5 * np.std(samples) / 100**0.5
    # but for the skewness of the samples, times their std over two
    assert kinetic["sampling"] == pytest.approx(own, rel=0.05) and kinetic["resampled"] == 0
    assert 0.8 * expected < own < 1.2 * expected and "±" in page
    assert "of F_k by moments, else by 20 resamplings of the 100 thresholds, known to ± 16%" in page


def test_where_k_star_takes_too_long_other_samples_tell_of_the_force_alone(
    capsys: Any, monkeypatch: Any
) -> None:
    """And where that is too late, too, the page says so; a surface is one sample, and a given law has none."""
    monkeypatch.setattr(uncertainty, "RESAMPLES", 4)
    law, begun, calls = {"kind": "from-samples", "x_s": [0.8, 0.9, 1.0, 1.1, 1.3]}, [], []

    def late(law: Any, count: int, work: Any, until: float) -> list[Any]:
        calls.append(work)
        return begun[-1](law, count, work, until=until) if len(calls) > 1 and begun else []

    resampled = uncertainty.of_resampled
    monkeypatch.setattr(uncertainty, "of_resampled", late)
    waiting = {"thresholds": law, "delay": {"time": 0.1}}
    # without a spring, on which the slider would be followed in steps of time
    tables = {"drive": {"velocity": 1.0}, "contacts": waiting}
    _, page, found = judged(capsys, **tables)
    assert "other samples: no time was left to resample the 5 thresholds" in page
    assert found["readings"][0]["kinetic"]["sampling"] is None
    begun.append(resampled)
    calls.clear()
    _, page, found = judged(capsys, **tables)
    own = found["readings"][0]
    assert own["kinetic"]["sampling"] > 0.0 and own["critical_spring"]["sampling"] is None
    assert "other samples: one standard error, by 4 resamplings of the 5 thresholds" in page
    begun.clear()
    tables = {"drive": {"spring": 5.0}, "verdict": RESET, "thresholds": law}
    _, page, found = judged(capsys, **tables)
    own = found["readings"][0]
    assert own["kinetic"]["sampling"] > 0.0 and own["critical_spring"]["sampling"] is None
    assert "other samples: one standard error, by the moments of the 5 thresholds" in page
    _, page, _ = judged(capsys, drive={"spring": 5.0}, verdict=RESET)
    assert "other samples" not in page
    machine = MACHINE | {"area": 1e-9}
    _, page, _ = judged(
        capsys, contacts={"thresholds": ROUGH}, drive=machine, verdict=RESET | {"steps": [1]}
    )
    (line,) = (one for one in page.splitlines() if one.startswith("other samples: one surface"))
    assert line.endswith("tells nothing of others")  # moments have no size


def test_slips_above_the_static_force_of_the_start_have_their_reason(capsys: Any) -> None:
    """Contacts that start with a width break less together than those that a slip has renewed."""
    start = {"kind": "gaussian", "mean": 0.0, "std": 0.2}
    for given, told in (({"start": start}, True), ({}, False)):
        _, page, found = judged(
            capsys, contacts=GAUSSIAN_CONTACTS | given, drive={"spring": 0.05}, verdict=RESET
        )
        own = found["readings"][0]
        assert (own["behaviours"][0]["before"] > 1.1 * own["static"]["value"]) is told
        assert ("slips begin above F_s" in page) is told


@pytest.mark.slow  # quick: the sampling error of cold samples above
def test_the_sampling_error_of_contacts_that_wait_is_that_of_their_force() -> None:
    """F_k of a long delay is <x_s²>/2 over the way in it: other samples scatter it by some 2 (std/mean) N^(-1/2)."""
    x_s = np.random.default_rng(5).uniform(0.5, 1.5, 60).tolist()
    contacts = {"thresholds": {"kind": "from-samples", "x_s": x_s}, "delay": {"time": 1e4}}
    found = judge.verdict(load_scene({"contacts": contacts, "wall_time": 1e3}, solved=False))
    kinetic = found.own.kinetic
    assert kinetic.value == pytest.approx(np.mean(np.square(x_s)) / 2e4, rel=0.01)
    expected = np.std(np.square(x_s)) / np.mean(np.square(x_s)) / 60**0.5
    assert kinetic.sampling is not None
    assert 0.7 * expected < kinetic.sampling / kinetic.value < 1.5 * expected


def test_digits_are_those_that_the_uncertainty_leaves() -> None:
    assert written(0.254779, "N", 0.01) == "250 mN"
    # one digit more where the uncertainty is told elsewhere: heat of 0.03 % is not a step from 250 to 260 mN
    assert guarded(0.254979, "N", 0.1) == guarded(0.255056, "N", 0.1) == "255 mN"
    springs = [spring_to_digits(one, "N/m", 1.11e5) for one in (1.853e4, 1.295e5)]
    assert springs == ["19 kN/m", "130 kN/m"]
    assert guarded(0.254979, "N", 1e-6) == "255.0 mN" and guarded(0.254979, "N", 0.0) == "255 mN"
    assert written(0.254779, "N") == "255 mN"
    assert written(45297237.6, "N/m") == "45.3 MN/m"
    assert written(5098.65, "s") == "5,100 s"
    assert written(0.0, "N") == "0 N" and written(np.inf, "N/m") == "infinite"


def test_units_follow_what_is_known() -> None:
    plain = scale_of(Contacts(gaussian(1.0, 0.1)), None)
    assert (plain.force_unit, plain.spring_unit, plain.load) == ("N_c<k>·length", "N_c<k>", None)
    tables = {"thresholds": ROUGH, "drive": {"area": 1e-6}, "master": None}
    contacts = load_scene(write(**tables), solved=False).contacts
    per_area, pad = scale_of(contacts, None), scale_of(contacts, 2e-6)
    assert per_area.force_unit == "Pa" and pad.force == pytest.approx(2e-6 * per_area.force)
    assert pad.load == pytest.approx(2.0) and per_area.load == pytest.approx(1e6)


REFUSED = {
    "times": ({"drive": {"spring": 1.0, "times": [1.0]}}, "drive.to: is missing"),
    "rules": ({"drive": {"spring": 1.0}, "verdict": {"rules": ["best"]}}, "verdict.rules = 'best'"),
    "reading": (
        {"thresholds": ROUGH, "verdict": {"readings": ["hertz/amontons"]}},
        "verdict.readings = 'hertz/amontons'",
    ),
    "law": (
        {"thresholds": ROUGH, "verdict": {"readings": ["gw/coulomb"]}},
        '\'gw/coulomb\': must be a model and a law, as "gw/amontons", or those and a regime, as "gw/paper/mixed": '
        "models are gw and persson, laws amontons, strength, paper, regimes of gw elastic",
    ),
    "patches": (
        {"thresholds": ROUGH, "verdict": {"readings": ["persson/strength"]}},
        "gw/strength",
    ),
    "slip": ({"drive": {"spring": 1.0, "mass": 1.0, "slip": "reset"}}, "drive.slip = 'reset'"),
    "unit": (
        {"thresholds": ROUGH | {"pressure": 1.0}, "drive": MACHINE | {"area": 1e-10}},
        "is the unit right?",
    ),
    "sign": ({"drive": {"spring": 1.0, "mass": "-0.1 kg"}}, "drive.mass = '-0.1 kg': must be"),
    "not a surface": ({"verdict": {"readings": ["gw/paper"]}}, "verdict.readings"),
    "steps": ({"thresholds": ROUGH, "verdict": {"steps": [2]}}, "verdict.steps = 2"),
    "area": ({"thresholds": ROUGH, "drive": {"spring": "50 N/m"}}, "drive.spring"),
    "own": (
        {"thresholds": ROUGH | {"law": "strength", "material": CONSTANTS}},
        "material.shear_strength",
    ),
}


@pytest.mark.parametrize(("tables", "named"), REFUSED.values(), ids=REFUSED)
def test_bad_input_is_one_line_and_writes_nothing(
    capsys: Any, tables: dict[str, Any], named: str
) -> None:
    tables = {"drive": {"velocity": 1.0}, "master": None} | tables
    status, out, err = said(capsys, "verdict", write(**tables))
    assert status == 2 and not out and named in err[0] and len(err) == 1
    assert not Path("mine-output").exists()


STRETCHED: dict[str, Any] = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}}
STRETCHED = {"contacts": STRETCHED | {"reforming": {"kind": "boltzmann", "temperature": 0.01}}}


def test_rules_that_leave_contacts_out_are_left_out_where_they_re_form_stretched(
    capsys: Any,
) -> None:
    """No solver takes them: they stood as "not decided" in the sentence. By name they are refused before any work."""
    drive = {"spring": 0.1, "velocity": 1.0}
    status, page, found = judged(capsys, drive=drive, **STRETCHED)
    rules = [one["rule"] for one in found["readings"][0]["behaviours"]]
    assert status == 0 and rules == ["reset", "instant"] and "not decided" not in page
    assert (
        'not every slip rule: contacts that re-form stretched would be out in a slip by "re' in page
    )
    for own in (
        {"drive": drive | {"slip": "reform-after"}},
        {"verdict": {"rules": ["reform-after"]}},
    ):
        said_by = said(capsys, "verdict", write(**(STRETCHED | {"drive": drive} | own)))
        assert (
            said_by[0] == 2 and "'reform-after': contacts that re-form stretched" in said_by[2][0]
        )


def test_a_speed_that_is_not_given_is_told_also_without_a_machine_where_it_matters(
    capsys: Any,
) -> None:
    """In heat the table had forces "at 1.00 m/s" of a scene that names no speed, and no word on it."""
    said_of_it = "the speed: none is given, and 1 m/s is taken; forces and K* hang on it"
    heat = {"law": "eyring", "width": 0.03, "attempt_frequency": 1e10}
    for laws, told in (({"thermal": heat}, True), ({}, False)):
        contacts = {"thresholds": ROUGH} | laws
        readings = {"readings": ["gw/amontons"], "steps": [1]}
        _, page, _ = judged(capsys, contacts=contacts, drive={"area": 1e-6}, verdict=readings)
        assert (said_of_it in page) is told


@pytest.mark.slow  # the slider is followed in heat four times
def test_a_path_that_turns_is_left_out_as_one_that_ends(capsys: Any) -> None:
    """The verdict finds its own, at the speed of the first leg: it was refused."""
    thresholds = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    heat = {"law": "eyring", "width": 0.03, "attempt_frequency": 1.0}
    given = {"contacts": {"thresholds": thresholds, "thermal": heat}, "verdict": RESET}
    kinetic, pages = list[float](), list[str]()
    for path in (
        {"velocity": 1e-3},
        {"velocity": 1e-3, "turns": [3.0, 1.0]},
        {"turns": [3.0, 3.0, 1.0], "times": [3e3, 4e3, 5e3]},
        {"velocity": 1e-2},
    ):
        _, page, found = judged(capsys, drive={"spring": 3.0} | path, **given)
        pages.append(page)
        kinetic.append(found["readings"][0]["kinetic"]["value"])
    assert kinetic[0] == kinetic[1] == kinetic[2] < kinetic[3]
    left = "not the path of drive.turns, which is left out: the drive goes one way, at 0.001"
    assert [left in page for page in pages] == [False, True, True, False]
    assert "the speed: none is given" not in pages[2]


def test_what_is_found_in_time_is_told(capsys: Any, monkeypatch: Any) -> None:
    """The time is over while other samples are looked at, or a slider is followed: K* and F_k are told all the same."""
    samples = np.random.default_rng(1).normal(1.0, 0.2, 40).tolist()
    tables = {"thresholds": {"kind": "from-samples", "x_s": samples}, "drive": {"spring": 0.5}}

    late = raising(TimeIsUp)
    monkeypatch.setattr(uncertainty, "of_resampled", late)
    _, page, found = judged(capsys, verdict=RESET, **tables)
    assert page.splitlines()[2].startswith("stick-slip") and "other samples" in page
    assert found["readings"][0]["kinetic"]["sampling"] is None
    monkeypatch.setattr(judge, "follow_contacts", late)
    status, page, found = judged(capsys, verdict=RESET, **tables)
    assert status == 1 and page.splitlines()[2] == f"not decided ({NO_TIME})"
    assert 0.4 < found["readings"][0]["kinetic"]["value"] < 0.7


GROWING = {
    "thermal": {"law": "soft", "temperature": 0.03, "attempt_frequency": 1e3},
    "strengthening": {"beta": 0.03, "time": 1.0},
}


@pytest.mark.parametrize(
    ("law", "known"),
    [({"kind": "identical", "value": 1.0}, True), slow(GAUSSIAN, False)],
    ids=["exact", "gaussian"],
)
def test_a_page_is_written_of_what_is_known_where_f_s_is_too_late(
    capsys: Any, monkeypatch: Any, law: Any, known: bool
) -> None:
    """K* is infinite as they break together, and F_s is what takes long."""

    monkeypatch.setattr(master, "propensity", raising(TimeIsUp))
    tables = {"thresholds": law, "drive": {"spring": 0.5}, "master": None, "wall_time": 1e4}
    status, page, found = judged(capsys, **tables)
    (reading,) = found["readings"]
    assert status == 1 and not found["success"] and Path("mine-output/verdict.png").exists()
    assert page.splitlines()[2] == f"not decided ({NO_FORCES})"
    assert reading["kinetic"]["value"] == pytest.approx(0.5 if known else 0.50125, rel=1e-4)
    assert reading["static"]["value"] is reading["critical_spring"]["value"] is None
    assert re.search(r"slips at least once below the spring K\* +not known", page)
    assert ("K* is infinite: all contacts break at one value, x = 1" in page) is known
    assert ("F_s of exact values may take a minute" in page) is known
    assert all(line.strip() for line in found["hangs_on"])


def test_what_takes_long_is_named_where_f_s_of_growing_thresholds_is_too_late(
    capsys: Any, monkeypatch: Any
) -> None:
    monkeypatch.setattr(master, "propensity", raising(TimeIsUp))
    contacts = {"thresholds": GAUSSIAN} | GROWING
    _, page, found = judged(capsys, contacts=contacts, drive={"velocity": 1.0})
    assert "grow and break by heat may take minutes: raise wall_time" in page
    assert "or run the scene with [eq], which needs neither" in page
    assert all(line.strip() for line in found["hangs_on"])


def test_without_time_a_slider_that_forgets_its_start_slides_at_the_kinetic_force() -> None:
    """Contacts that re-form at once: the master equation, given the time, ends at the same force."""
    told = follow(SOFT, WIDE, "instant", rigid(WIDE), wall_time=0.0)
    path = np.linspace(0.0, 6.0e4, 100)
    solved: Any = master.solve(WIDE, path, 1e-6, spring=1e-4, slip="instant")
    assert solved.regime.verdict == "decaying transient" and told.kind == "smooth"
    assert abs(told.after - solved.force[-1]) < told.error + solved.force_error
    assert "have forgotten their start" in told.message and told.success
    # of slips before the one from F_s, which were seen to shrink, "1 were seen, each drop 83% smaller" was told
    seen = replace(infinite("undecided", 4), shrinks_by=0.8, left=0.1, smaller=2, cut=True)
    over = after_forgetting(SOFT, WIDE, rigid(WIDE), replace(seen, rule="instant"))
    assert (over.slips, over.shrinks_by, over.left, over.smaller, over.cut) == (1, 0, 0, 0, False)
    # the trace drawn is that of the solver, but for small slips
    drawn = np.interp(path, told.drive, told.force)
    assert np.abs(drawn - solved.force).max() < 2e-3
    # exact thresholds keep their order, and a spring near K* has a short first slip
    exact = Contacts(mixture([identical(1.0), identical(1.5)], [0.5, 0.5]))
    near = replace(SOFT, spring=0.5)
    for machine, contacts in ((SOFT, exact), (near, WIDE)):
        other = follow(machine, contacts, "instant", rigid(WIDE), wall_time=0.0)
        assert other.kind == "undecided" and other.message == NO_TIME


def test_a_refused_slider_is_told_without_a_path_to_give_and_with_units(monkeypatch: Any) -> None:
    why = "contacts form too often in a slip that lasts some 2.3"

    end = "take eq_model.simulate, or end the path before 0.4"
    monkeypatch.setattr(master, "solve", raising(InputError(f"delay = 1: {why}; {end}")))
    heavy = replace(SOFT, mass=1.0, damping=0.1)
    found = follow(heavy, WIDE, "mass", RigidSlider(0.8, 0.5, 0.0, 3.0, 1.0), wall_time=10.0)
    assert found.kind == "undecided" and found.message == why
    metres = Scale(length_unit="m", time_unit="s")
    assert in_units(why, metres) == why + "0 s" and in_units(why, Scale()) == why
    assert in_units("cut at X_T = 4e-05, no more", metres) == "cut at X_T = 40.0 µm, no more"
    # the tolerance and the path are the verdict's own
    for given, shown in (
        (followed.SHORTEN, "it misses"),
        (followed.LOOSEN, "it misses"),
        (followed.LEAVE_HEAT, "it misses; leave out the heat"),
        (remedy_of([LegEnd(5.0, 0.2)], 1e-2, 1e-6), "it misses; leave out the heat"),
    ):
        assert in_units(f"it misses; {given}", Scale()) == shown
    beside = in_units(f"it misses; {followed.LOOSEN}; heat is left out beside a mass: so", metres)
    assert beside.startswith("it misses; heat is left out beside a mass: so; leave the temperature")


@pytest.mark.parametrize("rule", ["reset", "reform-after"])
def test_without_time_the_ensemble_tells_the_slips_far_below_the_critical_spring(rule: str) -> None:
    """The force before a slip is that of the master equation, late by N^(-2/3) at most."""
    told = follow(SOFT, WIDE, rule, rigid(WIDE), wall_time=0.0)
    solved: Any = master.solve(WIDE, np.linspace(0.0, 3e4, 100), 1e-6, spring=1e-4, slip=rule)
    assert told.kind == solved.regime.verdict == "stick-slip" and "by the ensemble" in told.message
    late = 1_000 ** (-2 / 3)  # a pilot of so few contacts will do
    assert abs(told.before - solved.slips.force_before[-1]) < 5.0 * told.error + late
    near = follow(replace(SOFT, spring=0.5), WIDE, rule, rigid(WIDE), wall_time=0.0)
    assert near.kind == "undecided"  # their number decides there


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["square", "hexagonal"])
def test_a_structure_of_ase_has_a_verdict(capsys: Any, kind: str) -> None:
    """A flake at all angles: P_c has many peaks, which the master equation follows too slowly; slips and the sliding
    force are told in newtons all the same, and F_s and F_k are those of single contacts on a rigid slider."""
    flake = origins.circular_island(2.88, radius=16.0)
    flake.set_cell([60.0, 60.0, 20.0])
    flake.write("POSCAR", format="vasp")
    period, energy = 2.46e-10, 3.2e-21 if kind == "square" else -3.2e-21
    island = {"kind": "file", "file": "POSCAR", "unit": "Å"}
    substrate = {"kind": kind, "amplitude": energy, "period": period}
    table = {"kind": "domains", "law": "equal", "stiffness": 32.0, "samples": 4000}
    table |= {"island": island, "substrate": substrate}
    contacts = {"thresholds": table}
    contacts["interface"] = {"mean_stiffness": 32.0, "contact_density": 1e13}
    drive = {"spring": "50 N/m", "area": 1e-7, "velocity": 1e-6}
    _, page, found = judged(capsys, contacts=contacts, drive=drive)
    own = found["readings"][0]
    kinds = {one["rule"]: one["kind"] for one in own["behaviours"]}
    assert kinds == {"reset": "stick-slip", "reform-after": "stick-slip", "instant": "smooth"}
    assert "N down to 0 N every" in page and "undecided" not in page
    law = Contacts(load_scene("mine.toml", solved=False).contacts.thresholds)
    top = 6.0 * law.mean_threshold
    path = np.append(np.linspace(0.0, top, 601), 40.0 * law.mean_threshold)
    forces = eq_model.simulate(law, path, n_contacts=200_000, n_replicas=2)
    error, together = forces.force_standard_error.max() * 32e6, 32e6
    assert (
        abs(own["static"]["value"] - forces.force.max() * together)
        < 5.0 * error + 2e-3 * law.mean_threshold * together
    )
    assert abs(own["kinetic"]["value"] - forces.force[-1] * together) < 5.0 * error
    for one in own["behaviours"][:2]:
        assert one["before"] == pytest.approx(own["static"]["value"], rel=0.02)
        assert one["period"] == pytest.approx(one["before"] / 50.0, rel=0.02)


@pytest.mark.slow  # quick: the structure of ASE above, and islands on the page
def test_slips_of_islands_are_those_of_the_barriers_and_not_of_their_smooth_law() -> None:
    """At listed angles barriers are exact values, and slips those of a slider on these. The smooth law through them has
    peaks with a width, and slips earlier."""
    angles = np.linspace(0.05, 1.5, 11)
    law = origins.domains(3.88, sizes=[(7, 7)], stiffness=1.0, samples=110, angles=angles)
    contacts = Contacts(law)
    values = np.sort(origins.triangular_barrier(3.88, 7, 7, angles)) / law.domains.period
    exact = Contacts(mixture([identical(float(x)) for x in values], np.full(11, 1.0 / 11.0)))
    way = np.linspace(0.0, 6e3, 50)
    own = eq_model.simulate(exact, way, spring=1e-4, slip="reset", n_contacts=20_000, seed=5)
    before = float(own.slips.force_before.mean())
    known = RigidSlider(0.35, 0.25, 1e-9, float("inf"), 1.0)
    assert of_smoothing(law)
    told = follow_contacts(SOFT, contacts, "reset", known, wall_time=1e4)
    finite = follow_finite(SOFT, with_barriers(contacts), 2e4, told, known.static, 1e3)
    smooth = follow_by_contacts(SOFT, contacts, "reset", 1e4, time.monotonic() + 1e4, known)
    for one in (told, finite):
        assert one.kind == "stick-slip" and one.before == pytest.approx(before, abs=2e-3)
    assert smooth.before < before - 8e-3
    assert told.contacts is not None
    # contacts that re-form at once are followed as before, as are laws that are no smooth ones through samples
    assert with_barriers(exact) is exact
    held = contacts.replace(thermal=origins.Thermal("soft", 1e-9, 1.0))
    assert follow_contacts(SOFT, held, "reset", known, wall_time=0.0).contacts is None


def test_contacts_of_the_area_break_by_heat_as_they_are_followed() -> None:
    """On a spring of 0.5 infinitely many slip from 0.6174 in this heat (docs/sliders.md), cold ones from 0.668."""
    warm = Contacts(gaussian(1.0, 0.2), thermal=origins.Thermal("soft", 0.02, 100.0))
    machine, slips = replace(SOFT, spring=0.5), replace(infinite("stick-slip", 5), before=0.6174)
    told = follow_finite(machine, warm, 2000, slips, 0.65, 1e4)
    assert told.kind == "stick-slip"
    assert told.before == pytest.approx(0.6174, abs=0.02 + 3.0 * told.before_error)
    assert told.before + 3.0 * told.before_error < 0.65
    left_out = follow_finite(machine, warm, 2000, replace(slips, heat_left_out=1e-3), 0.69, 1e4)
    assert left_out.before == pytest.approx(0.668, abs=0.02 + 3.0 * left_out.before_error)
    heavy = replace(machine, mass=1e-3, damping=0.05)
    held = warm.replace(delay=Delay(0.3))
    told = follow_finite(heavy, held, 2000, replace(slips, rule="mass"), 0.65, 1e4)
    assert told.kind == "stick-slip" and told.before + 3.0 * told.before_error < 0.65
    ageing = Contacts(gaussian(1.0, 0.2), ageing=origins.Ageing(gaussian(1.0, 0.2), rate=1e-3))
    for asked, rule in ((heavy, "mass"), (machine, "reset")):
        told = follow_finite(asked, ageing, 2000, replace(slips, rule=rule), 0.65, 1e4)
        assert told.kind == "unknown" and "contacts that age are not followed" in told.message


def test_contacts_of_a_slider_that_creeps_in_heat_are_not_followed_on_a_soft_spring(
    monkeypatch: Any,
) -> None:
    """300 of them break 25,000 times each while the spring of a machine is loaded; the rates at rest let expect 6."""
    eyring = origins.Thermal("eyring", width=0.03, attempt_frequency=1e10)
    machine, warm = replace(SOFT, spring=2e-6), Contacts(WIDE.thresholds, thermal=eyring)
    creeps = replace(infinite("smooth", 0), before=0.32, after=0.32)
    for rule in ("reset", "instant"):
        told = follow_finite(machine, warm, 1e5, replace(creeps, rule=rule), 0.3206, seconds=5.0)
        assert told.kind == "unknown" and "breaks are more than are followed" in told.message
    # their pilot is given up, too, where the time is over: each of its sliders takes more than 10 ms. By the law of
    # rates whose kernel other tests compile, too: that of another takes half a minute
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.SHORT", 0.01)
    warm = warm.replace(thermal=origins.Thermal("soft", 0.03, 1e10))
    with pytest.raises(InputError, match="1,000 contacts take more than 0 s: raise wall_time"):
        sliders(machine, warm, "reset", np.array([0.0, 1.3e5]), 10_000, seconds=0.0)


def test_many_barriers_have_their_own_quantiles() -> None:
    """In bins of twenty, on which the cdf is straight."""
    x_s = np.sort(stats.arcsine(0.5, 1.0).rvs(4000, random_state=1))
    law = origins.from_samples(x_s)
    law.domains = SimpleNamespace(angles=np.arange(3.0) / 7.0)
    found = with_barriers(Contacts(law)).thresholds
    q = np.linspace(0.0, 1.0, 81)
    assert found.ppf(q) == pytest.approx(np.quantile(x_s, q), abs=2e-3)
    assert found.mean() == pytest.approx(x_s.mean(), rel=1e-4)
    assert found.moment(2) == pytest.approx(np.mean(x_s**2), rel=2e-4)


@pytest.mark.slow  # quick: two peaks, in the shipped scene of test_run.py
def test_the_ensembles_slips_of_a_narrow_peak_between_those_of_all_are_no_slips() -> None:
    """Two contacts in five break together at 0.05, and the spring hardly shortens: the slips that are told are those of
    all contacts, with the master equation's force, and a period that the spring needs for it."""
    law = Contacts(mixture([gaussian(0.05, 0.002), gaussian(1.0, 0.05)], [0.4, 0.6]))
    soft = replace(SOFT, spring=0.01)
    solved: Any = master.solve(law, [0.0, 88.0], 1e-6, spring=0.01, slip="reform-after")
    (exact,) = solved.slips.force_before[solved.slips.main]
    known = RigidSlider(exact, 0.487, 1e-9, 5.37, 1.0)
    told = follow(soft, law, "reform-after", known, wall_time=0.0)
    finite = follow_finite(soft, law, 2e4, told, exact, seconds=1e3)
    assert told.kind == finite.kind == "stick-slip" and told.slips == 6
    for one in (told, finite):
        assert one.before == pytest.approx(exact, abs=0.02) and one.after == 0.0
        assert one.period == pytest.approx(one.before / 0.01 + one.before, rel=0.02)


def test_the_period_of_sliders_is_a_mean_as_their_force_is() -> None:
    """A reset leaves no force, and the spring regains that of the next slip over the period, but for K <x_s>: one gap
    of one slider differs from the mean by 1 % of few contacts, which an error of the mean did not hold."""
    known = replace(rigid(WIDE), contacts=500)
    told = follow(SOFT, WIDE, "reset", known, wall_time=0.0)
    assert told.period is not None and told.contacts == 500
    assert 1e-4 * told.period == pytest.approx(told.before, abs=2e-4)


def test_contacts_that_stand_for_infinitely_many_are_told_of_once(
    capsys: Any, monkeypatch: Any
) -> None:
    """All contacts of the area tell the slips where the master equation does not: one force, one period, one line."""

    monkeypatch.setattr(master, "solve", raising(InputError("path: not in time")))
    drive = {"spring": "10 N/m", "area": 4e-9, "velocity": 1e-6}
    verdict = {"rules": ["reset", "reform-after"]}
    _, page, found = judged(capsys, contacts=STATED, drive=drive, verdict=verdict)
    for one, many in zip(found["readings"][0]["behaviours"], found["finite"], strict=True):
        assert many["contacts"] == one["contacts"] == 2_000
        assert many["before"] == one["before"] and many["period"] == one["period"]
    assert "for infinitely many)" not in page and "not looked at" not in page
    assert page.count("the slips are means by the ensemble, 4 sliders of 2,000 contacts") == 1
    (told,) = re.findall(r"forces of the slider \((.*)\): a standard error of .*, between", page)
    assert told == "reset, reform-after"


def test_contacts_that_stand_for_more_are_no_contradiction() -> None:
    """Where fewer contacts tell the slips, the page does not say that their number was not looked at."""
    few = replace(infinite("stick-slip", 6), period=8e3, contacts=1_000, message="by 1,000")
    late = Finite("reset", 9_000, "unknown", message="no time")
    text = text_of(verdict_on(reading(few), finite=(late,)))
    told = "1,000 contacts stand for the 9,000 of the area if a slip renews all contacts: no time"
    assert told in text and "not looked at" not in text


def test_more_contacts_give_the_numbers_of_fewer_sliders() -> None:
    """A thousand contacts slip too early by some N^(-2/3), and their claim covers it; 50,000 are nearer."""
    few = follow(SOFT, WIDE, "reset", rigid(WIDE), wall_time=0.0)
    few = replace(few, contacts=1_000)
    finite = follow_finite(SOFT, WIDE, 5e4, few, rigid(WIDE).static, seconds=1e3)
    told = with_more(few, finite, WIDE.mean_threshold)
    solved: Any = master.solve(WIDE, np.linspace(0.0, 3e4, 100), 1e-6, spring=1e-4, slip="reset")
    exact = solved.slips.force_before[-1]
    assert told.contacts == 50_000 and told.error < few.error
    assert abs(told.before - exact) < 5.0 * told.error + 50_000 ** (-2 / 3)
    assert told.period == pytest.approx(solved.period, rel=0.01)
    assert abs(few.before - exact) < few.error + 5e-3


def test_a_slider_cut_after_a_slip_tells_of_it(capsys: Any, monkeypatch: Any) -> None:
    """The slip that was seen is told with its forces, and positions in metres."""
    solve = master.solve

    def cut(contacts: Any, path: Any, *arguments: Any, **named: Any) -> Any:
        found = solve(contacts, path[: path.size // 4], *arguments, **named)
        why = "stopped at X_T = 4.5e-09"
        undecided = replace(found.regime, verdict="undecided")
        return replace(found, regime=undecided, success=False, message=why)

    monkeypatch.setattr(master, "solve", cut)
    drive = {"spring": "0.5 N_c<k>", "velocity": 1e-6}
    status, page, found = judged(capsys, contacts=STATED, drive=drive, verdict=RESET)
    (one,) = found["readings"][0]["behaviours"]
    assert status == 1 and one["kind"] == "undecided" and one["slips"] >= 1
    assert "whether it goes on is not known" in page and "X_T = 4.50 nm" in page
    before = one["before"]
    static = found["readings"][0]["static"]["value"]
    assert one["after"] < before < one["peak"] < static < 1.02 * one["peak"]  # beside points
    told = f"from {guarded(before, 'Pa', 1e-9)}, past a peak of 6.8 kPa, down to"
    assert told in page, static
    assert "force before a slip (reset: path cut)" in page


def test_slips_that_were_seen_are_told_beside_what_was_not_followed() -> None:
    """A mass that no solver takes comes first, and what was seen without it is told all the same."""
    seen = replace(infinite("undecided", 16), before=0.2, after=0.0, message="cut", success=False)
    refused = replace(not_followed("mass", "no such slider"), before=float("nan"))
    found = verdict_on(reading(refused, seen))
    said, text = sentence(found), text_of(found)
    assert said.startswith("not decided (no such slider) if mass, damping and delay decide; ")
    assert (
        "16 slips were seen, the last from 0.2" in said and "if a slip renews all contacts" in said
    )
    assert "and whether it goes on is not known" in said
    assert "force before a slip (reset: not decided)" in text
    assert re.search(r"^slips \(mass\) +not known$", text, re.M)


@pytest.mark.parametrize("error", [float("inf"), 0.2])
def test_no_figure_is_told_of_a_force_that_is_not_known(
    capsys: Any, monkeypatch: Any, error: float
) -> None:
    """Slips of steps too coarse to tell them have no place on the page and in the files of a verdict."""
    solve = master.solve

    def rough(*arguments: Any, **named: Any) -> Any:
        found = solve(*arguments, **named)
        undecided = replace(found.regime, verdict="undecided")
        why = "neither force nor slips are known: too many steps"
        return replace(found, regime=undecided, success=False, force_error=error, message=why)

    monkeypatch.setattr(master, "solve", rough)
    drive = MACHINE | {"spring": "0.5 N_c<k>"}
    del drive["area"]  # else all of its contacts are followed
    _, page, found = judged(capsys, contacts=STATED, drive=drive, verdict=RESET)
    (one,) = found["readings"][0]["behaviours"]
    assert one["kind"] == "undecided" and not one["slips"]
    assert one["before"] is one["after"] is one["period"] is None
    assert re.search(r"^slips \(reset\) +not known$", page, re.M)
    assert "force before" not in page and "period" not in page
    assert "not decided (neither force nor slips are known" in page
    assert len(Path("mine-output/friction.csv").read_text().splitlines()) == 1


def test_readings_that_are_not_decided_stand_in_the_headline_and_their_errors_in_the_bound() -> (
    None
):
    """One reading of three is decided: the sentence is its own, and says so; F_k of all is known all the same."""
    sure, vague = answers.Quantity(2.0, 1e-6), answers.Quantity(10.0, 6.0)

    def answer(
        name: str, kinetic: float, spring: answers.Quantity, one: Behaviour
    ) -> answers.Answer:
        return reading(one, kinetic=answers.Quantity(kinetic, 1e-6), spring=spring, name=name)

    smooth, late = replace(infinite("smooth", 0), error=1e-9), not_followed("reset", NO_TIME)
    others = answer("b", 0.4, vague, late), answer("c", 0.5, sure, late)
    found = verdict_on(answer("own", 0.9, sure, smooth), *others)
    said, text = sentence(found), text_of(found)
    assert said.startswith("smooth at 0.5") and said.count("\n") == 0
    assert "so say own; the other 2 are not decided in time; F_k of all 3 is 0.4" in said
    assert " to 0.9" in said and text.count(said) == 1 and "not decided: b, c: out of time" in text
    # the bound below the table is of the own reading's numbers; what is worse in a range is named
    assert "  F_k, F_s and K*: at most 1e-06\n" in text
    assert "  K* of b, which is in the range: 6e-01, 10 ± 6 N_c<k>\n" in text
    assert "K* of c" not in text
    agreed = replace(found, answers=(found.own, answer("c", 0.5, sure, smooth)))
    assert "not decided" not in text_of(agreed) and "this is of" not in sentence(agreed)


def test_a_critical_spring_below_its_error_is_not_told() -> None:
    """Neither of the scene's own reading nor of another one, whose value is then in no range."""
    smooth = replace(infinite("smooth", 0), error=1e-9)
    sure, vague = answers.Quantity(2.0, 1e-6), answers.Quantity(7.0, 9.0)

    def told(machine: Machine | None, *springs: answers.Quantity) -> tuple[str, answers.Verdict]:
        given: Any = {"machine": machine, "kinetic": 0.5}
        found = verdict_on(
            *(
                reading(*[smooth] * bool(machine), spring=spring, name=f"r{number}", **given)
                for number, spring in enumerate(springs)
            )
        )
        return text_of(found), found

    for machine in (SOFT, None):
        text, found = told(machine, vague, sure)
        assert re.search(r"^slips at least once below the spring K\* +not known$", text, re.M)
        assert "  K*: not known, as it is as large as the number\n" in text
        assert not found.success and "7.0" not in text and "K is below K*" not in text
        assert ("K*, which is not known" in text) == (machine is None)
        text, found = told(machine, sure, vague, answers.Quantity(3.0, 1e-6))
        assert "  K* of r1: not known, as it is as large as the number\n" in text
        assert "2.0 N_c<k> to 3.0 N_c<k>" in text and "over 2 readings" in text
        assert found.success and "7.0" not in text
        (springs,) = (one for one in draw_verdict(found).axes if one.get_label() == "springs")
        assert [one.get_text() for one in springs.texts] == ["not known"]
        infinity = answers.Quantity(float("inf"), float("inf"))
        assert re.search(r"below the spring K\* +infinite", told(machine, infinity)[0])


def test_forces_under_two_rules_are_told_each_with_its_own_error() -> None:
    """Of 0.04 of a unit of force one half may be known under one rule, and 1.5 to a thousandth under the other."""
    early = replace(infinite("stick-slip", 9), before=0.04, after=0.0, period=None, error=0.02)
    full = replace(early, rule="reform-after", before=1.5, error=2e-3, period=15_123.4)
    text = text_of(verdict_on(reading(early, full, kinetic=2.0)))
    assert (
        "stick-slip: 0.040 ± 0.020 N_c<k>·length down to 0 N_c<k>·length if a slip renews" in text
    )
    assert "stick-slip: 1.500 ± 0.002 N_c<k>·length down to 0" in text
    assert re.search(r"^force before a slip \(reset\) +0.040 ± 0.020 N_c<k>·length$", text, re.M)
    told = r"^force before a slip \(reform-after\) +1.500 ± 0.002 N_c<k>·length$"
    assert re.search(told, text, re.M)
    assert re.search(
        r"^period \(reform-after\) +15,120 units of length, 15,120 units of time$", text, re.M
    )
    assert "forces of the slider (reset): at most 5e-01\n" in text


def test_a_reading_decided_under_some_slip_rules_alone_is_named() -> None:
    smooth, late = replace(infinite("smooth", 0), error=1e-9), not_followed("instant", NO_TIME)
    at_once = replace(smooth, rule="instant")
    both = tuple(
        reading(smooth, other, kinetic=2.0, name=name)
        for name, other in (("own", at_once), ("b", at_once), ("c", late))
    )
    for each in (both, both[:2]):
        text = text_of(verdict_on(*each))
        told = "decided under some slip rules, and not under others: c"
        assert (told in text) == (len(each) == 3)


@pytest.mark.parametrize(
    ("drive", "delay", "told", "not_told"),
    [
        ({}, 0.0, "give drive.mass, drive.damping and [contacts.delay]", "without the mass"),
        ({}, 9.0, "give drive.mass and drive.damping", "[contacts.delay]"),
        ({"mass": 1.0, "damping": 0.1}, 0.0, "not followed; give [contacts.delay]", "give drive"),
        ({"mass": 1.0, "damping": 0.1}, 9.0, "the slider with it, which would decide", "give "),
    ],
)
def test_what_is_given_is_not_asked_for(
    drive: dict[str, float], delay: float, told: str, not_told: str
) -> None:
    rules = [infinite("stick-slip", 5), replace(infinite("smooth", 0), rule="instant")]
    if drive:
        rules = [not_followed("mass", NO_TIME), *rules]
    contacts = WIDE.replace(delay=Delay(delay) if delay else None)
    text = page(verdict_on(reading(*rules, contacts=contacts, machine=replace(SOFT, **drive))))
    (line,) = (one for one in text if one.startswith("  the slip rule: "))
    assert told in line and not_told not in line and "undecided" not in "\n".join(text)


@pytest.mark.slow  # quick: the rules of contacts that wait, in test_verdict_mass.py
def test_with_a_delay_no_contact_is_said_to_re_form_at_once(capsys: Any) -> None:
    """Those that break in a slip wait: "instant" is "reform-after", and is not solved twice."""
    contacts = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}, "delay": {"time": 0.3}}
    rules = {"rules": ["reform-after", "instant"]}
    _, page, found = judged(capsys, contacts=contacts, drive={"spring": 3.0}, verdict=rules)
    assert [one["rule"] for one in found["readings"][0]["behaviours"]] == ["reform-after"]
    assert "at once" not in page and "instant" not in page


@pytest.mark.slow  # quick: the friction of contacts that do not wait, in test_verdict_mass.py
def test_a_short_delay_is_told_beside_contacts_without_one(capsys: Any, monkeypatch: Any) -> None:
    """A slider without mass slips in no time, beside which every delay is long; one of a delay far below a slip's own
    <x_s>/V, and so short that sliding is stable, acts as if contacts had none, which the page has, too."""
    solve = master.solve

    def refused(*arguments: Any, **named: Any) -> Any:
        if named.get("mass"):
            raise InputError("mass: contacts break and form too often")
        return solve(*arguments, **named)

    monkeypatch.setattr(master, "solve", refused)
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.CONTACTS", 5000)
    monkeypatch.setattr("toolkit.verdict.sliders.follow.few_are_followed", lambda *_: False)
    drive = {"spring": 0.01, "mass": 1e-4, "damping": 1e-4}
    contacts = {
        "thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.3},
        "delay": {"time": 1e-6},
    }
    _, page, found = judged(capsys, contacts=contacts, drive=drive)
    own = found["readings"][0]
    kinds = {one["rule"]: one["kind"] for one in own["behaviours"]}
    assert kinds["reform-after"] == "stick-slip" and kinds["instant"] == "smooth"
    # M X'' + γ X' + K X = 0, a twentieth of critical damping
    time = np.linspace(0.0, 0.5, 500_001)
    decay, frequency = 0.5, np.sqrt(100.0 - 0.25)
    speed = np.exp(-decay * time) * np.sin(frequency * time) * 100.0 / frequency
    mean, fastest = gaussian(1.0, 0.3).mean(), own["static"]["value"] / 0.01 * speed.max()
    # friction of contacts that wait falls with the speed by F_k τ/<x_s>: from γ<x_s>/F_k on by more than the damping
    unstable = 1e-4 * mean / own["kinetic"]["value"]
    assert unstable < mean / fastest
    lasts, reasons = f"{time[np.argmax(speed[1:] < 0.0)]:.3g} units of time", found["hangs_on"][0]
    assert f"; short is far below {unstable:.3g} units of time, long far above {lasts}, " in page
    assert f"a delay far below {unstable:.3g} units of time, above which friction" in reasons
    assert f"far above the {lasts} of a slip" in reasons


def test_a_smooth_slider_with_mass_and_no_delay_hangs_on_that() -> None:
    """Below K* contacts that re-form late would let it slip: none is given, so the first sentence says so."""
    own = replace(infinite("smooth", 0), rule="mass")
    for spring, delay, told in ((1e-4, 0.0, True), (2.0, 0.0, False), (1e-4, 3.0, False)):
        contacts = WIDE.replace(delay=Delay(delay) if delay else None)
        machine = replace(SOFT, spring=spring, mass=1.0)
        found = sentence(verdict_on(reading(own, contacts=contacts, machine=machine)))
        first = "if contacts form again at once, as no delay is given: " * told
        assert found.startswith(f"{first}smooth at 0.5")


def test_an_error_that_is_told_leaves_the_force_no_more_digits() -> None:
    own = replace(infinite("smooth", 0), before=0.5437, after=0.5437, error=0.01)
    found = sentence(verdict_on(reading(own, kinetic=0.5437)))
    assert found.startswith("smooth at 0.54 ± 0.01 N_c<k>·length")


def test_beside_an_error_of_what_still_swings_stands_the_force_that_it_swings_about() -> None:
    """F_k and γ v, 0.05 and 0.2 × 2: an error of 0.1 reaches below what the damping alone bears, and 0.45 is known."""
    own = replace(infinite("smooth", 1), rule="mass", error=0.1, before=0.47, after=0.47)
    machine = replace(SOFT, mass=1.0, damping=0.2, velocity=2.0)
    for rule, told in (("mass", True), ("instant", False)):
        one = reading(replace(own, rule=rule), machine=machine, kinetic=0.05)
        said = dependence(verdict_on(one, velocity=2.0))
        (line,) = (one for one in said if "is known less well than others" in one)
        share = "sliding that swings no more bears 0.450 N_c<k>·length, F_k and the damping's share"
        assert line.endswith(share) is told


@pytest.mark.parametrize("stiffness", ["independent", "linked"])
def test_linked_stiffness_is_what_a_verdict_hangs_on(stiffness: str, capsys: Any) -> None:
    """F_k is <x³>/(<x><x²>) times as large as with every k as <k>."""
    contacts = GAUSSIAN_CONTACTS | {"stiffness": stiffness}
    _, page, found = judged(capsys, contacts=contacts, drive={"spring": 5.0}, verdict=RESET)
    law = gaussian(1.0, 0.2)
    other = law.moment(2) / 2.0 / law.mean()
    factor = found["readings"][0]["kinetic"]["value"] / other
    line = f'the stiffness, "linked": with every k as <k> ("independent") F_k is 1/{factor:.3g} of this'
    assert (line in page) is (stiffness == "linked") is (factor > 1.05)


def test_an_error_that_hides_beside_the_force_before_a_slip_is_much_of_that_after_it() -> None:
    """Readings are 5 % apart, 13 of 256 mN: more than the error of 6.5 mN, which leaves two digits of 40.6 mN."""
    unit = 0.25 / 1e-3
    own = replace(infinite("stick-slip", 8), before=256.47 / unit, after=40.6 / unit)
    own = replace(own, error=6.5 / unit / WIDE.mean_threshold)
    scale = Scale(1e-3 * unit, "N", 1.0, "N/m", "m", "s")
    each = (reading(own, scale=scale, kinetic=value / unit) for value in (240.9, 253.0))
    found = sentence(verdict_on(*each))
    assert found.startswith("stick-slip: 256 mN down to 41 mN"), found


@pytest.mark.slow
def test_slips_of_islands_may_begin_far_below_their_static_force() -> None:
    """docs/islands.md: weak barriers, many at one value, let the slider slip before the strong ones bear F_s."""
    origins.circular_island(2.88, radius=10.0).write("flake.xyz")
    law = {"kind": "domains", "law": "equal", "stiffness": 32.0, "samples": 4000}
    law["island"] = {"kind": "file", "file": "flake.xyz", "unit": "Å"}
    law["substrate"] = {"kind": "hexagonal", "amplitude": -3.2e-21, "period": 2.46e-10}
    contacts = load_scene({"contacts": {"thresholds": law}}, solved=False).contacts
    barriers, mean = with_barriers(contacts), contacts.mean_threshold
    rigid: Any = eq_model.simulate(
        barriers, mean * np.linspace(0.0, 8.0, 161), n_contacts=20_000, n_replicas=2, seed=1
    )
    asked: dict[str, Any] = {"n_contacts": 20_000, "n_replicas": 2, "seed": 1, "spring": 1e-2}
    path = mean * np.linspace(0.0, 300.0, 50)
    renewed: Any = eq_model.simulate(barriers, path, slip="reset", **asked)
    climbing: Any = eq_model.simulate(barriers, path, slip="reform-after", **asked)
    static, top = rigid.force.max() / mean, rigid.path[rigid.force.argmax()] / mean
    assert static == pytest.approx(1.90, abs=0.02) and 5.0 < top < 6.5
    assert contacts.thresholds.sf(0.3 * mean) == pytest.approx(0.79, abs=0.02)
    assert contacts.thresholds.sf(0.5 * mean) == pytest.approx(0.44, abs=0.02)
    assert contacts.thresholds.sf(top * mean) < 0.1
    assert renewed.slips.force_before / mean == pytest.approx(0.34, abs=0.01)
    assert renewed.slips.force_after.max() < 1e-6 * mean
    own = climbing.slips.replica == 0
    before, after = (
        each[own][:7] / mean for each in (climbing.slips.force_before, climbing.slips.force_after)
    )
    assert before[:6] == pytest.approx([0.34, 0.54, 0.81, 1.08, 1.31, 1.52], abs=0.02)
    assert (after[:5] > 0.97 * before[:5]).all() and after[5] < 0.02 and before[6] < 0.35


def test_the_critical_spring_of_smoothed_islands_is_no_number(monkeypatch: Any) -> None:
    """No digits of it, and no point: it hangs on how samples are smoothed."""
    monkeypatch.setattr(answers, "of_smoothing", lambda law: True)
    force, spring = answers.Quantity(0.5, 1e-6), answers.Quantity(3.287, 0.1)
    for machine in (SOFT, None):
        rules = (infinite("smooth", 0),) if machine else ()
        answer = reading(*rules, machine=machine, kinetic=force, spring=spring)
        found = verdict_on(answer)
        text = text_of(found)
        assert "3.28" not in text + found._repr_html_() and "hangs on smoothing" in text
        assert ("K*, which is not known" in text) is (machine is None)
        assert "F_k and F_s: at most 2e-06\n" in text
        sampled = replace(answer, kinetic=answers.Quantity(0.5, 1e-6, sampling=0.012))
        html = replace(found, answers=(sampled,))._repr_html_()
        # not right behind the number, which has its own error there
        assert "F_k, by other samples</th><td>± 0.012" in html
        assert "length ± 0.012" not in html
        springs = draw_verdict(found).axes[-1]
        assert not springs.containers
        assert "hangs on the smoothing" in springs.texts[0].get_text()
        which = "F_s is that of the smooth law through the islands' barriers, and the force before a slip"
        for before in (0.49, 0.5, 0.51) if machine else ():
            slips = replace(infinite("stick-slip", 5), before=before, after=0.1)
            text = text_of(verdict_on(replace(answer, behaviours=(slips,))))
            assert (which in text) is (
                before != 0.5
            )  # where both stand beside each other, and differ
        assert "smoothing" in plain(found)["readings"][0]["critical_spring"]["hangs_on"]


def test_samples_that_the_program_draws_are_its_own_to_raise() -> None:
    """Of islands at all angles the page names the key, and not more samples of the user's."""
    law = origins.domains(3.88, mean_atoms=30.0, stiffness=1.0, samples=25)
    (note, *_), islands = of_samples(law), of_islands(law)
    assert "raise samples" in note and "take more samples" not in note
    assert of_smoothing(law) and "hangs on the smoothing" in islands[0]


def test_what_smoothing_adds_to_the_kinetic_force_stands_beside_the_error_of_the_samples() -> None:
    """<x> is kept, <x²> is not: told where it moves F_k by a tenth of the samples' own standard error or more."""
    x = stats.gamma(2.0).rvs(2000, random_state=np.random.default_rng(5))
    law = origins.from_samples(x)
    (note,) = (one for one in of_samples(law) if "smooth law" in one)
    others = np.random.default_rng(1).choice(x, (2000, x.size))
    own, each = ((one**2).sum(axis=-1) / (2.0 * one.sum(axis=-1)) for one in (x, others))
    said = re.match(r"F_k of the smooth law is (\S+)% (above|below) .* error is (\S+)%: ", note)
    off = 100.0 * (law.moment(2) / (2.0 * law.mean()) / own - 1.0)
    assert said is not None and (said[2] == "above") == (off > 0.0)
    assert float(said[1]) == pytest.approx(abs(off), abs=0.006)
    assert float(said[3]) == pytest.approx(100.0 * each.std() / own, rel=0.1)
    even = origins.from_samples(np.linspace(0.5, 1.5, 100))
    assert not any("smooth law" in one for one in of_samples(even))


def with_contacts(own: Behaviour, finite: Finite, *others: float) -> answers.Verdict:
    """The verdict on a slider of 300 contacts on its area; other readings have these F_k beside one of 1."""
    scale = replace(scale_of(WIDE, None), contacts=300.0, force_unit="N", spring_unit="N/m")
    each = (
        reading(own, scale=scale, kinetic=answers.Quantity(kinetic, 0.0), name=f"r{kinetic:g}")
        for kinetic in (1.0, *others)
    )
    return verdict_on(*each, finite=(finite,))


def test_the_areas_own_contacts_stand_in_the_headline_and_in_the_table() -> None:
    """Where their slips are from another force than those of infinitely many; these follow in brackets."""
    own = infinite("stick-slip", 5)
    for before, told in ((0.7, True), (0.7999, False)):
        finite = Finite(own.rule, 300, "stick-slip", before, 1e-3, 0.0, 0.0, 5.0, period=70.0)
        found = with_contacts(own, finite)
        said, text = sentence(found), text_of(found)
        first = "stick-slip: 700 ± 1 mN down to 0 N every 70.0 units of length, 70.0 units of time at 1.00 "
        first += "with the 300 contacts of the area (800 mN down to 500 mN for infinitely many)"
        assert said == (first if told else "stick-slip: 800 mN down to 500 mN")
        if told:  # a mean that is known no better than itself has its error, on the page, too
            found = with_contacts(own, replace(finite, period_error=69.0))
            assert "every 70 ± 69 units of length, 70 ± 69 units of time at" in sentence(found)
            assert "70 ± 69 units of length, 70 ± 69 units of time" in text_of(found)
        rows = dict(re.split(" {2,}", line)[:2] for line in text.splitlines() if "(reset)" in line)
        assert (rows.get("slips of 300 contacts, from (reset)") == "700 ± 1 mN down to 0 N") is told
        assert (
            rows.get("period of 300 contacts (reset)") == "70.0 units of length, 70.0 units of time"
        ) is told
        # what stands in brackets is told once
        assert ("force before a slip (reset)" in rows) is not told
        assert not any("infinitely many" in name for name in rows if name.startswith("force"))


def test_the_areas_own_contacts_stand_in_the_headline_where_they_are_known_far_better() -> None:
    """Of infinitely many 0.8 ± 0.05, of the area's 0.79 ± 0.001; not where heat is left out, of both of them."""
    own = replace(infinite("stick-slip", 5), error=0.05)
    for error, heat, told in ((1e-3, None, True), (0.02, None, False), (1e-3, 0.05, False)):
        finite = Finite(own.rule, 300, "stick-slip", 0.79, error, 0.0, 0.0, 5.0, period=70.0)
        said = sentence(with_contacts(replace(own, heat_left_out=heat), finite))
        alone = "stick-slip: 800 ± 50 mN down to "
        assert said.startswith("stick-slip: 790 ± 1 mN down to 0 N" if told else alone), said
        assert ("(800 ± 50 mN down to 500 mN for infinitely many)" in said) is told, said


def test_the_scatter_of_the_areas_contacts_is_told_as_scatter_and_not_as_an_error() -> None:
    """Beside a mean that is that of infinitely many, too; where slips are of several kinds by the range of their falls,
    and where they are alike by a standard deviation."""
    whose, slides = "with the 300 contacts of the area", replace(infinite("smooth", 0), after=1.0)
    finite = Finite("reset", 300, "smooth", late=1.001, late_error=2e-3, fluctuation=0.035)
    found = with_contacts(slides, finite)
    told = "1.001 ± 0.002 N, fluctuating by ± 0.035 N"
    assert sentence(found) == f"smooth at {told}, {whose} (1.00 N for infinitely many)"
    assert re.search(rf"sliding force of 300 contacts \(reset\) +{told}", text_of(found))
    assert plain(found)["finite"][0]["fluctuation"] == pytest.approx(0.035)
    found = with_contacts(slides, replace(finite, fluctuation=5e-3))
    assert "fluctuating" not in text_of(found)
    before, period = spread_of(np.array([0.68, 0.7, 0.72])), spread_of(np.linspace(60.0, 80.0, 9))
    slips = Finite("reset", 300, "stick-slip", 0.7, 1e-3, 0.0, 0.0, 5.0, period=70.0)
    slips = replace(slips, befores=before, drops=before, periods=period)
    for drops, after, fall in (
        (before, 0.0, "down to 0 N"),
        (spread_of(np.array([0.316, 0.324, 0.332])), 0.376, "down by 324.0 mN (scatter ± 8.0 mN)"),
        (spread_of(np.array([0.1, 0.2, 0.6])), 0.4, "down by 300 mN (100 mN to 600 mN)"),
        (spread_of(np.array(4 * [0.1] + 4 * [0.5])), 0.4, "down by 300 mN (half of them "),
    ):
        found = with_contacts(slides, replace(slips, drops=drops, after=after))
        begin = f"stick-slip: 700 ± 1 mN (scatter ± 20 mN) {fall}"
        text = text_of(found)
        # in the line below the headline, the table, and of what it hangs on in the file
        text += "\n".join(plain(found)["hangs_on"])
        assert text.count(begin) == 1 and text.count(begin.partition(": ")[2]) == 3
        assert (
            "every 70.0 units of length (scatter ± 6.8 units of length), 70.0 units of time at 1.00 with the 300"
            in text
        )
        assert plain(found)["finite"][0]["befores"]["std"] == pytest.approx(0.02)


def test_the_areas_own_contacts_slide_at_their_own_force_in_the_headline() -> None:
    """No more than the errors of both apart it is that of infinitely many; what rises on is said to."""
    own = replace(infinite("smooth", 0), rule="instant", before=1.0, after=1.0)
    finite = Finite("instant", 300, "smooth", late=1.043, late_error=2e-3)
    for late, error, rises, told in (
        (1.043, 0.0, False, "smooth at 1.043 ± 0.002 N with"),
        (1.043, 0.0, True, "smooth, at 1.043 ± 0.002 N and still rising with"),
        (1.043, 0.06, False, ""),
        (1.009, 0.0, False, ""),
    ):
        known = replace(own, error=error)
        found = with_contacts(known, replace(finite, late=late, rises=rises))
        text = text_of(found)
        rest = " the 300 contacts of the area (1.00 N for infinitely many)"
        assert sentence(found) == (
            told + rest if told else sentence(with_contacts(known, replace(finite, late=1.0)))
        )
        assert ("sliding force of 300 contacts (instant)  1.043 ± 0.002 N" in text) is bool(told)
    # of fewer contacts than there are nobody is told that the area's bear so much
    fewer = with_contacts(own, replace(finite, message="as infinitely many do"))
    assert sentence(fewer) == "smooth at 1.00 N" and "sliding force" not in text_of(fewer)
    assert "at the end they bear 1.043 ± 0.002 N" in text_of(fewer)


def test_where_the_areas_contacts_slip_otherwise_by_the_rule_the_lines_below_tell_their_forces() -> (
    None
):
    """The headline has the forces of the rules only where they are the same."""
    one = infinite("smooth", 0)
    scale = replace(scale_of(WIDE, None), contacts=300.0, force_unit="N")
    number = answers.Quantity(1.0, 0.0)
    answer = reading(one, replace(one, rule="instant"), scale=scale, kinetic=number)
    slips = Finite("reset", 300, "stick-slip", 0.7, 1e-3, 0.0, 0.0, 5.0)
    begin, end = (
        "300 contacts stick and slip",
        "; disagree: infinitely many would slide smoothly at 500 mN",
    )
    for other, told in (
        (
            replace(slips, rule="instant"),
            f"{begin}, from 700 mN down to 0 N{end}",
        ),
        (replace(slips, rule="instant", after=0.5), f"{begin}{end}"),
    ):
        found = verdict_on(answer, finite=(slips, other))
        assert sentence(found) == told
        assert "stick-slip: 700 ± 1 mN down to 0 N with the 300 contacts" in page(found)[3]


def test_readings_that_disagree_stand_in_a_headline_of_the_number_of_contacts() -> None:
    """Of the readings that say something else of infinitely many it told below alone."""
    slips = Finite("reset", 300, "stick-slip", 0.7, 1e-3, 0.0, 0.0, 5.0)
    found = with_contacts(infinite("smooth", 0), slips, 1.1, 1.2)
    begin, _, end = sentence(found).partition(
        "; disagree: infinitely many would slide smoothly at "
    )
    assert begin == "300 contacts stick and slip, from 700 mN down to 0 N" and ";" not in end
    *same, other = found.answers
    other = replace(other, behaviours=(infinite("stick-slip", 5),))
    found = replace(found, answers=(*same, other))
    assert sentence(found).endswith(f"{end}; stick-slip by 1 of 2 other readings")


def test_contacts_that_slip_now_and_then_are_told_so_wherever_they_are_told(
    monkeypatch: Any,
) -> None:
    """The sentence said "smooth", and the list and the picture "now and then"."""
    own = replace(infinite("smooth", 0), rule="instant", before=1.0, after=1.0)
    finite = Finite("instant", 300, "now and then", 1.1, 1e-3, 0.9, 1e-3, 0.25, fluctuation=0.02)
    finite = replace(finite, late=1.02, late_error=2e-3)
    finite = replace(finite, drive=np.array([0.0, 1.0]), force=np.array([0.0, 1.0]))
    found = with_contacts(own, finite)
    said = "slips now and then, at 1.020 ± 0.002 N, fluctuating by ± 0.020 N, with the 300 contacts of the area"
    (told, *_), text = page(found)[3:], text_of(found)
    assert told.strip() == f"{said} (smooth at 1.00 N for infinitely many)"
    assert "300 contacts, if contacts re-form at once: slips now and then, from 1.100 " in text
    assert "smooth at 1.02" not in text and text.count("now and then") == 3
    legend = draw_verdict(found).axes[0].get_legend()
    assert [one for one in legend.get_texts() if "at once: slips now and then" in one.get_text()]


def test_the_widest_uncertainty_stands_in_the_headline() -> None:
    """An error of one part in a hundred is told where readings agree better than that, else over what they reach."""
    own = replace(infinite("smooth", 0), before=1.0, after=1.0, error=0.01)
    finite = Finite("reset", 300, "smooth")
    assert sentence(with_contacts(own, finite)) == "smooth at 1.00 ± 0.01 N"
    assert sentence(with_contacts(own, finite, 0.995)) == "smooth at 1.00 ± 0.01 N"
    said = sentence(with_contacts(own, finite, 0.4, 1.2))
    assert said == "smooth at 1.00 N; F_k of the 3 readings is 400 mN to 1.20 N"
    found = with_contacts(own, finite)
    scattered = answers.Quantity(1.0, 0.0, 0.05)
    found = replace(found, answers=(replace(found.own, kinetic=scattered),))
    assert sentence(found) == "smooth at 1.00 N; other samples would change F_k by ± 0.050 N"


def test_with_a_delay_the_headline_ends_with_the_reach_of_the_force_before_a_slip() -> None:
    """F_k is that of a rigid slider as fast as the drive, which no slider that sticks reaches."""
    own = infinite("stick-slip", 5)
    found = with_contacts(own, Finite("reset", 300, "unknown"), 0.4, 1.2)
    late = found.own.contacts.replace(delay=Delay(9.0))
    forces = zip(found.answers, (0.8, 0.5, 0.9), strict=True)
    each = tuple(
        replace(one, contacts=late, behaviours=(replace(own, before=force),))
        for one, force in forces
    )
    said = sentence(replace(found, answers=each))
    told = "the force before a slip over all 3 readings is 500 mN to 900 mN"
    assert sentence(found).endswith("; F_k of the 3 readings is 400 mN to 1.20 N")
    assert said.endswith(f"; {told}")
    # another reading's slips under a rule that does not decide the own one are no reach of its force
    elsewhere = tuple(
        replace(one, behaviours=(replace(one.behaviours[0], rule="instant"),)) for one in each[1:]
    )
    assert "before a slip by" not in sentence(replace(found, answers=(each[0], *elsewhere)))
    title = draw_verdict(found).get_suptitle()
    without = "no friction trace is drawn, as no slider was followed"
    assert title == f"a\nstick-slip: 800 mN down to 500 mN\n{without}"


def test_what_the_verdict_hangs_on_is_sorted_by_how_much_it_changes(capsys: Any) -> None:
    """What turns the answer, how far the readings differ, the share of the load on contacts that would be plastic, what
    turns nothing; and most of the load on plastic contacts is a doubt before the answer."""
    soft = ROUGH | {"material": CONSTANTS | {"hardness": 5e7, "shear_strength": 5e7}}
    readings = {"readings": ["gw/amontons", "gw/strength"], "rules": ["reset", "instant"]}
    drive = MACHINE | {"spring": "50 N/m"}
    *_, found = judged(capsys, thresholds=soft, drive=drive, verdict=readings)
    surface = load_scene("mine.toml", solved=False).contacts.interface
    assert surface is not None
    caution = surface.plastic_caution
    assert f"{surface.plastic_load_fraction:.0%} of the load, would be plastic" in caution
    assert surface.plastic_load_fraction > surface.plastic_fraction
    starts = ("the slip rule: ", "threshold law, contact model", caution, "not the reading: ")
    places = [
        next(n for n, line in enumerate(found["hangs_on"]) if line.startswith(start))
        for start in starts
    ]
    assert places == sorted(places) and places[0] == 0
    assert found["do_not_trust"] == [
        f'do not trust this: {caution}: take regime = "mixed", or "plastic"'
    ]


def test_a_fall_that_is_none_is_no_disagreement() -> None:
    """Slips of finitely many contacts below 0.02 <x_s> do not contradict smooth sliding."""
    for fall, apart in ((0.001, False), (0.1, True)):
        finite = Finite("reset", 1000, "now and then", 0.6, 1e-3, 0.6 - fall, 1e-3, 1.2)
        said = verdict_on(reading(infinite("smooth", 1)), finite=(finite,))
        assert bool(disagreeing(said)) is apart


def test_a_fall_below_the_digits_of_the_forces_is_told_itself() -> None:
    """Not "from 0.2496 down to 0.2496"."""
    scale = Scale(force=1.0, force_unit="N", spring_unit="N/m", length_unit="m", time_unit="s")
    finite = Finite("instant", 1000, "now and then", 0.2496, 5e-4, 0.2496 - 1.2e-5, 5e-4, 0.75)
    assert fall_of(finite, scale) == "249.6 ± 0.5 mN down by 12 µN"
    finite = replace(finite, after=0.1)
    assert fall_of(finite, scale) == "249.6 ± 0.5 mN down to 100.0 ± 0.5 mN"


def test_doubts_about_the_input_stand_before_the_answer(capsys: Any) -> None:
    """A pressure of 1 Pa where 1 MPa is meant: before the sentence, in the file and in the picture's title."""
    tables = {"thresholds": ROUGH | {"pressure": 1.0}, "verdict": {"readings": ["gw/amontons"]}}
    _, page, found = judged(capsys, drive={"area": 1e-6}, **tables)
    said = [line for line in page.splitlines() if line.startswith("do not trust this: ")]
    assert found["do_not_trust"] == said and "pressure is 1 Pa: is the unit right?" in said[0]
    assert page.splitlines()[2] == said[0] and page.splitlines()[2 + len(said)] == found["verdict"]


def test_the_trace_says_that_it_swings_or_is_cut() -> None:
    """Below 0 the slider swings after a slip; and a path that is cut is no decision."""
    path = {"drive": np.array([0.0, 1.0]), "force": np.array([0.0, 1.0])}
    path["in_time"] = SlipsOfMass(slip_time=0.142)
    slips = replace(infinite("stick-slip", 5), rule="mass", after=-0.6, **path)
    cut = replace(infinite("undecided", 2), cut=True, **path)
    ringing = slips
    for own, told in (
        (slips, "stick-slip (below 0 the slider swings after a slip, 0.142 units of time long)"),
        (cut, "not decided, the path is cut"),
    ):
        found = told_of(own, None, WIDE)
        (label,) = draw_verdict(found).axes[0].get_legend_handles_labels()[1]
        assert label.endswith(f": {told}")
    # swings, each along 2π of the drive, that go on between points too far apart for them are no line
    for points, band in ((600, True), (2000, False)):
        drive = np.linspace(0.0, 1000.0, points)
        own = replace(ringing, drive=drive, force=0.3 + 0.1 * np.sin(drive))
        axes = draw_verdict(told_of(own, None, WIDE)).axes[0]
        assert bool(axes.collections) is band and bool(axes.get_lines()) is not band
        (label,) = axes.get_legend_handles_labels()[1]
        assert ("too many to be drawn" in label) is band
        if band:  # about the swings, 0.3 ± 0.1, and no wider
            low, high = axes.collections[0].get_datalim(axes.transData).intervaly
            assert 0.2 <= low < 0.201 and 0.399 < high <= 0.4


def test_other_readings_are_drawn_by_their_contact_model() -> None:
    """Many are grey, alike in dashes and marks where their model is, and counted in the legend."""
    own = told_of(replace(infinite("smooth", 0), rule="mass"), None, WIDE)
    names = ["gw/amontons", "gw/strength", "persson/amontons", "gw/paper", "gw/amontons/mixed"]
    each = [replace(own.own, name=f"{name}, step {n}") for n in (1, 2) for name in names]
    figure = draw_verdict(replace(own, answers=tuple(each)))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == [
        "gw/amontons, step 1",
        "gw: 5 other readings",
        "persson: 2 other readings",
        "gw, mixed: 2 other readings",
    ]
    # with the marks of their K*
    named = {line.get_marker() for line in figure.legends[0].get_lines()}
    assert {bar.lines[0].get_marker() for bar in figure.axes[-1].containers} == named
    assert figure.axes[-1].get_xlabel().startswith("balance unstable somewhere below")


def test_curves_that_lie_on_one_another_are_one_in_the_legend(capsys: Any) -> None:
    """Far below K* both rules that renew contacts after a slip give one trace; its error is told in newtons."""
    scene = write(
        contacts=STATED,
        drive=MACHINE | {"spring": "0.2 N/m", "area": 4e-9},
        verdict={"rules": ["reset", "reform-after"]},
        master=None,
    )
    found = judge.verdict(load_scene(scene, solved=False))
    (label,) = draw_verdict(found).axes[0].get_legend_handles_labels()[1]
    assert label == "a slip renews all contacts or contacts re-form after the slip: stick-slip"
    one, told = found.own.behaviours[0], plain(found)["readings"][0]["behaviours"][0]
    assert told["force_error"] == pytest.approx(one.error * 4e-9 * 5.0 * 5e11 * 4e-9, rel=1e-6)


def test_a_busy_machine_is_given_more_of_the_clock(monkeypatch: Any) -> None:
    """Half of the processor for one process: 60 s of its work are 120 of the clock, but not where these were given."""
    now = {"clock": 0.0, "work": 0.0}
    monkeypatch.setattr(os, "getloadavg", lambda: (1.0, 1.0, 1.0))
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(time, "monotonic", lambda: now["clock"])
    monkeypatch.setattr(time, "process_time", lambda: now["work"])
    shared, given = Budget(60.0, strict=False), Budget(60.0, strict=True)
    now |= {"clock": 40.0, "work": 20.0}
    assert shared.remaining() == pytest.approx(80.0, rel=0.05) and given.remaining() == 20.0
    assert shared.part(0.5).remaining() == pytest.approx(40.0, rel=0.05)
    now["work"] = 80.0  # several threads: the clock counts
    assert shared.remaining() == 20.0
    # before anything is known of the pace, two programs beside this one want the cores
    now |= {"clock": 0.0, "work": 0.0}
    monkeypatch.setattr(os, "getloadavg", lambda: (3.0, 1.0, 1.0))
    assert Budget(60.0, strict=False).remaining() == 120.0
    # the load of a hundred cores says little of the two that this process may use
    monkeypatch.setattr(os, "getloadavg", lambda: (99.0, 1.0, 1.0))
    assert Budget(60.0, strict=False).remaining() == 240.0


def test_one_reading_with_a_delay_gets_all_of_a_time_that_is_given(
    capsys: Any, monkeypatch: Any
) -> None:
    """It had a half, and the rest was left to contacts that are followed beside longer delays alone."""
    given = list[float]()

    def asked(table: Any, reading: Any, rules: Any, budget: Budget, rings: bool) -> Any:
        given.append(budget.remaining())
        raise InputError("enough")

    monkeypatch.setattr(judge, "answer_of", asked)
    for laws in ({"delay": {"time": 0.01}}, {}):
        contacts = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}} | laws
        drive = {"spring": 0.1, "velocity": 1.0, "mass": 0.1}
        said(capsys, "verdict", write(contacts=contacts, drive=drive, wall_time=1000.0))
    assert given[0] == pytest.approx(1000.0, rel=0.05)
    assert given[1] == pytest.approx(500.0, rel=0.05)


def test_a_mass_without_time_is_not_told_to_shorten_its_path() -> None:
    """The path is the verdict's own: more time is what the user can give."""
    machine = Machine(spring=1e-3, mass=1e-3, damping=1e-3, velocity=1.0)
    found = follow(machine, Contacts(gaussian(1.0, 0.3)), "mass", rigid(WIDE), 1e-3)
    assert "wall_time" in found.message and "raise" in found.message
    assert "path" not in found.message


def test_a_limit_of_time_leaves_no_module_half_imported(monkeypatch: Any) -> None:
    """numba that is cut as it is imported is broken for all that follows: the limit acts right after an import."""
    Path("slowly.py").write_text("import time\nfor _ in range(6):\n    time.sleep(0.05)\nend = 1\n")
    monkeypatch.syspath_prepend(".")
    with pytest.raises(TimeIsUp), no_longer_than(0.1):
        import slowly  # type: ignore[import-not-found]

        time.sleep(30.0)
    assert slowly.end == 1


@pytest.mark.parametrize("laws", [{}, {"delay": origins.Delay(3.0)}])
def test_a_heavy_slider_without_time_is_cut_and_no_error(laws: dict[str, Any]) -> None:
    contacts, path = Contacts(gaussian(1.0, 0.3), **laws), np.linspace(0.0, 3e3, 9)
    machine: dict[str, float] = {"spring": 1e-3, "mass": 1e-3, "damping": 1e-3}
    found: Any = master.solve(contacts, path, 1e-6, wall_time=1e-9, **machine)
    assert not found.success and "stopped by wall_time" in found.message


@pytest.mark.slow
def test_heat_that_does_nothing_leaves_the_ensemble_to_a_heavy_slider() -> None:
    """Barriers of 1e8 k_BT: where the master equation has no time, the ensemble follows the slider without heat, and
    its error holds the bound on what that changes."""
    heat = origins.Thermal("soft", temperature=1e-8, attempt_frequency=1.0)
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2), thermal=heat, delay=origins.Delay(20.0))
    machine = Machine(spring=1e-2, mass=1e-3, damping=1e-3, velocity=0.1)
    known = RigidSlider(
        static=0.7, kinetic=0.5, kinetic_error=1e-9, critical_spring=1.0, memory=1.0
    )
    found = follow(machine, contacts, "mass", known, 2.0)
    assert found.heat_left_out is not None and found.error >= found.heat_left_out
    assert found.kind == "stick-slip"


def told_of(behaviour: Behaviour, other: Behaviour | None, contacts: Contacts) -> answers.Verdict:
    """The verdict on a slider with mass on a spring far below K*, and what another delay would make it do."""
    given: Any = {
        "machine": replace(SOFT, mass=1e-4),
        "kinetic": 0.5,
        "static": 0.51,
        "spring": 1.0,
    }
    return verdict_on(reading(behaviour, contacts=contacts, **given), other=other)


def test_the_delay_that_would_turn_the_answer_stands_in_the_second_line() -> None:
    """A slider with mass whose contacts form again at once slides; the line is there only where the other is known."""
    smooth, slips = replace(infinite("smooth", 0), rule="mass"), infinite("stick-slip", 5)
    at_once, late = Contacts(gaussian(1.0, 0.3)), Contacts(gaussian(1.0, 0.3), delay=Delay(99.0))
    without = replace(smooth, rule="instant")
    for own, other, contacts, line in (
        (smooth, slips, at_once, "once a slip is over, which takes some 3.14 units of time, would"),
        (smooth, slips, at_once, "would make it stick-slip, as a slider without mass tells; give"),
        (replace(smooth, before=0.5), slips, late, "; leave [contacts.delay] out for the forces"),
        (smooth, replace(slips, rule="mass"), at_once, "again only after 9.42 units of time would"),
        (replace(slips, rule="mass"), without, late, "again at once would make it smooth at 0.5"),
        (smooth, smooth, at_once, ""),
        (smooth, None, at_once, ""),
        (smooth, not_followed("reform-after", NO_TIME), at_once, ""),
    ):
        lines = page(found := told_of(own, other, contacts))
        assert (line in lines[3]) if line else ("would make it" not in "\n".join(lines))
        # without a damping any delay lets it swing, which is told beside
        turns = [one for one in plain(found)["would_turn"] if "would make it" in one]
        assert bool(turns) is bool(line)
    found = told_of(smooth, smooth, at_once)
    damped = replace(found.own, machine=replace(SOFT, mass=1e-4, damping=1.0))
    assert "not the contacts' delay" in text_of(replace(found, answers=(damped,)))


@pytest.mark.parametrize(
    ("delay", "rule", "kind"), [(0.0, "reform-after", "stick-slip"), (50.0, "instant", "smooth")]
)
def test_the_other_delay_is_that_of_a_slider_without_mass(
    delay: float, rule: str, kind: str
) -> None:
    contacts = Contacts(gaussian(1.0, 0.3), delay=Delay(delay) if delay else None)
    found = follow_other_delay(replace(SOFT, spring=1e-2, mass=1e-4), contacts, None, 1e4)
    path = np.linspace(0.0, 500.0, 50)
    solved: Any = master.solve(WIDE, path, 1e-8, spring=1e-2, slip=rule)
    assert found.kind == kind and solved.regime.verdict in (kind, "decaying transient")
    force = solved.slips.force_before[-1] if kind == "stick-slip" else solved.force[-1]
    assert found.before == pytest.approx(force, abs=1e-5)


@pytest.mark.slow
def test_a_delay_that_outlasts_sliding_over_a_threshold_is_followed_with_the_mass() -> None:
    """Exponential contacts slide on every spring, under each slip rule; where they wait for three times <x_s>/v, those
    that slide hold a quarter of the force of those that stick, and the slider slips: no slip rule tells of that."""
    contacts, machine = Contacts(stats.expon()), Machine(1e-2, 1e-4, 1e-3, 1.0)
    assert follow_other_delay(machine, contacts, None, 60.0).kind == "smooth"
    delay = long_delay(machine, contacts.mean_threshold, 1.0)
    assert delay == 3.0
    found = follow_other_delay(machine, contacts, None, 60.0, delay)
    waiting = contacts.replace(delay=Delay(delay))
    own = eq_model.simulate(
        waiting, [0.0, 1e3], n_contacts=20_000, n_replicas=4, seed=5, **machine.keywords("mass")
    )
    assert (found.rule, found.kind) == ("mass", "stick-slip")
    for name, value in (("force_before", found.before), ("force_after", found.after)):
        assert value == pytest.approx(own.slips.mean(name, 3)[0], abs=0.05)


@pytest.mark.parametrize("kind", ["stick-slip", *(slow(one) for one in ("smooth", "undecided"))])
def test_that_no_delay_matters_is_told_only_where_a_long_one_was_followed(
    capsys: Any, monkeypatch: Any, kind: str
) -> None:
    """Where contacts that re-form after a slip slide, a delay far above a slip and <x_s>/v is followed, too."""
    contacts, asked = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.3}}, list[float]()
    drive = {"spring": 1.0, "mass": 1e-2, "damping": 0.1}
    late = replace(infinite(kind, 0), rule="mass")

    def followed(*given: Any) -> Behaviour:
        asked.append(given[4] if len(given) > 4 else 0.0)
        return late if asked[-1] else infinite("smooth", 0)

    monkeypatch.setattr("toolkit.verdict.with_mass.follow_other_delay", followed)
    _, text, _ = judged(capsys, contacts=contacts, drive=drive)
    turns = "contacts that form again only after 3 units of time would make it stick-slip"
    assert (turns in text) is (kind == "stick-slip")
    same = "the contacts' delay: with one of 3 units of time it is smooth, too" in text
    assert same is (kind == "smooth")
    assert ("the contacts' delay: none is given" in text) is (kind != "smooth")
    assert asked == [0.0, pytest.approx(3.0, rel=1e-3)]


@pytest.mark.parametrize("part", [0.0, 0.11, 0.999, 1.0, 1.001, 1.12, 5.0])
def test_a_damped_slip_takes_its_own_time_at_its_own_speed(part: float) -> None:
    """Against the motion M X'' + γ X' + K X = 0 itself, in steps: half a swing, or until it is as slow as the drive."""
    machine = Machine(spring=0.04, mass=0.01, damping=2.0 * part * 0.02, velocity=1e-5)
    own = told_of(replace(infinite("smooth", 0), rule="mass"), None, WIDE).own
    duration, fastest = kinds.a_slip(
        replace(own, machine=machine, static=answers.Quantity(0.3, 0.0))
    )
    at = np.linspace(0.0, 1.5 * duration, 200_001)
    matrix = np.array([[0.0, 1.0], [-4.0, -4.0 * part]])
    moves = linalg.expm(matrix * at[1])
    states = np.array([[-0.3 / 0.04], [0.0]])
    while states.shape[1] < at.size:
        states = np.hstack([states, moves @ states])
        moves = moves @ moves
    speed = states[1, : at.size]
    assert fastest == pytest.approx(speed.max(), rel=1e-6)
    later = np.argmax(speed)
    ends = at[later + np.argmax(speed[later:] < (0.0 if part < 1.0 else machine.velocity))]
    assert duration == pytest.approx(ends, rel=1e-4)


def test_of_k_star_0_by_few_samples_the_sentence_says_that_others_may_slip() -> None:
    """Where one standard error reaches from 0 to beyond the spring of the machine, and only there."""
    found = told_of(replace(infinite("smooth", 0), rule="mass"), None, WIDE)
    for spring, sampling, told in (
        (0.0, 1e-3, True),
        (0.0, 5e-5, False),
        (0.0, None, False),
        (2e-3, 1e-3, False),
    ):
        critical = answers.Quantity(spring, 1e-9, sampling)
        own = replace(found.own, critical_spring=critical)
        said = "; K* = 0.000 ± 0.001 N_c<k> by these samples: infinitely many contacts of other samples "
        said += "may slip on this spring"
        assert (said in sentence(replace(found, answers=(own,)))) is told


def test_below_the_critical_spring_smooth_sliding_has_its_reason_beside_the_table() -> None:
    """A fall of less than 0.02 <x_s> is no slip of a heavy slider; a slider that slipped has forgotten its start."""
    contacts, smooth = Contacts(gaussian(1.0, 0.3)), replace(infinite("smooth", 0), rule="mass")
    for behaviour, reason in (
        (smooth, "the fall from F_s to F_k, 0.0100 N_c<k>·length, is too small to count as a slip"),
        (replace(smooth, slips=1), "the slider slips once, and then no more"),
        (replace(smooth, slips=36), "the slider slips 36 times, and then no more"),
    ):
        lines = page(told_of(behaviour, None, contacts))
        at = next(n for n, line in enumerate(lines) if line.startswith("K is below K*, and yet"))
        assert reason in lines[at] and lines[at + 2].startswith("Numerical errors")
    none = Finite("mass", 500, "smooth")
    few = replace(told_of(replace(smooth, slips=1), None, contacts), finite=(none,))
    told = "a slider of infinitely many contacts slips once, and then no more, as contacts"
    assert told in text_of(few)
    once = told_of(replace(smooth, slips=1), None, contacts)
    waiting = replace(once.own, contacts=contacts.replace(delay=Delay(1e9)))
    heavy = replace(SOFT, mass=1.0)
    damped = replace(once.own, machine=replace(heavy, damping=1e9))
    for own, why in (
        (replace(waiting, machine=heavy), "as contacts wait on a longer way of the drive than"),
        (damped, "as the damping bears 1.00e+09 N_c<k>·length at the drive's speed"),
    ):
        assert f"and then no more, {why}" in text_of(replace(once, answers=(own,)))
    stiff = told_of(smooth, None, contacts)
    stiff = replace(stiff, answers=(replace(stiff.own, machine=replace(SOFT, spring=2.0)),))
    assert "and yet" not in text_of(stiff)


def test_a_slider_that_rings_at_the_end_of_its_path_is_not_called_smooth() -> None:
    """Without damping it rings on while contacts that form again break at once."""
    contacts, known = (
        Contacts(gaussian(1.0, 0.2), delay=Delay(300.0)),
        RigidSlider(0.75, 0.52, 1e-9, 1.0, 4.0),
    )
    for damping, kind in ((0.0, "undecided"), (1e-4, "stick-slip")):
        machine = Machine(spring=1e-3, mass=1e-3, damping=damping, velocity=1.0)
        found = follow_by_contacts(machine, contacts, "mass", 751.0, time.monotonic(), known)
        assert found.kind == kind and ("still ring" in found.message) is (kind == "undecided")


def test_the_commands_own_limit_of_time_is_named_as_such() -> None:
    own = load_scene(write(master=None), solved=False)
    for scene, words in (
        (own, r"own limit of time .* wall_time = 300 \(s\)"),
        (replace(own, wall_time=5.0), r"^wall_time = 5\.0: is over"),
    ):
        late = within(time.monotonic() - 1.0, scene, "this reading")
        with pytest.raises(InputError, match=words), late:
            time.sleep(1.0)


@pytest.mark.parametrize("damping", [10.0, *(slow(one) for one in (1.0, 60.0))])
def test_a_mass_is_followed_until_its_swing_has_died_away(damping: float) -> None:
    """Sliding at F_k the spring bears F_k + γv in the end; a path of a few loadings is shorter than one period."""
    contacts = Contacts(gaussian(1.0, 0.2))
    steady = master.steady_state(contacts, velocity=1.0)
    known = RigidSlider(0.75, steady.force, 1e-9, 1.0, 4.0)
    machine = Machine(spring=2.0, mass=50.0, damping=damping, velocity=1.0)
    found = follow(machine, contacts, "mass", known, 60.0)
    assert found.kind == "smooth" and found.error < 0.02
    assert found.before == pytest.approx(steady.force + damping, abs=found.error)


def test_a_mass_whose_slips_take_as_long_as_its_rests_is_not_told_by_a_slip_rule() -> None:
    contacts = Contacts(gaussian(1.0, 0.2))
    for mass, kind in ((1e-4, "stick-slip"), (50.0, "undecided")):
        machine = Machine(spring=0.3, mass=mass, damping=1.0, velocity=1.0)
        assert follow_other_delay(machine, contacts, None, 60.0).kind == kind
