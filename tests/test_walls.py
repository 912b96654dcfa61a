"""Thresholds that age towards laws that end, that begin as a power or fall as one: both solvers, and a third road."""

import numpy as np
import pytest
from scipy import stats

import eq_model
import master
import origins
from origins import Ageing, Contacts, InputError

WALLS = Contacts(origins.rectangular(0.6, 1.0), ageing=Ageing(origins.rectangular(0.5, 1.5), 0.1))
PATH = np.linspace(0.1, 3.0, 30)
CASES = {
    "rectangular": WALLS,
    "rectangular, from below 0": Contacts(WALLS.thresholds, -0.3, ageing=WALLS.ageing),
    "rectangular, back across the wall": Contacts(WALLS.thresholds, -0.7, ageing=WALLS.ageing),
    "rectangular, warm": Contacts(WALLS.thresholds, 0.3, origins.Thermal("soft", 0.1), WALLS.ageing),
    "beta": Contacts(stats.beta(2, 2), ageing=Ageing(stats.beta(3, 2), 0.1)),
    "gw_elastic": Contacts(origins.gw_elastic(1.0), ageing=Ageing(origins.gw_elastic(0.5), 0.1)),
    "gw_plastic": Contacts(origins.gw_plastic(1.0), ageing=Ageing(origins.gw_plastic(0.5), 0.1)),
    "gamma": Contacts(origins.gw_plastic(1.0), ageing=Ageing(stats.gamma(2), 0.1)),
    "lomax": Contacts(stats.expon(), ageing=Ageing(stats.lomax(3), 0.1)),
    "lognorm": Contacts(stats.lognorm(0.5), ageing=Ageing(stats.lognorm(0.7), 0.1)),
}
FEW = {"beta": 600, "rectangular, warm": 1500}  # of steps there are hundreds to a break


@pytest.mark.parametrize("name", CASES)
def test_both_solvers_agree(name: str) -> None:
    contacts = CASES[name]
    exact = master.solve(contacts, PATH, tolerance=1e-3)
    found = eq_model.simulate(contacts, PATH, n_contacts=FEW.get(name, 6000), seed=2)
    assert exact.force_error * contacts.mean_threshold < found.force_standard_error.max()
    off = np.abs(found.force - exact.force) - exact.force_error * contacts.mean_threshold
    assert (off < found.step_error + 4.5 * found.force_standard_error).all(), off / found.force_standard_error


def test_nothing_breaks_before_the_wall() -> None:
    path = np.linspace(0.0, 0.5, 11)
    exact = master.solve(WALLS, path, tolerance=1e-3)
    # at the wall itself they break as the root of the way beyond
    np.testing.assert_allclose(exact.force[:-1], path[:-1], atol=1e-9)
    for start in (0.0, -0.4):
        contacts = Contacts(WALLS.thresholds, start, ageing=WALLS.ageing)
        before = path[path < 0.5 - start] + (0.0 if start == 0.0 else 0.3)
        found = eq_model.simulate(contacts, before, n_contacts=2000, histograms=[-1])
        np.testing.assert_allclose(found.force, start + before, atol=1e-7)
        (one,) = found.histograms
        # and no threshold leaves the walls
        held = one.thresholds > 0.0
        assert one.threshold_edges[1:][held].min() > 0.5 and one.threshold_edges[:-1][held].max() < 1.5


def test_against_reflected_steps() -> None:
    """Small steps of a simulation of its own, folded back at the walls, met as a Brownian bridge tells."""
    diffusion, generator, means = 0.1, np.random.default_rng(4), []
    count, step = 20_000, 2e-3
    y, x, alive = WALLS.thresholds.rvs(count, generator), 0.0, np.ones(count, dtype=bool)
    while alive.any():
        later = y + np.sqrt(2.0 * diffusion * step) * generator.standard_normal(count)
        later = 1.5 - np.abs(1.5 - (0.5 + np.abs(later - 0.5) if x < 0.5 - 0.5 * step else later))
        below, above = later - x - step, np.maximum(y - x, 0.0)
        if x >= 0.5 - 0.5 * step:
            through = np.exp(-above * np.maximum(below, 0.0) / (diffusion * step))
            alive &= (below > 0.0) & (generator.random(count) >= through)
        y, x = later, x + step
        if round(x / step) % 50 == 0:
            means.append((x, alive.mean()))
    at, held = np.array(means).T
    # none that breaks comes back
    known = master.solve(Contacts(WALLS.thresholds, ageing=WALLS.ageing, delay=origins.Delay(100.0)), at, 1e-5).holding
    z = (held - known) / np.sqrt(np.maximum(known * (1.0 - known), 1.0 / count) / count)
    assert np.abs(z).max() < 5.0, z


def test_fast_diffusion_between_walls() -> None:
    """Uniform by then, thresholds all come down to the stretch within L²/(3 D) of the wall, hardly moving."""
    diffusion = 1e3
    ageing = Ageing(origins.rectangular(0.5, 1.5), diffusion)
    steady = master.steady_state(Contacts(WALLS.thresholds, ageing=ageing))
    assert steady.cycle_length - 0.5 == pytest.approx(1.0 / (3.0 * diffusion), rel=2.0 / diffusion)
    assert steady.cycle_length_error < 1e-5


def test_refusals() -> None:
    uneven = origins.mixture([origins.rectangular(0.5, 1.0), origins.rectangular(0.5, 1.5)], [0.5, 0.5])
    with pytest.raises(InputError, match=r"final: the density jumps at 1: there the drift"):
        Ageing(uneven, 0.1)
    Ageing(uneven, 0.1, closure="paper")
    steep = Contacts(stats.beta(2, 2, 0.5), ageing=Ageing(stats.beta(0.5, 0.5, 0.5), 0.1))
    with pytest.raises(InputError, match=r"the density of the final law diverges at 0\.5"):
        eq_model.simulate(steep, PATH, n_contacts=100)
    for final in (origins.rectangular(0.7, 1.5), origins.rectangular(0.5, 0.9)):
        with pytest.raises(InputError, match="fresh thresholds lies outside the final law"):
            Contacts(WALLS.thresholds, ageing=Ageing(final, 0.1))
