"""What a verdict says of delays that nobody followed: between which ones friction makes steady sliding unstable."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scipy import stats

import eq_model
import master
from origins import Ageing, Contacts, Delay, Thermal, gaussian
from toolkit.scene.scale import Scale, spoken
from toolkit.verdict import answers
from toolkit.verdict.files import plain
from toolkit.verdict.sliders.machine import Machine, critical_damping
from toolkit.verdict.sliders.records import Behaviour, not_followed
from toolkit.verdict.sliders.steady import friction_falls, unstable_delays
from toolkit.verdict.text import of_delay
from toolkit.verdict.text.hangs_on import dependence
from toolkit.verdict.text.words import page, sentence

# the machine of MD samples, 50 N/m and 0.1 kg at 1 µm/s with a tenth of critical damping, in N_c<k> = 8e4 N/m
TOTAL, MEAN, SPEED = 8e4, 2.18e-10, 1e-6
HEAVY = Machine(50.0 / TOTAL, 0.1 / TOTAL, 0.0, SPEED)
TENTH = 0.1 * critical_damping(HEAVY)
LAW = gaussian(MEAN, 0.2 * MEAN)
KINETIC = 0.5 * MEAN * 1.04
WITH_BAND = "falls with the speed by more than the damping rises"


def slider(kind: str = "smooth", before: float = KINETIC, **named: Any) -> Behaviour:
    """With mass and the damping that is assumed; one that slips falls below 0."""
    after = before if kind == "smooth" else -0.5 * before
    known = {"kind": kind, "before": before, "after": after, "slips": 5, "error": 1e-9}
    return replace(not_followed("mass", ""), **known, success=True, damping=TENTH, **named)


def told(
    found: Behaviour, turned: Behaviour | None = None, delay: float = 0.0, **named: Any
) -> answers.Verdict:
    """A verdict on these contacts, in SI units."""
    contacts = Contacts(LAW, delay=Delay(delay) if delay else None, **named)
    share = MEAN / (MEAN + SPEED * delay)
    kinetic, static = answers.Quantity(share * KINETIC, 0.0), answers.Quantity(0.7 * MEAN, 0.0)
    scale = Scale(TOTAL, "N", TOTAL, "N/m", "m", "s")
    critical = answers.Quantity(0.4, 0.0)
    own = answers.Answer("own", contacts, scale, kinetic, static, critical, HEAVY, (found,))
    return answers.Verdict("a", "a", SPEED, (own,), (), {}, 1.0, turned)


def test_delays_of_the_documentation_s_scan() -> None:
    """docs/sliders-with-mass.md: 6.2 nm, F_k of 255 mN and 1 N s/m, by a gamma law with that F_k/<x_s>."""
    shape = 1.2263
    law, total = stats.gamma(shape, scale=6.196e-9 / shape), 4.53e7
    low, high = unstable_delays(
        Machine(50.0 / total, 0.1 / total, 1.0 / total, SPEED), Contacts(law)
    )
    assert low == pytest.approx(24e-9, rel=0.02) and high == pytest.approx(26.0 * 60.0, rel=0.02)


@pytest.mark.parametrize("case", [slow(case, when=case >= 12) for case in range(40)])
def test_friction_falls_by_the_damping_at_both_ends_and_by_more_between_them(case: int) -> None:
    """F_k of the master equation's steady state, differentiated, against the roots; none from F/4v on."""
    rng = np.random.default_rng(case)
    law = [gaussian(1.0, 0.3), stats.expon(), stats.weibull_min(3.0)][case % 3]
    mean = Contacts(law).mean_threshold
    velocity = float(10.0 ** rng.uniform(-2.0, 2.0))
    force = master.steady_state(Contacts(law), velocity=velocity).force
    machine = Machine(1e-3, 1e-3 * (10.0 * mean / velocity) ** 2, 0.0, velocity)
    machine = replace(machine, damping=float(rng.uniform(0.01, 0.24)) * force / velocity)
    ends = unstable_delays(machine, Contacts(law))
    assert ends is not None

    def falls(delay: float) -> float:
        waiting = Contacts(law, delay=Delay(delay))
        low, high = (
            master.steady_state(waiting, velocity=part * velocity).force for part in (0.999, 1.001)
        )
        return float((low - high) / (0.002 * velocity))

    for end, inwards in zip(ends, (1.05, 1.0 / 1.05), strict=True):
        assert falls(end) == pytest.approx(machine.damping, rel=1e-4)
        assert falls(end * inwards) > machine.damping > falls(end / inwards)
        waiting = Contacts(law, delay=Delay(end))
        assert friction_falls(machine, waiting) == pytest.approx(machine.damping, rel=1e-9)
    assert (
        unstable_delays(replace(machine, damping=0.2501 * force / velocity), Contacts(law)) is None
    )
    assert unstable_delays(replace(machine, damping=0.0), Contacts(law)) == (0.0, np.inf)


