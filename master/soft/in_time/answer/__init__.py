"""The answer of sliders that solved the same path with halved steps: read at the times asked, extrapolated, its error.

`extrapolation.py` gives it, from what `reading.py` reads between the ends of steps; `aligned.py` reads the
share that holds, with a delay, as far from each slider's own slips; `near_slip.py` says whether steps leave open if a
slip comes before the drive turns, slows down or ends.
"""
