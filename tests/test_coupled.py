"""Contacts on a soft slider: against plain Python, exact excursions, and what every replica must keep."""

import numpy as np
import pytest
import scipy.stats
from plain_coupled import PlainReplica

import eq_model
import master
import origins

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
    "delayed": origins.Contacts(NARROW, delay=origins.Delay(0.3)),
}
HOLDS = {
    "path": [1.0, 2.0, 2.0, 2.0, 2.0, 5.0, 5.0, 9.0],
    "time": [1.0, 2.0, 2.1, 2.2, 2.4, 10.0, 20.0, 21.0],
}


def pulled(contacts, path, spring=0.7, slip="reset", n=300, replicas=1, seed=3, **other):
    arguments = {"n_contacts": n, "n_replicas": replicas, "seed": seed} | other
    return eq_model.simulate(contacts, path, spring=spring, slip=slip, **arguments)


@pytest.mark.parametrize("slip", RULES)
@pytest.mark.parametrize("name", CONTACTS)
def test_every_break_is_that_of_plain_python(name, slip):
    """Positions are whole numbers of 2^-28 mean thresholds here, floats there."""
    mean = CONTACTS[name].mean_threshold
    drives = [{"path": mean * np.linspace(0.8, 9.0, 300)}] + ([HOLDS] if name == "delayed" else [])
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


@pytest.mark.parametrize("contacts", [CONTACTS["narrow"], CONTACTS["atoms"], CONTACTS["stretched"]])
def test_an_instant_avalanche_is_an_excursion_below_the_running_maximum(contacts):
    """F_N(X) does not depend on K: X is the first at which F_N + K X reaches K X_T."""
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


@pytest.mark.parametrize("spring", [0.05, 0.5, 4.0])
@pytest.mark.parametrize("slip", RULES)
def test_identical_thresholds_are_a_sawtooth(slip, spring):
    """After an instant slip the contacts have been stretched by the slip; after the others they are relaxed."""
    to = 1.0 + 1.0 / spring
    period = 1.0 if slip == "instant" else to
    path = np.linspace(0.003, 0.997, 331) * (to + 4.0 * period)
    result = pulled(origins.Contacts(origins.identical(1.0)), path, spring, slip, n=1000)
    if slip == "instant":
        x = np.where(
            path < to,
            path * spring / (1.0 + spring),
            (spring * path + np.ceil(path - to)) / (1.0 + spring),
        )
        x = np.where(path < to, path / to, x)
        exact = spring * (path - x)
    else:
        x = path % period / period + path // period * period
        exact = path % period / period
        x = path - exact / spring
    clear = np.abs((path - to) / period - np.rint((path - to) / period)) > 1e-6
    assert clear.all()
    assert np.abs(result.position - x).max() < 1e-7 * to
    assert np.abs(result.force - exact).max() < 1e-7
    assert (
        np.abs(result.slips.drive - (to + period * np.arange(result.slips.drive.size))).max()
        < 1e-7 * to
    )
    assert (result.slips.breaks == (200 if slip == "reset" else 1000)).all()


def test_replicas_are_the_same_one_by_one_and_from_where_another_run_ended():
    path = np.linspace(0.0, 6.0, 61)
    arguments = {
        "spring": 0.7,
        "slip": "reform-after",
        "n_contacts": 500,
        "n_replicas": 7,
        "seed": 11,
    }
    whole = eq_model.simulate(CONTACTS["narrow"], path, **arguments)
    first = eq_model.CoupledEnsemble(CONTACTS["narrow"], path, **arguments)
    for done, total in first:
        assert total == 7 * 500 and 0 < done <= total
        if done >= 3 * 500:
            break
    threaded = eq_model.simulate(CONTACTS["narrow"], path, **arguments, threads=3)
    assert (threaded.forces == whole.forces).all()
    state = type(first.state).of_arrays(first.state.arrays())
    assert state.done == [range(3)] and state.contacts == 1500
    rest = eq_model.CoupledEnsemble(CONTACTS["narrow"], path, **arguments, earlier=[state])
    assert list(rest)[-1] == (4 * 500, 4 * 500)
    result = rest.result()
    for name in ("forces", "positions", "force", "force_standard_error", "avalanches", "breaks"):
        assert np.all(getattr(result, name) == getattr(whole, name))
    for name in ("replica", "number", "drive", "after", "breaks"):
        assert (getattr(result.slips, name) == getattr(whole.slips, name)).all()


