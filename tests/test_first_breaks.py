"""First breaks b_0 and J_0 against quadrature of their definition, whatever starts and thresholds look like."""

import mpmath
import numpy as np
import pytest
import scipy.stats
from scipy.special import gamma, gammainc, ndtr

import eq_model
import master
import origins
from master._old.first import FirstBreaks
from master._old.law import Law
from master._old.problem import Problem

mp = mpmath.MPContext()
mp.dps = 25
POSITIONS = np.array([0.003, 0.05, 0.31, 0.6, 0.93, 1.43, 2.7])

# law, its density and survival in mpmath, where it bends, and the integral of x P_c(x) from 0
LAWS = {
    "gaussian": (
        origins.gaussian(1.0, 0.1),
        lambda x: mp.npdf(x, 1, mp.mpf("0.1")) if x > 0 else mp.mpf(0),
        lambda x: mp.ncdf(-(x - 1) / mp.mpf(0.1)),
        [0.0, 0.5, 0.8, 0.9, 1.0, 1.1, 1.2, 1.5, 2.3],
        lambda t: ndtr((t - 1.0) / 0.1) - 0.1 * np.exp(-50.0 * (t - 1.0) ** 2) / np.sqrt(2.0 * np.pi),
    ),
    "rectangular": (
        origins.rectangular(0.5, 1.5),
        lambda x: mp.mpf(1) if 0.5 < x < 1.5 else mp.mpf(0),
        lambda x: min(max(mp.mpf(1.5) - x, mp.mpf(0)), mp.mpf(1)),
        [0.0, 0.5, 1.5],
        lambda t: 0.5 * (np.clip(t, 0.5, 1.5) ** 2 - 0.25),
    ),
    "weibull": (
        origins.gw_plastic(1.0),
        lambda x: 2 * x * mp.exp(-x * x),
        lambda x: mp.exp(-x * x),
        [0.0, 0.5, 1.0, 2.0, 4.0, 7.0],
        lambda t: gamma(1.5) * gammainc(1.5, t**2),
    ),
    "exponential": (
        scipy.stats.expon(),
        lambda x: mp.exp(-x),
        lambda x: mp.exp(-x),
        [0.0, 0.5, 1.0, 2.0, 4.0, 8.0],
        lambda t: gammainc(2.0, t),
    ),
    "onset": (
        origins.gw_elastic(1.0),
        lambda x: mp.mpf(4) / 3 * mp.cbrt(x) * mp.exp(-x * mp.cbrt(x)),
        lambda x: mp.exp(-x * mp.cbrt(x)),
        [0.0, *4.0 ** np.arange(-20, 2)],
        lambda t: gamma(1.75) * gammainc(1.75, t ** (4.0 / 3.0)),
    ),
}
_DEVIATIONS = np.array([-9.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0, 9.0])
STARTS = {
    "gaussian": (origins.gaussian_start(0.05, 0.04), scipy.stats.norm(0.05, 0.04).pdf, 0.05 + 0.04 * _DEVIATIONS),
    "wide": (origins.gaussian_start(-0.02, 0.05), scipy.stats.norm(-0.02, 0.05).pdf, -0.02 + 0.05 * _DEVIATIONS),
    "uniform": (scipy.stats.uniform(-0.2, 0.5), lambda x: np.full(x.shape, 2.0), np.array([-0.2, 0.3])),
}


def first_breaks(law, start, end=5.0):
    """FirstBreaks in lengths, not in mean thresholds: density, released stretch, unit."""
    contacts = origins.Contacts(law, start)
    unit = contacts.mean_threshold
    scaled = Law(contacts, 1.7 * end / unit + max(contacts.start.span[1] / unit, 0.0))
    return FirstBreaks(contacts, scaled, end / unit, 1e-15), unit


def sum_over(function, marks, low, high):
    """Integral by 40 Gauss nodes between neighbouring marks; shape of function(x) less its last axis."""
    edges = np.unique(np.clip(np.append(marks, [low, high]), low, high))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    half = 0.5 * np.diff(edges)[:, None]
    x = (0.5 * (edges[1:] + edges[:-1])[:, None] + half * nodes).ravel()
    return (function(x) * (half * weights).ravel()).sum(-1)


