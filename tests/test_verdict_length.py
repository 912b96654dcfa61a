"""What the page of `mesofriction verdict` has under "What it hangs on", and what verdict.json has of it."""

from dataclasses import replace

import pytest

import toolkit
from tests.verdicts import slips, told
from toolkit.scene.interfaces import NUMERICAL_ONLY
from toolkit.verdict.answers import Quantity, Verdict
from toolkit.verdict.files import plain
from toolkit.verdict.judge import verdict
from toolkit.verdict.sliders.records import Finite
from toolkit.verdict.text import hangs_on
from toolkit.verdict.text.kinds import GENERAL, NOTHING, TURNS, Line
from toolkit.verdict.text.words import page

HEAD = "What it hangs on"


def lines_of(verdict: Verdict) -> list[str]:
    """The lines of its page below HEAD."""
    text = page(verdict)
    at = text.index(HEAD)
    return [line.strip() for line in text[at + 1 : text.index("", at)]]


def many_lines(number: int) -> list[Line]:
    """So many lines, the last of which change least."""
    return [Line(1.0 / n, f"line {n}", f" as reason {n}") for n in range(1, number + 1)]


def test_what_errors_leave_out_is_no_line_beside_the_range_over_readings() -> None:
    """It stood below that range, which tells it in numbers; of one reading it stays, and verdict.json has it."""
    scene = toolkit.load_scene(
        "rough-gw-amontons",
        changes={"verdict": {"readings": ["gw/amontons", "gw/strength"], "steps": [1]}},
    )
    found = verdict(scene)
    assert len(found.answers) > 1 and NUMERICAL_ONLY in plain(found)["hangs_on"]
    assert NUMERICAL_ONLY not in lines_of(found)
    alone = replace(found, answers=found.answers[:1])
    assert NUMERICAL_ONLY in lines_of(alone)


def test_a_page_has_eight_lines_and_a_file_has_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twelve stood below the answer on a scan at 300 K, the reasons of each in it."""
    found = told(slips("reset"))
    monkeypatch.setattr(hangs_on, "unanswered", lambda verdict: iter(many_lines(11)))
    *shown, where = lines_of(found)
    assert shown == [f"line {n}" for n in range(1, 9)]
    assert where == "verdict.json (hangs_on) has 3 more lines and the reasons of these"
    assert plain(found)["hangs_on"] == [f"line {n} as reason {n}" for n in range(1, 12)]
    monkeypatch.setattr(hangs_on, "unanswered", lambda verdict: iter([Line(1.0, "alone")]))
    assert lines_of(found) == ["alone"]


def test_what_decides_comes_first_then_the_readings_then_what_was_assumed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    each = (
        Line(NOTHING, "not this"),
        Line(GENERAL, "of all"),
        Line(0.9, "assumed"),
        Line(0.3, "readings", of_readings=True),
        Line(TURNS, "decides"),
    )
    monkeypatch.setattr(hangs_on, "unanswered", lambda verdict: iter(each))
    found = told(slips("reset"))
    assert lines_of(found) == ["decides", "readings", "assumed", "of all", "not this"]


def test_what_the_answer_tells_of_the_areas_contacts_is_not_told_again() -> None:
    """Forces that differ from those of infinitely many stood in the answer, in the table and here; alike they stand
    here alone."""
    for before, again in ((0.4, False), (0.6, True)):
        few = Finite("reset", 500, "stick-slip", before, 1e-3, 0.0, 1e-3, 9.0, period=60.0)
        found = replace(told(slips("reset")), finite=(few,))
        said = "\n".join(page(found)).partition(HEAD)
        assert ("500 contacts of the area" in said[0] or "500 contacts of [eq]" in said[0]) is not (
            again
        )
        assert ("500 contacts: stick-slip" in said[2] or "500 contacts, if" in said[2]) is again
        assert any(line.startswith("500 contacts, if") for line in plain(found)["hangs_on"])


def test_a_doubt_before_the_answer_is_not_told_again(monkeypatch: pytest.MonkeyPatch) -> None:
    found = told(slips("reset"), kinetic=Quantity(0.5, 1e-9))
    monkeypatch.setattr(hangs_on, "remarks", lambda law, machine: ["is this meant?", "a remark"])
    monkeypatch.setattr(hangs_on, "doubts", lambda contacts: ["is this meant? take that"])
    assert "a remark" in lines_of(found) and "is this meant?" not in lines_of(found)
    assert "is this meant?" in plain(found)["hangs_on"]


def test_contacts_that_tell_the_answer_are_not_told_again() -> None:
    """As many of them as stand for those of the area in the answer, followed once more."""
    one = slips("reset", contacts=500, message="by the ensemble")
    few = Finite("reset", 500, "stick-slip", 0.6, 1e-3, 0.0, 1e-3, 9.0, message="too many breaks")
    for number, again in ((500, False), (900, True)):
        found = replace(told(one), finite=(replace(few, contacts=number),))
        start = f"{number} contacts, if"
        assert any(line.startswith(start) for line in lines_of(found)) is again
        assert any(line.startswith(start) for line in plain(found)["hangs_on"])
