"""Ageing in its exact closure, through master.solve and master.steady_state: Fig. A05, conservation, limits, scale."""

import numpy as np
import pytest

import master
import origins
from origins import Ageing, Contacts, Delay, InputError, Thermal

FRESH, FINAL = origins.gaussian(0.5, 0.1), origins.gaussian(1.0, 0.01)  # Fig. A05
NARROW = origins.gaussian(0.5, 0.05)
FIGURE_A05 = {1000.0: 0.4995, 100.0: 0.4965, 10.0: 0.4908, 3.0: 0.4880}  # of ensembles, by v/D
REFINED = {1000.0: 0.499542736223, 100.0: 0.496482068623, 10.0: 0.490625246688, 3.0: 0.487907968334}


def test_kinetic_force_of_figure_a05() -> None:
    for velocity, force in REFINED.items():
        steady = master.steady_state(Contacts(FRESH, ageing=Ageing(FINAL, 1.0)), velocity=velocity)
        assert abs(steady.force - FIGURE_A05[velocity]) < 2e-4
        assert abs(steady.force - force) < 1e-12 and steady.force_error < 1e-11
        x = np.linspace(-0.1, 1.3, 14_001)
        held = steady.distribution(x)
        assert np.trapezoid(held[1000:], x[1000:]) == pytest.approx(1.0, abs=1e-5)
        assert (held[x < 0.0] == 0.0).all()


def test_error_is_a_promise_here_too() -> None:
    path = np.linspace(0.05, 6.0, 240)
    for fresh, start, final, rate, fine_to in [
        (FRESH, -0.1, FINAL, 0.1, 1e-7),
        (origins.rectangular(0.3, 0.7), 0.1, FINAL, 1e-3, 1e-7),
        (origins.identical(0.5), None, FINAL, 1e-4, 1e-7),
        (NARROW, origins.gaussian_start(0.02, 0.01), origins.gaussian(1.0, 0.02), 2.5e-4, 1e-7),
        # what its first breaks are known to
        (FRESH, origins.gaussian_start(0.1, 0.04), origins.gaussian(1.0, 0.05), 0.01, 1.5e-7),
        (FRESH, None, origins.gw_plastic(0.6), 0.01, 1e-7),
    ]:
        contacts = Contacts(fresh, start, ageing=Ageing(final, rate))
        rough, fine = master.solve(contacts, path, 1e-5), master.solve(contacts, path, fine_to)
        error = np.abs(rough.force - fine.force).max() / contacts.mean_threshold
        assert rough.success and fine.success and error <= rough.force_error + fine.force_error, (rate, error)


def test_limits() -> None:
    path = np.linspace(0.0, 3.0, 61)
    start = origins.gaussian_start(0.02, 0.02)
    plain = master.solve(Contacts(NARROW, start), path, 1e-9).force
    at_rest = master.solve(Contacts(NARROW, start, ageing=Ageing(FINAL, 0.0)), path, 1e-9).force
    np.testing.assert_array_equal(at_rest, plain)
    barely = master.solve(Contacts(NARROW, start, ageing=Ageing(FINAL, 1e-13)), path, 1e-9)
    np.testing.assert_allclose(barely.force, plain, atol=1e-8)
    # D and v count as D/v alone
    one, two = (
        master.solve(Contacts(NARROW, ageing=Ageing(FINAL, 1e-3 * v)), path, 1e-9, velocity=v).force for v in (1.0, 7.0)
    )
    np.testing.assert_allclose(two, one, atol=1e-9)


@pytest.mark.parametrize("scale", [1e-9])
def test_scale_of_lengths_changes_nothing_else(scale: float) -> None:
    path = np.linspace(0.0, 3.0, 61)
    forces = [
        master.solve(
            Contacts(
                origins.gaussian(0.5 * u, 0.1 * u),
                origins.gaussian_start(0.05 * u, 0.02 * u),
                ageing=Ageing(origins.gaussian(1.0 * u, 0.05 * u), 1e-3 * u * u),
            ),
            path * u,
            1e-8,
            velocity=u,
        ).force
        / u
        for u in (1.0, scale)
    ]
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-8)


WIDTH = origins.gaussian_start(0.1, 0.025)
AGEING, PAPER = Ageing(FINAL, 1e-3), Ageing(FINAL, 1e-3, closure="paper")


@pytest.mark.parametrize(
    ("call", "begins"),
    [
        (
            lambda: master.solve(Contacts(FRESH, WIDTH, ageing=PAPER, delay=Delay(0.1)), [1.0]),
            "contacts.delay: (Q15), the paper's closure of ageing, does not have it",
        ),
        (
            lambda: master.steady_state(Contacts(FRESH, ageing=PAPER, reforming=0.1)),
            "contacts.reforming: (Q15), the paper's closure of ageing, does not have it",
        ),
        (
            lambda: master.solve(Contacts(FRESH, ageing=PAPER), [1.0], time=[1.0]),
            "time: the paper's closure of ageing takes one speed",
        ),
        (
            lambda: master.steady_state(Contacts(FRESH, None, Thermal("soft", 0.1, closure="paper"), AGEING)),
            'contacts.thermal: closure = "paper" averages the rate',
        ),
        (
            lambda: master.propensity(Contacts(FRESH, ageing=PAPER)),
            'contacts.ageing: closure = "paper" (Q15) has one P_c for all',
        ),
        (lambda: master.steady_state(Contacts(FRESH, ageing=AGEING), velocity=-1.0), "velocity = -1.0: must be above"),
        (
            lambda: master.steady_state(Contacts(origins.identical(0.5), ageing=Ageing(origins.gw_plastic(1.0), 1.0))),
            "thresholds: hold the single value 0.5",
        ),
    ],
)
def test_refusals(call, begins: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError) as refusal:
        call()
    assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value), str(refusal.value)
