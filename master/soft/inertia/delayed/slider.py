"""A slider with mass whose contacts form again after a delay, at T = 0, along the whole path of its drive.

While contacts break or form, X(t) is found panel by panel (`_panel`). A panel ends where the slider turns, where it
passes a place at which it turned before, and where births begin. Where none breaks or forms the motion is closed
(`_hold`): millions of swings of a slider that sticks, or whose contacts are all out, cost nothing.
"""

from master.outcome import StoppedError, stop_after
from master.soft.inertia.body import RINGS
from master.soft.inertia.delayed.panels import OnPanels
from master.soft.inertia.delayed.swinging import Swinging

# Most turns and closed motions: some 30 s.
MOST_TURNS = 3_000


class DelayedSlider(OnPanels, Swinging):
    """A slider with mass and a delay that is followed along the path of its drive."""

    def run(self) -> None:
        """Follow the drive to its end; StoppedError where that takes too long."""
        self._hold()
        while self._leg < self._motion.speeds.size:
            stop_after(self._until)
            if self._turns > MOST_TURNS:
                raise StoppedError(RINGS)
            if self._panel():
                self._hold()

    def _hold(self) -> None:
        """Go on by the closed motion as long as it holds: no contact breaks or forms."""
        while self._leg < self._motion.speeds.size and self._swing():
            stop_after(self._until)
            self._turns += 1
            if self._turns > MOST_TURNS:
                raise StoppedError(RINGS)
