"""Slips of a slider with mass that are still those of a transient: only those that last are averaged, and what is left
of a transient is part of the error."""

import re
import time
from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate, stats

import eq_model
import master
from eq_model.result import CoupledSlips
from origins import Contacts, Delay, gaussian
from toolkit.results.slips import are_lasting, late_slips, slips_beyond
from toolkit.scene.scale import scale_of
from toolkit.verdict import answers
from toolkit.verdict.of_area import with_more
from toolkit.verdict.sliders.ensemble import follow_by_contacts, shrinking
from toolkit.verdict.sliders.finite import follow_finite
from toolkit.verdict.sliders.follow import SWINGING, _behaviour, follow
from toolkit.verdict.sliders.machine import (
    Behaviour,
    Machine,
    RigidSlider,
    not_followed,
    rigid_slider,
)
from toolkit.verdict.text.words import sentence

WIDE = gaussian(1.0, 0.4)


def slips_of(force_before: np.ndarray) -> CoupledSlips:
    """Slips to no force of sliders, shape (sliders, slips), on a spring of 1."""
    sliders, many = force_before.shape
    drive = np.cumsum(force_before, axis=1).ravel()
    zeros = np.zeros(drive.size)
    return CoupledSlips(
        replica=np.repeat(np.arange(sliders), many),
        number=np.tile(np.arange(many), sliders),
        drive=drive,
        before=drive,
        after=drive,
        force_before=force_before.ravel(),
        force_after=zeros,
        breaks=zeros.astype(int),
    )


def test_where_one_slider_never_slips_all_slips_of_the_others_tell() -> None:
    """The first drop of each is three times as large as all others."""
    three = slips_of(np.tile(np.append(1.0, np.full(19, 0.3)), (3, 1)))
    mean, error = late_slips(three, 4).mean("drop")
    assert mean == pytest.approx((1.0 + 19.0 * 0.3) / 20.0) and error > 0.1


def test_the_error_of_late_slips_holds_what_a_transient_leaves() -> None:
    """Slips that fade to 1 by e^(-n/8), beside those that are there: the mean of the later half is off by more than
    chance, and its error says so; of few slips, of which one may be anything, by how much one differs from others."""
    chance = np.random.default_rng(2).normal(0.0, 0.01, (4, 256))
    for many, fades in ((8, True), (16, True), (256, False)):
        slips = slips_of(1.0 + np.exp(-np.arange(many) / 8.0) + chance[:, :many])
        (mean, error), late = late_slips(slips, 4).mean("force_before"), late_slips(slips, 4)
        assert late.settled is not fades
        assert abs(mean - 1.0) < 4.0 * error and (error > 0.05) is fades
        assert late.period()[1] == pytest.approx(error, rel=0.3)
    wide = slips_of(1.0 + 30.0 * chance[:, :64])
    assert late_slips(wide, 4).settled and late_slips(wide, 4).mean("drop")[1] < 0.05
    few = late_slips(slips_of(1.0 + 30.0 * chance[:, :12]), 4)
    assert not few.settled and few.mean("drop")[1] > 0.2
    # shrinking by 0.1 % from one slip to the next, which is no limit cycle, however slow
    slow = slips_of(0.999 ** np.arange(64) * (1.0 + 0.1 * chance[:, :64]))
    assert not late_slips(slow, 4).settled and not are_lasting(slow, 4)
    # two slips of each slider: the second is held against the first
    two = late_slips(slips_of(np.array(4 * [[3.0, 2.0]])), 4)
    assert two.mean("force_before") == (2.0, pytest.approx(1.0))
    beyond = slips_beyond(slips_of(np.ones((2, 5))), 3.5)
    assert beyond.number.tolist() == [0, 1, 0, 1] and beyond.drive.min() > 3.5


