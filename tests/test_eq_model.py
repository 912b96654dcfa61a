"""The ensemble against exact results and its own statistics; cut short, and gone on with."""

from itertools import islice
from typing import Any

import numpy as np
import pytest
import scipy.stats
from conftest import slow
from scipy.special import ndtr
from solving import same_bits

import eq_model
import origins
from origins import Ageing, Contacts, Delay, Thermal

NARROW, GAUSSIAN = origins.gaussian(1.0, 0.05), origins.gaussian(1.0, 0.2)
GAP = origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7])
ATOMS = origins.mixture([origins.identical(0.95), origins.identical(1.05)], [0.3, 0.7])
START = origins.gaussian_start(mean=0.1, std=0.025)
GRAINS = origins.growing_grains(1.0, 1.0, age=4.0)
TURNING = np.concatenate([np.linspace(0.0, 1.3, 5), np.linspace(-0.9, 0.7, 4), [0.7]])
SOFT, STIFF = Thermal("soft", 0.05, 0.4), Thermal("stiff", 0.05, 0.4)

# -- exact results -----------------------------------------------------------------------------------

DRAWN: dict[str, Any] = {
    "narrow": origins.gaussian(1.0, 1e-3),
    "chord": origins.gaussian(1.0, 0.05, form="paper", upper=2.0),
    "onset 1/3, large": origins.gw_elastic(1e12),
    "gw_gaussian mixed": origins.gw_gaussian(0.5, 1.0, "amontons", "mixed", 9.0),
    "persson": origins.persson(1.0, 0.3),
    "grains, printed": origins.grains(1.0, B=1.0, jacobian="paper"),
    "gap": GAP,
    "heavy tail": scipy.stats.pareto(1.5),
    "singular ends": scipy.stats.beta(0.5, 0.5),
    "samples": origins.from_samples(np.random.default_rng(0).gamma(3.0, size=1000)),
    "growing grains": GRAINS,
}


@pytest.mark.parametrize("name", [slow(name, when=name == "growing grains") for name in DRAWN])
def test_thresholds_are_drawn_from_their_law(name: str) -> None:
    """Kolmogorov and Smirnov's distance of those of a million contacts, and both tails, where bins tell them."""
    contacts, n = Contacts(DRAWN[name]), 1_000_000
    path = 1e-9 * contacts.mean_threshold
    (found,) = eq_model.simulate(contacts, path, n_contacts=n, seed=2, histograms=[0]).histograms
    below = np.cumsum(found.thresholds * np.diff(found.threshold_edges))
    cdf = contacts.thresholds.cdf(found.threshold_edges[1:])
    assert np.abs(below - cdf).max() < 1.95 / np.sqrt(n)  # the 0.1 % level
    for share, exact in ((below, cdf), (1.0 - below, 1.0 - cdf)):
        rare = (exact > 3e-5) & (exact < 1e-3)
        assert (np.abs(share - exact)[rare] < 5.0 * np.sqrt(exact[rare] / n)).all()


def test_exact_values_come_out_exact() -> None:
    """Two by their shares; one in the force itself, also where breaks fall on the path's points."""
    (found,) = eq_model.simulate(
        Contacts(ATOMS), 1e-9, n_contacts=200_000, histograms=[0]
    ).histograms
    shares = (found.thresholds * np.diff(found.threshold_edges))[found.thresholds > 0.0]
    assert shares.size == 2 and abs(shares[0] - 0.3) < 5.0 * np.sqrt(0.21 / 200_000)
    path = np.linspace(0.0, 50.0, 501)
    run = eq_model.simulate(Contacts(origins.identical(1.0)), path, n_contacts=10)
    assert np.abs(run.force - path + np.floor(path + 1e-9)).max() < 1e-11
    assert (run.force_standard_error == 0.0).all() and run.breaks == 500
    shifted = eq_model.simulate(Contacts(origins.identical(0.95), start=0.4), path, n_contacts=10)
    exact = path + 0.4 - 0.95 * np.floor((path + 0.4) / 0.95 + 1e-9)
    assert np.abs(shifted.force - exact).max() < 1e-11


