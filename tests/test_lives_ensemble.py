"""Contacts with laws of their own, on any path in time: the ensemble against single lives, exact results and itself."""

from typing import Any

import numpy as np
import pytest
import scipy.stats
from plain_life import life

import eq_model
import master
import origins
from eq_model.physics import STEP, STEP_ELSE
from origins import Ageing, Contacts, Delay, Drive, Thermal
from tests.lane_contacts import Lane
from tests.rate_laws import Tilted

GAUSSIAN = origins.gaussian(1.0, 0.2)
TURNING = np.concatenate([np.linspace(0.0, 1.3, 5), np.linspace(-0.9, 0.7, 4), [0.7]])
HOLDING = np.array([0.0, 0.9, 0.9, 1.2, 0.5, 0.5])
WHEN = np.array([0.0, 1.0, 40.0, 40.5, 43.0, 60.0])


# -- one contact -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["soft", "stiff"])
@pytest.mark.parametrize("temperature", [2e-3, 0.05, 20.0])
@pytest.mark.parametrize("stiffness", [1.0, 1.7])
def test_rate_its_integral_and_inverse_are_those_of_origins(law: Any, temperature: float, stiffness: float) -> None:
    from numba import njit

    thermal = Thermal(law, temperature, 3.0)
    own = thermal.rates.compiled()
    rate, passed, reached, most = (njit(one) for one in (own.rate, own.passed, own.reached, own.most))
    generator = np.random.default_rng(5)
    for _ in range(200):
        limit = generator.uniform(0.3, 1.7)
        near, far = np.sort(generator.uniform(0.0, limit, 2))
        expected = float(thermal.cumulative(far, limit, near, stiffness))
        assert passed(own.law, near, far, limit, stiffness) == pytest.approx(expected, rel=1e-9, abs=1e-300)
        there = float(thermal.rate(near, limit, stiffness))
        assert rate(own.law, near, limit, stiffness) == pytest.approx(there, rel=1e-9, abs=1e-300)
        assert there <= most(own.law, 0.5 * near, near, limit, 1.5 * limit, stiffness) * (1.0 + 1e-12) + 1e-300
        amount = expected * generator.uniform(0.05, 0.95)
        if amount > 1e-280:
            out = reached(own.law, np.log(amount), near, limit, stiffness)
            assert out == pytest.approx(float(thermal.inverse(amount, limit, near, stiffness)), abs=1e-8 * limit)


@pytest.mark.parametrize("thermal", [None, Thermal("soft", 0.05, 0.4), Thermal("stiff", 0.05, 0.4), Tilted(0.1, 0.4)])
@pytest.mark.parametrize(("path", "time"), [(TURNING, None), (HOLDING, WHEN)], ids=["turning", "holding"])
@pytest.mark.parametrize("stiffness", ["independent", "linked"])
def test_a_life_is_that_of_the_plain_twin(thermal: Any, path: Any, time: Any, stiffness: Any) -> None:
    """Also of a law that brings nothing compiled."""
    contacts, drive = Contacts(GAUSSIAN, thermal=thermal, stiffness=stiffness), Drive(path, time=time)
    lane, generator = Lane(contacts, drive), np.random.default_rng(8)
    end = lane.times[-1]
    for _ in range(60):
        born = generator.uniform(0.0, 0.7) * end
        x, threshold, bears = generator.uniform(-0.3, 0.3), generator.uniform(0.4, 1.4), generator.exponential()
        then, there = lane.follow(x, threshold, bears, born=born)
        when, stretch = life(contacts, drive, born, x, threshold, bears)
        assert np.isinf(then) == np.isinf(when)
        if not np.isinf(when):
            assert there == pytest.approx(stretch, abs=1e-8) and then == pytest.approx(when, abs=1e-7 * end)


@pytest.mark.parametrize("value", [0.3, 0.7, np.pi])
def test_what_reaches_its_threshold_has_broken_whatever_comes_later(value: float) -> None:
    """At a point, at a turn and where the slider stops alike, though rounding may leave it a unit short."""
    for breaks in (1, 2, 20, 37):
        for start in (0.0, 1.0 / 3.0, -0.2):
            contacts, turn = Contacts(origins.identical(value), start * value), (breaks - start) * value
            contacts, turn = Contacts(origins.identical(value), start * value), (breaks - start) * value
            # further points, and the force at all, in thresholds: backward it breaks again one threshold away
            for rest, force in (
                ([], [0.0]),
                ([-0.4], [0.0, -0.4]),
                ([-1.0], [0.0, 0.0]),
                ([-1.0, -0.9], [0.0, 0.0, 0.1]),
                ([0.0, 0.1], [0.0, 0.0, 0.1]),
            ):
                path, time = turn + value * np.array([0.0, *rest]), np.arange(1.0, len(force) + 1.0)
                found = eq_model.simulate(contacts, path, n_contacts=1, time=time)
                assert np.abs(found.force - value * np.array(force)).max() < 1e-6 * value


