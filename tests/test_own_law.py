"""Laws of one's own by which thresholds change, those of docs/extending.md among them: solvers take them, by
quadratures and a plain twin, or refuse them in one line."""

from __future__ import annotations

import ast
import math
import re
import subprocess
import sys
from copy import copy
from pathlib import Path

import numpy as np
import pytest
import scipy.stats
from conftest import slow
from solving import gauss

import eq_model
import master
import origins
from master.survival import make
from master.survival.changing import ChangingLife
from master.survival.life import Survivors
from master.survival.make import LIVES
from origins import (
    ChangingThresholds,
    Contacts,
    GrowingThresholds,
    InputError,
    ProportionalGrowth,
)
from origins.laws.compiled import compiled_rates
from origins.laws.strengthening import Strengthening
from toolkit.running.resampled import like
from toolkit.scene import laws
from toolkit.scene.scene import load_scene
from toolkit.scene.tables import GROWTHS

PC = origins.gaussian(mean=1.0, std=0.2)


class Power(ProportionalGrowth):
    """x_s0 (1 + t/τ)^p."""

    law = "power growth"

    def __init__(self, fresh, power, time, age=0.0):
        super().__init__(fresh, time, age)
        self.power = power

    def factor(self, age):
        return (1.0 + np.asarray(age) / self.time_unit) ** self.power


class Hazards(GrowingThresholds):
    """The same by its hazards alone, without a factor, and without a name."""

    time_unit = 1.0

    def __init__(self, power, age):
        self.power, self.age = power, age
        self.at_start = Power(PC, power, 1.0, age).at_start

    def hazard_at(self, x, pinned_for):
        return -PC.logsf(np.abs(x) / (1.0 + pinned_for) ** self.power)

    def threshold_at(self, hazard, pinned_for):
        return PC.isf(np.exp(-np.asarray(hazard))) * (1.0 + pinned_for) ** self.power


def steady(power, velocity, tau=1.0):
    """F_k: integrals of x E and E, with E(x) = S(x/g(x/v)), up to where one contact in 1e17 breaks."""
    end = far = float(PC.isf(1e-17))
    for _ in range(200):
        end = far * (1.0 + end / velocity / tau) ** power
    x, weights = gauss(np.linspace(0.0, end, 401), 10)
    held = weights * PC.sf(x / (1.0 + x / velocity / tau) ** power)
    return float(held @ x / held.sum())


@pytest.mark.parametrize(
    ("power", "velocity", "tau"),
    [(0.1, 1.0, 1.0), (0.1, 1e-3, 1.0), (0.5, 3.0, 1.0), (0.3, 0.1, 7.0)],
)
def test_steady_sliding_is_a_quadrature(power, velocity, tau):
    found = master.steady_state(Contacts(Power(PC, power, tau)), velocity=velocity)
    assert abs(found.force - steady(power, velocity, tau)) <= found.force_error + 1e-12
    assert found.force_error < 1e-9


@pytest.mark.parametrize("law", [Power(PC, 0.3, 1.0, age=0.5), Hazards(0.3, age=0.5)])
def test_start_and_rest(law):
    """Until their second break: S(max x/g)/S of the start, and births of one age at one place; F after a rest is that
    of contacts which have grown older meanwhile."""
    contacts = Contacts(law, start=origins.gaussian_start(mean=0.2, std=0.01))
    assert contacts.changing is law and contacts.laws == (law.law,) and contacts.older_at_start
    found = master.solve(contacts, [0.3, 0.3, 0.6], time=[0.3, 2.3, 2.6])
    z, weights = gauss(np.linspace(-9.0, 9.0, 200), 5)
    share, x = weights * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi), 0.2 + 0.01 * z
    ages = 0.5 + np.array([0.0, 0.3, 2.3, 2.6])[:, None]
    ratio = (x + np.array([0.0, 0.3, 0.3, 0.6])[:, None]) / (1.0 + ages) ** 0.3
    held = share * PC.sf(ratio.max(axis=0)) / PC.sf(ratio[0])
    # of the start alone: later contacts are stretched by less than 0.6, and hold but for a few
    assert found.force[-1] >= float(held @ (x + 0.6)) - found.force_error
    first = share * PC.sf(np.maximum(ratio[0], ratio[1])) / PC.sf(ratio[0])
    assert abs(found.force[0] - float(first @ (x + 0.3))) < 5e-4 and found.success


@pytest.mark.slow
@pytest.mark.parametrize("law", [Power(PC, 0.3, 1.0, age=0.5), Hazards(0.3, age=0.5)])
def test_the_ensemble_agrees(law):
    """On a path that rests and turns, at all points; and without an entry in any table."""
    contacts = Contacts(law, delay=origins.Delay(0.1))
    path, time = [0.5, 1.2, 1.2, 0.1, -1.2, 1.5], [0.5, 1.2, 4.2, 5.3, 6.6, 9.3]
    exact = master.solve(contacts, path, time=time, tolerance=1e-6)
    found = eq_model.simulate(contacts, path, time=time, n_contacts=2000, seed=3)
    error = np.hypot(found.force_standard_error, exact.force_error)
    assert (np.abs(found.force - exact.force) < 4.5 * error).all() and exact.success
    assert np.abs(found.holding - exact.holding).max() < 4.5 * np.sqrt(0.25 / 2000)


