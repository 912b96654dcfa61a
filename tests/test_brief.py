"""Reprs of results: a line or two, however many points they have."""

import numpy as np

import eq_model
import master
import origins
import toolkit


def test_a_result_is_told_in_a_line() -> None:
    contacts = origins.Contacts(origins.gaussian(1.0, 0.1))
    path = np.linspace(0.0, 0.5, 900)
    solved = master.solve(contacts, path, 1e-4)
    told = repr(solved)
    assert told.startswith("Solution(path=<900 from 0 to 0.5>, force=<900 from ")
    assert (
        f"force_error={solved.force_error!r}" in told
        and "success=True, message='error estimate" in told
    )
    simulated = eq_model.simulate(contacts, path, n_contacts=10, n_replicas=1)
    for one in (
        solved,
        simulated,
        toolkit.run("identical"),
        master.kinetic_curve(contacts, np.ones((30, 40))),
    ):
        assert len(repr(one)) < 1500 and "\n" not in repr(one)
    assert "force=array([0.505, 0.505])" in repr(master.kinetic_curve(contacts, [1.0, 2.0]))
    assert "velocity=<30x40 from 1 to 1>" in repr(master.kinetic_curve(contacts, np.ones((30, 40))))