@pytest.mark.parametrize("part", [0.5, 2.0])
def test_swings_grow_from_the_least_of_these_delays_on(part: float) -> None:
    """Sliders of a few contacts, which chance sets swinging; with a delay of half the least they hardly do."""
    law = gaussian(1.0, 0.5)
    machine = Machine(0.01, 0.01 * (20.0 / np.pi) ** 2, 0.06, 1.0)
    low, _ = unstable_delays(machine, Contacts(law)) or (0.0, 0.0)
    found = eq_model.simulate(
        Contacts(law, delay=Delay(part * low)),
        np.linspace(0.0, 1000.0, 1001),
        n_contacts=500,
        n_replicas=2,
        seed=1,
        **machine.keywords("mass"),
    )
    swings = np.ptp(found.forces[:, -300:], axis=1)
    assert (swings > 0.1).all() if part > 1.0 else (swings < 0.05).all()


def test_delays_of_other_laws_and_of_slow_drives_are_not_told() -> None:
    """Where a swing passes no threshold contacts act as springs, and other laws give friction another fall."""
    machine = replace(HEAVY, damping=TENTH)
    assert unstable_delays(machine, Contacts(LAW)) is not None
    assert unstable_delays(replace(machine, velocity=1e-10), Contacts(LAW)) is None
    linked = Contacts(LAW, stiffness="linked")
    aged = Contacts(LAW, ageing=Ageing(gaussian(2.0 * MEAN, MEAN), 1.0))
    assert unstable_delays(machine, linked) is None and unstable_delays(machine, aged) is None
    assert unstable_delays(replace(machine, mass=None), Contacts(LAW)) is None


def test_that_both_ends_of_the_delay_slide_does_not_clear_those_between() -> None:
    """F/γv = 20.3: delays of 0.055 to 18 <x_s>/v = 218 µs, beside the headline alone; the line of the delay says so."""
    late = slider(before=TENTH * SPEED)
    for turned, delay in ((late, 0.0), (late, 0.1), (slider(), 0.1), (None, 0.1)):
        found = told(slider(), turned, delay)
        ratio = KINETIC / (TENTH * SPEED) - 2.0
        larger = np.roots([1.0, -ratio, 1.0]).max()
        low, high = (spoken(MEAN / SPEED * one, "s") for one in (1.0 / larger, larger))
        between = f"With a delay between {low} and {high} friction {WITH_BAND}"
        (line,) = (one for one in dependence(found) if "contacts' delay" in one)
        assert line.startswith("the contacts' delay: ")
        assert WITH_BAND not in line and (("told above" in line) is bool(delay) or turned is late)
        longer = "; with somewhat longer ones it may go on to slip once it has begun" * (not delay)
        (told_once,) = (one for one in page(found) if "swings or slips" in one)
        assert told_once in page(found)[3:5] and told_once.startswith(f"  {between}")
        assert f"swings or slips{longer} (not followed)" in told_once
        assert between in plain(found)["would_turn"][-1]
    # nor where the one that is given is among them, and the slider slides about F_k all the same
    lines = dependence(told(slider(), slider(), 1e-3))
    assert "does the same. With a delay" in "".join(lines) and "as with this one" in "".join(lines)
    assert not any("not the contacts' delay" in one for one in lines)
    for damping in (TENTH, 10.0 * TENTH):
        damped = replace(slider(), damping=damping)
        found = told(damped, replace(damped, before=1.001 * KINETIC))
        lines = dependence(found)
        cleared = any(one.startswith("not the contacts' delay") for one in lines)
        assert cleared is (damping > TENTH)
        assert any(WITH_BAND in one for one in page(found)) is (damping == TENTH)


