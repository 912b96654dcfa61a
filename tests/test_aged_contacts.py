"""Thresholds that age one by one: closed forms, limits, Fig. A05, and far on the steady state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from conftest import slow
from rate_laws import Tilted
from scipy.integrate import solve_ivp
from scipy.special import log_ndtr, ndtr
from solving import held_to_claim

import eq_model
import master
import origins
from origins import Ageing, Contacts, Delay

FRESH, FINAL = origins.gaussian(0.5, 0.1), origins.gaussian(1.0, 0.01)  # Fig. A05
YOUNG, LATER = origins.gaussian(0.5, 0.15), origins.gaussian(0.8, 0.08)


def inverse_gaussian(t, distance, diffusion, speed):
    """Share of thresholds, at `distance` at first, that no level which moves up has met."""
    spread = np.sqrt(2.0 * diffusion * t)
    first = ndtr((distance - speed * t) / spread)
    rest = speed * distance / diffusion + log_ndtr(-(distance + speed * t) / spread)
    return first - np.exp(rest)


@pytest.mark.parametrize(("diffusion", "speed"), [(1e-3, 1.0), (0.1, 0.25)])
def test_first_passage_without_drift_is_inverse_gaussian(diffusion, speed):
    """A final law so wide that it does not pull; broken contacts stay out."""
    ageing = Ageing(origins.gaussian(1.0, 1e9), diffusion)
    contacts = Contacts(origins.identical(0.7), ageing=ageing, delay=Delay(1e3))
    path = np.linspace(0.05, 2.0, 30)
    found = master.solve(contacts, path, 1e-8, velocity=speed)
    exact = inverse_gaussian(path / speed, 0.7, diffusion, speed)
    assert found.success and np.abs(found.holding - exact).max() < found.force_error + 1e-10


@pytest.mark.parametrize("diffusion", [1e-3, 0.05])
def test_first_passage_after_a_turn(diffusion):
    """Images give how far above the level thresholds are where it turns, at X = 0.6; then it recedes from each."""
    ageing, back = Ageing(origins.gaussian(1.0, 1e9), diffusion), np.array([0.599, 0.5, 0.3, 0.05])
    contacts = Contacts(origins.identical(0.7), ageing=ageing, delay=Delay(1e3))
    found = master.solve(contacts, np.append(0.6, back), 1e-8)
    above, variance = np.linspace(0.0, 3.0, 60_001), 2.0 * diffusion * 0.6
    logs = [-((above - 0.1) ** 2), -((above + 1.3) ** 2) + 2.0 * variance * 0.7 / diffusion]
    density = np.subtract(*np.exp(np.array(logs) / (2.0 * variance)))
    density /= np.sqrt(2.0 * np.pi * variance)
    later = inverse_gaussian(0.6 - back[:, None], above, diffusion, -1.0)
    exact = np.append(
        inverse_gaussian(0.6, 0.7, diffusion, 1.0), np.trapezoid(density * later, above)
    )
    assert found.success and np.abs(found.holding - exact).max() < found.force_error + 1e-10


@pytest.mark.parametrize("start", [0.45, -0.45])
def test_hold_at_the_mean_of_the_final_law(start):
    """There the drift does not push: by reflection E = 2 Φ(z) - 1, averaged over the fresh; at first the
    few contacts right above the stretch break."""
    std, diffusion, time = 0.08, 5e-3, np.array([1e-6, 7e-6, 1e-4, 0.01, 0.1, 0.3, 1.0, 2.5])
    ageing = Ageing(origins.gaussian(0.45, std), diffusion)
    contacts = Contacts(YOUNG, start, ageing=ageing, delay=Delay(1e3))
    fresh = 0.45 + 1.35 * np.linspace(0.0, 1.0, 200_001) ** 2
    weight = YOUNG.pdf(fresh) / np.trapezoid(YOUNG.pdf(fresh), fresh)
    decay = np.exp(-diffusion / std**2 * time[:, None])
    z = (fresh - 0.45) * decay / (std * np.sqrt(1.0 - decay**2))
    exact = np.trapezoid(weight * (2.0 * ndtr(z) - 1.0), fresh)
    for tolerance in (1e-4, 1e-8):
        found = master.solve(contacts, np.zeros(8), tolerance, time=time)
        assert found.success and np.abs(found.holding - exact).max() < found.force_error


@dataclass(frozen=True)
class Parabola(Tilted):
    """h = ω (x_s - x)², under which normal thresholds stay normal."""

    def log_rate(self, x, threshold, stiffness):
        return np.log(self.omega) + 2.0 * np.log(np.maximum(threshold - x, 1e-300))


# its rates have a kernel of their own, kept nowhere, which takes as long to compile as this file to run; the cells of
# "heat" below hold the same with rates of a kernel that others need, too
@pytest.mark.slow
@pytest.mark.parametrize("path", [[0.1, 0.2, 0.3, 0.4], [0.1, 0.2, 0.2, 0.1]])
def test_ageing_with_heat_follows_mean_and_variance_of_the_thresholds(path) -> None:
    """In the ensemble, which alone takes it. Few have come to the stretch yet; broken contacts stay out. Rates of mean,
    variance and ln E add up."""
    time, rate, pull, omega = np.array([0.1, 0.2, 0.3, 0.4]), 0.01, 0.01 / 0.15**2, 2.0

    def flow(t, now):
        mean, variance, _ = now
        above = mean - np.interp(t, [0.0, *time], [0.0, *path])
        drift = pull * (1.4 - mean) - 2.0 * omega * variance * above
        spread = 2.0 * rate - 2.0 * pull * variance - 2.0 * omega * variance**2
        return drift, spread, -omega * (above**2 + variance)

    begin = [1.0, 0.01, 0.0]
    known = solve_ivp(flow, (0.0, 0.4), begin, t_eval=time, rtol=1e-9, atol=1e-11, max_step=0.05)
    ageing = Ageing(origins.gaussian(1.4, 0.15), rate)
    fresh, heat = origins.gaussian(1.0, 0.1), Parabola(omega=omega)
    contacts = Contacts(fresh, thermal=heat, ageing=ageing, delay=Delay(1e3))
    held = np.exp(known.y[2])
    found = eq_model.simulate(contacts, path, time=time, n_contacts=8_000, seed=1)
    scatter = np.sqrt(held * (1.0 - held) / 8_000)
    assert (np.abs(found.holding - held) < 4.0 * scatter + 1e-3).all()
    assert (np.abs(found.force - held * path) < path * (4.0 * scatter + 1e-3)).all()


NORMAL, AT_ZERO = origins.gaussian(1.0, 0.05), origins.lubricated(1.0, -0.5)
LEFT_TO_THE_ENSEMBLE = {
    "heat": Contacts(YOUNG, thermal=origins.Thermal("soft", 0.3), ageing=Ageing(NORMAL, 0.01)),
    "not normal": Contacts(YOUNG, ageing=Ageing(origins.persson(1.0, 0.4), 0.01)),
    "diverges at 0": Contacts(AT_ZERO, ageing=Ageing(NORMAL, 0.01)),
}
CALLS = {
    "solve": lambda contacts: master.solve(contacts, [0.0, 1.0]),
    "turning": lambda contacts: master.solve(contacts, [0.5, 0.2, 0.2], time=[1.0, 2.0, 3.0]),
    "steady_state": master.steady_state,
    "propensity": master.propensity,
    "kinetic_curve": master.kinetic_curve,
    "phase_line": master.phase_line,
    "decoherence_spectrum": master.decoherence_spectrum,
    "critical_velocity": lambda contacts: master.critical_velocity(contacts, 3.0, 0.1, 10.0),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("name", LEFT_TO_THE_ENSEMBLE)
def test_what_has_no_first_passage_is_refused_in_one_line(name: str, call: str) -> None:
    with pytest.raises(origins.InputError) as refusal:
        CALLS[call](LEFT_TO_THE_ENSEMBLE[name])
    told = str(refusal.value)
    assert told.startswith("contacts.") and "\n" not in told
    if (name, call) != ("heat", "critical_velocity"):  # which takes no heat in any case
        assert "use eq_model.simulate" in told


@pytest.mark.parametrize(
    "name",
    [
        # kernels of ageing with heat take half a minute to compile
        slow(name, when=name == "heat")
        for name in LEFT_TO_THE_ENSEMBLE
    ],
)
def test_cells_of_thresholds_on_a_stiff_spring_agree_with_the_ensemble(name: str) -> None:
    """Laws without a first passage: a rigid slider is refused in master, and left to the ensemble; on a spring the
    densities of thresholds are followed in cells. Heat has the time to halve the force: rates that are a tenth too low
    make a difference of three times what is allowed."""
    contacts, path = LEFT_TO_THE_ENSEMBLE[name], np.array([0.3, 0.5, 0.7])
    velocity, number = (0.1, 50_000) if name == "heat" else (1.0, 8_000)
    drawn = eq_model.simulate(contacts, path, n_contacts=number, velocity=velocity, seed=2)
    sprung = master.solve(contacts, path * (1.0 + 1e-4), 1e-2, velocity=velocity, spring=1e4)
    apart = np.abs(np.interp(path, sprung.position, sprung.force) - drawn.force)
    assert (apart < 4.0 * drawn.force_standard_error + drawn.step_error + 1e-3).all()
    assert (drawn.force_error == drawn.force_standard_error + drawn.step_error).all()


def test_the_drift_to_any_final_law_is_that_to_a_normal_one_where_it_is_normal() -> None:
    """Of a normal law the drift D U' is known; a mixture of that law with itself takes the road of any final law."""
    final, path = origins.gaussian(1.2, 0.05), np.array([0.25, 0.5])
    one, other = (
        master.solve(
            Contacts(YOUNG, ageing=Ageing(law, 0.01)), path, 3e-2, time=2.0 * path, spring=1e4
        )
        for law in (final, origins.mixture([final, final], [0.5, 0.5]))
    )
    np.testing.assert_allclose(other.force, one.force, rtol=1e-9)


