"""How wide panels of time are: wider ones while they miss little, narrower ones where a search fails."""

from typing import NamedTuple


class WidthControl(NamedTuple):
    """Numbers of the control of panels' widths; none has a unit.

    growth : the next panel is at most this many times as wide as the last one
    least_shrink, most_shrink : a panel that failed is narrower by a factor between these; by the second where its
        motion was not found
    aim : error of the next panel, in units of the error that a panel may have
    first_travel : travel on the first panel after a closed motion, in mean thresholds
    first_of_swing : and its width at most, in times in which mass and damping follow the stiffest spring
    fast : way of a panel on which contacts form and break, in LEAST_PASSAGE: half more, as speeds change on it
    steady : way of the first panel on which sliding is nearly steady, in mean thresholds, and least width in delays
    of_swing : most width of such a panel, in times in which the mass follows its spring
    of_stop : and in times in which the slider would stop at its present deceleration: it must not turn on it
    unbiased : error of a panel, in units of that which it may have, where sliding differs from a nearly steady one by
        more than the latter, and by no more than `biased` times of it: so much panels may add up to (1.2 measured)
    least, least_of_swing : a panel is never narrower than this part of the time since the start, which is its rounding,
        nor than this part of the time in which the mass follows its spring: nothing moves as fast
    """

    growth: float = 3.0
    least_shrink: float = 0.8
    most_shrink: float = 0.25
    aim: float = 0.5
    first_travel: float = 0.02
    first_of_swing: float = 0.1
    fast: float = 1.5
    steady: float = 3.0
    of_swing: float = 0.5
    of_stop: float = 0.9
    unbiased: float = 0.1
    biased: float = 4.0
    least: float = 1e-13
    least_of_swing: float = 1e-12


WIDTHS = WidthControl()
