"""Contacts on a soft slider: against plain Python, exact excursions, the master equation; and gone on with."""

import itertools
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
import scipy.stats
from conftest import slow
from plain_coupled import PlainReplica

import eq_model
import master
import origins
from origins.errors import InputError

RULES = ["instant", "reform-after", "reset"]
NARROW = origins.gaussian(1.0, 0.1)
MIXED = origins.mixture([origins.gaussian(1.0, 0.05), origins.gaussian(2.0, 0.1)], [0.5, 0.5])
ATOMS = origins.mixture([origins.identical(0.8), origins.identical(1.2)], [0.5, 0.5])
CONTACTS = {
    "narrow": origins.Contacts(NARROW),
    "stretched": origins.Contacts(NARROW, start=origins.gaussian_start(0.1, 0.1)),
    "linked": origins.Contacts(NARROW, stiffness="linked"),
    "mixed": origins.Contacts(MIXED),
    "atoms": origins.Contacts(ATOMS),
    "exponential": origins.Contacts(scipy.stats.expon()),
    "heavy tail": origins.Contacts(scipy.stats.lognorm(1.0)),
    "held back": origins.Contacts(NARROW, start=-0.9),
    "breaks while pushed": origins.Contacts(NARROW, start=scipy.stats.beta(0.3, 1.0, -0.9, 1.7)),
    "delayed": origins.Contacts(NARROW, delay=origins.Delay(0.3)),
    "strengthening": origins.Contacts(origins.strengthening(NARROW, 0.2, 0.3, age=1.0), start=0.3),
    "strengthening, delayed": origins.Contacts(
        origins.strengthening(NARROW, 0.2, 0.3), delay=origins.Delay(0.3)
    ),
}
HOLDS = {
    "path": [1.0, 2.0, 2.0, 2.0, 2.0, 5.0, 5.0, 9.0],
    "time": [1.0, 2.0, 2.1, 2.2, 2.4, 10.0, 20.0, 21.0],
}


def pulled(contacts, path, spring=0.7, slip="reset", n=300, replicas=1, seed=3, **other):
    arguments = {"n_contacts": n, "n_replicas": replicas, "seed": seed} | other
    return eq_model.simulate(contacts, path, spring=spring, slip=slip, **arguments)


# contacts by one rule each, which take turns; growth with a delay alone, by the rule that its slips differ most in; a
# mixture when it is slow, as narrow laws and heavy tails have its slips
QUICK = {name: RULES[number % 3] for number, name in enumerate(CONTACTS)}
QUICK |= {"strengthening": "", "strengthening, delayed": "reform-after", "mixed": ""}


@pytest.mark.parametrize(
    ("name", "slip"),
    [slow(name, slip, when=slip != QUICK[name]) for name in CONTACTS for slip in RULES],
)
def test_every_break_is_that_of_plain_python(name, slip):
    """Positions are whole numbers of 2^-28 mean thresholds here, floats there."""
    mean = CONTACTS[name].mean_threshold
    begin = -0.6 if name == "breaks while pushed" else 0.8  # contacts break there while F < 0
    drives = [{"path": mean * np.linspace(begin, 9.0, 300)}]
    drives += [HOLDS] if CONTACTS[name].in_time else []
    for number, drive in enumerate(drives):
        found = pulled(CONTACTS[name], **drive, slip=slip, replicas=number + 1, slip_fraction=0.03)
        asked = origins.Drive(**drive, spring=0.7, slip=slip)
        plain = PlainReplica(CONTACTS[name], asked, 300, 3, 0.03, number).follow()
        assert found.success and plain.breaks > 30
        off = 1e-6 * mean
        assert np.abs(found.positions[number] - plain.position).max() < off
        assert np.abs(found.forces[number] - plain.force).max() < off
        if number == 0:
            assert found.breaks == plain.breaks
            assert (found.holding == plain.holding).all()
            assert (found.avalanches[0] == plain.avalanches).all()
        slips, own = found.slips, found.slips.replica == number
        names = ("drive", "before", "after", "force_before", "force_after", "breaks")
        table = np.stack([getattr(slips, name)[own] for name in names], axis=1)
        assert table.shape == plain.slips.shape and len(table) > 0
        assert np.abs(table - plain.slips).max() < off


