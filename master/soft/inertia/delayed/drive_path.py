"""The path of the drive, leg by leg."""

import numpy as np

from master.motion import Motion
from origins.thresholds.law import Array


class DrivePath:
    """X_T(t) on the present leg of the drive's path.

    leg : the present leg, counted from 0; `next_leg` alone changes it
    direction : of the drive, +1 or -1; in a hold that of the leg before, or of the first that moves
    """

    def __init__(self, motion: Motion) -> None:
        """On the first leg."""
        self._motion, self.leg = motion, 0
        moving = motion.speeds[motion.speeds != 0.0]
        self.direction = int(np.sign(moving[0])) if moving.size else 1

    @property
    def over(self) -> bool:
        """Whether no leg is left."""
        return self.leg >= self._motion.speeds.size

    def at(self, t: float | Array) -> Array:
        """X_T (a length); as t."""
        motion, leg = self._motion, self.leg
        return np.asarray(motion.positions[leg] + motion.speeds[leg] * (t - motion.times[leg]))

    @property
    def speed(self) -> float:
        """dX_T/dt."""
        return float(self._motion.speeds[self.leg])

    @property
    def leg_end(self) -> float:
        """When the present leg ends."""
        return float(self._motion.times[self.leg + 1])

    @property
    def end(self) -> float:
        """When the last leg ends."""
        return float(self._motion.times[-1])

    @property
    def fastest(self) -> float:
        """Largest |dX_T/dt| of all legs."""
        return float(np.abs(self._motion.speeds).max())

    def next_leg(self) -> None:
        """Go on to the next leg."""
        self.leg += 1
        if not self.over:
            self.direction = int(np.sign(self.speed)) or self.direction
