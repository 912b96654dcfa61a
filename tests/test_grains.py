"""Grains of Lifshitz and Slyozov: sizes, thresholds, growth, sliding contacts, orientations."""

from collections.abc import Callable
from decimal import Decimal
from itertools import pairwise

import numpy as np
import pytest
from references import mp
from scipy import stats

import eq_model
import master
import origins
from origins import InputError, grains
from origins.grain_contact import SlidingGrains
from origins.lifshitz_slyozov import LifshitzSlyozov, hazard_beyond, invert_beyond
from origins.quadrature import gauss, panel_edges

TAIL = 10.0 ** -np.array([0.01, 0.3, 1, 3, 8, 12, 14, 30, 100, 200, 270])
LOW = 10.0 ** -np.array([0.05, 0.5, 1, 3, 8, 15, 30])
BARELY = 2.0 / 3.0 * (1.0 + 1e-6)
RHOS = [BARELY, 0.67, 0.7, 1.0, 2.0, 10.0, 1e3]


def sizes(u: mp.mpf) -> mp.mpf:
    """P_LS as the paper and Lifshitz and Pitaevskii print it."""
    front = 81 * mp.e / 2 ** (mp.mpf(5) / 3) * u * u
    return front * mp.exp(-1 / (1 - 2 * u / 3)) / ((u + 3) ** (mp.mpf(7) / 3) * (mp.mpf(3) / 2 - u) ** (mp.mpf(11) / 3))


def psi(y: mp.mpf) -> mp.mpf:
    return mp.mpf(4) / 3 * mp.log1p(y / 2) + mp.mpf(5) / 3 * mp.log1p(-y) + y / (1 - y)


def gauss_rule(n: int) -> list[tuple[mp.mpf, mp.mpf]]:
    """Nodes and weights on (0, 1) in 40 digits, Newton's from numpy's."""
    with mp.workdps(40):
        out = []
        for start in np.polynomial.legendre.leggauss(n)[0]:
            x = mp.mpf(float(start))
            for _ in range(2):
                slope = n * (x * mp.legendre(n, x) - mp.legendre(n - 1, x)) / (x * x - 1)
                x -= mp.legendre(n, x) / slope
            slope = n * (x * mp.legendre(n, x) - mp.legendre(n - 1, x)) / (x * x - 1)
            out.append(((1 + x) / 2, 1 / ((1 - x * x) * slope * slope)))
        return out


RULE = gauss_rule(16)


def integral(f: Callable[[mp.mpf], mp.mpf], marks: list[mp.mpf]) -> mp.mpf:
    """Gauss-Legendre between marks close enough together, each piece to its own relative accuracy."""
    return mp.fsum((b - a) * mp.fsum(w * f(a + t * (b - a)) for t, w in RULE) for a, b in pairwise(marks))


def exact_hazard(x: mp.mpf, rho: float, B: float) -> mp.mpf:
    largest = mp.mpf(3) / 2 * mp.mpf(rho)
    return psi(mp.sqrt(1 + mp.mpf(B) * x * x) / largest) - psi(1 / largest)


def relative(found: np.ndarray, exact: list[mp.mpf]) -> float:
    return max(abs(float(mp.mpf(float(a)) / b - 1)) for a, b in zip(np.ravel(found), exact, strict=True))


# -- sizes ------------------------------------------------------------------------------------------------


