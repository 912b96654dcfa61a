"""Steps: one step of a slider that a spring pulls, at whose end the forces balance, K (X_T - X) = F.

A step has a size, and two parts that add up to it: the travel of the slider, in units of `Steps.length`, and the time
that it takes, in time units (see TimeUnits). The size is chosen; the balance of forces decides how much of it is time.
So steps are even both where the slider creeps, and nearly all is time, and just before a slip, where dX/dt diverges and
nearly all is travel (pseudo-arclength continuation).

Steps of the size s = 1 on K = 0.2 at v = 1, of P_c(1, 0.2) with heat ("soft", 0.05, 0.1), from rest; `length` 0.1013
(a test computes these numbers). Travel is (s - τ) `length`:

    step 1:  τ = 0.215, the time 0.477, travel 0.0796, F = K (X_T - X) = 0.0796: stuck, the drive stretches the spring
    step 10: τ = 0.079, the time 0.181, travel 0.0933, F = 0.6896: contacts break, the slider moves ever faster
    step 11: τ < 0: no balance, as even in no time F falls below the pull of the spring: a slip

Files:

    steps.py        the step of a size, and the size of a step        I = K (X_T - X) - F for its part in time τ
    balance.py      the search for that part                          I(τ) = 0
    time_units.py   the measure of that part                          rate t + c ln(1 + t/first)
"""

from master.soft.in_time.steps.balance import Root, TriedStep, secant
from master.soft.in_time.steps.steps import CONTROL, FIRST_FRACTION, Guess, Node, StepControl, Steps

__all__ = [
    "CONTROL",
    "FIRST_FRACTION",
    "Guess",
    "Node",
    "Root",
    "StepControl",
    "Steps",
    "TriedStep",
    "secant",
]
