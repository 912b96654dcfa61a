"""The plain twins of `master.solve`: orders of convergence, Eq. Q14c, and what docs/equations.md shows."""

from __future__ import annotations

from inspect import cleandoc
from pathlib import Path

import numpy as np
import pytest
from phase_type import gaussian_force
from scipy.stats import expon

import master
import origins
from master.paper import renewal
from master.paper.explicit import explicit
from master.paper.renewal import renewal_force
from master.renewal import budget, past
from master.survival.make import life_of
from origins.thresholds.scipy_laws import as_thresholds

PATH = np.linspace(0.0, 5.0, 501)
STEPS = (0.01, 0.005, 0.0025)
SCENE = origins.Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, 0.025))


@pytest.mark.parametrize(("breaking", "at_finest"), [("survival", 0.01179), ("printed", 0.01401)])
def test_gaussian_scene_converges_at_first_order(breaking, at_finest):
    exact = gaussian_force(PATH, 1.0, 0.05, 0.0, 0.025)
    errors = {
        step: np.abs(explicit(SCENE, PATH, step, breaking).force - exact).max() for step in STEPS
    }
    order = np.polyfit(np.log(list(errors)), np.log(list(errors.values())), 1)[0]
    assert abs(order - 1.0) < 0.2
    assert errors[STEPS[-1]] == pytest.approx(at_finest, rel=0.005)


def test_constant_hazard_slides_as_in_q14c():
    """P(x) = p beyond x_s: F_k = [x_s + 1/p + 1/p/(1 + p x_s)]/2, Eq. Q14c."""
    contacts = origins.Contacts(as_thresholds(expon(0.5, 0.25)))
    coarse, fine = (explicit(contacts, [30.0], step, "printed").force[0] for step in (0.01, 0.005))
    assert 2.0 * fine - coarse == pytest.approx(0.5 * (0.5 + 0.25 + 0.25 / 3.0), abs=1e-4)
    assert abs(fine - coarse) > 1e-3


def test_number_conservation_in_plain_steps_converges_at_second_order():
    exact = master.solve(SCENE, PATH, 1e-10).force
    errors = {step: np.abs(renewal_force(SCENE, PATH, step) - exact).max() for step in STEPS}
    order = np.polyfit(np.log(list(errors)), np.log(list(errors.values())), 1)[0]
    assert abs(order - 2.0) < 0.2
    assert errors[STEPS[-1]] == pytest.approx(1.9e-5, rel=0.05)


@pytest.mark.parametrize("start", [0.3, -0.3, origins.gaussian_start(-0.1, 0.1)])
def test_the_plain_steps_take_any_start(start):
    contacts, path = (
        origins.Contacts(origins.rectangular(0.5, 1.5), start),
        np.linspace(0.0, 3.0, 31),
    )
    coarse, fine = (renewal_force(contacts, path, step) for step in (0.01, 0.005))
    exact = master.solve(contacts, path, 1e-9).force
    assert np.abs(fine - exact).max() < 1e-4
    assert np.abs((4.0 * fine - coarse) / 3.0 - exact).max() < 1e-5


PAGE = (Path(__file__).parents[1] / "docs" / "equations.md").read_text(encoding="utf-8")


def test_the_page_shows_the_steps_as_they_run():
    shown = PAGE.split("```python\n")[1].split("```")[0]
    code = Path(renewal.__file__).read_text(encoding="utf-8")
    assert "".join(f"    {line}\n" for line in shown.splitlines()) in code


def test_the_page_shows_the_error_budget_as_it_is():
    """The table of ErrorBudget, and its numbers."""
    table = [
        line.strip() for line in cleandoc(budget.ErrorBudget.__doc__).splitlines() if "|" in line
    ]
    assert len(table) == 7 and "\n".join(table) in PAGE
    part, left_out = budget.FOR_BIRTHS, past.LEFT_OUT * budget.FOR_BIRTHS
    page = PAGE.replace("e-6", "e-06").replace("e-5", "e-05")
    for said in (
        f"{part:g} of a panel's for each piece",
        f"{left_out:g} of a panel's for each leg",
        f"both are {past.COARSER:g} times as much",
        f"{past.COARSER * part:g} and {past.COARSER * left_out:g} of a panel's part",
        f"{budget.LEAST_FOR_PANELS:g} of all or more",
        f"panels get {1.0 - budget.FOR_SUMS:g} of the rest",
    ):
        assert said in page, said


def test_the_page_divides_the_tolerance_of_the_readme_s_scene_as_solve_does():
    law, start = origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, 0.025)
    contacts, path = origins.Contacts(law, start), np.linspace(0.0, 5.0, 501)
    round_off, stretch = 6.0e-14, law.isf(1e-18)
    divided = budget.ErrorBudget.divide(1e-8, life_of(contacts), round_off, 1.438, 1.0)
    assert f"{divided.panels:.1e}".replace("e-09", "e-9") == "7.0e-9" and "a panel 7.0e-9" in PAGE
    assert stretch == pytest.approx(1.438, abs=1e-3) and "stretch of 1.438" in PAGE
    claimed = master.solve(contacts, path, 1e-8).force_error
    assert 2e-12 < claimed < 9e-12 and "force_error is 4.5e-12" in PAGE