class Convex(Power):
    def factor(self, age):
        return 1.0 + (np.asarray(age) / self.time_unit) ** 2


class OfOneAge(Power):
    def factor(self, age):
        return float(np.mean(super().factor(age)))


class OfOneNumber(Power):
    def factor(self, age):
        return 1.0 + math.log1p(age)


class OfARow(Power):
    def factor(self, age):
        return np.array([super(OfARow, self).factor(one) for one in np.ravel(age)])


class BeginsAt2(Power):
    def factor(self, age):
        return 1.0 + super().factor(age)


class NotInverse(Hazards):
    def threshold_at(self, hazard, pinned_for):
        return 2.0 * super().threshold_at(hazard, pinned_for)


class OfOneStretch(Hazards):
    def hazard_at(self, x, pinned_for):
        return float(x) / float(pinned_for)


class OfOneSign(Hazards):
    def hazard_at(self, x, pinned_for):
        return np.maximum(np.sign(x), 0.0) * super().hazard_at(x, pinned_for)


class OfAnotherAge(Hazards):
    def __init__(self, power, age):
        super().__init__(power, age)
        self.at_start = PC


class Shrinks(Power):
    def factor(self, age):
        return 1.0 / super().factor(age)


class Delay(Power):
    law = "delay"


SHAPES = "must take arrays of any shape and return the same shape"


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (Convex(PC, 0.1, 7.0), r"thresholds \(power growth\): factor must be concave, and rises"),
        (BeginsAt2(PC, 0.1, 7.0), r"thresholds \(power growth\): factor\(0\) is 2 and must be 1"),
        (OfOneAge(PC, 0.1, 7.0), rf"factor {SHAPES}; for the shape \(2, 4\) it returns \(\)"),
        (OfARow(PC, 0.1, 7.0, age=1.0), rf"{SHAPES}; for the shape \(\) it returns \(1,\)"),
        (OfOneNumber(PC, 0.1, 7.0), rf"\(power growth\): factor {SHAPES}; .* ends in TypeError: "),
        (BeginsAt2(PC, 0.1, 7.0, age=1.0), r"factor\(0\) is 2 and must be 1"),
        (
            OfOneStretch(0.1, 1.0),
            rf"hazard_at {SHAPES}; for the shape \(7, 3\) it ends in TypeError",
        ),
        (NotInverse(0.1, 1.0), r"hazard_at at threshold_at\(hazard, age\) is not that hazard"),
        (OfOneSign(0.1, 1.0), r"hazard_at\(-x, age\) is not hazard_at\(x, age\)"),
        (OfAnotherAge(0.1, 1.0), "at_start is not the law of thresholds at the age of the start"),
        (Shrinks(PC, 0.1, 1.0), "factor must not fall with the age"),
        (Delay(PC, 0.1, 1.0), "is the name of another law"),
    ],
)
def test_a_law_that_solvers_would_follow_wrongly_is_refused(law, said):
    with pytest.raises(InputError, match=said) as refused:
        Contacts(law)
    assert "\n" not in str(refused.value)


class Unstated(Power):
    """It forgets to call super().__init__."""

    def __init__(self, power):
        self.power = power


class Startless(Hazards):
    """Without the law of thresholds at X = 0."""

    def __init__(self):
        self.power = 0.1


class OfScipy(Hazards):
    """Its law at X = 0 is none of origins."""

    def __init__(self):
        super().__init__(0.1, 0.0)
        self.at_start = scipy.stats.norm(1.0, 0.1)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (OfScipy(), "at_start must be a law of origins; write"),
        (Unstated(0.1), "not set: fresh, time_unit; call super"),
        (Startless(), "not set: at_start; set them in"),
    ],
)
def test_a_law_that_has_not_set_what_is_needed_says_what_and_where(law, says):
    with pytest.raises(InputError, match=says):
        Contacts(law)


class FromNothing(GrowingThresholds):
    """x_s = η v_0 a/(1 + a), of a hazard η, an age a: below η = v/v_0 it never holds on a slider of the speed v."""

    fastest, age, time_unit, begins_at_0, quick_width = 5.0, 2.0, 1.0, True, 1.0

    def __init__(self):
        self.at_start = Contacts(scipy.stats.expon(scale=self.fastest * 2.0 / 3.0)).thresholds

    def hazard_at(self, x, pinned_for):
        return np.abs(x) * (1.0 + 1.0 / np.maximum(pinned_for, 1e-300)) / self.fastest

    def threshold_at(self, hazard, pinned_for):
        return hazard * self.fastest * np.asarray(pinned_for) / (1.0 + np.asarray(pinned_for))

    def lost_hazard(self, velocity):
        return velocity / self.fastest


