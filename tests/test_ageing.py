"""Ageing: the exact transition of a Gaussian target, and finite volumes for any target, against closed forms."""

import mpmath
import numpy as np
import pytest
from q15_references import evolved
from scipy import special, stats

import origins
from origins import Ageing, InputError
from origins.laws.ageing import OrnsteinUhlenbeck
from origins.laws.diffusion import Diffusion
from origins.thresholds.scipy_laws import as_thresholds

mpmath.mp.dps = 40
MEAN, STD, D = 1.0, 0.1, 5e-4


def mean_and_spread(x0, t):
    """Of the transition, in mpmath."""
    mean = MEAN + (x0 - MEAN) * mpmath.exp(-D / mpmath.mpf(STD) ** 2 * t)
    return mean, STD * mpmath.sqrt(-mpmath.expm1(-2 * D / mpmath.mpf(STD) ** 2 * t))


def density(x, x0, t):
    """The normal law that solves the equation below."""
    return mpmath.npdf(x, *mean_and_spread(x0, t))


def test_reference_solves_the_equation() -> None:
    """∂P/∂t = D ∂_x (Ũ' + ∂_x) P with Ũ' = -P_cf'/P_cf (paper, Eqs. L, B)."""

    def flux(x, t):
        slope = -mpmath.diff(lambda y: mpmath.log(mpmath.npdf(y, MEAN, STD)), x)
        return slope * density(x, 0.6, t) + mpmath.diff(lambda y: density(y, 0.6, t), x)

    for x, t in [(0.6, 3.0), (0.8, 10.0), (1.1, 40.0)]:
        change = mpmath.diff(lambda s, x=x: density(x, 0.6, s), t)
        assert abs(change / (D * mpmath.diff(lambda y, t=t: flux(y, t), x)) - 1) < 1e-12


def test_transition_of_a_gaussian_target() -> None:
    normal = Ageing(origins.gaussian(MEAN, STD), rate=D).normal
    assert normal is not None and (normal.mean, normal.std) == (MEAN, STD)
    for time in (1e-9, 1e-3, 1.0, 20.0, 1e4):
        mean, spread = mean_and_spread(0.6, time)
        assert abs(float(normal.mean_after(0.6, time)) / mean - 1) < 1e-14
        assert abs(float(normal.std_after(time)) / spread - 1) < 1e-14
    assert float(normal.mean_after(0.6, 1e9)) == MEAN and float(normal.std_after(1e9)) == STD


def test_transitions_chain_and_draws_follow_them() -> None:
    normal = OrnsteinUhlenbeck(MEAN, STD, 0.05)
    random = np.random.default_rng(3)
    one, two = random.standard_normal((2, 1_000_000))
    drawn = normal.draw(normal.draw(0.6, 12.0, one), 7.0, two)
    law = stats.norm(*map(float, mean_and_spread(0.6, 19.0)))
    assert stats.kstest(drawn, law.cdf).pvalue > 1e-4
    # no time, or no ageing: nothing moves
    still = Ageing(origins.gaussian(MEAN, STD), rate=0.0).normal
    assert still.draw(0.3, 5.0, 1.7) == 0.3 == normal.draw(0.3, 0.0, 1.7)
    assert Ageing(origins.gw_plastic(1.0), rate=D).normal is None


# -- finite volumes: weights between edges at 0 and after D t, and D t --------------------------------


def towards_rayleigh(edges):
    """P_cf = x exp(-x²/2); the Laguerre polynomial L_1(x²/2) = 1 - x²/2 decays as exp(-2Dt)."""
    z, t = 0.5 * edges**2, 0.35
    target, mode = -np.diff(np.exp(-z)), np.diff(z * np.exp(-z))
    return target - 0.9 * mode, target - 0.9 * np.exp(-2.0 * t) * mode, t


def towards_exponential(edges):
    """P_cf = exp(-x): a Brownian motion with the drift -1, reflected at 0 (its distribution in closed form)."""

    def below(x, t):
        width = np.sqrt(2.0 * t)
        return special.ndtr((x - 0.5 + t) / width) - np.exp(-x) * special.ndtr(
            (-x - 0.5 + t) / width
        )

    return np.diff(below(edges, 0.2)), np.diff(below(edges, 0.8)), 0.6


EXPONENTIAL = as_thresholds(stats.expon())
TARGETS = {
    "rayleigh": (origins.gw_plastic(0.5), 8.0 * np.linspace(0.0, 1.0, 801), towards_rayleigh),
    "exponential": (
        as_thresholds(stats.expon()),
        2.0 * np.sinh(np.linspace(0.0, 3.55, 801)),
        towards_exponential,
    ),
}


