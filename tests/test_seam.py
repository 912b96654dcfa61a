"""The seam between the rooms: laws of thresholds, and the list of a contact's laws."""

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from functools import cache, partial

import numpy as np
import pytest
from scipy import stats

import origins
from origins import Contacts, Delay, InputError, Thermal, ThresholdLaw
from origins.contacts import LAWS
from origins.thresholds.quadrature import gauss, panel_edges

GAUSSIAN = origins.gaussian(1.0, 0.2)
SURFACE = origins.moments_of_summits(radius=20e-6, std=0.2e-6, density=3e9)
GLASS = origins.Material(
    contact_modulus=3e9, local_friction=0.3, hardness=3e8, shear_strength=2e7, shear_modulus=1e9
)
GRAINS = origins.growing_grains(1.0, 1.0, age=4.0)

SAMPLES = {
    "power": lambda r: r.weibull(2.5, 3000),
    "diverging": lambda r: r.gamma(0.5, size=1000),
    "edges": lambda r: r.uniform(0.5, 1.5, 1000),
    "decades": lambda r: 1.0 + r.pareto(2.5, 1000),
    "outlier": lambda r: np.append(r.normal(1.0, 0.05, 100), [1e-12, 50.0]),
    "half tied": lambda r: np.concatenate([np.ones(300), r.weibull(2.0, 300)]),
    "two": lambda r: r.weibull(2.0, 2),
}


def of_samples(draw: Callable[[np.random.Generator], np.ndarray]) -> origins.Thresholds:
    return origins.from_samples(draw(np.random.default_rng(1)))


FAMILIES = {
    "gaussian": lambda: origins.gaussian(1.0, 0.05),
    "gaussian, far below 0": lambda: origins.gaussian(-8.0, 1.0),
    "chord": lambda: origins.gaussian(1.0, 0.3, form="paper", upper=2.0),
    "identical": lambda: origins.identical(0.7),
    "rectangular": lambda: origins.rectangular(0.5, 1.5),
    "weibull": lambda: origins.gw_elastic(1.0),
    "summits": lambda: origins.gw_gaussian(1.5, 1.0, "paper", "elastic"),
    "persson": lambda: origins.persson(1.0, 0.5),
    "persson, heavy": lambda: origins.persson(10.0, 1.0),
    "lubricated": lambda: origins.lubricated(1.0),
    "gamma": lambda: origins.lubricated(1.3, power=5.0, decay=4.0),
    "grains": lambda: origins.grains(2.0, B=1.0),
    "grains, printed": lambda: origins.grains(1.0, B=1.0, jacobian="paper"),
    "grains, pinning": lambda: GRAINS.at_start,
    "mixture": lambda: origins.mixture([origins.identical(0.9), GAUSSIAN], [0.25, 0.75]),
    "mixture, spike": lambda: origins.mixture([origins.gaussian(1.02, 1e-7), GAUSSIAN], [0.1, 0.9]),
    "continuous mixture": lambda: origins.continuous_mixture(origins.gw_plastic, 1.0, 3.0),
    **{f"samples, {name}": partial(of_samples, draw) for name, draw in SAMPLES.items()},
    "scipy": lambda: Contacts(stats.gamma(2.5)).thresholds,
    "scipy, cut at 0": lambda: Contacts(stats.norm(5.0, 1.0)).thresholds,
    "scipy, newer": lambda: Contacts(stats.Normal(mu=1.0, sigma=0.1)).thresholds,
    "rough, powered": lambda: origins.from_moments(
        SURFACE, model="persson", law="amontons", material=GLASS, pressure=3e5, patch_area=1e-12
    ),
}


@cache
def family(name: str) -> origins.Thresholds:
    return FAMILIES[name]()


def subclasses(kind: type) -> Iterator[type]:
    for own in kind.__subclasses__():
        yield own
        yield from subclasses(own)


def parts(law: origins.Thresholds) -> Iterator[origins.Thresholds]:
    """A law and what it is a mixture or a power of."""
    yield law
    for own in vars(law).values():
        for one in own if isinstance(own, list | tuple) else [own]:
            if isinstance(one, origins.Thresholds):
                yield from parts(one)


def test_every_family_is_here() -> None:
    for module in pkgutil.walk_packages(origins.__path__, "origins."):
        importlib.import_module(module.name)
    here = {kind for name in FAMILIES for law in parts(family(name)) for kind in type(law).__mro__}
    all_of_them = {
        kind for kind in subclasses(origins.Thresholds) if kind.__module__.startswith("origins.")
    }
    # no panels integrate the peaks of the first: test_domains.py counts angles; test_grains.py has the hazard
    assert {kind.__name__ for kind in all_of_them - here} <= {"AngleThresholds", "SlidingGrains"}


