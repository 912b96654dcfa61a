"""Faults planted in the program: what is solved then fails, and its message says where to look."""

import re
from functools import cache

import numpy as np
import pytest
from conftest import slow

import master
import origins
from master import rigid
from master.motion import Motion
from master.outcome import FaultError
from master.renewal.births import BirthPanels, Births, reforming_law
from master.renewal.earlier_legs import EarlierLegs
from master.renewal.march import March
from master.renewal.past import Past
from master.renewal.solved import SolvedPanels
from master.soft.followed import ErrorPart, Followed
from master.soft.in_time import breaks, slip_ends
from master.soft.in_time.breaks import BirthsUpTo, BreaksInSteps
from master.soft.in_time.groups import Groups
from master.soft.in_time.slider import Node, Slider
from master.soft.slips import slips_of
from master.survival.life import ColdLife
from origins import Contacts, Delay, Drive


def test_a_jump_where_no_edge_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """One contact in a hundred breaks at X = 1, and no panel is told to end there."""
    true = rigid.edges

    def without_the_break(*given):
        plan = true(*given)
        times = plan.times
        return plan._replace(times=times[(times < 0.9) | (times > 1.1)])

    parts = [origins.identical(1.0), origins.gaussian(2.0, 0.2)]
    contacts, path = Contacts(origins.mixture(parts, [0.01, 0.99])), [0.4, 1.3]
    assert master.solve(contacts, path, tolerance=1e-10).success
    monkeypatch.setattr(rigid, "edges", without_the_break)
    found = master.solve(contacts, path, tolerance=1e-10)
    said = found.message
    assert not found.success and "of a panel near X = 1: the number of contacts jumps by " in said
    assert (
        "at a travel of 1, on leg 0 (from 0), where no edge is, or a sum over births is wrong"
        in said
    )


@pytest.mark.parametrize("place", [0.99, 1.06])
def test_a_jump_is_told_where_the_panel_begins_whose_error_it_is(place: float) -> None:
    """Of the batch of panels that is here the second; the begin of the first was told."""
    parts = [origins.identical(place), origins.gaussian(2.0, 0.2)]
    contacts = Contacts(origins.mixture(parts, [0.01, 0.99]))
    march = rigid.march_of(contacts, Motion.along(np.array([0.0, 1.3])), ColdLife(contacts), 1e-10)
    march.edges = march.edges[np.abs(march.edges - place) > 0.05]
    (jump,), solved = march.run().jumps, march.solved
    panel = int(solved.error.argmax())
    assert solved.error[panel] == jump.size > march.tolerance
    assert abs(jump.time - solved.begin[panel]) < 1e-3 * solved.width[panel]


def test_a_jump_right_behind_an_edge(monkeypatch: pytest.MonkeyPatch) -> None:
    """Contacts that are still out one cycle later are left out, first where the slider has turned."""
    contacts, path = Contacts(origins.gaussian(1.0, 0.2), delay=Delay(1.5)), [3.0, 4.0, 5.0, 2.0]
    assert master.solve(contacts, path, tolerance=1e-6).success
    true = March.longest_cycle
    monkeypatch.setattr(March, "longest_cycle", lambda self, leg: true(self, leg) - 1.5)
    found = master.solve(contacts, path, tolerance=1e-6)
    assert not found.success and "right behind an edge: a sum over births is wrong" in found.message