@pytest.mark.parametrize("value", [0.3, np.pi])
def test_what_reaches_its_threshold_has_broken_whatever_comes_later(value: float) -> None:
    """At a point, at a turn and where the slider stops alike, though rounding may leave it a unit short."""
    later = [
        ([], [0.0]),
        ([-0.4], [0.0, -0.4]),
        ([-1.0, -0.9], [0.0, 0.0, 0.1]),
        ([0.0, 0.1], [0.0, 0.0, 0.1]),
    ]
    for breaks in (1, 2, 37):
        for start in (0.0, 1.0 / 3.0, -0.2):
            contacts = Contacts(origins.identical(value), start * value)
            turn = (breaks - start) * value
            # further points, and the force at all, in thresholds: backward it breaks again one threshold away
            for rest, force in later:
                path, time = turn + value * np.array([0.0, *rest]), np.arange(1.0, len(force) + 1.0)
                found = eq_model.simulate(contacts, path, n_contacts=1, time=time)
                assert np.abs(found.force - value * np.array(force)).max() < 1e-6 * value


def test_the_steady_state_holds_length_biased_thresholds() -> None:
    """P_xs = x P_c/<x_s> and Q_s = S/C; breaks as renewal theory counts them."""
    law, n = origins.gw_elastic(1.0), 1_000_000
    run = eq_model.simulate(Contacts(law), [40.0], n_contacts=n, histograms=[0])
    (found,) = run.histograms
    x = np.linspace(0.0, float(found.threshold_edges[-1]), 40_001)
    middle = 0.5 * (x[1:] + x[:-1])
    biased, held = (
        np.cumsum(part) * x[1] / law.mean() for part in (middle * law.pdf(middle), law.sf(middle))
    )
    for counts, edges, exact in (
        (found.thresholds, found.threshold_edges, biased),
        (found.stretches, found.stretch_edges, held),
    ):
        distance = np.abs(
            np.cumsum(counts) * np.diff(edges) - np.interp(edges[1:], x[1:], exact, left=0.0)
        )
        assert distance.max() < 1.95 / np.sqrt(n)
    off = run.force[0] - law.moment(2) / (2.0 * law.mean())
    assert abs(off) < 5.0 * run.force_standard_error[0]
    # one break per mean threshold, (cv² - 1)/2 of them late
    spread = law.std() / law.mean()
    expected = 40.0 / law.mean() + (spread**2 - 1.0) / 2.0
    assert abs(run.breaks / n - expected) < 5.0 * spread * np.sqrt(40.0 / law.mean() / n)


@pytest.mark.parametrize("far", [False, True])
def test_ages_are_those_of_the_laws_at_rest(far: bool) -> None:
    """Left alone, thresholds are those of the Ornstein-Uhlenbeck process, or of grains of that age; nothing breaks."""
    n, time = 30_000, np.array([1.0, 5.0])
    ageing = Ageing(origins.gaussian(3.0, 0.3), 3.0 if far else 0.01)
    aged = Contacts(origins.gaussian(0.5, 0.05), ageing=ageing)
    process = ageing.normal
    width = np.hypot(process.std_after(5.0), 0.05 * np.exp(-process.rate * 5.0))
    normal = scipy.stats.norm(process.mean_after(0.5, 5.0), width)
    for contacts, law in ((aged, normal), (Contacts(GRAINS), GRAINS.growth.thresholds(9.0))):
        run = eq_model.simulate(contacts, [0.0, 0.0], time=time, n_contacts=n, histograms=[1])
        (found,) = run.histograms
        below = np.cumsum(found.thresholds * np.diff(found.threshold_edges))
        assert run.breaks == 0
        assert np.abs(below - law.cdf(found.threshold_edges[1:])).max() < 1.95 / np.sqrt(n)


