"""Paths in time: turns, holds and velocity steps of contacts with laws of their own."""

from itertools import pairwise

import numpy as np
import pytest
from counted_calls import CountedCalls
from moving_contacts import move
from scipy.integrate import quad

import eq_model
import master
from master.paper.explicit_loop import explicit_loop
from origins import (
    Ageing,
    Contacts,
    Delay,
    InputError,
    Thermal,
    gaussian,
    gaussian_start,
    identical,
    mixture,
)

Array = np.ndarray
WIDE = gaussian(1.0, 0.2)
SOFT, STIFF = Thermal("soft", 0.1), Thermal("stiff", 0.1)
# forward, a hold, a faster step, back slowly, a short hold, back further, forward again
CORNERS = [(0.0, 0.0), (1.3, 1.5), (1.3, 8.0), (2.0, 8.5), (0.2, 11.0), (0.2, 11.5), (-1.0, 14.0), (0.5, 15.0)]


def along(corners: list[tuple[float, float]], points: int = 6) -> tuple[Array, Array]:
    """Path and times through corners (X, t), `points` to each piece."""
    legs = [np.linspace(a, b, points)[1:] for a, b in pairwise(np.array(corners))]
    path, time = np.concatenate([[corners[0]], *legs]).T
    return path, time


CASES = {
    "soft, waiting": lambda: Contacts(WIDE, 0.1, thermal=Thermal("soft", 0.2), delay=Delay(0.3)),
    "stiff, linked": lambda: Contacts(WIDE, 0.1, thermal=STIFF, stiffness="linked"),
    "around, waiting": lambda: Contacts(
        WIDE, gaussian_start(-0.2, 0.1), reforming=gaussian_start(0.1, 0.05), delay=Delay(0.3)
    ),
    "one value, warm": lambda: Contacts(identical(1.0), 0.213, thermal=SOFT),
}


@pytest.mark.parametrize("name", CASES)
def test_turns_and_holds_are_those_of_discrete_contacts(name: str) -> None:
    path, time = along(CORNERS if name == "soft, waiting" else CORNERS[:5])
    contacts = CASES[name]()
    solved = master.solve(contacts, path, 1e-2, time=time)
    assert solved.success, solved.message
    count = 20_000
    force, error, holding = move(contacts, path, time, count)
    assert (np.abs(solved.force - force) < 5.0 * error + solved.force_error).all()
    spread = np.sqrt(np.maximum(holding * (1.0 - holding), 1.0 / count) / count)
    assert (np.abs(solved.holding - holding) < 5.0 * spread + solved.force_error).all()


@pytest.mark.parametrize(("thermal", "tolerance"), [(SOFT, 1e-6), (STIFF, 1e-4)])
def test_a_hold_lets_each_threshold_decay_at_its_own_rate(thermal: Thermal, tolerance: float) -> None:
    """What breaks forms again relaxed, so that the force is that of the first contacts."""
    start, time = 0.4, np.array([0.0, 1.0, 30.0, 1e6, 1e12])
    solved = master.solve(Contacts(WIDE, start, thermal=thermal), np.zeros(time.size), tolerance, time=time)

    def held(t: float) -> float:
        def share(threshold: float) -> float:
            return float(WIDE.pdf(threshold) * np.exp(-t * thermal.rate(start, threshold)))

        edges = np.append(start, np.linspace(0.45, 3.0, 60))
        return sum(quad(share, a, b, epsabs=1e-13, epsrel=1e-12)[0] for a, b in pairwise(edges))

    exact = start * np.array([held(t) for t in time]) / WIDE.sf(start)
    assert solved.success, solved.message
    assert np.abs(solved.force - exact).max() <= solved.force_error


def test_the_paper_closure_forgets_after_a_turn() -> None:
    """At next to no rate it is App. C, whose plain scheme is of first order."""
    path, _ = along([(0.0, 0.0), (0.9, 1.0), (-0.9, 2.0)], 10)
    contacts = Contacts(WIDE, thermal=Thermal("soft", 0.1, 1e-12, closure="paper"))
    solved = master.solve(contacts, path, 1e-4)
    coarse, fine = (explicit_loop(Contacts(WIDE), path, step).force for step in (2e-3, 1e-3))
    assert solved.success and np.abs(solved.force - (2.0 * fine - coarse)).max() < 2e-4