def test_contacts_hold_beyond_every_fresh_threshold_as_these_spread() -> None:
    fresh, final = origins.gaussian(1.0, 4e-4), origins.gaussian(0.392, 0.0408)
    contacts, x = Contacts(fresh, ageing=Ageing(final, 1.5e-5)), np.array([1.002, 1.005, 1.01])
    solved, drawn = (
        master.solve(contacts, x, 1e-6),
        eq_model.simulate(contacts, x, n_contacts=300_000),
    )
    assert solved.success
    assert (
        np.abs(solved.force - drawn.force) < 4.0 * drawn.force_standard_error + drawn.step_error
    ).all()


REFINED = {1000.0: 0.499542736223, 100.0: 0.496482068623, 10.0: 0.490625246688, 3.0: 0.487907968334}


@pytest.mark.parametrize(
    "velocity",  # by v/D
    [slow(v, when=v != 10.0) for v in REFINED],
)
def test_kinetic_force_of_figure_a05(velocity: float) -> None:
    contacts = Contacts(FRESH, ageing=Ageing(FINAL, 1.0))
    steady = master.steady_state(contacts, velocity=velocity)
    assert abs(steady.force - REFINED[velocity]) < 1e-12 and steady.force_error < 1e-11
    curve = master.kinetic_curve(contacts, [velocity, 2.0 * velocity], rate=[1.0, 2.0])
    np.testing.assert_allclose(curve.force, steady.force, rtol=1e-12)
    x = np.linspace(-0.1, 1.3, 14_001)
    held = steady.distribution(x)
    assert np.trapezoid(held[1000:], x[1000:]) == pytest.approx(1.0, abs=1e-5)
    assert (held[x < 0.0] == 0.0).all()


