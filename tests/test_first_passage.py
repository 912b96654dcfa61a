"""Exact ageing: closed forms, two independent roads, an ensemble of diffusing thresholds, and use as a law."""

import numpy as np
import pytest
from scipy import stats
from scipy.special import log_ndtr, ndtr

import master
import origins
from master._old.diffusion_passage import _march, _Problem, _wall, diffusion_passage, narrowest
from master._old.first_passage import first_passage
from master._old.ornstein_passage import OrnsteinPassage
from master._old.potential import Potential
from origins import Ageing, InputError
from origins.thresholds.scipy_laws import as_thresholds

FRESH, FINAL = origins.gaussian(0.5, 0.1), origins.gaussian(1.0, 0.01)  # Fig. A05
F_K = {1000.0: 0.49954273622262, 100.0: 0.49648206862310, 10.0: 0.49062524668845, 3.0: 0.48790796833389}  # by v/D


def inverse_gaussian(x, value, diffusion, speed):
    """Survival of a Brownian motion from `value` above a level that gains on it at `speed` per unit of x."""
    width = np.sqrt(2.0 * diffusion * x)
    image = np.exp(value * speed / diffusion + log_ndtr((-value - speed * x) / width))
    return ndtr((value - speed * x) / width) - image


@pytest.mark.parametrize("diffusion", [1e-3, 0.05, 3.0])
def test_no_restoring_force_is_the_inverse_gaussian(diffusion: float) -> None:
    """One value that diffuses freely, by the integral equation: its kernel vanishes, but what is left must not."""
    passage = OrnsteinPassage(origins.identical(0.7), 1.0, 1e9, diffusion)
    x = np.linspace(0.05, 2.0, 60)
    law = first_passage(origins.identical(0.7), Ageing(origins.gaussian(1.0, 1e9), diffusion)).law
    np.testing.assert_allclose(law.sf(x), inverse_gaussian(x, 0.7, diffusion, 1.0), atol=2e-12)
    exact = 0.7 / np.sqrt(4.0 * np.pi * diffusion * x**3) * np.exp(-((0.7 - x) ** 2) / (4.0 * diffusion * x))
    np.testing.assert_allclose(passage.density(x), exact, rtol=1e-9, atol=1e-11 * exact.max())
    # mean 0.7, and the mean square of an inverse Gaussian
    assert law.mean() == pytest.approx(0.7, rel=1e-9)
    assert law.moment(2) == pytest.approx(0.49 + 2.0 * diffusion * 0.7, rel=1e-8)


@pytest.mark.parametrize("diffusion", [1e-3, 0.1])
def test_constant_drift_by_the_diffusion_equation(diffusion: float) -> None:
    """Towards an exponential law thresholds drift down steadily: inverse Gaussian again, averaged over the fresh."""
    final = as_thresholds(stats.expon(scale=0.5))
    passage = diffusion_passage(FRESH, final, diffusion, accuracy=1e-8)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    fresh = 0.65 + 0.65 * nodes
    weights = 0.65 * weights * FRESH.pdf(fresh)
    speed = 1.0 + diffusion / 0.5
    t = passage.advance[1:]
    known = sum(w * inverse_gaussian(t, v, diffusion, speed) for v, w in zip(fresh, weights, strict=True))
    error = np.abs(passage.survival[1:] - known).max()
    assert error < 1e-9 and error < passage.error < 1e-6
    law = first_passage(FRESH, Ageing(final, diffusion)).law
    between = np.linspace(0.01, 1.0, 99)
    known = sum(w * inverse_gaussian(between, v, diffusion, speed) for v, w in zip(fresh, weights, strict=True))
    np.testing.assert_allclose(law.sf(between), known, atol=1e-7)


def test_figure_a05_by_two_roads() -> None:
    forces = {v: first_passage(FRESH, Ageing(FINAL, 1.0), velocity=v).kinetic_force() for v in F_K}
    for v, (force, error) in forces.items():
        assert abs(force - F_K[v]) < 2e-13 and error < 1e-12
    printed = {1000.0: 0.4995, 100.0: 0.4965}
    for v, value in printed.items():
        assert abs(forces[v][0] - value) < 5e-5
    other = Ageing(FINAL, 1.0)
    other.normal = None  # the diffusion equation instead
    told = diffusion_passage(FRESH, FINAL, 1.0 / 100.0, accuracy=1e-5)
    law = first_passage(FRESH, Ageing(FINAL, 1.0), velocity=100.0).law
    difference = np.abs(law.sf(told.advance) - told.survival).max()
    assert difference < min(2e-7, told.error) and told.error < 1e-4


