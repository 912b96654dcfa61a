"""A slider that heat lets go on too slowly for steps is told by steady sliding: what the page says, and whether it
holds where the slider can be followed."""

import re
import time
from dataclasses import replace
from functools import cache, reduce
from operator import mul
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scipy import stats

import eq_model
import master
from master.steady.response import is_stable
from master.steady.with_mass import decays, sliding_is_stable, unstable_below
from origins import Contacts, Delay, InputError, Thermal, gaussian, identical, strengthening
from origins.drive import RISE
from tests.test_creep import CatchBonds
from tests.verdicts import STATED, judged, reading, verdict_on
from toolkit.results.kinds import kind_of
from toolkit.verdict.sliders.follow import follow
from toolkit.verdict.sliders.in_heat import by_steady_sliding, looked_at, with_stability
from toolkit.verdict.sliders.machine import Machine, RigidSlider, rigid_slider
from toolkit.verdict.sliders.records import Behaviour, not_followed
from toolkit.verdict.text.hangs_on import dependence
from toolkit.verdict.text.words import sentence

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")

WIDE = gaussian(1.0, 0.3)
STRONG = Contacts(WIDE, thermal=Thermal("soft", 0.4, 50.0))
WEAK = Contacts(WIDE, thermal=Thermal("soft", 0.003, 50.0))
HEAVY = Machine(spring=0.3, mass=0.05, damping=0.1, velocity=1.0)


@cache
def rigid(contacts: Contacts, velocity: float) -> RigidSlider:
    """What is known without a spring."""
    steady = master.steady_state(contacts, velocity=velocity)
    found = master.propensity(contacts, velocity=velocity, tolerance=1e-3)
    return rigid_slider(contacts, steady, found, None)


def told(machine: Machine, contacts: Contacts, rule: str = "mass") -> Behaviour | None:
    """What steady sliding says."""
    return by_steady_sliding(
        machine,
        contacts,
        rule,
        rigid(contacts, machine.velocity),
        time.monotonic() + 1e4,
        lambda cold, known: follow(machine, cold, rule, known, 1e4),
    )


def test_disturbances_decay_where_all_roots_of_a_polynomial_say_so() -> None:
    """Of contacts that are springs and dampers in series, stiff ones that pull and some that push: numpy finds the
    roots of D(p). With 1e-3 of noise on G, as its sums have, no drawn machine is called wrongly."""
    rng, seen = np.random.default_rng(2), list[tuple[bool, bool | None]]()
    for _ in range(300):
        times = 10.0 ** rng.uniform(-2.0, 1.0, rng.integers(1, 4))
        stiff = 10.0 ** rng.uniform(-3.0, 0.0, times.size) * rng.choice(
            [1.0, 1.0, -1.0], times.size
        )
        spring, inertia = 10.0 ** rng.uniform(-5.0, 0.5), 10.0 ** rng.uniform(-4.0, 1.0)
        inertia, drag = inertia * rng.integers(0, 2), 10.0 ** rng.uniform(-4.0, 0.0)
        each = [np.poly1d([one, 1.0]) for one in times]
        whole = reduce(mul, each, np.poly1d([inertia, drag, spring]))
        for number, (one, pull) in enumerate(zip(times, stiff, strict=True)):
            others = each[:number] + each[number + 1 :]
            whole += reduce(mul, others, np.poly1d([pull * one, 0.0]))
        slow = np.sqrt(spring / inertia) if inertia else np.inf
        fast = np.sqrt((spring + 1.0) / inertia) if inertia else 0.0
        wave = np.geomspace(min(1e-3, 0.1 * slow), max(300.0, 10.0 * fast), 120)
        swing = 1j * wave[:, None] * times
        answer = (stiff * swing / (1.0 + swing)).sum(axis=1)
        answer *= 1.0 + 1e-3 * rng.standard_normal((2, wave.size)).T @ np.array([1.0, 1j])
        found = decays(wave, answer, spring, inertia, drag)
        seen.append((bool((whole.roots.real < 0.0).all()), found))
    assert all(one in (truth, None) for truth, one in seen)
    for truth in (True, False):
        clear = [one for stable, one in seen if stable == truth]
        assert len(clear) > 30 and clear.count(None) < 0.5 * len(clear)


