"""gw_gaussian: Gaussian heights in every regime against mpmath, its limits in order, samples, and metres beside it."""

import mpmath
import numpy as np
import pytest

import origins
from origins.roughness.gw_gaussian import EXPONENTS
from origins.thresholds.families import Weibull
from origins.thresholds.law import Thresholds
from origins.thresholds.quadrature import gauss, panel_edges

UPPER = 10.0 ** -np.array([0.02, 0.3, 1, 2, 5, 10, 30, 80, 150, 220, 280])
LOWER = 10.0 ** -np.array([0.05, 0.5, 1, 3, 8, 15, 22, 30])
SEPARATIONS = [-1e3, -3.0, 2.0, 40.0, 1e6]
REGIMES = [("elastic", None), ("plastic", None), ("mixed", 0.5), ("mixed", 7.0), ("mixed", 40.0), ("mixed", 1e4)]
SCALE = 3e-8


def compression(x: float, law: str, regime: str, index: float | None) -> mpmath.mpf:
    """delta/sigma_h at which the threshold is x, written out: scale delta^b, the part at delta = 1 having `scale`."""
    elastic, plastic = (mpmath.mpf(b) for b in EXPONENTS[law])
    y = mpmath.mpf(x) / mpmath.mpf(SCALE)
    if index is None:
        return y ** (1 / (elastic if regime == "elastic" else plastic))
    at = (9 * mpmath.pi / (4 * mpmath.mpf(index))) ** 2
    # x(delta_c): along the part that passes through scale at delta = 1
    mark = at ** (elastic if at > 1 else plastic)
    return at * (y / mark) ** (1 / (elastic if y < mark else plastic))


def slope(x: float, law: str, regime: str, index: float | None) -> mpmath.mpf:
    """d log delta / d log x."""
    if index is None:
        return 1 / mpmath.mpf(EXPONENTS[law][regime == "plastic"])
    at = (9 * mpmath.pi / (4 * mpmath.mpf(index))) ** 2
    return 1 / mpmath.mpf(EXPONENTS[law][bool(compression(x, law, regime, index) > at)])


@pytest.mark.parametrize("z", SEPARATIONS)
@pytest.mark.parametrize("law", ["paper", "amontons", "strength"])
def test_all_of_it_against_mpmath(law: str, z: float) -> None:
    """Relative 1e-10 of survival to 1e-280, cdf to 1e-30 and density; quantiles; weight 1 to 1e-12."""
    mpmath.mp.dps = 60
    touching = mpmath.erfc(mpmath.mpf(z) / mpmath.sqrt(2)) / 2
    for regime, index in REGIMES:
        p = origins.gw_gaussian(z, SCALE, law=law, regime=regime, plasticity_index=index)
        # where the law is narrow a quantile is exact to the last bits of x
        for quantile, q, function in ((p.isf, UPPER, p.sf), (p.ppf, LOWER, p.cdf)):
            x = quantile(q)
            assert (np.abs(function(x) - q) <= 1e-10 * q + 1e-15 * x * p.pdf(x)).all()
            for one, rounded in zip(x, np.spacing(x) / x, strict=True):
                delta = compression(one, law, regime, index)
                survival = mpmath.erfc((z + delta) / mpmath.sqrt(2)) / 2 / touching
                density = mpmath.npdf(z + delta) / touching * delta * slope(one, law, regime, index) / one
                # one rounding of delta itself, amplified where a normal law lies far from 0
                slack = 1e-10 + 4.0 * rounded * float(abs(delta) * max(abs(z), 1.0)) * (z < -100.0)
                exact = survival if function == p.sf else 1 - survival
                assert abs(float(function(one) / exact) - 1.0) < slack
                assert abs(float(p.pdf(one) / density) - 1.0) < slack
                assert abs(float(p.logsf(one) - mpmath.log(survival))) < slack * max(1.0, -float(mpmath.log(survival)))
        edges = panel_edges(p)
        nodes, weights = gauss(edges[:-1], edges[1:])
        assert (weights * p.pdf(nodes)).sum() == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("z", [-3.0, 2.0, 37.0])
@pytest.mark.parametrize("law", ["paper", "amontons", "strength"])
def test_moments_in_closed_form_and_by_panels(law: str, z: float) -> None:
    mpmath.mp.dps = 40
    for regime, index in REGIMES:
        p = origins.gw_gaussian(z, SCALE, law=law, regime=regime, plasticity_index=index)
        for n in (1, 2, 3, 4):
            if index is None:
                order = mpmath.mpf(n * EXPONENTS[law][regime == "plastic"])
                parabolic = mpmath.gamma(order + 1) * mpmath.exp(-mpmath.mpf(z) ** 2 / 4)
                parabolic *= mpmath.pcfd(-order - 1, z) / mpmath.sqrt(2 * mpmath.pi) / mpmath.ncdf(-z)
                assert p.moment(n) == pytest.approx(float(parabolic) * SCALE**n, rel=1e-11)
            # an integral over heights on one side, over thresholds on the other
            assert p.moment(n) == pytest.approx(Thresholds._moment(p, n), rel=1e-11)


