"""Contacts on a soft slider with mass: against plain Python and scipy's integrator, exact motions and limits."""

import itertools

import numpy as np
import pytest
import scipy.stats
from conftest import slow
from plain_heavy import PlainSlider
from scipy.optimize import brentq
from solving import oscillator

import eq_model
import origins
from eq_model.compiling import compiled
from eq_model.coupled.mass.nearest import FAR, KNOWN, look_through, make_nearest, nearest, set_place

NARROW = origins.gaussian(1.0, 0.1)
ATOMS = origins.mixture([origins.identical(0.8), origins.identical(1.2)], [0.5, 0.5])
CONTACTS = {
    "narrow": origins.Contacts(NARROW),
    "stretched": origins.Contacts(NARROW, start=origins.gaussian_start(0.1, 0.1)),
    "linked": origins.Contacts(NARROW, stiffness="linked"),
    "atoms": origins.Contacts(ATOMS),
    "exponential": origins.Contacts(scipy.stats.expon()),
    "delayed": origins.Contacts(NARROW, delay=origins.Delay(0.3)),
}
# mass and damping: swings back and forth, hardly slips, creeps, rings (15 oscillations between two points), critical
MOTIONS = [(0.01, 0.0), (0.3, 0.05), (1e-3, 0.5), (1e-5, 1e-6), (0.1, 2.0 * (0.1 * 1.3) ** 0.5)]


def pulled(contacts, path, spring=0.3, mass=0.01, n=100, replicas=1, seed=3, **other):
    arguments = {"n_contacts": n, "n_replicas": replicas, "seed": seed} | other
    return eq_model.simulate(contacts, path, spring=spring, mass=mass, **arguments)


def slips_of(found):
    names = ["drive", "before", "after", "force_before", "force_after", "breaks", "duration"]
    return np.stack([getattr(found.slips, name) for name in names], axis=1)


def curves_of(found):
    names = ["position", "force", "holding", "velocity", "contact_force"]
    return np.stack([getattr(found, name) for name in names])


# one motion of each contacts, in turns, and all of those with a delay but the one that rings for seconds
RINGS = {
    (name, motion): pytest.mark.slow
    for number, name in enumerate(CONTACTS)
    for at, motion in enumerate(MOTIONS)
    if motion[0] == 1e-5 or (name != "delayed" and at != number % len(MOTIONS))
}


@pytest.mark.parametrize(
    "name, mass, damping",
    [
        pytest.param(name, *motion, marks=RINGS.get((name, motion), ()))
        for name in CONTACTS
        for motion in MOTIONS
    ],
)
def test_every_break_is_that_of_plain_python(name, mass, damping):
    contacts, path = CONTACTS[name], CONTACTS[name].mean_threshold * np.linspace(0.5, 5.5, 24)
    found = pulled(contacts, path, mass=mass, damping=damping)
    drive = origins.Drive(path, spring=0.3, mass=mass, damping=damping)
    plain = PlainSlider(contacts, drive, 100, 3).follow()
    assert found.breaks == plain.breaks > 100
    # returns are rounded to whole units of 2^-28 mean thresholds here, and double roots are off by 1e-8 there
    off = 1e-6
    assert np.abs(curves_of(found) - plain.curves)[[0, 1, 2, 4]].max() < off
    assert np.abs(found.velocity - plain.curves[3]).max() < off / mass**0.5
    assert slips_of(found).shape == plain.slips.shape
    assert np.abs(slips_of(found) - plain.slips).max(initial=0.0) < off
    assert np.abs(found.energy.imbalance).max() < 1e-12


def test_holds_and_changes_of_speed():
    path, time = [1.0, 4.0, 4.0, 7.0, 7.0], [1.0, 2.5, 5.0, 5.5, 8.0]
    for name in ("narrow", "delayed"):
        found = pulled(CONTACTS[name], path, time=time, damping=0.01)
        drive = origins.Drive(path, time=time, spring=0.3, mass=0.01, damping=0.01)
        plain = PlainSlider(CONTACTS[name], drive, 100, 3).follow()
        assert np.abs(curves_of(found) - plain.curves).max() < 1e-6
        assert np.abs(slips_of(found) - plain.slips).max() < 1e-6 and len(plain.slips) > 0


