"""A slider with mass whose contacts form again after a delay, at T = 0, along the whole path of its drive.

While contacts break or form, X(t) is found panel by panel (`OnPanels.advance`). A panel ends where the slider turns,
where it passes a place at which it turned before, if the force has a kink there that counts, and where births begin.
Where none breaks or forms the motion is closed (`Swinging.swing`): millions of swings of a slider that sticks, or whose
contacts are all out, cost nothing.
"""

from master.motion import Motion
from master.outcome import StoppedError, stop_after
from master.soft.inertia.body import RINGS
from master.soft.inertia.delayed.body import DelayedBody
from master.soft.inertia.delayed.drive_path import DrivePath
from master.soft.inertia.delayed.fast_sliding import FastSliding
from master.soft.inertia.delayed.panel import NODES
from master.soft.inertia.delayed.panels import OnPanels
from master.soft.inertia.delayed.small_swings import GoesOn, SmallSwings
from master.soft.inertia.delayed.swinging import SwingEnd, Swinging
from master.soft.inertia.record import Record
from origins import Contacts
from origins.drive import Drive

# Most turns and closed motions: some 30 s.
MOST_TURNS = 3_000


class DelayedSlider:
    """A slider with mass and a delay that is followed along the path of its drive.

    stored_first : energy of the contacts at t = 0, per N_c<k> (length squared)
    goes_on : what small swings change that are not followed up to the path's end; None where all are

    The body is the state; both kinds of motion change it in turns.
    _swings : closed motions so far
    """

    def __init__(
        self,
        contacts: Contacts,
        drive: Drive,
        motion: Motion,
        record: Record,
        tolerance: float,
        asked: float,
        until: float,
    ) -> None:
        """At rest, in balance, at t = 0.

        motion : of the drive; record : is told of all that happens
        tolerance, asked : of the force, in this run, and as the user asked for it (lengths)
        until : reading of time.monotonic() at which to stop
        """
        self._until, self._path = until, DrivePath(motion)
        self._body = DelayedBody(contacts, drive, self._path, record, tolerance)
        sliding = FastSliding(contacts.thresholds)
        self._on_panels = OnPanels(self._body, sliding, record, contacts)
        self._swinging, self._swings = Swinging(self._body, record), 0
        self._small_swings = SmallSwings(self._body, sliding, record, asked)
        self.goes_on: GoesOn | None = None
        self.stored_first = self._body.contacts.stored(0.0)

    @property
    def nodes(self) -> int:
        """Instants at which the motion was solved."""
        return self._on_panels.search.tried * NODES.size

    def run(self) -> None:
        """Follow the drive to its end; StoppedError where that takes too long."""
        self._swing()
        while not self._path.over and self.goes_on is None:
            self._check_limits()
            turned = self._on_panels.advance()
            self.goes_on = self._small_swings.goes_on()
            if turned and self.goes_on is None:
                self._swing()

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
