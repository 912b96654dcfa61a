"""Grains of Lifshitz and Slyozov: sizes, thresholds by both Jacobians, and what the solvers make of them."""

from decimal import Decimal
from itertools import pairwise

import numpy as np
import pytest
from grain_references import BARELY, LOW, RULE, TAIL, integral, relative, sizes
from references import mp
from scipy import stats

import master
import origins
from origins import grains
from origins.grains.lifshitz_slyozov import LifshitzSlyozov
from origins.thresholds.quadrature import gauss, panel_edges


def test_sizes_are_the_printed_density() -> None:
    law = LifshitzSlyozov()
    u = np.array([1e-8, 1e-3, 0.3, 0.7, 1.0, 1.3, 1.45, 1.49, 1.497])
    with mp.workdps(40):
        assert relative(law.pdf(u), [sizes(mp.mpf(float(v))) for v in u]) < 1e-13
        # the survival in closed form against the integral of the density, down to the essential singularity
        for q in TAIL:
            marks = [mp.mpf(float(law.isf(q * 10.0**-k))) for k in range(20)]
            assert (
                relative(
                    law.sf(float(marks[0])) - law.sf(float(marks[-1])), [integral(sizes, marks)]
                )
                < 1e-12
            )
        for end in law.ppf(LOW):
            assert (
                relative(law.cdf(end), [integral(sizes, [end * mp.mpf(k) / 4 for k in range(5)])])
                < 1e-13
            )
        second = mp.quad(lambda u: u * u * sizes(u), [0, 1.1, 1.3, 1.5])
    assert (
        law.support() == (0.0, 1.5)
        and law.pdf(1.5) == 0.0 == law.pdf(0.0)
        and law.logsf(1.4999) < -1e3
    )
    assert law.mean() == 1.0 and super(LifshitzSlyozov, law)._moment(1) == pytest.approx(
        1.0, abs=1e-14
    )
    assert law.moment(2) == pytest.approx(float(second), rel=1e-13)
    # coalescence keeps the shape: <u^n> (1 - n/3) = (9n/4) (<u^(n-3)> - <u^(n-2)>)
    assert law.moment(4) == pytest.approx(27.0 * (law.moment(2) - 1.0), rel=1e-12)
    assert law.moment(5) == pytest.approx(135.0 / 8.0 * (law.moment(3) - law.moment(2)), rel=1e-12)


class Printed:
    """The printed law in mpmath: its density, and sums over Gauss nodes between marks that follow its fall."""

    def __init__(self, law: origins.Thresholds, rho: float, B: float) -> None:
        self.rho, self.B = mp.mpf(rho), mp.mpf(B)
        deep = law.isf(10.0 ** -np.arange(0.5, 296.0, 2.0))
        near = law.ppf(10.0 ** -np.array([0.5, 1.0, 4.0, 10.0]))
        bends = np.array([0.5, 1.0, 2.0, 4.0, 8.0]) / np.sqrt(B)
        self.marks = [
            mp.mpf(float(x)) for x in np.unique([0.0, *near, *bends[bends < deep[0]], *deep])
        ]
        self.nodes = [
            [(a + t * (b - a), w * (b - a)) for t, w in RULE] for a, b in pairwise(self.marks)
        ]
        self.parts = [[w * self.height(x) for x, w in cell] for cell in self.nodes]
        self.whole = mp.fsum(part for cell in self.parts for part in cell)

    def height(self, x: mp.mpf) -> mp.mpf:
        return sizes(mp.sqrt(1 + self.B * x * x) / self.rho) / sizes(1 / self.rho)

    def above(self, x: float) -> mp.mpf:
        place = next(i for i, mark in enumerate(self.marks) if mark > x)
        rest = integral(self.height, [mp.mpf(float(x)), self.marks[place]])
        return (rest + mp.fsum(part for cell in self.parts[place:] for part in cell)) / self.whole

    def below(self, x: float) -> mp.mpf:
        place = max(i for i, mark in enumerate(self.marks) if mark <= x)
        rest = integral(self.height, [self.marks[place], mp.mpf(float(x))])
        return (rest + mp.fsum(part for cell in self.parts[:place] for part in cell)) / self.whole

    def moment(self, n: int) -> mp.mpf:
        pairs = zip(self.nodes, self.parts, strict=True)
        return (
            mp.fsum(x**n * part for a, b in pairs for (x, _), part in zip(a, b, strict=True))
            / self.whole
        )


