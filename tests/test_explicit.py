"""The paper's explicit scheme: the exact Gaussian answer, order of convergence, numbers kept, and `solve` beside it."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ndtr
from scipy.stats import expon

import master
import origins
from master.lives.heat.mean_rate import MeanRateLife
from master.paper.explicit import MOST_NODES, explicit
from origins.thresholds.scipy_laws import as_thresholds

PATH = np.linspace(0.0, 5.0, 501)
STEPS = (0.01, 0.005, 0.0025)


def gaussian_force(x, mean=1.0, std=0.05, start_std=0.025):
    """Closed form for Gaussian thresholds and a Gaussian start about 0, weight below 0 neglected."""
    n = np.arange(1, 40)[:, None]
    width = np.sqrt(n * std**2 + start_std**2)
    z = (x - n * mean) / width
    density = np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
    return x - (mean * ndtr(z) - std**2 / width * density).sum(axis=0)


@pytest.fixture(scope="module")
def gaussian_scene():
    return origins.Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, 0.025))


@pytest.mark.parametrize(("breaking", "at_finest"), [("survival", 0.01179), ("printed", 0.01401)])
def test_gaussian_scene_converges_at_first_order(gaussian_scene, breaking, at_finest):
    exact = gaussian_force(PATH)
    errors = {step: np.abs(explicit(gaussian_scene, PATH, step, breaking).force - exact).max() for step in STEPS}
    order = np.polyfit(np.log(list(errors)), np.log(list(errors.values())), 1)[0]
    assert abs(order - 1.0) < 0.2
    assert errors[STEPS[-1]] == pytest.approx(at_finest, rel=0.005)


@pytest.mark.parametrize("breaking", ["survival", "printed"])
@pytest.mark.parametrize(
    "start", [None, 0.31, origins.gaussian_start(0.1, 0.025)], ids=["relaxed", "single", "gaussian"]
)
@pytest.mark.parametrize(
    "thresholds",
    [origins.rectangular(0.5, 1.5), origins.gw_elastic(1.0), origins.persson(1.0, 0.5)],
    ids=["rectangular", "gw_elastic", "persson"],
)
def test_agrees_with_solve_to_its_own_first_order_error(thresholds, start, breaking):
    contacts = origins.Contacts(thresholds, start)
    reference = master.solve(contacts, PATH, 1e-8).force
    coarse, fine = (explicit(contacts, PATH, step, breaking).force for step in (0.01, 0.005))
    # errors linear in the step: the finer one is off by what halving changed, and extrapolation takes that away
    own_error = np.abs(coarse - fine).max()
    assert np.abs(fine - reference).max() < 1.1 * own_error
    assert np.abs(2.0 * fine - coarse - reference).max() < 0.1 * own_error


def test_constant_hazard_slides_as_in_q14c():
    """P(x) = p beyond x_s: F_k = [x_s + 1/p + 1/p/(1 + p x_s)]/2, Eq. Q14c."""
    contacts = origins.Contacts(as_thresholds(expon(0.5, 0.25)))
    coarse, fine = (explicit(contacts, [30.0], step, "printed").force[0] for step in (0.01, 0.005))
    assert 2.0 * fine - coarse == pytest.approx(0.5 * (0.5 + 0.25 + 0.25 / 3.0), abs=1e-4)
    assert abs(fine - coarse) > 1e-3


def mean_rate_by_quadrature(thresholds, thermal, x):
    """Integral of h(x; x_s) P_c(x_s) over x_s = x + s² > x, which takes the root of stiff contacts away."""
    top = np.sqrt(float(thresholds.isf(1e-18)) - x)
    corners = np.sqrt(np.clip([0.02, 0.5 - x, 1.0 - x], 1e-3, top**2))
    options = {"points": corners, "epsabs": 1e-14, "epsrel": 1e-10, "limit": 400}
    return quad(lambda s: 2.0 * s * thresholds.pdf(x + s * s) * thermal.rate(x, x + s * s), 0.0, top, **options)[0]


@pytest.mark.parametrize(("law", "temperature"), [("soft", 0.3), ("soft", 2e-3), ("stiff", 0.3), ("stiff", 2e-3)])
def test_mean_rate_is_the_integral_of_temper3(law, temperature):
    thermal = origins.Thermal(law, temperature, closure="paper")
    x = np.array([0.0, 0.4, 0.83, 1.0, 1.3])
    for thresholds in (origins.gaussian(1.0, 0.1), origins.rectangular(0.5, 1.5)):
        known = [mean_rate_by_quadrature(thresholds, thermal, at) for at in x.tolist()]
        found = MeanRateLife(origins.Contacts(thresholds, thermal=thermal)).table.rate(x)
        np.testing.assert_allclose(found, known, rtol=1e-8, atol=1e-13)


def test_identical_thresholds_on_the_grid_stay_an_exact_sawtooth():
    path = 0.125 * np.arange(0, 400) + 0.0625
    force = explicit(origins.Contacts(origins.identical(1.0)), path, 0.0625).force
    assert np.abs(force - path % 1.0).max() < 1e-13


def test_a_start_below_zero_is_a_relaxed_start_that_comes_later():
    # Q(x;X) does not know that thresholds of contacts from -0.5 exceed 0.5
    thresholds = origins.rectangular(0.0, 2.0)
    relaxed = explicit(origins.Contacts(thresholds), PATH, 0.01).force
    below = explicit(origins.Contacts(thresholds, -0.5), PATH + 0.5, 0.01).force
    assert np.abs(below - relaxed).max() < 1e-13
    assert explicit(origins.Contacts(thresholds, -0.5), [0.0, 0.25], 0.01).force == pytest.approx([-0.5, -0.25])


@pytest.mark.parametrize(
    ("path", "step", "breaking", "words"),
    [
        ([0.0, 1.0], 0.0, "survival", "step = 0.0: must be above zero"),
        ([0.0, 1.0], float("nan"), "survival", "step = nan: must be finite"),
        ([0.0, 1.0], 1.0 / (2 * MOST_NODES), "survival", "write step="),
        ([1.0, 0.0], 0.1, "survival", "does not turn round"),
        ([0.0, 1.0], 0.1, "exact", 'must be "survival" or "printed"'),
    ],
)
def test_bad_input_is_refused_in_one_line(path, step, breaking, words):
    with pytest.raises(origins.InputError) as caught:
        explicit(origins.Contacts(origins.gaussian(1.0, 0.1)), path, step, breaking)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_printed_fraction_is_refused_for_exact_single_values():
    with pytest.raises(origins.InputError, match='write "survival"'):
        explicit(origins.Contacts(origins.identical(1.0)), [0.0, 1.0], 0.1, "printed")
