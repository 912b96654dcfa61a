"""Steady creep of a slider on a soft spring, whose contacts heat breaks; and when it is not told."""

from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest
from conftest import slow
from scipy import stats

import master
from master.rate_state.critical_spring import transform
from master.soft.in_time.creep import Creep, Offset
from master.steady.response import is_stable, response
from origins import Contacts, InputError, Thermal, gaussian
from origins.laws.rate_law import RateLaw

WIDE, NARROW = gaussian(1.0, 0.2), gaussian(1.0, 0.05)
SPREAD = stats.weibull_min(2.0, scale=1.128379167)
# F_k grows by 0.03 of its largest value for each factor e of the speed
EYRING = Thermal("eyring", width=0.03)
# a spring on which a slider moves by 10 thresholds while its speed grows by a factor e; softer, a million
SPRING, SOFTEST = 3e-3, 1e-6
CREEPING = Contacts(SPREAD, thermal=EYRING)


def kinetic(contacts: Contacts, velocity: float) -> float:
    """F_k/(N_c <k>)."""
    return float(master.steady_state(contacts, velocity=velocity).force)


def stepped(contacts: Contacts, tolerance: float, points: int) -> None:
    """With R(X), the change of F after a step for each factor e of the speed, G(iq) = iq T(iq), T its transform."""
    step, waves, way = 0.02, np.array([0.3, 2.0, 6.0]), np.linspace(0.0, 8.0, points)
    runs = []
    for ratio in (np.exp(-step), np.exp(step)):
        # 30 thresholds at one speed, then on at another
        path = np.append(np.linspace(0.0, 30.0, 31)[:-1], 30.0 + way)
        time = np.append(np.linspace(0.0, 30.0, 31)[:-1], 30.0 + way / ratio) / 1e-4
        runs.append(np.asarray(master.solve(contacts, path, tolerance, time=time).force)[30:])
    mean = (runs[1] - runs[0]) / (2.0 * step)
    told = response(contacts, 1e-4, waves)
    assert told == pytest.approx(1j * waves * transform(way, mean, waves), abs=2e-3)


@pytest.mark.parametrize("law", [WIDE, slow(SPREAD)])
def test_the_response_is_that_to_a_small_step_of_the_speed(law: Any) -> None:
    stepped(Contacts(law, thermal=EYRING), 1e-7, 801)


@pytest.mark.parametrize("width", [0.01, 0.1])
def test_slow_disturbances_see_the_slope_of_the_kinetic_force(width: float) -> None:
    """G(iq) -> iq dF_k/d ln v; and fast ones elastic contacts, that all break by heat."""
    for law in (WIDE, SPREAD):
        contacts = Contacts(law, thermal=Thermal("eyring", width=width))
        slow, fast = response(contacts, 1e-4, np.array([1e-3, 30.0 / width]))
        up, down = (kinetic(contacts, 1e-4 * ratio) for ratio in (1.01, 1.0 / 1.01))
        assert slow.imag / 1e-3 == pytest.approx((up - down) / (2.0 * np.log(1.01)), rel=2e-3)
        assert fast.real == pytest.approx(1.0, abs=0.05)


@dataclass(frozen=True)
class CatchBonds(RateLaw):
    """A rate that falls as contacts are stretched, h = e^(-x/a)."""

    a: float = 0.1
    name: ClassVar[str] = "catch"
    scale: ClassVar[float] = 1.0

    def log_rate(self, x: Any, threshold: Any, stiffness: Any) -> Any:
        return -x / self.a + 0.0 * threshold

    def log_passed(self, near: Any, far: Any, threshold: Any, stiffness: Any) -> Any:
        with np.errstate(divide="ignore"):
            return np.log(-self.a * np.expm1((near - far) / self.a)) - near / self.a

    def reached(self, log_amount: Any, near: Any, threshold: Any, stiffness: Any) -> Any:
        left = np.exp(-near / self.a) - np.exp(np.minimum(log_amount, 600.0)) / self.a
        far = -self.a * np.log(np.maximum(left, 1e-300))
        return np.minimum(far, threshold)


