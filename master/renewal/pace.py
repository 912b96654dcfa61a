"""Pace: how wide the next panels are, from how well the last ones resolved the breaks."""

from __future__ import annotations

import numpy as np

from master.renewal import rule
from master.renewal.run import Run

# Width of the narrowest panel, in units of the life's grain, below which halving has met a point
# that no panel resolves.
NARROWEST = 1e-10
# The same of lives that heat may end at any rate, of which nobody knows how short they are.
NARROWEST_IN_TIME = 1e-18
# Width of a panel, in units of its time, that rounding spoils.
ROUNDED = 1e-13
# Panels of a first run, and of the longest: a run that fails is solved in vain.
FIRST, LONGEST = 8, 256
# Panels narrower than half a grain are doubled at once where they resolve more than is asked;
# wider ones after so many, since other widths need other kernels.
PATIENCE = 32
# Share of the tolerance below which panels are tried twice as wide: on narrow panels breaks are
# smooth, so that wide ones err by the power 16 more. Where contacts break at all rates at once,
# panels may widen as time goes by, and are tried sooner.
WIDEN, WIDEN_IN_TIME = 0.5**rule.DEGREE, 1e-2
# Share of the tolerance below which such panels are tried four times as wide.
FAR_BELOW = 1e-6
# Width in grains below which panels lie beside a point that no polynomial follows, such as a pole of
# P_c: they may widen with the distance to it, and are tried sooner, too.
BESIDE = 1e-2

# Share of a refused panel's width that is tried at least next.
STEEPEST = 1e-3


class Pace:
    """Widths of panels from one edge to the next.

    Parameters
    ----------
    width : float
        Allowed at first.
    grain, speed : float
        Length over which breaks have to be resolved, and how fast the slider moves.
    most : float
        Width that no panel exceeds.
    narrowest : float
        Width below which no panel is halved.
    tolerance : float
        Largest error of a panel.
    in_time : bool
        Whether contacts break at rates.

    Attributes
    ----------
    allowed : float
        Width allowed for the next panels.
    count : int
        Panels of the next run.
    """

    def __init__(
        self,
        width: float,
        grain: float,
        speed: float,
        most: float,
        narrowest: float,
        tolerance: float,
        in_time: bool,
    ) -> None:
        self.allowed, self.count = width, FIRST
        self._grain, self._speed, self._most = grain, speed, most
        self.narrowest, self._tolerance, self._in_time = narrowest, tolerance, in_time
        self._smooth, self._wait, self._widened = 0, 0, False
        self._last = 0.0, 0.0  # width and error of the last panel, if that was refused

    def refused(self, width: float, wrong: float) -> None:
        """A panel of this width missed the tolerance."""
        hopeless = wrong > 100.0 * self._tolerance
        narrower = 0.25 if hopeless else 0.5
        if self._in_time and self._last[0] > width and wrong < self._last[1] < np.inf:
            # as some power of the width, as beside an onset of P_c
            power = np.log(self._last[1] / wrong) / np.log(self._last[0] / width)
            goal = (0.5 * self._tolerance / wrong) ** (1.0 / power)
            narrower = float(np.clip(goal, STEEPEST, narrower))
        self._last = width, wrong
        self.allowed, self.count, self._smooth = narrower * width, 1, 0
        if self._widened and self._sooner(width):  # it was tried too soon
            self._wait = min(max(2, 2 * self._wait), PATIENCE)
        self._widened = False

    def resolved(self, width: float, run: Run, hurried: bool) -> None:
        """All panels of a run were good enough; hurried: wider ones are tried whatever they miss."""
        self._last = 0.0, 0.0
        self._wait, self._widened = (self._wait // 2 if self._widened else self._wait), False
        self.count = min(2 * self.count, LONGEST)
        sooner = self._sooner(width)
        spare = self._tolerance * (WIDEN_IN_TIME if sooner else WIDEN)
        needless = run.wrong.max() < max(spare, 1e-14)
        self._smooth = self._smooth + run.wrong.size if needless else 0
        still = abs(run.breaks[:, -1]).max() < 1e-3 * self._tolerance
        narrow = still or width * self._speed <= 0.5 * self._grain
        patience = self._wait if narrow else PATIENCE
        if hurried or (self._smooth > patience and width > 0.6 * self.allowed):
            self.count = 1 if sooner else max(1, self.count // 2)
            self._smooth, self._widened = 0, True
            far_below = sooner and run.wrong.max() < FAR_BELOW * self._tolerance
            self.allowed = min((4.0 if far_below else 2.0) * width, self._most)

    def _sooner(self, width: float) -> bool:
        """Whether panels of this width are tried wider before they err by far less than asked."""
        return self._in_time or width * self._speed < BESIDE * self._grain
