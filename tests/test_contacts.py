"""A contact: what it carries, its starts, rates in heat, ageing; against mpmath and closed forms."""

import dataclasses

import mpmath
import numpy as np
import pytest
from rate_laws import Tilted
from scipy import integrate, stats
from scipy.linalg import expm

import eq_model
import master
import origins
from eq_model.closest import closest
from master.paper.explicit import explicit
from origins import Ageing, Contacts, Delay, InputError, RateLaw, Thermal, gaussian_start
from origins.laws.diffusion import Diffusion
from origins.laws.thermal import RATE_LAWS

NARROW = origins.gaussian(1.0, 0.05)
GAUSSIAN = origins.gaussian(1.0, 0.2)
BOX = origins.rectangular(0.5, 1.0)
PATH = np.linspace(0.0, 1.0, 5)
LAWS = {
    "thermal": Thermal("soft", temperature=0.1),
    "ageing": Ageing(origins.gaussian(1.2, 0.1), rate=1e-3),
    "delay": Delay(time=0.2),
    "reforming": 0.1,
    "stiffness": "linked",
}
SOLVERS = {
    "master.solve": lambda contacts: master.solve(contacts, PATH),
    "master.steady_state": master.steady_state,
    "master.propensity": master.propensity,
    "master.paper.explicit": lambda contacts: explicit(contacts, PATH, step=0.01),
    "eq_model.simulate": lambda contacts: eq_model.simulate(contacts, PATH, n_contacts=10),
    "eq_model.closest": lambda contacts: closest(contacts, PATH, n_contacts=10),
}
TAKEN = {"master.paper.explicit": (), "eq_model.closest": ()}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", LAWS)
def test_no_law_is_silently_ignored(solver: str, name: str) -> None:
    solve, contacts = SOLVERS[solver], Contacts(GAUSSIAN, **{name: LAWS[name]})
    if name in TAKEN.get(solver, LAWS):
        number = "critical_spring" if solver == "master.propensity" else "force"
        plain, other = getattr(solve(Contacts(GAUSSIAN)), number), getattr(solve(contacts), number)
        assert np.any(plain != other)
        return
    shown = " = 'linked'" if name == "stiffness" else ""
    told = f"contacts.{name}{shown}: {solver} does not take it yet; leave "
    refused(lambda: solve(contacts), told)
    refused(lambda: solve(GAUSSIAN), "contacts = ")


def refused(call, begins: str) -> None:
    with pytest.raises(InputError) as refusal:
        call()
    assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value)


def test_weight_beyond_every_threshold_is_cut_and_said() -> None:
    """Up to 1e-6 is cut off; both sides count, since barriers and thresholds ask for |x|."""
    known = 2.0 * stats.norm.sf(5.0)
    assert Contacts(BOX, gaussian_start(0.0, 0.2)).cut_weight == pytest.approx(known, rel=1e-12)
    births = Contacts(BOX, reforming=origins.boltzmann_reforming(0.04)).reforming
    assert births.cut_weight == pytest.approx(known, rel=1e-12)
    for law, start in [(BOX, 0.999), (BOX, stats.uniform(-1.0, 2.0)), (NARROW, 2.5)]:
        assert Contacts(law, start=start).cut_weight == 0.0


def test_starts_are_those_of_scipy() -> None:
    x, q = np.linspace(-0.1, 0.1, 7), np.array([1e-12, 0.3, 0.9])
    newer = Contacts(GAUSSIAN, start=stats.Normal(mu=0.0, sigma=0.025)).start
    for start, twin in (
        (gaussian_start(0.01, 0.025), stats.norm(0.01, 0.025)),
        (Contacts(GAUSSIAN, start=stats.uniform(-0.05, 0.1)).start, stats.uniform(-0.05, 0.1)),
        (newer, stats.norm(0.0, 0.025)),
    ):
        assert not start.is_single and start.mean() == pytest.approx(twin.mean(), abs=1e-15)
        for name, given in {"pdf": x, "cdf": x, "sf": x, "ppf": q, "isf": q}.items():
            found, known = getattr(start, name)(given), getattr(twin, name)(given)
            np.testing.assert_allclose(found, known, rtol=1e-12, atol=1e-15)


