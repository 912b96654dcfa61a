"""Slips that shrink: those that die out end in steady sliding at F_k, those that shrink ever less go on."""

import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import slow

import eq_model
import master
from master.soft.followed import ErrorPart, Followed
from master.soft.regime import LASTING, Regime, regime
from master.soft.slips import Slips
from origins import Contacts, Delay, gaussian, identical, mixture
from origins.drive import Drive
from toolkit.results.slips import are_fading, main_slips, shrinks_by
from toolkit.verdict.sliders.finite import follow_finite
from toolkit.verdict.sliders.follow import follow
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour

NARROW = Contacts(gaussian(1.0, 0.05))


def known_of(contacts: Contacts) -> RigidSlider:
    """F_s, F_k, K* and the decoherence length of these contacts."""
    found, steady = master.propensity(contacts, 1e-6), master.steady_state(contacts)
    static = found.static_to_kinetic * steady.force
    return RigidSlider(static, steady.force, 1e-9, found.critical_spring, found.decoherence_length)


def followed(spring: float, contacts: Contacts = NARROW) -> tuple[Machine, RigidSlider, Behaviour]:
    """What infinitely many contacts that re-form at once do on this spring."""
    machine, known = Machine(spring, None, 0.0, 1.0), known_of(contacts)
    return machine, known, follow(machine, contacts, "instant", known, wall_time=1e4)


def slips_of(drops: list[list[float]]) -> Any:
    """Slips of sliders with these drops."""
    replica = np.repeat(np.arange(len(drops)), [len(one) for one in drops])
    return SimpleNamespace(replica=replica, drop=np.concatenate(drops))


@pytest.mark.parametrize("spring", [0.5, 4.0])
def test_narrow_thresholds_slide_at_the_kinetic_force(spring: float) -> None:
    """Contacts that began together keep their step for tens of thresholds: at the path's end the force still swings by
    0.3 to 0.5 about F_k = <x²>/2<x>, at which they slide in the end."""
    _, _, found = followed(spring)
    law = NARROW.thresholds
    exact = law.moment(2) / (2.0 * law.mean())
    assert found.kind == "smooth" and np.ptp(found.force[-120:]) > 0.25
    assert found.before == found.after == pytest.approx(exact, rel=1e-6)
    assert abs(found.force[-1] - exact) > 0.05
    # that swing is told by its ends, and is no error of F_k: "smooth at 0.50 ± 0.30" was told
    assert found.error < 1e-5 and found.swings is not None
    low, high = found.swings
    assert low < exact - 0.05 and exact + 0.05 < high


def test_exact_thresholds_that_keep_their_order_have_the_swing_in_their_error() -> None:
    """A fifth of the contacts breaks at one value, and may keep its step for ever: the error reaches to F_k."""
    contacts = Contacts(mixture([gaussian(1.0, 0.1), identical(1.0)], [0.8, 0.2]))
    _, known, found = followed(4.0, contacts)
    assert found.kind == "smooth"
    assert 0.05 < abs(found.before - known.kinetic) < found.error


def test_chance_that_gives_a_slip_more_is_no_other_answer() -> None:
    """Of 2,000 contacts some slip once more than infinitely many, and slide then as these do; on a softer spring slips
    go on up to the end of the way, shrinking as those of infinitely many."""
    machine, known, told = followed(2.0)
    found = follow_finite(machine, NARROW, 2000.0, told, known.static, 1e4)
    assert found.kind == "smooth" and found.late == pytest.approx(known.kinetic, abs=0.01)
    machine, known, told = followed(0.5)
    found = follow_finite(machine, NARROW, 2000.0, told, known.static, 1e4)
    assert found.kind == "unknown" and "2,000 contacts slip ever less, by 0.1" in found.message


def test_slips_that_shrink_are_told_from_those_that_scatter() -> None:
    rng = np.random.default_rng(1)
    shrinking = [list(0.9 ** np.arange(12.0) * rng.normal(1.0, 0.02, 12)) for _ in range(4)]
    steady = [list(rng.normal(1.0, 0.2, 12)) for _ in range(4)]
    # the first slip is larger, as contacts began together
    first = [[2.0, *one] for one in steady]
    told = [are_fading(slips_of(one)) for one in (shrinking, steady, first, shrinking[:1])]
    assert told == [True, False, False, True]
    assert not are_fading(slips_of([one[:8] for one in shrinking]))


@pytest.mark.slow
def test_drops_that_shrink_ever_less_are_no_end_of_the_slips() -> None:
    """Contacts that wait for one length of the drive's way, a mass: the first drops shrink by 1.1, 0.4 and 0.25 %, and
    the 14th is as large as the 13th."""
    contacts = NARROW.replace(delay=Delay(1.0))
    pulled: dict[str, Any] = {"spring": 1.0, "mass": 1e-3, "damping": 0.01, "velocity": 1.0}
    short, long = (master.solve(contacts, [0.0, end], 1e-3, **pulled) for end in (12.3, 25.0))
    assert short.regime.slips == 4 and short.regime.trend < -1e-3
    assert short.regime.verdict == "undecided"
    assert (
        "fade ever less, perhaps to 1.36;" in short.regime.reason and short.regime.drive_to > 12.3
    )
    assert long.regime.verdict == "stick-slip" and long.slips.drop[-1] > 1.3
    assert long.slips.drop[-1] > LASTING * short.slips.drop[-1]