def test_contacts_that_never_hold_on_a_fast_slider_are_as_many_when_it_moves_back():
    """The speed that `lost_hazard` gets has no sign; laws of grains are even in it, and do not tell."""
    contacts, path = Contacts(FromNothing()), np.linspace(0.0, 6.0, 25)[1:]
    asked = {"spring": 3.0, "velocity": 2.0, "wall_time": 60.0}
    there, back = (master.solve(contacts, sign * path, 1e-3, **asked) for sign in (1.0, -1.0))
    assert there.success, there.message
    assert back.success, back.message
    assert np.abs(there.force + back.force).max() < 1e-12
    # on the same way as this soft slider goes, it bears the same force, and a fourth of those born never hold
    rigid = master.solve(contacts, there.position, 1e-6, time=path / 2.0)
    far = there.force_error + rigid.force_error + 1e-3  # straight between the points
    assert np.abs(rigid.force - there.force).max() < far * contacts.mean_threshold


@pytest.mark.parametrize("age", [0.0, 0.5])
def test_what_a_law_inherits_follows_from_its_hazards(age):
    by_factor, by_hazards = Power(PC, 0.3, 1.0, age), Hazards(0.3, age)
    assert by_hazards.older_at_start == by_factor.older_at_start == (age > 0.0)
    ratio = ((3.0 + age) / (1.0 + age)) ** 0.3
    for law in (by_factor, by_hazards):
        assert law.typical_threshold(1.1, 2.0) == pytest.approx(1.1 * ratio, rel=1e-12)
        assert law.largest_threshold(2.5, 1e-17, 2.0) == pytest.approx(2.5 * ratio, rel=1e-9)


@pytest.mark.parametrize("name", ["thermal", "ageing", "delay", "start"])
def test_a_law_in_another_law_s_place_is_named_by_its_class(name):
    """Its address would tell nothing."""
    with pytest.raises(InputError, match=rf"^{name} = Power\(\.\.\.\): must be"):
        Contacts(PC, **{name: Power(PC, 0.1, 1.0)})
    assert repr(Contacts(Power(PC, 0.1, 1.0))).startswith("Contacts(thresholds=Power(...), ")


class OfRoot(Strengthening):
    """Made from a compiled law, whose numbers its own functions for compiled loops share."""

    law = "of root"

    def factor(self, age):
        return np.sqrt(1.0 + self.beta * np.asarray(age) / self.time_unit)

    def compiled(self):
        found = super().compiled()
        return found._replace(
            factor=lambda law, age: (1.0 + law.beta * age) ** 0.5,
            slope=lambda law, age: 0.5 * law.beta * (1.0 + law.beta * age) ** -0.5,
        )


@pytest.mark.slow  # its kernel, which no other test needs, is compiled for 8 s
@pytest.mark.parametrize(("number", "power"), [(1000, 0.1), (4000, 0.05)])
def test_a_law_made_from_a_compiled_one_is_not_taken_for_it(number, power):
    """Nor that for it: its kernel stood on disk in place of the other's, for all processes that came later. A law of
    one's own is called, as no kernel on disk is told apart by its source."""
    law = OfRoot(PC, beta=0.3, time=2.0)
    assert law.compiled() is not None and law.compiled_factor is None
    path, asked = np.array([8.0]), {"velocity": 0.1}
    for each in (law, Strengthening(PC, beta=0.3, time=2.0)):
        contacts = Contacts(each)
        exact = master.solve(contacts, path, 1e-4, **asked)
        found = eq_model.simulate(contacts, path, n_contacts=number, n_replicas=4, seed=1, **asked)
        off = abs(found.force[0] - exact.force[0])
        assert off < 4.0 * found.force_standard_error[0] < power * exact.force[0]


def test_rates_compiled_outside_the_package_are_called():
    """As of growth: no kernel on disk has them, and breaks are counted as those of a law that is called."""
    rates = origins.Thermal("soft", 0.01).rates
    given = rates.compiled()

    class OwnRates(type(rates)):
        def compiled(self):
            return given._replace(log_rate=lambda law, x, threshold, stiffness: 0.0)

    own = OwnRates(rates.temperature, rates.attempt_frequency)
    assert compiled_rates(rates) is not None
    assert compiled_rates(own) is None


@pytest.mark.slow
def test_the_ensemble_agrees_on_a_spring():
    """By any factor, also of a class that is made from a compiled one: its own was once that with the logarithm."""

    path = np.linspace(0.5, 6.0, 12)
    asked = {"velocity": 0.1, "spring": 0.5, "slip": "instant"}
    for law in (Power(PC, 0.2, 0.5, age=3.0), OfRoot(PC, beta=0.1, time=2.0)):
        exact = master.solve(Contacts(law), path, 1e-3, **asked)
        found = eq_model.simulate(
            Contacts(law), path, n_contacts=2000, n_replicas=8, seed=3, **asked
        )
        error = np.hypot(found.force_standard_error, exact.force_error)
        assert (np.abs(found.force - exact.force) < 4.5 * error).all() and exact.success
        stays = eq_model.simulate(
            Contacts(law.at_start), path, n_contacts=2000, n_replicas=8, seed=3, **asked
        )
        assert (np.abs(stays.force - exact.force) > 9.0 * error).any()  # it would be told apart


# of each law of growth that scenes know by its name, one with numbers
NAMED = {"strengthening": Strengthening(PC, beta=0.04, time=0.5)}