def test_sizes_are_the_printed_density() -> None:
    law = LifshitzSlyozov()
    u = np.array([1e-8, 1e-3, 0.3, 0.7, 1.0, 1.3, 1.45, 1.49, 1.497])
    with mp.workdps(40):
        assert relative(law.pdf(u), [sizes(mp.mpf(float(v))) for v in u]) < 1e-13
        # the survival in closed form against the integral of the density, down to the essential singularity
        for q in TAIL:
            marks = [mp.mpf(float(law.isf(q * 10.0**-k))) for k in range(20)]
            assert relative(law.sf(float(marks[0])) - law.sf(float(marks[-1])), [integral(sizes, marks)]) < 1e-12
        for end in law.ppf(LOW):
            assert relative(law.cdf(end), [integral(sizes, [end * mp.mpf(k) / 4 for k in range(5)])]) < 1e-13
        second = mp.quad(lambda u: u * u * sizes(u), [0, 1.1, 1.3, 1.5])
    assert law.support() == (0.0, 1.5) and law.pdf(1.5) == 0.0 == law.pdf(0.0) and law.logsf(1.4999) < -1e3
    assert law.mean() == 1.0 and super(LifshitzSlyozov, law)._moment(1) == pytest.approx(1.0, abs=1e-14)
    assert law.moment(2) == pytest.approx(float(second), rel=1e-13)
    # coalescence keeps the shape: <u^n> (1 - n/3) = (9n/4) (<u^(n-3)> - <u^(n-2)>)
    assert law.moment(4) == pytest.approx(27.0 * (law.moment(2) - 1.0), rel=1e-12)
    assert law.moment(5) == pytest.approx(135.0 / 8.0 * (law.moment(3) - law.moment(2)), rel=1e-12)


def test_hazard_and_its_inverse_at_random() -> None:
    generator = np.random.default_rng(7)
    e0 = 10.0 ** generator.uniform(-12.0, 0.0, 3000)
    y0 = 1.0 - e0
    hazard = 10.0 ** generator.uniform(-30.0, 3.0, 3000)
    q = invert_beyond(hazard, y0, e0)
    np.testing.assert_allclose(hazard_beyond(q, y0, e0), hazard, rtol=1e-14)
    with mp.workdps(60):
        for far, start, wanted in zip(q[:200], e0, hazard, strict=False):
            rest = 1 / (1 / mp.mpf(float(start)) + mp.mpf(float(far)))
            assert float(psi(1 - rest) - psi(1 - mp.mpf(float(start)))) == pytest.approx(wanted, rel=1e-13)


# -- thresholds: the exact Jacobian also runs through test_families ----------------------------------------


class Printed:
    """The printed law in mpmath: its density, and sums over Gauss nodes between marks that follow its fall."""

    def __init__(self, law: origins.Thresholds, rho: float, B: float) -> None:
        self.rho, self.B = mp.mpf(rho), mp.mpf(B)
        deep = law.isf(10.0 ** -np.arange(0.5, 296.0, 2.0))
        near = law.ppf(10.0 ** -np.array([0.5, 1.0, 4.0, 10.0]))
        bends = np.array([0.5, 1.0, 2.0, 4.0, 8.0]) / np.sqrt(B)
        self.marks = [mp.mpf(float(x)) for x in np.unique([0.0, *near, *bends[bends < deep[0]], *deep])]
        self.nodes = [[(a + t * (b - a), w * (b - a)) for t, w in RULE] for a, b in pairwise(self.marks)]
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
        return mp.fsum(x**n * part for a, b in pairs for (x, _), part in zip(a, b, strict=True)) / self.whole


