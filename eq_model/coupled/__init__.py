"""Coupled contacts: N of them on one soft slider, which a spring pulls (paper Sec. III E).

In reading order: `ensemble.py`, replicas followed along the drive; `slider.py`, a slider's state and the pull of its
spring; `queue_kernel.py`, breaks in the order of their positions; `slide_kernel.py`, from break to break, and
avalanches; `moves.py`, moves between breaks; `forming.py`, contacts that form; `turns.py`, a drive that turns;
`heat.py` and `heat_moves.py`, breaks by heat; `ages.py`, thresholds that strengthen; `work.py`, how long it takes; and
`mass/`, a slider with mass.
"""