WIDER = Ageing(origins.gaussian(0.8, 0.25), 0.1)  # by which all is soon forgotten
FAR = [
    Contacts(FRESH, -0.1, ageing=WIDER, reforming=0.15, delay=Delay(0.1)),
    Contacts(FRESH, -0.1, ageing=WIDER, reforming=-0.1, delay=Delay(0.05)),
]


@pytest.mark.parametrize("contacts", FAR)
def test_far_on_the_force_is_that_of_steady_sliding(contacts: Contacts) -> None:
    steady = master.steady_state(contacts, velocity=2.0)
    far = master.solve(contacts, np.linspace(40.0, 42.0, 21), 1e-6, velocity=2.0)
    assert 0.0 < steady.force_error < 1e-6 and np.abs(far.force - steady.force).max() < 1e-6
    lost = 2.0 * contacts.waiting_time
    held = steady.cycle_length / (steady.cycle_length + lost)
    assert far.holding[-1] == pytest.approx(held, abs=1e-6)


def test_steady_motion_step_by_step_is_the_exact_one() -> None:
    path = np.linspace(0.1, 1.2, 12)
    contacts = Contacts(FRESH, 0.1, ageing=Ageing(LATER, 1e-3))
    held_to_claim(contacts, path, 1e-5, master.solve(contacts, path, 1e-8), time=path.copy())


