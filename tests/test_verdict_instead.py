"""Where the master equation does not decide, and the ensemble follows all contacts of the area, its answer stands."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import eq_model
import master
from origins import Contacts, Delay, InputError, Thermal, gaussian
from tests.verdicts import MACHINE, RESET, STATED, infinite, judged
from toolkit.verdict.of_area import tells_instead, with_more
from toolkit.verdict.sliders.budget import OF_MOST, most_breaks, seconds_of
from toolkit.verdict.sliders.finite import follow_finite, told_by_another_rule
from toolkit.verdict.sliders.machine import Machine
from toolkit.verdict.sliders.records import Behaviour, Finite

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")

# of 2,000 contacts, with <k> = 5 N/m
FEW = MACHINE | {"spring": "0.5 N_c<k>", "area": 4e-9}
TOGETHER = 2000 * 5.0
LATE = "stopped by wall_time; neither force nor slips are known"


def not_solved(monkeypatch: Any, why: str = "") -> None:
    """No slider is solved: out of time, or `why` it is refused."""
    solve = master.solve

    def rough(*arguments: Any, **named: Any) -> Any:
        if why:
            raise InputError(f"mass: {why}")
        found = solve(*arguments, **named)
        undecided = replace(found.regime, verdict="undecided")
        return replace(
            found, regime=undecided, success=False, force_error=float("inf"), message=LATE
        )

    monkeypatch.setattr(master, "solve", rough)


def test_all_contacts_of_the_area_decide_where_the_master_equation_runs_out_of_time(
    capsys: Any, monkeypatch: Any
) -> None:
    """By the forces of other sliders; the status is that of an answer, and the page says who gave it."""
    not_solved(monkeypatch)
    status, page, found = judged(capsys, contacts=STATED, drive=FEW, verdict=RESET)
    (one,), (many,) = found["readings"][0]["behaviours"], found["finite"]
    assert status == 0 and found["success"]
    assert one["kind"] == many["kind"] == "stick-slip" and one["contacts"] == 2000
    assert one["before"] == many["before"] and one["period"] == many["period"]
    contacts, way = Contacts(gaussian(4e-9, 8e-10)), np.linspace(0.0, 2e-7, 101)
    others = eq_model.simulate(
        contacts, way, spring=0.5, slip="reset", n_contacts=2000, n_replicas=20, seed=7
    )
    late = others.slips.force_before[others.slips.number >= 4].mean() * TOGETHER
    assert abs(one["before"] - late) < 5.0 * many["before_error"] < 0.05 * late
    headline = page.splitlines()[2]
    said = "with the 2,000 contacts of the area, followed contact by contact: the master equation ran out of time"
    assert headline.startswith("stick-slip: ") and " ± " in headline and said in headline
    assert "not decided" not in page and "disagree" not in page
    assert (
        "4 sliders of 2,000 contacts" in page and "with what more contacts would change" not in page
    )
    assert re.search(r"^slips of 2,000 contacts, from \(reset\) +\d", page, re.M)


def test_all_contacts_of_the_area_slide_where_nobody_knows_what_infinitely_many_do(
    capsys: Any, monkeypatch: Any
) -> None:
    not_solved(monkeypatch)
    drive = FEW | {"spring": "20 N_c<k>", "area": 4e-8}
    status, page, found = judged(
        capsys, contacts=STATED, drive=drive, verdict={"rules": ["instant"]}
    )
    (one,) = found["readings"][0]["behaviours"]
    assert (status, one["kind"], one["contacts"]) == (0, "smooth", 20_000)
    assert one["before"] == pytest.approx(found["readings"][0]["kinetic"]["value"], rel=0.01)
    assert page.splitlines()[2].startswith("smooth")
    assert "with the 20,000 contacts of the area, followed contact by contact" in page


def test_of_a_mass_that_all_contacts_decide_no_slip_rule_is_told(
    capsys: Any, monkeypatch: Any
) -> None:
    """Nor anything else of a slider without it, but for what another delay would do."""
    not_solved(monkeypatch, why="takes 8001 steps")
    drive = FEW | {"mass": "1e-12 kg", "damping": "2e-4 N s/m", "velocity": 1e-5}
    status, page, found = judged(capsys, contacts=STATED, drive=drive)
    each = found["readings"][0]["behaviours"]
    assert status == 0 and [one["rule"] for one in each] == ["mass"]
    assert len(found["finite"]) == 1 and each[0]["kind"] == found["finite"][0]["kind"] != "unknown"
    assert "followed contact by contact: the master equation takes no such slider" in page
    assert "not decided" not in page and "a slip renews all contacts" not in page


@pytest.mark.parametrize("kind", ["unknown", "now and then"])
def test_contacts_that_do_not_decide_leave_it_open(kind: str) -> None:
    open_one = infinite("undecided", 0)
    told = Finite("reset", 500, "stick-slip", 0.8, 1e-3, 0.0, 1e-3, 12.0, period=1.5)
    assert tells_instead(open_one, told)
    for other in (
        replace(told, kind=kind),
        replace(told, message="as infinitely many do, and so the 9,000 of the area"),
        replace(told, kind="smooth", late=0.5, rises=True),
        replace(told, kind="smooth"),
    ):
        assert with_more(open_one, other, 1.0) is open_one
    # nor is one that is decided answered by others
    decided = infinite("smooth", 0)
    assert with_more(decided, told, 1.0) is decided


def test_a_slider_with_mass_that_still_rings_does_not_decide() -> None:
    """On a spring that is stiffer than all contacts, with hardly a damping; with a damping it slides at F_k + γv."""
    contacts, asked = Contacts(gaussian(1.0, 0.3)), replace(infinite("undecided", 0), rule="mass")
    machine = Machine(spring=5.0, mass=0.1, damping=1e-4, velocity=1.0)
    rings = follow_finite(machine, contacts, 2000, asked, 0.7, 1e4)
    slides = follow_finite(replace(machine, damping=0.5), contacts, 2000, asked, 0.7, 1e4)
    assert slides.kind == "smooth" and not slides.message
    kinetic = master.steady_state(contacts, velocity=1.0).force
    assert abs(slides.late - kinetic - 0.5) < max(4.0 * slides.late_error, 2e-3)
    assert rings.kind == "unknown" and "longer to die away than their way" in rings.message


def test_sliders_of_the_area_are_followed_once_where_slip_rules_do_the_same() -> None:
    """In heat that lets nobody slip no rule acts, and where each slip leaves no force contacts begin anew by both rules
    that renew them; elsewhere, and of contacts that wait, each rule is followed."""
    warm = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.02, 100.0))
    cold = Contacts(gaussian(1.0, 0.2))
    smooth, slips = infinite("smooth", 0), replace(infinite("stick-slip", 5), before=0.8, after=0.0)
    slid = Finite("reset", 500, "smooth", late=0.5, late_error=1e-3)
    stuck = Finite("reset", 500, "stick-slip", 0.8, 1e-3, 0.0, 0.0, 12.0, period=1.5)
    late = Finite("reset", 500, "unknown", message="take more than 4 s")

    def told(kind: Behaviour, rule: str, seen: Finite, contacts: Contacts) -> Finite | None:
        first = replace(kind, rule="reset")
        return told_by_another_rule(replace(kind, rule=rule), [(first, seen)], contacts)

    for rule in ("reform-after", "instant"):
        assert told(smooth, rule, slid, warm) == replace(slid, rule=rule)
        assert told(smooth, rule, late, warm) == replace(late, rule=rule)
        assert told(smooth, rule, slid, cold) is None
        assert told(smooth, rule, replace(slid, slips=0.25), warm) is None
        assert told(replace(smooth, slips=1), rule, slid, warm) is None
    assert told(slips, "reform-after", stuck, cold) == replace(stuck, rule="reform-after")
    assert told(slips, "instant", stuck, cold) is None
    assert told(slips, "reform-after", replace(stuck, after=0.1), cold) is None
    assert told(replace(slips, after=0.1), "reform-after", stuck, cold) is None
    assert told(slips, "reform-after", stuck, cold.replace(delay=Delay(1.0))) is None
    # which is right: both fall alike
    way, each = np.linspace(0.0, 60.0, 31), list[Any]()
    for rule in ("reset", "reform-after"):
        each.append(eq_model.simulate(cold, way, spring=0.05, slip=rule, n_contacts=500, seed=3))
    drops = [one.slips.drop.mean() for one in each]
    assert all((one.slips.force_after == 0.0).all() for one in each)
    assert abs(drops[0] - drops[1]) < 0.02


def test_a_short_pilot_in_heat_counts_by_its_time() -> None:
    """Of a slider that creeps moves cost more than breaks; no more than DEAREST times as much, as a machine is busy."""
    cold = Contacts(gaussian(1.0, 0.2))
    warm = cold.replace(thermal=Thermal("eyring", width=0.03))
    usual = OF_MOST * 1e5 / most_breaks(warm, "reset")
    for took, counted in (
        (0.1 * usual, usual),
        (3.0 * usual, 3.0 * usual),
        (9.0 * usual, 5.0 * usual),
    ):
        assert seconds_of(1e5, warm, "reset", took) == pytest.approx(counted)
    cheap = OF_MOST * 1e5 / most_breaks(cold, "reset")
    assert seconds_of(1e5, cold, "reset", 1.9) == cheap
    assert seconds_of(1e5, cold, "reset", 2.1) == seconds_of(1e5, warm, "reset", 2.1) == 2.1
