"""Coupled contacts on springs as soft as those of machines, 1e-9 to 1e-3 N_c<k>, and beyond the ring of buckets."""

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from plain_coupled import PlainReplica

import eq_model
import origins

NARROW = origins.gaussian(1.0, 0.1)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("spring", [1.0, 1e-3, 1e-9])
@pytest.mark.parametrize("slip", ["reset", "reform-after", "instant"])
def test_identical_thresholds_slip_as_by_hand(slip, spring):
    """All contacts break at the stretch 1, with F = 1.

    If they re-form after the slip, X = X_T there, and each slip begins 1 beyond the last one's end. If at once,
    F = 0 at the slip's begin, and X moves on to where F + K X is K X_T again.
    """
    if slip == "instant":
        before = np.arange(1.0, 4.0)
        drive, after = before + 1.0 / spring, before + 1.0 / (1.0 + spring)
    else:
        after = drive = np.arange(1.0, 4.0) * (1.0 + 1.0 / spring)
        before = drive - 1.0 / spring
    path = [drive[0] - 0.25, drive[-1] + 0.25]
    contacts, n = origins.Contacts(origins.identical(1.0)), 1_000_000 if spring == 1e-9 else 100
    found = eq_model.simulate(contacts, path, spring=spring, slip=slip, n_contacts=n)
    slips, rounding = found.slips, 4e-16 * drive + 1e-8  # positions are multiples of 2^-28
    for name, exact in (("drive", drive), ("before", before), ("after", after)):
        assert (np.abs(getattr(slips, name)[:3] - exact) < rounding).all(), name
    assert np.abs(slips.force_before[:3] - 1.0).max() < 1e-8
    assert np.abs(slips.force_after[:3] - spring * (drive - after)).max() < 1e-8
    assert found.force[0] == pytest.approx(1.0 - 0.25 * spring / (1.0 + spring), abs=1e-8)


def test_a_million_contacts_on_the_softest_spring():
    """K = 1e-9: the force of the spring has the digits of the contacts' force, though X is 1e9 thresholds."""
    contacts, spring, path = origins.Contacts(NARROW), 1e-9, np.linspace(1e8, 2.4e9, 24)
    asked = {"spring": spring, "slip": "reform-after", "n_contacts": 1_000_000, "seed": 6}
    found = eq_model.simulate(contacts, path, **asked)
    slips = found.slips
    assert slips.drive.size == 3 and (slips.breaks == 1_000_000).all()
    assert (slips.after == slips.drive).all() and np.abs(slips.force_after).max() < 1e-14
    # the first slip in closed form: 1 - X P_c(X) = -K; F = X - (what first breaks have released)
    x = scipy.optimize.brentq(lambda x: x * NARROW.pdf(x) - 1.0 - spring, 0.5, 0.9)
    force = x - scipy.integrate.quad(lambda y: y * NARROW.pdf(y), 0.0, x)[0]
    assert np.abs(slips.force_before - force).max() < 8.0 * 0.2 * 1e-3
    # a point of the path: K (X_T - X) = F, and X is what that force stretches all contacts to, but for breaks
    assert found.force[0] == pytest.approx(spring * 1e8, abs=1e-9)
    assert found.position[0] == pytest.approx(0.1, abs=1e-3)


def test_five_slips_with_mass_on_the_softest_spring():
    """K = 1e-9, critically damped, identical contacts that come back 100 T = 100 (M/K)^(1/2) after they broke: all at
    the stretch 1 and the spring's force 1. By then the slider follows its drive, u = X_T - X = γ v/K behind it, as
    M u'' + γ u' + K u = γ v; contacts that form there break 1 + 1/K + γ v further, and a slip is as fast as (1/K T)/e.
    """
    spring, time = 1e-9, 1e3
    mass, damping, delay, speed = spring * time**2, 2.0 * spring * time, 100.0 * time, 1.0
    contacts = origins.Contacts(origins.identical(1.0), delay=origins.Delay(delay))
    machine = {"spring": spring, "mass": mass, "damping": damping, "velocity": speed}
    path = np.linspace(2.5e8, 5.25e9, 21)
    found = eq_model.simulate(contacts, path, n_contacts=1000, n_replicas=1, **machine)
    slips, energy = found.slips, found.energy
    behind = damping * speed / spring
    period = delay * speed - behind + 1.0 + 1.0 / spring + damping * speed
    assert slips.drive.size == 5 and np.abs(np.diff(slips.drive) - period).max() < 1e-5
    # a slip is seen once the slider moves: 1e-3 of time later, by 1/(2 M) 1e-6 lengths
    assert slips.drive[0] == pytest.approx(1.0 + 1.0 / spring, abs=2e-3)
    assert np.abs(slips.force_before - 1.0).max() < 1e-8
    assert slips.top_speed == pytest.approx(np.full(5, np.exp(-1.0) / spring / time), rel=1e-6)
    assert np.abs(energy.imbalance).max() < 1e-10 * energy.work.max()
    assert found.force[-1] == pytest.approx(spring * (path[-1] - found.position[-1]), abs=1e-9)
    with pytest.raises(
        origins.InputError, match=r"^path\[-1\] = 8000000000.0: must be below 7.59e\+09"
    ):
        eq_model.simulate(contacts, [8e9], n_contacts=1000, **machine)


def test_breaks_beyond_the_ring_come_in_their_order():
    """One contact in 1,100 has a threshold of some 30, which waits in the list beyond the ring."""
    law = origins.mixture([NARROW, origins.gaussian(30.0, 3.0)], [1.0 - 9e-4, 9e-4])
    contacts, path, spring = origins.Contacts(law), np.linspace(1.0, 45.0, 75), 3.0
    asked = {"spring": spring, "slip": "instant", "n_contacts": 200, "seed": 8}
    found = eq_model.simulate(contacts, path, **asked)
    drive = origins.Drive(path, spring=spring, slip="instant")
    plain = PlainReplica(contacts, drive, 200, 8, 0.2, 0).follow()
    assert found.breaks == plain.breaks > 6_000
    assert np.abs(found.forces[0] - plain.force).max() < 1e-6
    assert (found.avalanches[0] == plain.avalanches).all()


@pytest.mark.parametrize(
    "slip, path, words",
    [
        # F_s = 0.80, F_k = 0.505: the slider slips at X_T = 8.0e8, by 3e8 thresholds
        ("instant", 8.1e8, r"^slip = 'instant': takes about 3\.0e\+14 breaks of 1000000 contacts"),
        ("instant", 7.9e8, ""),
        ("reset", 1e19, r"^path\[-1\] = 1e\+19: must be below 8.59e\+09"),
        ("reform-after", 8.1e8, ""),
    ],
)
def test_work_that_has_no_end_is_refused_before_it_begins(slip, path, words):
    contacts = origins.Contacts(NARROW)
    if not words:
        found = eq_model.simulate(contacts, [path], spring=1e-9, slip=slip, n_contacts=10_000)
        assert found.success and found.breaks <= 20_000
        return
    with pytest.raises(origins.errors.InputError, match=words):
        eq_model.simulate(contacts, [path], spring=1e-9, slip=slip, n_contacts=1_000_000)
