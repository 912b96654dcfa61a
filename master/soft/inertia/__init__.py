"""A soft slider with a mass, M X'' + γ X' = K (X_T - X) - F.

`solution.py` makes the answer of several runs (`run.py`) with ever smaller tolerances (`runs.py`), whose differences
are the error. At T = 0 without delay (`slider.py`) the contacts' force depends on the way alone. The state (`body.py`)
is the time, the travel since the slider turned last, its speed, and energies; three modes of motion take turns, and
each says which comes next:

1. `moving.py`: contacts break, and X follows an ordinary differential equation;
2. `elastic.py`: none breaks after a turn, and the motion is a damped oscillator in closed form (`oscillation.py`);
3. `following.py`: nothing rings, and X follows its drive in balance, but for a lag in powers of γ and M (`slow.py`).

The force on a straight move, and what the contacts store, come from the panels of a march (`reaction.py`).
`record.py` keeps results at the asked times and finds slips, the falls of the spring's force after a stick;
`closed_falls.py` looks for them in motions of closed form; `foretold.py` refuses, before the work, sliders that would
ring for too long.
With a delay births depend on time: `delayed/` has a state and motions of its own. Where it is so short that it only
takes from the damping, it is left out (`short_delay.py`). With any other law beside thresholds and start `in_time/`
takes steps of time. Weak heat is left out: `heat_left_out.py` says whether a slip hangs on it. Whether a delay lets
swings of steady sliding grow, and how large, is told by `growing_swings.py`.

In reading order: `slider.py`, `body.py`, `reaction.py`, the three modes, `record.py`, `run.py`, `short_delay.py`,
`runs.py`, `energy_errors.py`, `solution.py`; then `delayed/` and `in_time/`.
Tests: tests/test_mass_master.py, test_mass_turns.py, test_mass_energy.py, test_mass.py and test_mass_agreement.py.
"""
