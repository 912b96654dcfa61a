"""A soft slider: a spring between the drive and the slider, and what its slips do.

`solution.py` comes first. It leaves out heat too weak for steps (`in_time/idle_heat.py`), and lets one of two follow
the slider; both give a `Followed` (`followed.py`):

- `cold.py`, where no law depends on time: straight moves (`moves.py`; in slips in which broken contacts stay out
  `moves_without_births.py`) of a slider on `cold_contacts.py`, each on the panels of master.renewal, and the load
  along a move (`curve.py`), which tells where slips begin and end, far ahead by waves (`decohered.py`); what a turn
  does to errors (`turns.py`); slips that become alike are repeated (`limit_cycle.py`); whether slips hang on heat
  that is left out (`left_out.py`, `first_fall.py`); ways that are refused before the work (`too_long.py`);
- `in_time/`, in steps of time, where one does: `refined` in its `refining.py`, which first refuses what takes too many
  (its functions `refuse_...`).

Then `regime.py` judges the slips (`slips.py`), at T = 0 those beyond the path, too (`slips_ahead.py`): whether their
drops fade (`drops.py`), and, with a mass, whether they are but swings of its start (`unfed_swings.py`). Of a
slider with a mass `inertia/solution.py` comes first.

Tests: tests/test_soft.py, test_any_spring.py and, for slips of "reform-after", test_reform_after.py with a plain twin.
"""