def test_of_two_jumps_where_no_edges_are_the_larger_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One contact in ten thousand breaks at X = 1, one in a hundred at X = 1.3; the larger jump may be either."""
    true = rigid.edges

    def without_the_breaks(*given):
        plan = true(*given)
        times = plan.times
        return plan._replace(times=times[(times < 0.9) | (times > 1.4)])

    monkeypatch.setattr(rigid, "edges", without_the_breaks)
    for shares, larger in (([1e-4, 0.01, 0.9899], r"1\.3"), ([0.01, 1e-4, 0.9899], r"1(\.0)?")):
        parts = [origins.identical(1.0), origins.identical(1.3), origins.gaussian(2.0, 0.1)]
        found = master.solve(Contacts(origins.mixture(parts, shares)), [0.4, 1.5], tolerance=1e-6)
        told = rf"of a panel near X = {larger}\d*: the number of contacts jumps by "
        assert not found.success and re.search(told, found.message)


def test_a_gap_between_panels(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second run of panels begins one width too late."""
    true, runs = SolvedPanels.append, list[float]()

    def late(self, run, good, *, begin, breaks_begin_own_leg, width):
        runs.append(begin)
        later = begin + width * (len(runs) == 2)
        true(self, run, good, begin=later, breaks_begin_own_leg=breaks_begin_own_leg, width=width)

    monkeypatch.setattr(SolvedPanels, "append", late)
    found = master.solve(Contacts(origins.gaussian(1.0, 0.1)), [1.5, 0.5])
    assert len(runs) == 2 and not found.success and found.force_error == np.inf
    assert "number is not conserved: panels end at t = " in found.message


@pytest.mark.parametrize(
    ("law", "drive"),
    [
        ({}, {}),
        ({"delay": origins.Delay(0.1)}, {"velocity": 1.0}),
        ({"ageing": origins.Ageing(origins.gaussian(1.2, 0.1), 1e-3)}, {"velocity": 1.0}),
    ],
    ids=["no law", "delay", "ageing"],
)
def test_births_out_of_order(monkeypatch: pytest.MonkeyPatch, law, drive) -> None:
    """Births of the legs before count their times backwards."""
    true = SolvedPanels.births
    monkeypatch.setattr(SolvedPanels, "births", lambda self, begin: true(self, begin[-1:] - begin))
    contacts = Contacts(origins.gaussian(1.0, 0.1), **law)
    found = master.solve(contacts, [1.5, 0.5], wall_time=60.0, **drive)
    assert not found.success and found.force_error == np.inf
    assert "births are out of order: on the panel that begins at t = 0" in found.message


def test_births_whose_bends_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a turn, births that hold were left out with the piece they are on: F off by 2e-3, told as 2e-8."""
    contacts, path = Contacts(origins.rectangular(0.8, 1.2), delay=Delay(0.15)), [1.4, -1.3, 0.7]
    assert master.solve(contacts, path, tolerance=1e-6).success
    true = EarlierLegs.bends_of_births
    monkeypatch.setattr(EarlierLegs, "bends_of_births", lambda self, t, born: -true(self, t, born))
    said = master.solve(contacts, path, tolerance=1e-6).message
    assert re.search(
        "of the births between .* after leg 1 begins some hold, where all do or none", said
    )


def test_bends_of_births_on_a_way_up_as_seen_from_the_way_down() -> None:
    """The example of EarlierLegs.bends_of_births, by hand."""
    contacts = Contacts(origins.rectangular(0.0, 0.6))
    motion = Motion.along(np.array([0.0, 1.0, 0.0]))
    births = Births(ColdLife(contacts), reforming_law(contacts), motion)
    one_panel = BirthPanels(np.array([0.0, 1.0]), np.ones((1, 1)))
    legs = EarlierLegs(births, motion, 1, np.array([0]), one_panel, 1e-9)
    bends = np.unique(legs.bends_of_births(np.array([1.5]), 0.0).round(12))
    assert {0.4, 0.5, 0.75, 1.0, 1.1} <= set(bends.tolist())
    pieces = legs.pieces_of_births(np.array([1.5]))
    assert pieces.low == pytest.approx([0.4, 0.5, 0.75], abs=1e-12)  # those before are out
    assert pieces.high == pytest.approx([0.5, 0.75, 1.0], abs=1e-12)


def test_a_leg_that_is_not_entered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Behind the turn births of the first leg still count as of the present one, whose survival is another."""
    true = Past.enter
    monkeypatch.setattr(Past, "enter", lambda self, leg, solved: true(self, 0, solved))
    found = master.solve(Contacts(origins.gaussian(1.0, 0.1)), [1.5, 0.5])
    assert not found.success and found.force_error == np.inf
    assert "sums are asked for on leg 1 while leg 0 is entered, a fault" in found.message


