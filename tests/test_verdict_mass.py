"""What a verdict says of a slider with mass whose contacts wait: its trace, the contacts that tell, the delay."""

import re
import time
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scipy import stats

import eq_model
import master
from master.soft.inertia.run import SlipsInTime
from origins import Contacts, Delay, InputError, Thermal, gaussian, strengthening
from tests.scenes import said, write
from tests.verdicts import reading, text_of, verdict_on
from toolkit.results.kinds import kind_of
from toolkit.scene.scale import scale_of
from toolkit.scene.scene import load_scene
from toolkit.verdict import answers, judge, with_mass
from toolkit.verdict.files import friction, plain
from toolkit.verdict.judge import verdict
from toolkit.verdict.of_area import with_more
from toolkit.verdict.picture import draw_verdict
from toolkit.verdict.readings import Reading
from toolkit.verdict.sliders import ensemble, ways
from toolkit.verdict.sliders.budget import NO_TIME, Budget, late, long_delay, may_follow
from toolkit.verdict.sliders.ensemble import (
    PILOT,
    follow_by_contacts,
    sliders,
)
from toolkit.verdict.sliders.finite import follow_finite
from toolkit.verdict.sliders.follow import follow
from toolkit.verdict.sliders.late import shrinking
from toolkit.verdict.sliders.machine import Machine, RigidSlider, half_a_swing, slip_duration
from toolkit.verdict.sliders.plans import Asked
from toolkit.verdict.sliders.records import Behaviour, Finite, not_followed
from toolkit.verdict.sliders.slips_in_time import SlipsOfMass
from toolkit.verdict.sliders.ways import lives_in_a_slip, loading_of
from toolkit.verdict.text import kinds, of_delay
from toolkit.verdict.text.above_static import why_above
from toolkit.verdict.text.hangs_on import dependence, on_the_page
from toolkit.verdict.text.spread import widest
from toolkit.verdict.text.table import in_units, table
from toolkit.verdict.text.words import page, sentence
from toolkit.verdict.with_mass import closely, follow_extremes, in_its_own_time

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")

WAITING = Contacts(gaussian(1.0, 0.3), delay=Delay(30.0))
STRONGER = Contacts(strengthening(gaussian(1.0, 0.3), beta=0.1, time=1.0))
# slips after 800 mean thresholds of its drive, and then after 650 each
HEAVY_ON_SOFT = Machine(1e-3, 1e-3, 6e-4, 1.0)


def of_a_mass(kind: str, before: float, **named: Any) -> Behaviour:
    """What infinitely many contacts do, the spring's force swinging to minus half of itself after a slip."""
    told: dict[str, Any] = {"error": 1e-6, "success": True, "message": "", "run_time": 0.0}
    after = before if kind == "smooth" else -0.5 * before
    return Behaviour("mass", kind, before, after, None, 3, **(told | named))


@pytest.mark.parametrize(
    ("heat", "few", "many"), [(None, 500_000, 600_000), (Thermal("soft", 0.01), 70_000, 75_000)]
)
def test_contacts_of_an_area_with_mass_are_followed_for_five_slips(
    heat: Thermal | None, few: int, many: int
) -> None:
    """For three where these are breaks of more than some seconds: 200 ns each, 2 µs in heat. A loading is the way to
    F_s, the stretch of the contacts, and the way while they are out. Contacts that form again in a slip break at each
    threshold that it passes, and are followed for three."""
    lasting = WAITING.replace(thermal=heat)
    for contacts, number, slips in (
        (lasting, few, 5.2),
        (lasting, many, 3.2),
        (WAITING.replace(delay=None), 1000, 3.2),
    ):
        asked = Asked(HEAVY_ON_SOFT, contacts, number, of_a_mass("stick-slip", 0.5), 0.5)
        loading = 0.5 / HEAVY_ON_SOFT.spring + contacts.mean_threshold + asked.waits
        assert asked.planned(number, 0.0, 0.0).end == pytest.approx(slips * loading)


def of(behaviour: Behaviour, turned: Behaviour | None = None) -> answers.Verdict:
    """A verdict of one reading of contacts that wait."""
    machine = Machine(1e-3, 1e-5, 0.01, 1.0)
    own = reading(behaviour, contacts=WAITING, machine=machine, kinetic=0.8)
    return verdict_on(own, other=turned)


def test_the_trace_of_a_mass_has_its_slips_in_time() -> None:
    """A slip lasts half a period of mass and spring, in which this drive goes on by a third of its way to the slip: the
    spring's force falls along it, and not at one place of the drive."""
    machine = Machine(spring=1e-2, mass=1.0, damping=0.02, velocity=1.0)
    contacts = WAITING.replace(delay=Delay(200.0))
    found = follow_by_contacts(
        machine, contacts, "mass", 80.0, 1e9, RigidSlider(0.8, 0.5, 0, 3, 500)
    )
    top, bottom = int(np.argmax(found.force)), int(np.argmin(found.force))
    assert found.force[bottom] < 0.0 < found.force[top]
    way = found.drive[bottom] - found.drive[top]
    assert way == pytest.approx(np.pi * (machine.mass or 0.0) ** 0.5 / 0.1, rel=0.1)
    # K (v - V), V the slider's speed, is how fast the force changes
    steepest = np.abs(np.diff(found.force)).max()
    assert steepest < 0.2 * np.ptp(found.force)


@pytest.mark.parametrize("contacts_told", [2000, slow(None)])
def test_a_slip_of_a_mass_is_shown_in_its_own_time(contacts_told: int | None) -> None:
    """While all contacts are out, mass and spring swing by themselves: damping takes the same share of each swing, and
    the picture has force and way of the slider; told by the master equation, and by the ensemble."""
    machine, slip = Machine(spring=1e-2, mass=1e-4, damping=2e-4, velocity=1.0), np.pi * 0.1
    contacts = Contacts(gaussian(1.0, 0.3), delay=Delay(5.0))
    begun = of_a_mass("stick-slip", 0.8, in_time=SlipsOfMass(slip, first_slip=79.0), run_time=1.0)
    begun = replace(begun, drive=np.array([0.0, 80.0]), force=np.array([0.0, 0.8]))
    # the first slip is looked for again where its place is not known well
    told = replace(begun, contacts=contacts_told)
    found = closely(told, machine, contacts, 1e9)
    time, way = in_its_own_time(found, machine)
    force = found.slip_force
    assert found.drive is told.drive and time[0] < 0.0 < time[-1] and time.size > 300
    swing = time[time > 1.5 * slip]
    last = swing[np.argmax(force[time > 1.5 * slip])] - time[np.argmin(force)]
    assert last == pytest.approx(slip, rel=0.03)
    first, second = force.min(), force[time > 1.5 * slip].max()
    ratio = machine.damping / (2.0 * np.sqrt(machine.mass or 0.0) * np.sqrt(machine.spring))
    assert -second / first == pytest.approx(np.exp(-np.pi * ratio), rel=0.05)
    np.testing.assert_allclose(way[-1], (force.max() - force[-1]) / 1e-2 + time[-1], rtol=1e-6)
    verdict_of = of(found)
    (panel,) = (one for one in draw_verdict(verdict_of).axes if one.get_label() == "slip")
    assert panel.lines[0].get_xdata().size == time.size
    rows = friction(verdict_of)
    assert rows["slip rule"].count("mass, its first slip") == time.size
    assert closely(told, machine, contacts, 0.0) is told