@pytest.mark.parametrize("number", [300, slow(1000)])
def test_a_plain_integrator_agrees_to_its_own_error(number):
    path, contacts = np.linspace(3.7, 4.1, 9), CONTACTS["narrow"]  # the first slip
    drive = origins.Drive(path, spring=0.3, mass=0.01, damping=0.05)
    found = pulled(contacts, path, damping=0.05, n=number)
    coarse, fine = (
        PlainSlider(contacts, drive, number, 3).integrate(tolerance) for tolerance in (1e-4, 1e-8)
    )
    own = np.abs(coarse - fine).max()
    assert 1e-7 < own < 1e-2 and found.position[-1] > 2.0
    assert np.abs(found.position - fine).max() < 1e-2 * own


@pytest.mark.parametrize("mass, damping", [(0.1, 0.0), (1e-3, 1e-3), (0.1, 3.0), (1e-16, 0.0)])
def test_without_breaks_it_is_an_oscillator(mass, damping):
    """From rest, in closed form by the roots of m r² + c r + S = 0; at 1e-16 through 1e7 oscillations."""
    spring, path = 0.5, np.linspace(0.01, 0.6, 60)
    found = pulled(origins.Contacts(origins.identical(1.0)), path, spring, mass, damping=damping)
    x, fastest = oscillator(path, spring, mass, damping)
    allowed = 1e-14 + 1e-15 * fastest * (mass / (spring + 1.0)) ** 0.5
    assert found.breaks == 0 and np.abs(found.position - x).max() < allowed
    assert np.abs(found.force - spring * (path - x)).max() < allowed


def test_identical_contacts_are_pieces_of_oscillators():
    """All break at once, one threshold behind or ahead of where they formed: undamped, by hand, over three slips.

    The slider sticks where the spring's force rises by 0.02 while no contact breaks.
    """
    spring, mass, path = 0.5, 0.2, [30.0]
    found = pulled(origins.Contacts(origins.identical(1.0)), path, spring, mass)
    own, drift = ((spring + 1.0) / mass) ** 0.5, spring / (spring + 1.0)
    t, birth, v = 0.0, 0.0, 0.0
    falls, begun, breaks, broken = [], None, 0, 0
    stuck, x = True, birth
    while len(falls) < 3 and t < 30.0:
        lowest = spring * (t - x)
        # about where forces balance, which moves with the drift
        u, du = x - (spring * t + birth) / (spring + 1.0), v - drift

        def moved(s):
            return drift * s + u * (np.cos(own * s) - 1.0) + du * np.sin(own * s) / own  # noqa: B023

        def speed(s):
            return drift - u * own * np.sin(own * s) + du * np.cos(own * s)  # noqa: B023

        times = np.arange(0.0, 40.0, 0.01)
        away = np.abs(x + moved(times) - birth) >= 1.0
        i = int(np.flatnonzero(away[1:])[0]) + 1
        side = np.sign(x + moved(times[i]) - birth)
        end = brentq(lambda s: side * (x + moved(s) - birth) - 1.0, times[i - 1], times[i])  # noqa: B023
        times = np.append(times[:i], end)
        fast = speed(times) > 1.0
        for j in np.flatnonzero(fast[1:] != fast[:-1]):
            at = brentq(lambda s: speed(s) - 1.0, times[j], times[j + 1])
            force = spring * (t + at - x - moved(at))
            if fast[j + 1]:
                begun, broken = (t + at, x + moved(at), force), 0
                continue
            if stuck and breaks and begun[2] - force >= 0.02:
                falls.append(
                    [*begun[:2], x + moved(at), begun[2], force, breaks, t + at - begun[0]]
                )
            stuck, begun, lowest = stuck and not breaks, None, force
        highest = begun[2] if begun else spring * (t + end - x - moved(end))
        if (begun is None or not broken) and highest - lowest >= 0.02:
            stuck, breaks = True, 0
        t, x, v, birth = t + end, birth + side, speed(end), birth + side
        breaks, broken = breaks + 100, broken + 100
    assert np.abs(slips_of(found)[:3] - falls[:3]).max() < 1e-9


