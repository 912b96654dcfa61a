"""Contacts that age: the force far on is that of the steady state, and births at many stretches are births at each."""

import numpy as np
import pytest

import master
import origins
from origins import Ageing, Contacts

FRESH = origins.gaussian(0.5, 0.1)


@pytest.mark.parametrize(("birth", "wait"), [(0.0, 0.2), (0.15, 0.0), (-0.1, 0.1)])
def test_far_on_with_delay_and_births_at_other_stretches(birth: float, wait: float) -> None:
    """Wide final thresholds: all is soon forgotten."""
    ageing, delay = Ageing(origins.gaussian(0.8, 0.25), 0.1), origins.Delay(wait / 2.0)
    contacts = Contacts(FRESH, -0.1, ageing=ageing, reforming=birth, delay=delay)
    steady = master.steady_state(contacts, velocity=2.0)
    far = master.solve(contacts, np.linspace(40.0, 42.0, 21), 1e-6, velocity=2.0)
    assert steady.force_error < 1e-8 and np.abs(far.force - steady.force).max() < 1e-6
    assert far.holding[-1] == pytest.approx(steady.cycle_length / (steady.cycle_length + wait), abs=1e-6)


@pytest.mark.parametrize("final", [origins.gw_plastic(0.6), origins.lubricated(1.0)])
def test_far_on_with_other_final_laws(final: origins.Thresholds) -> None:
    contacts = Contacts(FRESH, ageing=Ageing(final, 0.1))
    steady = master.steady_state(contacts, velocity=2.0)
    far = master.solve(contacts, np.linspace(28.0, 30.0, 41), 1e-6, velocity=2.0)
    assert 0.0 < steady.force_error < 1e-6 and np.abs(far.force - steady.force).max() < 1e-6


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_warm_contacts_that_hardly_age_are_those_that_do_not(law: str) -> None:
    thermal = origins.Thermal(law, 0.05, 2.0)  # type: ignore[arg-type]
    path, final = 0.05 * np.arange(1, 31), origins.gaussian(0.8, 0.1)
    alone, barely = (
        master.solve(Contacts(FRESH, None, thermal, slow), path, 1e-6, velocity=2.0)
        for slow in (None, Ageing(final, 1e-9))
    )
    claims = (alone.force_error + barely.force_error) * FRESH.mean()
    assert barely.success and np.abs(alone.force - barely.force).max() <= claims


def test_births_at_many_stretches_are_births_at_each_of_them() -> None:
    """Lengths of lives and the force summed over them are averages over the births, here by Gauss and Hermite."""
    ageing = Ageing(origins.gaussian(0.8, 0.04), 0.02)
    many = master.steady_state(Contacts(FRESH, ageing=ageing, reforming=origins.gaussian_start(0.05, 0.01)))
    nodes, weights = np.polynomial.hermite_e.hermegauss(7)
    each = [master.steady_state(Contacts(FRESH, ageing=ageing, reforming=float(0.05 + 0.01 * x))) for x in nodes]
    lengths = weights / weights.sum() * np.array([steady.cycle_length for steady in each])
    assert many.cycle_length == pytest.approx(lengths.sum(), rel=1e-10)
    assert many.force == pytest.approx(lengths @ [steady.force for steady in each] / lengths.sum(), rel=1e-10)