def test_an_instant_avalanche_is_an_excursion_below_the_running_maximum():
    """F_N(X) does not depend on K: X is the first at which F_N + K X reaches K X_T."""
    contacts = CONTACTS["stretched"]
    fine = np.linspace(0.8, 6.0, 200_001)
    stiff = pulled(contacts, fine, spring=1e4, slip="instant", n=100)
    x, force = stiff.positions[0], stiff.forces[0]
    step = np.diff(x).max()
    for spring in (0.3, 1.5):
        path = np.linspace(5.0, 5.0 * (1.0 + 0.1 / spring), 200)
        soft = pulled(contacts, path, spring=spring, slip="instant", n=100)
        load, near = force + spring * x, np.searchsorted(x, soft.positions[0])
        met = np.abs(load[near] - spring * path) <= (1.0 + spring) * step
        # elsewhere a contact breaks between two of the fine points
        assert (met | (force[near] < force[near - 1])).all() and met.mean() > 0.95
        highest = np.maximum.accumulate(load)
        assert (highest[near - 2] <= spring * path + (1.0 + spring) * step).all()


def test_contacts_that_form_again_stretched_are_the_rigid_ones_on_a_stiff_spring():
    """On a spring far above K* the force is that of a rigid slider at X."""
    contacts = origins.Contacts(NARROW, reforming=origins.gaussian_start(0.1, 0.2))
    path = np.linspace(1.0, 5.0, 9)
    coupled = pulled(contacts, path, spring=1e4, slip="instant", n=20_000, replicas=10)
    rigid = eq_model.simulate(contacts, coupled.position, n_contacts=200_000)
    error = np.hypot(coupled.force_standard_error, rigid.force_standard_error)
    assert np.abs((coupled.force - rigid.force) / error).max() < 5.0 and error.max() < 2e-3


def test_replicas_are_the_same_one_by_one_and_from_where_another_run_ended():
    path, contacts = (
        np.append(np.linspace(0.0, 4.0, 41), np.linspace(4, -2, 61)),
        CONTACTS["narrow"],
    )
    asked = {"spring": 0.7, "slip": "reform-after", "n_contacts": 500, "n_replicas": 7, "seed": 11}
    whole = eq_model.simulate(contacts, path, **asked)
    first = eq_model.CoupledEnsemble(contacts, path, **asked)
    for done, total in first:
        assert total == 7 * 500 and 0 < done <= total
        if done >= 3 * 500:
            break
    part = first.result()
    assert not part.success and part.contacts == 1500 and "stopped before all 7" in part.message
    rest = eq_model.CoupledEnsemble(contacts, path, **asked, earlier=[first.state])
    assert list(rest)[-1] == (4 * 500, 4 * 500)
    for other in (rest.result(), eq_model.simulate(contacts, path, **asked, threads=3)):
        names = "forces positions force force_standard_error avalanches breaks"
        for name in names.split():
            assert np.all(getattr(other, name) == getattr(whole, name))
        for name in ("replica", "number", "drive", "after", "breaks"):
            assert (getattr(other.slips, name) == getattr(whole.slips, name)).all()


@pytest.mark.parametrize(
    ("mass", "threads"),
    [
        ({}, 1),
        ({"mass": 0.01, "damping": 0.01}, 2),
        slow({}, 2),
        slow({"mass": 0.01, "damping": 0.01}, 1),
    ],
)
def test_a_replica_that_nobody_waits_for_is_given_up_on_its_way_and_followed_anew(mass, threads):
    """Once two are done and a third is on its way the run is interrupted, or its wall time is over: not the first."""
    rule = {} if mass else {"slip": "reset"}
    asked = {"spring": 0.5, "n_contacts": 1000, "n_replicas": 4, "threads": threads} | mass | rule
    path, contacts = np.linspace(0.0, 90.0, 10), CONTACTS["narrow"]
    whole = eq_model.simulate(contacts, path, **asked)
    for kind in ("interrupted", "over"):
        first = eq_model.Ensemble(contacts, path, **asked, wall_time=5.0)
        looks, all_yields = [], []

        def after_two(first=first, looks=looks):
            looks.append(first.state.contacts)
            return first.state.contacts >= 2000 and looks.count(looks[-1]) > 4

        if kind == "interrupted":
            first.interrupted = after_two
        else:
            first.clock = lambda after_two=after_two: 10.0 * after_two()
        for yielded in first:
            all_yields.append(yielded)
        kept = first.state.contacts
        assert kept == 2000 if threads == 1 else kept >= 2000
        assert all_yields[-1] == (kept, 4000)
        assert threads == 2 or looks.count(2000) >= 5  # once at its begin, else on its way
        rest = eq_model.Ensemble(contacts, path, **asked, earlier=[first.state])
        list(rest)
        assert (rest.result().forces == whole.forces).all()


