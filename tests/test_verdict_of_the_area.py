"""What a verdict says of the contacts of the area where they slip by chance, and infinitely many do not."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats

import eq_model
import master
from origins import Contacts, Delay, InputError, gaussian
from tests.verdicts import HEAVY, slips, told
from toolkit.verdict import answers
from toolkit.verdict.of_area import with_more
from toolkit.verdict.picture import draw_verdict
from toolkit.verdict.sliders import finite
from toolkit.verdict.sliders import follow as following
from toolkit.verdict.sliders.finite import follow_finite
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Finite, not_followed
from toolkit.verdict.sliders.slips_in_time import SlipsOfMass
from toolkit.verdict.text.words import page, sentence

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")

SMOOTH: dict[str, Any] = {"kind": "smooth", "before": 0.5, "after": 0.5, "slips": 0}
RULES = "reset", "reform-after", "instant"


def of_the_area(number: float, critical: float, finite: tuple[Finite, ...]) -> answers.Verdict:
    """The verdict on so many contacts, with this K*/(N_c <k>), of which infinitely many slide under all rules."""
    found = told(*(slips(rule, **SMOOTH) for rule in RULES))
    scale = replace(found.own.scale, contacts=number)
    own = replace(found.own, scale=scale, critical_spring=answers.Quantity(critical, 1e-9))
    return replace(found, answers=(own,), finite=finite)


def test_without_a_spring_it_says_up_to_which_one_the_areas_contacts_may_slip() -> None:
    """Up to N K³ = 50, of 400,000 K = 0.05, which is above a K* of 0.01, and not above one of 0.1."""
    for critical, by_chance in ((0.01, True), (0.1, False)):
        found = of_the_area(4e5, critical, ())
        found = replace(found, answers=(replace(found.own, machine=None, behaviours=()),))
        said, text = sentence(found), page(found)
        assert said.startswith(
            f"slips at least once on a spring softer than K* = {critical:#.4g} N"
        )
        assert "; whether slips go on hangs on mass, damping and delay, or on the slip rule" in said
        many = (
            "if contacts are infinitely many; the 400,000 contacts of the area may slip by chance"
        )
        assert (many in said and "up to some 0.050 N_c<k>;" in said) is by_chance
        rows = [one for one in text if one.startswith("400,000 contacts may slip by chance up to")]
        assert [one.split()[-2] for one in rows] == ["0.050"] * by_chance


def test_the_slip_rule_decides_what_the_areas_contacts_do_where_infinitely_many_agree() -> None:
    """The page said that it does not, for infinitely many contacts, of which its answer is not."""
    each = [
        Finite(rule, 4000, "stick-slip", 0.6, 1e-3, 0.0, 0.0, 5.0, period=70.0) for rule in RULES
    ]
    few = (*each[:2], Finite("instant", 4000, "smooth", late=0.5, late_error=1e-4))
    text = page(of_the_area(4e3, 0.0, few))
    decides = (
        "  the slip rule, for the 4,000 contacts of the area: stick-slip if a slip renews all "
    )
    decides += "contacts or contacts re-form after the slip, smooth if contacts re-form at once; infinitely many slide "
    assert [one for one in text if one.startswith(f"{decides}smoothly. In nature mass")]
    assert not any("all rules agree" in one for one in text)
    alike = page(of_the_area(4e3, 0.0, tuple(each)))
    assert any("all rules agree" in one for one in alike)
    assert not any("the slip rule, for the 4,000" in one for one in alike)


def test_slips_that_do_not_recur_are_no_stick_slip() -> None:
    """With exponential thresholds and N K³ = 45 some sliders slip twice, and some once; at 15 all go on to slip."""
    smooth = slips("reset", kind="smooth", before=1.0, after=1.0, slips=0)
    for crowd, kind in ((45.0, "now and then"), (15.0, "stick-slip")):
        machine = Machine((crowd / 1e3) ** (1.0 / 3.0), None, 0.0, 1.0)
        few = follow_finite(machine, Contacts(stats.expon()), 1e3, smooth, 1.0, 1e4)
        assert few.kind == kind and (few.period is None) is (kind == "now and then")
        if few.period is None:
            found = page(of_the_area(1e3, 0.0, (few,)))
            assert found[2].startswith("1,000 contacts slip now and then, from 1.04 N_c<k>·length")
            assert (
                f", {few.slips:.2g} a slider on the way that was followed, sliding at" in found[3]
            )
            assert not any(one.startswith("period") or "stick-slip" in one for one in found)


def test_slips_that_infinitely_many_have_too_are_not_told_of_those_that_slip_once_more() -> None:
    """The sentence told the first fall of all sliders, from F_s, as one of those that come now and then; a fall of 4
    standard deviations of the force, which has such ones by chance, is in the lines below it alone."""
    contacts = Contacts(stats.weibull_min(3))
    mean = contacts.mean_threshold
    kinetic = stats.weibull_min(3).moment(2) / (2.0 * mean)
    smooth = slips("instant", kind="smooth", before=kinetic, after=kinetic, slips=1)
    machine = Machine(0.02, None, 0.0, 1.0)
    few = follow_finite(machine, contacts, 3e3, smooth, 1.15 * kinetic, 1e4)
    # beside the first of each, two of one slider, two of another and one of a third
    assert few.kind == "now and then" and few.slips == 1.25
    assert 0.02 * mean < few.before - few.after < 0.03 * mean
    assert abs(0.5 * (few.before + few.after) - few.late) < few.fluctuation
    rigid = replace(of_the_area(3e3, 0.3, ()), finite=(few,))
    one = replace(smooth, error=1e-9)
    own = replace(rigid.own, behaviours=(one,), contacts=contacts)
    found = replace(rigid, answers=(own,))
    assert sentence(found).startswith("slips now and then, at ")
    assert "disagree" not in sentence(found)
    steady = replace(found, finite=(replace(few, fluctuation=0.1 * few.fluctuation),))
    assert sentence(steady).startswith("3,000 contacts slip now and then, from ")


def test_falls_of_sliders_that_slide_for_most_of_the_way_are_no_stick_slip() -> None:
    """A thousand contacts on a soft spring have falls above 0.02 <x_s> every 5 ± 4 <x_s> of the drive, and slide in
    between; those of a hundred take back most of what the drive loads."""
    contacts, machine = Contacts(stats.weibull_min(3)), Machine(0.02, None, 0.0, 1.0)
    kinetic = stats.weibull_min(3).moment(2) / (2.0 * contacts.mean_threshold)
    smooth = slips("instant", kind="smooth", before=kinetic, after=kinetic, slips=1)
    for number, kind in ((1e3, "now and then"), (1e2, "stick-slip")):
        few = follow_finite(machine, contacts, number, smooth, 1.15 * kinetic, 1e4)
        assert few.kind == kind and few.period is not None


def test_the_headline_leads_with_the_rules_of_the_largest_slips() -> None:
    """It told a fall of 3 % of the force under one rule before slips down to no force under the others."""
    rules = [slips(rule) for rule in RULES[:2]] + [slips("instant", **SMOOTH)]
    found = told(*rules)
    whole = [Finite(rule, 4000, "stick-slip", 0.7, 1e-3, 0.0, 0.0, 5.0) for rule in RULES[:2]]
    part = Finite("instant", 4000, "stick-slip", 0.55, 1e-3, 0.45, 1e-3, 5.0)
    own = replace(found.own, scale=replace(found.own.scale, contacts=4e3))
    found = replace(found, answers=(own,), finite=(*whole, part))
    first, second, third = sentence(found).split("; ")
    after = "if a slip renews all contacts or contacts re-form after the slip"
    unit = own.scale.force_unit
    assert first == f"stick-slip, from 0.700 {unit} down to 0 {unit}, {after}"
    assert second.startswith(f"4,000 contacts stick and slip, from 0.550 {unit} down to ")
    assert third.startswith("disagree: infinitely many would slide smoothly at ")
    title = draw_verdict(found).get_suptitle()
    assert title.splitlines()[1].startswith("stick-slip, from 0.700 ") and "0.550" not in title


def test_a_rule_under_which_the_areas_contacts_slip_now_and_then_is_so_told_in_the_headline() -> (
    None
):
    """It said that they slide smoothly, above a line that they slip now and then: infinitely many slide."""
    found = told(slips("reset"), slips("instant", **SMOOTH))
    few = Finite("instant", 60, "now and then", 0.52, 1e-3, 0.48, 1e-3, 0.25, fluctuation=0.02)
    own = replace(found.own, scale=replace(found.own.scale, contacts=60.0))
    all_slip = Finite("reset", 60, "stick-slip", 0.6, 1e-3, 0.0, 0.0, 6.0, period=70.0)
    few = replace(few, late=0.5, late_error=1e-3)
    found = replace(found, answers=(own,), finite=(all_slip, few))
    says = (
        "stick-slip if a slip renews all contacts, slips now and then if contacts re-form at once"
    )
    assert sentence(found) == f"what contacts do in a slip decides: {says}"
    assert any(one.strip().startswith("slips now and then, at 0.500 ") for one in page(found))


@pytest.mark.parametrize(
    "number, whom", [(6e4, "the 60,000 of the area"), (None, "infinitely many")]
)
def test_contacts_that_stand_for_more_are_told_in_the_first_sentence(
    number: float | None, whom: str
) -> None:
    """It gave their forces as those of the slider, and the lines far below said that they were of a thousand."""
    for few in (slips("mass"), slips("mass", **SMOOTH)):
        found = told(replace(few, contacts=1000), machine=HEAVY)
        own = replace(found.own, scale=replace(found.own.scale, contacts=number))
        said = sentence(replace(found, answers=(own,)))
        assert f" with 1,000 contacts, followed contact by contact, in place of {whom}" in said
        every = replace(own, scale=replace(own.scale, contacts=1000.0))
        assert "in place of" not in sentence(replace(found, answers=(every,)))


def test_an_assumed_damping_is_no_part_of_the_force_of_smooth_sliding() -> None:
    """F_k = 0.5, and the damping bears 0.02: of a machine's own one the spring's force is told, with its share."""
    slides = slips("mass", **(SMOOTH | {"before": 0.52, "after": 0.52}))
    assumed = sentence(told(replace(slides, damping=0.02), machine=HEAVY))
    more = "the spring's force is larger by 0.0200 N_c<k>·length, which the damping bears"
    assert f"smooth at 0.5000 N_c<k>·length ({more}), with an assumed damping of " in assumed
    given = sentence(told(slides, machine=replace(HEAVY, damping=0.02)))
    share = "0.0200 N_c<k>·length of it borne by the damping"
    assert f"smooth at 0.5200 N_c<k>·length ({share})" in given


def test_few_contacts_slip_above_k_star_and_not_on_far_stiffer_springs() -> None:
    """Thresholds of onset power 1 (K* = 0.035), N = 100: they slip on K = 0.4 (N K³ = 6), and not on 1.6 (400)."""
    contacts = Contacts(stats.rayleigh())
    smooth = slips("reset", kind="smooth", before=0.8, after=0.8, slips=0)
    for spring, kind in ((0.4, "stick-slip"), (1.6, "smooth")):
        machine = Machine(spring, None, 0.0, 1.0)
        assert follow_finite(machine, contacts, 100.0, smooth, 0.8, 1e4).kind == kind


def test_sliders_whose_slips_leave_all_contacts_new_are_followed_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside slips of infinitely many that go on they were followed twice as far, all from the begin; not where nobody
    knows whether those go on."""
    machine, number = Machine(1e-3, 1e-4, 6e-5, 1.0), 800
    contacts = Contacts(gaussian(1.0, 0.4), delay=Delay(5.0))
    asked, further = list[float](), finite.until_settled

    def counted(*each: Any) -> Any:
        asked.append(each[-1])
        return further(*each)

    monkeypatch.setattr(finite, "until_settled", counted)
    found = dict[bool, Finite]()
    for known in (True, False):
        known_of = slips("mass", before=0.6, after=-0.4, slips=4, contacts=None if known else 100)
        found[known] = follow_finite(machine, contacts, float(number), known_of, 0.56, 1e4)
        assert bool(asked) is not known
    once, more = found[True], found[False]
    assert once.kind == more.kind == "stick-slip" and once.slips < more.slips
    assert abs(once.before - more.before) < 2.0 * once.before_error < 0.1 * once.before


