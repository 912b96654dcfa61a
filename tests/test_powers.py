"""Laws that end, begin or diverge as a power above 0: against closed forms, fine lattices and what they must reach."""

import mpmath
import numpy as np
import pytest
from scipy import special, stats

import master
import origins
from master._old.powers import find_powers
from master._old.problem import Problem
from master._old.renewal import LaterReleased
from master._old.response import SpreadSolution


def two_generations(a: float, b: float, x: float) -> float:
    """F(X) for thresholds beta(a, b) from 1 to 2, relaxed start, X up to 3: no contact breaks thrice.

    Of two breaks by X the second releases as much as the first on average: E[xi; xi + xi' <= X].
    """
    with mpmath.workdps(18):
        x, a, b = mpmath.mpf(x), mpmath.mpf(a), mpmath.mpf(b)

        def cdf(u: mpmath.mpf, more: int = 0) -> mpmath.mpf:
            return mpmath.betainc(a + more, b, 0, min(max(u, 0), 1), regularized=True)

        first = cdf(x - 1) + a / (a + b) * cdf(x - 1, 1)
        top = min(x - 2, mpmath.mpf(1))
        if top <= 0:
            return float(x - first)
        # u = top t^8 and so on: both ends are powers; where X < 3 the density is smooth at its upper end
        power = 8

        def from_below(t: mpmath.mpf) -> mpmath.mpf:
            u = top * t**power
            return (1 + u) * u ** (a - 1) * (1 - u) ** (b - 1) * cdf(x - 2 - u) * power * u / t

        def from_above(t: mpmath.mpf) -> mpmath.mpf:
            rest = top * t**power
            u = top - rest
            return (1 + u) * u ** (a - 1) * (1 - top + rest) ** (b - 1) * cdf(x - 2 - u) * power * rest / t

        half = mpmath.mpf("0.5") ** (mpmath.mpf(1) / power)
        near = [0, *[t for t in [(abs(x - 3) / top) ** (mpmath.mpf(1) / power)] if 0 < t < half], half]
        again = mpmath.quad(from_below, [0, half]) + mpmath.quad(from_above, near)
        return float(x - first - again / mpmath.beta(a, b))


@pytest.mark.parametrize(("a", "b"), [(0.3, 0.3), (0.7, 0.4)])
def test_two_generations_in_closed_form(a: float, b: float) -> None:
    """Next to the places where F begins to bend and to fall, and between."""
    beside = 10.0 ** -np.array([1.0, 4.0, 7.0, 11.0])
    x = np.unique(np.concatenate([[1.5, 2.0, 2.5], 1.0 + beside, 2.0 - beside, 2.0 + beside, 3.0 - beside]))
    exact = np.array([two_generations(a, b, value) for value in x])
    # the end of the path lies beyond, where contacts have broken thrice
    contacts = origins.Contacts(stats.beta(a, b, 1.0, 1.0))
    solution = master.solve(contacts, np.append(x, 6.0), 1e-8)
    assert solution.success
    assert np.abs(solution.force[:-1] - exact).max() <= solution.force_error * contacts.mean_threshold


@pytest.mark.parametrize(
    ("powers", "start"),
    [((0.5, 0.5), None), ((0.3, 0.3), None), ((2.0, 0.7), None), ((0.7, 0.4), 0.1), ((1.5, 1.3), -0.1)],
)
def test_against_a_lattice_that_knows_no_powers(powers: tuple[float, float], start: float | None) -> None:
    """A hundred times finer, and read sixty of its nodes away from every place; first breaks in closed form."""
    a, b = powers
    law = stats.beta(a, b)
    contacts, unit, end = origins.Contacts(law, start), law.mean(), 4.0
    problem = Problem(contacts, end, 1e-9)
    assert problem.powers is not None
    step = end / 2**17
    near = problem.powers.places[:, None] + step * np.array([-3e3, -400.0, -90.0, -60.0, 60.0, 90.0, 400.0, 3e3])
    x = np.sort(np.append(near.ravel(), np.linspace(0.05, end, 40)))
    x = x[(x <= end) & (np.abs(x[:, None] - problem.powers.places).min(axis=1) > 59.0 * step)]
    solution = master.solve(contacts, x * unit, 1e-8)
    assert solution.success
    problem.powers = None
    later = LaterReleased(problem, step, x, 1e-12)(x)
    begin = start or 0.0
    least = abs(begin)
    beyond = np.maximum(begin + x * unit, least)
    first = unit * (special.betainc(a + 1.0, b, np.minimum(beyond, 1.0)) - special.betainc(a + 1.0, b, least))
    exact = (begin + x * unit - first / law.sf(least)) / unit - later
    assert np.abs(solution.force / unit - exact).max() <= solution.force_error