def test_contacts_that_wait_are_pulled_as_far_as_a_slider_that_sticks() -> None:
    """A slider that moves with its drive breaks its contacts one by one, to a force of 0.37 for exponential thresholds;
    one that sticks renews them, and its slips are 0.9/K apart: on three of the former's ways there is one slip."""
    machine = Machine(spring=1e-3, mass=1e-5, damping=1e-4, velocity=1.0)
    contacts = Contacts(stats.expon(), delay=Delay(30.0))
    told = of_a_mass("stick-slip", 0.85)
    found = follow_finite(machine, contacts, 2000.0, told, np.exp(-1.0), 1e3)
    assert found.kind == "stick-slip" and found.slips >= 2.0
    assert found.period is not None
    # what the spring regains over a period is less than the force before, by what it swings back
    assert 0.5 * found.before < machine.spring * found.period < 1.05 * found.before


def test_contacts_that_wait_for_a_moment_break_at_each_threshold_of_a_slip() -> None:
    """Slips of 1.3e5 mean thresholds, at each of which all contacts break, as they wait for far less than it takes to
    the next one: a pilot of a thousand of them would take minutes."""
    machine = Machine(spring=1e-5, mass=1e-5, damping=1e-4, velocity=1.0)
    short = Contacts(gaussian(1.0, 0.3), delay=Delay(1e-6))
    told = of_a_mass("stick-slip", 0.85)
    found = follow_finite(machine, short, 1e5, told, 0.8, 1e3)
    assert found.kind == "unknown" and "breaks are more than are followed here" in found.message


def test_what_a_shorter_path_told_stands_where_a_longer_one_takes_too_long(
    monkeypatch: Any,
) -> None:
    """Three slips on the first path, four needed: the second ends behind the fifth, no 20 loadings away, and where it
    is not done in time the three are told."""
    machine = Machine(spring=1e-3, mass=1e-5, damping=1e-4, velocity=1.0)
    contacts = Contacts(gaussian(1.0, 0.3), delay=Delay(30.0))
    solve, ends = master.solve, list[float]()
    slips = np.array([800.0, 2200.0, 3600.0])

    def without_time(contacts: Contacts, path: Any, *given: Any, **named: Any) -> Any:
        ends.append(path[-1])
        if len(ends) > 1:
            return solve(contacts, path, *given, **(named | {"wall_time": 1e-9}))
        found = solve(contacts, np.linspace(0.0, 10.0, path.size), *given, **named)
        none, moved = 0.0 * slips, slips + 1400.0
        of = SlipsInTime(slips, slips, moved, none + 0.9, none - 0.5, 0.0, slips, none, none, 0.0)
        undecided = replace(found.regime, verdict="undecided")
        told = {"slips": of, "period": 1400.0, "regime": undecided}
        return replace(found, path=path, **told)

    monkeypatch.setattr(master, "solve", without_time)
    found = follow(machine, contacts, "mass", RigidSlider(0.8, 0.5, 0, 3, 500), 60.0)
    assert found.kind == "undecided" and found.slips == 3 and found.before == 0.9
    assert ends[1] == pytest.approx(3600.0 + 2.2 * 1400.0)


@pytest.mark.slow  # quick: contacts that wait, below, are pulled beyond that force, too
def test_contacts_of_a_fast_drive_are_pulled_beyond_the_force_that_infinitely_many_reach() -> None:
    """While a mass is fast its contacts wait, but before its first slip the spring pulls more than F_s of a slider that
    moves with the drive, and by half of that in the time of a slip."""
    machine = Machine(spring=3.1e-3, mass=6.2e-6, damping=3.1e-5, velocity=2e3)
    contacts = Contacts(gaussian(1.0, 0.25), delay=Delay(1.0))
    found, steady = (
        master.propensity(contacts, velocity=2e3),
        master.steady_state(contacts, velocity=2e3),
    )
    static = found.static_to_kinetic * steady.force
    known = RigidSlider(static, steady.force, 1e-9, found.critical_spring, found.decoherence_length)
    told = follow(machine, contacts, "mass", known, wall_time=1e9)
    assert told.kind == "smooth" and told.force.max() > 1.1 * static
    few = follow_finite(machine, contacts, 2000.0, told, static, 1e9)
    assert (
        few.kind == "smooth" and few.contacts == 2000 and few.drive[-1] > told.force.max() / 3.1e-3
    )


def test_other_samples_change_the_kinetic_force_of_a_rigid_slider() -> None:
    """Contacts that wait are fewer on one as fast as the drive than on one that sticks."""
    told = of(of_a_mass("smooth", 0.05))
    kinetic = answers.Quantity(0.8, 1e-9, 0.1)
    own = replace(told.own, kinetic=kinetic)
    assert widest(replace(told, answers=(own,)))[0].startswith(
        "other samples would change F_k of a rigid slider by ± 0.10"
    )
    rested = replace(own, contacts=WAITING.replace(delay=None))
    assert widest(replace(told, answers=(rested,)))[0].startswith(
        "other samples would change F_k by ± 0.10"
    )


def test_the_number_of_contacts_hangs_on_their_breaks_and_no_tenth_of_a_pilots_time(
    monkeypatch: Any,
) -> None:
    """On a busy machine a pilot takes longer, and the answer is to be the same: numbers are PILOT by a power of 2, by
    the breaks of a pilot that takes a moment, and by the time of one that takes longer."""
    machine, asked, taken, clock = Machine(1e-3, None, 0.0, 1.0), list[int](), [0.9], [0.0]
    contacts, path = Contacts(gaussian(1.0, 0.3)), np.linspace(0.0, 3000.0, 5)
    ensemble = eq_model.Ensemble
    own_result = ensemble.result

    def result(followed: Any) -> Any:
        clock[0] += taken[-1]
        return replace(own_result(followed), run_time=taken[-1])

    def made(*arguments: Any, n_contacts: int, **named: Any) -> Any:
        asked.append(n_contacts)
        return ensemble(*arguments, n_contacts=PILOT, **named)

    def followed(seconds: float) -> int:
        sliders(machine, contacts, "reset", path, 10 * PILOT, seconds)
        return asked[-1]

    pilot = ensemble(
        contacts, path, n_contacts=PILOT, n_replicas=4, seed=1, **machine.keywords("reset")
    )
    breaks = sum(1 for _ in pilot) and pilot.result().breaks
    monkeypatch.setattr(ensemble, "result", result)
    monkeypatch.setattr(time, "process_time", lambda: clock[0])
    monkeypatch.setattr(eq_model, "Ensemble", made)
    for times, number in ((1.9, PILOT), (2.1, 2 * PILOT), (9.9, 8 * PILOT), (10.1, 10 * PILOT)):
        monkeypatch.setattr("toolkit.verdict.sliders.budget.MOST_BREAKS", times * breaks)
        assert [followed(1e3), followed(12.0)] == [number] * 2
    assert followed(5.9) == 4 * PILOT  # in half the time that those breaks take
    for run_time, number in (
        (2.1, 4 * PILOT),
        (2.5, 4 * PILOT),
        (4.0, 2 * PILOT),
        (1.9, 10 * PILOT),
    ):
        taken.append(run_time)
        assert followed(13.0) == number


def test_a_delay_that_changes_the_force_alone_is_no_assumption_without_effect() -> None:
    """Smooth with a delay and without one, at a force of an eighth: the page tells the other one."""

    def without(force: float, **named: Any) -> Behaviour:
        return replace(of_a_mass("smooth", force, **named), rule="instant")

    lines = dependence(of(of_a_mass("smooth", 0.05), without(0.4)))
    (line,) = [one for one in lines if "the contacts' delay" in one]
    assert line.startswith("the contacts' delay: without one it is smooth, too, but at 0.4")
    same = dependence(of(of_a_mass("smooth", 0.4), without(0.401)))
    assert same[-1] == "not the contacts' delay: without one it does the same"
    rough = without(0.4, error=0.5)
    assert dependence(of(of_a_mass("smooth", 0.05), rough))[-1] == same[-1]


