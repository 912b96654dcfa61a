"""The verdict on an interface and its machine: does it stick and slip, how strongly, and what does that hang on?

Whether a slider sticks and slips is decided from its slips in `master/soft/regime.py`, which `toolkit/results/kinds.py`
puts in one word; `sliders/` chooses which solver tells, of how many contacts, and how far they are driven.
`Behaviour`, what a slider does, and `Finite`, what as many contacts as the area holds do, stand in
`sliders/records.py`: each is what one teller says, and is replaced as a whole where another one tells in its place.

In reading order: `answers.py`, what a verdict holds; `sliders/`, what sliders do; `readings.py`, over what they are
compared; `with_mass.py`, more of a slider with mass; `uncertainty.py` and `of_area.py`, how well the numbers are known,
and what the contacts of the area do; `mean_force.py`, the force over slips; `judge.py`, which asks all of these;
`text/` with `slips_in_words.py`, `files.py` with `legend.py`, and `picture.py` with `trace.py`, which show what was
found; `report.py`, which the command `verdict` calls, and which writes them.

A scene goes through them so: `commands.verdict`, `report.report_verdict`, `judge.verdict` (all readings),
`judge.answer_of` (one reading), `sliders/follow.py:follow` (one slip rule), `sliders/told.py:behaviour_of`, which says
stick-slip, smooth or undecided; then `sliders/finite.py` for the contacts of the area, and `text/words.py:sentence`.
"""