def test_a_mass_that_nothing_damps_but_contacts_is_stable_where_friction_rises() -> None:
    """Without a mass it is what `is_stable` says; a damping below 0 that is larger than the rise of friction with the
    speed lets swings grow, on a spring so soft that a swing passes many thresholds."""
    assert sliding_is_stable(STRONG, 1.0, 0.3) and is_stable(STRONG, 1.0, 0.3)
    spring, mass, near = 1e-3, 0.1, 1e-3
    up, down = (master.steady_state(STRONG, velocity=1.0 + step).force for step in (near, -near))
    rise = (up - down) / (2.0 * near)
    assert rise > 0.01 and sliding_is_stable(STRONG, 1.0, spring, mass)
    assert sliding_is_stable(STRONG, 1.0, spring, mass, -0.8 * rise)
    assert sliding_is_stable(STRONG, 1.0, spring, mass, -1.2 * rise) is False


def test_sliding_is_unstable_below_the_spring_that_the_answer_of_the_force_tells() -> None:
    """Growing contacts in heat: by steps of the speed `rate-state` solves 0.0201 ± 0.0029. Of contacts that break less
    the more they are stretched G swings on to the fastest disturbances, and nothing is told."""
    assert np.isnan(unstable_below(Contacts(WIDE, thermal=CatchBonds()), 0.1, 1e-2))
    assert unstable_below(STRONG, 1.0, 1e-3) == 0.0
    heat = Thermal("eyring", width=0.03, attempt_frequency=1e4)
    growing = Contacts(strengthening(WIDE, beta=0.1, time=0.1), thermal=heat)
    assert abs(unstable_below(growing, 1e-2, 1e-4) - 0.0201) < 0.0029


@pytest.mark.slow  # quick: a mass without damping, where a slider is not decided, below
def test_a_mass_that_swings_on_a_spring_is_as_unstable_unless_it_is_damped() -> None:
    heat = Thermal("eyring", width=0.03, attempt_frequency=1e4)
    growing = Contacts(strengthening(WIDE, beta=0.1, time=0.1), thermal=heat)
    assert unstable_below(growing, 1e-2, 1e-3, 0.1) > 0.015
    assert unstable_below(growing, 1e-2, 1e-3, 0.1, 10.0) == 0.0


def test_a_slider_that_is_not_decided_says_whether_steady_sliding_is_stable() -> None:
    """In the bracket of the reason, once; nothing where it is not known."""
    heat = Thermal("eyring", width=0.03, attempt_frequency=1e4)
    growing = Contacts(strengthening(WIDE, beta=0.1, time=0.1), thermal=heat)
    late, machine = not_followed("mass", "takes 9 steps; loosen it"), Machine(1e-3, 0.1, 0.0, 1e-2)
    found = with_stability(late, machine, growing)
    own = reading(found, contacts=growing, machine=machine, kinetic=0.5)
    said = sentence(verdict_on(own, velocity=1e-2))
    told = r"not decided \(takes 9 steps; steady sliding is unstable on springs below 0.0\d+ N_c<k>, so that it "
    told += r"swings or slips on\)"
    assert re.fullmatch(told, said)
    undamped = "comes to it is not known: give drive.damping)"
    for below, words in ((0.0, undamped), (np.nan, "9 steps)")):
        each = replace(own, behaviours=(replace(found, unstable_below=below),))
        assert words in sentence(verdict_on(each, velocity=1e-2))
    assert with_stability(late, machine, Contacts(WIDE)) is late
    assert with_stability(replace(late, slips=2), machine, growing).unstable_below is None


@pytest.mark.parametrize("spring", [slow(1e-4), 1e-3, slow(1e-2)])
@pytest.mark.parametrize(
    "heat",
    [
        Thermal("stiff", 0.82, 1e6),
        slow(Thermal("soft", 2.4, 2e11)),
        slow(Thermal("soft", 10, 1e11)),
    ],
)
def test_contacts_that_hardly_hold_damp_a_mass(spring: float, heat: Thermal) -> None:
    """They bear 1e-6 to 1e-11 of a threshold, in proportion to the speed: nothing but friction that rises. Sums of
    their answer to slow swings are rounding, which was told as unstable."""
    loose = Contacts(WIDE, thermal=heat)
    force = master.steady_state(loose, velocity=1.0).force
    assert force < 1e-5
    assert master.steady_state(loose, velocity=2.0).force == pytest.approx(2.0 * force, rel=0.1)
    for mass in (1.0, 100.0):
        assert sliding_is_stable(loose, 1.0, spring, mass) is not False
        damped = sliding_is_stable(loose, 1.0, spring, mass, 1e-3)
        # of contacts in stiff heat it is known
        assert damped or (damped is None and (heat.law, mass) != ("stiff", 1.0))