def test_a_path_that_turns_gives_no_advice_to_drive_on() -> None:
    """It goes another way: "drive to X_T = ..." is of one that goes on. Contacts of one exact threshold keep step
    for ever."""
    pulled: dict[str, Any] = {"spring": 0.5, "slip": "instant"}
    for path, advice in (([0.0, 4.0], True), ([0.0, 4.0, 1.0], False)):
        found = master.solve(Contacts(identical(1.0)), path, 1e-3, **pulled).regime
        assert "are too few to tell" in found.reason and ("drive to" in found.reason) is advice
        assert (found.drive_to is not None) is advice


@pytest.mark.parametrize("end", [0.8e6, 1.2e6, 1.8e6])
def test_one_slip_on_a_soft_spring_is_known_to_be_the_last(end: float) -> None:
    """It goes along F(X) until all steps of the start are forgotten: what follows on a longer path is known."""
    pulled: dict[str, Any] = {"spring": 1e-6, "slip": "instant"}
    contacts = Contacts(gaussian(1.0, 0.2))
    short, long = (master.solve(contacts, [each], 1e-4, **pulled) for each in (end, 20.0 * end))
    assert short.regime.verdict == "decaying transient" and long.slips.drive.size == 1
    assert "1 slip up to the end of the path, then none: F falls no more" in short.regime.reason


def test_slips_beyond_the_path_are_those_of_a_longer_one() -> None:
    """Two peaks whose contacts fall out of step in fourteen slips: a path sees one, or four that do not fade."""
    contacts = Contacts(mixture([gaussian(1.0, 0.1), gaussian(2.0, 0.1)], [0.5, 0.5]))
    pulled: dict[str, Any] = {"spring": 0.3, "slip": "instant"}
    all_slips = master.solve(contacts, [160.0], 1e-4, **pulled).slips.drive
    for end, seen in ((6.0, 1), (8.0, 4)):
        found = master.solve(contacts, [end], 1e-4, **pulled).regime
        more = f"{all_slips.size - seen} more up to X_T = {all_slips[-1]:.4g}, then none"
        assert found.slips == seen and found.verdict == "decaying transient"
        assert more in found.reason


def test_contacts_that_keep_their_step_are_not_said_to_forget_it() -> None:
    """Of one exact threshold; and of two, of which one is a multiple of the other."""
    for law in (identical(1.0), mixture([identical(1.0), identical(2.0)], [0.5, 0.5])):
        found = master.solve(Contacts(law), [4.0], 1e-3, spring=0.5, slip="instant")
        assert 0 < found.regime.slips < 4 and found.regime.verdict == "undecided"


def test_slips_of_exact_thresholds_that_shrink_at_first_go_on() -> None:
    """The first four drops shrink, by 38 % each: 82 more come on a longer path, of up to 1.04."""
    law = mixture([identical(1.0), identical(2.0), identical(3.0)], [0.5, 0.2, 0.3])
    for spring in (3.0, 6.0, 9.4):
        for end in (2.0, 3.0, 4.0, 5.0):
            path = [end * (1.0 + 1.0 / spring)]
            found = master.solve(Contacts(law), path, 1e-3, spring=spring, slip="instant").regime
            assert found.verdict == "undecided" or found.trend is None or found.trend > -1e-3


def test_slips_that_shrink_ever_more_die_out() -> None:
    """As each is a larger part smaller than the one before."""
    found = master.solve(NARROW, np.linspace(0.0, 17.8, 600), 1e-6, spring=0.5, slip="instant")
    assert found.regime.verdict == "decaying transient" and found.regime.slips == 16


def judged(drops: list[float], error: float) -> Regime:
    """The regime of a slider with mass, whose contacts wait, with these drops of its force, known to `error` each."""
    contacts = NARROW.replace(delay=Delay(1.0))
    pulled: dict[str, Any] = {"spring": 1e-3, "mass": 1e-3, "damping": 0.01, "velocity": 1.0}
    drop = np.array(drops)
    at = 1e3 * np.cumsum(drop)
    # some contacts hold on: the slider moves by less than a threshold
    slips = Slips(at, at, at + 0.5, 0.9 + 0.0 * drop, 0.9 - drop, 0.0)
    path = np.linspace(0.0, at[-1] + 10.0, 50)
    part = ErrorPart("two runs", error)
    found = Followed(0.0, 0.5 + 0.0 * path, 1.0 + 0.0 * path, slips, error, 1, (part,))
    return regime(contacts, Drive(path, **pulled), found, 1e-3, time.monotonic() + 60.0)


