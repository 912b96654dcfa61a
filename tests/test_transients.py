"""Slips of a slider with mass that are still those of a transient: only those that last are averaged, and what is left
of a transient is part of the error."""

import re
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import slow
from scipy import integrate, stats

import eq_model
import master
from eq_model.result import CoupledSlips
from origins import Contacts, Delay, Thermal, gaussian
from tests.verdicts import reading, text_of, verdict_on
from toolkit.results.mean_of_pairs import mean_of_pairs
from toolkit.results.rarer import rarer
from toolkit.results.slips import are_lasting, late_slips, main_slips, slips_beyond
from toolkit.scene.scale import scale_of
from toolkit.verdict import answers
from toolkit.verdict.files import plain
from toolkit.verdict.mean_force import mean_of_contacts, mean_over_slips
from toolkit.verdict.of_area import with_more
from toolkit.verdict.sliders.ensemble import follow_by_contacts
from toolkit.verdict.sliders.finite import follow_finite
from toolkit.verdict.sliders.follow import STILL_SWINGS, follow
from toolkit.verdict.sliders.late import EVER_RARER, in_the_end, shrinking
from toolkit.verdict.sliders.machine import Machine, RigidSlider, rigid_slider
from toolkit.verdict.sliders.records import Behaviour, Finite, not_followed
from toolkit.verdict.sliders.steady import friction_falls, is_stable_with_delay
from toolkit.verdict.sliders.told import behaviour_of
from toolkit.verdict.text.hangs_on import dependence
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


@pytest.mark.slow  # quick: slips that get ever rarer, below
@pytest.mark.parametrize(
    ("machine", "delay", "number"),
    [
        # 5.6, 1.6, 3.9, 2.2, 1.8, ... of a long delay: slips 5 to 8 were averaged as if they lasted
        (Machine(5e-4, 0.2, 5e-4, 1.0), 2000.0, 2000),
        # slips of many sizes, of which the second alone was told, with the scatter between sliders as its error
        (Machine(0.05, 0.02, 5e-5, 1.0), 20.0, 4000),
    ],
)
def test_only_slips_that_last_are_averaged(machine: Machine, delay: float, number: int) -> None:
    """Held against other sliders of the ensemble on a way three times as long, of which the first half is left out, by
    the main slips of both, as a verdict tells these."""
    contacts = Contacts(WIDE, delay=Delay(delay))
    loading = 0.56 / machine.spring + 1.0 + delay
    rigid = RigidSlider(0.56, 0.01, 0.0, 0.76, 1.0, number)
    found = follow_by_contacts(machine, contacts, "mass", loading, time.monotonic() + 1e4, rigid)
    many = found.finite
    assert found.kind == "stick-slip" and many is not None and found.drive[-1] > 12.0 * loading
    long = np.linspace(0.0, 3.0 * found.drive[-1], 10)
    asked = {"n_contacts": number, "n_replicas": 4, "seed": 7}
    own = main_slips(eq_model.simulate(contacts, long, **asked, **machine.keywords("mass")).slips)
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


@pytest.mark.slow  # quick: test_only_slips_that_last_are_averaged
def test_the_contacts_of_the_area_tell_a_lasting_cycle_of_slips_that_were_not_decided() -> None:
    """Of infinitely many six slips were seen; the area's go on for ever with slips of several sizes."""
    machine, contacts = Machine(5e-3, 2e-4, 5e-4, 1.0), Contacts(WIDE, delay=Delay(20.0))
    machine = replace(machine, mass=2.0)
    seen = replace(not_followed("mass", "cut"), slips=6, before=0.6, after=-0.55, period=250.0)
    many = follow_finite(machine, contacts, 1000.0, seen, 0.56, 1e4)
    assert many.kind == "stick-slip" and many.slips > 30 and not many.message
    told = with_more(seen, many, 1.0)
    assert told.kind == "stick-slip" and told.success and told.before == many.before
    assert told.error == many.force_error and told.period_error == many.period_error
    # fewer than there are tell nothing of it, nor those that shrink
    for one, other in (
        (seen, replace(many, message="as infinitely many do")),
        (seen, replace(many, kind="unknown")),
    ):
        assert with_more(one, other, 1.0) is one
    # where nobody saw infinitely many slip, falls of a slider that rings for so long may be those of its swing
    nobody = follow_finite(machine, contacts, 1000.0, replace(seen, slips=0), 0.56, 1e4)
    assert nobody.kind == "unknown" and "a swing of the mass" in nobody.message