@pytest.mark.parametrize("rule, delay", [("instant", None), ("reform-after", origins.Delay(0.5))])
def test_light_and_damped_sliders_follow_the_slip_rules(rule, delay):
    """Contact by contact: what is left is proportional to the damping; slips take that time, too."""
    contacts, path = origins.Contacts(NARROW, delay=delay), np.linspace(0.5, 9.0, 86)
    asked = {"spring": 0.7, "n_contacts": 300, "seed": 3}
    limit = eq_model.simulate(contacts, path, slip=rule, **asked)
    # the first slip from turn to turn, by points that are 1e-6 apart where it begins, and 1e-5 where it ends
    near, far = np.linspace(-0.02, 0.02, 40_001), np.linspace(-0.1, 0.1, 20_001)
    fine = limit.slips.drive[0] + np.union1d(near, far)
    trace = eq_model.simulate(contacts, fine, slip=rule, **asked).force
    top = int(np.argmax(trace))
    off, shifts = [], []
    for damping in (1e-4, 1e-5):
        found = eq_model.simulate(contacts, path, mass=1e-3 * damping**2, damping=damping, **asked)
        off.append(np.sort(np.abs(found.position - limit.position))[:-3].max())
        shifts.append(np.abs(found.slips.drive[0] - fine[top]))
        drop = found.slips.drop[0] / (trace[top] - trace[top:].min()) - 1.0
        assert abs(found.breaks - limit.breaks) <= 3 and abs(drop) < 20.0 * damping
    assert off[1] < 0.2 * off[0] < 1e-3 and shifts[1] < 0.2 * shifts[0] < 1e-4


def test_on_a_soft_spring_a_slip_is_half_an_oscillation():
    """F is F_k in the slip, so that the spring's force falls by 2 (F_s - F_k) in pi (M/K)^(1/2)."""
    pc = origins.gaussian(1.0, 0.2)
    kinetic = pc.moment(2) / (2.0 * pc.mean())
    off = []
    for spring in (1e-2, 1e-3):
        mass = 0.3
        found = pulled(origins.Contacts(pc), [1.0 / spring], spring, mass, n=4000)
        slip = found.slips
        drop = slip.drop[0] / (2.0 * (slip.force_before[0] - kinetic))
        time = slip.duration[0] / (np.pi * (mass / spring) ** 0.5)
        off.append(max(abs(drop - 1.0), abs(time - 1.0)))
        assert np.abs(found.energy.imbalance).max() < 1e-10
    damping = 1e-2 * (mass * spring) ** 0.5
    damped = pulled(
        origins.Contacts(pc), [1.0 / spring], spring, mass, n=4000, damping=damping
    ).slips
    assert off[1] < 0.5 * off[0] and off[1] < 0.02
    assert 0.9 < damped.drop[0] / slip.drop[0] < 1.0
    assert abs(damped.duration[0] / slip.duration[0] - 1.0) < 0.03


def test_replicas_are_the_same_one_by_one_on_threads_and_from_where_another_run_ended():
    path, contacts = np.linspace(0.0, 6.0, 31), CONTACTS["delayed"]
    asked = {"spring": 0.3, "mass": 0.01, "damping": 0.01, "n_contacts": 200, "n_replicas": 5}
    whole = eq_model.simulate(contacts, path, **asked)
    first = eq_model.Ensemble(contacts, path, **asked)
    for done, _ in first:
        if done >= 2 * 200:
            break
    rest = eq_model.Ensemble(contacts, path, **asked, earlier=[first.state])
    assert not first.result().success and list(rest)[-1] == (3 * 200, 3 * 200)
    for other in (rest.result(), eq_model.simulate(contacts, path, **asked, threads=3)):
        for name in ("forces", "positions", "velocities", "force_standard_error", "breaks"):
            assert np.all(getattr(other, name) == getattr(whole, name))
        assert (slips_of(other) == slips_of(whole)).all()
        assert (other.energy.drive == whole.energy.drive).all()
    assert len(whole.velocity_standard_error) == 31 and whole.velocities.shape == (5, 31)


@compiled
def _nearest_after(near, contacts, places, asked, found):  # type: ignore[no-untyped-def]
    """The nearest place after each change, or a bound; the place itself where it is asked for."""
    for k in range(contacts.size):
        set_place(near, contacts[k], places[k])
        found[k] = nearest(near)
        while asked[k] and near.at[KNOWN] == 0:
            look_through(near)
            found[k] = nearest(near)


