"""gw_gaussian: moments in every regime against mpmath, its limits in order, the jump where contacts turn plastic."""

import mpmath
import numpy as np
import pytest

import origins
from origins.roughness.gw_gaussian import EXPONENTS
from origins.thresholds.families import Weibull
from origins.thresholds.law import Thresholds

UPPER = 10.0 ** -np.array([0.02, 0.3, 1, 2, 5, 10, 30, 80, 150, 220, 280])
REGIMES = [
    ("elastic", None),
    ("plastic", None),
    ("mixed", 0.5),
    ("mixed", 7.0),
    ("mixed", 40.0),
    ("mixed", 1e4),
]
SCALE = 3e-8


@pytest.mark.parametrize(("z", "law"), [(-3.0, "amontons"), (2.0, "paper"), (37.0, "strength")])
def test_moments_in_closed_form_and_by_panels(law: str, z: float) -> None:
    mpmath.mp.dps = 40
    for regime, index in REGIMES:
        p = origins.gw_gaussian(z, SCALE, law=law, regime=regime, plasticity_index=index)
        for n in (1, 2, 3, 4):
            if index is None:
                order = mpmath.mpf(n * EXPONENTS[law][regime == "plastic"])
                parabolic = mpmath.gamma(order + 1) * mpmath.exp(-(mpmath.mpf(z) ** 2) / 4)
                parabolic *= (
                    mpmath.pcfd(-order - 1, z) / mpmath.sqrt(2 * mpmath.pi) / mpmath.ncdf(-z)
                )
                assert p.moment(n) == pytest.approx(float(parabolic) * SCALE**n, rel=1e-11)
            # an integral over heights on one side, over thresholds on the other
            assert p.moment(n) == pytest.approx(Thresholds._moment(p, n), rel=1e-11)


@pytest.mark.parametrize(
    ("law", "regime"), [("paper", "elastic"), ("paper", "plastic"), ("amontons", "elastic")]
)
def test_light_loads_tend_to_exponential_heights_in_order(law: str, regime: str) -> None:
    """S e^tau = 1 - (tau + tau²/2)/z² + (2 tau + tau² + tau³/2 + tau⁴/8)/z⁴ + O(z^-6), tau = z delta/sigma_h."""
    exponent = EXPONENTS[law][regime == "plastic"]
    tau = np.array([0.1, 0.7, 2.0, 4.0])
    left = []
    separations = np.array([10.0, 20.0, 40.0])
    for z in separations:
        x = (tau / z) ** exponent
        ratio = origins.gw_gaussian(z, 1.0, law=law, regime=regime).sf(x) * np.exp(tau)
        first, second = (
            (tau + tau**2 / 2) / z**2,
            (2 * tau + tau**2 + tau**3 / 2 + tau**4 / 8) / z**4,
        )
        left.append(
            [np.abs(ratio - 1.0), np.abs(ratio - 1.0 + first), np.abs(ratio - 1.0 + first - second)]
        )
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


@pytest.mark.parametrize(("law", "exponent"), [("amontons", 1.0), ("paper", 0.75)])
def test_the_heaviest_loads_press_all_heights(law: str, exponent: float) -> None:
    """At h0 = -1000 sigma_h compressions are the heights themselves, a Gaussian about 1000 sigma_h."""
    p = origins.gw_gaussian(-1e3, SCALE, law=law)
    assert EXPONENTS[law][0] == exponent
    for beyond in (-6.0, -1.0, 0.0, 2.0, 30.0):
        x = SCALE * (1e3 + beyond) ** exponent
        assert float(p.sf(x)) == pytest.approx(float(mpmath.ncdf(-beyond)), rel=1e-9)