def test_fewer_contacts_than_there_are_say_that_their_error_has_what_more_would_change() -> None:
    told = of_a_mass("stick-slip", 0.8, contacts=1000, message="by the ensemble", error=0.01)
    (line,) = [one for one in dependence(of(told)) if "slips are means" in one]
    assert "(one standard error, with what more contacts would change)" in line


def test_each_rule_has_its_own_error_in_the_line_on_sliders_that_tell_the_slips() -> None:
    """The largest of both was told of both: 28 µN of a force that is known to 0.7."""
    sharp = of_a_mass("stick-slip", 0.8, contacts=1000, message="by the ensemble", error=7e-4)
    each = replace(sharp, rule="reset"), replace(sharp, rule="reform-after", error=0.028)
    verdict = of(sharp)
    verdict = replace(verdict, answers=(replace(verdict.own, behaviours=each),))
    (line,) = [one for one in dependence(verdict) if "slips are means" in one]
    known = "known to some 7.0e-04 N_c<k>·length if a slip renews all contacts and some 0.028 N"
    assert known in line and "length if contacts re-form after the slip (one standard" in line


def test_more_contacts_keep_the_error_of_heat_that_is_left_out() -> None:
    few = of_a_mass("stick-slip", 0.8, contacts=1000, error=0.3, heat_left_out=0.25)
    more = Finite("mass", 2000, "stick-slip", before=0.8, before_error=1e-3, after=-0.4)
    more = replace(more, after_error=1e-3, period=1e3, period_error=1.0, slips=3.0)
    told = with_more(few, more, 1.0)
    assert told.contacts == 2000 and told.error == pytest.approx(0.251)
    assert told.message.endswith("2,000 contacts without heat")
    assert "heat is left out: it would change the force by" in "\n".join(dependence(of(told)))


def test_steps_of_thresholds_that_are_no_surfaces_are_refused_by_their_name() -> None:
    scene = load_scene(write(master=None, verdict={"steps": [1, 2]}), solved=False)
    with pytest.raises(InputError, match=r"^verdict.steps = \[1, 2\]: are of a surface"):
        verdict(scene)


def test_one_contact_is_no_plural(capsys: Any) -> None:
    """An area of a single contact is asked about, and its slips are told."""
    law = {"kind": "gaussian", "mean": 1e-8, "std": 2e-9}
    stated = {"mean_stiffness": 5.0, "contact_density": 1e6}
    drive = {"spring": "0.1 N/m", "area": 1e-6, "velocity": 1e-6}
    contacts = {"thresholds": law, "interface": stated}
    name = write(contacts=contacts, drive=drive, master=None, wall_time=1e4)
    _, out, _ = said(capsys, "verdict", name)
    page = "\n".join(out)
    assert "drive.area holds 1 contact: is it right" in page and "1 contacts" not in page
    assert "; sliders of 1 contact stick and slip, from " in page


def test_the_force_of_a_slider_on_which_few_contacts_hold_says_so_beside_the_mean_of_slips() -> (
    None
):
    """F_k of contacts of which a thousandth holds is a thousandth of the force before a slip, and startled; the mean of
    a sawtooth from 0 to 0.8 is 0.4, without its first third, where it rises twice as high."""
    drive = np.array([0.0, 800.0, 800.0, 1600.0, 1600.0, 2400.0, 2400.0, 2800.0])
    force = np.array([0.0, 1.6, 0.0, 0.8, 0.0, 0.8, 0.0, 0.4])
    told = replace(of_a_mass("stick-slip", 0.8), drive=drive, force=force, period=800.0)
    found = of(told)
    few = replace(found, answers=(replace(found.own, holding=1e-3),))
    lines = table(few)
    (kinetic,) = (one for one in lines if one.startswith("kinetic friction F_k"))
    assert "with 0.1% of the contacts holding" in kinetic
    (mean,) = (one for one in lines if one.startswith("mean force of stick-slip (mass)"))
    assert "0.4000 N_c<k>·length" in mean
    (why,) = (one for one in dependence(few) if "F_k is smaller than without a delay" in one)
    assert "waits while the drive goes on by 30.0" in why and "0.1% of them hold" in why
    many = table(found)
    assert not any("hold" in one for one in many)
    assert not any("F_k is smaller than without a delay" in one for one in dependence(found))
    smooth = of(of_a_mass("smooth", 0.8, drive=drive, force=force))
    assert not any(one.startswith("mean force") for one in table(smooth))


def test_a_slider_that_is_not_decided_in_time_lies_between_two_that_are() -> None:
    """With a long delay contacts re-form after a slip, without one at once: both are told, and what to do. So damped
    the spring's way of 800 falls by e in γ/K = 10, from a speed of 80 to that of the drive, 1, in 10 ln 80."""
    late = not_followed("mass", NO_TIME)
    each = {"reset": "stick-slip", "reform-after": "stick-slip", "instant": "smooth"}
    light = [replace(of_a_mass(kind, 0.8), rule=rule) for rule, kind in each.items()]
    found = of(late)
    between = replace(found, answers=(replace(found.own, behaviours=(late, *light)),))
    assert sentence(between) == (
        "not decided in time: stick-slip if the contacts' delay were far above the time of a slip, "
        "43.8 units of time, smooth if they had none; "
        "the command's --set wall_time=600 gives it ten minutes"
    )
    text = text_of(between)
    assert "stick-slip: 0.8000 N_c<k>·length down to" in text and "smooth at 0.8000" in text
    refused = replace(late, message="no such slider")
    other = replace(between, answers=(replace(found.own, behaviours=(refused, *light)),))
    said = sentence(other)
    assert said.startswith("not decided: stick-slip if") and "wall_time" not in said
    slipped = of_a_mass("undecided", 0.8, message="stopped by wall_time", cut=True)
    said = "\n".join(page(of(slipped, replace(of_a_mass("smooth", 0.6), rule="instant"))))
    assert "goes on is not known; the command's --set wall_time=600" in said
    assert "contacts that form again at once would make it smooth at 0.6000" in said


def test_a_delay_outlasts_a_slip_of_the_damped_mass() -> None:
    """Beyond critical damping a slip takes some γ/K times a logarithm, and not π (M/K)^(1/2) = 0.3."""
    machine = Machine(spring=1e-3, mass=1e-5, damping=4e-4, velocity=1.0)
    damped = replace(machine, damping=0.05 * machine.damping)
    known, times = RigidSlider(0.8, 0.5, 1e-9, 3.0, 500.0), [half_a_swing(machine)]
    times += [slip_duration(each, known.static) for each in (damped, machine)]
    assert times[0] == pytest.approx(times[1], rel=0.1) and times[2] > 2.0 * times[0]
    # docs/sliders.md, ζ = 1: of 50 N/m, 0.1 kg and 255 mN at 1 µm/s
    scan = Machine(50.0, 0.1, 2.0 * 5.0**0.5, 1e-6)
    assert slip_duration(scan, 0.255) == pytest.approx(14.3 * (0.1 / 50.0) ** 0.5, rel=0.01)
    for each, least in ((damped, times[1]), (machine, times[2])):
        for part in (2.99, 3.01):
            waiting = WAITING.replace(delay=Delay(part * least))
            assert may_follow(each, waiting, "mass", known) is (part > 3.0)
        assert long_delay(each, 1e-9, known.static) == pytest.approx(3.0 * least, rel=1e-12)