@pytest.mark.slow
def test_density_of_contacts_that_form_again_at_many_stretches() -> None:
    births = origins.gaussian_start(0.05, 0.02)
    steady = master.steady_state(Contacts(FRESH, ageing=Ageing(LATER, 1e-3), reforming=births))
    x = np.linspace(-0.1, 1.3, 701)
    held = steady.distribution(x)
    assert np.trapezoid(held, x) == pytest.approx(1.0, abs=1e-5)
    assert np.trapezoid(held * x, x) == pytest.approx(steady.force, abs=1e-5)


@pytest.mark.slow
def test_births_of_the_very_law_of_the_start_on_a_path_that_turns() -> None:
    laws = [origins.gaussian_start(0.05, 0.02) for _ in range(2)]
    aged = [Contacts(FRESH, laws[0], ageing=Ageing(LATER, 1e-3), reforming=law) for law in laws]
    same, other = (master.solve(contacts, [0.8, 0.45, 0.1], 1e-3) for contacts in aged)
    np.testing.assert_allclose(same.force, other.force, rtol=1e-12)


def test_splines_between_moments_of_a_leg_count_in_the_error() -> None:
    """Thresholds of a rectangular law hardly age: their survival bends sharply where it begins. A path that turns later
    takes splines over the time, one that does not asks for each survival."""
    ageing, x = Ageing(origins.gaussian(0.8, 0.1), 1e-5), np.linspace(0.33, 0.93, 60)
    contacts = Contacts(origins.rectangular(0.4, 1.0), 0.05, ageing=ageing, delay=Delay(1e3))
    forward, turning = (master.solve(contacts, path, 1e-9) for path in (x, np.append(x, 0.5)))
    apart = np.abs(turning.holding[:-1] - forward.holding).max()
    assert forward.success and apart < forward.force_error + turning.force_error


@pytest.mark.slow
def test_births_of_a_leg_before_the_turn_count_after_it() -> None:
    """They hold on, and soon pull the other way."""
    contacts = Contacts(
        origins.gaussian(0.7, 0.1), ageing=Ageing(origins.gaussian(1.0, 0.05), 5e-3)
    )
    path = np.array([1.2, 0.9])
    solved = master.solve(contacts, path, 1e-3)
    found = eq_model.simulate(contacts, path, n_contacts=20_000, seed=1)
    apart = np.abs(solved.force - found.force)
    assert solved.success and (apart < solved.force_error + 5.0 * found.force_standard_error).all()
