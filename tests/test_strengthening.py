"""Thresholds that grow with the logarithm of the contact's age."""

import numpy as np
import pytest

import origins
from origins import Contacts, InputError
from toolkit.scene.scene import load_scene

PC = origins.gaussian(mean=1.0, std=0.2)


def test_thresholds_keep_their_quantile():
    """x_s(t) = x_s0 (1 + β ln(1 + t/τ_0)): hazard_at and threshold_at are inverse at every age."""
    law = origins.strengthening(PC, beta=0.04, time=0.5, age=2.0)
    hazard, ages = np.geomspace(1e-20, 300.0, 40), np.array([[0.0], [0.3], [1e6]])
    x = law.threshold_at(hazard, ages)
    np.testing.assert_allclose(
        law.hazard_at(-x, ages), np.broadcast_to(hazard, x.shape), rtol=1e-13
    )
    g = 1.0 + 0.04 * np.log(1.0 + ages / 0.5)
    np.testing.assert_allclose(
        x[:, hazard > 0.5], g * PC.isf(np.exp(-hazard[hazard > 0.5])), rtol=1e-12
    )
    # at X = 0, of the age 2
    contacts, factor = Contacts(law), 1.0 + 0.04 * np.log(5.0)
    assert contacts.mean_threshold == pytest.approx(factor * PC.mean(), rel=1e-14)
    assert contacts.thresholds.sf(1.1) == pytest.approx(float(PC.sf(1.1 / factor)), rel=1e-12)
    assert contacts.laws == ("strengthening",) and contacts.strengthening is law
    assert contacts.grains is None and contacts.growing is law
    assert contacts.replace(delay=origins.Delay(0.1)).growing is law


@pytest.mark.parametrize("turn", [None, 0.7, -0.4])
def test_the_ratio_is_largest_at_the_end_of_a_leg(turn):
    """|x|/g(age) on any leg of one speed first falls and then rises: no inner point exceeds both ends."""
    law = origins.strengthening(PC, beta=1.0, time=0.02)
    generator = np.random.default_rng(4)
    for _ in range(200):
        begin, end = (1.0 if turn is None else turn) * generator.normal(size=2)
        since, lasts = generator.exponential(1.0, 2) ** 3
        share = np.linspace(0.0, 1.0, 400)
        ratio = np.abs(begin + share * (end - begin)) / law.factor(since + share * lasts)
        assert ratio.max() == max(ratio[0], ratio[-1])


def test_no_growth_is_no_law():
    """β = 0 leaves the thresholds as they are."""
    contacts = Contacts(origins.strengthening(PC, beta=0.0, time=1.0, age=3.0))
    assert contacts.laws == () and contacts.thresholds is PC


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: origins.strengthening(PC, -0.1, 1.0), "beta = -0.1: must be zero or above"),
        (lambda: origins.strengthening(PC, 2.0, 1.0), "beta = 2.0: must be at most 1"),
        (lambda: origins.strengthening(PC, 0.1, 0.0), "time = 0.0: must be above zero"),
        (
            lambda: origins.strengthening(PC, 0.1, 1.0, age=-1.0),
            "age = -1.0: must be zero or above",
        ),
        (lambda: origins.strengthening(1.0, 0.1, 1.0), "thresholds = 1.0: must come from origins"),
        (
            lambda: origins.strengthening(PC, 0.1, 1.0).check_speed(1e-120),
            "contacts break at ages of 1e+120 times",
        ),
    ],
)
def test_bad_numbers(call, said):
    """One line, with the value and what holds."""
    with pytest.raises(InputError) as error:
        call()
    assert said in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("laws", "said"),
    [
        ({"reforming": 0.1}, "reforming: contacts whose thresholds grow"),
        ({"stiffness": "linked"}, "nothing says whether k_i grows"),
        ({"ageing": origins.Ageing(PC, rate=1.0)}, "ageing: thresholds that grow"),
        ({"thermal": origins.Thermal("soft", 0.1, closure="paper")}, "each age has another"),
    ],
)
def test_laws_that_do_not_go_with_it(laws, said):
    """The reason is said."""
    with pytest.raises(InputError, match=said):
        Contacts(origins.strengthening(PC, 0.03, 1.0), **laws)


SCENE = {
    "contacts": {
        "thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2},
        "strengthening": {"beta": 0.04, "time": 0.5, "age": 2.0},
    },
    "drive": {"to": 2.0, "velocity": 0.1},
    "eq": {"contacts": 100},
}


def test_a_scene_names_it():
    """[contacts.strengthening] is the call with the thresholds of the scene; its errors name the key."""
    law = load_scene(SCENE).contacts.strengthening
    assert (law.beta, law.time_unit, law.age) == (0.04, 0.5, 2.0)
    np.testing.assert_array_equal(law.fresh.sf([0.9, 1.1]), PC.sf([0.9, 1.1]))
    assert load_scene(SCENE, changes={"contacts.strengthening.beta": 0.0}).contacts.laws == ()
    for key, value, said in [
        (
            "contacts.strengthening.beta",
            -0.1,
            "contacts.strengthening.beta = -0.1: must be zero or above",
        ),
        ("contacts.strengthening.tau", 1.0, "contacts.strengthening.tau = 1.0: unknown key"),
        ("contacts.stiffness", "linked", "contacts.stiffness = 'linked': not defined"),
        (
            "contacts.thresholds",
            {"kind": "growing-grains", "alpha": 1.0, "B": 1.0, "age": 4.0},
            "grow already",
        ),
    ]:
        with pytest.raises(InputError) as error:
            load_scene(SCENE, changes={key: value})
        assert said in str(error.value)


def test_contacts_of_a_rough_surface_in_newtons():
    """The surface stays behind the thresholds, which are in metres, at X = 0 of any age."""
    bare = load_scene("rough-gw-amontons").contacts
    table = {"beta": 0.03, "time": 1.0, "age": 1e4}
    grown = load_scene("rough-gw-amontons", changes={"contacts.strengthening": table}).contacts
    assert grown.interface == bare.interface and bare.interface is not None
    factor = 1.0 + 0.03 * np.log(1.0 + 1e4)
    assert grown.mean_threshold == pytest.approx(factor * bare.mean_threshold, rel=1e-12)