def test_a_turn_where_no_edge_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Panels go on across the turn at the travel 1.5, as if the slider had not turned."""
    true = rigid.edges

    def without_the_turn(*given):
        plan = true(*given)
        return plan._replace(times=plan.times[plan.times != 1.5])

    monkeypatch.setattr(rigid, "edges", without_the_turn)
    found = master.solve(Contacts(origins.gaussian(1.0, 0.1)), [1.5, 0.5])
    assert not found.success and found.force_error == np.inf
    told = "panels are on two legs: no edge is between t = 0 and 2.5, but leg 0 (from 0) is from 0 to 1.5, a fault"
    assert told in found.message


@pytest.mark.parametrize(
    ("off", "told"),
    [(-1, r"begin at -0\.\d+ on the clock of their leg"), (1, r"end at 0\.\d+ of leg 1")],
)
def test_births_on_a_wrong_leg(monkeypatch: pytest.MonkeyPatch, off: int, told: str) -> None:
    """A panel too few, or one too many, has its births on the legs before the one after the turn: without a check an
    answer that was off by 0.18 called itself good to 7e-12."""
    true = Past.count_before

    def wrong(self, solved):
        count = true(self, solved)
        return count + off if count > 0 else 0

    monkeypatch.setattr(Past, "count_before", wrong)
    contacts = Contacts(origins.gaussian(1.0, 0.2), delay=Delay(1.5))
    found = master.solve(contacts, [3.0, 4.0, 5.0, 2.0], tolerance=1e-6)
    assert not found.success and found.force_error == np.inf
    assert re.search(
        "births are on a wrong leg: on the panel that begins at .* they " + told, found.message
    )


@pytest.mark.parametrize(
    ("most", "error", "fault"),
    [
        (1.0005, 0.0, ""),
        (1.007, 1e-4, "reaches 1.007, above the tolerance 1.0e-03; take a smaller one"),
        (1.007, 1e-3, ""),
        (1.07, 1e-3, "reaches 1.07, a fault of the program"),
        (1.07, 0.3, "reaches 1.07, a fault of the program"),
        (1.07, np.inf, ""),
    ],
)
def test_a_number_that_is_not_conserved(most: float, error: float, fault: str) -> None:
    """More contacts hold than there are, beyond the tolerance of 1e-3 and ten times the error, but for an error that
    judges nothing; of coarse steps alone, whose error is not known, as `wall_time` ends the work, that is no fault."""
    holding, none = np.array([0.9, most]), slips_of(np.empty((3, 0)), 0.3, 0.0)
    parts = (ErrorPart("planted", 1e-6),)
    of_holding = ErrorPart("planted", error)
    found = Followed(0.0, holding, holding, none, 1e-6, 10, parts, of_holding=of_holding)
    contacts = Contacts(origins.gaussian(1.0, 0.1))
    success, said = found.outcome(contacts, Drive([1.0, 2.0], spring=0.3), 1e-3, "X_T")
    told = f"number is not conserved: holding {fault}"
    assert (said == told) == bool(fault) and success == (not fault and error <= 1e-3)


def test_the_largest_part_of_an_error_is_named() -> None:
    found = master.solve(Contacts(origins.gaussian(1.0, 0.2)), [1.0, 2.0, -1.0], tolerance=1e-15)
    assert not found.success and "most of it that of " in found.message


IN_TIME = "master.soft.in_time."
LATE = Contacts(origins.gaussian(1.0, 0.2), delay=origins.Delay(0.25))
# a constant of the program, a value that plants an error, and what the message then says of the largest part; the drive
# slips at X_T = 3.07771 and ends at 4.2
PLANTED: dict[str, tuple[str, float, str]] = {
    "memory": ("memory.ThresholdMemory.error", 0.02, "the memory of the contacts' history; loosen"),
    "rounding": ("answer.extrapolation.ROUNDING", 1e-4, r"rounding in \d+ steps; loosen"),
    "small slips": ("refining.UNLISTED", 1e6, r"slips that are too small to be .*X_T = 3\.0777"),
    "births": ("unresolved.UNKNOWN_BELOW", 1.0, "births of one step, of which many break before"),
    "near slips": (
        "answer.near_slip.NEAR",
        1e12,
        r"a slip that may come .*X_T = 4\.2; turn or end the",
    ),
    "steps": (
        "steps.balance.MOST_SECANTS",
        3,
        "steps, by which F and loads at slips changed as they",
    ),
}


def test_a_stretch_beyond_the_largest_names_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without |x| the largest stretch forgets those against X: F was off by 0.01 behind a turn, to 8e-6 as it said."""
    true = Groups.moved

    def without_abs(self: Groups, memory, travel: float, duration: float) -> Groups:
        moved = true(self, memory, travel, duration)
        return moved._replace(largest=np.maximum(self.largest, moved.stretch))

    monkeypatch.setattr(Groups, "moved", without_abs)
    found = master.solve(LATE, [1.0, -0.6], 1e-2, velocity=1.0, spring=2.0)
    assert not found.success and found.force_error == np.inf
    assert re.search("contacts are stretched by -.*, and were by at most .* a fault", found.message)