def test_one_number_is_written_once() -> None:
    """The force of a smooth slider is F_k and what the damping bears; the headline had 3.815 mN for a table's 3.814."""
    found = of(of_a_mass("smooth", 0.80008))
    own = replace(found.own, machine=Machine(1e-3, 1e-5, 8e-5, 1.0))
    known = replace(found, answers=(own,))
    assert sentence(known).startswith("smooth at 0.8001 N_c<k>·length (8.00e-05 N_c<k>·length of")
    sampled = replace(own, kinetic=answers.Quantity(0.8, 1e-9, 0.015))
    said = sentence(replace(found, answers=(sampled,)))
    assert said.startswith("smooth at 0.800 N_c<k>·length; other samples")
    far = replace(sampled, behaviours=(of_a_mass("smooth", 0.81),))
    assert sentence(replace(found, answers=(far,))).startswith("smooth at 0.810 ")


def test_smooth_sliding_of_contacts_that_were_not_followed_is_that_of_infinitely_many() -> None:
    """The sentence holds what was looked at: "instant" of the area's contacts was not, and yet they were smooth."""
    smooth = [replace(of_a_mass("smooth", 0.8), rule=rule) for rule in ("reset", "instant")]
    found = of(smooth[0])
    found = replace(found, answers=(replace(found.own, behaviours=tuple(smooth)),))
    followed = Finite("reset", 1000, "smooth", late=0.8, late_error=1e-3, fluctuation=1e-4)
    unknown = Finite("instant", 1000, "unknown", message="no time")
    said = sentence(replace(found, finite=(followed, unknown)))
    assert said == (
        "smooth at 0.8000 N_c<k>·length if a slip renews all contacts; "
        "smooth at 0.8000 N_c<k>·length for infinitely many contacts if contacts re-form at once"
    )
    both = replace(found, finite=(followed, replace(followed, rule="instant")))
    assert sentence(both) == "smooth at 0.8000 N_c<k>·length"


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_heat_tells_what_it_changes_in_the_kinetic_force(law: str) -> None:
    """Beside the bound of what it may change, which is 100 times that; F_k with and without by the master equation."""
    thermal = {"law": law, "temperature": 1e-3, "attempt_frequency": 1.0}
    thresholds = {"kind": "gaussian", "mean": 1.0, "std": 0.3}
    tables = {"thresholds": thresholds, "thermal": thermal}
    scene = load_scene({"contacts": tables, "wall_time": 1e4}, solved=False)
    cold, warm = (
        master.steady_state(each, velocity=1.0).force
        for each in (scene.contacts.replace(thermal=None), scene.contacts)
    )
    (line,) = (one for one in dependence(verdict(scene)) if one.startswith("heat "))
    change = (warm - cold) / cold
    told = r"F_k by (\S+) N_c<k>·length, ([^\s%]+)(%?) of the (\S+) N_c<k>·length without it"
    said = re.fullmatch(rf"heat (raises|lowers) {told}", line)
    assert said is not None and (said[1] == "raises") is (change > 0.0)
    assert float(said[2]) == pytest.approx(abs(warm - cold), rel=0.05)
    in_units = 100.0 if said[4] else 1.0
    assert float(said[3]) == pytest.approx(in_units * abs(change), rel=0.05)
    assert float(said[5]) == pytest.approx(cold, rel=0.005)
    left_out = of_a_mass("smooth", 0.8, heat_left_out=0.1)
    found = of(left_out)
    own = replace(found.own, cold=answers.Quantity(0.8 - 1e-3, 0.0))
    (line,) = (one for one in dependence(replace(found, answers=(own,))) if "left out" in one)
    raised = "heat raises F_k of a rigid slider as fast as the drive by 0.0010 N_c<k>·length"
    assert "by 0.10 N_c<k>·length at most; " + raised in line
    # on the page, too, as the bound may be far above it
    assert any(raised in line for line in on_the_page(replace(found, answers=(own,))))
    # of the barriers of a scan, 4e-06%
    own = replace(own, kinetic=answers.Quantity(0.8, 0.0), cold=answers.Quantity(0.8 - 3e-8, 0.0))
    (line,) = (one for one in dependence(replace(found, answers=(own,))) if "left out" in one)
    assert "by 3.0e-08 N_c<k>·length, 3.8e-08 of the 0.8" in line


def test_one_other_reading_is_no_plural() -> None:
    found = of(of_a_mass("smooth", 0.8))
    two = replace(found, answers=(found.own, replace(found.own, name="step 2")))
    assert dependence(two)[-1] == "not the reading: the other one says what own says"
    three = replace(two, answers=(*two.answers, replace(found.own, name="step 4")))
    assert "the 2 others that were followed say what own says" in dependence(three)[-1]


def test_a_trace_has_several_points_of_each_swing() -> None:
    """600 points of a path of 700 swings showed slower swings, which are not there."""
    machine = Machine(1e-3, 1e-3, 1e-4, 1.0)
    contacts = Contacts(gaussian(1.0, 0.2), delay=Delay(30.0))
    known = RigidSlider(0.69, 0.52, 1e-9, 1.0, 4.0, 2000.0)
    found = follow_by_contacts(machine, contacts, "mass", 700.0, time.monotonic() + 1e4, known)
    swing = 2.0 * half_a_swing(machine) * machine.velocity
    assert found.in_time.first_slip is not None and np.diff(found.drive).max() < swing / 8.0
    # contacts are out for a delay after the slip, in which the force is 0 twice a swing
    after = (found.drive > found.in_time.first_slip) & (
        found.drive < found.in_time.first_slip + 29.0
    )
    crossings = np.count_nonzero(np.diff(np.sign(found.force[after])))
    assert abs(crossings - 2.0 * 29.0 / swing) <= 1.0
    assert machine.points(1000.0 * swing) == 16_000 and machine.points(1e9) == 600
    assert replace(machine, mass=None).points(1e9) == 600


def test_sliders_that_stick_after_one_slip_where_their_path_ends_do_not_slide(
    monkeypatch: Any,
) -> None:
    """Their force rises by less than 0.3 <x_s> in the last tenth of such a path, as that of sliders that swing may."""
    monkeypatch.setattr(ways, "LOADINGS", 1.6)
    contacts = Contacts(gaussian(1.0, 0.2), delay=Delay(30.0))
    known = RigidSlider(0.69, 0.52, 1e-9, 1.0, 4.0, 2000.0)
    asked = HEAVY_ON_SOFT, contacts, "mass", 700.0, time.monotonic() + 1e4, known
    assert follow_by_contacts(*asked).kind == "stick-slip"
    # as if there were no time to pull them further
    monkeypatch.setattr(ensemble, "until_settled", lambda found, *_: found)
    late = follow_by_contacts(*asked)
    assert (late.kind, late.message) == ("undecided", ensemble.ONCE)


@pytest.mark.parametrize("followed", [1, 3, 4])
def test_sliders_of_which_some_were_given_up_for_want_of_time_are_none(followed: int) -> None:
    """Three of four sliders were taken for four of fewer contacts, of which one had not slipped: sliding was smooth."""

    class GivenUp(eq_model.Ensemble):
        """Out of time after so many sliders."""

        @property
        def interrupted(self) -> Any:
            return lambda: self.state.contacts >= followed * 100

        @interrupted.setter
        def interrupted(self, value: Any) -> None:
            pass

    contacts, path = Contacts(gaussian(1.0, 0.2), delay=Delay(30.0)), np.linspace(0.0, 900.0, 9)
    asked = HEAVY_ON_SOFT.keywords("mass")
    following = GivenUp(contacts, path, n_contacts=100, n_replicas=4, seed=1, threads=1, **asked)
    found = ensemble.followed_within(following, 1e4)
    assert (found is None) == (followed < 4)
    assert following.state.contacts == followed * 100