def test_a_start_so_wide_that_numbers_overflow_is_refused() -> None:
    for given in ((0.0, 1e308), (1e308, 0.1), (-1e308, 1e308)):
        with pytest.raises(InputError, match=r"^(std|mean) = -?1e\+308: must be at most 1e\+150"):
            gaussian_start(*given)


def test_boltzmann_reforming_is_the_law_of_a_spring() -> None:
    """R ~ exp(-k x²/2k_BT): equipartition, <k> <x²> = k_BT."""
    law = origins.boltzmann_reforming(0.03)
    second = integrate.quad(lambda x: x * x * law.pdf(x), -2.0, 2.0, epsabs=1e-14)[0]
    assert second == pytest.approx(0.03, rel=1e-10)


@pytest.mark.parametrize("law", [-0.8, gaussian_start(0.1, 0.3)])
def test_drawn_thresholds_follow_the_conditional_law(law: object) -> None:
    """Through the conditional survival each pair becomes uniform."""
    births = Contacts(GAUSSIAN, reforming=law).reforming
    x, threshold = births.draw(200_000, np.random.default_rng(6))
    assert (threshold >= np.abs(x)).all()
    left = GAUSSIAN.sf(threshold) / GAUSSIAN.sf(np.abs(x))
    assert stats.kstest(left, "uniform").pvalue > 1e-4
    if not births.law.is_single:
        assert stats.kstest(x, stats.norm(0.1, 0.3).cdf).pvalue > 1e-4


# -- breaking in heat ------------------------------------------------------------------------------

mpmath.mp.dps = 50


def soft(x, threshold, energy):
    barrier, a = energy * (threshold**2 - x**2) / 2, mpmath.sqrt(energy / 2)
    grown = mpmath.sqrt(mpmath.pi) / (2 * a) * mpmath.erfi(a * x)
    return mpmath.exp(-barrier), grown * mpmath.exp(-((a * threshold) ** 2))


def stiff(x, threshold, energy):
    c, s = energy * threshold**2 / 2, 1 - x / threshold
    reached = mpmath.exp(-c * s ** mpmath.mpf(1.5))
    return mpmath.sqrt(s) * reached, 2 * threshold / (3 * c) * (reached - mpmath.exp(-c))


def eyring(x, threshold, width):
    rate, relaxed = mpmath.exp(-(1 - x / threshold) / width), mpmath.exp(-1 / width)
    return rate, width * threshold * (rate - relaxed)


# each law's h/ω as it is written, and its integral from 0 to x >= 0, with k_i/k_BT, or with the law's own parameter
EXACT = {"soft": soft, "stiff": stiff, "eyring": eyring}


def exact(thermal: Thermal, x, threshold, stiffness):
    if thermal.temperature is None:
        energy = mpmath.mpf(dict(thermal.own)["width"])
    else:
        energy = mpmath.mpf(stiffness) / thermal.temperature
    found = EXACT[thermal.law](abs(mpmath.mpf(x)), mpmath.mpf(threshold), energy)
    return [thermal.attempt_frequency * value for value in found]


def exact_rate(thermal: Thermal, x, threshold, stiffness=1.0):
    return exact(thermal, x, threshold, stiffness)[0]


def exact_cumulative(thermal: Thermal, x, threshold, start=0.0, stiffness=1.0):
    """|integral of h from start to x|."""
    end, begin = (np.sign(y) * exact(thermal, y, threshold, stiffness)[1] for y in (x, start))
    return abs(end - begin)


def cases(law: str):
    """Temperatures 1e-6 to 1e3, widths 1e-4 to 1, ω 1e-12 to 1e12; stretches from next to zero to the threshold itself,
    also behind x = 0; starts at 0, anywhere, and just below x."""
    random = np.random.default_rng(7 if law == "soft" else 8)
    for i in range(300):
        temperature, scale = 10.0 ** random.uniform(-6, 3), 10.0 ** random.uniform(-12, 12)
        if law == "eyring":  # widths of 1e-4 to 1
            width = 10.0 ** (-4.0 * abs(np.log10(temperature)) / 6.0)
            thermal = Thermal(law, attempt_frequency=scale, width=width)
        else:
            thermal = Thermal(law, temperature, scale)
        threshold = 10.0 ** random.uniform(-1.0, 0.7)
        near_end = 1.0 - 10.0 ** random.uniform(-15, -1)
        x = threshold * random.choice([1e-12, 1e-3, random.uniform(-1, 1), near_end, 1.0])
        near = x * (1.0 - 10.0 ** random.uniform(-12, -1))
        start = (0.0, threshold * random.uniform(-1, 1), near)[i % 3]
        yield thermal, float(x), float(threshold), float(start), 10.0 ** random.uniform(-1, 1)