def test_drops_that_fade_by_less_than_their_error_are_no_end_of_the_slips() -> None:
    """Forces known to 1e-2: these drops shrink by 0.16 % each, as much as two runs of another tolerance differ by, and
    a verdict called it smooth. Known well enough, the same drops fade; small ones are not told of."""
    drops = [1.53, 1.675, 1.6892, 1.6837, 1.6840]
    told, small = judged(drops, 1e-2), judged([0.1 * each for each in drops], 1e-2)
    assert told.verdict == "stick-slip" and "alike within their errors" in told.reason
    assert judged(drops, 1e-5).verdict == "decaying transient"
    assert small.verdict == "undecided" and "tighten the tolerance" in small.reason


def test_drops_that_close_in_go_on() -> None:
    """A long slip is followed by a short one, as contacts pull the slider on that formed in it: each drop lies between
    the two before it, and so does the last one. Drops that only go up and down are not told of."""
    told = judged([1.40, 1.89, 1.57, 1.78, 1.585], 5e-3)
    assert told.verdict == "stick-slip" and "between the two before it" in told.reason
    assert judged([1.89, 1.40, 1.5, 1.3, 1.45], 5e-3).verdict == "undecided"
    # drops as small as their errors may do so by chance
    assert judged([0.140, 0.189, 0.157, 0.178, 0.1585], 1e-2).verdict == "undecided"


def test_slips_of_few_contacts_that_re_form_after_each_are_over_once_they_slide() -> None:
    """Infinitely many slip 7 times, ever less, and 2,000 some 11 times, up to a quarter of their way: they were called
    stick-slip, as only contacts that re-form at once were asked whether their slips are over."""
    known, rule = known_of(NARROW), "reform-after"
    machine = Machine(0.3 * known.critical_spring, None, 0.0, 1.0)
    told = follow(machine, NARROW, rule, known, wall_time=1e4)
    found = follow_finite(machine, NARROW, 2000.0, told, known.static, 1e4)
    assert told.kind == found.kind == "smooth" and found.slips > told.slips > 5


@pytest.mark.slow  # quick: contacts that wait long draw apart, below
@pytest.mark.parametrize(("std", "spring"), [(0.15, 1.0), (0.4, 1.0), (0.4, 0.2)])
def test_drops_of_wide_thresholds_that_shrink_ever_less_are_no_end_of_the_slips(
    std: float, spring: float
) -> None:
    """Of contacts that wait the drops of the first slips shrink by 0.6 and 4 % each, and go on: what five slips tell
    is what many do, or is not decided."""
    contacts = Contacts(gaussian(1.0, std), delay=Delay(1.0))
    loading = 0.9 / spring + 1.0
    pulled: dict[str, Any] = {"spring": spring, "mass": 1e-3, "damping": 0.01, "velocity": 1.0}
    found = master.solve(contacts, [0.0, 6.5 * loading], 1e-2, **pulled)
    assert found.regime.slips > 3 and found.regime.verdict in ("stick-slip", "undecided")
    assert (spring == 0.2) == (found.regime.verdict == "stick-slip")


@pytest.mark.parametrize(
    ("law", "spring", "delay", "far", "verdict", "least"),
    [
        # the drive had gone on by six times what loads the spring, and all contacts were still out
        (gaussian(1.0, 0.2), 0.95, 25.0, 14.0, "undecided", 0.7),
        # no contact held on after the first slip, and yet the tenth is less than half of it
        (gaussian(1.0, 0.4), 0.252, 30.0, 9.0, "undecided", 0.0),
        slow(gaussian(1.0, 0.4), 0.252, 1.0, 9.0, "stick-slip", 0.9),
    ],
)
def test_contacts_that_wait_long_draw_apart_from_slip_to_slip(
    law, spring: float, delay: float, far: float, verdict: str, least: float
) -> None:
    """What one slip tells beside twelve of the ensemble."""
    contacts, drive = Contacts(law, delay=Delay(delay)), {"velocity": 1.0, "spring": spring}
    path = np.linspace(0.0, far, 50)
    found = master.solve(contacts, path, 1e-2, slip="reform-after", **drive)
    assert found.success and found.regime.verdict == verdict, found.regime.reason
    long = np.linspace(0.0, 14.0 * (delay + 2.0 + 1.0 / spring), 50)
    slid = eq_model.simulate(contacts, long, n_contacts=4000, slip="reform-after", seed=1, **drive)
    drops = main_slips(slid.slips).drop
    assert drops.size >= 10 and found.slips.drop[0] == pytest.approx(drops[0], abs=0.02)
    ratio = drops[9] / drops[0]
    assert ratio > least if least else ratio < 0.5


def test_by_how_much_late_slips_shrink_is_told_beyond_chance() -> None:
    """Of four sliders, of which each drop is 3 % smaller than the one before, and by chance more or less."""
    chance = np.random.default_rng(1).normal(0.0, 1.0, (4, 12))
    shrinking = 0.97 ** np.arange(12)
    assert shrinks_by(slips_of(list(shrinking * np.exp(1e-3 * chance))), 4) == pytest.approx(
        0.03, abs=1e-3
    )
    assert shrinks_by(slips_of(list(shrinking * np.exp(0.2 * chance))), 4) == 0.0
    assert shrinks_by(slips_of(list(np.exp(1e-3 * chance))), 4) == 0.0
    assert shrinks_by(slips_of([[1.0, 0.9, 0.8]] * 4), 4) == 0.0  # too few to tell
