"""An error that the panels' own rule cannot see, planted: `force_error` has to hold it."""

import numpy as np

import master
from master.lives.cold import ColdLife
from master.outcome import unheard
from master.rigid import solve_rigid
from origins import Contacts, Drive, gaussian

LOOP = np.concatenate([np.linspace(0.0, 1.3, 27), np.linspace(1.28, -0.6, 40)])


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
    """A wrong E satisfies number conservation as well; where nobody counts it, the claim is missed."""
    contacts, drive = Contacts(gaussian(1.0, 0.1)), Drive(LOOP)
    right = master.solve(contacts, LOOP, 1e-10).force
    silent, honest = (
        solve_rigid(contacts, drive, Wrong(contacts, says), 1e-8, unheard) for says in (False, True)
    )
    assert np.abs(silent.force - right).max() > 10.0 * silent.force_error
    assert np.abs(honest.force - right).max() <= honest.force_error
    assert not honest.success