@pytest.mark.parametrize("rho, B", [(BARELY, 1.0), (0.7, 3e17), (2.0, 1.7), (1e3, 1.0)])
def test_printed_form(rho: float, B: float) -> None:
    law = grains(rho, B=B, jacobian="paper")
    with mp.workdps(25):
        exact = Printed(law, rho, B)
        upper, lower = law.isf(TAIL), law.ppf(LOW)
        assert relative(law.sf(upper), [exact.above(x) for x in upper]) < 1e-12
        assert relative(law.cdf(lower), [exact.below(x) for x in lower]) < 1e-12
        assert relative(law.logsf(lower), [mp.log1p(-exact.below(x)) for x in lower]) < 1e-12
        assert relative(law.pdf(upper), [exact.height(mp.mpf(float(x))) / exact.whole for x in upper]) < 1e-11
        for n in (1, 2, 3, 4):
            assert law.moment(n) == pytest.approx(float(exact.moment(n)), rel=1e-12)
        # isf cannot tell more than the stretch beside the end of the support
        grain = 4.0 * np.finfo(float).eps * upper * law.pdf(upper) / TAIL
    assert (np.abs(law.sf(upper) / TAIL - 1.0) <= 1e-12 + grain).all()
    np.testing.assert_allclose(law.cdf(lower), LOW, rtol=1e-12)
    edges = panel_edges(law)
    nodes, weights = gauss(edges[:-1], edges[1:])
    assert (weights * law.pdf(nodes)).sum() == pytest.approx(1.0, abs=1e-12)
    assert law.onset_power == 0.0 and law.pdf(0.0) == pytest.approx(float(1 / exact.whole), rel=1e-12)
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
    np.testing.assert_allclose(exact.isf(q), width * np.sqrt(-2.0 * np.log(q)), rtol=500.0 * true + 1e-14)
    half = stats.norm(0.0, width)
    np.testing.assert_allclose(printed.isf(q), half.isf(0.5 * q), rtol=500.0 * true + 1e-9 * (q > 0.999).any())
    assert exact.support()[1] == pytest.approx(np.sqrt(2.0 * true) / 2.0, rel=1e-5)


def test_time_and_size_are_one_thing() -> None:
    law, same = grains(alpha=0.5, time=64.0, B=1.3), grains(2.0, B=1.3)
    x = np.linspace(0.1, 1.8, 9)
    np.testing.assert_allclose(law.sf(x), same.sf(x), rtol=1e-14)
    assert law.support() == same.support() == pytest.approx((0.0, np.sqrt(8.0 / 1.3)), rel=1e-15)


@pytest.mark.parametrize(
    "arguments, says",
    [
        ({"rho": 2.0 / 3.0}, "rho = 0.6666666666666666: no grain pins yet"),
        ({"rho": 0.1}, "rho = 0.1: no grain pins yet"),
        ({"rho": -1.0}, "rho = -1.0: must be above zero"),
        ({"rho": 1e60}, "rho = 1e+60: must be at most 1e+50"),
        ({"rho": np.nan}, "rho = nan: must be finite"),
        ({"rho": 1.0, "time": 1.0}, "rho = 1.0: is alpha time^(1/3): give rho, or alpha and time"),
        ({}, "rho = None: is missing; give rho, such as 2.0, or alpha and time"),
        ({"alpha": 1.0}, "rho = None: is missing; give rho"),
        ({"alpha": 1.0, "time": 0.2}, "time = 0.2: no grain pins yet: the first does at (2/(3 alpha))³ = 0.2962962962"),
        ({"alpha": 1.0, "time": 1e200}, "time = 1e+200: must keep rho"),
        ({"alpha": 0.0, "time": 1.0}, "alpha = 0.0: must be above zero"),
        ({"rho": 1.0, "B": 0.0}, "B = 0.0: must be above zero"),
        ({"rho": 1.0, "jacobian": "printed"}, 'jacobian = \'printed\': must be "exact" or "paper"'),
    ],
)
def test_refusals(arguments: dict, says: str) -> None:
    with pytest.raises(InputError) as caught:
        grains(**{"B": 1.0, **arguments})
    assert str(caught.value).startswith(says) and "\n" not in str(caught.value)


