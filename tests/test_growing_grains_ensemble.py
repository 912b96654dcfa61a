"""Growing grains in the ensemble: its kernel against origins, breaks at a rate, and the law at each age."""

import numpy as np
import pytest
import scipy.stats

import eq_model
from eq_model.laws import growing
from origins import Contacts, Drive, Thermal, growing_grains
from origins.errors import InputError
from tests.lane_contacts import Lane

GRAINS = growing_grains(1.0, 1.0, age=4.0)
FIRST = GRAINS.growth.first_pinning_time


def test_hazard_and_quantile_of_the_compiled_kernel() -> None:
    root, since = np.sqrt(GRAINS.growth.B), np.geomspace(1e-6, 1e6, 25)
    for u in (1e-9, 1e-3, 0.3, 0.9, 1.0 - 1e-9):
        stretch = GRAINS.quantile(u, FIRST * (1.0 + since))
        goal = -np.log1p(-u)
        found = [growing.quantile(goal, age, root) for age in since]
        np.testing.assert_allclose(found, stretch, rtol=1e-9)
        # a threshold near the largest has lost what tells its hazard
        told = [growing.hazard(x, age, root) for x, age in zip(stretch, since, strict=True)]
        np.testing.assert_allclose(told, GRAINS.hazard(stretch, FIRST * (1.0 + since)), rtol=1e-6)


def test_a_contact_followed_breaks_where_its_hazard_is_met() -> None:
    """Pulled steadily from the first, after a rest, and turning round after it was pulled faster than it now is."""
    path, time = np.array([0.0, 0.5, 0.5, 6.0]), np.array([2.0, 2.1, 2.3, 13.3])
    lane, generator = Lane(Contacts(GRAINS), Drive(path, time=time)), np.random.default_rng(4)
    broken = 0
    for _ in range(50):
        x, u = generator.uniform(-0.4, 0.4), generator.random()
        first = float(GRAINS.hazard(abs(x), 4.0))
        threshold = float(GRAINS.quantile(-np.expm1(-first + np.log(u)), 4.0))
        goal = float(GRAINS.hazard(threshold, 4.0))
        then, there = lane.follow(x, threshold, 1.0, fresh=False)
        sample = np.linspace(0.0, min(then, 13.3), 4001)[:-1]
        stretch = np.abs(x + np.interp(sample, np.append(0.0, time), np.append(0.0, path)))
        assert (GRAINS.hazard(stretch, 4.0 + sample) < goal * (1.0 + 1e-9)).all()
        if then < np.inf:
            assert GRAINS.hazard(abs(there), 4.0 + then) == pytest.approx(goal, rel=1e-8)
            broken += 1
    assert broken > 20


@pytest.mark.parametrize("thermal", [Thermal("soft", 0.02, 3.0), Thermal("stiff", 1e-3, 30.0)])
def test_breaks_at_a_temperature_follow_the_rate_at_the_present_threshold(thermal: Thermal) -> None:
    """One contact, from pinning on, pulled, at rest and pulled back: the times of its breaks in many lives."""
    path, time = np.array([0.3, 0.3, -0.6]), np.array([0.4, 1.0, 2.2])
    goal, drive = 1.3, Drive(path, time=time)
    cold, lane = (Lane(Contacts(GRAINS, thermal=law), drive) for law in (None, thermal))
    until = min(cold.follow(0.0, 0.0, goal)[0], 2.2)
    found = [lane.follow(0.0, 0.0, goal, block=block)[0] for block in range(4000)]
    found = [at for at in found if at < until * (1.0 - 1e-12)]
    t = np.linspace(0.0, until, 200_001)
    middle = 0.5 * (t[1:] + t[:-1])
    stretch = np.abs(np.interp(middle, np.append(0.0, time), np.append(0.0, path)))
    threshold = GRAINS.quantile(-np.expm1(-goal), FIRST + middle)
    spent = np.append(0.0, np.cumsum(thermal.rate(np.minimum(stretch, threshold), threshold)) * t[1])
    share = -np.expm1(-spent[-1])
    assert 0.2 < share < 0.98 and abs(len(found) / 4000 - share) < 4.0 * np.sqrt(share * (1.0 - share) / 4000)
    assert scipy.stats.kstest(found, lambda at: -np.expm1(-np.interp(at, t, spent)) / share).pvalue > 1e-3


def test_thresholds_seen_in_the_ensemble_are_those_of_their_age() -> None:
    """At rest from pinning on nothing breaks: the histogram is that of the law at the age it has come to."""
    path, time, n = np.array([0.0, 0.0]), np.array([1.0, 5.0]), 100_000
    found = eq_model.simulate(Contacts(GRAINS), path, time=time, n_contacts=n, histograms=[0, 1])
    for point, age in enumerate((5.0, 9.0)):
        seen = found.histograms[point]
        share = np.cumsum(seen.thresholds * np.diff(seen.threshold_edges))
        assert np.abs(share - GRAINS.growth.thresholds(age).cdf(seen.threshold_edges[1:])).max() < 1.95 / np.sqrt(n)
    assert found.breaks == 0


@pytest.mark.parametrize(
    ("alpha", "density", "age", "to", "time", "match"),
    [
        (1.0, 1e30, 1.0, 2.0, 1.0, r"path\[-1\] = 2: lies 3.7e\+15 mean thresholds away"),
        (1e30, 1e30, 1e-89, 2.0, 1e90, r"stretches may reach 2.*e\+15 mean thresholds.* or other units"),
        (1.0, 1.0, 1e60, 1e20, 1e12, r"grains: each contact breaks about 3e\+12 times .* other units of time"),
    ],
)
def test_other_units_are_told_by_what_has_them(
    alpha: float, density: float, age: float, to: float, time: float, match: str
) -> None:
    contacts = Contacts(growing_grains(alpha, density, age=age))
    with pytest.raises(InputError, match=match):
        eq_model.simulate(contacts, [0.5 * to, to], time=[0.5 * time, time], n_contacts=10)