@pytest.mark.parametrize(
    ("machine", "delay", "number"),
    [
        # 5.6, 1.6, 3.9, 2.2, 1.8, ... of a long delay: slips 5 to 8 were averaged as if they lasted
        (Machine(5e-4, 0.2, 5e-4, 1.0), 2000.0, 4000),
        # slips of many sizes, of which the second alone was told, with the scatter between sliders as its error
        (Machine(0.05, 0.02, 5e-5, 1.0), 20.0, 4000),
    ],
)
def test_only_slips_that_last_are_averaged(machine: Machine, delay: float, number: int) -> None:
    """Held against other sliders of the ensemble on a way three times as long, of which the first half is left out."""
    contacts = Contacts(WIDE, delay=Delay(delay))
    loading = 0.56 / machine.spring + 1.0 + delay
    rigid = RigidSlider(0.56, 0.01, 0.0, 0.76, 1.0, number)
    found = follow_by_contacts(machine, contacts, "mass", loading, time.monotonic() + 1e4, rigid)
    many = found.sliders
    assert found.kind == "stick-slip" and many is not None and found.drive[-1] > 12.0 * loading
    long = np.linspace(0.0, 3.0 * found.drive[-1], 10)
    asked = {"n_contacts": number, "n_replicas": 4, "seed": 7}
    own = eq_model.simulate(contacts, long, **asked, **machine.keywords("mass")).slips
    late = late_slips(own, 4)
    for name, told, error in (
        ("force_before", many.before, many.before_error),
        ("force_after", many.after, many.after_error),
    ):
        mean, chance = late.mean(name)
        assert abs(told - mean) < 3.5 * np.hypot(error, chance), name
    period, chance = late.period()
    assert abs(many.period - period) < 3.5 * np.hypot(many.period_error, chance)
    first = own.force_before[own.number == 1].mean()
    assert abs(first - many.before) > 10.0 * many.before_error  # the transient is far from it


def test_the_contacts_of_the_area_tell_a_lasting_cycle_of_slips_that_were_not_decided() -> None:
    """Of infinitely many six slips were seen; the area's go on for ever with slips of several sizes."""
    machine, contacts = Machine(5e-3, 2e-4, 5e-4, 1.0), Contacts(WIDE, delay=Delay(20.0))
    machine = replace(machine, mass=2.0)
    seen = replace(not_followed("mass", "cut"), slips=6, before=0.6, after=-0.55, period=250.0)
    many = follow_finite(machine, contacts, 4000.0, seen, 0.56, 1e4)
    assert many.kind == "stick-slip" and many.slips > 30 and not many.message
    told = with_more(seen, many, 1.0)
    assert told.kind == "stick-slip" and told.success and told.before == many.before
    assert told.error == many.error
    # fewer than there are tell nothing of it, nor those that shrink, nor what was never seen to slip
    for one, other in (
        (seen, replace(many, message="as infinitely many do")),
        (seen, replace(many, kind="unknown")),
        (replace(seen, slips=0), many),
    ):
        assert with_more(one, other, 1.0) is one


def test_a_slider_that_swings_at_the_end_is_told_by_its_last_whole_slip() -> None:
    """It swings beyond its drive's speed after four slips: the swing that the path's end cuts was told as "the last
    from 2.80 mN down by 0 N"."""
    contacts, machine = Contacts(WIDE, delay=Delay(200.0)), Machine(5e-3, 200.0, 0.05, 1.0)
    path = np.linspace(0.0, 6000.0, 600)
    solved = master.solve(contacts, path, 1e-2, **machine.keywords("mass"))
    assert solved.slips.drop.size >= 3
    told = _behaviour("mass", solved, 1.0, 1.0, SWINGING)
    last = solved.slips.main[-1]
    assert told.kind == "undecided" and told.message == SWINGING
    assert told.before - told.after == pytest.approx(solved.slips.drop[last]) and last > 1
    assert told.before - told.after > 0.5


def test_smooth_sliding_after_slips_that_shrink_is_told_at_f_k_with_what_is_left() -> None:
    """F_k(v) + γ v by quadrature: contacts of age x hold with the chance that none of their thresholds is below it."""
    delay, machine = 0.2, Machine(0.5, 2e-5, 5e-3, 1.0)
    contacts, law = Contacts(WIDE, delay=Delay(delay)), stats.norm(1.0, 0.4)
    below = law.cdf(0.0)
    bears = integrate.quad(lambda x: x * (law.sf(x) / (1.0 - below)), 0.0, 6.0)[0]
    holds = integrate.quad(lambda x: law.sf(x) / (1.0 - below), 0.0, 6.0)[0]
    exact = bears / (holds + delay) + machine.damping
    steady = master.steady_state(contacts, velocity=1.0)
    known = rigid_slider(contacts, steady, master.propensity(contacts, 1e-3), 2e4)
    # nine slips, and a heavy damping: the force at the path's end, 0.4714 +- 0.0029, stood for that of sliding
    slides = follow(machine, contacts, "mass", known, 1e4)
    assert slides.kind == "smooth" and slides.after == pytest.approx(exact, abs=1e-6)
    assert 0.4884 - 0.4714 < slides.error < 0.2
    assert slides.slips == 9 and slides.shrinks_by == pytest.approx(0.245, abs=0.02)
    # another solver, on its own way: what still swings there is within the error
    late = slides.drive > 0.8 * slides.drive[-1]
    assert np.abs(slides.force[late] - exact).max() < 1.5 * slides.error < 0.3
    said = sentence(of(slides))
    assert re.match(
        r"smooth at 0\.\d+ ± 0\.\d+ N.* once slips have died out: 9 were seen, each drop", said
    )
    assert "swing by more" not in said  # the error of the force says it
    # where they leave more than the force itself, that is said beside its error
    left = replace(slides, error=0.8, before=1e-3, after=1e-3, slips=13)
    said = sentence(of(left))
    assert "± 0.8" in said and "13 were seen" in said
    assert re.search(r"and the path ends while they swing by more than the force$", said)
    assert shrinking(slides) in said
    # and where the path ends too soon for that
    open_end = replace(left, kind="undecided", before=0.4, after=-0.3)
    assert f"13 slips were seen{shrinking(slides)}, the last from 0.4" in sentence(of(open_end))