@pytest.mark.parametrize("trend", [-30, 0, 30, 1000])
def test_the_nearest_of_changing_places(trend):
    """Places that come nearer fill the heap of those that came later; those that go away leave it behind."""
    rng, n, many = np.random.default_rng(5), 90, 20_000
    contacts = rng.integers(0, n, many)
    places = trend * np.arange(many) + rng.integers(0, 2000, many) * rng.integers(1, 40, many)
    places[rng.random(many) < 0.3] = FAR
    asked = (rng.random(many) < 0.5) & (np.arange(many) % 3000 > 800)
    found = np.zeros(many, np.int64)
    _nearest_after(make_nearest(n, 500.0), contacts, places, asked, found)
    now, least = np.full(n, FAR), np.zeros(many, np.int64)
    for k in range(many):
        now[contacts[k]] = places[k]
        least[k] = now.min()
    assert (found <= least).all() and (found[asked] == least[asked]).all() and asked.sum() > 5000


def test_energies_and_falls_of_light_sliders_beyond_critical_damping():
    """Where one contact returns while the slider is fast, and where the slider hardly moves against its damping. What
    a single contact takes from the force is no more than chance does."""
    one = origins.Contacts(origins.gaussian(1.0, 0.3), delay=origins.Delay(5e-6))
    found = pulled(one, [6000.0], 3e-4, 8e-12, n=1, damping=2.8e-5, velocity=400.0)
    assert found.slips.drop.size == 0 and found.avalanches.sum() > 5
    slow = pulled(CONTACTS["exponential"], [2.7], 0.16, 6e-7, damping=700.0, velocity=600.0)
    for result in (found, slow):
        assert np.abs(result.energy.imbalance).max() < 1e-10


def test_contacts_that_break_before_the_slider_is_as_fast_as_its_drive_belong_to_its_slip():
    """Identical thresholds and a delay beyond the path's time, in closed form.

    The slider rests at first: up to the break it moves by w t - (w/s) sin(s t), w = K v/S, s² = S/M. Then no contact
    holds, and it swings freely about the drive.
    """
    spring, mass, velocity, delay = 1e-2, 1.0, 50.0, origins.Delay(1e4)
    contacts = origins.Contacts(origins.identical(1.0), delay=delay)
    slips = pulled(contacts, [4000.0], spring, mass, velocity=velocity).slips
    drift, own = spring * velocity / (spring + 1.0), ((spring + 1.0) / mass) ** 0.5
    broken = brentq(lambda t: drift * t - drift / own * np.sin(own * t) - 1.0, 1e-3, 10.0)
    assert drift * (1.0 - np.cos(own * broken)) < 0.02 * velocity
    behind, free = velocity * broken - 1.0, (spring / mass) ** 0.5
    slower = velocity - drift * (1.0 - np.cos(own * broken))
    furthest = np.hypot(behind, slower / free)
    begin = broken + np.arctan2(slower / free, behind) / free
    assert slips.drive.size == 1 and slips.breaks[0] == 100
    found = [getattr(slips, name)[0] for name in ("drive", "drop", "duration", "top_speed")]
    exact = [velocity * begin, 2.0 * spring * furthest, np.pi / free, velocity + free * furthest]
    np.testing.assert_allclose(found, exact, rtol=1e-7)


def test_contacts_that_all_break_before_a_heavy_slider_is_fast_have_slipped():
    """The last ones break so slowly that the spring's force still rises. Then the slider swings freely about the drive,
    at which the damping takes the force γ v; the delay is longer than the path's time."""
    spring, mass, velocity, ratio = 0.36, 4.0, 0.36, 0.08
    damping = 2.0 * ratio * (spring * mass) ** 0.5
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2), delay=origins.Delay(70.0))
    drive = {"spring": spring, "mass": mass, "damping": damping, "velocity": velocity}
    slips = pulled(contacts, [20.0], n=2000, **drive).slips
    assert slips.drive.size == 1 and slips.breaks[0] > 400
    beyond = np.exp(-np.pi * ratio / (1.0 - ratio**2) ** 0.5)
    whole = (slips.force_before[0] - damping * velocity) * (1.0 + beyond)
    assert slips.drop[0] == pytest.approx(whole, rel=1e-3)  # a few contacts hold on as it begins


