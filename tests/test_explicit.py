"""The paper's explicit scheme: order of convergence, and Eq. Q14c."""

from __future__ import annotations

import numpy as np
import pytest
from phase_type import gaussian_force
from scipy.stats import expon

import origins
from master.paper.explicit import explicit
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