def test_a_run_that_stops_early_has_whole_replicas_and_says_so():
    ensemble = eq_model.CoupledEnsemble(
        CONTACTS["narrow"], [4.0], spring=0.7, n_contacts=500, n_replicas=5
    )
    for _ in ensemble:
        ensemble.stop()
    result = ensemble.result()
    assert (
        not result.success and result.contacts == 500 and "stopped before all 5" in result.message
    )
    assert np.isinf(result.force_standard_error).all()


def test_what_is_held_agrees_with_the_force():
    """K (X_T - X) = F, and the force falls by K times the slip."""
    for slip in RULES:
        result = pulled(CONTACTS["narrow"], np.linspace(0.0, 9.0, 91), slip=slip, replicas=3)
        assert np.abs(0.7 * (result.path - result.positions) - result.forces).max() < 1e-7
        slips = result.slips
        assert np.abs(slips.drop - 0.7 * (slips.after - slips.before)).max() < 1e-7
        assert np.abs(0.7 * (slips.drive - slips.before) - slips.force_before).max() < 1e-7
        mean, error = slips.mean("drop", 0)
        assert mean == slips.drop[slips.number == 0].mean() and 0.0 < error < 0.1


def test_standard_errors_are_those_of_the_replicas():
    """Of ten replicas the mean over its own error follows Student's t with nine degrees of freedom."""
    runs = [
        pulled(CONTACTS["narrow"], [3.0], slip="instant", n=300, replicas=10, seed=k).slips
        for k in range(300)
    ]
    for name in ("drive", "drop"):
        found = np.array([run.mean(name, 0) for run in runs])
        z = (found[:, 0] - found[:, 0].mean()) / found[:, 1]
        assert z.var() == pytest.approx(9.0 / 7.0, rel=0.35)  # 300 seeds know it to a tenth


def test_contacts_that_form_again_stretched_are_the_rigid_ones_on_a_stiff_spring():
    """On a spring far above K* the force is that of a rigid slider at X, which the master equation knows."""
    contacts = origins.Contacts(NARROW, reforming=origins.gaussian_start(0.1, 0.2))
    path = np.linspace(1.0, 5.0, 9)
    coupled = pulled(contacts, path, spring=1e4, slip="instant", n=20_000, replicas=40)
    rigid = master.solve(contacts, coupled.position, 1e-8)
    error = coupled.force_standard_error
    assert np.abs((coupled.force - rigid.force) / error).max() < 5.0 and error.max() < 1e-3


def refused(match, path=(2.0,), **other):
    with pytest.raises(origins.InputError, match=match):
        pulled(path=path, **({"contacts": CONTACTS["narrow"]} | other))


def test_what_is_not_followed_is_refused():
    warm = origins.Thermal("soft", 0.1)
    again = origins.gaussian_start(0.0, 0.1)
    refused("thermal", contacts=origins.Contacts(NARROW, thermal=warm))
    refused(
        "ageing",
        contacts=origins.Contacts(NARROW, ageing=origins.Ageing(origins.gaussian(1.2, 0.05), 1e-3)),
    )
    refused("reforming", contacts=origins.Contacts(NARROW, reforming=again), slip="reset")
    refused(r"path\[2\].*does not turn", path=[0.0, 2.0, 1.0])
    refused("break backwards", path=[-3.0, 2.0])
    refused("slip", slip="never")
    refused("spring", spring=-1.0)
    refused("slip_fraction", slip_fraction=1.5)
    refused("tolerance", tolerance=1e-3)
    refused("histograms", histograms=[0])
    refused("n_contacts", n=0)
    with pytest.raises(origins.InputError, match="rigid"):
        eq_model.simulate(CONTACTS["narrow"], [2.0], slip="instant")
    with pytest.raises(origins.InputError, match="slip_fraction"):
        eq_model.simulate(CONTACTS["narrow"], [2.0], slip_fraction=0.2)
