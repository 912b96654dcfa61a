"""A law in numbers: every error against the true one."""

from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.special import gamma

import origins
import toolkit
from toolkit.judge.describe import conditions, describe
from toolkit.scene.interfaces import with_error

MOMENTS = ("mean", "second_moment", "third_moment")
WEIBULL = [float(gamma(1.0 + n / 2.5)) for n in (1, 2, 3)]


@pytest.mark.parametrize(
    ("law", "exact"),
    [
        (origins.rectangular(0.5, 1.5), [1.0, 13.0 / 12.0, 1.25]),
        (origins.gw_elastic(1.0), [float(gamma(1.0 + 0.75 * n)) for n in (1, 2, 3)]),
        (origins.identical(0.7), [0.7, 0.49, 0.343]),
        (origins.mixture([origins.identical(0.5), origins.rectangular(1.0, 2.0)], [0.25, 0.75]),
         [0.125 + 0.75 * 1.5, 0.0625 + 0.75 * 7.0 / 3.0, 0.03125 + 0.75 * 15.0 / 4.0]),
        (stats.weibull_min(2.5), WEIBULL),
        (stats.pareto(3.5), [3.5 / 2.5, 3.5 / 1.5, 3.5 / 0.5]),
    ],
    ids=["rectangular", "gw", "identical", "atom", "weibull", "pareto"],
)  # fmt: skip
def test_moments_lie_within_their_errors(law: object, exact: list[float]) -> None:
    numbers = describe(origins.Contacts(law)).numbers
    for name, value in zip(MOMENTS, exact, strict=True):
        assert abs(numbers[name].value - value) <= numbers[name].error
        assert numbers[name].error < 1e-9 * value
    # as variances: a law of one value has none, but for the rounding of the two moments
    variance, spread = exact[1] - exact[0] ** 2, numbers["standard_deviation"]
    assert abs(spread.value**2 - variance) <= 2.0 * spread.value * spread.error + 4e-16 * exact[1]


def test_propensity_lies_within_its_errors() -> None:
    numbers = describe(origins.Contacts(origins.rectangular(0.5, 1.5))).numbers
    # at X = 3/2, first and second breaks: F' = 1 - X P_c(X) - (3/8), the last the integral of s from 1/2 to 1
    spring = numbers["critical_spring"]
    assert abs(spring.value - 7.0 / 8.0) <= spring.error < 1e-6
    kinetic = numbers["kinetic_force"]
    assert abs(kinetic.value - 13.0 / 24.0) <= kinetic.error < 1e-12


@pytest.mark.filterwarnings("ignore:The integral is probably divergent")
def test_what_has_no_answer_is_said() -> None:
    found = describe(origins.Contacts(stats.pareto(1.5)))
    assert (
        np.isinf(found.numbers["second_moment"].value)
        and found.numbers["second_moment"].error is None
    )
    assert "critical_spring" not in found.numbers
    assert "<x_s^2> is infinite" in found.notes[0]


def test_interface_numbers_have_units() -> None:
    law = origins.from_topography(
        origins.self_affine_surface(
            (64, 64), 40e-9, hurst=0.8, rms_slope=0.1, short_cutoff=2e-7, seed=1
        ),
        40e-9,
        model="gw",
        law="strength",
        material=origins.Material(contact_modulus=1.75e9, shear_modulus=1.1e9, shear_strength=5e7),
        pressure=1e6,
    )
    numbers = describe(origins.Contacts(law)).numbers
    assert (
        numbers["mean"].unit == "m"
        and numbers["mean_stiffness"].unit == "N/m"
        and numbers["pressure"].error is None
    )
    assert numbers["mean_load"].value == pytest.approx(1e6 / numbers["contact_density"].value)


def test_speed_and_laws_are_said_where_they_tell() -> None:
    warm = origins.Contacts(
        origins.gaussian(1.0, 0.2), thermal=origins.Thermal("soft", 0.1), delay=origins.Delay(0.5)
    )
    told = "F_k, K*, F_s/F_k and X* at v = 0.25, T = 0.1, attempt frequency 1, delay 0.5; all else is P_c alone"
    assert describe(warm, 0.25).notes[0] == told
    assert not describe(origins.Contacts(origins.gaussian(1.0, 0.2)), 0.25).notes


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"drive": {"to": 1.0, "points": 3, "velocity": 0.5}}, "v = 0.5, "),
        ({"drive": {"turns": [0.0, 1.0], "times": [1.0, 5.0], "points": 3}}, "v = 0.25, "),
        ({"sweep": {"velocity": [0.1, 1.0]}}, "v = 0.1 (the sweep's first), "),
        ({"sweep": {"velocity": 0.1, "temperature": [0.1, 0.2]}}, "v = 0.1, "),
        ({}, "v = 1 (as none is given), "),
    ],
)
def test_which_speed_of_a_scene_is_taken_is_said(more: dict[str, Any], told: str) -> None:
    thermal = {"law": "soft", "temperature": 0.1}
    contacts = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}, "thermal": thermal}
    scene = toolkit.load_scene({"contacts": contacts, **more}, solved=False)
    speed = scene.sliding
    assert conditions(scene.contacts, speed.value, speed.chosen)[0].startswith(
        f"F_k, K*, F_s/F_k and X* at {told}T"
    )


@pytest.mark.parametrize(
    ("value", "error", "told"),
    [
        (0.0, 5.1, "0 ± 5"),
        (1.0 / 3.0, 1e-16, "0.33333333 ± 1e-16"),
        (-4.5678e-9, 2.3e-10, "-4.6e-09 ± 2e-10"),
        (1.2345, 0.097, "1.2 ± 0.1"),
        (1.0, 1e-16, "1 ± 1e-16"),
        (1.5, 0.0, "1.5"),
        (np.inf, 0.1, "inf"),
    ],
)
def test_no_digit_is_told_beyond_the_error(value: float, error: float, told: str) -> None:
    assert with_error(value, error, 8) == told