def test_paths_on_which_contacts_do_too_much_are_refused_soon() -> None:
    hot = Contacts(WIDE, thermal=Thermal("soft", 0.1, 1e12))
    for _ in range(2):  # the first time it imports what it needs
        too_hot = r"attempt_frequency = 10+\.0: .* times on the way, .* slide faster"
        with CountedCalls() as told, pytest.raises(InputError, match=too_hot):
            master.solve(hot, [3.0, -3.0, 3.0])
    assert told.number < 50_000
    too_long = r"ageing: a move of 2e\+03 in time needs more than \d+ steps; use a shorter path"
    with pytest.raises(InputError, match=too_long):
        master.solve(Contacts(WIDE, ageing=Ageing(gaussian(1.5, 0.1), 1e-2)), [1e3, -1e3])


def test_long_ways_between_turns_end_in_steady_sliding() -> None:
    """Each leg but its end is as long as one wishes: contacts forget how it began."""
    contacts = Contacts(WIDE, thermal=SOFT)
    solved = master.solve(contacts, [1e5, -1e5])
    steady = master.steady_state(contacts)
    assert solved.success
    assert np.abs(np.abs(solved.force) - steady.force).max() <= solved.force_error + steady.force_error


def test_an_exact_threshold_with_re_forming_at_many_stretches_on_a_path_that_turns() -> None:
    contacts = Contacts(identical(1.0), reforming=gaussian_start(0.0, 0.1))
    path = np.array([0.9, 1.1, 1.6, 2.0, 1.2, 0.2, -1.0, -0.5, 0.7, 2.0])
    solved = master.solve(contacts, path, 1e-6)
    sampled = eq_model.simulate(contacts, path, n_contacts=40_000, n_replicas=8, seed=2)
    assert solved.success
    errors = sampled.force_standard_error + solved.force_error
    assert (np.abs(solved.force - sampled.force) <= 5.0 * errors).all()


def test_odd_paths() -> None:
    contacts = Contacts(WIDE, 0.4, thermal=SOFT)
    one = master.solve(contacts, [-0.2], 1e-3)
    again = master.solve(contacts, [-0.2, -0.2, -0.2], 1e-3, time=[0.2, 0.2, 0.2])
    assert one.success and np.abs(again.force - one.force).max() < 1e-3
    still = master.solve(contacts, [0.0, 0.0], 1e-3, time=[0.0, 0.0])
    assert still.success and np.abs(still.force - 0.4).max() < still.force_error
    box = Contacts(mixture([WIDE, identical(0.8)], [0.7, 0.3]), 0.213, delay=Delay(0.2))
    assert np.isfinite(master.solve(box, [1.0, 0.5], 1e-1).force).all()


@pytest.mark.parametrize("thermal", [Thermal("soft", 0.03), Thermal("soft", 0.3), Thermal("stiff", 0.1)])
def test_after_long_holds_the_force_is_that_of_discrete_contacts(thermal: Thermal) -> None:
    """Late births of a hold differ in age by far more than they live; what is left of them bears the static force."""
    contacts, after = Contacts(WIDE, thermal=thermal), np.linspace(0.1, 1.5, 8)
    peaks = []
    for hold in (1e2, 1e4, 1e6):
        path, time = np.concatenate([[2.0, 2.0], 2.0 + after]), np.concatenate([[2.0, 2.0 + hold], 2.0 + hold + after])
        found = master.solve(contacts, path, 1e-3, time=time)
        assert found.success, found.message
        peaks.append(found.force[2:].max())
        if hold < 1e5 or thermal.temperature < 0.1:  # or they break too often for an ensemble
            seen = eq_model.simulate(contacts, path, time=time, n_contacts=2000 if hold < 1e5 else 100)
            off = np.abs(found.force - seen.force)
            assert (off < found.force_error + 5.0 * seen.force_standard_error).all()
    # strengthening with the time's logarithm, until it is in balance
    assert min(np.diff(peaks)) > (0.05 if thermal.temperature < 0.1 else 0.0)


def test_a_hold_without_end_leaves_thresholds_in_balance() -> None:
    """Those that hold are as P_c over the rate; a step that takes no time then finds them, and what it makes."""
    law, thermal, hold, speed = gaussian(1.0, 0.05), Thermal("soft", 0.1), 1e5, 1e4
    x = np.linspace(0.8, 1.25, 19)
    found = master.solve(Contacts(law, thermal=thermal), np.append(0.0, x), 1e-6, time=hold + np.append(0.0, x / speed))
    # P_c/h is a Gaussian as well
    sharp = 1.0 / 0.05**2
    balance = gaussian(sharp / (sharp - 10.0), (sharp - 10.0) ** -0.5)
    later = [quad(lambda y, at=at: balance.pdf(y) * (at - y) * law.sf(at - y), 0.5, at, epsabs=1e-12)[0] for at in x]
    assert found.success, found.message
    # on the way some ω T/v break
    assert np.abs(found.force[1:] - x * balance.sf(x) - later).max() < 3e-5
