"""Coupled contacts on a soft slider that has a mass: M X'' + γ X' = K (X_T - X) - F.

`slide` in `kernel.py` goes from event to event: a break, a return after the delay, a point of the path. `nearest.py`
finds the place of the next break; `moves.py` moves the slider there, on some nine moves of ten by short ways
(`quick_move`, `damped_move`), else in closed form with the time that `motion.py` finds; `state.py` has the slider, its
forces and energies. `swings.py` tells what is a slip, by the rule in `origins/drive.py`, and `chance.py` how much of a
fall chance makes of few contacts. `integrals.py` has what the motion adds to the energies; `heat.py` proposes breaks by
heat. `sliders.py` makes the input of all this, and its result.
"""