@pytest.mark.parametrize("name", GROWTHS)
def test_a_compiled_factor_is_the_law_s(name):
    """With its slope, in its unit of ages; a class with another factor has none that is compiled."""
    law, ages = NAMED[name], np.geomspace(1e-3, 1e6, 30)
    found = law.compiled_factor
    factor = law.factor(law.time_unit * ages)
    np.testing.assert_allclose(found.factor(found.law, ages), factor, rtol=1e-14)
    between = found.factor(found.law, 1.001 * ages) - found.factor(found.law, 0.999 * ages)
    np.testing.assert_allclose(found.slope(found.law, ages), between / (0.002 * ages), rtol=1e-5)
    other = copy(law)
    other.__class__ = type("Other", (type(law),), {"factor": lambda self, age: 1.0 + 0.0 * age})
    assert other.compiled_factor is None


class Root(Strengthening):
    """As scenes would know it."""

    law = "root"

    def __init__(self, thresholds, power, time, age=0.0):
        super().__init__(thresholds, 0.0, time, age)
        self.power = power

    def factor(self, age):
        return (1.0 + np.asarray(age) / self.time_unit) ** self.power


def test_a_scene_takes_a_law_of_growth_by_one_line(monkeypatch):
    """Its keys are the parameters of its class but P_c, which is that of the scene; other samples grow alike."""
    monkeypatch.setitem(laws.CONTACTS, "strengthening", f"{__name__}:Root")
    thresholds = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    table = {"power": 0.2, "time": 3.0, "age": 1.0}
    scene = {"contacts": {"thresholds": thresholds, "strengthening": table}}
    contacts = load_scene(scene, solved=False).contacts
    assert isinstance(contacts.changing, Root) and contacts.laws == ("root",)
    assert contacts.mean_threshold == pytest.approx((4.0 / 3.0) ** 0.2)
    wide = like(contacts, origins.gaussian(1.0, 0.3))
    assert wide.thresholds.std() == pytest.approx(
        origins.gaussian(1.0, 0.3).std() * (4.0 / 3.0) ** 0.2
    )
    with pytest.raises(InputError, match=r"contacts\.strengthening\.beta = 0\.1: unknown key"):
        table["beta"] = 0.1
        load_scene(scene, solved=False)


OF_ORIGINS = """
import origins
class Root(origins.Strengthening):
    law = "square root"
def root(thresholds: object, half: float, time: float) -> Root:
    return Root(thresholds, 2.0 * half, time)
class OfPython(Root):
    law = "a law that no function of origins makes"
origins.Root, origins.OfPython, origins.square_root = Root, OfPython, root
from toolkit import load_scene
thresholds = {"kind": "identical", "value": 1.0}
own = {"contacts": {"thresholds": thresholds, "square_root": {"half": 0.25, "time": 2.0}}}
law = load_scene(own, solved=False).contacts.changing
assert type(law) is Root and law.beta == 0.5 and law.time_unit == 2.0
"""


def test_a_law_of_growth_that_origins_imports_is_a_table_of_scenes():
    """No list in toolkit has to be told of it; a name of two words has _ between them in scenes."""
    subprocess.run([sys.executable, "-c", OF_ORIGINS], check=True)


@pytest.mark.parametrize("law", [Power(PC, 1.0, 1.0), Hazards(1.0, 0.0)])
def test_contacts_that_never_break_are_refused(law):
    """x_s = x_s0 (1 + t/τ) grows at the speed x_s0/τ: slower contacts never meet their thresholds."""
    contacts = Contacts(law)
    fastest = PC.isf(1e-17)  # of contacts that are counted, where the law's time is 1
    with pytest.raises(InputError, match=rf"never break below v = {fastest:.4g}, .*; slide faster"):
        master.steady_state(contacts, velocity=1.0)
    if not isinstance(law, ProportionalGrowth):
        with pytest.raises(InputError, match=rf"contacts\.{law.law}: .*does not take it yet"):
            eq_model.simulate(contacts, [1.0], spring=0.5)


def test_a_factor_that_stays_1_is_no_law():
    assert Contacts(Power(PC, 0.0, 1.0)).laws == ()


def test_the_law_of_older_contacts_begins_as_that_of_fresh_ones():
    """Lengths g times as large, and a density at 0 that is lower by g; scipy's normal has no quantile there."""
    with np.errstate(all="raise", under="ignore"):
        law = Power(scipy.stats.norm(1.0, 0.1), 0.5, 7.0, age=21.0).at_start
        assert law.std() == pytest.approx(0.2, rel=1e-12)
    assert law.pdf(0.0) == pytest.approx(scipy.stats.norm.pdf(0.0, 1.0, 0.1) / 2.0, rel=1e-12)


def test_a_density_that_begins_at_a_finite_value_has_no_onset_power():
    """scipy's cdf of it is rounded near its begin, where a fit gave 3e-4; older contacts then had none at 0."""
    fresh = scipy.stats.truncnorm(-2.0, 3.0, loc=1.0, scale=0.5)
    for law in (Contacts(fresh).thresholds, Contacts(scipy.stats.uniform(0.3, 0.5)).thresholds):
        assert law.onset_power == law.onset_power_error == 0.0
    older = origins.strengthening(fresh, 0.05, 1.0, age=1e3).at_start
    expected = fresh.pdf(0.0) / (1.0 + 0.05 * np.log1p(1e3))
    assert older.pdf(0.0) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("law", [Power(PC, 0.3, 1.0), Hazards(0.3, 0.0)], ids=["factor", "hazards"])