# -- many ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_cold_contacts_break_at_their_thresholds(law: Any) -> None:
    """Steadily forward as on a path in time, where barriers are beyond all that breaks by themselves."""
    # a path that turns in the end, and one contact at a time, so that both go the same way through the same draws
    path, thresholds = np.append(np.linspace(0.1, 3.0, 12), 2.9), origins.lubricated(1.0)

    def forces(**laws: Any) -> np.ndarray:
        contacts = Contacts(thresholds, **laws)
        return np.array([eq_model.simulate(contacts, path, n_contacts=1, seed=seed).force for seed in range(60)])

    cold = forces()
    for temperature in (1e-5, 1e-7, 1e-12, 1e-19):
        assert np.abs(forces(thermal=Thermal(law, temperature)) - cold).max() < 1e-9
    with pytest.raises(origins.InputError, match=r"thermal.temperature = 1e-21: is .*: leave thermal out"):
        Contacts(thresholds, thermal=Thermal(law, 1e-21))


def test_the_result_does_not_depend_on_threads() -> None:
    contacts = Contacts(
        GAUSSIAN,
        origins.gaussian_start(0.0, 0.2),
        thermal=Thermal("stiff", 0.05),
        delay=Delay(0.2),
        reforming=origins.gaussian_start(0.0, 0.3),
        stiffness="linked",
    )
    arguments: dict[str, Any] = {"n_contacts": 20_700, "n_replicas": 3, "seed": 3, "histograms": [2, -1]}
    whole = eq_model.simulate(contacts, TURNING, **arguments)
    found = eq_model.simulate(contacts, TURNING, **arguments, threads=3)
    for name in ("force", "force_standard_error", "holding"):
        assert np.array_equal(getattr(found, name), getattr(whole, name))
    assert found.breaks == whole.breaks > 0
    for one, other in zip(found.histograms, whole.histograms, strict=True):
        assert np.array_equal(one.stretches, other.stretches) and np.array_equal(one.thresholds, other.thresholds)
        assert one.count == round(found.holding[one.point] * 62_100)
    # to ask for histograms changes no draw
    without = eq_model.simulate(contacts, TURNING, **arguments | {"histograms": ()})
    assert np.array_equal(without.force, whole.force)


@pytest.mark.parametrize(
    ("thresholds", "reforming"),
    [
        (origins.gaussian(1.0, 0.05), 1.42),
        (GAUSSIAN, 8.2),
        (GAUSSIAN, origins.gaussian_start(2.7, 0.2)),
        (scipy.stats.beta(1.5, 10.0), 0.95),
    ],
    ids=["2^-54", "1e-285", "spread", "thin end"],
)
def test_contacts_form_again_where_next_to_no_threshold_lies_beyond(thresholds: Any, reforming: Any) -> None:
    contacts, path = Contacts(thresholds, reforming=reforming), np.linspace(0.0, 1.5, 7)[1:]
    known, found = master.solve(contacts, path), eq_model.simulate(contacts, path, n_contacts=1000)
    assert known.success and found.breaks > 10 * 1000
    error = np.hypot(found.force_standard_error, known.force_error)
    assert (np.abs(found.force - known.force) < 4.5 * error).all()


@pytest.mark.parametrize(
    ("thresholds", "reforming", "told"),
    [
        (GAUSSIAN, 8.5, "the survival of the thresholds is below 1e-290; use stretches .* below 8.28415"),
        (origins.gaussian(1.0, 0.01), origins.boltzmann_reforming(0.05), "below 1e-290; use .* below 1.36"),
        (origins.rectangular(0.5, 1.0), 1.0 - 1e-12, "half of the contacts break again within 5e-13"),
    ],
)
def test_forming_again_where_no_answer_is_told(thresholds: Any, reforming: Any, told: str) -> None:
    with pytest.raises(origins.InputError, match=f"^reforming: .*{told}") as refusal:
        eq_model.simulate(Contacts(thresholds, reforming=reforming), [0.0, 1.0], n_contacts=10)
    assert "\n" not in str(refusal.value) and "start" not in str(refusal.value)


