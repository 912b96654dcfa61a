"""The laws that Contacts carry: how contacts form again, stay out and are linked, and which solver takes what."""

import numpy as np
import pytest
from scipy import integrate, stats

import eq_model
import master
import origins
from eq_model.closest import closest
from master.paper.explicit import explicit
from origins import Ageing, Contacts, Delay, InputError, Thermal, boltzmann_reforming, gaussian_start
from origins.births import Births

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
TAKEN = dict.fromkeys(("master.solve", "master.steady_state", "master.propensity", "eq_model.simulate"), tuple(LAWS))
TAKEN["master.paper.explicit"] = ("delay",)


def refused(call, begins: str) -> None:
    with pytest.raises(InputError) as refusal:
        call()
    assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value), str(refusal.value)


def test_what_is_left_out_is_not_there() -> None:
    contacts = Contacts(GAUSSIAN)
    assert (contacts.thermal, contacts.ageing, contacts.delay, contacts.reforming) == (None, None, None, None)
    assert contacts.stiffness == "independent" and contacts.relative_stiffness(0.3) == 1.0
    assert Contacts(GAUSSIAN, reforming=0.0).reforming is None
    assert Contacts(GAUSSIAN, reforming=gaussian_start(0.0, 0.0)).reforming is None


def test_what_is_given_is_carried() -> None:
    for name, law in LAWS.items():
        contacts = Contacts(GAUSSIAN, **{name: law})
        if name == "reforming":
            assert contacts.reforming is not None and contacts.reforming.law.mean() == 0.1
        else:
            assert getattr(contacts, name) is law
    # the exact closures go together with everything but linked stiffness and ageing
    Contacts(GAUSSIAN, 0.1, **{name: law for name, law in LAWS.items() if name != "stiffness"})
    Contacts(GAUSSIAN, 0.1, **{name: law for name, law in LAWS.items() if name != "ageing"})


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", LAWS)
def test_no_law_is_silently_ignored(solver: str, name: str) -> None:
    if name in TAKEN.get(solver, ()):
        number = "critical_spring" if solver == "master.propensity" else "force"
        told = SOLVERS[solver](Contacts(GAUSSIAN)), SOLVERS[solver](Contacts(GAUSSIAN, **{name: LAWS[name]}))
        assert np.any(getattr(told[0], number) != getattr(told[1], number))
        return
    shown = " = 'linked'" if name == "stiffness" else ""
    told = f"contacts.{name}{shown}: {solver} does not take it yet; leave "
    if (solver, name) == ("master.paper.explicit", "thermal"):
        told = "contacts.thermal.closure = 'exact': the explicit scheme knows x alone"
    refused(lambda: SOLVERS[solver](Contacts(GAUSSIAN, **{name: LAWS[name]})), told)
    refused(lambda: SOLVERS[solver](GAUSSIAN), "contacts = ")


@pytest.mark.parametrize(
    ("call", "begins"),
    [
        (lambda: Contacts(GAUSSIAN, thermal=0.1), "thermal = 0.1: must be an origins.Thermal"),
        (lambda: Contacts(GAUSSIAN, ageing=GAUSSIAN), "ageing = "),
        (lambda: Contacts(GAUSSIAN, delay=0.2), "delay = 0.2: must be an origins.Delay"),
        (lambda: Contacts(GAUSSIAN, stiffness="equal"), "stiffness = 'equal': "),
        (lambda: Contacts(GAUSSIAN, reforming="relaxed"), "reforming = 'relaxed': must be None, a stretch"),
        (lambda: Contacts(GAUSSIAN, reforming=np.nan), "reforming = nan: "),
        (lambda: Contacts(GAUSSIAN, reforming=stats.cauchy()), "reforming: the mean of the distribution is"),
        (
            lambda: Contacts(GAUSSIAN, stiffness="linked", thermal=Thermal("soft", 0.1, closure="paper")),
            "stiffness = 'linked': not defined with thermal closure = \"paper\"",
        ),
        (
            lambda: Contacts(GAUSSIAN, stiffness="linked", ageing=LAWS["ageing"]),
            "stiffness = 'linked': not defined with ageing: ",
        ),
        (lambda: Contacts(BOX, reforming=1.0), "reforming: a weight of 1 lies beyond every threshold, at |x| >= 1;"),
        (lambda: Contacts(BOX, reforming=-1.5), "reforming: a weight of 1 lies beyond every threshold"),
        (lambda: Contacts(BOX, reforming=boltzmann_reforming(0.05)), "reforming: a weight of 7.74e-06 lies beyond"),
        (
            lambda: Contacts(GAUSSIAN, ageing=Ageing(BOX, rate=1.0)),
            "ageing: a weight of 0.506 of the fresh thresholds lies outside the final law, 0.5 to 1",
        ),
        (lambda: Delay(-0.1), "time = -0.1: must be zero or above"),
        (lambda: Delay(np.inf), "time = inf: "),
        (lambda: boltzmann_reforming(0.0), "temperature = 0.0: must be above zero"),
        (lambda: Births("start", gaussian_start(0.0, 0.1), BOX).survival(0.2, [0.1, 1.2]), "birth = 1.2: no threshold"),
    ],
)
def test_refusals(call, begins: str) -> None:
    refused(call, begins)


