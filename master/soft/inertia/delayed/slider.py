"""A slider with mass whose contacts form again after a delay, at T = 0, along the whole path of its drive.

While contacts break or form, X(t) is found panel by panel (`OnPanels.advance`). A panel ends where the slider turns,
where it passes a place at which it turned before, and where births begin. Where none breaks or forms the motion is
closed (`Swinging.swing`): millions of swings of a slider that sticks, or whose contacts are all out, cost nothing.
"""

from master.motion import Motion
from master.outcome import StoppedError, stop_after
from master.soft.inertia.body import RINGS
from master.soft.inertia.delayed.body import DelayedBody
from master.soft.inertia.delayed.drive_path import DrivePath
from master.soft.inertia.delayed.foretold import slip_time
from master.soft.inertia.delayed.panel import NODES
from master.soft.inertia.delayed.panel_search import MOST_PANELS
from master.soft.inertia.delayed.panels import OnPanels
from master.soft.inertia.delayed.swinging import SwingEnd, Swinging
from master.soft.inertia.record import Record
from origins import Contacts
from origins.drive import Drive

# Most turns and closed motions: some 30 s.
MOST_TURNS = 3_000
# Panels of a slip, a few seconds, after which those that are left are foretold. It goes on while fewer contacts hold,
# or the slider is that many times as fast as its drive.
SEEN, HELD, FASTER = 800, 0.5, 10.0


class DelayedSlider:
    """A slider with mass and a delay that is followed along the path of its drive.

    stored_first : energy of the contacts at t = 0, per N_c<k> (length squared)

    The body is the state; both kinds of motion change it in turns.
    _swings : closed motions so far
    _held_at, _panels_before : when contacts last held, and the panels up to then
    """

    def __init__(
        self,
        contacts: Contacts,
        drive: Drive,
        motion: Motion,
        record: Record,
        tolerance: float,
        until: float,
    ) -> None:
        """At rest, in balance, at t = 0.

        motion : of the drive; record : is told of all that happens
        tolerance : of the force (a length); until : reading of time.monotonic() at which to stop
        """
        self._until, self._path = until, DrivePath(motion)
        self._body = DelayedBody(contacts, drive, self._path, record, tolerance)
        self._on_panels = OnPanels(self._body, record, contacts)
        self._swinging, self._swings = Swinging(self._body, record), 0
        self._held_at, self._panels_before = 0.0, 0
        self.stored_first = self._body.contacts.stored(0.0)

    @property
    def nodes(self) -> int:
        """Instants at which the motion was solved."""
        return self._on_panels.search.tried * NODES.size

    def run(self) -> None:
        """Follow the drive to its end; StoppedError where that takes too long."""
        self._swing()
        while not self._path.over:
            self._check_limits()
            if self._on_panels.advance():
                self._swing()
            self._foretell()

    def _swing(self) -> None:
        """Go on by closed motions as long as they follow each other: no contact breaks or forms."""
        while not self._path.over:
            end = self._swinging.swing()
            if end is not SwingEnd.TOO_SHORT:
                self._on_panels.search.begin_anew()
            if not end.goes_on:
                break
            self._swings += 1
            self._check_limits()

    def _check_limits(self) -> None:
        """StoppedError after too much time, or too many turns and swings."""
        stop_after(self._until)
        if self._on_panels.turns + self._swings > MOST_TURNS:
            raise StoppedError(RINGS)

    def _foretell(self) -> None:
        """StoppedError for a slip that would take too many panels. Contacts that break within a short time form again
        together one delay later, and break again: each such volley takes some panels until the slider's swings fade."""
        state, tried = self._body.state, self._on_panels.search.tried
        slow = abs(state.w) <= FASTER * self._path.fastest
        if slow and self._body.contacts.unbroken() >= HELD:
            self._held_at, self._panels_before = state.t, tried
        seen = tried - self._panels_before
        if seen < SEEN:
            return
        lasts = state.t - self._held_at
        machine = self._body.machine
        slip = slip_time(machine.mass, machine.damping, machine.spring)
        left = min(slip, self._path.end - self._held_at) - lasts
        panels = seen * left / lasts
        if tried + panels > MOST_PANELS:
            delay = self._body.past.delay
            raise StoppedError(
                f"stopped in the slip that begins at t = {self._held_at:.6g}: a delay of {delay:g} is so "
                f"short beside it that contacts break and form too often, on some {panels:.0e} panels of time after "
                f"{tried:,}, of which at most {MOST_PANELS:,} are followed; "
                "take eq_model.simulate, end the path before, or leave the mass out and give a slip rule"
            )