@pytest.mark.slow  # quick: swings that have not died out, below
def test_a_slider_that_swings_at_the_end_is_told_by_its_last_whole_slip() -> None:
    """It swings beyond its drive's speed after four slips: the swing that the path's end cuts was told as "the last
    from 2.80 mN down by 0 N"."""
    contacts, machine = Contacts(WIDE, delay=Delay(200.0)), Machine(5e-3, 200.0, 0.05, 1.0)
    path = np.linspace(0.0, 6000.0, 600)
    solved = master.solve(contacts, path, 1e-2, **machine.keywords("mass"))
    assert solved.slips.drop.size >= 3
    told = behaviour_of("mass", solved, 1.0, 1.0, STILL_SWINGS)
    last = solved.slips.main[-1]
    assert told.kind == "undecided" and told.message == STILL_SWINGS
    assert told.before - told.after == pytest.approx(solved.slips.drop[last]) and last > 1
    assert told.before - told.after > 0.5


@pytest.mark.parametrize(
    ("machine", "many", "shrinks_by"),
    [
        (Machine(0.5, 2e-3, 0.015, 1.0), 4, 0.368),
        # a heavy damping: the force at the path's end, 0.4714 +- 0.0029, stood for that of sliding, 0.4884
        slow(Machine(0.5, 2e-5, 5e-3, 1.0), 9, 0.245),
    ],
    ids=["four slips", "nine slips"],
)
def test_smooth_sliding_after_slips_that_shrink_is_told_at_f_k_with_what_is_left(
    machine: Machine, many: int, shrinks_by: float
) -> None:
    """F_k(v) + γ v by quadrature: contacts of age x hold with the chance that none of their thresholds is below it."""
    delay = 0.2
    contacts, law = Contacts(WIDE, delay=Delay(delay)), stats.norm(1.0, 0.4)
    below = law.cdf(0.0)
    bears = integrate.quad(lambda x: x * (law.sf(x) / (1.0 - below)), 0.0, 6.0)[0]
    holds = integrate.quad(lambda x: law.sf(x) / (1.0 - below), 0.0, 6.0)[0]
    exact = bears / (holds + delay) + machine.damping
    steady = master.steady_state(contacts, velocity=1.0)
    known = rigid_slider(contacts, steady, master.propensity(contacts, 1e-3), 2e4)
    slides = follow(machine, contacts, "mass", known, 1e4)
    assert slides.kind == "smooth" and slides.after == pytest.approx(exact, abs=1e-6)
    assert (0.4884 - 0.4714 if many == 9 else 1e-3) < slides.error < 0.2
    assert slides.slips == many and slides.shrinks_by == pytest.approx(shrinks_by, abs=0.02)
    # another solver, on its own way: what still swings there is within the error
    late = slides.drive > 0.8 * slides.drive[-1]
    assert np.abs(slides.force[late] - exact).max() < 1.5 * slides.error < 0.3
    low, high = slides.force[late].min(), slides.force[late].max()
    said = sentence(of(slides))
    assert re.search(rf"once slips have died out: {many} were seen, each drop", said)
    # swings of more than a twentieth of the force are told by their ends, and smaller ones are its error
    assert slides.swings == ((low, high) if many == 9 else None) and low < exact < high
    swings = f", still swinging between {low:.2g} N_c<k>·length and {high:.2g} N_c<k>·"
    assert (swings in said) is (many == 9)
    assert said.startswith(f"smooth at {exact:.4f} N" if many == 9 else "smooth at 0.498 ± 0.004 N")
    # where its ends are not known what is left is an error, of more than the force itself
    left = replace(slides, error=0.8, before=1e-3, after=1e-3, slips=13, swings=None)
    said = sentence(of(left))
    assert " ± 0.8" in said and "13 were seen" in said
    assert said.endswith("and the path ends while they swing by more than the force")
    assert shrinking(slides) in said
    # and where the path ends too soon for that
    open_end = replace(left, kind="undecided", before=0.4, after=-0.3)
    assert f"13 slips were seen{shrinking(slides)}, the last from 0.4" in sentence(of(open_end))