@pytest.mark.parametrize(("contacts", "slips"), [slow(STRONG, 0), (WEAK, 1)])
def test_finitely_many_contacts_slide_as_steady_sliding_tells(
    contacts: Contacts, slips: int
) -> None:
    """By heat that lets nothing slip, and by weak heat after one slip: 1,000 contacts bear the force that is told, and
    do not slip again."""
    found = told(HEAVY, contacts)
    assert found is not None and (found.kind, found.slips, found.success) == ("smooth", slips, True)
    assert (found.heat_on_the_way or 0.0) > 0.0 if slips else found.heat_on_the_way == 0.0
    path = np.linspace(0.0, 30.0, 121)
    few = eq_model.simulate(
        contacts, path, n_contacts=1000, n_replicas=4, seed=3, **HEAVY.keywords("mass")
    )
    late = few.forces[:, path > 18.0].mean(axis=1)
    off = late.std(ddof=1) / np.sqrt(late.size)
    assert abs(late.mean() - found.before) < 5.0 * off < 0.02
    assert np.all(few.slips.drive < 8.0) and few.slips.drive.size == 4 * slips


@pytest.mark.slow  # its kernel, which no other test needs, is compiled for 7 s
def test_heat_that_steadies_sliding_changes_forces_by_more_than_a_slip() -> None:
    """Samples of molecular dynamics at 300 K were not decided. F_k rises with the speed, and F_s is above it by less
    than without heat; 500 contacts bear the force that is told in the end."""
    contacts = Contacts(WIDE, thermal=Thermal("stiff", 0.01, 1e4))
    found, known = told(HEAVY, contacts), rigid(contacts, 1.0)
    assert found is not None and (found.kind, found.success) == ("smooth", True)
    assert (found.heat_on_the_way or 0.0) > 5.0 * RISE and known.static - known.kinetic > RISE
    path = np.linspace(0.0, 30.0, 121)
    asked = HEAVY.keywords("mass")
    few = eq_model.simulate(contacts, path, n_contacts=500, n_replicas=4, seed=3, **asked)
    late = few.forces[:, path > 22.0].mean(axis=1)
    assert abs(late.mean() - found.before) < 5.0 * late.std(ddof=1) / 2.0 < 0.02
    assert few.slips.drive.max(initial=0.0) < 8.0


def test_stable_sliding_tells_nothing_where_slower_sliding_bears_more() -> None:
    """Heat leaves the contacts of high thresholds to a slow slider, which slides at 3.5 <x_s> where a fast one does at
    3.0: from the relaxed start it slips on, as 2,000 contacts do, beside steady sliding that is stable."""
    broad = Contacts(stats.expon(), thermal=Thermal("stiff", 0.05, 1.0), stiffness="linked")
    machine = Machine(spring=0.003, mass=0.1, damping=0.0006, velocity=10.0)
    assert sliding_is_stable(broad, 10.0, 0.003, 0.1, 0.0006)
    assert told(machine, broad) is None
    slow, fast = (
        master.steady_state(broad, velocity=one).force for one in (looked_at(machine)[0], 10.0)
    )
    assert slow - fast > 20.0 * RISE


@pytest.mark.slow  # some 40 s; quick: the forces above
def test_a_slider_slips_on_beside_stable_sliding_where_slower_sliding_bears_more() -> None:
    broad = Contacts(stats.expon(), thermal=Thermal("stiff", 0.05, 1.0), stiffness="linked")
    machine = Machine(spring=0.003, mass=0.1, damping=0.0006, velocity=10.0)
    few = eq_model.simulate(
        broad, np.linspace(0.0, 3000.0, 601), n_contacts=2000, seed=1, **machine.keywords("mass")
    )
    assert few.slips.drive.size >= 3 and few.slips.drop.min() > 20.0 * RISE