# -- the ensemble as a whole --------------------------------------------------------------------------

ALL = Contacts(GAUSSIAN, START, STIFF, None, Delay(0.2), origins.gaussian_start(0.0, 0.3), "linked")
AGED = Contacts(origins.rectangular(0.4, 0.9), 0.1, SOFT, Ageing(origins.gaussian(0.9, 0.1), 0.1))
STRONG = Contacts(origins.strengthening(GAUSSIAN, 0.1, 2.0, age=3.0), START, SOFT)
FORWARD = np.concatenate([[0.0], 3.0 + 1e-9 * np.arange(5), np.linspace(3.1, 7.0, 20)])


@pytest.mark.parametrize(
    ("contacts", "path"),
    [(Contacts(GAP, START), FORWARD), (ALL, TURNING), slow(AGED, TURNING), (STRONG, TURNING)],
    ids=["forward", "all", "aged", "strengthening"],
)
def test_bits_hang_on_no_threads_nor_histograms(contacts: Contacts, path: np.ndarray) -> None:
    n = 300 if contacts.laws and contacts is not ALL else 20_700
    asked: dict[str, Any] = {"n_contacts": n, "n_replicas": 3, "seed": 11}
    whole = eq_model.simulate(contacts, path, **asked)
    counted = eq_model.simulate(contacts, path, **asked, histograms=[3, -1])
    same_bits(counted, whole, "histograms")
    threaded = eq_model.simulate(contacts, path, **asked, histograms=[2, -1], threads=3)
    same_bits(threaded, eq_model.simulate(contacts, path, **asked, histograms=[2, -1]))
    for found in threaded.histograms:
        shares, edges = found.stretches * np.diff(found.stretch_edges), found.stretch_edges
        assert shares.sum() == pytest.approx(whole.holding[found.point])
        assert found.count == round(3 * n * whole.holding[found.point])
        if contacts.stiffness == "independent":
            mean = (shares * 0.5 * (edges[1:] + edges[:-1])).sum()
            assert abs(mean - whole.force[found.point]) < np.diff(edges).max()
    other = eq_model.simulate(contacts, path, **asked | {"seed": 12})
    assert not np.array_equal(other.force, whole.force)


def test_error_from_the_variance_between_contacts() -> None:
    """Two contacts whose stretches are known by the histogram; and steady sliding after a million breaks."""
    contacts = Contacts(NARROW, start=origins.gaussian_start(mean=0.0, std=0.1))
    pair = eq_model.simulate(contacts, 0.0, n_contacts=2, seed=4, histograms=[0])
    (found,) = pair.histograms
    low, high = (0.5 * (found.stretch_edges[1:] + found.stretch_edges[:-1]))[found.stretches > 0.0]
    width = float(np.diff(found.stretch_edges)[1])
    assert abs(pair.force[0] - 0.5 * (low + high)) < width
    assert abs(pair.force_standard_error[0] - (high - low) / 2.0) < width
    assert eq_model.simulate(contacts, 0.0, n_contacts=1).force_standard_error[0] == np.inf
    far = eq_model.simulate(Contacts(origins.rectangular(0.5, 1.5)), 3e4, n_contacts=400)
    exact = np.sqrt((1.25 / 3.0 - (13.0 / 24.0) ** 2) / 400.0)
    assert far.breaks > 1e7 and far.force_standard_error[0] == pytest.approx(exact, rel=0.15)
    assert abs(far.force[0] - 13.0 / 24.0) < 5.0 * exact


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_scaling_all_lengths_changes_the_scale_only(factor: float) -> None:
    path, asked = np.linspace(0.0, 3.0, 31), {"n_contacts": 2000}
    base = eq_model.simulate(Contacts(NARROW, START), path, **asked)
    law = origins.gaussian(factor, 0.05 * factor)
    start = origins.gaussian_start(0.1 * factor, 0.025 * factor)
    scaled = eq_model.simulate(Contacts(law, start), path * factor, **asked)
    assert np.abs(scaled.force / factor - base.force).max() < 1e-9
    assert np.abs(scaled.force_standard_error / factor - base.force_standard_error).max() < 1e-9
    assert scaled.breaks == base.breaks