@pytest.mark.parametrize("law", [stats.beta(0.5, 0.5), stats.beta(2.0, 0.7), stats.powerlaw(0.5)])
def test_a_start_with_a_width(law: object) -> None:
    """Against the start's own first breaks, in tables, and a lattice that knows no powers: a start smooths them."""
    unit = origins.Contacts(law).mean_threshold
    contacts, end = origins.Contacts(law, origins.gaussian_start(0.1 * unit, 0.025 * unit)), 3.0
    problem = Problem(contacts, end, 1e-9)
    assert problem.powers is None
    x = np.sort(np.concatenate([np.linspace(0.0, end, 44), np.linspace(0.0, 0.2, 20), 1.905 + 0.01 * np.arange(20.0)]))
    exact = problem.known(x) - LaterReleased(problem, end / 2**15, x, 1e-12)(x)
    solution = master.solve(contacts, x * unit, 1e-8)
    assert isinstance(solution, SpreadSolution) and solution.success
    assert np.abs(solution.force / unit - exact).max() <= solution.force_error + 1e-10


def test_a_start_with_a_width_is_many_starts() -> None:
    """A start from one stretch knows its first breaks otherwise; a uniform start is their mean. Density too."""
    law = stats.beta(0.3, 0.3)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    x = np.array([0.4, 1.3, 2.2])
    force = np.zeros(x.size)
    for node, weight in zip(nodes, weights, strict=True):
        single = master.solve(origins.Contacts(law, 0.1 + 0.02 * float(node)), x, 1e-9)
        force += 0.5 * weight * single.force
    solution = master.solve(origins.Contacts(law, stats.uniform(0.08, 0.04)), x, 1e-8)
    assert isinstance(solution, SpreadSolution) and solution.success
    assert np.abs(solution.force - force).max() <= 0.5 * (solution.force_error + 1e-9)
    middles = (np.arange(20_000) + 0.5) / 20_000
    assert abs(solution.distribution(1.3).density(middles).mean() - 1.0) < 1e-3


LAWS = [
    stats.arcsine(),
    stats.beta(2.0, 0.7),
    stats.beta(0.3, 0.3),
    stats.beta(0.7, 0.4),
    stats.beta(2.0, 1.3),
    stats.beta(1.5, 1.5),
    stats.beta(0.5, 0.7, 0.3),
    stats.powerlaw(0.5),
    stats.powerlaw(0.5, 0.2),
]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("spread", [False, True])
def test_the_tolerance_is_met_on_few_nodes(law: object, spread: bool) -> None:
    unit = origins.Contacts(law).mean_threshold
    contacts = origins.Contacts(law, origins.gaussian_start(0.1 * unit, 0.025 * unit) if spread else None)
    solution = master.solve(contacts, np.linspace(0.0, 5.0, 301) * unit, 1e-8)
    assert solution.success and solution.force_error <= 1e-8 and solution.nodes < 40_000


def test_orders_add_up() -> None:
    """Of each place of J_1, from the orders of P_c at 0 and at its end."""
    contacts = origins.Contacts(stats.beta(2.0, 0.7))
    problem = Problem(contacts, 5.0, 1e-8)
    found = find_powers(contacts, problem.law, 5.0, 1e-10)
    assert found is not None
    np.testing.assert_allclose(found.places, np.arange(1.0, 5.0) * 2.7 / 2.0, rtol=1e-12)
    # one end and one onset; two, three and four ends
    assert [part.germs[0].order - 1.0 for part in found.released] == pytest.approx([2.7, 1.4, 2.1, 2.8], abs=1e-8)
    for law in (origins.gaussian(1.0, 0.1), stats.gamma(0.3), origins.rectangular(0.5, 1.5)):
        contacts = origins.Contacts(law)
        assert Problem(contacts, 5.0, 1e-8).powers is None