def test_a_cubic_that_misses_the_steps_names_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its places are twice what they are: breaks were read by straight lines, and only the error was larger."""
    true = breaks.polynomial_through
    monkeypatch.setattr(
        breaks, "polynomial_through", lambda at, values: true([2 * a for a in at], values)
    )
    found = master.solve(LATE, [1.0], 1e-2, velocity=1.0, spring=2.0)
    assert not found.success and found.force_error == np.inf
    assert "the cubic through past steps that is read at t = " in found.message


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_births_that_are_not_the_breaks_one_delay_before_name_themselves(
    monkeypatch: pytest.MonkeyPatch, factor: float
) -> None:
    """A tenth too few, or too many: the number is conserved all the same, with other breaks."""
    true = BreaksInSteps.births_up_to

    def wrong(self: BreaksInSteps, *, begin: float, end: float) -> BirthsUpTo:
        of = true(self, begin=begin, end=end)
        return BirthsUpTo(factor * of.per_break, factor * of.rest)

    monkeypatch.setattr(BreaksInSteps, "births_up_to", wrong)
    found = master.solve(LATE, [1.5, 2.5], 1e-2, velocity=1.0, spring=2.0)
    assert not found.success and found.force_error == np.inf
    assert re.search("births are not the breaks one delay before: up to t = ", found.message)


@pytest.mark.parametrize(
    ("method", "told"),
    [
        ("repeat_jump", r"births jump amid a step, from .* as breaks did by 0\.\d+ at t = 3\.07"),
        ("take_due", r"births do not repeat a jump of breaks: .* behind the slip at t = 3\.07"),
    ],
)
def test_births_that_do_not_repeat_a_slip_name_themselves(
    monkeypatch: pytest.MonkeyPatch, method: str, told: str
) -> None:
    """A jump of breaks is forgotten, or its births are taken for those that break: contacts came back on the steps
    that followed, by which F was off by 7e-5, as its error said."""
    true = getattr(BreaksInSteps, method)

    def wrong(self: BreaksInSteps, at: float) -> float | None:
        return -true(self, at) if method == "take_due" else self.repeat_bend(at + 1.0)

    monkeypatch.setattr(BreaksInSteps, method, wrong)
    found = master.solve(LATE, [4.2], 1e-2, velocity=1.0, spring=0.3, slip="reform-after")
    assert not found.success and found.force_error == np.inf
    assert re.search(told, found.message)


def node_beside_the_slider(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes, from which answers are read, are not where the slider is."""
    true = Slider.node_now

    def wrong(self: Slider, sizes_so_far: float) -> Node:
        node = true(self, sizes_so_far)
        return node._replace(position=node.position + 1e-6)

    monkeypatch.setattr(Slider, "node_now", wrong)