@pytest.mark.parametrize(
    ("other", "says"),
    [
        ({"stiffness": "linked"}, "nothing says whether k_i grows"),
        ({"reforming": 0.1}, "relaxed alone"),
    ],
)
def test_what_no_solver_follows_is_refused_beside_any_growing_thresholds(law, other, says):
    with pytest.raises(origins.InputError, match=says):
        Contacts(law, **other)


def of_page(solved: bool) -> dict:
    """The names that docs/extending.md makes of laws with a memory; without what it solves, which takes seconds, or
    with all of it, also by the ensemble."""
    page = (Path(__file__).parents[1] / "docs" / "extending.md").read_text(encoding="utf-8")
    section = page.split("## A new law with a memory")[1].split("\n## ")[0]
    names = {"np": np, "origins": origins, "master": master, "eq_model": eq_model}
    names |= {"Contacts": Contacts}
    for code in re.findall(r"```python\n(.*?)```", section, re.DOTALL):
        if solved:
            exec(compile(code, "extending.md", "exec"), names)
        elif "eq_model" not in code:
            tree = ast.parse(code)
            tree.body = [part for part in tree.body if "= master." not in ast.unparse(part)]
            exec(compile(tree, "extending.md", "exec"), names)
    said = "{:.6f}, {:.6f} and {:.6f}".format(*names["by_quadrature"])
    assert f"# {said}: at v = 0.01, 0.1 and 0.1" in section
    return names


@pytest.fixture(scope="module")
def page() -> dict:
    return of_page(solved=False)


@pytest.fixture(scope="module")
def whole_page() -> dict:
    return of_page(solved=True)


def test_laws_of_the_page_slide_as_by_quadratures(page):
    laws, speeds = ("growing", "hardening", "weakening"), (0.01, 0.1, 0.1)
    for name, velocity, force in zip(laws, speeds, page["by_quadrature"], strict=True):
        found = master.steady_state(page[name], velocity=velocity)
        assert found.success and abs(found.force - force) < 1e-8


def stepped(threshold, path, time, start, delay, count, step=2e-3):
    """The plain twin: contacts in steps of time, which break where |x| has reached threshold(x_s0, age), and are born
    again at x = 0 a delay later; the mean stretch at the points, 0 of those that are out, and its standard error."""
    rng = np.random.default_rng(5)
    x, age = np.full(count, start), np.zeros(count)
    fresh = PC.isf(rng.random(count) * PC.sf(abs(start)))
    found, before = [], (0.0, 0.0)
    for now in zip(time, path, strict=True):
        lasts, moves = np.subtract(now, before)
        steps = int(np.ceil(lasts / step))
        for _ in range(steps):
            age += lasts / steps
            holds = age > 0.0
            x += np.where(holds, moves / steps, 0.0)
            broken = holds & (np.abs(x) >= threshold(fresh, age))
            x[broken], age[broken] = 0.0, -delay
            fresh[broken] = PC.rvs(int(broken.sum()), rng)
        found.append((x.mean(), x.std() / np.sqrt(count)))
        before = now
    return np.array(found).T


def hardened(fresh, age):
    return fresh + np.minimum(0.1 * np.log1p(age), 0.3)


def weakened(fresh, age):
    return fresh * np.exp(-age / 5.0)


@pytest.mark.parametrize(
    ("name", "twin", "other", "start", "delay"),
    [
        slow("hardening", hardened, weakened, 0.0, 0.0),
        slow("weakening", weakened, hardened, 0.0, 0.0),
        ("weakening", weakened, hardened, -0.3, 0.2),
    ],
)
def test_laws_of_the_page_are_those_of_single_contacts(page, name, twin, other, start, delay):
    """On a path that rests and turns; the twin of the other law is told apart."""
    contacts = Contacts(page[name].changing, start, delay=origins.Delay(delay))
    found = master.solve(contacts, page["path"], 1e-5, time=page["clock"])
    assert found.success
    for threshold in (twin, other):
        # so far away that fewer contacts tell it
        count = 10_000 if threshold is twin else 2_000
        force, error = stepped(threshold, page["path"], page["clock"], start, delay, count)
        # contacts break up to a step late, half of one in the mean, in which they are stretched by 1e-3
        off = np.abs(found.force - force) / (error + 1e-3)
        assert (off.max() < 4.5) == (threshold is twin)


@pytest.mark.slow
def test_the_ensemble_takes_the_laws_of_the_page(whole_page):
    names = whole_page
    exact, found = names["rested_by_master"], names["rested_by_ensemble"]
    error = np.hypot(found.force_standard_error, exact.force_error)
    assert (np.abs(found.force - exact.force) < 5.0 * error).all()
    for of_all_points in (names["z"], names["z_weakened"], names["z_damaged"]):
        assert (np.abs(of_all_points) < 5.0).all()
    damaged = names["damaged"]
    for ask, says in (
        (lambda: eq_model.simulate(damaged, [1.0], histograms=[0]), "damage has no line of AGED"),
        (lambda: master.solve(damaged, [1.0, 0.0]), "use eq_model.simulate"),
    ):
        with pytest.raises(InputError, match=says) as refused:
            ask()
        assert "\n" not in str(refused.value)