def test_the_ends_of_sharp_drops_are_in_the_error() -> None:
    """Where all contacts but one in a thousand have broken, or none but one, most ensembles see no such contact."""
    path, width = 1.0 + np.linspace(-5e-3, 5e-3, 21), 1e-3
    z = (path - 1.0) / width
    exact = path - ndtr(z) + width * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
    for n in (100, 3000):
        for back in ([], [0.5]):
            asked = np.concatenate([path, back])
            contacts = Contacts(origins.gaussian(1.0, width))
            runs = [
                eq_model.simulate(contacts, asked, n_contacts=n, seed=seed) for seed in range(40)
            ]
            off = [
                (run.force[:21] - exact) / np.hypot(run.force_standard_error[:21], 1e-9)
                for run in runs
            ]
            # a break that is seen in one of ten ensembles is three times its claim away in that one
            assert np.abs(off).max() < 9.0 and (np.square(off).mean(axis=0) < 3.0).all()
    assert 0.7 < np.square(off)[:, 9:12].mean() < 1.4  # where there are many it is not too large


# -- cut short, and gone on with ----------------------------------------------------------------------

PATH = np.linspace(0.0, 3.0, 7)


def followed(ensemble: eq_model.Ensemble) -> eq_model.EnsembleResult:
    for _ in ensemble:
        pass
    return ensemble.result()


@pytest.mark.parametrize(
    "contacts",
    [Contacts(NARROW, START), Contacts(NARROW, delay=Delay(0.2))],
    ids=["plain", "delay"],
)
def test_gone_on_with_twice_it_is_the_uninterrupted_one(contacts: Contacts) -> None:
    asked: dict[str, Any] = {"n_contacts": 100_000, "seed": 4}
    whole = followed(eq_model.Ensemble(contacts, PATH, **asked))
    first = eq_model.Ensemble(contacts, PATH, **asked)
    assert len(list(islice(first, 2))) == 2
    part = first.result()
    assert 0 < part.contacts < 100_000 and not part.success and "stopped" in part.message
    second = eq_model.Ensemble(contacts, PATH, **asked, earlier=[first.state])
    ((done, total),) = islice(second, 1)
    # only what was missing is done again
    assert total == 100_000 - part.contacts and 0 < done < total
    same_bits(followed(eq_model.Ensemble(contacts, PATH, **asked, earlier=[second.state])), whole)
    for other in ([1.0, 2.0], PATH[1:]):  # the second has as many bins
        with pytest.raises(origins.InputError, match="another path"):
            eq_model.Ensemble(contacts, other, **asked, earlier=[first.state])


@pytest.mark.parametrize(("path", "time"), [(0.0, None), ([0.0, 0.0], [1.0, 2.0])])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_slider_that_stays_where_it_is(path: Any, time: Any) -> None:
    run = eq_model.simulate(Contacts(NARROW), path, time=time, n_contacts=10)
    assert (run.force == 0.0).all() and run.breaks == 0


def test_it_stops_where_the_tolerance_is_reached() -> None:
    """Also where it was cut short in the round before: what was not enough is not judged again."""
    asked: dict[str, Any] = {"n_contacts": 2_000_000, "tolerance": 1.15e-3}
    contacts = Contacts(origins.gaussian(1.0, 0.1), origins.gaussian_start(0.0, 0.1))
    run = eq_model.simulate(contacts, PATH, **asked)
    assert run.success and "within the tolerance" in run.message and run.contacts < 2_000_000
    assert 1.15e-3 / 2.0 < run.force_standard_error.max() <= 1.15e-3
    for blocks in (1, 3, 6):
        first = eq_model.Ensemble(contacts, PATH, **asked)
        list(islice(first, blocks))
        same_bits(followed(eq_model.Ensemble(contacts, PATH, **asked, earlier=[first.state])), run)
    beyond = eq_model.simulate(Contacts(GAUSSIAN), [1.0], n_contacts=10, tolerance=1e-200)
    assert not beyond.success and "more than 1.4e+11" in beyond.message


