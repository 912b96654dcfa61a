"""Contacts, their laws, starts and drives: what they carry, what they refuse, and which solver takes which law."""

import numpy as np
import pytest
from scipy import integrate, stats

import eq_model
import master
import origins
from eq_model.closest import closest
from master.paper.explicit import explicit
from origins import Ageing, Contacts, Delay, Drive, InputError, Thermal, gaussian_start
from origins.start import as_start

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
TAKEN = {"master.paper.explicit": ("delay",), "eq_model.closest": ()}


class Slow(origins.Thresholds):
    """Of infinite mean."""

    def support(self):
        return 1.0, np.inf

    def _moment(self, n):
        return np.inf


class Loose(origins.Thresholds):
    """Half of the weight at 0, the rest at 1."""

    def support(self):
        return 0.0, 1.0

    @property
    def atoms(self):
        return np.array([0.0, 1.0]), np.array([0.5, 0.5])


def test_what_is_left_out_is_not_there_and_what_is_given_is() -> None:
    bare = Contacts(stats.gamma(3.0))
    assert bare.mean_threshold == 3.0 and bare.start.is_single and bare.laws == ()
    assert bare.stiffness == "independent" and bare.relative_stiffness(0.3) == 1.0
    assert Contacts(GAUSSIAN, reforming=gaussian_start(0.0, 0.0)).reforming is None
    for name, law in LAWS.items():
        carried = getattr(Contacts(GAUSSIAN, **{name: law}), name)
        assert (carried.law.mean() if name == "reforming" else carried) == law


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
    if (solver, name) == ("master.paper.explicit", "thermal"):
        told = "contacts.thermal.closure = 'exact': the explicit scheme knows x alone"
    refused(lambda: solve(contacts), told)
    refused(lambda: solve(GAUSSIAN), "contacts = ")


def refused(call, begins: str, holds: str = "") -> None:
    with pytest.raises(InputError) as refusal:
        call()
    told = str(refusal.value)
    assert told.startswith(begins) and holds in told and "\n" not in told, told


BEYOND = "a weight of 1 lies beyond every threshold"
REFUSED = [
    (lambda: Contacts(stats.halfcauchy()), "thresholds: the mean is inf"),
    (lambda: Contacts(Slow()), "thresholds: the mean threshold is inf"),
    (lambda: Contacts(Loose()), "thresholds: a weight of 0.5 lies at x = 0; such contacts never"),
    (lambda: Contacts(origins.gaussian(1e200, 1e199)), "std = 1e+199: must lie between"),
    (lambda: Contacts(origins.identical(1e-200)), "thresholds: the mean is 1e-200: powers of"),
    (lambda: Contacts(BOX, start=-1.0), f"start: {BEYOND}, at |x| >= 1;"),
    (lambda: Contacts(origins.identical(1.0), start=1.0), f"start: {BEYOND}"),
    (lambda: Contacts(NARROW, start=10.0), f"start: {BEYOND}"),
    (lambda: Contacts(BOX, start=gaussian_start(0.0, 0.21)), "start: a weight of 1.92e-06 lies"),
    (lambda: Contacts(GAUSSIAN, start=np.nan), "start = nan: "),
    (lambda: Contacts(GAUSSIAN, start=True), "start = True: "),
    (lambda: Contacts(GAUSSIAN, start=[0.0, 1.0]), "start = [0.0, 1.0]: "),
    (lambda: Contacts(GAUSSIAN, start=stats.cauchy()), "start: the mean of the distribution is"),
    (lambda: Contacts(GAUSSIAN, start=stats.poisson(1.0)), "start = "),
    (lambda: gaussian_start(np.nan, 0.1), "mean = nan: "),
    (lambda: gaussian_start(0.0, -0.1), "std = -0.1: "),
    (lambda: Contacts(GAUSSIAN, thermal=0.1), "thermal = 0.1: must be an origins.Thermal"),
    (lambda: Contacts(GAUSSIAN, ageing=GAUSSIAN), "ageing = "),
    (lambda: Contacts(GAUSSIAN, delay=0.2), "delay = 0.2: must be an origins.Delay"),
    (lambda: Contacts(GAUSSIAN, stiffness="equal"), "stiffness = 'equal': "),
    (lambda: Contacts(GAUSSIAN, reforming="relaxed"), "reforming = 'relaxed': must be None, a"),
    (lambda: Contacts(BOX, reforming=-1.5), f"reforming: {BEYOND}"),
    (
        lambda: Contacts(
            GAUSSIAN, stiffness="linked", thermal=Thermal("soft", 0.1, closure="paper")
        ),
        "stiffness = 'linked': not defined with thermal closure = \"paper\"",
    ),
    (
        lambda: Contacts(GAUSSIAN, stiffness="linked", ageing=LAWS["ageing"]),
        "stiffness = 'linked': not defined with ageing: ",
    ),
    (
        lambda: Contacts(GAUSSIAN, ageing=Ageing(BOX, rate=1.0)),
        "ageing: a weight of 0.506 of the fresh thresholds lies outside the final law, 0.5 to 1",
    ),
    (lambda: Delay(-0.1), "time = -0.1: must be zero or above"),
    (lambda: origins.boltzmann_reforming(0.0), "temperature = 0.0: must be above zero"),
    (lambda: Drive([]), "path = array of shape (0,): "),
    (lambda: Drive([[0.0, 1.0]]), "path = array of shape (1, 2): "),
    (lambda: Drive([0.0, np.nan, 1.0]), "path[1] = nan: "),
    (lambda: Drive([0.0, "x"]), "path = [0.0, 'x']: "),
    (lambda: Drive([-0.1, 1.0]).only_forward("this"), "path[0] = -0.1: lies behind X = 0; this"),
    (lambda: Drive([0.0, 2.0, 1.0]).only_forward("this"), "path[2] = 1.0: lies behind path[1] = 2"),
    (lambda: Drive([0.0, 1.0], slip="instant"), "slip = 'instant': is what a slip of a soft"),
    (lambda: Drive([0.0, 1.0], time=[0.0, 0.0]), "time[1] = 0.0: leaves no time to get there"),
    (lambda: Drive([0.0, 1.0], time=[1.0, 0.5]), "time[1] = 0.5: is before time[0] = 1;"),
    (lambda: Drive([0.0, 1.0], 2.0, time=[0.0, 1.0]), "velocity = 2.0: the times of the points"),
]


