"""Contacts whose thresholds grow with their age, against contacts one by one."""

import numpy as np
import pytest

import master
import origins
from origins import Ageing, Contacts, Delay, GrainContact, GrainGrowth, InputError, Thermal, gaussian, growing_grains

ALPHA, B = 1.0, 1.0
GRAINS = growing_grains(ALPHA, B, age=4.0)
AGEING = Ageing(gaussian(1.0, 0.1), rate=1e-3)
FIRST = GRAINS.growth.first_pinning_time


def simulate(contacts: Contacts, path: np.ndarray, time: np.ndarray, step: float) -> np.ndarray:
    """Mean stretch and holding fraction, each with its standard error, at the ends of straight pieces: every contact
    keeps a quantile, as a hazard, and breaks where that of its law at its stretch and age exceeds it."""
    generator, count = np.random.default_rng(3), 6_000
    grains, wait = contacts.grains, contacts.waiting_time
    x = np.full(count, contacts.start.mean())
    pinned = np.full(count, FIRST - grains.age)  # when
    own = np.array(grains.hazard(np.abs(x), grains.age)) + generator.exponential(size=count)
    clock, told = 0.0, []
    for travel, duration in zip(np.diff(path, prepend=0.0), np.diff(time, prepend=0.0), strict=True):
        steps = int(np.ceil(max(abs(travel), duration) / step))
        dx, dt = travel / steps, duration / steps
        for _ in range(steps):
            clock += dt
            x += dx
            new = np.flatnonzero((pinned > clock - dt) & (pinned <= clock))
            x[new], own[new] = dx / dt * (clock - pinned[new]), generator.exponential(size=new.size)
            holds = np.flatnonzero(pinned <= clock)
            broken = holds[grains.hazard(np.abs(x[holds]), FIRST + clock - pinned[holds]) > own[holds]]
            # those that pinned within the step never held, others broke somewhere in it
            late = np.where(np.isin(broken, new), pinned[broken], clock - dt * generator.random(broken.size))
            pinned[broken] = late + wait
        force, holding = np.where(pinned > clock, 0.0, x), pinned <= clock
        told.append([(one.mean(), max(one.std(), 1e-2) / np.sqrt(count)) for one in (force, holding)])
    return np.array(told)


SLIDE_HOLD_SLIDE = np.array([0.5, 1.0, 2.0, 3.0, 3.0, 3.0, 3.2, 3.4, 3.6, 4.0, 4.5, 5.5])
CASES = {
    "hold": (0.0, SLIDE_HOLD_SLIDE, np.array([0.5, 1.0, 2.0, 3.0, 3.5, 8.0, 8.2, 8.4, 8.6, 9.0, 9.5, 10.5]), 0.0),
    "turns, delay": (0.1, np.array([0.7, 1.4, 0.6, -0.5, -1.5, 0.0]), np.array([1.0, 2.0, 3.2, 5.0, 6.0, 7.0]), 0.2),
}


@pytest.mark.parametrize("name", CASES)
def test_paths_in_time_against_contacts_one_by_one(name: str) -> None:
    start, path, time, delay = CASES[name]
    contacts = Contacts(GRAINS, start, delay=Delay(delay))
    solved = master.solve(contacts, path, 2e-3, time=time)
    assert solved.success, solved.message
    told = simulate(contacts, path, time, 1e-2)
    own = solved.force_error * contacts.mean_threshold
    z = (told[:, 0, 0] - solved.force) / (told[:, 0, 1] + own), (told[:, 1, 0] - solved.holding) / (told[:, 1, 1] + own)
    assert np.abs(z).max() < 5.0, z


def test_far_along_the_force_is_that_of_steady_sliding() -> None:
    """One road steps in time and lets those that never hold wait again, the other knows their mean wait alone."""
    contacts, velocity = Contacts(GRAINS, 0.05), 1.0
    steady = master.steady_state(contacts, velocity=velocity)
    far = master.solve(contacts, [12.0], 5e-4, time=[12.0 / velocity])
    assert far.success and abs(far.force[0] - steady.force) < far.force_error * contacts.mean_threshold
    assert far.holding[0] == pytest.approx(steady.holding, abs=1e-4)
    curve = master.kinetic_curve(contacts, [velocity, 2.0], delay=[[0.0], [0.3]])
    assert curve.force[0, 0] == steady.force and (np.diff(curve.holding) < 0.0).all()
    assert (curve.holding[1] < curve.holding[0]).all()


def test_contacts_at_rest_grow_stronger() -> None:
    path = np.concatenate([[2.0, 2.0], np.linspace(2.2, 4.0, 10)])
    peaks = []
    for hold in (1.0, 30.0):
        time = np.concatenate([[2.0, 2.0 + hold], hold + path[2:]])
        solved = master.solve(Contacts(GRAINS), path, 5e-3, time=time)
        assert solved.success and solved.force[1] == pytest.approx(solved.force[0], abs=1e-12)
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
        (lambda: master.solve(Contacts(GRAINS), [1.0], spring=1.0), "contacts.thresholds: master.solve takes none"),
        (lambda: master.solve(Contacts(GRAINS, thermal=Thermal("soft", 0.1)), [1.0, 0.0]), "contacts.thermal: with thres"),
        (lambda: origins.mixture([GRAINS], [1.0]), "thresholds = <origins.grain_contact.GrainContact"),
    ]
    for call, begins in cases:
        with pytest.raises(InputError) as refusal:
            call()
        assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value), str(refusal.value)