def test_no_block_begins_after_the_wall_time() -> None:
    """No block at all would be no result; what takes long begins with few contacts."""
    contacts = Contacts(NARROW, delay=Delay(0.2))
    first = next(iter(eq_model.Ensemble(contacts, PATH, n_contacts=10_000_000)))[0]
    found = eq_model.simulate(contacts, PATH, n_contacts=10_000_000, wall_time=1e-9)
    assert found.contacts == first and not found.success and "stopped before all" in found.message
    hot = Contacts(NARROW, thermal=Thermal("soft", 0.5, 1e7))
    assert eq_model.simulate(hot, 0.2, n_contacts=1000, wall_time=1e-9).contacts <= 4


def test_compilation_is_not_in_the_run_time(python: Any) -> None:
    """In a process of its own, by a clock that only moves while something is compiled, or read back as it was."""
    done = python("""
import eq_model, origins
from eq_model import lanes
eq_model.Ensemble.clock = staticmethod(lambda: float(len(lanes.follow.signatures)))
run = eq_model.simulate(origins.Contacts(origins.gaussian(1.0, 0.05)), 2.0, n_contacts=100)
print(run.breaks > 0, run.compile_time, run.run_time)
""")
    assert done.stdout.split() == ["True", "1.0", "0.0"], (done.stdout, done.stderr)


def test_points_closer_than_the_unit_of_whole_lengths() -> None:
    """A path of 1e-29 of a threshold, on which nothing breaks."""
    path = np.linspace(0.0, 5.0, 11)
    found = eq_model.simulate(Contacts(origins.identical(1e30)), path, n_contacts=10)
    np.testing.assert_allclose(found.force, path, rtol=1e-12)
    assert found.breaks == 0


def test_few_contacts_form_one_delay_after_they_broke_by_hand() -> None:
    """Equal ones break each 1 + 0.3 of the way; where the slider turns at 1.1 they form at 0.9, on its way back."""
    late = Contacts(origins.identical(1.0), delay=Delay(0.15))
    path = np.array([0.9, 1.2, 1.31, 2.2, 2.5, 2.61, 3.5])
    found = eq_model.simulate(late, path, velocity=2.0, n_contacts=3)
    np.testing.assert_allclose(found.force, [0.9, 0.0, 0.01, 0.9, 0.0, 0.01, 0.9], atol=1e-7)
    np.testing.assert_array_equal(found.holding, [1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0])
    path = np.array([1.1, 0.91, 0.89, -0.09, -0.11, -0.39, -0.41])
    back = eq_model.simulate(late, path, velocity=2.0, n_contacts=3)
    np.testing.assert_allclose(back.force, [0.0, 0.0, -0.01, -0.99, 0.0, 0.0, -0.01], atol=1e-7)
    np.testing.assert_array_equal(back.holding, [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0])


@pytest.mark.parametrize("std", [2.5e-6, 2.5e-7, 1e-12])
def test_starts_whose_width_is_lost_in_rounding_have_an_error_nevertheless(std: float) -> None:
    contacts = Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, std))
    path = np.linspace(0.0, 0.5, 4)
    found = eq_model.simulate(contacts, path, n_contacts=5000, seed=1)
    assert found.breaks == 0  # so that F - X is the mean start
    assert (np.abs(found.force - path) < 5.0 * found.force_standard_error + 1e-15).all()
    assert (found.force_standard_error < max(std, 1e-7)).all()