def of(behaviour: Behaviour) -> answers.Verdict:
    """A verdict of one reading."""
    contacts, number = Contacts(WIDE, delay=Delay(0.2)), answers.Quantity(0.5, 1e-9)
    machine = Machine(0.5, 2e-5, 5e-3, 1.0)
    scale = scale_of(contacts, None)
    own = answers.Answer("own", contacts, scale, number, number, number, machine, (behaviour,))
    return answers.Verdict("a", "a", 1.0, (own,), (), {}, 1.0)


def test_slips_that_fade_are_followed_until_they_are_over_and_open_until_then(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Contacts that wait long come back ever less together: a tenth less in each slip. The means of late slips stood
    for those to come; sliding, in the end, is that of F_k = <x²>/2/(<x> + v delay) and what the damping bears."""
    delay, number = 1e3, 20_000
    machine, contacts = Machine(0.2, 1e-3, 4e-3, 1.0), Contacts(WIDE, delay=Delay(delay))
    kinetic = 0.5 * WIDE.moment(2) / (WIDE.mean() + delay)
    rigid, loading = RigidSlider(0.56, kinetic, 0.0, 0.76, 1.0, number), 4.0 + delay
    asked = machine, contacts, "mass", loading, time.monotonic() + 1e4, rigid
    over = follow_by_contacts(*asked)
    assert over.kind == "smooth" and over.slips >= 15 and 0.02 < over.shrinks_by < 0.2
    assert over.after == pytest.approx(kinetic + machine.damping, rel=1e-9)
    long = np.linspace(0.0, 30.0 * loading, 31)
    own = eq_model.simulate(
        contacts, long, n_contacts=number, n_replicas=4, seed=9, **machine.keywords("mass")
    )
    work = own.energy.drive[:, -1] - own.energy.drive[:, 20]
    mean = work / (long[-1] - long[20])
    assert abs(mean.mean() - over.after) < 5.0 * mean.std(ddof=1) / 2.0 < over.error
    monkeypatch.setattr(
        "toolkit.verdict.sliders.ensemble.DOUBLINGS", 0
    )  # as where there is no time
    fades = follow_by_contacts(*asked)
    number_of_last = fades.slips - 1
    assert fades.kind == "undecided" and fades.shrinks_by > 0.08 and fades.slips < 8
    before, off = own.slips.mean("force_before", number_of_last)
    assert abs(fades.before - before) < 4.0 * (off + fades.error)
    assert f"not decided: {fades.slips} slips were seen{shrinking(fades)}" in sentence(of(fades))
    # what follows in place of the master equation is told, though it is open
    never = not_followed("mass", "it is not solved here")
    monkeypatch.setattr("toolkit.verdict.sliders.follow._by_distribution", lambda *_: never)
    assert follow(machine, contacts, "mass", rigid, 1e4).slips == fades.slips


def test_slips_of_several_sizes_are_told_by_their_mean() -> None:
    """The last slip of the master equation stood for all: 3.9 mN where slips begin at 3.5 to 7 mN."""
    contacts = Contacts(WIDE)
    solved = master.solve(contacts, np.linspace(0.0, 60.0, 50), 1e-6, spring=0.1, slip="reset")
    slips = solved.slips
    assert solved.regime.verdict == "stick-slip" and slips.drop.size >= 6
    alike = _behaviour("reset", solved, 1.0, 1.0, "")
    assert alike.before == slips.force_before[-1] and alike.period == solved.period
    sizes = np.where(np.arange(slips.drop.size) % 2, 0.5, 1.0) * slips.force_before
    told = _behaviour(
        "reset", replace(solved, slips=replace(slips, force_before=sizes)), 1.0, 1.0, ""
    )
    late = slips.drop.size // 2
    assert told.before == pytest.approx(sizes[late:].mean()) and told.after == 0.0
    assert told.period == pytest.approx(np.diff(slips.drive[late:]).mean())
    assert told.error > np.std(sizes[late:]) / slips.drop.size