@pytest.mark.parametrize("law", RATE_LAWS)
def test_rate_and_cumulative_rate(law: str) -> None:
    underflown = 0
    for thermal, x, threshold, start, stiffness in cases(law):
        way = (x, threshold, start, stiffness)
        for plain, logarithm, exact, arguments in (
            (thermal.rate, thermal.log_rate, exact_rate, (x, threshold, stiffness)),
            (thermal.cumulative, thermal.log_cumulative, exact_cumulative, way),
        ):
            known = exact(thermal, *arguments)
            if known == 0:  # a stiff contact at its threshold, or x = start
                assert plain(*arguments) == 0.0 and logarithm(*arguments) == -np.inf
                continue
            told = float(logarithm(*arguments))
            assert abs(told - mpmath.log(known)) <= 1e-13 * max(1.0, abs(told))
            underflown += known < 1e-308
            if known > 1e-300:
                assert abs(float(plain(*arguments)) / known - 1) < 1e-12, (thermal, arguments)
    assert underflown > 25


@pytest.mark.parametrize("law", RATE_LAWS)
def test_inverse(law: str) -> None:
    """Right in x, or in the amount that leads there: where the rate vanishes, or rises steeply, one must give."""
    reached = 0
    for thermal, x, threshold, start, stiffness in cases(law):
        start, x = sorted((start, x))
        amount = float(exact_cumulative(thermal, x, threshold, start, stiffness))
        if not amount > 1e-300:
            continue
        found = float(thermal.inverse(amount, threshold, start, stiffness))
        assert start <= found <= threshold
        back = exact_cumulative(thermal, found, threshold, start, stiffness)
        off = min(abs(found - x) / threshold, abs(back / amount - 1))
        assert off < 1e-12, (thermal, x, threshold, start)
        reached += 1
        # the mirror image: backward from -start to -x
        behind = thermal.cumulative(-x, threshold, -start, stiffness)
        assert behind == thermal.cumulative(x, threshold, start, stiffness)
    assert reached > 50


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_linked_stiffness_in_the_barrier(law: str) -> None:
    """T is k_BT/<k>; each contact's own is k_BT/k_i with k_i = <k> x_si/<x_s>, so the barrier grows as x_s³."""
    thermal, thresholds = Thermal(law, 0.24, 2.0), np.array([0.3, 1.0, 4.0])
    linked = Contacts(origins.gw_plastic(0.2), thermal=thermal, stiffness="linked")
    stiffness = linked.relative_stiffness(thresholds)
    np.testing.assert_allclose(stiffness, thresholds / linked.thresholds.mean(), rtol=1e-15)
    told = thermal.log_cumulative(0.6 * thresholds, thresholds, 0.1, stiffness)
    for value, share, threshold in zip(told, stiffness, thresholds, strict=True):
        own = Thermal(law, 0.24 / float(share), 2.0).log_cumulative(0.6 * threshold, threshold, 0.1)
        assert value == pytest.approx(float(own), rel=1e-13)
    relaxed = thermal.log_rate(0.0, thresholds, stiffness) - np.log(2.0)
    np.testing.assert_allclose(relaxed / relaxed[1], thresholds**3, rtol=1e-13)
    assert Contacts(origins.gw_plastic(0.2)).relative_stiffness(thresholds).tolist() == [1.0] * 3


# -- ageing ----------------------------------------------------------------------------------------

MEAN, STD, D = 1.0, 0.1, 5e-4


def mean_and_spread(x0, t):
    """Of the transition, in mpmath."""
    mean = MEAN + (x0 - MEAN) * mpmath.exp(-D / mpmath.mpf(STD) ** 2 * t)
    return mean, STD * mpmath.sqrt(-mpmath.expm1(-2 * D / mpmath.mpf(STD) ** 2 * t))


