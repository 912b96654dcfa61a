"""A slider with mass whose contacts form again after a delay, at T = 0, along the whole path of its drive.

While contacts break or form, X(t) is found panel by panel (`_panel`). A panel ends where the slider turns, where it
passes a place at which it turned before, and where births begin. Where none breaks or forms the motion is closed
(`_hold`): millions of swings of a slider that sticks, or whose contacts are all out, cost nothing.
"""

import numpy as np

from master.outcome import StoppedError, stop_after
from master.soft.inertia.body import RINGS
from master.soft.inertia.delayed.panels import MOST_PANELS, OnPanels
from master.soft.inertia.delayed.swinging import Swinging

# Most turns and closed motions: some 30 s.
MOST_TURNS = 3_000
# Panels of a slip, a few seconds, after which those that are left are foretold. It goes on while fewer contacts hold,
# or the slider is that many times as fast as its drive.
SEEN, HELD, FASTER = 800, 0.5, 10.0


class DelayedSlider(OnPanels, Swinging):
    """A slider with mass and a delay that is followed along the path of its drive."""

    # when contacts last held, and the panels up to then
    _held_at, _panels_before = 0.0, 0

    def run(self) -> None:
        """Follow the drive to its end; StoppedError where that takes too long."""
        self._hold()
        while self._leg < self._motion.speeds.size:
            stop_after(self._until)
            if self._turns > MOST_TURNS:
                raise StoppedError(RINGS)
            if self._panel():
                self._hold()
            self._foretell()

    def _foretell(self) -> None:
        """StoppedError for a slip that would take too many panels. Contacts that break within a short time form again
        together one delay later, and break again: each such volley takes some panels until the slider's swings fade."""
        state, fastest = self._state, FASTER * float(np.abs(self._motion.speeds).max())
        if abs(state.w) <= fastest and self._contacts.unbroken() >= HELD:
            self._held_at, self._panels_before = state.t, self._panels
        seen = self._panels - self._panels_before
        if seen < SEEN:
            return
        lasts, end = state.t - self._held_at, float(self._motion.times[-1])
        left = min(self._slip_time, end - self._held_at) - lasts
        panels = seen * left / lasts
        if self._panels + panels > MOST_PANELS:
            raise StoppedError(
                f"stopped in the slip that begins at t = {self._held_at:.6g}: a delay of {self._past.delay:g} is so "
                f"short beside it that contacts break and form too often, on some {panels:.0e} panels of time; "
                "take eq_model.simulate, end the path before, or leave the mass out and give a slip rule"
            )

    @property
    def _slip_time(self) -> float:
        """About how long a slip lasts until its swings are no longer than a threshold."""
        mass, damping, spring, _ = self._machine
        if damping == 0.0:
            return np.inf
        apart = np.sqrt(max(damping**2 - 4.0 * mass * spring, 0.0))
        fading = 2.0 * spring / (damping + apart) if apart else 0.5 * damping / mass
        return float(np.pi * np.sqrt(mass / spring) + max(-np.log(spring), 0.0) / fading)

    def _hold(self) -> None:
        """Go on by the closed motion as long as it holds: no contact breaks or forms."""
        while self._leg < self._motion.speeds.size and self._swing():
            stop_after(self._until)
            self._turns += 1
            if self._turns > MOST_TURNS:
                raise StoppedError(RINGS)
