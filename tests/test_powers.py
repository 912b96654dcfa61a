"""Laws that end, begin or diverge as a power above 0: against closed forms, fine lattices and what they must reach."""

import mpmath
import numpy as np
import pytest
from scipy import special, stats

import master
import origins
from master.powers import find_powers
from master.problem import Problem
from master.renewal import LaterReleased


def arcsine_force(x: float) -> float:
    """F(X) for thresholds of density 1/(pi sqrt((x - 1)(2 - x))), relaxed start, X up to 3: no contact breaks thrice.

    The sum s of two has the density 2 K(m)/pi^2, m = 1 - (s - 3)^2; each of them releases s/2 on average.
    """
    with mpmath.workdps(20):
        angle = mpmath.acos(max(min(3 - 2 * mpmath.mpf(x), 1), -1))
        first = (3 * angle - mpmath.sin(angle)) / (2 * mpmath.pi)
        marks = [2, *[s for s in (2.5, 2.9) if s < x], x]

        def again(s: mpmath.mpf) -> mpmath.mpf:
            return s * mpmath.ellipk(1 - (s - 3) ** 2) / mpmath.pi**2

        return float(x - first - (mpmath.quad(again, marks) if x > 2 else 0))


def test_two_generations_in_closed_form() -> None:
    """Next to the places where F begins to bend and to fall, and between."""
    beside = 10.0 ** -np.arange(1.0, 13.0)
    x = np.unique(np.concatenate([[1.5, 2.0, 2.5], 1.0 + beside, 2.0 - beside, 2.0 + beside, 3.0 - beside]))
    exact = np.array([arcsine_force(value) for value in x])
    # the end of the path lies beyond, where contacts have broken thrice
    solution = master.solve(origins.Contacts(stats.arcsine(1.0)), np.append(x, 6.0), 1e-8)
    assert solution.success
    assert np.abs(solution.force[:-1] - exact).max() <= solution.force_error * 1.5 <= 1.5e-8


@pytest.mark.parametrize(
    ("powers", "start"), [((0.5, 0.5), None), ((2.0, 0.7), None), ((0.7, 0.4), 0.1), ((1.5, 1.3), -0.1)]
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


@pytest.mark.parametrize(
    "law",
    [
        stats.arcsine(),
        stats.beta(2.0, 0.7),
        stats.beta(0.7, 0.4),
        stats.beta(2.0, 1.3),
        stats.beta(1.5, 1.5),
        stats.beta(0.5, 0.7, 0.3),
        stats.powerlaw(0.5, 0.2),
    ],
)
def test_the_tolerance_is_met_on_few_nodes(law: object) -> None:
    contacts = origins.Contacts(law)
    solution = master.solve(contacts, np.linspace(0.0, 5.0, 301) * contacts.mean_threshold, 1e-8)
    assert solution.success and solution.force_error <= 1e-8 and solution.nodes < 100_000


def test_orders_add_up() -> None:
    """Of each place of J_1, from the orders of P_c at 0 and at its end."""
    contacts = origins.Contacts(stats.beta(2.0, 0.7))
    problem = Problem(contacts, 5.0, 1e-8)
    found = find_powers(contacts, problem.law, 5.0)
    assert found is not None
    np.testing.assert_allclose(found.places, np.arange(1.0, 5.0) * 2.7 / 2.0, rtol=1e-12)
    # one end and one onset; two, three and four ends
    assert [orders[0] for orders in found.orders] == pytest.approx([2.7, 1.4, 2.1, 2.8], abs=1e-8)
    for law in (origins.gaussian(1.0, 0.1), stats.gamma(0.3), origins.rectangular(0.5, 1.5)):
        contacts = origins.Contacts(law)
        assert Problem(contacts, 5.0, 1e-8).powers is None