def pulled(weaken, path, spring, speed, count=20_000, step=2e-3):
    """The plain twin under a spring: in steps of the drive thresholds become weaken(thresholds, time, random numbers),
    then the slider follows, by at most a step at a time, and contacts break and are born again. The force at the
    points, its standard error, the place of the drive at the first slip, and the force after it."""
    rng = np.random.default_rng(7)
    x, limit = np.zeros(count), PC.rvs(count, rng)
    place, drives, loads, slips = 0.0, np.arange(0.0, path[-1] + step, step), [0.0], []
    for drive in drives[1:]:
        limit, lost, moves, broke = weaken(limit, step / speed, rng), 0, step, 0
        while moves > 1e-7 or broke:
            moves = min((spring * (drive - place) - x.mean()) / (spring + 1.0), step)
            x, place = x + moves, place + moves
            broken = x >= limit
            broke = int(broken.sum())
            x[broken] = np.minimum(x[broken] - limit[broken], step)  # its way on since it broke
            limit[broken] = PC.rvs(broke, rng)
            lost += broke
        loads.append(x.mean())
        if lost > 0.2 * count:
            slips.append((drive - 0.5 * step, x.mean()))
    return np.interp(path, drives, loads), x.std() / np.sqrt(count), *slips[0]


def weakened_more(limit, lasts, rng):
    return limit * np.exp(-lasts / 5.0)


def damaged_more(limit, lasts, rng):
    return limit * 0.8 ** rng.poisson(0.5 * lasts, limit.size)


@pytest.mark.slow  # kernels of the page's laws are compiled
@pytest.mark.parametrize(
    ("name", "twin", "other", "spring", "speed"),
    [
        ("weakened_on_spring", weakened_more, damaged_more, 0.5, 0.3),
        ("damaged_on_spring", damaged_more, weakened_more, 0.2, 10.0),
    ],
)
def test_laws_of_the_page_on_a_spring_are_those_of_single_contacts(
    whole_page, name, twin, other, spring, speed
):
    """One by its birth_threshold, one by its life: the first slip under "instant", and the force but beside slips; the
    twin of the other law is told apart."""
    found = whole_page[name]
    assert found.success and found.slips.drive.size
    for weaken in (twin, other):
        try:
            force, error, first, after = pulled(weaken, found.path, spring, speed)
        except IndexError:  # it does not slip
            assert weaken is other
            continue
        # in a step of the twin contacts are stretched by 2e-3, which shifts a slip by as much over K/(1 + K)
        off = (
            abs(first - found.slips.drive[0]) / 0.02,
            abs(after - found.slips.force_after[0]) / 0.01,
        )
        beside = np.abs(found.path[:, None] - found.slips.drive).min(axis=1) < 0.2
        of_points = np.abs(force - found.force) / (4.5 * error + 2e-3 + found.force_error)
        assert (max(*off, *of_points[~beside]) < 1.0) == (weaken is twin)


class OwnStrengthening(origins.OrderedThresholds):
    """That of origins.strengthening, by its birth_threshold."""

    law = "own strengthening"

    def __init__(self, fresh, beta, time):
        self.at_start, self.beta, self.time = fresh, beta, time

    def growth(self, age):
        return 1.0 + self.beta * np.log1p(age / self.time)

    def birth_threshold(self, x, age, travelled):
        return x / self.growth(age)

    def largest_threshold(self, fresh, share, duration):
        return fresh * float(self.growth(duration))


TURNS = np.concatenate(
    [np.linspace(0.4, 3, 14), [3.0, 3.0], np.linspace(2.6, 0, 6), [1.0, 2.0, 3.0]]
)
TURNED = np.cumsum(
    np.where(np.diff(TURNS, prepend=0.0), np.abs(np.diff(TURNS, prepend=0.0)) / 0.3, 2.0)
)


@pytest.mark.slow  # quick: the same of a slider with mass, below
@pytest.mark.parametrize("rule", ["reset", "instant", "reform-after"])
def test_a_law_of_one_s_own_on_a_spring_is_the_same_law_that_is_built_in(rule):
    """On a drive that slips, turns and rests; by another memory, so that the errors of steps differ."""
    laws = origins.strengthening(PC, 0.05, 0.01), OwnStrengthening(PC, 0.05, 0.01)
    given = {"spring": 0.5, "time": TURNED, "slip": rule}
    built_in, own = (master.solve(Contacts(law), TURNS, 1e-3, **given) for law in laws)
    assert built_in.success and own.success
    error = built_in.force_error + own.force_error
    assert np.abs(built_in.force - own.force).max() <= error
    assert own.slips.drive.size == built_in.slips.drive.size >= 1
    assert np.abs(own.slips.force_after - built_in.slips.force_after).max() <= error
    assert np.abs(own.force).max() > 0.8  # of thresholds that stay: 0.75