@pytest.mark.parametrize("start", [0.0, 0.15, -0.2])
@pytest.mark.parametrize("diffusion", [1e-4, 1e-2, 3.0])
def test_roads_agree_from_any_start(start: float, diffusion: float) -> None:
    fresh, final = origins.gaussian(0.5, 0.15), origins.gaussian(0.9, 0.08)
    exact = first_passage(fresh, Ageing(final, diffusion), start=start, accuracy=1e-11)
    told = diffusion_passage(fresh, final, diffusion, start)
    difference = np.abs(exact.law.sf(told.advance) - told.survival).max()
    assert difference < 1e-7 and difference < told.error + exact.error
    assert exact.error < 1e-11


def ensemble(fresh, mean, std, diffusion, start, step, count, generator):  # type: ignore[no-untyped-def]
    """Advances at which thresholds that diffuse meet |start + t|: exact steps, crossings within a step by the
    Brownian bridge, whose drift over a step is what is left out."""
    normal = origins.Ageing(origins.gaussian(mean, std), diffusion).normal
    least = abs(start)
    values = fresh.isf(float(fresh.sf(least)) * (1.0 - generator.random(count)))
    out, alive, t = np.zeros(count), np.arange(count), 0.0
    while alive.size:
        after = normal.draw(values, step, generator.standard_normal(alive.size))
        above, below = values - abs(start + t), after - abs(start + t + step)
        through = np.exp(-above * np.maximum(below, 0.0) / (diffusion * step))
        breaks = (below <= 0.0) | (generator.random(alive.size) < through)
        out[alive[breaks]] = t + step * generator.random(int(breaks.sum()))
        alive, values, t = alive[~breaks], after[~breaks], t + step
    return out


@pytest.mark.parametrize(("diffusion", "start", "step"), [(1e-3, 0.0, 2e-3), (2e-2, -0.2, 5e-4), (5e-3, 0.3, 1e-3)])
def test_ensemble_of_diffusing_thresholds(diffusion: float, start: float, step: float) -> None:
    fresh, final = origins.gaussian(0.5, 0.1), origins.gaussian(1.0, 0.05)
    drawn = ensemble(fresh, 1.0, 0.05, diffusion, start, step, 20_000, np.random.default_rng(5))
    law = first_passage(fresh, Ageing(final, diffusion), start=start).law
    z = (drawn.mean() - law.mean()) / (law.std() / np.sqrt(drawn.size))
    assert abs(z) < 4.0, z
    at = law.isf(np.linspace(0.02, 0.98, 25))
    known = law.sf(at)
    z = (np.array([(drawn > x).mean() for x in at]) - known) / np.sqrt(known * (1.0 - known) / drawn.size)
    assert np.abs(z).max() < 5.0, z


def test_order_of_convergence_in_time() -> None:
    """Seven at the ends of steps, by equal steps against the integral equation."""
    fresh, final, diffusion = origins.gaussian(0.7, 0.05), origins.gaussian(1.0, 0.1), 0.005
    law = first_passage(fresh, Ageing(final, diffusion)).law
    wall = _wall(fresh, final)
    problem = _Problem(fresh, Potential(final, wall), diffusion, 0.0, wall, wall, 1e-12)
    size = min(narrowest(fresh), narrowest(final))
    steps = np.array([16, 24, 32, 48])
    errors = []
    for n in steps:
        told = _march(problem, 0.5 * size, 1e-9, np.full(n, 0.9 / n))
        errors.append(abs(told.survival[-1] - float(law.sf(0.9))))
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(order - 7.0) < 0.2 and errors[-1] < 1e-6, (order, errors)


