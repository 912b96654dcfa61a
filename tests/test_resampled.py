"""What other samples would give of contacts with laws in time: F_k of contacts as hot and as old as those asked for."""

from typing import Any

import numpy as np
import pytest
from conftest import slow

import master
import origins
from origins.laws.strengthening import Strengthening
from origins.thresholds.law import Array
from toolkit import load_scene
from toolkit.judge import describe
from toolkit.running.resampled import error_by_moments, kinetic_name, like
from toolkit.verdict import judge, uncertainty

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
    # of 10 resamplings, (2 * 9)^-1/2; F_k in heat has no closed form
    how = "of moments in closed form, of all else by 10 resamplings, known to ± 24%"
    assert sum(how in note for note in found.notes) == 1


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


def numbers_of_samples(x: Array, weights: Array) -> dict[str, Array]:
    """What the moments of samples tell, along the last axis."""
    first, second, third = ((weights * x**k).sum(axis=-1) for k in (1, 2, 3))
    found = {"mean": first, "second_moment": second, "third_moment": third}
    found |= {"standard_deviation": np.sqrt(second - first**2)}
    return found | {"kinetic_force": second / 2.0 / first, "linked_force": third / 2.0 / first**2}


@pytest.mark.parametrize(
    "seed", [*range(4), *(pytest.param(n, marks=pytest.mark.slow) for n in range(4, 40))]
)
def test_errors_of_moments_are_those_of_a_bootstrap_of_a_thousand(seed: int) -> None:
    """Samples of several laws, drawn again a thousand times, which knows their scatter to 2.2 %; of F_k to the second
    order in 1/n, which the delta method leaves out. Twenty resampled laws missed by up to a half."""
    generator = np.random.default_rng(seed)
    n, unit = int(generator.integers(150, 400)), 10.0 ** generator.integers(-9, 3)
    x = unit * (0.1 + generator.weibull(generator.uniform(1.5, 4.0), n))
    law, even = origins.from_samples(x), np.full(n, 1.0 / n)
    drawn = numbers_of_samples(x[generator.integers(0, n, (1000, n))], even)
    for name, own in numbers_of_samples(x, even).items():
        scatter = np.std(drawn[name])
        assert error_by_moments(law, name, float(own)) == pytest.approx(scatter, rel=0.12), name
        # and the shift by smoothing, as it is told
        shifted = error_by_moments(law, name, float(own + 2.0 * scatter))
        assert shifted == pytest.approx(5.0**0.5 * scatter, rel=0.12)


def test_errors_of_moments_in_a_mixture_are_those_of_its_parts_from_samples() -> None:
    """Each part is drawn again apart, by its effective samples; a law that is given has no error."""
    generator = np.random.default_rng(3)
    x, y = 0.1 + generator.weibull(2.5, 200), 1.0 + generator.weibull(2.0, 300)
    weights = generator.uniform(0.5, 1.5, 300)
    parts = [
        origins.from_samples(x),
        origins.from_samples(y, weights=weights),
        origins.gaussian(9.0, 0.1),
    ]
    share = np.array([0.5, 0.3, 0.2])
    law = origins.mixture(parts, share)
    drawn_y = generator.choice(
        300, (4000, round(parts[1].effective_samples)), p=weights / weights.sum()
    )
    means = [numbers_of_samples(x[generator.integers(0, 200, (4000, 200))], np.full(200, 1 / 200))]
    means += [numbers_of_samples(y[drawn_y], np.full(drawn_y.shape[1], 1 / drawn_y.shape[1]))]
    first, second = (
        sum(s * one[name] for s, one in zip(share, means, strict=False))
        + share[2] * parts[2].moment(k)
        for k, name in ((1, "mean"), (2, "second_moment"))
    )
    forces = second / 2.0 / first
    own = float(np.mean(forces))
    found = error_by_moments(law, "kinetic_force", own)
    assert found == pytest.approx(float(np.std(forces)), rel=0.06)


@pytest.mark.parametrize("linked", [False, slow(True)])
def test_the_verdict_and_thresholds_tell_the_same_errors_of_samples(
    linked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the same draws of K*, here few, and of F_k by the same moments."""
    for each in (describe, uncertainty):
        monkeypatch.setattr(each, "RESAMPLES", 6)
    x = np.random.default_rng(4).weibull(2.0, 100) + 0.1
    contacts = {"thresholds": {"kind": "from-samples", "x_s": x.tolist()}}
    contacts |= {"stiffness": "linked"} if linked else {}
    scene = load_scene({"contacts": contacts}, solved=False)
    own, numbers = judge.verdict(scene).own, describe.describe(scene.contacts).numbers
    assert kinetic_name(scene.contacts) == ("linked_force" if linked else "kinetic_force")
    for name, one in (("kinetic_force", own.kinetic), ("critical_spring", own.critical_spring)):
        assert one.sampling == pytest.approx(numbers[name].error, rel=2e-3)
        assert one.value == pytest.approx(numbers[name].value, rel=1e-3)
    assert own.kinetic.resampled == 0 and own.critical_spring.resampled == describe.RESAMPLES
