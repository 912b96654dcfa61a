"""The paper's ageing closure (Eq. Q15): closed forms, convergence, what it does not keep."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.linalg import solve_banded

import master
import origins
from master.paper.q15_transient import paper_transient
from origins import Ageing, Contacts, gaussian, identical
from origins.laws.diffusion import Diffusion
from origins.thresholds.scipy_laws import as_thresholds

FRESH, FINAL = origins.gaussian(0.5, 0.1), origins.gaussian(1.0, 0.01)  # Fig. A05


def gaussian_force(fresh, mean, std, diffusion):
    """C and F_k/(N_c <k>) (lengths) for a normal final law of `mean` and `std`, not cut at 0.

    `diffusion` is D_X >= 0 (lengths). With λ = D_X/std² and resets once in C, <x - mean> decays by
    1/(1 + λC) and what <(x - mean)²> has beyond std² by 1/(1 + 2λC).
    """
    fresh_mean, fresh_square = fresh.mean(), fresh.moment(2)
    rate = np.asarray(diffusion, dtype=float) / std**2
    # λ C² + (1 - λ mean) C - fresh mean = 0, the root that stays for λ = 0, without cancellation
    half = 0.5 * (1.0 - rate * mean)
    root = np.sqrt(half * half + rate * fresh_mean)
    with np.errstate(divide="ignore", invalid="ignore"):
        c = np.where(half > 0.0, fresh_mean / (half + root), (root - half) / rate)
    first, second = 1.0 / (1.0 + rate * c), 1.0 / (1.0 + 2.0 * rate * c)
    square = std**2 + (fresh_square - 2.0 * mean * fresh_mean + mean**2 - std**2) * second
    square = square + mean**2 + 2.0 * mean * (fresh_mean - mean) * first
    return c, 0.5 * square / c


@pytest.mark.parametrize("fresh", [FRESH, origins.identical(0.5)])
def test_steady_state_in_closed_form(fresh) -> None:
    diffusion = np.array([0.0, 1e-8, 1e-5, 1e-4, 1e-3, 1e-2, 1.0, 1e4])
    c, force = gaussian_force(fresh, 1.0, 0.01, diffusion)
    contacts = Contacts(fresh, ageing=Ageing(FINAL, 1.0, closure="paper"))
    curve = master.kinetic_curve(contacts, rate=diffusion)
    assert (np.abs(curve.force - force) <= 2.0 * curve.force_error).all()
    np.testing.assert_allclose(curve.force, force, rtol=1e-9)
    waiting = master.kinetic_curve(contacts, 4.0, rate=4.0 * diffusion, delay=0.1)
    np.testing.assert_allclose(waiting.holding, c / (c + 0.4), rtol=1e-9)
    np.testing.assert_allclose(waiting.force, curve.force * waiting.holding, rtol=1e-12)
    steady = master.steady_state(contacts, velocity=1e3)
    assert abs(steady.mean_threshold - c[4]) < 1e-12 and abs(steady.force - force[4]) < 1e-12
    # C is both the mean of P_c and the integral of its survival
    x = np.linspace(0.0, 1.5, 30_001)
    assert np.trapezoid(steady.distribution(x), x) == pytest.approx(1.0, abs=1e-7)
    assert steady.thresholds.mean() == pytest.approx(steady.mean_threshold, rel=3e-9)


@pytest.mark.parametrize("mean", [0.4, 3.0])
@pytest.mark.parametrize("fresh", [identical(1.0), gaussian(1.0, 4e-4), gaussian(1.0, 2e-5)])
def test_narrow_fresh_laws_on_either_side_of_the_final_mean(fresh, mean: float) -> None:
    """Those above the final mean spread upwards at first; widths below those of cells are in the error."""
    for diffusion in (1e-4, 3e-3, 0.1):
        ageing = Ageing(gaussian(mean, 0.04), diffusion, closure="paper")
        steady = master.steady_state(Contacts(fresh, ageing=ageing))
        c, force = gaussian_force(fresh, mean, 0.04, diffusion)
        assert abs(steady.force - force) <= steady.force_error < 1e-3
        assert abs(steady.cycle_length - c) <= steady.cycle_length_error


def test_its_error_bounds_what_rounding_does() -> None:
    found = []
    for unit in (1.0, 1.3, 1.7, 0.77, 2.9):
        ageing = Ageing(origins.gaussian(unit, 0.18 * unit), 2.3 * unit, closure="paper")
        contacts = Contacts(origins.gaussian(0.6 * unit, 0.0075 * unit), ageing=ageing)
        steady = master.steady_state(contacts)
        found.append([steady.force / unit, steady.cycle_length / unit])
        errors = 0.6 * np.array([steady.force_error, steady.cycle_length_error])
    assert (np.ptp(found, axis=0) <= 2.0 * errors).all()


def resting(fresh, final, amount, cells):  # type: ignore[no-untyped-def]
    """<x> and <x²> of diffusion with resetting, D C = amount: the resolvent of hops between cells."""
    edges = np.linspace(0.0, 6.0, cells + 1)
    hops = Diffusion(final, edges)
    up, down = amount * hops.up, amount * hops.down
    diagonal = 1.0 + np.append(up, 0.0) + np.append(0.0, down)
    p = solve_banded(
        (1, 1),
        np.stack([np.append(0.0, -down), diagonal, np.append(-up, 0.0)]),
        hops.weights(fresh),
    )
    middle = 0.5 * (edges[1:] + edges[:-1])
    return np.array([middle @ p, middle**2 @ p])


TWO_PEAKS = origins.mixture([origins.gaussian(0.7, 0.1), origins.gaussian(1.2, 0.1)], [0.5, 0.5])


@pytest.mark.parametrize("diffusion", [0.1])
@pytest.mark.parametrize(
    ("fresh", "final"),
    [
        (FRESH, origins.gw_plastic(1.5)),
        (origins.lubricated(0.4), as_thresholds(stats.gamma(9.0, scale=0.07))),
        (origins.rectangular(0.3, 0.7), TWO_PEAKS),
    ],
)
def test_other_targets_by_finite_volumes(fresh, final, diffusion: float) -> None:  # type: ignore[no-untyped-def]
    ageing = Ageing(final, diffusion, closure="paper")
    steady = master.steady_state(Contacts(fresh, ageing=ageing))
    c = steady.mean_threshold
    coarse, fine = (resting(fresh, final, diffusion * c, cells) for cells in (6000, 12_000))
    first, second = (4.0 * fine - coarse) / 3.0
    assert first == pytest.approx(c, rel=1e-6)
    assert 0.5 * second / c == pytest.approx(steady.force, rel=1e-6)


NARROW = origins.gaussian(0.5, 0.05)


def figure_a04(rate: float = 5e-4) -> Contacts:
    start = origins.gaussian_start(0.1, 0.025)
    ageing = Ageing(origins.gaussian(1.0, 0.02), rate, closure="paper")
    return Contacts(NARROW, start, ageing=ageing)


def test_order_of_convergence_is_two() -> None:
    """While mass and sign are kept."""
    contacts, path = figure_a04(), np.array([0.35, 0.5, 0.6, 0.7])
    steps = 0.7 / np.array([70, 140, 280, 560])
    forces = [paper_transient(contacts, path, float(h), cells=8).force for h in steps]
    errors = [np.abs(force - (4.0 * forces[-1] - forces[-2]) / 3.0).max() for force in forces[:-1]]
    order = np.polyfit(np.log(steps[:-1]), np.log(errors), 1)[0]
    assert abs(order - 2.0) < 0.2, (order, errors)


def test_as_printed_without_ageing() -> None:
    """At D = 0 it is not (Q5a): P_c is used up as contacts break."""
    start = origins.gaussian_start(0.1, 0.025)
    contacts = Contacts(origins.gaussian(1.0, 0.2), start, ageing=Ageing(FINAL, 0.0, "paper"))
    printed = master.solve(contacts, [0.5, 1.0], 1e-5)
    known = master.solve(Contacts(contacts.thresholds, contacts.start), [0.5, 1.0], 1e-8)
    assert printed.success and abs(printed.force[1] - 0.59981) < 2e-5
    assert abs(known.force[1] - 0.4795) < 1e-4


def test_defects_of_figure_a04() -> None:
    """Mass and sign are kept until contacts outrun P_c; from there on one of them is not, and every curve tells."""
    early = master.solve(figure_a04(), np.linspace(0.0, 0.7, 15), 1e-4)
    assert early.success and early.outrun == np.inf
    assert early.message.endswith("P_c kept its mass and its sign")
    np.testing.assert_allclose(early.weights.sum(axis=1), 1.0, atol=1e-12)
    late = master.solve(figure_a04(), np.linspace(0.0, 1.5, 16), 1e-4)
    assert 0.75 < late.outrun < 0.9 and 0.05 < late.mass_defect[-1] < 0.1
    assert late.positivity_defect.max() == 0.0
    assert np.abs(late.mass_defect[late.path < 0.75]).max() < 1e-6 and (late.holding == 1.0).all()
    assert not late.success and "contacts outrun P_c" in late.message and late.force_error > 1e-4
    other = paper_transient(figure_a04(), np.linspace(0.0, 1.5, 16), 0.005, keep="mass")
    assert not other.success and other.path[-1] < 1.5 and "no thresholds are left" in other.message
    assert np.abs(other.mass_defect).max() < 1e-9


def test_wall_time_ends_the_halving_of_steps() -> None:
    found = master.solve(figure_a04(), np.linspace(0.0, 1.0, 5), wall_time=1e-9)
    assert not found.success and "wall_time" in found.message and found.force.size == 5
    assert found.force_error == np.inf
