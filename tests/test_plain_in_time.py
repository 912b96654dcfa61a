"""The plain twin of soft sliders in steps of time: its order, and its limit beside the solver."""

from __future__ import annotations

import numpy as np
import pytest
from plain_in_time import pulled

import master
from master.soft.in_time.breaks import BreaksInSteps
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
    assert solved.success and not solved.slips.drive.size
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
