"""The paper's ageing closure on the way (Eq. Q15): what it converges to, what it does not keep, and stability."""

import numpy as np
import pytest
from q15_references import evolved, gaussian_force
from scipy import stats

import master
import origins
from master.paper.q15_step import Q15Stepper, make_ageing
from master.paper.q15_transient import paper_transient
from origins import Ageing, Contacts, InputError
from origins.laws.diffusion import Diffusion

FRESH, FINAL = origins.gaussian(0.5, 0.1), origins.gaussian(1.0, 0.01)  # Fig. A05
NARROW = origins.gaussian(0.5, 0.05)


def figure_a04(rate: float = 5e-4) -> Contacts:
    start, ageing = origins.gaussian_start(0.1, 0.025), Ageing(origins.gaussian(1.0, 0.02), rate, closure="paper")
    return Contacts(NARROW, start, ageing=ageing)


def test_propagator() -> None:
    """Second order in the step, keeps the sum, and what is at rest; against the exact exponential."""
    hops = Diffusion(FINAL, np.linspace(0.0, 1.3, 401))
    born = hops.weights(FRESH)
    exact = evolved(hops, born, 1e-4)
    parts = np.array([32, 64, 128])
    errors = [np.abs(make_ageing(hops, 1e-4, n)(born) - exact).sum() for n in parts]
    order = -np.polyfit(np.log(parts), np.log(errors), 1)[0]
    assert abs(order - 2.0) < 0.2 and errors[-1] < 2e-3
    for amount in (1e-9, 1e-4, 1.0, 1e6):
        step = make_ageing(hops, amount)
        assert step(born).sum() == pytest.approx(1.0, abs=1e-13)
        np.testing.assert_allclose(step(hops.stationary), hops.stationary, atol=1e-12)


def figure_a05(diffusion: float, start: object = None) -> Contacts:
    start = origins.gaussian_start(0.2, 0.1) if start is None else start
    return Contacts(FRESH, start, ageing=Ageing(FINAL, diffusion, closure="paper"))


def follow(stepper, length):  # type: ignore[no-untyped-def]
    """F and the mean of P_c, step by step."""
    middle = 0.5 * (stepper.edges[1:] + stepper.edges[:-1])
    told = [(stepper.state()[0], stepper.weights() @ middle)]
    while len(told) * stepper.step <= length:
        stepper.advance()
        told.append((stepper.state()[0], stepper.weights() @ middle))
    assert abs(stepper.state()[1]) < 1e-9 and stepper.state()[2] == 0.0
    return np.array(told)


def smooth_mean(values):  # type: ignore[no-untyped-def]
    """Mean under a bump without ends: what goes to and fro drops out."""
    u = (np.arange(len(values)) + 0.5) / len(values)
    weights = np.exp(-1.0 / (u * (1.0 - u)))
    return weights @ values / weights.sum()


@pytest.mark.parametrize("diffusion", [1e-5])
def test_runs_to_the_steady_state(diffusion: float) -> None:
    """From stretches that P_c keeps ahead of, spread evenly: where X brings decay."""
    start = stats.uniform(0.0, 0.4)
    runs = []
    for step in (0.005, 0.0025):
        stepper = Q15Stepper(figure_a05(diffusion, start), step, 1.0, "positivity", 16)
        runs.append(smooth_mean(follow(stepper, 13.0)[-round(4.0 / step) :]))
    force, mean = (4.0 * runs[1] - runs[0]) / 3.0
    c, known = gaussian_force(FRESH.mean(), FRESH.moment(2), 1.0, 0.01, diffusion)
    assert abs(force - known) < 1e-6 and abs(mean - c) < 1e-6


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
    assert printed.success and abs(printed.force[1] - 0.59981) < 2e-5 and abs(known.force[1] - 0.4795) < 1e-4


def test_defects_of_figure_a04() -> None:
    """Mass and sign are kept until contacts outrun P_c; from there on one of them is not, and every curve tells."""
    early = master.solve(figure_a04(), np.linspace(0.0, 0.7, 15), 1e-4)
    assert early.success and early.outrun == np.inf and early.message.endswith("P_c kept its mass and its sign")
    np.testing.assert_allclose(early.weights.sum(axis=1), 1.0, atol=1e-12)
    late = master.solve(figure_a04(), np.linspace(0.0, 1.5, 16), 1e-4)
    assert 0.75 < late.outrun < 0.9 and 0.05 < late.mass_defect[-1] < 0.1 and late.positivity_defect.max() == 0.0
    assert np.abs(late.mass_defect[late.path < 0.75]).max() < 1e-6 and (late.holding == 1.0).all()
    assert not late.success and "contacts outrun P_c" in late.message and late.force_error > 1e-4
    other = paper_transient(figure_a04(), np.linspace(0.0, 1.5, 16), 0.005, keep="mass")
    assert not other.success and other.path[-1] < 1.5 and "no thresholds are left" in other.message
    assert np.abs(other.mass_defect).max() < 1e-9


def test_single_fresh_value() -> None:
    ageing = Ageing(origins.gaussian(1.0, 0.05), 1e-3, closure="paper")
    told = master.solve(Contacts(origins.identical(0.6), origins.gaussian_start(0.1, 0.05), ageing=ageing), [0.3], 1e-3)
    # thresholds have hardly moved by then, nor have contacts come so far
    assert told.success and told.force[0] == pytest.approx(0.4, abs=1e-3)


def test_a_final_law_that_ends() -> None:
    """Thresholds are reflected at the wall: they come to lie evenly, while contacts stand far below."""
    ageing = Ageing(origins.rectangular(0.4, 0.8), 1.0, closure="paper")
    contacts = Contacts(origins.gaussian(0.6, 0.02), origins.gaussian_start(0.1, 0.02), ageing=ageing)
    told = master.solve(contacts, [0.2], 1e-4)
    assert told.success and told.force[0] == pytest.approx(0.3, abs=1e-6) and told.edges[-1] == 0.8
    even = np.diff(np.clip(told.edges, 0.4, 0.8)) / 0.4
    np.testing.assert_allclose(told.weights[0], even, atol=1e-4)


def test_refusals() -> None:
    printed = Ageing(FINAL, 1e-3, "paper")
    cases = [
        (lambda: master.solve(Contacts(FRESH, 0.1, ageing=printed), [1.0]), "start: all contacts at the one stretch"),
        (lambda: paper_transient(figure_a04(), [1.0], 0.01, keep="both"), "keep = 'both': "),
        (lambda: paper_transient(figure_a04(), [1.0], 1e-6), "step = 1e-06: needs more than 20,000 cells"),
        (lambda: paper_transient(figure_a04(), [1.0, 0.5], 0.01), "path[1] = 0.5: lies behind"),
        (lambda: paper_transient(Contacts(FRESH, 0.1), [1.0], 0.01), "contacts.ageing: is None"),
    ]
    for call, begins in cases:
        with pytest.raises(InputError) as refusal:
            call()
        assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value), str(refusal.value)