@pytest.mark.parametrize("mass", [{}, {"mass": 0.01, "damping": 0.01}])
def test_the_first_replica_is_given_up_at_the_wall_time_too_and_one_line_says_that_nothing_is_known(
    mass,
):
    """The clock goes on by a second each time it is asked, so that the time is over on the way of the first replica."""
    rule = {} if mass else {"slip": "reset"}
    asked = {"spring": 0.5, "n_contacts": 1000, "n_replicas": 2} | mass | rule
    late = eq_model.Ensemble(CONTACTS["narrow"], np.linspace(0.0, 90.0, 10), **asked, wall_time=5.0)
    seconds = itertools.count()
    late.clock = lambda: float(next(seconds))
    *_, (done, total) = late
    assert (done, total) == (0, 2000) and next(seconds) < 15
    with pytest.raises(InputError, match=r"^wall_time = 5: no slider was followed to the end"):
        late.result()
    # what another run has is the result
    path, contacts = np.linspace(0.0, 4.0, 5), CONTACTS["narrow"]
    first = eq_model.Ensemble(contacts, path, **asked)
    next(iter(first))
    late = eq_model.Ensemble(contacts, path, **asked, wall_time=1e-9, earlier=[first.state])
    list(late)
    found = late.result()
    assert found.contacts == 1000 and not found.success and "stopped before all 2" in found.message


# -- beside the master equation, extrapolated to infinitely many contacts --------------------------

SIZES = np.array([4_000, 32_000, 256_000])
SLIPS = {  # contacts, and a spring below 0.7 K*
    "gaussian": (origins.Contacts(origins.gaussian(1.0, 0.05)), 1.0),
    "linked": (origins.Contacts(origins.gaussian(1.0, 0.1), stiffness="linked"), 0.7),
    "delayed": (origins.Contacts(origins.gaussian(1.0, 0.1), delay=origins.Delay(0.2)), 0.7),
    "machine": (origins.Contacts(origins.gaussian(1.0, 0.1)), 1e-6),
    "strengthening": (
        origins.Contacts(origins.strengthening(origins.gaussian(1.0, 0.1), 0.05, 0.2)),
        0.7,
    ),
}


class Extrapolated(NamedTuple):
    """A mean for infinitely many contacts, its standard error, what the next order may add, and misfit."""

    value: float
    error: float
    systematic: float
    chi_square: float

    def deviation(self, exact: float) -> float:
        return (self.value - exact) / np.hypot(self.error, self.systematic)


def extrapolated(means, errors) -> Extrapolated:
    """Fit value + a N^(-2/3), as of the first passage of a random walk over a parabola.

    The next order is N^(-1), by a factor of up to 5 a: that much a fit at N = 4,000 alone is off.
    """
    terms = np.stack([np.ones(SIZES.size), SIZES ** (-2.0 / 3.0)], axis=1)
    weights = np.linalg.pinv(terms / errors[:, None]) / errors
    value, slope = weights @ means
    error = float(np.sqrt((weights[0] ** 2 * errors**2).sum()))
    misfit = (means - terms @ [value, slope]) / errors
    systematic = float(abs(5.0 * slope * (weights[0] / SIZES).sum()))
    return Extrapolated(float(value), error, systematic, float((misfit**2).sum()))


def solved_slips(contacts, spring, rule, number):
    """X_T of so many first slips of the master equation."""
    path = [0.0, 1.1 * number * (1.0 + 1.0 / spring)]
    tolerance = 1e-5 if contacts.in_time else 1e-8
    solved = master.solve(contacts, path, tolerance, spring=spring, slip=rule)
    assert solved.success and solved.slips.drive.size >= number
    return solved.slips.drive[:number]


