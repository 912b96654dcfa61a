"""A slider with mass whose contacts form again one delay after they break: births are known before they come.

State (`DelayedBody`): time, X and dX/dt; contacts in `Cohorts` that formed at one position each, of which the largest
|x| so far tells how many hold (T = 0); the `PastBreaks`, which are the births one delay later; and the leg of the
drive. Contacts that break at an exact threshold do so together, and form again together: a lump.

Two kinds of motion take turns (`DelayedSlider.run`), and change the body by its methods alone:

1. While contacts break or form, a `TimePanel` of time: X, breaks and force are polynomials through the nodes of Radau's
   rule, at which M dW/dt + γ W + F = K (X_T - X) is imposed and solved by Newton's method (`Collocation`). A panel that
   misses more than the accuracy is narrowed; one on which the slider turns, or passes a place at which the force has a
   kink, is cut there; it ends where births have a kink, one, two or three delays after one of breaks (`OnPanels`, which
   changes the body, and `PanelSearch`, which finds the panels).
2. While hardly a contact breaks or forms, F is a straight line in X: the motion is a damped swing in closed form up to
   where contacts would break, the next births come or the drive's leg ends (`Swinging`; `SwingEnd` names each end).
   Few that form in many swings do so together at the end of one.

Where the slider is so fast that contacts form and break on one panel, its nodes do not resolve them: as many break as
form, and what holds follows from the rate of births and its slope (`FastSliding`). Where its speed changes slowly
beside the delay, too, and its contacts have forgotten their start, births themselves follow from the speed, and
friction is F_k of the present speed but for its rise: a slip of a million thresholds then takes some hundred panels.

Small swings that neither grow nor drift are not followed to the path's end, but told by their middle (`SmallSwings`).

A panel is taken if the last coefficients of its polynomials miss less than the accuracy. The error that is told follows
from several runs with ever smaller tolerances (`master/soft/inertia/runs.py`).

In reading order: `slider.py`, `body.py` and `drive_path.py`, `panels.py`, `panel_search.py` and `width_control.py`,
`collocation.py`, `pull.py` and `panel.py`, `cohorts.py` and `survival.py`, `past_breaks.py` and `panel_births.py`,
`fast_sliding.py`, `swinging.py`, and `small_swings.py`. How the number of contacts is conserved says `past_breaks.py`.

Tests: tests/test_mass_delay_master.py, parts by themselves first, test_births_are_the_breaks_one_delay_before among
them; test_mass_rings.py; and test_mass_agreement.py beside the ensemble.
"""
