"""What a density alone gives: cdf, survival, moments on panels, against closed forms in both tails."""

import numpy as np
import pytest
from scipy import stats

import origins
from origins import InputError
from origins.thresholds.numerical import NumericalLaw
from origins.thresholds.scipy_laws import as_thresholds

LAWS = {
    "gaussian": origins.gaussian(1.0, 0.05),
    "most below 0": origins.gaussian(-1.0, 0.5),
    "x^(1/3) onset": origins.gw_elastic(1.0),
    "diverging at 0": origins.lubricated(1.0, power=-0.5, decay=0.5),
    "narrow, far from where one looks first": origins.gaussian(1.0, 1e-4),
    "from above 0": as_thresholds(stats.expon(2.0, 1e-3)),
    "two ends": as_thresholds(stats.beta(2.5, 3.0, 1.0, 0.5)),
}


def numerical(law: origins.Thresholds) -> NumericalLaw:
    return NumericalLaw(law.logpdf, *law.support(), law.breakpoints, law.onset_power)


def rounding(law: origins.Thresholds, x: np.ndarray) -> np.ndarray:
    """What the last bit of x may change, relative to a probability: by the law's width and to an end that is not 0."""
    lower, upper = law.support()
    narrow = np.minimum(law.std(), upper - x)
    if lower > 0.0:
        narrow = np.minimum(narrow, x - lower)
    hazard = np.maximum(1.0, -law.logsf(x))
    return 3e-15 * x / narrow * hazard


@pytest.mark.parametrize("name", LAWS)
def test_both_tails_and_moments(name: str) -> None:
    law = LAWS[name]
    found = numerical(law)
    upper = law.isf(10.0 ** -np.array([0.02, 0.3, 1, 3, 10, 30, 100, 290]))
    lower = law.ppf(10.0 ** -np.array([0.3, 1, 3, 8, 15]))
    for x, function in ((upper, "sf"), (upper, "logsf"), (lower, "cdf"), (lower, "logsf")):
        x = x[x < law.support()[1]]
        exact, off = getattr(law, function)(x), getattr(found, function)(x)
        assert (np.abs(off - exact) <= (3e-12 + rounding(law, x)) * np.abs(exact)).all()
    for n in (1, 2, 4):
        assert found.moment(n) == pytest.approx(law.moment(n), rel=1e-12)
    assert found.moment(2, law.mean()) == pytest.approx(law.std() ** 2, rel=1e-8)
    assert found.log_whole == pytest.approx(0.0, abs=1e-11)


def test_logarithm_where_the_survival_underflows() -> None:
    for law, x in (
        (origins.gaussian(1.0, 0.05), [4.0, 50.0, 1e6]),
        (origins.gw_elastic(1.0), [300.0, 1e9]),
    ):
        np.testing.assert_allclose(numerical(law).logsf(np.array(x)), law.logsf(x), rtol=1e-13)


def test_a_heavy_tail_has_few_moments() -> None:
    found = numerical(as_thresholds(stats.lomax(2.5)))
    assert found.moment(1) == pytest.approx(1.0 / 1.5, rel=1e-12) and found.moment(3) == np.inf


def test_kinks_and_jumps_that_are_not_told_are_found() -> None:
    law = as_thresholds(
        stats.rv_histogram((np.array([1.0, 3.0]), np.array([0.0, 1.0, 2.0])), density=False)
    )
    assert numerical(law).sf(np.array([0.5, 1.0, 1.5])) == pytest.approx(
        [0.875, 0.75, 0.375], rel=1e-13
    )
    triangle = as_thresholds(stats.triang(0.3))
    assert numerical(triangle).moment(2) == pytest.approx(stats.triang(0.3).moment(2), rel=1e-12)


@pytest.mark.parametrize(
    "law", [stats.beta(0.5, 0.5), stats.beta(2.0, 0.1), stats.beta(0.5, 0.5, loc=1.0)]
)
def test_a_pole_above_0_needs_a_cdf(law: object) -> None:
    """Next to it positions are rounded, and the density does not tell the weights."""
    with pytest.raises(InputError, match=r"the density diverges at x = [12]"):
        numerical(as_thresholds(law))
    with pytest.raises(InputError, match="diverges at x = 0; state its onset_power"):
        NumericalLaw(lambda x: -0.5 * np.log(x) - x, 0.0, np.inf)