def reset_beside_the_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a reset the slider stops where the spring would balance another force."""
    true = Slider.slip
    monkeypatch.setattr(Slider, "slip", lambda self, drive: true(self, drive + 1e-6))


def slip_too_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """A slip goes on behind its balance."""
    true = slip_ends.travel_to_balance

    def wrong(contacts, steps):
        travel, imbalance = true(contacts, steps)
        return 1.001 * travel, imbalance

    monkeypatch.setattr(slip_ends, "travel_to_balance", wrong)


@pytest.mark.parametrize(
    ("plant", "slip", "told"),
    [
        (node_beside_the_slider, "reform-after", r"a step to t = 0\.\d+, X = "),
        (reset_beside_the_drive, "reset", r"a slip to t = 3\.07\d*, X = "),
        (slip_too_far, "reform-after", r"a slip to t = 3\.07\d*, X = "),
    ],
)
def test_forces_that_do_not_balance_name_themselves(monkeypatch, plant, slip, told) -> None:
    """Each gave another X or F, by more than the error told."""
    plant(monkeypatch)
    found = master.solve(LATE, [4.2], 1e-2, velocity=1.0, spring=0.3, slip=slip)
    assert not found.success and found.force_error == np.inf
    assert re.search("the forces do not balance after " + told, found.message)


@cache
def sound() -> master.Solution:
    """Without a fault; solved once, as all tests below have the same MOST_STEPS."""
    return master.solve(LATE, np.linspace(0.0, 4.2, 9), 1e-3, spring=0.3, slip="reform-after")


@pytest.mark.parametrize(
    "name",
    [slow(name, when=name in ("memory", "near slips", "steps", "rounding")) for name in PLANTED],
)
def test_the_largest_part_of_an_error_under_a_spring_is_named(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    constant, value, told = PLANTED[name]
    drive = {"spring": 0.3, "slip": "reform-after"}
    monkeypatch.setattr(f"{IN_TIME}refining.MOST_STEPS", 300)  # two halvings tell it
    assert sound().success, sound().message
    tolerance = 1e-4 if name == "births" else 1e-3
    monkeypatch.setattr(f"{IN_TIME}{constant}", value)
    found = master.solve(LATE, np.linspace(0.0, 4.2, 9), tolerance, **drive)
    assert not found.success
    assert re.search(f"above the tolerance 1.0e-0[34], most of it that of {told}", found.message)
    limited = "steps are not halved again, which takes 4" in found.message
    assert limited == (name != "memory"), found.message


def test_an_error_of_which_a_part_is_unknown_says_which() -> None:
    """And the parts at T = 0, of which the largest is the error."""
    contacts, far = Contacts(origins.gaussian(1.0, 0.1)), np.array([5.0, 10.0])
    found = master.solve(contacts, far, 1e-16, spring=0.3)
    assert not found.success and "most of it that of X_T at slips; shorten the" in found.message
    parts = ErrorPart("what is known", 0.5), ErrorPart("what is not", np.inf, "do less")
    holding, none = np.ones(2), slips_of(np.empty((3, 0)), 0.3, 0.0)
    unknown = Followed(0.0, holding, holding, none, np.inf, 10, parts)
    success, said = unknown.outcome(contacts, Drive([1.0, 2.0], spring=0.3), 1e-3, "X_T")
    why = "no error is known without that of what is not; do less"
    assert not success and said == f"neither force nor slips are known: {why}"


def test_a_motion_that_lasts_no_time_says_so() -> None:
    """Its speed was 0/0, of which numpy warned."""
    with pytest.raises(
        FaultError, match=r"all knots of a motion are at t = 3, a fault of the program"
    ):
        Motion(np.array([3.0, 3.0]), np.array([0.0, 1.0]))