@pytest.mark.slow  # some 10 s
def test_strengthening_on_a_very_soft_spring_decoheres_as_step_after_step():
    """Slips of a million thresholds under "instant": replaced by what they lead to, contacts bear F_k of fresh ones,
    and slip again as those of the law of one's own, whose slips are followed in steps until F is steady."""
    laws = origins.strengthening(PC, 0.03, 1e-3), OwnStrengthening(PC, 0.03, 1e-3)
    path, given = 1e6 * np.linspace(0.05, 2.5, 40), {"spring": 1e-6, "slip": "instant"}
    found, own = (
        master.solve(Contacts(law), path, tolerance, **given)
        for law, tolerance in zip(laws, (1e-4, 5e-3), strict=True)
    )
    assert found.success and own.success
    assert found.slips.drive.size == own.slips.drive.size == 3
    fresh = PC.moment(2) / (2.0 * PC.mean())
    assert np.abs(found.slips.force_after - fresh).max() < found.force_error
    off = np.abs(found.slips.force_before - own.slips.force_before).max()
    assert off < found.force_error + own.force_error


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["reform-after", "reset", "instant"])
def test_a_life_alone_takes_a_law_onto_a_spring(page, monkeypatch, rule):
    """Step by step the same as by its birth_threshold, where both take the same steps."""
    monkeypatch.setattr(make, "LIVES", {Closed: ClosedLife} | LIVES)
    laws = page["weakening"].changing, Closed(PC, 5.0)
    given = {"spring": 0.5, "time": TURNED, "slip": rule}
    ordered, by_life = (master.solve(Contacts(law), TURNS, 1e-2, **given) for law in laws)
    assert ordered.success and by_life.success and by_life.slips.drive.size >= 1
    assert np.abs(ordered.force - by_life.force).max() < 1e-5


def test_what_slides_and_slips_follows_from_the_life_alone(page):
    """The sum over roots is the force along the path; F_s its largest, K* its steepest fall."""
    contacts, x = page["weakening"], np.linspace(2e-3, 3.0, 1500)
    found = master.solve(contacts, x, 1e-8, velocity=1.0)
    spectrum = master.decoherence_spectrum(contacts, velocity=1.0)
    late = slice(1000, None, 100)
    assert np.abs(spectrum.force(x[late]) - found.force[late]).max() < 1e-7
    ready, steady = (
        ask(contacts, velocity=1.0) for ask in (master.propensity, master.steady_state)
    )
    assert ready.static_to_kinetic == pytest.approx(found.force.max() / steady.force, abs=1e-5)
    steepest = -np.diff(found.force).min() / 2e-3
    assert ready.critical_spring == pytest.approx(steepest, abs=1e-3)


class Closed(ChangingThresholds):
    """x_s0 e^(-t/τ), the page's weakening, by a life of its own alone."""

    law = "weakening"

    def __init__(self, fresh, time):
        self.at_start, self.time = fresh, time

    def largest_threshold(self, fresh, share, duration):
        return fresh


class ClosedLife(ChangingLife):
    """E = S(the largest |x| e^(t/τ) since birth)/S(|r|): on a leg of one speed v at an end, or where x = -vτ."""

    def survivors(self, born, side, history):
        law = self.contacts.changing
        displacement, duration, speed = history.legs()
        x = born[:, None] + displacement  # at the ends of legs
        age = np.cumsum(np.insert(duration, 0, 0.0, axis=1), axis=1)
        at_0 = np.divide(-x[:, :-1], speed, out=np.zeros_like(duration), where=speed != 0.0)
        after = at_0 - law.time  # when x = -vτ, on each leg
        between = (after > 0.0) & (after < duration)
        top = np.where(between, np.abs(speed) * law.time, 0.0)
        stretches = np.hstack([np.abs(x), top])
        ages = np.hstack([age, np.where(between, age[:, :-1] + after, 0.0)])
        grown = np.exp(np.minimum(ages / law.time, 300.0))  # weaker ones are broken
        held = law.at_start.sf((stretches * grown).max(axis=1)) / law.at_start.sf(np.abs(born))
        return Survivors(held, held * x[:, -1], self.error)


class OneLegLife(ClosedLife):
    """For a slider that keeps its speed."""

    @classmethod
    def why_not(cls, contacts, one_leg=True):
        return "" if one_leg else "contacts.weakening: keep one speed"


class Contradicts(origins.OrderedThresholds):
    """It weakens and strengthens with the age at one x."""

    law = "contradiction"

    def __init__(self, fresh):
        self.at_start = fresh

    def birth_threshold(self, x, age, travelled):
        return x * (1.0 + 0.5 * np.sin(age))


def test_a_law_that_no_life_follows_on_a_spring_is_refused_in_one_line(monkeypatch):
    closed = Closed(PC, 5.0)
    for law, lives, says in (
        (closed, {}, "has no life in master"),
        (closed, {Closed: OneLegLife}, r"one speed \(on a spring the slider's speed changes\)$"),
        (Contradicts(PC), {}, "rises and falls with the age at one x"),
    ):
        monkeypatch.setattr(make, "LIVES", lives | LIVES)
        with pytest.raises(InputError, match=says) as refused:
            master.solve(Contacts(law), [1.0, 5.0], 1e-2, velocity=0.1, spring=0.5)
        assert "\n" not in str(refused.value)