def slips(name, rule, number, contacts_each, seed=1):
    """The first slips of the master equation, and X_T of those of ensembles of each size, extrapolated; K X_T where
    K is below 1."""
    contacts, spring = SLIPS[name]
    exact = solved_slips(contacts, spring, rule, number)
    asked = {"spring": spring, "slip": rule, "seed": seed}
    sizes = [{"n_contacts": int(n), "n_replicas": contacts_each // int(n)} for n in SIZES]
    scale = min(spring, 1.0)
    end = [exact[-1] + 0.3 / scale]  # by which all replicas have slipped
    runs = [eq_model.simulate(contacts, end, **asked, **size).slips for size in sizes]
    tables = [scale * np.array([run.mean("drive", k) for run in runs]) for k in range(number)]
    return scale * exact, [extrapolated(table[:, 0], table[:, 1]) for table in tables]


@pytest.mark.parametrize(
    "name, rule",
    [
        ("gaussian", "reform-after"),
        # up to the first slip all rules are alike
        *(slow("gaussian", rule) for rule in ("instant", "reset")),
        slow("linked", "reform-after"),
        slow("machine", "reset"),
        slow("delayed", "reform-after"),
    ],
)
def test_the_first_slip_is_that_of_the_master_equation(name, rule):
    exact, found = slips(name, rule, 1, 4_000_000)
    assert abs(found[0].deviation(exact[0])) < 4.0
    assert found[0].error < 3e-4 and found[0].systematic < 2e-4 and found[0].chi_square < 12.0


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["instant", "reform-after"])
def test_slips_of_contacts_that_strengthen_are_those_of_the_master_equation(rule):
    """Two slips; growth by 2 % more, which shifts each by 20 standard errors or more, is told apart."""
    exact, found = slips("strengthening", rule, 2, 4_000_000)
    more = origins.Contacts(origins.strengthening(origins.gaussian(1.0, 0.1), 0.051, 0.2))
    other = 0.7 * solved_slips(more, 0.7, rule, 2)
    for k in (0, 1):
        assert abs(found[k].deviation(exact[k])) < 4.0 and found[k].chi_square < 12.0
        assert abs(found[k].deviation(other[k])) > 10.0


def largest(spring, size, replicas=16):
    """Mean share of the contacts that the largest avalanche breaks, gaussian(1, 0.2), and its standard error."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2))
    asked = {"slip": "instant", "slip_fraction": 1e-3, "n_replicas": replicas, "seed": 4}
    path = [3.0 + 1.5 / spring]
    slips = eq_model.simulate(contacts, path, spring=spring, n_contacts=size, **asked).slips
    shares = np.array([slips.breaks[slips.replica == r].max() for r in range(replicas)]) / size
    return shares.mean(), shares.std(ddof=1) / np.sqrt(replicas)


@pytest.mark.slow  # quick: the first slip of all contacts, above
@pytest.mark.parametrize("sizes", [(2_000, 16_000), (2_000, 16_000, 128_000)])
def test_above_the_critical_spring_the_largest_avalanche_vanishes(sizes):
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2))
    critical = master.propensity(contacts).critical_spring
    stiff = [largest(1.4 * critical, size) for size in sizes]
    soft = [largest(0.7 * critical, size) for size in sizes]
    for (few, error), (many, _) in pairwise(stiff):
        assert many < 0.5 * few and error < 0.2 * few
    for (few, _), (many, _) in pairwise(soft):
        assert abs(many - few) < 0.1 * few
    assert soft[-1][0] > 0.3 and stiff[-1][0] < 0.01


@pytest.mark.parametrize("rule", ["reset", "reform-after"])
def test_after_a_slip_of_all_contacts_the_force_is_none(rule):
    """And not the round-off of K (X_T - X), which was written as 5e-16 <x_s> in one of ten slips."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.3))
    found = eq_model.simulate(
        contacts, [0.0, 320.0], n_contacts=2000, n_replicas=4, seed=3, spring=0.037, slip=rule
    )
    assert found.slips.drive.size > 60 and not found.slips.force_after.any()
    some = eq_model.simulate(
        contacts, [0.0, 40.0], n_contacts=2000, n_replicas=4, seed=3, spring=0.3, slip="instant"
    )
    assert some.slips.drive.size >= 4 and (np.abs(some.slips.force_after) > 1e-6).all()