@pytest.mark.parametrize("name", FAMILIES)
def test_threshold_laws_conform(name: str) -> None:
    law = family(name)
    assert isinstance(law, ThresholdLaw)
    lower, upper = law.support()
    assert 0.0 <= lower <= upper
    positions, weights = law.atoms
    assert (weights > 0.0).all() and weights.sum() <= 1.0 + 1e-14
    assert (np.diff(law.breakpoints) > 0.0).all()
    assert lower in law.breakpoints and (upper in law.breakpoints or np.isinf(upper))
    assert isinstance(law.onset_power, float) and law.onset_power > -1.0
    q = np.array([1e-30, 1e-9, 1e-3, 0.2, 0.5, 0.9, 0.999])
    x = law.isf(q)
    assert (law.sf(x * (1.0 + 1e-12)) <= q * (1.0 + 1e-9)).all()
    assert (law.sf(x * (1.0 - 1e-12)) >= q * (1.0 - 1e-9)).all()
    # what takes logarithms is what does not; the complement; and quantiles at their ends
    np.testing.assert_allclose(np.exp(law.logsf(x)), law.sf(x), rtol=1e-12)
    np.testing.assert_allclose(np.exp(law.logpdf(x)), law.pdf(x), rtol=1e-12)
    np.testing.assert_allclose(law.cdf(x) + law.sf(x), 1.0, atol=4e-15)
    assert law.ppf(0.0) == lower == law.isf(1.0) and law.ppf(1.0) == upper == law.isf(0.0)
    assert lower <= law.ppf(1e-300) <= law.ppf(0.5) <= law.isf(1e-300) < np.inf
    for quantile in (law.ppf, law.isf):
        with pytest.raises(InputError, match="q = "):
            quantile([0.5, 1.1])
    # outside the support, for NaN, and in any shape
    limits = {"pdf": (0.0, 0.0), "logpdf": (-np.inf, -np.inf), "logsf": (0.0, -np.inf)}
    limits |= {"cdf": (0.0, 1.0), "sf": (1.0, 0.0)}
    for name_of, (below, above) in limits.items():
        method = getattr(law, name_of)
        assert method([-np.inf, -1.0, np.nextafter(lower, -1.0)]).tolist() == [below] * 3
        assert method(np.inf) == above and np.isnan(method([0.5, np.nan])).tolist() == [False, True]
        assert isinstance(method(0.5), float) and method(np.ones((2, 3))).shape == (2, 3)
        assert method(np.empty((0, 2))).shape == (0, 2)
    assert law.moment(0) == 1.0 and law.moment(1) == law.mean()
    assert law.moment(2) == pytest.approx(law.mean() ** 2 + law.std() ** 2, rel=1e-12)
    with pytest.raises(InputError, match="n = "):
        law.moment(1.0)  # type: ignore[arg-type]
    assert law.rvs((2, 3)).shape == (2, 3) and np.ndim(law.rvs()) == 0
    drawn, cells = law.rvs(20_000, random_state=1), law.isf(np.arange(0.0, 1.0, 0.01))
    share = (drawn > cells[:, None]).mean(axis=1)
    assert np.abs(share - law.sf(cells)).max() < 1.95 / np.sqrt(20_000)  # the 0.1 % level
    # the density and the atoms make up the survival, and both the mean
    edges = panel_edges(law)
    nodes, node_weights = gauss(edges[:-1], edges[1:])
    mass = node_weights * law.pdf(nodes)
    beyond = mass.sum(axis=1)[::-1].cumsum()[::-1] + np.array(
        [weights[positions > at].sum() for at in edges[:-1]]
    )
    np.testing.assert_allclose(beyond, law.sf(edges[:-1]), rtol=1e-7, atol=1e-11)
    assert law.mean() == pytest.approx(float((mass * nodes).sum() + weights @ positions), rel=1e-9)


def test_laws_of_contacts_and_their_exchange() -> None:
    aged = origins.Ageing(origins.gaussian(1.2, 0.1), rate=1e-3)
    given = {"thermal": Thermal("soft", 0.1), "ageing": aged, "delay": Delay(0.2), "reforming": 0.1}
    contacts = Contacts(GAUSSIAN, 0.05, **given)
    assert contacts.laws == tuple(name for name in LAWS if name in given)
    bare = contacts.replace(**dict.fromkeys(given))
    assert bare.laws == () and contacts.laws != () and bare.start is contacts.start
    again = bare.replace(**given)
    assert again.laws == contacts.laws
    assert again.waiting_time == 0.2
    assert again.reforming.law.mean() == 0.1
    # all is checked again, also against what stays
    with pytest.raises(InputError, match="stiffness = 'linked': not defined with ageing"):
        contacts.replace(stiffness="linked")
    other = contacts.replace(thresholds=origins.gaussian(1.1, 0.1))
    assert other.mean_threshold == pytest.approx(1.1) and other.laws == contacts.laws
    moving = Contacts(GRAINS, delay=Delay(0.2))
    assert moving.laws == ("grains", "delay") and moving.replace(start=0.0).grains is GRAINS
    assert moving.replace(delay=None).waiting_time == GRAINS.growth.first_pinning_time
