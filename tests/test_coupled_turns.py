"""Contacts on a spring whose drive turns: against plain Python, the master equation, steps of time."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.stats
from conftest import slow
from plain_coupled import PlainReplica
from test_coupled import CONTACTS, RULES, pulled
from test_heat_on_springs import stepped

import eq_model
import master
import origins

WIDE = origins.gaussian(1.0, 0.2)
# of mean thresholds; where it begins contacts of a stretched start are passed by the drive's way back
ENDS = np.array([-0.7, 4.0, -2.5, 3.0, 2.2, -1.0])
SPRING = 0.7


def along(ends, points):
    """A path through these places, straight between them."""
    return np.concatenate([np.linspace(*leg, points)[1:] for leg in pairwise(np.append(0, ends))])


RESTS = {
    "path": np.repeat(along(ENDS, 4), 2),
    "time": np.cumsum(np.tile([0.9, 0.2, 2.0, 0.0, 0.1, 1.5], 6)),
}


NAMES = "stretched", "linked", "atoms", "exponential", "breaks while pushed", "delayed"


@pytest.mark.parametrize(
    ("name", "slip"),
    [
        slow(name, slip, when=number > 5 or slip != RULES[number % 3])
        for number, name in enumerate((*NAMES, "strengthening", "strengthening, delayed"))
        for slip in RULES
    ],
)
def test_every_break_is_that_of_plain_python(name, slip):
    """Which mirrors nothing: contacts break ahead or behind. With laws of time the drive rests at its points, too."""
    contacts, n = CONTACTS[name], 200
    drives = [{"path": along(ENDS, 30)}] + [RESTS] * bool(contacts.in_time)
    for drive in drives:
        found = pulled(contacts, **drive, spring=SPRING, slip=slip, n=n, slip_fraction=0.05)
        asked = origins.Drive(**drive, spring=SPRING, slip=slip)
        plain = PlainReplica(contacts, asked, n, 3, 0.05, 0).follow()
        assert found.breaks == plain.breaks > 50
        assert np.abs(found.positions[0] - plain.position).max() < 1e-6
        assert np.abs(found.forces[0] - plain.force).max() < 1e-6
        assert (found.holding == plain.holding).all()
        assert (found.avalanches[0] == plain.avalanches).all()
        names = ("drive", "before", "after", "force_before", "force_after", "breaks")
        table = np.stack([getattr(found.slips, name) for name in names], axis=1)
        assert (
            table.shape == plain.slips.shape and np.abs(table - plain.slips).max(initial=0) < 1e-6
        )
        assert (found.forces[0] < -0.1).any() and (found.forces[0] > 0.1).any()


def test_contacts_that_form_again_stretched_are_pushed_the_same_way_on_the_way_back():
    contacts = origins.Contacts(WIDE, reforming=origins.gaussian_start(0.2, 0.1))
    found = pulled(contacts, along(ENDS, 30), spring=SPRING, slip="instant", n=200)
    asked = origins.Drive(along(ENDS, 30), spring=SPRING, slip="instant")
    plain = PlainReplica(contacts, asked, 200, 3, 0.2, 0).follow()
    assert found.breaks == plain.breaks > 1000
    assert np.abs(found.forces[0] - plain.force).max() < 1e-9
    mirrored = origins.Contacts(WIDE, reforming=origins.gaussian_start(-0.2, 0.1))
    other = pulled(mirrored, along(ENDS, 30), spring=SPRING, slip="instant", n=200)
    assert np.abs(found.forces - other.forces).max() > 0.1


# -- the master equation ---------------------------------------------------------------------------

STIFF = {  # on springs on which nothing slips: contacts, others near them, K/(N_c <k>), and the tolerance
    "gaussian": (
        origins.Contacts(WIDE, start=origins.gaussian_start(0.4, 0.1)),
        origins.Contacts(origins.gaussian(1.01, 0.2), start=origins.gaussian_start(0.4, 0.1)),
        2.0,
        1e-6,
    ),
    "linked": (
        origins.Contacts(WIDE, stiffness="linked"),
        origins.Contacts(origins.gaussian(1.01, 0.2), stiffness="linked"),
        2.5,
        1e-6,
    ),
    "exponential": (
        origins.Contacts(scipy.stats.expon()),
        origins.Contacts(scipy.stats.expon(scale=1.02)),
        0.5,
        1e-6,
    ),
    "strengthening": (
        origins.Contacts(origins.strengthening(WIDE, 0.1, 0.2)),
        origins.Contacts(origins.strengthening(WIDE, 0.11, 0.2)),
        2.0,
        1e-4,
    ),
    "heat": (
        origins.Contacts(WIDE, thermal=origins.Thermal("soft", 0.05, 10.0)),
        origins.Contacts(WIDE, thermal=origins.Thermal("soft", 0.053, 10.0)),
        1.5,
        1e-3,
    ),
}
TURNS = np.array([2.5, 0.4, 1.6, -2.0, -1.0, -2.2, 2.0])


@pytest.mark.parametrize("name", [slow(name, when=name != "gaussian") for name in STIFF])
def test_forces_between_turns_are_those_of_the_master_equation(name):
    """At 42 points of seven legs, extrapolated from 4,000 and 32,000 contacts; one 2 % off (heat 6 %) is told apart."""
    contacts, other, spring, tolerance = STIFF[name]
    asked = {"spring": spring, "slip": "instant"}
    solved, off = (
        master.solve(one, along(TURNS, 7), tolerance, **asked) for one in (contacts, other)
    )
    assert solved.success and not solved.slips.drive.size
    few, many = (
        eq_model.simulate(
            contacts, along(TURNS, 7), n_contacts=n, n_replicas=replicas, seed=7, **asked
        )
        for n, replicas in ((4_000, 128), (32_000, 24))
    )
    force = (4.0 * many.force - few.force) / 3.0  # N^(-2/3) is a quarter
    error = np.hypot(4.0 * many.force_standard_error, few.force_standard_error) / 3.0
    error = np.hypot(error, solved.force_error)
    assert np.abs((force - solved.force) / error).max() < 4.0 and error.max() < 2e-3
    assert np.abs((force - off.force) / error).max() > 5.0


@pytest.mark.slow
@pytest.mark.parametrize("slip", RULES)
def test_slips_between_turns_are_those_of_the_master_equation(slip):
    """In order along three legs, extrapolated from 4,000 and 32,000 contacts."""
    contacts, path = origins.Contacts(origins.gaussian(1.0, 0.1)), [5.0, -5.0, 3.0]
    solved = master.solve(contacts, path, 1e-6, spring=SPRING, slip=slip).slips
    asked = {"spring": SPRING, "slip": slip, "seed": 2}
    few, many = (
        eq_model.simulate(contacts, path, n_contacts=n, n_replicas=replicas, **asked).slips
        for n, replicas in ((4_000, 1_000), (32_000, 125))
    )
    # chance makes more and fewer of the last small ones under "instant"
    count = 4 if slip == "instant" else 9
    assert solved.drive.size >= count
    for name in ("drive", "force_before", "force_after"):
        for k in range(count):
            (one, off), (two, more_off) = few.mean(name, k), many.mean(name, k)
            error = np.hypot(off, 4.0 * more_off) / 3.0
            # the next order, N^(-1), by up to five times the slope
            left = 5.0 * abs(two - one) * 4_000 ** (-1 / 3) / 3.0
            assert abs((4.0 * two - one) / 3.0 - getattr(solved, name)[k]) <= 4.0 * error + left
    assert (np.sign(many.drop) == np.sign(many.after - many.before)).all()


# -- heat ------------------------------------------------------------------------------------------


# the second sees differences of half the size
@pytest.mark.parametrize(("stepping", "jumping"), [(120, 500), slow(1000, 4000)])
def test_a_slider_creeps_on_as_its_drive_turns(stepping, jumping):
    """It still goes forward while the drive goes back slowly: beside steps of time, of 20 contacts each."""
    contacts = origins.Contacts(WIDE, thermal=origins.Thermal("soft", 0.1, 3.0))
    path, time = np.array([1.5, 1.4, 1.4, 0.2]), np.array([0.5, 3.0, 5.0, 5.5])
    x, force, error = stepped(contacts, path, time, 0.5, 20, stepping, 2e-3, 11)
    asked = {"time": time, "spring": 0.5, "slip": "instant", "n_contacts": 20}
    found = eq_model.simulate(contacts, path, **asked, n_replicas=jumping, seed=2)
    error = np.hypot(error, found.force_standard_error)
    assert np.abs((found.force - force) / error).max() < 4.0
    assert error.max() < 6e-3 * (1000 / stepping) ** 0.5
    assert x[2] > x[0] + 0.1 and found.position[2] > found.position[0] + 0.1


def test_the_way_back_is_the_mirror_image_of_the_way_forward():
    """A start pulled to one side, far behind where the path begins, beside one pulled to the other."""
    heat = origins.Thermal("soft", 0.05, 10.0)
    path, asked = along([0.0, 2.0, -1.0, 1.0], 4), {"spring": 0.5, "slip": "instant", "seed": 1}
    one, other = (
        eq_model.simulate(
            origins.Contacts(WIDE, thermal=heat, start=origins.gaussian_start(way * 0.5, 0.1)),
            way * path,
            n_contacts=2000,
            n_replicas=32,
            **asked,
        )
        for way in (1, -1)
    )
    error = np.hypot(one.force_standard_error, other.force_standard_error)
    assert np.abs((one.force + other.force) / error).max() < 4.0 and error.max() < 4e-3