def test_limits() -> None:
    """Nothing ages: the fresh law, and F_k leaves it in proportion to D. All speeds are answered, F_k falls to 0."""
    at_rest = first_passage(FRESH, Ageing(FINAL, 0.0))
    assert at_rest.law is FRESH and at_rest.error == 0.0
    rates = np.array([1e-9, 1e-8, 1e-7])
    fresh_force = 0.5 * FRESH.moment(2) / FRESH.mean()
    change = [first_passage(FRESH, Ageing(FINAL, d)).kinetic_force()[0] - fresh_force for d in rates]
    assert np.polyfit(np.log(rates), np.log(change), 1)[0] == pytest.approx(1.0, abs=0.02)
    x = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(first_passage(FRESH, Ageing(FINAL, 1e-14)).law.sf(x), FRESH.sf(x), atol=1e-12)
    creep = [first_passage(FRESH, Ageing(FINAL, d)).kinetic_force()[0] for d in (1e-3, 1e-1, 1e1, 1e4, 1e8)]
    assert (np.diff(creep) < 0.0).all() and creep[-1] > 0.45
    for fresh in (origins.identical(0.5), origins.rectangular(0.3, 0.7), origins.lubricated(0.4)):
        for d in (1e-10, 1e-5, 1.0):
            law = first_passage(fresh, Ageing(FINAL, d)).law
            assert law.cdf(law.ppf(0.3)) == pytest.approx(0.3, abs=1e-12)
            assert law.mean() == pytest.approx(float(np.trapezoid(law.sf(y := np.linspace(0, 2, 20001)), y)), abs=1e-5)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_of_lengths_changes_nothing_else(scale: float) -> None:
    for final, other in [
        (FINAL, origins.gaussian(1.0 * scale, 0.01 * scale)),
        (origins.gw_plastic(1.0), origins.gw_plastic(1.0 / scale**2)),
    ]:
        here = first_passage(FRESH, Ageing(final, 1e-3)).kinetic_force()[0]
        there = first_passage(origins.gaussian(0.5 * scale, 0.1 * scale), Ageing(other, 1e-3 * scale**2), scale)
        assert there.kinetic_force()[0] / scale == pytest.approx(here, rel=1e-9)


def force_by_generations(law, end, step):  # type: ignore[no-untyped-def]
    """F(X) = X E(X) + integral of F(X - s) dP(s): by trapezia against the exact weight of each step."""
    x = step * np.arange(round(end / step) + 1)
    weights = np.diff(law.cdf(x))
    force, first = x * law.sf(x), 0.5 * weights[0]
    beside = np.append(0.5 * weights, 0.0) + np.append(0.0, 0.5 * weights)
    for n in range(1, x.size):
        # F(0) = 0: the last trapezium is half of what its neighbour takes
        force[n] = (force[n] + beside[1:n] @ force[n - 1 : 0 : -1]) / (1.0 - first)
    return force


@pytest.mark.parametrize("diffusion", [1e-4, 1e-2])
def test_effective_law_in_the_renewal_solver(diffusion: float) -> None:
    """F(X) from a relaxed start against its own renewal equation on a lattice, extrapolated."""
    passage = first_passage(FRESH, Ageing(FINAL, diffusion))
    contacts = origins.Contacts(passage.law)
    solution = master.solve(contacts, np.linspace(0.0, 3.0, 61), 1e-8)
    assert solution.success
    first, second, third = (force_by_generations(passage.law, 3.0, 0.05 / n)[::n] for n in (25, 50, 100))
    force = (64.0 * third - 20.0 * second + first) / 45.0  # errors of second and of fourth order taken away
    np.testing.assert_allclose(solution.force, force, atol=2e-8)
    steady = master.steady_state(contacts)
    assert steady.force == pytest.approx(passage.kinetic_force()[0], rel=1e-12)


def test_refusals() -> None:
    cases = [
        (lambda: first_passage(FRESH, Ageing(FINAL, 1.0), velocity=0.0), "velocity = 0.0: must be above zero"),
        (lambda: first_passage(FRESH, Ageing(FINAL, 1.0), start=50.0), "start = 50: lies beyond every threshold"),
        (
            lambda: first_passage(FRESH, Ageing(origins.rectangular(0.5, 1.5), 1.0)),
            "ageing: a weight of 0.5 of the fresh thresholds lies outside",
        ),
        (
            lambda: first_passage(origins.identical(0.5), Ageing(origins.gw_plastic(1.0), 1.0)),
            "thresholds: hold the single value 0.5: only towards a Gaussian final law",
        ),
    ]
    for call, begins in cases:
        with pytest.raises(InputError) as refusal:
            call()
        assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value), str(refusal.value)