def test_the_steady_state_holds_length_biased_thresholds() -> None:
    """P_xs = x P_c/<x_s> and Q_s = S/C, once all but 2e-5 of the first contacts have broken."""
    law = origins.gw_elastic(1.0)
    run = eq_model.simulate(Contacts(law), [6.0], n_contacts=10_000_000, histograms=[0])
    (found,) = run.histograms
    x = np.linspace(0.0, float(found.threshold_edges[-1]), 40_001)
    middle = 0.5 * (x[1:] + x[:-1])
    biased, held = (np.cumsum(part) * x[1] / law.mean() for part in (middle * law.pdf(middle), law.sf(middle)))
    for counts, edges, exact in (
        (found.thresholds, found.threshold_edges, biased),
        (found.stretches, found.stretch_edges, held),
    ):
        below = np.cumsum(counts) * np.diff(edges)
        distance = np.abs(below - np.interp(edges[1:], x[1:], exact, left=0.0)).max()
        assert scipy.stats.kstwobign.sf(distance * np.sqrt(found.count)) > 1e-3


def test_histograms_of_wide_laws_tell_where_contacts_are() -> None:
    """Bins are fine where most contacts are, and what lies beyond is in the last ones: all edges are told."""
    law, n = scipy.stats.lomax(3.0), 400_000
    run = eq_model.simulate(Contacts(law), [1e-9, 5.0], n_contacts=n, histograms=[0, 1])
    for found in run.histograms:
        assert found.stretch_edges[[0, -1]] == pytest.approx([-5.05, 5.05]) and found.threshold_edges[-1] > 1e5
        weights = found.thresholds * np.diff(found.threshold_edges)
        assert (np.diff(found.threshold_edges)[:-1] < 0.01).all() and 0.0 < weights[-1] < 1e-3
        shares = found.stretches * np.diff(found.stretch_edges)
        assert shares.sum() == pytest.approx(1.0) and weights.sum() == pytest.approx(1.0)
        middle = 0.5 * (found.stretch_edges[1:] + found.stretch_edges[:-1])
        assert abs((shares * middle).sum() - run.force[found.point]) < 0.5 * 10.1 / shares.size
    fresh, worn = run.histograms
    seen = np.cumsum(fresh.thresholds * np.diff(fresh.threshold_edges))
    assert np.abs(seen - law.cdf(fresh.threshold_edges[1:])).max() < 1.95 / np.sqrt(n)
    assert (worn.stretches > 0.0).sum() > 1500


@pytest.mark.parametrize("final", [origins.gaussian(1.0, 0.1), origins.lubricated(0.8)])
def test_the_error_of_the_steps_of_ageing_is_told(final: origins.Thresholds, monkeypatch: pytest.MonkeyPatch) -> None:
    contacts, path = Contacts(origins.gaussian(0.5, 0.1), ageing=Ageing(final, 0.01)), np.linspace(0.25, 3.0, 12)
    exact = master.solve(contacts, path, tolerance=1e-5).force
    for longer in (1.0, 4.0):
        monkeypatch.setattr("eq_model.physics.STEP", longer * STEP)
        monkeypatch.setattr("eq_model.physics.STEP_ELSE", longer * STEP_ELSE)
        found = eq_model.simulate(contacts, path, n_contacts=40_000, seed=5)
        off = np.abs(found.force - exact)
        assert (off < found.step_error + 4.5 * found.force_standard_error).all()
        assert (found.step_error < 2.0 * longer * found.force_standard_error.max()).all()


@pytest.mark.parametrize("diffusion", [0.1, 3.0])
def test_thresholds_that_outgrow_all_fresh_ones_have_bins(diffusion: float) -> None:
    """Left alone, thresholds are those of the Ornstein-Uhlenbeck process; nothing breaks."""
    final = origins.gaussian(3.0, 0.3)
    run = eq_model.simulate(
        Contacts(origins.gaussian(0.5, 0.05), ageing=Ageing(final, diffusion)),
        [0.0, 0.0],
        time=[0.02, 2.0],
        n_contacts=20_000,
        histograms=[1],
    )
    (found,) = run.histograms
    process = Ageing(final, diffusion).normal
    assert process is not None and run.breaks == 0
    below = np.cumsum(found.thresholds * np.diff(found.threshold_edges))
    edges, sure = found.threshold_edges[1:], np.exp(-process.rate * 2.0)
    width = np.hypot(process.std_after(2.0), 0.05 * sure)
    exact = scipy.stats.norm.cdf((edges - process.mean_after(0.5, 2.0)) / width)
    assert np.abs(below - exact).max() < 1.95 / np.sqrt(20_000)