@pytest.mark.slow  # some 20 s; quick: the ensemble above
def test_a_slider_that_can_be_followed_slides_as_steady_sliding_tells() -> None:
    found = told(HEAVY, WEAK)
    solved: Any = master.solve(WEAK, np.linspace(0.0, 14.0, 200), 1e-2, **HEAVY.keywords("mass"))
    assert found is not None and kind_of(solved) == found.kind and solved.slips.drive.size == 1
    assert solved.force[-1] == pytest.approx(found.before, abs=solved.force_error + 1e-6)


def test_steady_sliding_tells_of_no_other_slider() -> None:
    """Of contacts under another law than heat; of exact thresholds; of a swing that nothing damps; and of rules that
    renew contacts in slips."""
    assert told(HEAVY, STRONG.replace(delay=Delay(1.0))) is None
    assert told(HEAVY, STRONG.replace(thresholds=identical(1.0))) is None
    assert told(Machine(0.3, 0.05, 0.0, 1.0), STRONG) is None
    assert told(HEAVY, WEAK, "reset") is None


@pytest.mark.parametrize(
    ("off", "how"),
    [(0.01, "followed without heat"), (0.1, "followed without heat"), (0.0, "not followed")],
)
def test_the_sentence_tells_how_the_way_to_steady_sliding_was_followed(
    off: float, how: str
) -> None:
    """Beside what was looked at, which the page tells below."""
    slides = replace(not_followed("mass", ""), kind="smooth", success=True, before=0.26, after=0.26)
    slides = replace(slides, error=1e-9, heat_on_the_way=off)
    told = verdict_on(reading(slides, contacts=STRONG, machine=HEAVY, kinetic=0.26))
    assert re.match(rf"smooth at \S+ .*in the end \(the way there was {how}\)", sentence(told))
    (line,) = (each for each in dependence(told) if "was not followed, as it goes on" in each)
    changed = "heat changes F_k and F_s by 0.010 N_c<k>·length at most, less than" in line
    steadies = "changes F_k and F_s by 0.10 N_c<k>·length at most, more than what counts as a slip"
    assert (steadies in line and "but steadies: F_k rises" in line) == (off > 0.02)
    assert (changed or steadies in line) == bool(off) and (
        "no force is above that of faster sliding" in line
    ) != bool(off)


@pytest.mark.slow  # 4 s; quick: the sentence, above
def test_the_page_tells_what_was_followed_and_what_heat_may_change(
    capsys: Any, monkeypatch: Any
) -> None:
    """300 K on barriers of 1e4 k_BT, 50 N/m and 0.1 kg: 2,000 steps in heat end in the first loading."""
    solve = master.solve

    def stepped(contacts: Contacts, *arguments: Any, **named: Any) -> Any:
        if contacts.thermal is not None:
            raise InputError("path[-1]: takes 2001 steps")
        return solve(contacts, *arguments, **named)

    monkeypatch.setattr(master, "solve", stepped)
    stated = STATED | {"thermal": {"law": "stiff", "temperature": {"kelvin": 300.0}}}
    stated["thermal"]["attempt_frequency"] = 1e10
    drive = {"spring": "50 N/m", "mass": "0.1 kg", "damping": "0.5 N s/m"}
    drive |= {"area": 1e-6, "velocity": 1e-6}
    status, page, found = judged(capsys, contacts=stated, drive=drive)
    (one,) = found["readings"][0]["behaviours"]
    assert (status, one["kind"], one["slips"]) == (0, "smooth", 1)
    assert one["before"] == pytest.approx(found["readings"][0]["kinetic"]["value"] + 5e-7, rel=1e-9)
    headline = page.splitlines()[2]
    assert headline.startswith("if contacts form again at once, as no delay is given: smooth at ")
    assert "in the end (the way there was followed without heat)" in headline
    reasons = "\n".join(found["hangs_on"])
    assert "the slips before it from contacts without heat" in reasons
    assert "what is told follows from steady sliding" in page
    assert "not decided" not in page
    assert 0.0 < one["heat_on_the_way"] < 0.02
