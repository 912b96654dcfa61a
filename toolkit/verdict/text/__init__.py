"""The verdict in words: the sentence, its table, what it hangs on, and what was not answered.

In reading order: `words.py`, the sentence and the page; what stands beside the answer in it: `doubts.py`, `spread.py`,
`above_static.py`, `over_load.py`, `k_star.py`, `border.py`; `table.py` with `slip_rows.py`; `hangs_on.py`, which asks
`kinds.py`, `of_delay.py` with `swinging.py`, `of_heat.py`, `of_stuck_sliders.py` and `of_mass.py`; and `undone.py`.
"""