@pytest.mark.slow  # quick: how late few contacts slip, above
def test_the_period_of_fewer_contacts_than_there_are_is_known_as_their_force_is() -> None:
    """The standard error of 500 contacts alone was a third of what their period is off by from that of all."""
    machine, contacts = (
        Machine(1e-3, 1e-3, 6e-4, 1.0),
        Contacts(gaussian(1.0, 0.2), delay=Delay(30.0)),
    )
    exact = master.solve(contacts, np.array([2150.0]), 1e-4, **machine.keywords("mass")).period
    known = RigidSlider(0.69, 0.52, 1e-9, 1.0, 4.0, 1e6)
    for most in (500, 4000):
        asked = machine, contacts, "mass", 700.0, time.monotonic() + 1e4, known, most
        found = follow_by_contacts(*asked)
        assert found.period is not None and found.finite is not None
        off = abs(found.period - exact)
        assert off <= found.period_error
        # times the force that is not known, for the fall of a mass that swings
        assert found.period_error < 2.5 * found.error / machine.spring
        assert most > 500 or off > 3.0 * found.finite.period_error


@pytest.mark.slow  # quick: contacts that wait are pulled as far as a slider that sticks, above
def test_contacts_that_wait_longer_than_the_spring_is_loaded_slip_on(monkeypatch: Any) -> None:
    """In their delay the drive goes on by seven times what loads the spring: the path ended while all contacts were out
    after the first slip, and sliding was called smooth."""
    contacts = Contacts(gaussian(1.0, 0.05), delay=Delay(60.0))
    machine = Machine(spring=0.1, mass=1e-6, damping=3e-4, velocity=1.0)
    rigid = RigidSlider(0.9, 0.01, 0.0, 5.0, 1.0)
    never = not_followed("mass", "it is not solved here")
    monkeypatch.setattr("toolkit.verdict.sliders.follow.by_distribution", lambda *_: never)
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.CONTACTS", 5000)
    found = follow(machine, contacts, "mass", rigid, 1e4)
    assert found.kind == "stick-slip" and found.period == pytest.approx(69.4, abs=0.2)
    # K times the way from one slip to the next: by the delay nothing holds the slider, then contacts load the spring
    by_hand = 60.0 + found.before / 0.1
    assert found.period == pytest.approx(by_hand, rel=0.02)
    finite = follow_finite(machine, contacts, 2e3, found, rigid.static, 1e4)
    assert finite.kind == "stick-slip" and finite.before == pytest.approx(found.before, abs=0.02)
    told = follow_finite(machine, contacts, 2e3, never, rigid.static, 1e4)
    assert told.kind == "stick-slip" and told.before == pytest.approx(found.before, abs=0.03)
    # also where infinitely many were seen to slip, perhaps until they slide, but not where there is no time for more
    seen = replace(never, slips=9)
    told = follow_finite(machine, contacts, 2e3, seen, rigid.static, 1e4)
    assert told.kind == "stick-slip" and told.before == pytest.approx(found.before, abs=0.01)
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.ROUNDS", (0, 0))
    assert follow_finite(machine, contacts, 2e3, seen, rigid.static, 1e4).kind == "unknown"


def test_slips_of_a_mass_that_shrink_are_smooth_sliding_only_once_they_are_over() -> None:
    """Nine slips, each drop 2 % smaller than the one before, were called smooth at the force at which the path ended,
    halfway between two of them."""
    slips = SimpleNamespace(drive=np.arange(1.0, 10.0), duration=np.full(9, 0.1))
    regime = SimpleNamespace(verdict="decaying transient")
    named = {"slips": slips, "regime": regime, "period": 1.0}
    assert kind_of(SimpleNamespace(path=np.array([0.0, 9.5]), **named)) == "undecided"
    assert kind_of(SimpleNamespace(path=np.array([0.0, 12.0]), **named)) == "smooth"
    del slips.duration  # without a mass F tends to F_k, which is known
    assert kind_of(SimpleNamespace(path=np.array([0.0, 9.5]), **named)) == "smooth"


def test_slips_that_are_over_are_no_stick_slip_and_those_that_shrink_say_so(
    monkeypatch: Any,
) -> None:
    """Contacts that wait long come back ever less together: a few slips and then none were called stick-slip."""
    never = not_followed("mass", "it is not solved here")
    monkeypatch.setattr("toolkit.verdict.sliders.follow.by_distribution", lambda *_: never)
    delay = 40.0
    contacts = Contacts(stats.expon(), delay=Delay(delay))
    mass = 0.05 * (0.3 * delay / np.pi) ** 2  # a slip takes 0.3 of the delay
    machine = Machine(0.05, mass, 0.2 * np.sqrt(0.05 * mass), 1.0)
    rigid = RigidSlider(0.55, 0.025, 0.0, 0.5, 1.0, contacts=4000)
    found = follow(machine, contacts, "mass", rigid, 1e4)
    assert found.kind == "smooth" and found.slips == 4
    # steady sliding at F_k, <x_s>^2 / (<x_s> + v delay) for an exponential law, and what the damping bears
    steady = 1.0 / (1.0 + delay) + machine.damping
    assert found.after == pytest.approx(steady, abs=found.error) and found.error < 0.1
    narrow = Contacts(gaussian(1.0, 0.4), delay=Delay(delay))
    machine = replace(machine, mass=mass / 9.0, damping=machine.damping / 3.0)
    settled = follow(machine, narrow, "mass", replace(rigid, static=0.6), 1e4)
    # as where there is no time
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.ROUNDS", (0, 0))
    found = follow(machine, narrow, "mass", replace(rigid, static=0.6), 1e4)
    # of the transient nothing is told as if it lasted: its mean has what separates it from the slips to come
    assert settled.kind == "stick-slip" and settled.slips > 2 * found.slips
    assert abs(found.before - settled.before) < 3.0 * (found.error + settled.error)
    # means of slips that fade tell nothing of those to come: they are told by the last one, and as not decided
    assert found.kind == "undecided" and 0.04 < found.shrinks_by < 0.2
    said = shrinking(found)
    assert re.fullmatch(r", each drop [\d.]+% smaller than the one before", said)
    assert f"not decided: {found.slips} slips were seen{said}, the last from" in sentence(of(found))
    # those that shrink less go on for long: beside their mean it stands, too
    assert found.finite is not None
    many = replace(found.finite, kind="stick-slip", message="")
    slow = replace(found, kind="stick-slip", shrinks_by=0.0, finite=many)
    verdict_of_many = replace(of(slow), finite=(many,))
    assert f"{said}, so that they may die out" in sentence(verdict_of_many)
    steady = replace(verdict_of_many, finite=(replace(many, shrinks_by=0.0),))
    assert "die out" not in sentence(steady)


