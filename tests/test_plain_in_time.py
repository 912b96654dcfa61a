"""The plain twin of soft sliders in steps of time: its order, and its limit beside the solver."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from plain_in_time import pulled

import master
from master.soft.in_time.breaks import BreaksInSteps
from master.soft.in_time.threshold_cells import ThresholdCells
from origins import Contacts, Delay, Thermal, gaussian

WIDE = gaussian(1.0, 0.2)
CASES = {
    "delay": Contacts(WIDE, delay=Delay(0.25)),
    "heat": Contacts(WIDE, thermal=Thermal("soft", 0.1)),
}
SPRING, VELOCITY = 2.0, 1.0
# of the twin's cells of thresholds, measured by halving them
OF_CELLS = 1e-5


@pytest.mark.parametrize("name", CASES)
def test_equal_steps_are_of_second_order_and_lead_to_the_solver_s_force(name: str) -> None:
    solved = master.solve(CASES[name], [1.0], 1e-4, velocity=VELOCITY, spring=SPRING)
    assert solved.success, solved.message
    assert not solved.slips.drive.size
    coarse, middle, fine = (
        pulled(CASES[name], SPRING, VELOCITY, 1.0, steps)[-1] for steps in (16, 32, 64)
    )
    assert abs(np.log2((coarse - middle) / (middle - fine)) - 2.0) < 0.2
    limit = fine + (fine - middle) / 3.0
    assert abs(limit - solved.force[0]) < solved.force_error + OF_CELLS


def test_contacts_that_are_left_out_while_they_hold_name_themselves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Cohorts go as soon as less than 0.3 of them holds: their number would be made up by births."""
    monkeypatch.setattr("master.soft.in_time.contacts.DEAD", 0.3)
    found = master.solve(CASES["heat"], [2.0], 1e-3, velocity=VELOCITY, spring=SPRING)
    assert not found.success and "was left out while it held" in found.message


def test_breaks_that_are_lost_name_themselves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the breaks are forgotten as a step is taken: more have formed and not broken than hold."""
    true = BreaksInSteps.add
    monkeypatch.setattr(BreaksInSteps, "add", lambda of, now, breaks: true(of, now, 0.5 * breaks))
    found = master.solve(CASES["delay"], [1.0], 1e-3, velocity=VELOCITY, spring=SPRING)
    assert not found.success and "number is not conserved: after t = " in found.message


def test_the_cell_of_the_least_threshold_that_holds_is_continued_along_its_barrier() -> None:
    """Where ln A falls linearly with x_s², as along a barrier, its value at a threshold within a cell is exact."""
    edges = np.linspace(0.4, 1.6, 13)
    beyond = WIDE.sf(edges)
    cells = ThresholdCells(CASES["heat"], edges, beyond)
    least, stretch = 0.83, 0.8  # in the cell from 0.8 to 0.9

    def log(x: np.ndarray) -> np.ndarray:
        return 3.0 - 4.0 * x**2

    integrals = np.exp(log(edges))
    integrals[edges < least] = (
        1e3  # of contacts that have met their thresholds: not to be asked for
    )
    unmet = float(WIDE.sf(least))
    found, force = cells.survival_and_force(
        integrals[None], np.array([stretch]), np.array([least]), np.array([unmet])
    )
    ends = np.append(least, edges[edges > least])
    shares = -np.diff(np.append(unmet, beyond[edges > least]))
    along = np.linspace(0.0, 1.0, 4001)
    means = [
        np.trapezoid(np.exp(-np.exp(log(low) + along * (log(high) - log(low)))), along)
        for low, high in pairwise(ends)
    ]
    assert abs(found[0] - shares @ means) < 1e-8
    assert abs(force[0] - stretch * found[0]) < 1e-15
