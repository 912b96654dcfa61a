"""Where ageing ends stick-slip (Fig. A06): at v_c the steepest drop of the force just reaches the spring."""

import numpy as np
import pytest

import master
import origins
from master import critical_velocity
from master.paper.q15_transient import paper_transient
from origins import Ageing, Contacts, InputError

NARROW = origins.gaussian(0.5, 0.05)


def figure_a06(closure: str) -> Contacts:
    ageing = Ageing(origins.gaussian(1.0, 0.02), 5e-4, closure=closure)
    return Contacts(NARROW, origins.gaussian_start(0.02, 0.01), ageing=ageing)


def test_critical_velocity_of_figure_a06_exact() -> None:
    """At v_c the drop just reaches the spring."""
    critical = critical_velocity(figure_a06("exact"), 3.5, 4.2, 4.3)
    assert critical.velocity == pytest.approx(4.2531, abs=1e-4) and 0.0 < critical.velocity_error < 1e-5
    path = critical.position + np.linspace(-0.01, 0.01, 41)
    told = master.solve(figure_a06("exact"), path, 1e-8, velocity=critical.velocity)
    x = path - path.mean()
    slope = -np.polyval(np.polyder(np.polyfit(x, told.force, 6)), x)
    assert told.success and slope.max() == pytest.approx(3.5, abs=1e-6)


def test_critical_velocity_of_figure_a06_paper() -> None:
    critical = critical_velocity(figure_a06("paper"), 3.5, 2.0, 2.1)
    assert critical.velocity == pytest.approx(2.0692, abs=2e-4) and 0.0 < critical.velocity_error < 1e-4
    path = critical.position + np.linspace(-0.02, 0.02, 41)
    coarse, fine = (
        paper_transient(figure_a06("paper"), path, h, velocity=critical.velocity, cells=8).force for h in (2e-3, 1e-3)
    )
    x = path - path.mean()
    slope = -np.polyval(np.polyder(np.polyfit(x, (4.0 * fine - coarse) / 3.0, 6)), x)
    assert slope.max() == pytest.approx(3.5, abs=1e-3)


def test_propensity_tells_the_same_spring() -> None:
    """At v_c the critical spring is the one that v_c was found for; it reads F(X), whose slowest decay is X*."""
    contacts = figure_a06("exact")
    told = master.propensity(contacts, velocity=4.253078)
    assert told.critical_spring == pytest.approx(3.5, abs=1e-6) and told.critical_spring_error < 3e-7
    path = np.linspace(0.0, 40.0, 4001)
    force = master.solve(contacts, path, 1e-8, velocity=4.253078).force
    kinetic = master.steady_state(contacts, velocity=4.253078).force
    assert force.max() == pytest.approx(told.static_to_kinetic * kinetic, rel=1e-4)
    # the envelope's decay, from peak to peak far out
    off = np.abs(force - kinetic)
    peaks = np.flatnonzero((off[1:-1] > off[:-2]) & (off[1:-1] > off[2:])) + 1
    far = peaks[path[peaks] > 20.0]
    rate = -np.polyfit(path[far], np.log(off[far]), 1)[0]
    assert 1.0 / rate == pytest.approx(told.decoherence_length, rel=2e-3)


def test_refusals() -> None:
    by_speed = "contacts.ageing: is None; v_c is that of contacts that age by diffusion. What a temperature, a delay or"
    cases = [
        (figure_a06("exact"), 50.0, "slowest, fastest: -F' is at most"),
        (figure_a06("paper"), -1.0, "spring = -1.0: must be above zero"),
        (Contacts(NARROW), 1.0, "contacts.ageing: is None; without ageing nothing depends on the speed"),
        (Contacts(origins.growing_grains(1.0, 4.0, age=4.0)), 1.0, f"{by_speed} thresholds that grow make of K*"),
    ]
    for contacts, spring, begins in cases:
        with pytest.raises(InputError) as refusal:
            critical_velocity(contacts, spring, 3.0, 4.0)
        assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value), str(refusal.value)