def test_rebounds_belong_to_the_slip_and_smooth_sliding_has_none():
    """Undamped, with a delay below a slip's time of 99, the slider swings to and fro, and contacts never hold it."""
    swings = origins.Contacts(NARROW, delay=origins.Delay(63.0))
    found = pulled(swings, np.linspace(0.0, 2e4, 2001), 1e-3, 1.0, n=1000)
    assert found.slips.drive.size == 1 and found.avalanches[0, 8:].sum() > 60
    after = found.path > found.slips.drive[0] + 100.0
    assert np.abs(found.velocity[after]).mean() > 5.0 and found.velocity[after].min() < -10.0
    # a longer delay than a slip: each slip is followed by a stick in which the drive moves on
    path = np.linspace(0.0, 2000.0, 4001)
    sticks = origins.Contacts(NARROW, delay=origins.Delay(50.0))
    found = pulled(sticks, path, 1e-2, 1.0, damping=0.02, n=1000)
    between = np.searchsorted(path, found.slips.drive)
    assert between.size > 8 and np.abs(np.diff(found.slips.drive[2:]) - 194.0).max() < 3.0
    for first, last in itertools.pairwise(between):
        assert np.abs(found.velocity[first:last]).min() < 0.1
    # so heavily damped that it creeps, with falls of the spring's force by chance
    smooth = pulled(CONTACTS["narrow"], [1500.0], 1e-2, 1e-4, n=500, damping=1.0)
    assert smooth.slips.drive.size == 0 and smooth.avalanches[0, 5:].sum() > 100


def test_a_light_slider_that_rings_five_billion_times_costs_nothing():
    """Undamped: before the slip at X = 1 in closed form, then breaks of the slip, then ringing on all contacts."""
    spring, mass, velocity = 1.25e-3, 1.05e-10, 2.3e-3
    contacts, path = origins.Contacts(origins.identical(1.0)), [700.0, 805.0, 1590.0]
    found = pulled(contacts, path, spring, mass, n=18, velocity=velocity)
    # without inertia the slider is at X_T K/(K + 1)
    assert found.position[0] == pytest.approx(700.0 * spring / (spring + 1.0), rel=1e-8)
    assert found.slips.before[0] == pytest.approx(1.0, abs=1e-6)
    assert found.slips.drive[0] == pytest.approx(1.0 + 1.0 / spring, rel=1e-6)
    assert found.slips.force_before[0] == pytest.approx(1.0, abs=1e-6)
    assert 18 * 700 < found.breaks < 18 * 1700
    assert np.abs(found.energy.imbalance).max() < 1e-12


@pytest.mark.parametrize(
    "law, spring, mass, damping, velocity, delay, path",
    [
        # a drive so fast that the slider has hardly moved: powers of a small time
        ("narrow", 19.3, 6741.0, 0.0, 9024.0, None, [1.0, 7.7]),
        ("narrow", 19.3, 6741.0, 34.5, 9024.0, 40.0, [1.0, 7.7]),
        # a damping so large that it has hardly relaxed
        ("narrow", 1.1, 923.0, 6.5e5, 518.0, None, [1.0, 3.6]),
        # light and undamped: 1e5 oscillations between two returns, and breaks where it turns
        ("narrow", 3e-3, 2.7e-9, 0.0, 0.008, 1.58, [1.0, 1000.0]),
        ("exponential", 2.5e-3, 4.2e-9, 0.0, 1e-3, 0.15, [1.0, 1000.0]),
        # near critical damping, on both sides of it
        ("narrow", 0.3, 0.01, 2.0 * 0.013**0.5 * (1.0 + 1e-5), 1.0, None, [1.0, 9.0]),
        ("delayed", 0.3, 0.01, 2.0 * 0.013**0.5 * (1.0 - 1e-5), 1.0, None, [1.0, 9.0]),
    ],
)
def test_energy_is_kept_in_the_corners(law, spring, mass, damping, velocity, delay, path):
    """To 1e-10 of the work of the drive at each point of the path."""
    contacts = CONTACTS[law]
    if delay is not None:
        contacts = origins.Contacts(contacts.thresholds, delay=origins.Delay(delay))
    found = pulled(contacts, path, spring, mass, n=10, damping=damping, velocity=velocity)
    assert found.energy.drive.shape == (1, 2) and (found.energy.drive > 0.0).all()
    assert np.abs(found.energy.imbalance).max() < 1e-10