def test_sliding_whose_force_answers_against_a_disturbance_is_unstable_on_a_soft_spring() -> None:
    """Contacts that break less the more they are stretched: although F_k rises with the speed, G has a negative real
    part where it has no imaginary one, so that swings of about a threshold grow. Eyring's heat is stable on every
    spring."""
    contacts, waves = Contacts(WIDE, thermal=CatchBonds()), np.geomspace(0.01, 20.0, 400)
    answer = response(contacts, 0.1, waves)
    turns = np.flatnonzero(np.diff(np.sign(answer.imag)))
    critical = -answer.real[turns].min()
    assert critical == pytest.approx(0.21, abs=0.01)
    assert is_stable(contacts, 0.1, 2.0 * critical)
    assert not is_stable(contacts, 0.1, 0.5 * critical)
    for law in (WIDE, NARROW):
        assert is_stable(Contacts(law, thermal=EYRING), 1e-4, SOFTEST)


@cache
def soft(
    contacts: Contacts, end: float, slip: Any, tolerance: float = 1e-2, sign: float = 1.0
) -> Any:
    """The slider on SPRING at points up to X_T = 192, and then at the end of its path."""
    path = sign * np.append(np.linspace(0.0, 192.0, 33), [end] if end > 192.0 else [])
    return master.solve(contacts, path, tolerance, velocity=1e-4, spring=SPRING, slip=slip)


# the example below is quick, and ends at the kinetic force
@pytest.mark.slow
@pytest.mark.parametrize("slip", ["reset", "instant"])
def test_steady_creep_goes_on_as_steps_do(slip: Any) -> None:
    """Up to X_T = 192 steps do; on a path ten times as long creep takes over at 178. By "reset" F would fall to 0 in
    any slip: as there is none, steps are the same under another rule."""
    contacts = CREEPING
    steps = soft(contacts, 192.0, "reset")
    assert steps.success and "creeps" not in steps.message and not steps.slips.drive.size
    creep = soft(contacts, 2400.0, slip)
    assert creep.success and "creeps" in creep.message
    off = np.abs(creep.force[:33] - steps.force).max()
    assert off < steps.force_error + creep.force_error
    assert creep.force[-1] == pytest.approx(kinetic(contacts, 1e-4), rel=1e-6)
    assert creep.regime.verdict == "smooth" and not creep.slips.drive.size


@pytest.mark.slow  # quick: creep goes on as steps do, above
def test_the_numbers_of_the_example_in_creep_py(monkeypatch: pytest.MonkeyPatch) -> None:
    """How the three sliders hand over to creep, and what the error is made of."""
    from_here, told = Creep.from_here, []

    def kept(self: Creep, nodes: Any, most_steps: float) -> Any:
        crept = from_here(self, nodes, most_steps)
        if crept is not None:
            told.append((nodes, crept))
        return crept

    monkeypatch.setattr(Creep, "from_here", kept)
    soft.__wrapped__(CREEPING, 2400.0, "instant")
    assert len(told) == 3
    nodes, crept = told[-1]
    last, way = nodes[-1], nodes[-1].position - nodes[0].position
    drive = last.position + last.force / SPRING
    assert (drive, last.force, way) == pytest.approx((178.3, 0.5045, 10.14), rel=2e-4)
    assert way / last.force == pytest.approx(20.0, rel=0.01) and len(nodes) == 179
    assert crept.error == pytest.approx(2.6e-4, rel=0.03)
    middle, fine = Offset(-1.43e-3, 0.0, 2.0), Offset(-2.23e-4, 8.6e-5, 1.0)
    assert fine.at_step_0(middle) + fine.variation == pytest.approx(2.6e-4, rel=0.03)
    # the first of the three has no slider with longer steps
    assert Offset(-7.41e-3, 0.0, 4.0).at_step_0(None) == 7.41e-3
    assert told[0][1].error == pytest.approx(7.41e-3, rel=0.01)
    first, second = crept.sections[0][:2]
    speed = (second.position - first.position) / (second.time - first.time)
    assert speed == pytest.approx(0.837e-4, rel=0.01)
    assert crept.sections[0][-1].sizes_so_far > 40.0
    assert crept.sections[0][-1].force == pytest.approx(kinetic(CREEPING, 1e-4), rel=1e-6)