def exact_at(at, law, law_edges, partial_mean, start_pdf, start_edges):
    """(b_0, J_0) at X = at: J_0 counts thresholds between |x| and x + X, released at their own value."""

    def both(x):
        low, high = np.abs(x), np.maximum(x + at, np.abs(x))
        held = start_pdf(x) / law.sf(low)
        return held * np.stack([np.where(high > low, law.pdf(high), 0.0), partial_mean(high) - partial_mean(low)])

    edges = np.array(law_edges)
    marks = np.concatenate([start_edges, [0.0, -0.5 * at], edges - at, edges, -edges])
    return sum_over(both, marks, start_edges[0], start_edges[-1])


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("law", LAWS)
def test_a_distribution_of_starts(law, start):
    thresholds, _, _, law_edges, partial_mean = LAWS[law]
    first, unit = first_breaks(thresholds, STARTS[start][0])
    for at in POSITIONS:
        density, released = exact_at(at, thresholds, law_edges, partial_mean, *STARTS[start][1:])
        assert first.density(np.array([at / unit]))[0] / unit == pytest.approx(density, rel=2e-12, abs=2e-13)
        assert first.released(np.array([at / unit]))[0] * unit == pytest.approx(released, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("start", [0.0, 0.2, 0.7, -0.2, -0.7])
@pytest.mark.parametrize("law", LAWS)
def test_a_single_start(law, start):
    thresholds, pdf, sf, law_edges, _ = LAWS[law]
    first, unit = first_breaks(thresholds, start)
    survival = sf(abs(mp.mpf(start)))
    for at in POSITIONS:
        top, low = start + float(at), abs(start)
        held = pdf(mp.mpf(top)) / survival if top > low else mp.mpf(0)
        marks = sorted({mp.mpf(low), mp.mpf(top), *[mp.mpf(e) for e in law_edges if low < e < top]})
        released = mp.quad(lambda x: x * pdf(x), marks) / survival if top > low else mp.mpf(0)
        assert first.density(np.array([at / unit]))[0] / unit == pytest.approx(float(held), rel=1e-11, abs=1e-13)
        assert first.released(np.array([at / unit]))[0] * unit == pytest.approx(float(released), rel=1e-12, abs=1e-14)
    assert first.mean_start * unit == pytest.approx(start, abs=1e-16)


@pytest.mark.parametrize("start", [None, 0.3, -0.3, origins.gaussian_start(0.0, 0.05), scipy.stats.uniform(-0.2, 0.5)])
@pytest.mark.parametrize("law", LAWS)
def test_every_contact_breaks_once(law, start):
    first, _ = first_breaks(LAWS[law][0], start, end=60.0)
    assert first.density.total + first.atom_weights.sum() == pytest.approx(1.0, abs=1e-13)


@pytest.mark.parametrize("law", [LAWS["gaussian"][0], LAWS["rectangular"][0]])
def test_what_is_cut_from_a_start_is_not_missed_from_the_rest(law):
    # a weight of about 4e-7 lies where no threshold is left, or fewer than floating point can tell
    end = min(law.support()[1], float(law.isf(1e-300)))
    first, _ = first_breaks(law, scipy.stats.expon(0.0, end / 14.8), end=60.0)
    assert first.density.total == pytest.approx(1.0, abs=1e-12)


def test_identical_thresholds_break_at_once_or_as_the_start_is_spread():
    first, _ = first_breaks(origins.identical(1.0), 0.3)
    assert first.atoms == pytest.approx([0.7], abs=1e-16)
    assert first.atom_weights == pytest.approx([1.0], abs=1e-16)
    assert first.released(np.array([0.69, 0.7, 0.71])) == pytest.approx([0.0, 1.0, 1.0], abs=1e-15)
    first, _ = first_breaks(origins.identical(1.0), origins.gaussian_start(0.1, 0.02))
    x = np.linspace(0.7, 1.1, 81)
    assert not first.atoms.size
    assert first.density(x) == pytest.approx(scipy.stats.norm(0.9, 0.02).pdf(x), rel=1e-12, abs=1e-12)
    assert first.released(x) == pytest.approx(scipy.stats.norm(0.9, 0.02).cdf(x), rel=1e-12, abs=1e-13)


def test_an_atom_beside_a_density_counts_only_for_contacts_below_it():
    law = origins.mixture([origins.identical(0.6), origins.rectangular(0.5, 1.5)], [0.25, 0.75])
    first, unit = first_breaks(law, 0.2)
    assert first.atoms * unit == pytest.approx([0.4], rel=1e-14)
    assert first.atom_weights == pytest.approx([0.25], rel=1e-14)
    first, unit = first_breaks(law, 0.7)
    assert not first.atoms.size
    assert first.density(np.array([0.1 / unit]))[0] / unit == pytest.approx(1.0 / 0.8, rel=1e-13)


def test_an_atom_reads_every_jump_of_the_survival_that_a_start_is_conditioned_on():
    # 1/S(|x_0|) jumps at the atom and bends at the rectangle, on both sides of 0
    law = origins.mixture(
        [origins.rectangular(0.1, 0.2), origins.identical(0.5), origins.gaussian(2.0, 0.1)], [0.5, 0.3, 0.2]
    )
    contacts = origins.Contacts(law, start=origins.gaussian_start(mean=-0.3, std=0.2))
    first = Problem(contacts, 6.0 / contacts.mean_threshold, 1e-8).first
    assert first.error < 1e-10


@pytest.mark.parametrize("std", [1e-2, 1e-3, 1e-4, 1e-5])
def test_a_narrow_law_under_a_start_that_reaches_down_to_it(std):
    # b_0 is cut off within some std of twice the thresholds, far from all else that happens
    contacts = origins.Contacts(origins.gaussian(1.0, std), scipy.stats.uniform(-1.0 + std, 0.5))
    first = Problem(contacts, 5.0, 1e-8).first
    assert abs(first.density.total - 1.0) < 1e-12 and first.error < 1e-11


def test_a_start_that_diverges_makes_no_jump():
    law = origins.mixture([origins.identical(1.0), origins.gaussian(1.0, 0.1)], [0.3, 0.7])
    contacts = origins.Contacts(law, scipy.stats.gamma(0.5, 0.0, 0.02))
    assert np.abs(Problem(contacts, 4.0, 1e-6).first.jump_sizes).max() < 10.0
    path = [0.99, 1.0, 1.01, 1.999, 2.0, 2.001, 3.0]
    ensemble = eq_model.simulate(contacts, path, n_contacts=200_000)
    z = (master.solve(contacts, path, 1e-6).force - ensemble.force) / ensemble.force_standard_error
    assert np.abs(z).max() < 5.0