def test_of_other_readings_the_master_equation_has_most_of_the_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A thousand contacts take a moment, and know the force to 20 %; more of them took the time, and were given up."""
    given = list[float]()

    def solve(*arguments: Any, wall_time: float, **named: Any) -> None:
        given.append(wall_time)
        raise InputError("mass: is not solved")

    monkeypatch.setattr(master, "solve", solve)
    monkeypatch.setattr(following, "follow_by_contacts", lambda *each: not_followed("mass", ""))
    machine, known = Machine(1e-2, 1e-4, 2e-4, 1.0), RigidSlider(0.69, 0.52, 1e-9, 1.0, 4.0)
    contacts = Contacts(gaussian(1.0, 0.3), delay=Delay(5.0))
    for tolerance in (1e-3, following.WHETHER_IT_SLIPS):
        following.follow(machine, contacts, "mass", known, 1e4, tolerance_in_time=tolerance)
    assert given == pytest.approx([5e3, 8.5e3], rel=0.01)


def test_the_first_slip_is_that_of_the_contacts_whose_later_ones_are_told() -> None:
    """That of the thousand contacts which told before was told beside the slips of all half a million, 9 % too low."""
    machine, number = Machine(1e-2, 1e-3, 6e-4, 1.0), 8_000
    contacts = Contacts(gaussian(1.0, 0.4), delay=Delay(5.0))
    few = slips("mass", before=0.6, after=-0.4, slips=3, contacts=100)
    few = replace(few, in_time=SlipsOfMass(3.0, 1.0, 50.0, (0.5, -0.3), 0.1))
    many = follow_finite(machine, contacts, float(number), few, 0.56, 1e4)
    found = with_more(few, many, 1.0)
    asked = {"n_contacts": number, "n_replicas": 4, "seed": 7, **machine.keywords("mass")}
    seen = eq_model.simulate(contacts, np.linspace(0.0, 70.0, 70), **asked).slips
    assert found.contacts == number and seen.number.tolist() == [0] * 4
    first = found.in_time
    assert first.first_forces is not None and 0.0 < first.first_error < 0.005
    chance = seen.force_before.std(ddof=1) / 2.0
    off = 4.0 * np.hypot(first.first_error, chance)
    assert first.first_forces[0] == pytest.approx(seen.force_before.mean(), abs=off)
    assert first.first_forces[1] == pytest.approx(seen.force_after.mean(), abs=off)
    assert first.first_slip == pytest.approx(seen.drive.mean(), abs=100.0 * off)
    assert first.slip_time == pytest.approx(seen.duration.mean(), rel=0.05)