@pytest.mark.parametrize(("law", "regime"), [("paper", "elastic"), ("paper", "plastic"), ("amontons", "elastic")])
def test_light_loads_tend_to_exponential_heights_in_order(law: str, regime: str) -> None:
    """S e^tau = 1 - (tau + tau²/2)/z² + (2 tau + tau² + tau³/2 + tau⁴/8)/z⁴ + O(z^-6), tau = z delta/sigma_h."""
    exponent = EXPONENTS[law][regime == "plastic"]
    tau = np.array([0.1, 0.7, 2.0, 4.0])
    left = []
    separations = np.array([10.0, 20.0, 40.0])
    for z in separations:
        x = (tau / z) ** exponent
        ratio = origins.gw_gaussian(z, 1.0, law=law, regime=regime).sf(x) * np.exp(tau)
        first, second = (tau + tau**2 / 2) / z**2, (2 * tau + tau**2 + tau**3 / 2 + tau**4 / 8) / z**4
        left.append([np.abs(ratio - 1.0), np.abs(ratio - 1.0 + first), np.abs(ratio - 1.0 + first - second)])
    orders = -np.diff(np.log(np.array(left)), axis=0) / np.log(2.0)
    # at z = 40 the last of them is 1e-9, and 1e-13 of round-off is seen where tau is small
    assert np.abs(orders[0] - [[2.0], [4.0], [6.0]]).max() < 0.35
    # the limit is a standard family: (GW3), (GW4) and an exponential
    family = {"elastic": origins.gw_elastic, "plastic": origins.gw_plastic}[regime]
    far = origins.gw_gaussian(1e6, 1.0, law=law, regime=regime)
    limit = family(1e6) if law == "paper" else Weibull(1.0, 1e6, 0.0)
    x = limit.isf(UPPER[:6])
    assert far.sf(x) == pytest.approx(limit.sf(x), rel=1e-9)


@pytest.mark.parametrize(("law", "jump"), [("paper", 1.5), ("amontons", 2.0), ("strength", 1.0)])
def test_density_jumps_where_contacts_turn_plastic(law: str, jump: float) -> None:
    p = origins.gw_gaussian(1.0, SCALE, law=law, regime="mixed", plasticity_index=9.0)
    at = (2.25 * np.pi / 9.0) ** 2
    mark = SCALE * at**0.5  # below sigma_h: along the plastic part
    assert p.breakpoints == pytest.approx([0.0, mark] if jump > 1.0 else [0.0], rel=1e-14)
    near = mark * np.array([1 - 1e-12, 1 + 1e-12])
    below, above = p.pdf(near)
    assert above / below == pytest.approx(jump, rel=1e-10)
    # nothing else jumps: no gap and no weight at one value
    survival = p.sf(near)
    assert survival[0] / survival[1] == pytest.approx(1.0, abs=1e-11)
    assert p.atoms[0].size == 0 and p.isf(survival) == pytest.approx(near, rel=1e-13)
    beyond = mpmath.ncdf(-(1 + at)) / mpmath.ncdf(-1)
    assert float(p.sf(mark)) == pytest.approx(float(beyond), rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((np.nan, 1.0), "separation = nan"),
        ((-1.1e3, 1.0), "separation = -1100.0: is h0/sigma_h"),
        ((2e6, 1.0), "separation = 2000000.0: is h0/sigma_h"),
        ((1.0, 0.0), "scale = 0.0"),
        ((2.0, 1e300), "scale = 1e+300: must lie between"),
        ((2.0, 1e-300), "scale = 1e-300: must lie between"),
        ((1.0, 1.0, "coulomb"), "law = 'coulomb'"),
        ((1.0, 1.0, "paper", "hard"), "regime = 'hard'"),
        ((1.0, 1.0, "paper", "mixed"), "plasticity_index = None"),
        ((1.0, 1.0, "paper", "mixed", -2.0), "plasticity_index = -2.0"),
        ((1.0, 1.0, "paper", "elastic", 2.0), "plasticity_index = 2.0: belongs to regime"),
    ],
)
def test_bad_parameters_are_named(arguments: tuple, says: str) -> None:
    with pytest.raises(origins.InputError) as caught:
        origins.gw_gaussian(*arguments)
    assert str(caught.value).startswith(says) and "\n" not in str(caught.value)