def test_heavy_tails_are_followed_where_linked_stiffness_does_not_add_to_them() -> None:
    law, path = scipy.stats.pareto(2.5), np.array([1.5, 2.0, 1.0, -1.0, 2.0])
    run, exact = eq_model.simulate(Contacts(law), path), master.solve(Contacts(law), path, 1e-5)
    assert exact.success and (np.abs(run.force - exact.force) < 4.5 * run.force_standard_error + 2e-5).all()
    with pytest.raises(origins.InputError, match=r"thresholds: stretches may reach .* use thresholds with a shorter"):
        eq_model.simulate(Contacts(law, stiffness="linked"), path)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"histograms": [5]}, "histograms"),
        ({"histograms": [0.5]}, "histograms"),
        ({"contacts": Contacts(GAUSSIAN, thermal=Thermal("soft", 0.1, closure="paper"))}, "thermal"),
        ({"contacts": Contacts(GAUSSIAN, ageing=Ageing(GAUSSIAN, 0.1, closure="paper"))}, "ageing"),
        ({"contacts": Contacts(GAUSSIAN, thermal=Thermal("soft", 1.0, 1e12))}, "each contact breaks about 1e.12 times"),
        ({"contacts": Contacts(GAUSSIAN, ageing=Ageing(GAUSSIAN, 1.0)), "time": [1.0, 1e12, 2e12]}, "ageing: .* steps"),
        ({"velocity": -1.0}, "velocity"),
        ({"time": [0.0, 1.0, 0.5]}, "time"),
        ({"comm": 3}, "^comm = 3: must be a communicator of mpi4py"),
    ],
)
def test_bad_input_is_refused_by_name(change: dict[str, Any], complaint: str) -> None:
    arguments: dict[str, Any] = {"contacts": Contacts(GAUSSIAN), "path": [0.0, 1.0, 2.0], "n_contacts": 10, **change}
    with pytest.raises(origins.InputError, match=complaint):
        eq_model.simulate(**arguments)


def test_a_tolerance_out_of_all_reach_is_told() -> None:
    for contacts, tolerance, told in ((10, 1e-200, "more than 1.4e+11"), (10, 1e-300, "more than"), (1, 0.1, "two")):
        run = eq_model.simulate(Contacts(GAUSSIAN), [1.0], n_contacts=contacts, tolerance=tolerance)
        assert not run.success and told in run.message


@pytest.mark.parametrize("final", [origins.gaussian(0.9, 0.1), scipy.stats.uniform(0.1, 1.4)])
@pytest.mark.parametrize("thermal", [None, Thermal("soft", 0.1, 1.0)])
def test_histograms_of_ageing_change_no_draw_and_are_those_of_a_shorter_drive(final: Any, thermal: Any) -> None:
    """Between two steps thresholds are drawn from a bridge; at the end of a drive each step ends."""
    contacts = Contacts(origins.rectangular(0.4, 0.9), 0.1, thermal, Ageing(final, 0.1))
    path, n = np.array([0.3, 0.313, 0.7, 1.5]), 40_000
    asked: dict[str, Any] = {"n_contacts": n, "seed": 5}
    whole = eq_model.simulate(contacts, path, **asked, histograms=[0, 1, 2])
    without = eq_model.simulate(contacts, path, **asked)
    assert np.array_equal(whole.force, without.force) and whole.breaks == without.breaks
    for k, found in enumerate(whole.histograms):
        short = eq_model.simulate(contacts, path[: k + 1], n_contacts=n, seed=6, histograms=[-1]).histograms[0]
        assert found.count == n
        for name, edges in (("stretches", "stretch_edges"), ("thresholds", "threshold_edges")):
            one, other = (np.cumsum(getattr(h, name) * np.diff(getattr(h, edges))) for h in (found, short))
            apart = one - np.interp(getattr(found, edges)[1:], getattr(short, edges)[1:], other)
            assert np.abs(apart).max() < 2.2 * np.sqrt(2.0 / n)
