"""Errors that the panels' own rule cannot see, planted one by one: `force_error` has to hold them.

The rule looks at polynomials and at number conservation, both of which a wrong E satisfies as well
as the right one. Each test has a control: where nobody counts what was planted, the force is
further off than it claims.
"""

from __future__ import annotations

import numpy as np

import master
from master.lives.cold import ColdLife
from master.outcome import unheard
from master.rigid import solve_rigid
from origins import Contacts, Drive, gaussian

LOOP = np.concatenate([np.linspace(0.0, 1.3, 27), np.linspace(1.28, -0.6, 40)])


def solved(contacts, life, path=LOOP, tolerance=1e-8, time=None):
    """What `solve` does with a life of the test's own."""
    return solve_rigid(contacts, Drive(path, 1.0, time, None, "reset"), life, tolerance, unheard)


def apart(one, other):
    """Largest difference of two forces."""
    return float(np.abs(one.force - other.force).max())


class Wrong(ColdLife):
    """A life whose E is smooth, and wrong by up to a millionth; it says so, or not."""

    def __init__(self, contacts, says):
        super().__init__(contacts)
        self.error = 1e-6 if says else 0.0

    def left(self, born, history):
        share, force = super().left(born, history)
        wrong = 1.0 + 4e-6 * (1.0 - share) if np.ndim(share) else 1.0
        return np.stack([share * wrong, force * wrong])


def test_an_error_of_the_survival_is_in_the_error_of_the_force():
    contacts = Contacts(gaussian(1.0, 0.1))
    right = master.solve(contacts, LOOP, 1e-10)
    silent, honest = (solved(contacts, Wrong(contacts, says)) for says in (False, True))
    assert apart(silent, right) > 10.0 * silent.force_error
    assert apart(honest, right) <= honest.force_error
    assert not honest.success