def test_an_ordered_law_is_solved_as_by_its_closed_form(page, monkeypatch):
    """The largest birth_threshold on a leg is looked for; here its place is known."""
    monkeypatch.setattr(make, "LIVES", LIVES | {Closed: ClosedLife})
    laws = page["weakening"].changing, Closed(PC, 5.0)
    path, clock = [*page["path"], -1.2, -1.2, 0.4], [*page["clock"], 12.0, 15.0, 15.1]
    found, closed = (
        master.solve(Contacts(law, -0.3), path, 1e-5, time=clock).force for law in laws
    )
    assert np.abs(found - closed).max() < 1e-12


def with_life(monkeypatch, survivors=None, reach=lambda fresh: fresh):
    """Contacts of a law like weakening whose life gives `survivors` of what ClosedLife does."""
    law = type("Own", (Closed,), {"largest_threshold": lambda self, fresh, *rest: reach(fresh)})

    class Life(ClosedLife):
        def survivors(self, *given):
            found = super().survivors(*given)
            return found if survivors is None else survivors(found)

    monkeypatch.setattr(make, "LIVES", {law: Life} | LIVES)
    return Contacts(law(PC, 5.0))


@pytest.mark.parametrize(
    ("survivors", "reach", "says"),
    [
        (tuple, float, r"must return Survivors\(survival, force, error\), not \("),
        (
            lambda found: found.reshape(3, 1),
            float,
            r"must return a survival of the shape \(3,\), not \(3, 1\)",
        ),
        (lambda found: found._replace(force=np.nan * found.force), float, "finite forces"),
        (lambda found: found._replace(survival=1.1 * found.survival), float, "shares from 0 to 1"),
        (lambda found: found._replace(error=found.force), float, "and one error"),
        (None, lambda fresh: np.inf, "must return a finite number, not inf"),
        (None, lambda fresh: np.array([fresh]), r"must return a finite number, not array\("),
    ],
)
def test_a_life_that_gives_what_cannot_be_is_refused(monkeypatch, survivors, reach, says):
    contacts = with_life(monkeypatch, survivors, reach)
    with pytest.raises(InputError, match=says) as refused:
        master.solve(contacts, [1.0], velocity=1.0)
    said = str(refused.value)
    assert "\n" not in said and said.startswith("contacts.weakening: Life: ")


def test_a_life_alone_takes_a_law_onto_a_slider_with_mass(page, monkeypatch):
    """None broke, and F rose for ever: the life was asked for on a drive that was not known."""
    monkeypatch.setattr(make, "LIVES", LIVES | {Closed: ClosedLife})
    laws = page["weakening"].changing, Closed(PC, 5.0)
    given = {"spring": 0.5, "mass": 0.3, "damping": 0.3, "velocity": 0.5}
    path = np.linspace(0.2, 2.4, 12)
    found, known = (master.solve(Contacts(law), path, 1e-2, **given) for law in reversed(laws))
    assert found.success and known.success and found.energy.released[-1] > 0.1
    off = np.abs(found.force - known.force).max() / PC.mean()
    assert off <= found.force_error + known.force_error


@pytest.mark.slow
def test_a_life_that_leaves_out_contacts_tells_where_the_number_jumps(page, monkeypatch):
    """A tenth of those that form is lost: panels at the beginning of a leg are narrower than rounding of the time, and
    their births have to stay on that leg."""
    contacts = with_life(
        monkeypatch,
        lambda found: found._replace(survival=0.9 * found.survival, force=0.9 * found.force),
    )
    found = master.solve(contacts, page["path"], 1e-4, time=page["clock"], wall_time=60.0)
    assert not found.success and found.force.size == len(page["path"])
    assert "the number of contacts jumps by " in found.message


@pytest.mark.parametrize(
    ("ask", "says"),
    [
        (
            lambda law: eq_model.simulate(Contacts(Closed(PC, 1.0)), [1.0], velocity=1.0),
            "no kernel in eq_model; use master.solve, or state birth_threshold",
        ),
        (
            lambda law: eq_model.simulate(Contacts(law), [1.0], spring=1.0),
            "with a spring does not take it yet; leave weakening out of the contacts, or use master",
        ),
        (lambda law: Contacts(law, thermal=origins.Thermal("soft", 0.1)), "take no thermal beside"),
        (lambda law: Contacts(law, stiffness="linked"), "take no stiffness beside"),
        (lambda law: Contacts(law, reforming=0.1), "take no reforming beside"),
        (lambda law: Contacts(law, ageing=origins.Ageing(PC, 1.0)), "take no ageing beside"),
        (
            lambda law: Contacts(origins.Ageing(PC, 1.0)),
            r"beside thresholds, as Contacts\(law, ageing",
        ),
        (
            lambda law: master.steady_state(
                Contacts(type(law)(origins.identical(1.0), 5.0)), velocity=1.0
            ),
            "exact values, which the master equation does not follow while they change",
        ),
    ],
)
def test_what_has_not_been_written_for_a_law_is_refused_in_one_line(page, ask, says):
    with pytest.raises(InputError, match=says) as refused:
        ask(page["weakening"].changing)
    assert "\n" not in str(refused.value)