def test_transition_of_a_gaussian_target() -> None:
    normal = Ageing(origins.gaussian(MEAN, STD), rate=D).normal
    assert normal is not None and (normal.mean, normal.std) == (MEAN, STD)
    for time in (1e-9, 1e-3, 1.0, 20.0, 1e4):
        mean, spread = mean_and_spread(0.6, time)
        assert abs(float(normal.mean_after(0.6, time)) / mean - 1) < 1e-14
        assert abs(float(normal.std_after(time)) / spread - 1) < 1e-14
    assert float(normal.mean_after(0.6, 1e9)) == MEAN and float(normal.std_after(1e9)) == STD
    still = Ageing(origins.gaussian(MEAN, STD), rate=0.0).normal  # nothing moves
    assert still is not None and (still.mean_after(0.3, 5.0), still.std_after(5.0)) == (0.3, 0.0)


def towards_rayleigh(edges):
    """P_cf = x exp(-x²/2); the Laguerre polynomial L_1(x²/2) = 1 - x²/2 decays as exp(-2Dt)."""
    z, t = 0.5 * edges**2, 0.35
    target, mode = -np.diff(np.exp(-z)), np.diff(z * np.exp(-z))
    return target - 0.9 * mode, target - 0.9 * np.exp(-2.0 * t) * mode, t


def test_order_of_convergence_is_two() -> None:
    """By the exact propagator of hops between cells."""
    errors, every = [], np.array([8, 4, 2, 1])
    edges = 8.0 * np.linspace(0.0, 1.0, 801)
    for step in every:
        before, after, amount = towards_rayleigh(edges[::step])
        hops = Diffusion(origins.gw_plastic(0.5), edges[::step])
        generator = np.diag(hops.up, -1) + np.diag(hops.down, 1)
        found = expm(amount * (generator - np.diag(generator.sum(axis=0)))) @ before
        errors.append(np.abs(found - after).sum())
    order = np.polyfit(np.log(every), np.log(errors), 1)[0]
    assert abs(order - 2.0) < 0.2 and errors[-1] < 5e-4, (order, errors)


@dataclasses.dataclass(frozen=True)
class Steady(RateLaw):
    """h = ω w: a law with a parameter of its own and no temperature."""

    width: float
    attempt_frequency: float = 1.0
    name = "steady"

    @property
    def scale(self):
        return self.width * self.attempt_frequency

    def log_rate(self, x, threshold, stiffness):
        return np.log(self.scale) + 0.0 * np.asarray(x + threshold + stiffness)

    def log_passed(self, near, far, threshold, stiffness):
        with np.errstate(divide="ignore"):
            return np.log(self.scale * (np.asarray(far) - near))

    def reached(self, log_amount, near, threshold, stiffness):
        return np.minimum(near + np.exp(log_amount) / self.scale, threshold)


def test_a_named_law_with_a_parameter_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is kept by every road that makes the contacts anew, and a temperature is not its own."""
    monkeypatch.setitem(RATE_LAWS, "steady", Steady)
    thermal = Thermal("steady", width=0.5, attempt_frequency=2.0, closure="paper")
    exact = dataclasses.replace(thermal, closure="exact")
    assert exact.rates == Steady(0.5, 2.0) and exact != Thermal("steady", width=0.4)
    contacts = Contacts(origins.gaussian(1.0, 0.1), thermal=thermal)
    assert contacts.each_by_itself().thermal == exact
    assert Contacts(contacts.thresholds, thermal=Steady(0.5, 2.0)).thermal == exact
    one = contacts.replace(thresholds=origins.identical(1.0), thermal=exact)
    curve, c = master.kinetic_curve(one, [1.0, 2.0]), np.array([1.0, 0.5])  # h x_s/v
    known = (1.0 / c - (1.0 / c + 1.0) * np.exp(-c)) / -np.expm1(-c)
    assert curve.success.all() and curve.force == pytest.approx(known, rel=1e-10)
    for asked, says in (
        (
            {"temperature": 0.1, "width": 0.1},
            'temperature = 0.1: is unknown; the law "steady" takes width',
        ),
        ({}, "width: is missing"),
        ({"witdh": 0.1}, "witdh = 0.1: is unknown"),
    ):
        with pytest.raises(origins.InputError, match=says):
            Thermal("steady", **asked)
    with pytest.raises(origins.InputError, match="temperature: these contacts have no law for it"):
        master.kinetic_curve(one, 1.0, temperature=0.1)
    assert "0x" not in repr(Contacts(contacts.thresholds, thermal=Tilted()).thermal)
