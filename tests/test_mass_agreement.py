"""Sliders with mass by both solvers, slip by slip: means of N contacts, extrapolated, against the master equation.

The mean of a slip's X_T and forces differs from that of infinitely many contacts by N^(-2/3), as the slider is slow
where F' = -K, and by the next order, N^(-1): three N give the value without both. The test has power: it tells machines
apart whose mass, damping or delay differs by 2 %.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest
from conftest import slow

import eq_model
import master
import origins

SLIPS = ("drive", "force_before", "force_after", "duration", "top_speed")
# sliders of each N; without a delay more, as their slips differ less between machines
SIZES, REPLICAS = np.array([4_000, 32_000, 256_000]), np.array([120, 40, 10])
MORE = 5
# weights of the means at three N in their value without the powers 2/3 and 1 of 1/N
WEIGHTS = np.linalg.inv(np.stack([SIZES**-power for power in (0.0, 2 / 3, 1.0)], axis=1))[0]
MASS, VELOCITY = 0.1, 0.3
DAMPED = 0.25  # in units of critical damping of mass and spring
FURTHEST = 4.0  # largest difference, in standard errors
SEEN = 0.02  # change of a number of the machine that the test sees


class Pulled(NamedTuple):
    """Contacts at their start, the spring, and how far it is pulled without a delay and with one."""

    thresholds: Any
    start: Any
    spring: float
    ends: tuple[float, float]


PULLED = {
    "gaussian": Pulled(origins.gaussian(1.0, 0.2), 0.0, 0.1, (11.0, 22.0)),
    "lubricated": Pulled(origins.lubricated(1.0), 0.0, 0.05, (21.0, 22.0)),
    "persson": Pulled(
        origins.persson(1.0, 0.5), origins.gaussian_start(0.1, 0.1), 0.1, (11.0, 14.0)
    ),
}
CASES = [(law, damped, delay) for law in PULLED for damped in (0, 1) for delay in (0.0, 0.3, 3.0)]
# the same of a fourth of the sliders, whose means are known half as well; only the delay is changed, by twice as much
QUICK = ("persson", 1, 3.0, 4)


def asked(law: str, **numbers: float) -> dict[str, Any]:
    """Arguments of both solvers for a machine with these mass, damping and delay; without a delay if it is 0."""
    pulled, delay = PULLED[law], numbers.pop("delay")
    contacts = origins.Contacts(
        pulled.thresholds, pulled.start, delay=origins.Delay(delay) if delay else None
    )
    machine = {"spring": pulled.spring, "velocity": VELOCITY} | numbers
    return {"contacts": contacts, "path": [pulled.ends[delay > 0.0]]} | machine


@pytest.mark.parametrize("law, damped, delay, fewer", [QUICK, *(slow(*case, 1) for case in CASES)])
def test_both_solvers_have_the_same_slips(law: str, damped: int, delay: float, fewer: int) -> None:
    damping = DAMPED * damped * 2.0 * (PULLED[law].spring * MASS) ** 0.5
    numbers = {"mass": MASS, "damping": damping, "delay": delay}
    found = master.solve(**asked(law, **numbers), tolerance=3e-5 * fewer**2)
    count, replicas = found.slips.drive.size, REPLICAS * (1 if delay else MORE) // fewer
    assert found.success, found.message
    assert count > 0
    drawn = [
        eq_model.simulate(**asked(law, **numbers), n_contacts=n, n_replicas=many, seed=1).slips
        for n, many in zip(SIZES.tolist(), replicas.tolist(), strict=True)
    ]
    # so many contacts slip as often as infinitely many
    assert np.bincount(drawn[-1].replica).tolist() == replicas[-1] * [count]
    means = np.array(
        [[[one.mean(name, k) for name in SLIPS] for k in range(count)] for one in drawn]
    )
    value = np.tensordot(WEIGHTS, means[..., 0], 1)
    error = np.tensordot(WEIGHTS**2, means[..., 1] ** 2, 1) ** 0.5

    def off(other: Any) -> float:
        exact = np.array([getattr(other.slips, name) for name in SLIPS]).T
        both = min(len(exact), count)
        return float((np.abs(exact[:both] - value[:both]) / error[:both]).max())

    assert off(found) < FURTHEST
    for name in [name for name, number in numbers.items() if number] if fewer == 1 else ["delay"]:
        changed = numbers | {name: (1.0 + SEEN * fewer**0.5) * numbers[name]}
        other = master.solve(**asked(law, **changed), tolerance=3e-4)
        assert off(other) > FURTHEST, name


def test_identical_contacts_have_the_same_slips_in_both_solvers() -> None:
    """Pieces of oscillators: to what an ensemble's whole units and the master equation's steps leave. In the third and
    the eighth slip the force rises by less than 0.02 on its way down, which belongs to the slip."""
    contacts, path = origins.Contacts(origins.identical(1.0)), np.linspace(0.0, 20.0, 101)[1:]
    machine = {"spring": 0.5, "mass": 0.3, "damping": 0.2, "velocity": 0.3}
    by_master = master.solve(contacts, path, 1e-7, **machine).slips
    by_contacts = eq_model.simulate(contacts, path, n_contacts=20_000, **machine).slips
    assert by_master.drive.size == by_contacts.drive.size == 10
    for name in SLIPS[:-1]:
        both = getattr(by_master, name), getattr(by_contacts, name)
        assert np.abs(both[0] - both[1]).max() < 1e-5, name
    # the top speed is that of a parabola through three of the times that are looked at
    assert np.abs(by_master.top_speed - by_contacts.top_speed).max() < 1e-3


@pytest.mark.parametrize("draws", [range(8), slow(range(8, 40))], ids=["few", "many"])
def test_drawn_machines_have_the_same_slips_in_both_solvers(draws: range) -> None:
    """Of 1e5 contacts, which slip early by some hundredths of <x_s>/K. Swings down in which the force rises for a while
    are among them, and turns at which contacts that come back hold the slider for a moment."""
    laws, slips = [origins.identical(1.0), *map(origins.gaussian, [1.0] * 3, [0.05, 0.2, 0.4])], 0
    for k in draws:
        rng = np.random.default_rng(k)
        spring, mass, ratio = 10.0 ** rng.uniform([-1.3, -3.0, -1.3], [-0.2, -0.3, 0.7])
        swing = 2.0 * np.pi * (mass / spring) ** 0.5
        machine = {"spring": spring, "mass": mass, "damping": 2.0 * ratio * (mass * spring) ** 0.5}
        machine["velocity"] = 10.0 ** rng.uniform(-1.5, 0.3)
        delay = origins.Delay(swing * 10.0 ** rng.uniform(-0.5, 1.0)) if k // 4 % 2 else None
        contacts = origins.Contacts(laws[k % 4], delay=delay)
        asked: dict[str, Any] = {"path": [3.0 / spring + 3.0]} | machine
        by_master = master.solve(contacts, tolerance=1e-3, **asked)
        by_contacts = eq_model.simulate(contacts, n_contacts=100_000, seed=2, **asked).slips
        if not by_master.success:
            continue
        assert by_master.slips.drive.size == by_contacts.drive.size, k
        for name in ("force_before", "force_after"):
            both = getattr(by_master.slips, name), getattr(by_contacts, name)
            assert np.abs(both[0] - both[1]).max(initial=0.0) < 0.02, (k, name)
        slips += by_contacts.drive.size
    assert slips > len(draws)


@pytest.mark.slow
def test_both_solvers_lose_the_same_energy_while_an_undamped_slider_swings_on() -> None:
    """Each delay of 3.3 swings all contacts come back and break. Between, the energy that breaks have taken says what
    held in all of them, whatever phase the swing had; each contact breaks once a delay, at 0.52 <x_s>² or less."""
    spring, swing = 1e-4, 100.0
    delay, mass = 3.3 * swing, spring * (swing / (2.0 * np.pi)) ** 2
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2), delay=origins.Delay(delay))
    machine = {"spring": spring, "mass": mass}
    begins = master.solve(contacts, [7.5 / 10.0 / spring], 2e-2, **machine).slips.drive[0]
    path = begins + delay * (0.5 + np.arange(6))
    found = master.solve(contacts, path, 2e-2, **machine)
    assert found.success and found.slips.drive.size == 1
    drawn = eq_model.simulate(
        contacts, path, n_contacts=16_000, n_replicas=8, seed=1, **machine
    ).energy.released
    error = drawn.std(axis=0, ddof=1) / len(drawn) ** 0.5
    off = np.abs(drawn.mean(axis=0) - found.energy.released)
    assert (off < FURTHEST * error).all() and (error < 2e-3).all()
    assert (found.energy.released < 0.52 * (1.0 + np.arange(6)) + 0.1).all()