@pytest.mark.parametrize("rho, B", [(BARELY, 1.0), (2.0, 1.7), (1e3, 1.0)])
def test_printed_form(rho: float, B: float) -> None:
    law = grains(rho, B=B, jacobian="paper")
    with mp.workdps(25):
        exact = Printed(law, rho, B)
        upper, lower = law.isf(TAIL), law.ppf(LOW)
        assert relative(law.sf(upper), [exact.above(x) for x in upper]) < 1e-11
        assert relative(law.cdf(lower), [exact.below(x) for x in lower]) < 1e-11
        assert relative(law.logsf(lower), [mp.log1p(-exact.below(x)) for x in lower]) < 1e-11
        assert (
            relative(law.pdf(upper), [exact.height(mp.mpf(float(x))) / exact.whole for x in upper])
            < 1e-11
        )
        for n in (1, 2, 3, 4):
            assert law.moment(n) == pytest.approx(float(exact.moment(n)), rel=1e-12)
        # isf cannot tell more than the stretch beside the end of the support
        grain = 4.0 * np.finfo(float).eps * upper * law.pdf(upper) / TAIL
    assert (np.abs(law.sf(upper) / TAIL - 1.0) <= 1e-11 + grain).all()
    np.testing.assert_allclose(law.cdf(lower), LOW, rtol=1e-11)
    edges = panel_edges(law)
    nodes, weights = gauss(edges[:-1], edges[1:])
    assert (weights * law.pdf(nodes)).sum() == pytest.approx(1.0, abs=1e-12)
    assert law.onset_power == 0.0 and law.pdf(0.0) == pytest.approx(
        float(1 / exact.whole), rel=1e-12
    )
    assert law.pdf(law.support()[1]) == 0.0 and law.logsf(law.isf(1e-280) * (1 + 1e-3)) < -640.0


@pytest.mark.parametrize("rho", [1.0, 2.0])
def test_jacobians_differ_by_what_physics_says(rho: float) -> None:
    """Printed over exact is proportional to (1 + B x²)^(1/2)/x: dr/df ~ 1/r, not f^(-1/2)."""
    x = np.linspace(0.05, 0.5, 10)
    ratio = grains(rho, B=2.0, jacobian="paper").pdf(x) / grains(rho, B=2.0).pdf(x)
    shape = ratio * x / np.sqrt(1.0 + 2.0 * x * x)
    np.testing.assert_allclose(shape, shape[0], rtol=1e-12)


@pytest.mark.parametrize("excess", [1e-15, 1e-12, 1e-6])
def test_first_grains_to_pin(excess: float) -> None:
    """rho -> 2/3: the law of a stretch far below x_max, exp(-B x²/(2 e²)) with e the excess, and its half Gaussian."""
    rho = float(np.float64(2.0 / 3.0) * (1.0 + excess))
    true = float(Decimal(rho) * 3 / 2 - 1)  # the excess that this float has
    exact, printed = grains(rho, B=4.0), grains(rho, B=4.0, jacobian="paper")
    width = true / 2.0
    q = np.array([1e-100, 1e-12, 0.01, 0.3, 0.9, 1.0 - 1e-9])
    # corrections are of the order of the excess, times the hazard
    np.testing.assert_allclose(
        exact.isf(q), width * np.sqrt(-2.0 * np.log(q)), rtol=500.0 * true + 1e-14
    )
    half = stats.norm(0.0, width)
    np.testing.assert_allclose(
        printed.isf(q), half.isf(0.5 * q), rtol=500.0 * true + 1e-9 * (q > 0.999).any()
    )
    assert exact.support()[1] == pytest.approx(np.sqrt(2.0 * true) / 2.0, rel=1e-5)


def test_propensity_of_the_printed_form() -> None:
    """m = 0, yet prone: the onset power alone does not decide. The first grains are Rayleigh's law."""

    def spring(law: origins.Thresholds) -> float:
        return master.propensity(origins.Contacts(law)).critical_spring

    for rho, known in ((1.0, 0.29), (2.0, 1.04)):
        assert spring(grains(rho, B=1.0, jacobian="paper")) == pytest.approx(known, abs=0.005)
    rayleigh = spring(origins.gw_plastic(1.0))
    assert spring(grains(BARELY, B=1.0)) == pytest.approx(rayleigh, abs=1e-5)