def test_reforming_weight_beyond_is_cut_and_said() -> None:
    births = Contacts(BOX, reforming=boltzmann_reforming(0.04)).reforming
    assert births is not None and births.cut_weight == pytest.approx(2.0 * stats.norm.sf(5.0), rel=1e-12)
    births = Contacts(BOX, reforming=boltzmann_reforming(0.01)).reforming
    assert births is not None and births.cut_weight == 0.0


def test_boltzmann_reforming_is_the_law_of_a_spring() -> None:
    """R ~ exp(-k x²/2k_BT): equipartition, <k> <x²> = k_BT."""
    law = boltzmann_reforming(0.03)
    second = integrate.quad(lambda x: x * x * law.pdf(x), -2.0, 2.0, epsabs=1e-14)[0]
    assert second == pytest.approx(0.03, rel=1e-10)
    assert law.pdf(0.2) / law.pdf(0.0) == pytest.approx(np.exp(-(0.2**2) / (2.0 * 0.03)), rel=1e-13)


def test_mean_way_of_contacts_that_form_again_elsewhere() -> None:
    """E(s) = ∫ R(r) S(max(|r|, r + s))/S(|r|) dr falls to ∫E ds = <x_s - r>, the mean way from birth to break."""
    births = Contacts(GAUSSIAN, reforming=gaussian_start(0.1, 0.15)).reforming
    assert births is not None
    nodes, weights = np.polynomial.legendre.leggauss(160)
    r, shares = 0.1 + 1.2 * nodes, 1.2 * weights
    shares = shares * births.law.pdf(r)
    s = 1.6 * (nodes + 1.0)
    survival = births.survival(r[:, None] + s, r[:, None])
    way = float(shares @ survival @ (1.6 * weights))
    x, threshold = births.draw(250_000, np.random.default_rng(5))
    assert (threshold >= np.abs(x)).all()
    assert abs(way - (threshold - x).mean()) < 5.0 * (threshold - x).std() / 500.0


@pytest.mark.parametrize("law", [0.8, -0.8, gaussian_start(0.1, 0.3)])
def test_drawn_thresholds_follow_the_conditional_law(law: object) -> None:
    """Through the conditional survival each pair becomes uniform."""
    births = Contacts(GAUSSIAN, reforming=law).reforming
    assert births is not None
    x, threshold = births.draw(200_000, np.random.default_rng(6))
    assert stats.kstest(births.survival(threshold, x), "uniform").pvalue > 1e-4
    if births.law.is_single:
        assert (x == law).all()
    else:
        assert stats.kstest(x, stats.norm(0.1, 0.3).cdf).pvalue > 1e-4


def test_deep_births_keep_their_digits() -> None:
    """Where S(|r|) underflows the ratio is still there: S falls off as a Gaussian tail."""
    births = Births("start", gaussian_start(0.0, 0.1), GAUSSIAN)
    x, r = 9.02, 9.0
    known = stats.norm.logsf(x, 1.0, 0.2) - stats.norm.logsf(r, 1.0, 0.2)
    assert float(births.survival(x, r)) == pytest.approx(np.exp(known), rel=1e-10)
    assert float(births.survival(-0.3, 0.9)) == 1.0  # moved back: it has been further
