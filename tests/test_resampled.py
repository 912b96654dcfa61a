"""What other samples would give of contacts with laws in time: F_k of contacts as hot and as old as those asked for."""

from typing import Any

import numpy as np
import pytest

import master
import origins
from origins.laws.strengthening import Strengthening
from origins.thresholds.law import Array
from toolkit.judge import describe
from toolkit.running.resampled import like

WIDTH, ATTEMPTS = 0.1, 1e5  # of eyring heat: F_k is a ninth of that without
X_S = np.random.default_rng(1).uniform(0.2, 1.8, 100)


def integrals_of_each(x_s: Array) -> tuple[Array, Array]:
    """The integrals of x E and of E over x for each threshold, E the survival in eyring heat at v = 1."""
    x = np.linspace(0.0, x_s, 4001)
    broken = ATTEMPTS * WIDTH * x_s * (np.exp((x / x_s - 1.0) / WIDTH) - np.exp(-1.0 / WIDTH))
    survival = np.exp(-broken)
    return np.trapezoid(x * survival, x, axis=0), np.trapezoid(survival, x, axis=0)


@pytest.mark.slow  # quick: the errors of cold samples, in test_samples.py and test_verdict.py
@pytest.mark.parametrize("longest", [describe.LONGEST, 0.0])
def test_in_strong_heat_the_sampling_error_is_that_of_the_hot_force(
    longest: float, monkeypatch: Any
) -> None:
    """It is the scatter of a sum over the samples, drawn again and not smoothed. F_k without heat scatters by more.
    Where K* of one law takes long, F_k alone is resampled, and a note says so."""
    monkeypatch.setattr(describe, "LONGEST", longest)
    monkeypatch.setattr(describe, "RESAMPLES", 10)
    hot = origins.Thermal("eyring", width=WIDTH, attempt_frequency=ATTEMPTS)
    contacts = origins.Contacts(origins.from_samples(X_S), thermal=hot)
    force, travel = integrals_of_each(X_S)
    drawn = np.random.default_rng(2).integers(0, X_S.size, (1000, X_S.size))
    scatter = float(np.std(force[drawn].sum(axis=1) / travel[drawn].sum(axis=1)))
    found = describe.describe(contacts)
    kinetic, spring = found.numbers["kinetic_force"], found.numbers["critical_spring"]
    assert kinetic.value == pytest.approx(force.sum() / travel.sum(), abs=0.5 * scatter)
    assert kinetic.error is not None and spring.error is not None
    assert 0.6 * scatter < kinetic.error < 1.7 * scatter
    squares, x_s = np.square(X_S)[drawn].sum(axis=1), X_S[drawn].sum(axis=1)
    assert kinetic.error < 0.4 * np.std(0.5 * squares / x_s)
    assert (spring.error == np.inf) == (describe.TOO_LONG in found.notes) == (longest == 0.0)


def test_a_resampled_law_of_growing_thresholds_grows_alike() -> None:
    """Thresholds of next to one value that grow all break where x = x_s g(x/v); the delay stays, too."""
    grown = origins.strengthening(origins.from_samples(X_S), beta=0.1, time=0.01)
    contacts = origins.Contacts(grown, delay=origins.Delay(time=0.3))
    other = like(contacts, origins.gaussian(mean=1.0, std=1e-3))
    at_break = 1.0
    for _ in range(60):
        at_break = 1.0 + 0.1 * np.log1p(at_break / 0.01)
    expected = 0.5 * at_break**2 / (at_break + 0.3)
    assert other.delay is contacts.delay
    assert master.steady_state(other).force == pytest.approx(expected, rel=1e-5)


def test_a_growth_of_ones_own_is_that_of_other_samples_too() -> None:
    """It was left out of them without a word; one that is stated by hazards has none, and says so."""

    class Own(Strengthening):
        law = "own"

        def factor(self, age: Any) -> Any:
            return np.sqrt(1.0 + np.asarray(age) / self.time_unit)

    other = origins.gaussian(mean=1.0, std=0.1)
    contacts = origins.Contacts(Own(origins.from_samples(X_S), beta=0.1, time=4.0, age=3.0))
    contacts.thresholds.mean()  # found once, of these samples
    alike = like(contacts, other)
    assert isinstance(alike.growing, Own) and alike.thresholds.mean() == pytest.approx(1.75**0.5)
    grains = origins.Contacts(origins.growing_grains(1.0, 1.0, age=4.0))
    with pytest.raises(origins.InputError, match="has no other samples"):
        like(grains, other)