@pytest.mark.parametrize(("call", "begins"), REFUSED)
def test_refusals(call, begins: str) -> None:
    refused(call, begins)


def test_weight_beyond_every_threshold_is_cut_and_said() -> None:
    """Up to 1e-6 is cut off; both sides count, since barriers and thresholds ask for |x|."""
    known = 2.0 * stats.norm.sf(5.0)
    assert Contacts(BOX, gaussian_start(0.0, 0.2)).cut_weight == pytest.approx(known, rel=1e-12)
    births = Contacts(BOX, reforming=origins.boltzmann_reforming(0.04)).reforming
    assert births.cut_weight == pytest.approx(known, rel=1e-12)
    for law, start in [(BOX, 0.999), (BOX, stats.uniform(-1.0, 2.0)), (NARROW, 2.5)]:
        assert Contacts(law, start=start).cut_weight == 0.0


def test_starts() -> None:
    assert as_start(None).span == (0.0, 0.0) and as_start(np.float64(-0.1)).is_single
    single = gaussian_start(0.2, 0.0)
    assert single.is_single and single.span == (0.2, 0.2) and as_start(single) is single
    x, q = np.linspace(-0.1, 0.1, 7), np.array([1e-12, 0.3, 0.9])
    twins = [
        (gaussian_start(0.01, 0.025), stats.norm(0.01, 0.025)),
        (as_start(stats.expon()), stats.expon()),
        (as_start(stats.Normal(mu=0.0, sigma=0.025)), stats.norm(0.0, 0.025)),
    ]
    for start, twin in twins:
        assert not start.is_single and start.mean() == pytest.approx(twin.mean(), rel=1e-15)
        for name, given in {"pdf": x, "cdf": x, "sf": x, "ppf": q, "isf": q}.items():
            found, known = getattr(start, name)(given), getattr(twin, name)(given)
            np.testing.assert_allclose(found, known, rtol=1e-12, atol=1e-15)
        assert twin.cdf(start.span[0]) + twin.sf(start.span[1]) < 4e-16
    box = as_start(stats.uniform(1.0, 2.0))
    assert box.span == (1.0, 3.0) and box.breakpoints.tolist() == [1.0, 3.0]


def test_paths() -> None:
    assert Drive(2.0).path.tolist() == [2.0] and Drive([3]).path.dtype == float
    assert [Drive(path).forward for path in ([0.0, 2.0], [0.0, 2.0, 1.0], [-0.1, 1.0])] == [
        True,
        False,
        False,
    ]
    assert Drive([0.0, 1.0], time=[0.0, 3.0]).only_forward("this").time.tolist() == [0.0, 3.0]


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
