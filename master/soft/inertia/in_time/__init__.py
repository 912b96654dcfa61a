"""Sliders with mass in steps of time: heat that matters, ageing, thresholds that grow, and re-forming stretched.

    M X'' + γ X' = K (X_T - X) - F

The contacts are those of `master.soft.in_time` (`ContactsInSteps`), and so is a step's size: what part of it is travel
and what part time is found by a secant. A step is right where the slider's own motion in that time is that travel. With
mass nothing is unstable: no slip rule is needed, and a step of any small size has a solution.

    swing_steps.py   a swing: a damped oscillator on the contacts that hold, pulled by the rest of F, which grows evenly
    balanced_steps.py   in balance: K (X_T - X) - F - γ V = 0, where the inertia that this leaves out is small
    steady_sliding.py, steady_motion.py   long ways without steps, on which F is F_k of the present speed
    long_slips.py    slips by a million thresholds of contacts that form at once: F is F_k(V) there, too
    ringing.py       a stuck slider on contacts that hold, which swings in closed form until it rests
    flights.py       ways without steps on which contacts wait for their delay, and the spring alone moves the slider
    slider.py        one after another, from turn to turn of the slider and of the drive
    node.py          the end of a step
    falls.py         falls of the spring's force, and slips among them, as `master.soft.inertia.record` defines them
    refining.py      steps of 1, 1/2, 1/4 ... until the error is within the tolerance
    answer.py        the limit of steps 0, and its error
    energy_errors.py energies, and theirs
    clocks.py        when each slider is read for that, as a slip comes a little earlier or later on halved steps

Sections along which all is smooth end where the slider turns round (V = 0), as contacts may break ahead of it and not
behind; where a swing becomes small, so that longer steps follow it; and where the slider comes to rest or leaves it.

Tests: tests/test_mass_laws_in_time.py, beside the two other roads at T = 0 and even steps with cohorts; and
tests/test_mass_steady_sliding.py; tests/test_mass_long_slips.py; tests/test_mass_flights.py.
"""