def test_a_slider_that_slips_with_its_delay_is_told_where_friction_ceases_to_fall() -> None:
    """With 1 ms it slips; above 4.9 ms friction falls by less than the damping rises. In heat it is said without it."""
    slips = slider("stick-slip", before=1.2 * KINETIC)
    lines = dependence(told(slips, slider(), 1e-3))
    (line,) = (one for one in lines if one.startswith("the contacts' delay: another one"))
    assert "ms, as with this one, friction falls" in line and "not followed" not in line
    assert line.count(WITH_BAND) == 1 and not any("make it swing" in one for one in lines)
    warm = Thermal(law="stiff", temperature=1e-6 * MEAN**2, attempt_frequency=1e6)
    found = told(slider(), slider(before=0.5 * KINETIC), thermal=warm)
    assert "  Without heat, with a delay between" in "\n".join(page(found))
    # which tells nothing where heat takes nearly all of F_k
    strong = replace(found.own, cold=answers.Quantity(100.0 * KINETIC, 0.0))
    assert WITH_BAND not in "\n".join(page(replace(found, answers=(strong,))))


def test_a_slider_that_is_not_decided_has_the_delays_between_its_extremes() -> None:
    undecided = replace(not_followed("mass", "too long"), damping=TENTH)
    each = [replace(slider(), rule=rule) for rule in ("reset", "reform-after", "instant")]
    found = told(undecided, None, 0.2)
    found = replace(found, answers=(replace(found.own, behaviours=(undecided, *each)),))
    assert "; with a delay between " in sentence(found) and "it swings or slips" in sentence(found)


def test_a_slip_that_lasts_as_long_as_its_loading_has_no_delay_between() -> None:
    """141 ms of a slip and 246 ms of its loading have no delay far above and far below them; 800 and 0.3 have."""
    for force, between in ((12.3e-6 / TOTAL, False), (120e-6 / TOTAL, True)):
        own = told(slider("stick-slip", before=force), None, 1e-3).own
        said = of_delay.of_short_delays(own)
        assert ("of a slip, and far below the" in said) is between
        never = "about as long as the 246 ms in which the drive loads the spring"
        assert (never in said) is not between
        assert ("no delay is far above the one and far below the other" in said) is not between


def test_a_damping_that_is_assumed_says_why_and_where_less_of_it_is_unstable() -> None:
    """-dF_k/dv with 1 ms, of the closed form; all of the critical damping only where a tenth rings on."""
    for delay in (0.0, 1e-3):
        (line,) = (one for one in dependence(told(slider(), None, delay)) if "damping: none" in one)
        assert "give drive.damping, the machine's own. " in line
        assert "The assumed one is no property of" in line
        text = "\n".join(page(told(slider(), None, delay)))
        assert text.count("% of critical") == text.count("0.447 N s/m") == 1, text
        falls = TOTAL * KINETIC * 1e-3 / MEAN / (1.0 + SPEED * 1e-3 / MEAN) ** 2
        assert (f"Below {falls:.3g} N s/m, as here, friction of contacts" in line) is bool(delay)
        assert ("steady sliding is unstable" in line) is bool(delay)
    full = replace(slider(), damping=10.0 * TENTH)
    (line,) = (one for one in dependence(told(full)) if "damping: none" in one)
    assert (
        "without one, or with a tenth of critical damping, the slider rings for too long: g" in line
    )
    text = "\n".join(page(told(full)))
    assert "100% of critical" in text and text.count("% of critical") == 1
