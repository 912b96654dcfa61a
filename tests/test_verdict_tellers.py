"""What one teller says of a slider is replaced as a whole where another one tells in its place."""

from dataclasses import fields, replace
from typing import get_type_hints

import numpy as np

from master.soft.inertia.run import SlipsInTime
from origins import Contacts, gaussian
from tests.verdicts import SOFT, infinite, rigid, told
from toolkit.verdict.legend import UNITS
from toolkit.verdict.of_area import with_more
from toolkit.verdict.sliders.forgetting import after_forgetting
from toolkit.verdict.sliders.records import AS_ASKED, Behaviour, Finite
from toolkit.verdict.sliders.slips_in_time import SlipsOfMass, slips_in_time
from toolkit.verdict.slips_in_words import swinging
from toolkit.verdict.uncertainty import once_over

WIDE = Contacts(gaussian(1.0, 0.2))
# all that a teller may say beside the forces, of a slider that was not decided
SAID = replace(
    infinite("undecided", 11),
    rule="instant",
    shrinks_by=0.06,
    left=0.3,
    swings=(0.3, 0.7),
    smaller=4,
    few_break=0.01,
    period=9.0,
    period_error=1.0,
    in_time=SlipsOfMass(3.0, 1.0, 50.0, (0.5, -0.3), 0.1),
    cut=True,
    damping=0.2,
    delay=0.5,
    unstable_below=0.01,
    slip_drive=np.ones(3),
    slip_force=np.ones(3),
    drive=np.ones(3),
    force=np.ones(3),
)


def kept(told: Behaviour, seen: Behaviour) -> set[str]:
    """Fields with which this one says what the other one did, though they are no usual ones."""
    names = {one.name for one in fields(Behaviour)} - {*AS_ASKED, "kind", "message"}
    usual = infinite("smooth", 0)
    same = {one for one in names if np.array_equal(getattr(told, one), getattr(seen, one))}
    return {one for one in same if not np.array_equal(getattr(told, one), getattr(usual, one))}


def test_no_number_of_the_one_stands_beside_numbers_of_another() -> None:
    """Sliders of all contacts that slide told the swings and the dying slips of infinitely many as their own."""
    slid = Finite("instant", 500, "smooth", late=0.55, late_error=1e-3, slips=2.0)
    told = with_more(SAID, slid, 1.0)
    assert told.kind == "smooth" and (told.before, told.slips) == (0.55, 2)
    assert not kept(told, SAID) and told.in_time == SlipsOfMass()
    assert {one: getattr(told, one) for one in AS_ASKED} == {
        one: getattr(SAID, one) for one in AS_ASKED
    }
    over = after_forgetting(SOFT, WIDE, rigid(WIDE), SAID)
    assert over.kind == "smooth" and not kept(over, SAID)


def test_a_smooth_slider_tells_no_swings_of_another() -> None:
    slid = Finite("instant", 500, "smooth", late=0.55, late_error=1e-3, slips=2.0)
    own = told(with_more(SAID, slid, 1.0)).own
    assert not swinging(own, own.behaviours[0]) and not once_over(own, own.behaviours[0])


def test_each_number_of_a_record_has_its_unit() -> None:
    """A number without one would be written to verdict.json in the units of the solvers."""
    words = {"rule", "kind", "message", "success", "cut", "refused", "instead", "rises"}
    parts = {"drive", "force", "slip_drive", "slip_force", "in_time", "finite"}
    for record in (Behaviour, Finite, SlipsOfMass):
        names = {one.name for one in fields(record)}
        assert names - words - parts <= UNITS.keys(), names - words - parts - UNITS.keys()
        assert not any(get_type_hints(record)[one] is float for one in names & (words | parts))


def test_a_slip_of_a_solution_takes_the_time_of_its_last_main_one() -> None:
    """Its forces are those of that slip, too; a small one followed it, and was told with its own time and speed."""
    two = {"before": np.zeros(2), "after": np.zeros(2), "drive_error": 0.0, "time": np.zeros(2)}
    forces = {"force_before": np.array([0.6, 0.5]), "force_after": np.array([-0.4, 0.45])}
    motion = {"duration": np.array([3.0, 0.1]), "top_speed": np.array([8.0, 0.2])}
    found = slips_in_time(SlipsInTime(np.array([50.0, 60.0]), **two, **forces, **motion))
    assert found == SlipsOfMass(3.0, 8.0, 50.0, (0.6, -0.4), 0.0)