@pytest.mark.parametrize("name", TARGETS)
def test_order_of_convergence_is_two(name: str) -> None:
    target, edges, solution = TARGETS[name]
    every, errors = np.array([8, 4, 2, 1]), []
    for step in every:
        before, after, amount = solution(edges[::step])
        found = evolved(Diffusion(target, edges[::step]), before, amount)
        errors.append(np.abs(found - after).sum())
    order = np.polyfit(np.log(every), np.log(errors), 1)[0]
    assert abs(order - 2.0) < 0.2 and errors[-1] < 5e-4, (order, errors)


PEAKS = [origins.gaussian(0.5, 0.1), origins.gaussian(1.5, 0.2)]
LAWS = {
    "gaussian": origins.gaussian(1.0, 0.1),
    "gw-elastic": origins.gw_elastic(1.6),
    "rectangular": origins.rectangular(0.5, 1.5),
    "two peaks": origins.mixture(PEAKS, [0.3, 0.7]),
}


@pytest.mark.parametrize("name", LAWS)
def test_target_is_at_rest(name: str) -> None:
    """No flow between any two cells."""
    law = LAWS[name]
    lower, upper = law.support()
    edges = np.linspace(lower, upper if np.isfinite(upper) else float(law.isf(1e-13)), 301)
    hops = Diffusion(law, edges)
    np.testing.assert_allclose(hops.weights(law), hops.stationary, rtol=1e-9, atol=1e-12)
    there, back = hops.up * hops.stationary[:-1], hops.down * hops.stationary[1:]
    np.testing.assert_allclose(there, back, rtol=1e-13)


def test_narrow_target_far_away() -> None:
    """Fig. A05: the final density is exp(-1250) where fresh thresholds are; its logarithm is all that counts."""
    final, fresh = origins.gaussian(1.0, 0.01), origins.gaussian(0.5, 0.1)
    edges = np.linspace(0.0, 1.3, 1301)
    hops, normal = Diffusion(final, edges), Ageing(final, rate=1.0).normal
    after = evolved(hops, hops.weights(fresh), 1e-4)
    assert (after >= -1e-16).all() and after.sum() == pytest.approx(1.0, abs=1e-13)
    known = float(normal.mean_after(fresh.mean(), 1e-4))
    assert float(after @ (0.5 * (edges[1:] + edges[:-1]))) == pytest.approx(known, abs=1e-3)


def test_cut_at_zero_is_a_wall() -> None:
    """Half a Gaussian with a wall at 0 is a whole one by reflection, the even modes of which remain."""
    edges = np.linspace(0.0, 9.0, 901)

    def weights(time: float) -> np.ndarray:
        mean, std = 0.7 * np.exp(-time), np.sqrt(-np.expm1(-2.0 * time))
        return np.diff(special.ndtr((edges - mean) / std) + special.ndtr((edges + mean) / std))

    after = evolved(Diffusion(origins.gaussian(0.0, 1.0), edges), weights(0.3), 0.8)
    np.testing.assert_allclose(after, weights(1.1), atol=2e-7)


GRID = np.linspace(0.0, 2.0, 101)
NARROW = origins.gaussian(1.0, 0.1)
GAP = origins.mixture([origins.rectangular(0.1, 0.5), origins.rectangular(1, 2)], [0.5, 0.5])


@pytest.mark.parametrize(
    ("call", "begins"),
    [
        (lambda: Ageing(NARROW, -1.0), "rate = -1.0: must be zero or above"),
        (lambda: Ageing(NARROW, 1.0, "mean"), "closure = 'mean': "),
        (lambda: Ageing("gaussian", 1.0), "final = 'gaussian': "),
        (lambda: Ageing(origins.identical(1.5), 1.0), "final: holds the single value 1.5: "),
        (lambda: Ageing(GAP, 1), "final: has no weight between 0.5 and 1: "),
        (lambda: OrnsteinUhlenbeck(1.0, 0.1, 1.0).draw(0.5, -1.0, 0.0), "time = -1.0: must be"),
        (lambda: Diffusion(NARROW, [0.0, 1.0, 1.0, 2.0]), "edges = array of shape (4,): "),
        (lambda: Diffusion(origins.gaussian(1.0, 0.5), GRID), "final: has a weight of 0.0233 bey"),
        (lambda: Diffusion(origins.rectangular(0.5, 1.5), GRID), "final: has no weight, or one"),
    ],
)
def test_refusals(call, begins: str) -> None:
    with pytest.raises(InputError) as refusal:
        call()
    assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value)