def test_a_cause_is_told_only_where_it_was_followed() -> None:
    """Heat that was left out lifts no force, and a damping that nobody gave stands in the sentence itself."""
    found = not_followed("mass", "by the ensemble, 4 sliders of 500 contacts")
    slips = {"kind": "stick-slip", "before": 0.9, "after": -0.5, "period": 900.0, "slips": 5}
    found = replace(found, **slips, error=1e-9, success=True, damping=0.02, heat_left_out=1e-4)
    told = of(found)
    warm = replace(told.own, contacts=WAITING.replace(thermal=Thermal("soft", 0.01, 0.1)))
    (line,) = why_above(replace(told, answers=(warm,)))
    assert line.startswith("the force before a slip is above F_s: ") and "heat breaks" not in line
    assert "; all contacts hold one that sticks" in line and line in page(
        replace(told, answers=(warm,))
    )
    at_once = replace(warm, contacts=warm.contacts.replace(delay=None))
    (line,) = why_above(replace(told, answers=(at_once,)))
    assert line.endswith("; heat, which lowers F_s, is left out of the slips")  # nothing waits
    followed = replace(warm, behaviours=(replace(found, heat_left_out=None),))
    assert "; heat breaks weak" in " ".join(why_above(replace(told, answers=(followed,))))
    # 2 (K M)^(1/2) = 2e-4 is critical
    assert sentence(told).endswith("(10000% of critical; none is given)")
    given = replace(told.own, behaviours=(replace(found, damping=None),))
    assert "none is given" not in sentence(replace(told, answers=(given,)))


def test_a_slider_that_is_not_decided_is_told_with_its_mass_at_both_extremes_of_its_delay() -> None:
    """The delay is short below min(<x_s>/V, γ<x_s>/F_k), with V = 0.8/(K M)^(1/2) damped to 80 and γ/F_k = 0.0125."""
    undecided = not_followed("mass", NO_TIME)
    late = replace(of_a_mass("stick-slip", 0.8), period=1200.0, delay=30.0)
    both = of_a_mass("smooth", 0.5), late
    found = of(undecided)
    hardly = WAITING.replace(delay=Delay(1e-6))  # so that F_k is that of contacts that do not wait
    told = replace(found, answers=(replace(found.own, extremes=both, contacts=hardly),))
    for damping in (0.01, 0.2):
        machine = replace(told.own.machine or Machine(1.0), damping=damping)
        each = replace(told, answers=(replace(told.own, machine=machine),))
        fastest = kinds.a_slip(each.own)[1]
        expected = min(1.0 / fastest, damping / 0.8) * WAITING.mean_threshold
        assert of_delay.short_delay_of(each.own) == pytest.approx(expected, rel=2e-6)
    said = sentence(told)
    assert said.startswith("not decided in time: stick-slip if the contacts' delay were far above")
    assert "smooth if it were far below 0.0125 units of time" in said or "far below 12.5" in said
    text = page(told)
    (at_once,) = (one for one in text if "form again at once would make it" in one)
    assert "make it smooth at 0.5000 N_c<k>·length" in at_once
    (after,) = (
        one for one in text if "form again only after 30 units of time would make it" in one
    )
    assert "stick-slip: 0.8000 N_c<k>·length down to -0.4000" in after and "every 1,200" in after
    (delay,) = (one for one in text if one.startswith("  the contacts' delay: "))
    assert delay.endswith(" units of time, the time of a slip") and "; short is far below" in delay
    (delay,) = (one for one in dependence(told) if one.startswith("the contacts' delay: "))
    assert "friction falls with the speed by more than the damping rises" in delay
    loaded = "units of time in which the drive loads the spring to F_s"  # F_s/(K v), 0.8/1e-3
    assert f"of a slip, and far below the 800 {loaded}, only after the slip" in delay
    fast = replace(told.own.machine or Machine(1.0), velocity=1e4)
    (delay,) = dependence(replace(told, answers=(replace(told.own, machine=fast),)))[:1]
    assert "with no delay do they all re-form between one slip and the next" in delay
    assert f"longer than the 0.08 {loaded}" in delay
    assert [one["kind"] for one in plain(told)["readings"][0]["extremes"]] == [
        "smooth",
        "stick-slip",
    ]
    assert not any("would make it" in one for one in page(found))


