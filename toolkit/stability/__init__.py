"""Numerical stability: stiff and extreme cases through both solvers, each judged by a second road.

In reading order: `case.py`, what a case and its answer are; `table.py`, all cases, which stand in `thresholds.py`,
`surfaces.py`, `laws.py`, `speeds.py` and `sliders.py`; their second roads: `truths.py`, and for what has no closed form
`renewal.py`, `diffusing.py`, `cohorts.py` and `heavy.py`; `work.py`, solutions that end after so much work;
`scene_map.py` (values: `pushes.py`), the numbers of a scene pushed by decades; `report.py`, the page.

In `coverage.py`, `drawn.py` and `drawn_laws.py`, how often the errors that solvers state hold the true one, over cases
drawn at random (`precision --coverage`).
"""