def distance(law: origins.Thresholds, draws: np.ndarray) -> float:
    draws = np.sort(draws)
    cdf = np.concatenate([law.cdf(part) for part in np.array_split(draws, draws.size // 20_000)])
    steps = np.arange(draws.size + 1) / draws.size
    return max((cdf - steps[:-1]).max(), (steps[1:] - cdf).max()) * np.sqrt(draws.size)


@pytest.mark.parametrize("jacobian, many", [("exact", 10_000_000), ("paper", 1_000_000)])
def test_samples(jacobian: str, many: int) -> None:
    law = grains(1.0, B=1.0, jacobian=jacobian)
    draws = law.rvs(many, random_state=12)
    tail = 100.0 / many
    for beyond in ((draws > law.isf(tail)).sum(), (draws < law.ppf(tail)).sum()):
        assert abs(beyond - 100) < 40
    assert distance(law, draws) < 1.95  # the 0.1 % level


# -- what the solvers make of them -------------------------------------------------------------------------


@pytest.mark.parametrize("jacobian", ["exact", "paper"])
@pytest.mark.parametrize("rho", RHOS)
def test_solvers(rho: float, jacobian: str) -> None:
    contacts = origins.Contacts(grains(rho, B=1.0, jacobian=jacobian))
    mean = contacts.mean_threshold
    path = np.linspace(0.0, 5.0 * mean, 501)
    solved = master.solve(contacts, path, tolerance=1e-8)
    finer = master.solve(contacts, path, tolerance=1e-12)
    assert solved.success and solved.force_error <= 1e-8 and finer.success
    assert np.abs(solved.force - finer.force).max() <= solved.force_error * mean
    # F'(0) = 1 - x P_c at once, and the steady state in closed moments
    first = path[1] * (1.0 - contacts.thresholds.cdf(path[1]))
    assert solved.force[1] == pytest.approx(first, rel=0.02)
    steady = master.steady_state(contacts)
    expected = contacts.thresholds.moment(2) / (2.0 * mean)
    assert steady.force == pytest.approx(expected, rel=1e-10)
    done = eq_model.simulate(contacts, path, n_contacts=5000, n_replicas=2, seed=1)
    allowed = 5.0 * done.force_standard_error + 1e-8 * mean
    assert (np.abs(done.force - solved.force) <= allowed).all()


def test_propensity_of_the_printed_form() -> None:
    """m = 0, yet prone: the onset power alone does not decide. And the first grains are Rayleigh's law."""
    weak, strong = (
        master.propensity(origins.Contacts(grains(rho, B=1.0, jacobian="paper"))).critical_spring for rho in (1.0, 2.0)
    )
    assert weak == pytest.approx(0.28784, abs=1e-5) and strong == pytest.approx(1.03578, abs=1e-5)
    first = master.propensity(origins.Contacts(grains(BARELY, B=1.0))).critical_spring
    rayleigh = master.propensity(origins.Contacts(origins.gw_plastic(1.0))).critical_spring
    assert first == pytest.approx(rayleigh, abs=1e-5)


# -- growth ------------------------------------------------------------------------------------------------


def test_growth_in_time() -> None:
    growth = origins.GrainGrowth(alpha=0.8, B=1.7)
    first = growth.first_pinning_time
    assert growth.rho(first) == pytest.approx(2.0 / 3.0, rel=1e-15)
    times = first * np.array([0.1, 1.0, 1.01, 1.5, 27.0 / 8.0, 20.0, 1e6])
    np.testing.assert_allclose(growth.rho(times), 0.8 * times ** (1.0 / 3.0), rtol=1e-15)
    np.testing.assert_allclose(growth.number(times), first / times, rtol=1e-15)
    fraction = growth.pinned_fraction(times)
    assert fraction[:2].tolist() == [0.0, 0.0] and 0.0 < fraction[2] < 1e-100
    np.testing.assert_allclose(fraction[3:], LifshitzSlyozov().sf(1.0 / growth.rho(times[3:])), rtol=1e-12)
    np.testing.assert_allclose(growth.pinning_number(times), fraction * first / times, rtol=1e-15)
    # grains of the mean radius neither grow nor shrink: most pin when those are as thick as the film, at rho = 1
    around = 27.0 / 8.0 * first * (1.0 + np.array([-2e-3, -1e-3, 0.0, 1e-3, 2e-3]))
    numbers = growth.pinning_number(around)
    assert numbers.argmax() == 2 and numbers[1] == pytest.approx(numbers[3], rel=1e-8)
    assert growth.thresholds(20.0 * first).sf(0.9) == pytest.approx(
        grains(0.8 * (20.0 * first) ** (1 / 3), B=1.7).sf(0.9), rel=1e-13
    )
    assert growth.thresholds(20.0 * first, "paper").onset_power == 0.0
    with pytest.raises(InputError, match=r"^time = .*: no grain pins yet"):
        growth.thresholds(0.9 * first)
    with pytest.raises(InputError, match=r"^time = 0.0: must be finite and above zero"):
        growth.rho([1.0, 0.0])
    with pytest.raises(InputError, match=r"^alpha = -1.0: must be above zero"):
        origins.GrainGrowth(alpha=-1.0, B=1.0)


def test_growth_of_a_film() -> None:
    thin = origins.film_growth(2e-9, coarsening_rate=1e-27, shear_strength=1e8, force_coefficient=3e12)
    thick = origins.film_growth(6e-9, coarsening_rate=1e-27, shear_strength=1e8, force_coefficient=3e12)
    assert thin.first_pinning_time == pytest.approx((2e-9) ** 3 / 27e-27, rel=1e-14)
    assert thick.first_pinning_time == pytest.approx(27.0 * thin.first_pinning_time, rel=1e-14)
    # a grain of radius r breaks at tau pi (r² - d²/4) = c x²
    time = 5.0 * thin.first_pinning_time
    largest = 1.5 * (1e-27 * time) ** (1 / 3)
    force = 1e8 * np.pi * (largest**2 - 1e-18)
    assert thin.thresholds(time).support()[1] == pytest.approx(np.sqrt(force / 3e12), rel=1e-13)
    # k = G A^(1/2) and f_s = tau A: x = tau A^(1/2)/G
    by_modulus = origins.film_growth(2e-9, 1e-27, 1e8, shear_modulus=4e10).thresholds(time)
    assert by_modulus.support()[1] == pytest.approx(1e8 * np.sqrt(force / 1e8) / 4e10, rel=1e-13)
    with pytest.raises(InputError, match="give either force_coefficient or shear_modulus"):
        origins.film_growth(2e-9, 1e-27, 1e8)
    with pytest.raises(InputError, match=r"^film_thickness = -1.0: must be above zero"):
        origins.film_growth(-1.0, 1e-27, 1e8, 1.0)


# -- contacts whose threshold grows while they slide ---------------------------------------------------------

SLIDING = [(1.0, 0.0), (0.01, 0.0), (3.0, 0.0), (0.3, 0.7), (5.0, 1e-3), (1e-6, 0.0)]  # velocity, rest


def meeting_hazard(x: mp.mpf, growth: origins.GrainGrowth, velocity: float, rest: float) -> mp.mpf:
    """Straight from the definition, -log of the survival of P_c at the age of stretch x."""
    since = (mp.mpf(rest) + x / mp.mpf(velocity)) / mp.mpf(growth.first_pinning_time)
    largest = (1 + since) ** (mp.mpf(1) / 3)
    return psi(mp.sqrt(1 + mp.mpf(growth.B) * x * x) / largest) - psi(1 / largest)


@pytest.mark.parametrize("velocity, rest", SLIDING)
def test_survival_of_sliding_contacts(velocity: float, rest: float) -> None:
    growth = origins.GrainGrowth(alpha=1.0, B=1.0)
    contact = origins.GrainContact(growth)
    law = contact.breaking(velocity, rest)
    x = np.unique(law.isf(TAIL))
    x = np.concatenate([x[0] * np.array([1e-70, 1e-12, 1e-5]), x])
    with mp.workdps(320):
        exact = [meeting_hazard(mp.mpf(float(v)), growth, velocity, rest) for v in x]
        slid = mp.mpf(velocity) * mp.mpf(growth.first_pinning_time)
        lost = mp.mpf(9) / 2 * slid * slid if rest == 0.0 else mp.mpf(0)
        assert relative(law.sf(x), [mp.exp(lost - h) for h in exact]) < 1e-11
        assert relative(law.cdf(x[:5]), [-mp.expm1(lost - h) for h in exact[:5]]) < 1e-11


        def held(z: mp.mpf) -> mp.mpf:
            return mp.exp(lost - meeting_hazard(z, growth, velocity, rest))

        slopes = [-mp.diff(held, mp.mpf(float(v)), h=v * mp.mpf(10) ** -40) for v in x]
        assert relative(law.pdf(x), slopes) < 1e-11
    # from rest at tau_m on a contact whose threshold starts to grow slower than it slides never holds
    held_at_all = np.exp(-4.5 * (velocity * growth.first_pinning_time) ** 2) if rest == 0.0 else 1.0
    assert law.held_fraction == pytest.approx(held_at_all, rel=1e-14) == contact.survival(0.0, velocity, rest)
    np.testing.assert_allclose(contact.survival(x, velocity, rest), held_at_all * law.sf(x), rtol=1e-12)
    assert contact.survival(-1.0, velocity, rest) == 1.0
    edges = panel_edges(law)
    nodes, weights = gauss(edges[:-1], edges[1:])
    assert (weights * law.pdf(nodes)).sum() == pytest.approx(1.0, abs=1e-12)
    # the hazard at the meeting never falls, so that each quantile meets its threshold once
    grid = np.linspace(0.0, law.support()[1], 20_001)[1:-1]
    hazard = -law.logsf(grid)
    assert (np.diff(hazard) >= -1e-13 * (law.lost_hazard + hazard[1:])).all()


@pytest.mark.parametrize("velocity, rest", SLIDING[:5])
def test_first_meeting_by_brute_force(velocity: float, rest: float) -> None:
    """Walk along the stretch and take the first step at which it reaches the threshold of its age."""
    growth = origins.GrainGrowth(alpha=1.0, B=2.0)
    contact = origins.GrainContact(growth)
    u = np.array([0.0, 1e-6, 0.05, 0.2, 0.5, 0.8, 0.99, 1.0 - 1e-9, 1.0])
    found = contact.first_meeting(u, velocity, rest)
    end = contact.breaking(velocity, rest).support()[1]
    step = end / 2000
    x = step * np.arange(1, 2001)
    ages = growth.first_pinning_time + rest + x / velocity
    for rank, meets in zip(u, found, strict=True):
        reached = x >= contact.quantile(rank, ages) * (1.0 - 1e-12)
        first = x[np.argmax(reached)]
        assert reached.any() and first - step * (1 + 1e-9) <= meets <= first * (1 + 1e-9)
        if meets > 0.0:
            age = growth.first_pinning_time + rest + meets / velocity
            assert contact.quantile(rank, age) == pytest.approx(meets, rel=1e-9)
    survived = 1.0 - contact.survival(found[1:-1], velocity, rest)
    held = found[1:-1] > 0.0
    np.testing.assert_allclose(survived[held], u[1:-1][held], rtol=1e-10)
    assert (survived[~held] >= u[1:-1][~held]).all()


def test_quantiles_of_growing_contacts() -> None:
    growth = origins.GrainGrowth(alpha=1.0, B=1.7)
    contact = origins.GrainContact(growth)
    first = growth.first_pinning_time
    u = np.array([0.0, 1e-9, 0.3, 0.7, 1.0 - 1e-9, 1.0])
    for age in first * np.array([1.01, 2.0, 50.0, 1e9]):
        law = growth.thresholds(age)
        np.testing.assert_allclose(contact.quantile(u, age), law.ppf(u), rtol=1e-12)
    ages = np.linspace(first, 100.0 * first, 400)
    grown = contact.quantile(u[:, None], ages)
    assert grown.shape == (6, 400) and (grown[:, 0] == 0.0).all() and (np.diff(grown[1:], axis=1) > 0.0).all()
    assert isinstance(contact.quantile(0.5, 3.0), float)
    # at rest for long, then slid fast: the thresholds of that age
    rested = contact.breaking(velocity=1e18, rest=7.0 * first)
    x = np.linspace(0.05, 1.5, 9)
    np.testing.assert_allclose(rested.sf(x), growth.thresholds(8.0 * first).sf(x), rtol=1e-9)


def test_sliding_contacts_in_the_solvers() -> None:
    """The law of breaking is a law of thresholds like any other; steady sliding in closed moments."""
    contact = origins.GrainContact(origins.GrainGrowth(alpha=1.0, B=1.0))
    for velocity in (0.5, 10.0):
        law = contact.breaking(velocity)
        assert isinstance(law, SlidingGrains) and law.onset_power == 0.0
        assert distance(law, law.rvs(100_000, random_state=3)) < 1.95
        contacts = origins.Contacts(law)
        path = np.linspace(0.0, 5.0 * law.mean(), 101)
        solved = master.solve(contacts, path, tolerance=1e-8)
        assert solved.success
        done = eq_model.simulate(contacts, path, n_contacts=5000, n_replicas=2, seed=1)
        allowed = 5.0 * done.force_standard_error + 1e-8 * law.mean()
        assert (np.abs(done.force - solved.force) <= allowed).all()
    rested = contact.breaking(0.5, rest=0.1)
    assert rested.onset_power == 1.0 and rested.pdf(0.0) == 0.0 < contact.breaking(0.5).pdf(0.0)
    # far too fast for any to hold
    assert contact.survival([0.0, 1e-3], velocity=1e6).tolist() == [0.0, 0.0]
    assert contact.first_meeting([0.5, 1.0 - 1e-15], velocity=1e6).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    "call, says",
    [
        (lambda c: c.survival(1.0, velocity=0.0), "velocity = 0.0: must be above zero"),
        (lambda c: c.breaking(velocity=100.0), "velocity = 100.0: none holds but a fraction exp(-3951)"),
        (lambda c: c.survival(1.0, velocity=1.0, rest=-1.0), "rest = -1.0: must be zero or above"),
        (lambda c: c.first_meeting(1.5, velocity=1.0), "u = 1.5: must be a quantile between 0 and 1"),
        (lambda c: c.quantile([0.5, np.nan], 1.0), "u = nan: must be a quantile"),
        (lambda c: c.quantile(0.5, [1.0, 0.1]), "age = 0.1: no grain pins before the age (2/(3 alpha))³ = 0.296296296"),
        (lambda c: origins.GrainContact(1.0), "growth = 1.0: must be growth"),
    ],
)
def test_contact_refusals(call: Callable, says: str) -> None:
    with pytest.raises(InputError) as caught:
        call(origins.GrainContact(origins.GrainGrowth(1.0, 1.0)))
    assert str(caught.value).startswith(says)


# -- orientations ------------------------------------------------------------------------------------------


def test_two_orientations_are_a_mixture() -> None:
    """R = (delta(phi) + delta(phi - pi/4))/2: each with its own normalised P_c, that of its strength."""
    weak, strong = grains(1.5, B=1.0), grains(1.5, B=1.0 / 7.0)
    both = origins.mixture([weak, strong], [0.5, 0.5])
    x = np.linspace(0.0, 5.5, 100)
    np.testing.assert_allclose(both.pdf(x), 0.5 * weak.pdf(x) + 0.5 * np.sqrt(1 / 7.0) * weak.pdf(x * np.sqrt(1 / 7.0)))
    assert both.support()[1] == pytest.approx(np.sqrt(7.0) * weak.support()[1], rel=1e-15)


def test_all_orientations() -> None:
    """Against mpmath's integral over phi, to the accuracy asked."""
    rho = 1.5

    def strength(phi: float) -> float:
        return 1.0 + 6.0 * np.exp(-((phi / 0.3) ** 2))

    def often(phi: float) -> float:
        return 1.0 + np.cos(4.0 * phi)

    law = origins.continuous_mixture(
        lambda phi: grains(rho, B=1.0 / strength(phi)), 0.0, np.pi / 4.0, density=often, accuracy=1e-8
    )
    assert law.quadrature_error <= 1e-8 and law.weights.size <= 128
    assert law.weights.sum() == pytest.approx(1.0, abs=1e-14) and law.onset_power == 1.0
    with mp.workdps(20):
        whole = mp.quad(lambda phi: 1 + mp.cos(4 * phi), [0, mp.pi / 4])
        for x in (0.2, 1.0, 2.0, 3.0, 4.5):

            def held(phi: mp.mpf, x: float = x) -> mp.mpf:
                B = 1 / (1 + 6 * mp.exp(-((phi / mp.mpf("0.3")) ** 2)))
                alive = 1 + B * mp.mpf(x) ** 2 < (mp.mpf(3) / 2 * rho) ** 2
                return (1 + mp.cos(4 * phi)) * mp.exp(-exact_hazard(mp.mpf(x), rho, B)) if alive else mp.mpf(0)

            assert abs(law.sf(x) - float(integral(held, mp.linspace(0, mp.pi / 4, 33)) / whole)) < 2e-8
    solved = master.solve(origins.Contacts(law), np.linspace(0.0, 5.0 * law.mean(), 101), tolerance=1e-8)
    assert solved.success and solved.force_error <= 1e-8


def test_equal_orientations_of_a_closed_form() -> None:
    """Rayleigh laws of equal rates: S(x) = (e^(-a x²) - e^(-b x²))/((b - a) x²)."""
    law = origins.continuous_mixture(origins.gw_plastic, 1.0, 3.0)
    x = np.linspace(0.05, 4.0, 50)
    exact = (np.exp(-x * x) - np.exp(-3.0 * x * x)) / (2.0 * x * x)
    assert np.abs(law.sf(x) - exact).max() < 1e-10
    assert law.mean() == pytest.approx(np.sqrt(np.pi) / 2.0 * (np.sqrt(3.0) - 1.0), rel=1e-10)
    frozen = origins.continuous_mixture(lambda rate: stats.expon(scale=1.0 / rate), 1.0, 2.0)
    assert frozen.sf(1.0) == pytest.approx(np.exp(-1.0) - np.exp(-2.0), abs=1e-10)


@pytest.mark.parametrize(
    "arguments, says",
    [
        ({"upper": 0.0}, "upper = 0.0: must be above lower = 0"),
        ({"law": 3.0}, "law = 3.0: must be a function of phi"),
        ({"density": 3.0}, "density = 3.0: must be a function of phi"),
        ({"density": lambda phi: -1.0}, "density = -1.0: must not be below zero, as at phi = "),
        ({"density": lambda phi: np.nan}, "density = nan: must be finite"),
        ({"density": lambda phi: 0.0}, "density = <function"),
        ({"accuracy": 0.0}, "accuracy = 0.0: must be above zero"),
        ({"law": lambda phi: origins.identical(1.0 + phi)}, "accuracy = 1e-10: 512 laws reach"),
        ({"law": lambda phi: phi}, "thresholds = "),
    ],
)
def test_refused_mixtures(arguments: dict, says: str) -> None:
    with pytest.raises(InputError) as caught:
        origins.continuous_mixture(
            **{"law": lambda phi: grains(1.0 + phi, B=1.0), "lower": 0.0, "upper": 1.0, **arguments}
        )
    assert str(caught.value).startswith(says) and "\n" not in str(caught.value)
