"""Contacts whose thresholds grow with their age, against contacts one by one."""

import numpy as np
import pytest
from growing_contacts import along, deviation

import master
import origins
from origins import (
    Ageing,
    Contacts,
    Delay,
    GrainContact,
    GrainGrowth,
    InputError,
    Thermal,
    gaussian,
    gaussian_start,
    growing_grains,
)

ALPHA, B = 1.0, 1.0
GRAINS = growing_grains(ALPHA, B, age=4.0)
AGEING = Ageing(gaussian(1.0, 0.1), rate=1e-3)
FIRST = GRAINS.growth.first_pinning_time


SLIDE_HOLD_SLIDE = np.array([0.5, 1.0, 2.0, 3.0, 3.0, 3.0, 3.2, 3.4, 3.6, 4.0, 4.5, 5.5])
HOLD = np.array([0.5, 1.0, 2.0, 3.0, 3.5, 8.0, 8.2, 8.4, 8.6, 9.0, 9.5, 10.5])
TURNS, AT = np.array([0.7, 1.4, 0.6, -0.5, -1.5, 0.0]), np.array([1.0, 2.0, 3.2, 5.0, 6.0, 7.0])
CASES = {
    "hold": (Contacts(GRAINS), SLIDE_HOLD_SLIDE, HOLD),
    "turns, delay": (Contacts(GRAINS, 0.1, delay=Delay(0.2)), TURNS, AT),
    "turns, stiff": (Contacts(GRAINS, gaussian_start(0.1, 0.05), thermal=Thermal("stiff", 0.1, 0.5)), TURNS, AT),
}


@pytest.mark.parametrize("name", CASES)
def test_paths_in_time_against_contacts_one_by_one(name: str) -> None:
    contacts, path, time = CASES[name]
    solved = master.solve(contacts, path, 1e-2, time=time)
    assert solved.success, solved.message
    assert deviation(contacts, solved, along(contacts, path, time, 4_000, 2e-2, 3)) < 5.0


def test_far_along_the_force_is_that_of_steady_sliding() -> None:
    """One road steps in time and lets those that never hold wait again, the other knows their mean wait alone."""
    contacts, velocity = Contacts(GRAINS, 0.05), 1.0
    steady = master.steady_state(contacts, velocity=velocity)
    far = master.solve(contacts, [12.0], 1e-3, time=[12.0 / velocity])
    assert far.success and abs(far.force[0] - steady.force) < far.force_error * contacts.mean_threshold
    assert far.holding[0] == pytest.approx(steady.holding, abs=3e-4)
    curve = master.kinetic_curve(contacts, [velocity, 2.0], delay=[[0.0], [0.3]])
    assert curve.force[0, 0] == steady.force and (np.diff(curve.holding) < 0.0).all()
    assert (curve.holding[1] < curve.holding[0]).all()


def test_so_fast_that_none_holds_which_pins_on_the_way() -> None:
    contacts, path = Contacts(GRAINS), [0.5, 1.0, 4.0]
    quick, quickest = (master.solve(contacts, path, 1e-3, velocity=velocity) for velocity in (30.0, 50.0))
    assert quick.success and quickest.success and quickest.force[:2] == pytest.approx(quick.force[:2], abs=5e-3)
    for solved in (quick, quickest):
        assert abs(solved.force[2]) <= solved.force_error * contacts.mean_threshold < 1e-2
    assert quickest.holding[2] < 1e-12
    # some hold, but fewer than sums beside 1 can tell
    fast = master.solve(contacts, [0.5, 4.0, 6.0], 1e-4, velocity=10.0)
    assert fast.success and fast.force[0] > 0.1 and np.abs(fast.force[1:]).max() < 1e-6
    fast = master.propensity(contacts, velocity=20.0)
    assert fast.critical_spring == pytest.approx(master.propensity(contacts, velocity=10.0).critical_spring, rel=0.01)
    with pytest.raises(InputError, match="none holds but a fraction"):
        master.propensity(contacts, velocity=30.0)


def test_contacts_at_rest_grow_stronger() -> None:
    path = np.concatenate([[2.0, 2.0], np.linspace(2.2, 4.0, 10)])
    peaks = []
    for hold in (1.0, 30.0):
        time = np.concatenate([[2.0, 2.0 + hold], hold + path[2:]])
        solved = master.solve(Contacts(GRAINS), path, 5e-3, time=time)
        # nothing breaks at rest, but for the error of the solution
        assert solved.success and abs(solved.force[1] - solved.force[0]) < 1e-8 < solved.force_error
        peaks.append(float(solved.force[2:].max()))
    assert (np.diff(peaks) > 0.1).all(), peaks


def test_hazard_is_that_of_the_law_at_each_age() -> None:
    x = np.linspace(0.0, 3.0, 13)
    for age in (1.01 * FIRST, 1.0, 4.0, 300.0):
        np.testing.assert_allclose(np.exp(-GRAINS.hazard(x, age)), GRAINS.growth.thresholds(age).sf(x), atol=1e-13)
    assert GRAINS.hazard([0.0, 0.1], FIRST).tolist() == [0.0, np.inf]
    assert GRAINS.hazard(1e-7, FIRST + 1e-7) == pytest.approx(GRAINS.lost_hazard(1.0), rel=1e-5)


def test_refusals() -> None:
    cases = [
        (lambda: Contacts(GrainContact(GrainGrowth(ALPHA, B))), "age = None: is missing; give the contacts' age"),
        (lambda: growing_grains(ALPHA, B, 0.2), "age = 0.2: no grain pins before the age"),
        (lambda: Contacts(GRAINS, thermal=Thermal("soft", 0.1, 1.0, "paper")), 'thermal: closure = "paper" averages'),
        (lambda: Contacts(GRAINS, ageing=AGEING), "ageing: thresholds that grow with their age do age"),
        (lambda: Contacts(GRAINS, reforming=0.1), "reforming: contacts form again as their grains pin"),
        (lambda: Contacts(GRAINS, stiffness="linked"), "stiffness = 'linked': not defined with thresholds that grow"),
        (lambda: origins.mixture([GRAINS], [1.0]), "thresholds = <origins.grains.contact.GrainContact"),
    ]
    for call, begins in cases:
        with pytest.raises(InputError) as refusal:
            call()
        assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value), str(refusal.value)


def test_jumps_of_the_rate_of_breaks_are_edges_of_panels() -> None:
    """Births that break at once repeat a jump after each delay: halving found 3,000 nodes there."""
    path = np.linspace(0.0, 3.0, 31)
    solved = master.solve(Contacts(GRAINS, 0.1), path, 1e-9)
    assert solved.success and solved.nodes < 500
