"""A slider with mass at T = 0, M X'' + g X' = K (X_T - X) - F, along the whole path of its drive.

While it moves one way F is that of a move, and the motion an ordinary differential equation (`moving`). Where it turns
contacts hold at first: as long as none breaks the motion is closed (`elastic`). What rings by less than a small part of
the tolerance is at rest, and the slider follows its drive slowly (`following`) until it gets fast.
"""

from functools import cached_property

import numpy as np

from master.outcome import StoppedError, stop_after
from master.soft.inertia.body import RINGS, Mode
from master.soft.inertia.elastic import Elastic
from master.soft.inertia.following import Following
from master.soft.inertia.moving import MOST_STEPS, Moving
from master.soft.moves import LoadingHistory

# Most turns: some 20 s.
MOST_TURNS = 3_000


class InertialSlider(Elastic, Moving, Following):
    """A slider with mass that is followed along the path of its drive."""

    @property
    def nodes(self) -> int:
        """Moments at which number conservation was solved."""
        return self.contacts.nodes

    @property
    def _loaded(self) -> LoadingHistory:
        return LoadingHistory(self.contacts.start)

    @cached_property
    def stored_first(self) -> float:
        """Energy of the contacts at t = 0, per N_c<k> (length squared)."""
        return float(self._new_move(self.drive_direction, self._loaded).stored(np.zeros(1))[0])

    def run(self) -> None:
        """Follow the drive to its end; StoppedError where that takes too long."""
        self.move = self._new_move(self.drive_direction, self._loaded)
        self._hold(0.0, self.move.elastic_end, self._new_move(-self.drive_direction, self._loaded))
        mode: Mode = self.elastic
        while self.leg < self.motion.speeds.size:
            stop_after(self.contacts.until)
            if self.steps > MOST_STEPS or self.turns > MOST_TURNS:
                raise StoppedError(RINGS)
            mode = mode()  # type: ignore[assignment]