@pytest.mark.slow
def test_creep_backward_is_that_forward() -> None:
    there = soft(CREEPING, 2400.0, "reset")
    back = soft(CREEPING, 2400.0, "reset", sign=-1.0)
    assert "creeps" in back.message
    assert -back.force == pytest.approx(there.force, abs=1e-7)


@pytest.mark.slow
def test_on_the_spring_of_a_machine_the_force_is_the_kinetic_one() -> None:
    """A million thresholds: F rises with the drive, and then as V/v = 1/(1 + e^-s), to F_k. On the way it is F_k at the
    speed of the slider, which is at X = X_T - F/K: so it creeps in its time. A path that ends on the way is told
    how far to drive until F is F_k to the tolerance."""
    on_the_way = master.solve(CREEPING, [5e5], 1e-2, velocity=1e-4, spring=SOFTEST).regime
    assert (
        on_the_way.verdict == "undecided"
        and "not there to the tolerance; drive to" in on_the_way.reason
    )
    there = on_the_way.drive_to
    path = np.array(
        [0.0, 2.5e5, 4.4e5, 4.41e5, 5e5, 5.01e5, 0.99 * there, there, 5.5e5, 5.51e5, 2e6]
    )
    told = master.solve(CREEPING, path, 1e-2, velocity=1e-4, spring=SOFTEST)
    assert told.success and told.regime.verdict == "smooth", told.message
    assert told.force[-1] == pytest.approx(kinetic(CREEPING, 1e-4), rel=1e-6)
    assert told.force[1] == pytest.approx(SOFTEST * path[1], abs=1e-3)
    before, at = kinetic(CREEPING, 1e-4) - told.force[6:8]
    assert at <= 1e-2 < before < 2e-2
    position = path - told.force / SOFTEST
    for near, far in ((2, 3), (4, 5), (8, 9)):  # at 0.03, 0.4 and 0.9 times the drive's speed
        speed = 1e-4 * (position[far] - position[near]) / (path[far] - path[near])
        force = 0.5 * (told.force[near] + told.force[far])
        assert kinetic(CREEPING, speed) == pytest.approx(force, abs=1e-4)


@pytest.mark.slow
def test_narrow_thresholds_that_slip_all_at_once_are_not_smooth() -> None:
    """Contacts that break nearly together slip before they have forgotten their start."""
    told = soft(Contacts(NARROW, thermal=EYRING), 900.0, "reset")
    assert told.regime.verdict == "stick-slip" and told.slips.drive.size > 2


@pytest.mark.slow
def test_contacts_that_break_less_the_more_they_are_stretched_do_not_creep_smoothly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Steady sliding of them is unstable on soft springs, so that steady creep must not be told of them: it would be
    within the first hundred steps."""
    monkeypatch.setattr("master.soft.in_time.contacts.MOST_WORK", 5e7)
    contacts = Contacts(WIDE, thermal=CatchBonds())
    assert kinetic(contacts, 0.2) > kinetic(contacts, 0.1)
    try:
        path = [0.0, 2e4]
        told = master.solve(contacts, path, 1e-2, velocity=0.1, spring=1e-3, slip="instant")
    except InputError as refused:
        assert "steps" in str(refused)
    else:
        assert "creeps" not in told.message and told.regime.verdict != "smooth"