def of(behaviour: Behaviour) -> answers.Verdict:
    """A verdict of one reading."""
    contacts, machine = Contacts(WIDE, delay=Delay(0.2)), Machine(0.5, 2e-5, 5e-3, 1.0)
    return verdict_on(reading(behaviour, contacts=contacts, machine=machine, kinetic=0.5))


@pytest.mark.slow  # quick: test_smooth_sliding_after_slips_that_shrink, of infinitely many
def test_slips_that_fade_are_followed_until_they_are_over_and_open_until_then(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Contacts that wait long come back ever less together: a tenth less in each slip. The means of late slips stood
    for those to come; sliding, in the end, is that of F_k = <x²>/2/(<x> + v delay) and what the damping bears."""
    delay, number = 1e3, 4000
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
    # as where there is no time
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.ROUNDS", (0, 0))
    fades = follow_by_contacts(*asked)
    number_of_last = fades.slips - 1
    assert fades.kind == "undecided" and fades.shrinks_by > 0.08 and fades.slips < 8
    before, off = own.slips.mean("force_before", number_of_last)
    assert abs(fades.before - before) < 4.0 * (off + fades.error)
    assert f"not decided: {fades.slips} slips were seen{shrinking(fades)}" in sentence(of(fades))
    # what follows in place of the master equation is told, though it is open
    never = not_followed("mass", "it is not solved here")
    monkeypatch.setattr("toolkit.verdict.sliders.follow.by_distribution", lambda *_: never)
    assert follow(machine, contacts, "mass", rigid, 1e4).slips == fades.slips


def test_slips_with_mass_are_told_where_a_point_beside_one_is_not() -> None:
    """A slip takes no time beside that by which its begin is not known, so that the force at a point near it is off by
    all that it falls: a verdict puts its own points anywhere, and was "not decided" for that."""
    machine = Machine(0.1, 0.1, 0.05, 1.0)
    solved = master.solve(
        Contacts(WIDE), np.linspace(0.0, 15.0, 9), 1e-5, **machine.keywords("mass")
    )
    assert solved.slips.drive.size
    error = solved.slips.force_error
    assert error == pytest.approx(0.1 * solved.slips.drive_error / WIDE.mean())
    for off, lowest in ((0.7, error), (0.2 * error, 0.2 * error)):
        told = behaviour_of(
            "mass", replace(solved, force_error=off, success=False), 1.0, 1.0, STILL_SWINGS
        )
        assert told.error == pytest.approx(lowest) and told.message == STILL_SWINGS
    # smooth sliding is told by the force at the path's end
    smooth = replace(solved.regime, verdict="smooth")
    slides = replace(solved, force_error=0.04, success=False, regime=smooth)
    assert behaviour_of("mass", slides, 1.0, 1.0, "").error == 0.04
    lost = behaviour_of("mass", replace(slides, force_error=0.7), 1.0, 1.0, "")
    assert lost.kind == "undecided" and lost.error == 0.7
    slips = replace(solved.slips, force_error=1.0)
    unknown = replace(solved, force_error=0.7, success=False, slips=slips, message="too many steps")
    assert behaviour_of("mass", unknown, 1.0, 1.0, "").message == "too many steps"


def test_slips_of_several_sizes_are_told_by_their_mean() -> None:
    """The last slip of the master equation stood for all: 3.9 mN where slips begin at 3.5 to 7 mN."""
    contacts = Contacts(WIDE)
    solved = master.solve(contacts, np.linspace(0.0, 60.0, 50), 1e-6, spring=0.1, slip="reset")
    slips = solved.slips
    assert solved.regime.verdict == "stick-slip" and slips.drop.size >= 6
    alike = behaviour_of("reset", solved, 1.0, 1.0, "")
    assert alike.before == slips.force_before[-1] and alike.period == solved.period
    sizes = np.where(np.arange(slips.drop.size) % 2, 0.5, 1.0) * slips.force_before
    told = behaviour_of(
        "reset", replace(solved, slips=replace(slips, force_before=sizes)), 1.0, 1.0, ""
    )
    even = (slips.drop.size + 1) // 4 * 2
    assert told.before == pytest.approx(sizes[-even:].mean()) and told.after == 0.0
    assert told.period == pytest.approx(np.diff(slips.drive)[-even:].mean())


@pytest.mark.parametrize("number", range(5, 13))
def test_slips_in_turn_long_and_short_have_the_mean_of_both(number: int) -> None:
    """Of gaps of 2 and 3 in turn the mean was 2.67, as the later half has one more of one kind than of the other."""
    contacts = Contacts(WIDE)
    solved = master.solve(contacts, np.linspace(0.0, 60.0, 50), 1e-6, spring=0.1, slip="reset")
    gaps, falls = (np.resize(each, number) for each in ([2.0, 3.0], [0.4, 0.6]))

    def told(gaps: np.ndarray, falls: np.ndarray) -> Behaviour:
        slips = replace(
            solved.slips,
            **{name: np.zeros(number) for name in ("before", "after", "force_after")},
            drive=np.cumsum(gaps),
            force_before=falls,
            drive_error=1e-3,
        )
        return behaviour_of("reset", replace(solved, slips=slips), 1.0, 1.0, "")

    for each in (falls, np.full(number, 0.5)):  # that the gaps differ tells as much
        found = told(gaps, each)
        assert found.period == pytest.approx(2.5) and found.before == pytest.approx(0.5)
        assert found.period_error == pytest.approx(2e-3)
        assert found.error == pytest.approx(solved.force_error, abs=1e-12)


def test_the_mean_force_is_that_of_as_many_long_periods_as_short_ones() -> None:
    """Gaps of 2 and 3 on a spring of 0.1, up to 1: the way of the mean period from the end held one kind more."""
    drive, force = [0.0], [1.0]
    for gap in np.resize([2.0, 3.0], 9):
        drive += [drive[-1] + 1e-9, drive[-1] + gap]
        force += [1.0 - 0.1 * gap, 1.0]
    slider = not_followed("mass", "")
    slider = replace(
        slider, kind="stick-slip", period=2.5, drive=np.array(drive), force=np.array(force)
    )
    assert mean_over_slips(slider) == pytest.approx(1.0 - 0.05 * 13.0 / 5.0)


def test_the_mean_force_of_contacts_is_that_of_their_own_cycles() -> None:
    """A sawtooth between 1 and 0 has 0.5, however its periods scatter; one that slides on has none told."""
    gaps = 10.0 + np.random.default_rng(3).normal(0.0, 0.5, 12)
    drive = np.repeat(np.cumsum(gaps), 2)
    force = np.tile([1.0, 0.0], gaps.size)
    ends = np.append(drive, drive[-1] + 4.0), np.append(force, 0.4)
    saw = Finite("reset", 100, "stick-slip", 1.0, 0.01, 0.0, 0.01, period=10.0, drive=ends[0])
    found = mean_of_contacts(replace(saw, force=ends[1]))
    assert found is not None and found == (pytest.approx(0.5), 0.01)
    uneven = replace(saw, force=ends[1] * (1.0 + 0.2 * np.cos(np.arange(ends[1].size))))
    found = mean_of_contacts(uneven)
    assert found is not None and abs(found.force - 0.5) < 3.0 * found.error < 0.1
    assert mean_of_contacts(replace(saw, drive=ends[0][:3], force=ends[1][:3])) is None
    assert mean_of_contacts(replace(saw, before=1.0, after=0.9, force=ends[1])) is None


@pytest.mark.parametrize("number", [2, 4, 6, 12])
def test_one_standard_error_of_pairs_holds_the_mean_of_as_many_as_it_says(number: int) -> None:
    rng, many = np.random.default_rng(number), 4000
    means = [mean_of_pairs(rng.normal(1.0, 0.1, number)) for _ in range(many)]
    within = np.mean([abs(mean.value - 1.0) < mean.error for mean in means])
    assert within == pytest.approx(0.683, abs=4.0 * (0.683 * 0.317 / many) ** 0.5)


def test_a_period_has_its_own_error() -> None:
    """2 drive_error is not as large a part of the period as the error of the force is of that."""
    machine, contacts = Machine(0.05, 0.02, 0.01, 0.5), Contacts(WIDE, delay=Delay(3.0))
    one = replace(SLIDES, kind="stick-slip", after=-0.1, slips=9, period=9.09)
    for off, said in (
        (1e-9, "every 9.090 units of length, "),
        (0.2, "every 9.1 ± 0.2 units of length, "),
    ):
        told = replace(
            on_area(
                replace(one, period_error=off), Finite("mass", 300, "smooth"), machine, contacts
            ),
            finite=(),
        )
        assert said in sentence(told)
        assert said.removeprefix("every ") in text_of(told).partition("\n\n")[2]


# of a tribologist's machine, 1.45 kN/m, 60 g, 0.546 N s/m, 22.4 s and 2.66 µm/s, in thresholds: contacts wait on a way
# of 59 µm, and break on 5 nm
RARE = Machine(1e-3, 1e-3 / 0.294**2, 1.99e-4, 1.0)
RARE_CONTACTS = Contacts(WIDE, delay=Delay(11819.0))


def test_friction_falls_with_the_speed_as_that_of_two_steady_states() -> None:
    machine, contacts, off = Machine(0.5, 0.1, 0.1, 0.7), Contacts(WIDE, delay=Delay(3.0)), 1e-3
    low, high = (master.steady_state(contacts, velocity=0.7 + sign * off).force for sign in (-1, 1))
    falls = (low - high) / 2.0 / off
    assert friction_falls(machine, contacts) == pytest.approx(falls, rel=1e-5)
    assert friction_falls(machine, Contacts(WIDE)) == 0.0


@pytest.mark.parametrize("part", [0.9, 1.1])
def test_contacts_that_broke_together_draw_apart_on_springs_above_a_stiffness(part: float) -> None:
    """Held against volleys of small size, e^(st): per unit of the slider's swing D = K + γs + Ms² and contacts that
    hold, C, pull back, and so many come back a delay later that e^(-sτ) = (D - C)/(g D - C), g being the transform of
    P_c; |e^(-sτ)| below 1 at s = iω is a volley that grows."""
    unit, square, delay = WIDE.mean(), WIDE.moment(2), 4000.0
    share = unit / (unit + delay)
    least = share * square / (square - unit**2)
    machine, contacts = replace(RARE, spring=part * least), Contacts(WIDE, delay=Delay(delay))
    assert is_stable_with_delay(machine, contacts) is (part > 1.0)
    x, forms, swing = WIDE.isf((np.arange(200_000) + 0.5) / 200_000), share / unit, 1e-3
    phase = np.exp(-1j * swing * x)
    held = forms / (1j * swing) * (1.0 - ((1.0 + 1j * swing * x) * phase).mean())
    pulls = machine.spring + 1j * swing * machine.damping - swing**2 * machine.mass
    comes_back = (pulls - held) / (phase.mean() * pulls - held)
    assert bool(abs(comes_back) > 1.0) is (part > 1.0)


def test_sliding_is_not_called_stable_where_that_is_not_known() -> None:
    assert is_stable_with_delay(RARE, RARE_CONTACTS)
    falls = friction_falls(RARE, RARE_CONTACTS)
    assert not is_stable_with_delay(replace(RARE, damping=0.99 * falls), RARE_CONTACTS)
    assert is_stable_with_delay(replace(RARE, damping=1.01 * falls), RARE_CONTACTS)
    # swings that pass no threshold; no mass; no delay; contacts that age, form stretched or are linked
    assert not is_stable_with_delay(replace(RARE, mass=0.09 * RARE.spring), RARE_CONTACTS)
    assert not is_stable_with_delay(replace(RARE, mass=None), RARE_CONTACTS)
    assert not is_stable_with_delay(RARE, Contacts(WIDE))
    for other in ({"reforming": 0.1}, {"stiffness": "linked"}, {"thermal": Thermal("soft", 0.01)}):
        assert not is_stable_with_delay(RARE, RARE_CONTACTS.replace(**other))


def at_places(places: list[np.ndarray]) -> CoupledSlips:
    """Slips of sliders at these places of the drive, all alike."""
    slips = slips_of(np.ones((1, sum(map(len, places)))))
    return replace(
        slips,
        replica=np.repeat(np.arange(len(places)), [len(one) for one in places]),
        number=np.concatenate([np.arange(len(one)) for one in places]),
        drive=np.concatenate(places),
    )


def test_slips_get_rarer_where_the_last_third_of_the_way_has_clearly_fewer() -> None:
    chance = np.random.default_rng(5)
    grow = at_places([np.cumsum(1.1 ** np.arange(40)) * chance.uniform(0.9, 1.1) for _ in range(4)])
    end = float(grow.drive.max())
    found = rarer(grow, 4, end)
    assert found is not None and found.slips == 40.0 and found.way == end - grow.drive.min()
    late = grow.drive > end - found.way / 3.0
    assert found.last == pytest.approx(4.0 * found.way / 3.0 / late.sum())
    assert found.first < 0.3 * found.last
    # a cycle; the same of a start; chance; one slider that never slips; and two that go on, and two that do not
    alike = [np.arange(60.0) for _ in range(4)]
    started = [np.append(np.linspace(0.0, 0.9, 10), np.arange(1.0, 60.0)) for _ in range(4)]
    by_chance = [np.sort(chance.uniform(0.0, 60.0, 40)) for _ in range(4)]
    for places in (alike, started, by_chance, [*alike[:2], *(one[:20] for one in alike[:2])]):
        assert rarer(at_places(places), 4, 60.0) is None
    assert rarer(grow, 5, end) is None
    none_left = rarer(at_places([np.arange(30.0) for _ in range(4)]), 4, 90.0)
    assert none_left is not None and none_left.last == pytest.approx(120.0)


def test_slips_that_get_ever_rarer_end_where_steady_sliding_is_stable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It was told as stick-slip every 160 µm, the mean of late slips: these come ever less often, and after 470 delays
    of 1,500 no more. The force of sliding is F_k(v), of contacts of which a part h holds, and γ v. Four sliders are
    enough to tell it with nine of twelve seeds, of which this is one; else it is undecided."""
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.SEED", 3)
    rigid = RigidSlider(0.56, 0.01, 0.0, 0.76, 1.0, 300)
    found = follow_by_contacts(RARE, RARE_CONTACTS, "mass", 1.2e4, time.monotonic() + 1e4, rigid)
    many = found.finite
    assert found.kind == EVER_RARER and many is not None and many.kind == EVER_RARER
    assert many.rarer is not None and many.rarer.first < 0.5 * many.rarer.last
    share = 1.0 / (1.0 + 11819.0 / WIDE.mean())
    kinetic = share * WIDE.moment(2) / 2.0 / WIDE.mean()
    given = {"kinetic": kinetic, "static": 0.56, "spring": 0.56, "holding": share}
    own = reading(found, contacts=RARE_CONTACTS, machine=RARE, **given)
    told = verdict_on(own, finite=(many,))
    said, text = sentence(told), text_of(told)
    force = kinetic + RARE.damping
    assert f"slips ever rarer, smooth in the end at {force:.2e} " in said
    assert re.search(r"\d{3} slips a slider over 5\.\de\+06.*every 1\d,000 .*every \d\d,000 ", said)
    usual = re.search(r"fluctuating by ± (\S+) N_c<k>·length between slips", said)
    # about as large as the force itself, as few contacts hold
    assert usual is not None and 0.4 * force < float(usual[1]) < 2.0 * force
    assert "stick-slip" not in text
    assert "stable against slow changes of the speed: friction falls with the speed by" in text
    assert plain(told)["readings"][0]["behaviours"][0]["kind"] == "ever rarer"
    assert plain(told)["finite"][0]["rarer"]["slips"] == many.slips


def test_where_sliding_is_stable_slips_that_neither_end_nor_last_are_open() -> None:
    """Of unlike slips nobody knows whether they end; alike they are those of a cycle, beside sliding that is stable,
    and where it is not, slips that get rarer are told as such."""
    chance = np.random.default_rng(3)
    places = [np.arange(240.0) for _ in range(4)]
    unlike = replace(at_places(places), force_before=chance.uniform(0.5, 1.5, 960))
    finite = Finite("mass", 300, "stick-slip")
    path = np.linspace(0.0, 240.0, 61)

    def told(slips: CoupledSlips, machine: Machine = RARE) -> Finite:
        found = SimpleNamespace(slips=slips, path=path, forces=np.zeros((4, 61)))
        return in_the_end(finite, found, machine, RARE_CONTACTS)

    assert told(unlike).kind == "unknown" and "steady sliding is stable" in told(unlike).message
    assert told(at_places(places)).kind == "stick-slip"
    swings = replace(RARE, damping=0.0)
    assert told(unlike, swings) == finite
    fewer = at_places([np.cumsum(1.04 ** np.arange(60)) for _ in range(4)])
    assert told(fewer).kind == EVER_RARER
    assert told(fewer, swings).kind == "stick-slip" and told(fewer, swings).rarer is not None


def on_area(one: Behaviour, few: Finite, machine: Machine, contacts: Contacts) -> answers.Verdict:
    """A verdict on so many contacts of an area, and on infinitely many."""
    kinetic = master.steady_state(contacts, velocity=1.0).force
    scale = replace(scale_of(contacts, None), contacts=float(few.contacts))
    own = reading(one, contacts=contacts, machine=machine, kinetic=kinetic, scale=scale)
    return verdict_on(own, finite=(few,))


SLIDES = Behaviour("mass", "smooth", 0.1, 0.1, None, 1, 1e-6, True, "", 1.0)


def test_swings_that_have_not_died_out_are_told_by_their_ends_and_are_no_error() -> None:
    """It was "smooth at 820 ± 2,700 µN": the force of sliding is known, and the slider swung about it after 11 delays
    of its contacts; slips on the way are counted."""
    machine, contacts = Machine(1.8, 1e-4, 1e-3, 1.0), Contacts(WIDE, delay=Delay(5.6))
    steady = master.steady_state(contacts, velocity=1.0)
    known = rigid_slider(contacts, steady, master.propensity(contacts, 1e-3), 2e4)
    found = follow(machine, contacts, "mass", known, 1e4)
    assert found.kind == "smooth" and found.swings is not None
    low, high = found.swings
    late = found.drive >= found.drive[-1] * 0.8
    assert low == pytest.approx(found.force[late].min()) and high == found.force[late].max()
    assert low < found.after < high
    assert found.after == pytest.approx(steady.force + machine.damping)
    few = Finite("mass", 20_000, "smooth", slips=36.0)
    told = on_area(found, few, machine, contacts)
    said, text = sentence(told), text_of(told)
    delays = found.drive[-1] / 5.6
    assert re.match(r"smooth at 0\.\d+ N_c<k>·length", said) and "±" not in said
    assert f"of the drive, {delays:.3g} delays of its contacts" in said
    assert f", still swinging between {low:.2g} N_c<k>·length and {high:.2g} N_c<k>·" in said
    assert "forces of the slider" not in text  # which would be an error of it
    assert "20,000 contacts: smooth after 36 slips" in text
    twice = replace(found, slips=13)
    assert " after 13 slips, still swinging between" in sentence(
        on_area(twice, few, machine, contacts)
    )


@pytest.mark.slow  # quick: the test before
def test_a_larger_damping_ends_the_swings() -> None:
    """Of a slider that swings about the force of sliding."""
    machine, contacts = Machine(1.8, 1e-4, 1e-3, 1.0), Contacts(WIDE, delay=Delay(5.6))
    steady = master.steady_state(contacts, velocity=1.0)
    known = rigid_slider(contacts, steady, master.propensity(contacts, 1e-3), 2e4)
    swinging = follow(machine, contacts, "mass", known, 1e4).swings
    assert swinging is not None
    low, high = swinging
    still = follow(replace(machine, damping=0.5), contacts, "mass", known, 1e4)
    assert still.kind == "smooth" and (still.swings is None or np.ptp(still.swings) < high - low)


def test_means_that_leave_smaller_slips_out_say_so() -> None:
    """Slips below a fifth of the largest stood in no sentence where the area's contacts tell in place of all."""
    machine, contacts = Machine(5e-3, 2.0, 5e-4, 1.0), Contacts(WIDE, delay=Delay(20.0))
    few = Finite("mass", 300, "stick-slip", 0.5, 1e-3, -0.5, 1e-3, 3.0, period=200.0, smaller=5)
    one = replace(SLIDES, kind="stick-slip", after=-0.1, slips=9, finite=few, contacts=300)
    told = ", without 5 of 17 slips, below a fifth of the largest"
    found = on_area(one, replace(few, before=0.55), machine, contacts)
    assert sentence(found).count(told) == 1 and text_of(found).count(told) == 2
    whole = on_area(
        replace(one, finite=replace(few, smaller=0)), replace(few, smaller=0), machine, contacts
    )
    assert "without" not in sentence(whole)
    # of infinitely many, which have 9 in all
    alone = on_area(replace(one, finite=None, contacts=None, smaller=2), few, machine, contacts)
    alone = replace(alone, finite=())
    assert ", without 2 of 9 slips, below a fifth of the largest" in sentence(alone)


@pytest.mark.parametrize("part", [0.4, 0.93, 1.07, 2.1])
def test_on_the_border_of_steady_sliding_chance_decides_on_slips(part: float) -> None:
    """Of a damping that is a few per cent above or below friction's fall with the speed, 2e-5 F_k/<x_s>, 5,000 contacts
    tell nothing: their force scatters by 1.4 %."""
    contacts = Contacts(WIDE, delay=Delay(2e-5))
    falls = friction_falls(Machine(0.05, 1e-9, 0.0, 1.0), contacts)
    machine = Machine(0.05, 3e-8, part * falls, 1.0)
    few = Finite("mass", 5000, "now and then", 0.60, 1e-3, 0.56, 1e-3, 2.0)
    border = 0.5 < part < 2.0
    for one, said in ((few, border), (Finite("mass", 5000, "smooth"), border)):
        told = sentence(on_area(SLIDES, one, machine, contacts))
        assert (
            f"on the border: friction falls with the speed by {falls:.3g} N_c<k> time" in told
        ) is said
        assert (
            "by chance the force of 5,000 contacts falls by 0.0201 N_c<k>·length or more" in told
        ) is said
    # large slips, and very many contacts, are no chance
    large = replace(few, before=0.7)
    assert "on the border" not in sentence(on_area(SLIDES, large, machine, contacts))
    over = replace(large, kind="smooth", slips=2.0)  # but where they are those of the start
    assert ("on the border" in sentence(on_area(SLIDES, over, machine, contacts))) is border
    many = replace(few, contacts=10**12)
    assert "on the border" not in sentence(on_area(SLIDES, many, machine, contacts))


def test_the_force_of_few_contacts_that_slide_beside_a_mass_fluctuates() -> None:
    """ "smooth at 7.45 ± 0.03 mN" stood for 39 contacts whose force goes from 3.6 to 10.2 mN: the ± is of the mean."""
    machine, contacts = Machine(2.0, 0.5, 0.3, 0.25), Contacts(WIDE)
    few = Finite("mass", 39, "smooth", fluctuation=0.05)
    told = sentence(on_area(SLIDES, few, machine, contacts))
    assert ", fluctuating by ± 0.050 N_c<k>·length with 39 contacts" in told
    for other in (replace(few, fluctuation=5e-4), replace(few, fluctuation=np.nan)):
        assert "fluctuating" not in sentence(on_area(SLIDES, other, machine, contacts))
    swings = replace(SLIDES, swings=(0.0, 0.2), drive=np.array([0.0, 9.0]))
    assert "fluctuating" not in sentence(on_area(swings, few, machine, contacts))


def test_the_way_on_which_contacts_hold_is_that_of_their_share() -> None:
    """It was the mean threshold, also of contacts that heat breaks before: 79 % would hold, beside "68 %"."""
    machine = Machine(0.5, 0.02, 0.1, 2.0)
    contacts = Contacts(WIDE, delay=Delay(1.0))
    told = on_area(SLIDES, Finite("mass", 300, "smooth"), machine, contacts)
    own = replace(told.own, holding=0.2)
    text = "\n".join(dependence(replace(told, answers=(own,))))
    said = "waits while the drive goes on by 2.00 units of length, "
    assert f"{said}and holds while it goes on by 0.500 units of length: 20% of" in text


def test_equal_periods_are_told_once_whatever_their_errors() -> None:
    """Two rules with one period, of which one alone has an error worth showing: they were compared by their texts."""
    machine, contacts = Machine(0.05, None, 0.0, 0.5), Contacts(WIDE)
    one = replace(SLIDES, rule="reset", kind="stick-slip", after=-0.1, slips=9, period=9.09)
    told = on_area(one, Finite("reset", 300, "smooth"), machine, contacts)
    both = one, replace(one, rule="reform-after", period_error=0.2)
    said = sentence(replace(told, answers=(replace(told.own, behaviours=both),), finite=()))
    assert said.count("9.1 ± 0.2 units of length, ") == 1