def test_the_extremes_of_a_delay_keep_the_mass_and_are_asked_of_the_cheaper_solver(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Contacts that form at once are the master equation's, those that wait for far above a slip the ensemble's."""
    machine, budget = Machine(1e-3, 1e-5, 0.01, 1.0), Budget(1e4, strict=True)
    contacts = WAITING.replace(delay=Delay(0.5))
    given = not_followed("mass", NO_TIME)
    first, after = of_a_mass("smooth", 0.5), of_a_mass("stick-slip", 0.8)
    delays = list[float]()

    def asked(name: str, told: Behaviour) -> None:
        def followed(slider: Machine, waiting: Contacts, rule: str, *_: Any) -> Behaviour:
            assert (slider, rule, waiting.thermal) == (machine, "mass", None)
            delays.append(waiting.waiting_time)
            return told

        monkeypatch.setattr(with_mass, name, followed)

    asked("follow", first)
    asked("follow_by_contacts", after)
    own = Reading("own", True, contacts)
    told = follow_extremes(machine, own, given, None, budget)
    assert told == (replace(first, delay=0.0), replace(after, delay=delays[1]))
    # far above a slip of the damped mass from F_s, here longer than <x_s>/v = 1
    without = contacts.replace(delay=None)
    static = master.propensity(without).static_to_kinetic * master.steady_state(without).force
    assert delays == [0.0, pytest.approx(3.0 * slip_duration(machine, static), rel=1e-2)]
    # neither of others than the scene's own, nor without a delay or a damping, nor beside heat that matters
    hot = contacts.replace(thermal=Thermal("soft", temperature=0.01, attempt_frequency=1e-3))
    for one in (
        (machine, Reading("other", False, contacts), given),
        (machine, Reading("own", True, contacts.replace(delay=None)), given),
        (replace(machine, damping=0.0), own, given),
        (machine, Reading("own", True, hot), given),
    ):
        assert follow_extremes(*one, None, budget) == ()
    weak = replace(given, heat_left_out=0.01)
    warm = follow_extremes(machine, Reading("own", True, hot), weak, None, budget)
    assert [one.kind for one in warm] == ["smooth", "stick-slip"]
    assert warm[1].error == pytest.approx(after.error + 0.01) and warm[1].heat_left_out == 0.01
    asked("follow", given)
    assert follow_extremes(machine, own, given, None, budget) == ()


def test_a_slider_whose_sliding_swings_is_told_how_far_it_is_from_steady() -> None:
    """In N s/m, N_c<k> = 4e7 N/m here; the path and the tolerance are the verdict's own."""
    contacts = Contacts(gaussian(1e-8, 3e-9), delay=Delay(1e-7))
    path = np.linspace(0.0, 1e-2, 5)
    solved = master.solve(
        contacts, path, 1e-2, velocity=1e-6, spring=1e-6, mass=2.2e-9, damping=1e-8, wall_time=1e-9
    )
    law = contacts.thresholds
    falls = 1e-7 * 0.5 * law.moment(2) / (law.mean() + 1e-13) ** 2
    told = (
        f"friction falls with the speed by {falls:.4g}, and the damping is 1e-08; with a larger one"
    )
    assert told in solved.message and "; else end the path sooner" in solved.message
    assert "stopped by wall_time" in solved.message
    newtons = replace(
        scale_of(contacts, None), length_unit="m", time_unit="s", spring_unit="N/m", spring=4e7
    )
    told = in_units(late(solved.message), newtons)
    assert told.startswith("neither force nor slips are known in time: raise wall_time")
    assert told.endswith(
        "friction falls with the speed by 2.179 N s/m, and the damping is 0.400 N s/m; "
        "with a larger one it would not, if the machine has that"
    ), told
    assert late("stopped by wall_time").endswith("where none is given)")


def test_a_slider_that_slides_with_a_short_delay_is_held_against_a_long_one(
    monkeypatch: Any,
) -> None:
    """It was held against none, and the page said that the delay decides nothing."""
    short = WAITING.replace(delay=Delay(1e-3))
    asked = list[float]()

    def other(machine: Any, contacts: Any, number: Any, seconds: float, delay: float = 0.0) -> Any:
        asked.append(delay)
        found = of_a_mass("stick-slip" if delay else "smooth", 0.8)
        return found if delay else replace(found, rule="instant")

    monkeypatch.setattr("toolkit.verdict.with_mass.follow_other_delay", other)
    slides = replace(of_a_mass("smooth", 0.5), after=0.5)
    own = replace(of(slides).own, contacts=short)
    turned = with_mass.with_other_delay(own, Budget(60.0, strict=True))
    assert turned.kind == "stick-slip" and asked == [0.0, kinds.long_delay_of(own)]
    told = replace(of(slides, turned), answers=(own,))
    text = " ".join(page(told))
    assert "contacts that form again only after " in text and "would make it stick-slip" in text
    assert "not the contacts' delay" not in text
    # one that slides with a delay that is long already, and one that sticks, are held against none
    for contacts, behaviour in (
        (WAITING.replace(delay=Delay(1e3)), slides),
        (short, of_a_mass("stick-slip", 0.8)),
    ):
        del asked[:]
        own = replace(of(behaviour).own, contacts=contacts)
        assert with_mass.with_other_delay(
            own, Budget(60.0, strict=True)
        ).kind == "smooth" and asked == [0.0]


def test_where_slip_rules_tell_of_no_long_delay_the_mass_itself_does(monkeypatch: Any) -> None:
    """Slips of a heavy slider take as long as the time between them: no rule tells of it, and the page of one that
    slides, of which no delay is given, did not say that one of 42 ms makes it stick and slip."""

    def other(machine: Any, contacts: Any, number: Any, seconds: float, delay: float = 0.0) -> Any:
        too_long = not_followed("reform-after", "a slip of this mass takes as long as the period")
        return of_a_mass("stick-slip", 0.8) if delay else too_long

    monkeypatch.setattr("toolkit.verdict.with_mass.follow_other_delay", other)
    own = of(replace(of_a_mass("smooth", 0.5), after=0.5)).own
    own = replace(own, contacts=own.contacts.replace(delay=None))
    assert with_mass.with_other_delay(own, Budget(60.0, strict=True)).kind == "stick-slip"


def test_a_short_delay_is_told_by_the_friction_of_contacts_that_do_not_wait() -> None:
    """F_k of the table is that of the present delay, at which fewer contacts hold."""
    slides = of_a_mass("smooth", 0.5)
    at_once, late = (
        replace(of(slides).own, contacts=WAITING.replace(delay=Delay(delay)))
        for delay in (1e-9, 1.0)
    )
    unit = WAITING.mean_threshold
    fewer = replace(late, kinetic=answers.Quantity(0.8 * unit / (unit + 1.0), 1e-9))
    assert of_delay.short_delay_of(fewer) == pytest.approx(
        of_delay.short_delay_of(at_once), rel=1e-6
    )


def slips_of_infinitely_many(
    before: float, after: float, period: float, first: float | None = None
) -> Behaviour:
    """A slider with mass that sticks and slips."""
    named = {
        "period": period,
        "in_time": SlipsOfMass(first_slip=first),
        "force": np.full(4, before),
    }
    found = of_a_mass("stick-slip", before, drive=np.linspace(0.0, 1.0, 4))
    return replace(found, after=after, slips=9, **named)


def test_a_slip_that_lasts_longer_than_the_spring_is_loaded_is_waited_for() -> None:
    """The mass takes 63 mean thresholds of the drive for a slip, and the spring is loaded by 25: the path ended before
    the first slip, and sliding was called smooth."""
    contacts, machine = Contacts(gaussian(1.0, 0.4), delay=Delay(2.0)), Machine(0.05, 20.0, 0.05, 1)
    told = slips_of_infinitely_many(1.245, -0.809, 125.8)
    found = follow_finite(machine, contacts, 1000.0, told, 0.557, 1e4)
    assert found.kind == "stick-slip" and found.period == pytest.approx(125.7, abs=0.5)
    assert found.before == pytest.approx(1.245, abs=0.05)


@pytest.mark.slow  # quick: a slip that lasts longer than the spring is loaded, above
def test_slips_in_many_falls_of_few_contacts_each_are_those_of_infinitely_many() -> None:
    """Contacts come back while a slip goes on: of finitely many the force falls in steps, of which few break a fifth of
    all contacts. The slip is the swing from the maximum to the minimum, as of infinitely many."""
    contacts = Contacts(gaussian(1.0, 0.4), delay=Delay(0.2))
    told = slips_of_infinitely_many(0.603, 0.077, 2.24, first=2.095)
    found = follow_finite(Machine(0.5, 2e-11, 5e-6, 1.0), contacts, 2e4, told, 0.5885, 1e4)
    assert found.kind == "stick-slip" and found.slips >= 4.0
    # the first maximum of finitely many forces is above that of their mean, by some N^(-2/3) of a threshold
    few = 2.0 * 20_000.0 ** (-2.0 / 3.0)
    assert found.before == pytest.approx(told.before, abs=4.0 * found.before_error + few)
    assert found.after == pytest.approx(told.after, abs=4.0 * found.after_error + few)
    assert found.period == pytest.approx(2.24, abs=4.0 * found.period_error + few / 0.5)
    assert found.before_error < 0.002 and found.period_error < 0.02


def test_rules_that_agree_on_slips_and_not_on_their_drop_say_so() -> None:
    """Both stick and slip, one by half as much as the other."""
    told = of(of_a_mass("stick-slip", 0.8))
    each = [replace(told.own.behaviours[0], rule="reset", after=0.0)]
    apart = "0.8000 N_c<k>·length down to 0 N_c<k>·length every 800.0 units of length if "
    apart += "a slip renews all contacts and 0.8000 N_c<k>·length down to 0.4000 N_c<k>·length "
    apart += "every 400.0 units of length if contacts re-form after the slip"
    for after, end in ((0.0, "all rules agree"), (0.4, f"all stick and slip, between {apart}")):
        each[0] = replace(each[0], period=800.0)
        other = replace(each[0], rule="reform-after", after=after, period=1e3 * (0.8 - after))
        both = (*each, other)
        lines = dependence(replace(told, answers=(replace(told.own, behaviours=both),)))
        assert [line for line in lines if line.endswith(end)]


@pytest.mark.parametrize(
    "spring, mass, damping, delay, force",
    [
        (2.5e-5, 0.05e-6, 0.25e-6, 1e-3, 1.3),  # rings on contacts that wait for most of the time
        (2.5e-4, 0.05e-6, 0.25e-6, 1e-5, 1.3),  # friction ends its first swing
        (
            0.5,
            0.05e-6,
            0.25e-6,
            1e-5,
            1.1,
        ),  # carried along by a drive that is too fast for it to stick
    ],
)
def test_a_contact_that_waits_breaks_no_more_often_than_its_lives_and_delays_allow(
    spring: float, mass: float, damping: float, delay: float, force: float
) -> None:
    """Some 2e9 breaks were refused where sliders took 1e8: each contact waits between two. The ensemble counts them."""
    contacts = Contacts(gaussian(1.0, 0.4), delay=Delay(delay))
    machine = Machine(spring, mass, damping, 2e5 if spring > 0.1 else 200.0)
    loading = loading_of(machine, contacts, force)
    path = np.linspace(0.0, 6.0 * loading, 7)
    found = eq_model.simulate(contacts, path, n_contacts=100, **machine.keywords("mass"))
    expected = 100 * found.slips.drive.size * lives_in_a_slip(machine, contacts, force, loading)
    assert found.slips.drive.size >= 3 and 0.9 < expected / found.breaks < 3.0


@pytest.mark.slow  # quick: the number of contacts hangs on their breaks, above
def test_a_short_delay_that_is_not_solved_is_told_by_as_many_contacts_as_break_often_enough(
    monkeypatch: Any,
) -> None:
    """A slider with a delay of a twentieth of its slip was not decided; all of its contacts are followed, or fewer, by
    their number of breaks and by no clock."""
    never = not_followed("mass", "it is not solved here")
    monkeypatch.setattr("toolkit.verdict.sliders.follow.by_distribution", lambda *_: never)
    contacts, spring = Contacts(gaussian(1.0, 0.4), delay=Delay(0.05)), 0.01
    mass = spring / np.pi**2
    machine = Machine(spring, mass, 0.2 * np.sqrt(spring * mass), 1.0)
    rigid = RigidSlider(0.65, 0.58, 0.0, 0.3, 1.0, contacts=4000)
    every = follow(machine, contacts, "mass", rigid, 1e4)
    assert every.kind == "stick-slip" and every.contacts == 4000
    monkeypatch.setattr("toolkit.verdict.sliders.budget.MOST_BREAKS_RINGING", 1e6)
    fewer = follow(machine, contacts, "mass", rigid, 1e4)
    assert fewer.contacts == 2 * PILOT and fewer.before == pytest.approx(
        every.before, abs=fewer.error
    )
    many = follow_finite(machine, contacts, 4000.0, fewer, rigid.static, 1e4)
    assert many.kind == "unknown" and "breaks are more than are followed here" in many.message
    assert "2,000 contacts stand for the 4,000" in "\n".join(
        dependence(replace(of(fewer), finite=(many,)))
    )
    # without a delay each contact breaks at every threshold: the master equation alone takes such a slider
    assert follow(machine, contacts.replace(delay=None), "mass", rigid, 1e4) is never


def test_a_slider_on_a_spring_above_that_of_the_table_says_why_it_slips() -> None:
    """K* of contacts that wait is of one speed; the number of contacts is no cause of slips below it, nor of those of
    contacts that have grown stronger."""
    told = of(of_a_mass("stick-slip", 0.9))
    scale = replace(told.own.scale, contacts=20_000.0)
    for spring, above in ((0.7, False), (0.9, True)):
        machine = replace(told.own.machine or Machine(1.0), spring=spring)
        lines = dependence(
            replace(told, answers=(replace(told.own, machine=machine, scale=scale),))
        )
        assert above is any("on a spring above K* of the table" in one for one in lines)
        assert above is any("N K³ = " in one for one in lines)
    older = replace(told.own, machine=machine, scale=scale, contacts=STRONGER)
    assert not any("N K³" in one for one in dependence(replace(told, answers=(older,))))


def test_a_picture_without_a_friction_trace_says_why() -> None:
    trace = {"drive": np.linspace(0.0, 9.0, 5), "force": np.full(5, 0.8)}
    for error, told in ((0.5, True), (1e-3, False)):
        figure = draw_verdict(of(of_a_mass("smooth", 0.8, error=error, **trace)))
        title = figure.get_suptitle().replace("\n", " ")
        assert ("no friction trace" in title) is told
        assert ("as its force is known to 0.5 <x_s> only: see friction.csv" in title) is told
    unknown = draw_verdict(of(not_followed("mass", NO_TIME)))
    assert "as no slider was followed" in unknown.get_suptitle()


@pytest.mark.slow  # quick: narrow peaks, in test_verdict.py, whose slips end at 0
def test_what_is_left_of_the_force_after_a_slip_by_rounding_is_none() -> None:
    """The tail of P_c far beyond its support left 2.4e-176 fN of 6.3 mN."""
    contacts = Contacts(gaussian(1.0, 0.4), delay=Delay(0.2))
    rigid = RigidSlider(0.59, 0.48, 0.0, 0.3, 1.0)
    found = follow(
        Machine(0.05, None, 0.0, 1.0), contacts, "reform-after", rigid, 1e4, tolerance_in_time=0.03
    )
    assert found.kind == "stick-slip" and found.contacts is None
    assert found.after == 0.0 and found.before == pytest.approx(0.634, abs=0.01)


@pytest.mark.slow  # quick: a damping that was taken, in test_verdict.py
def test_a_damping_that_nobody_gave_bears_no_large_part_of_an_answer() -> None:
    """A tenth of critical damping bore 63 of 69 mN, told as the answer."""
    contacts, machine = Contacts(gaussian(1.0, 0.4)), Machine(0.5, 5e-8, 0.0, 2e5)
    rigid = RigidSlider(0.646, 0.5794, 1e-9, 0.22, 1.0)
    found = follow(machine, contacts, "mass", rigid, 1e4, rings=True)
    # 0.1 times 2 (K M)^(1/2) v = 6.3, beside F_k
    said = f"would bear {6.325 / (6.325 + 0.5794):.0%} of its force: give drive.damping"
    assert found.kind == "undecided" and found.message.endswith(said)
    assert said in sentence(of(found))
    slow = follow(replace(machine, velocity=2e2), contacts, "mass", rigid, 1e4, rings=True)
    assert slow.kind == "smooth" and slow.damping == pytest.approx(0.2 * (0.5 * 5e-8) ** 0.5)
    with_damping = follow(replace(machine, damping=slow.damping), contacts, "mass", rigid, 1e4)
    assert with_damping.before == pytest.approx(6.325 + 0.5794, rel=0.01)
    own = replace(of(found).own, scale=replace(of(found).own.scale, contacts=100.0))
    assert (
        judge.finite_sliders(SimpleNamespace(eq=None), own, *2 * [Budget(60.0, True)], print) == ()
    )


def test_contacts_of_the_area_are_given_up_once_the_time_is_over(monkeypatch: Any) -> None:
    """Kernels of contacts that break by heat were compiled for 20 s after the end of a wall_time of 50 s."""

    def compiled(*_: Any) -> Finite:
        time.sleep(60.0)
        raise AssertionError("it was not given up")

    monkeypatch.setattr(judge, "follow_finite", compiled)
    monkeypatch.setattr(judge, "SHORT", 0.1)
    own = of(of_a_mass("stick-slip", 0.8)).own
    own, over = replace(own, scale=replace(own.scale, contacts=100.0)), Budget(0.0, strict=True)
    (told,) = judge.finite_sliders(SimpleNamespace(eq=None), own, over, over, print)
    assert (told.kind, told.contacts, told.message) == ("unknown", 100, NO_TIME)


@pytest.mark.parametrize("kind", ["undecided", "smooth"])
def test_where_heat_costs_the_answer_of_a_mass_it_is_told_what_to_leave_out(kind: str) -> None:
    """Samples at 300 K on 50 N/m, with 0.1 kg: not decided in a minute, and in seconds without heat."""
    warm = Contacts(gaussian(1.0, 0.3), thermal=Thermal("soft", 1e-3, 1.0))
    slider = Behaviour("mass", kind, 0.5, 0.5, None, 0, 1e-3, True, "takes 2001 steps", 0.0)
    given: Any = {"machine": Machine(1e-4, 1e-4, 1e-3, 1.0), "cold": answers.Quantity(0.51, 1e-9)}
    found = verdict_on(reading(slider, contacts=warm, kinetic=0.5, **given))
    told = [line for line in dependence(found) if line.startswith("heat lowers F_k")]
    assert len(told) == 1
    assert ("leave [contacts.thermal] out" in told[0]) == (kind == "undecided")
