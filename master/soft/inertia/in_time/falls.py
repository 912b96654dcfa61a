"""Falls of the spring's force along steps of a slider with mass, between whose ends X is a cubic of the time."""

import numpy as np

from master.motion import Motion
from master.soft.inertia.in_time.node import HeavyNode
from master.soft.inertia.record import Instant, Record, SlipWithMass, Watched, crossing
from origins.thresholds.law import Array

# Times on a step at which the slider is looked at, its ends among them.
LOOKED_AT = 5


class Falls:
    """Falls of the spring's force and slips among them, as `Record` defines them."""

    def __init__(self, motion: Motion | None, spring: float, unit: float, waits: float) -> None:
        """For this motion of the drive; `unit` is the mean threshold, `waits` the delay of the contacts."""
        self._motion, self._spring = motion, spring
        self._record = Record(np.empty(0), unit, waits)
        moving = np.empty(0) if motion is None else motion.speeds[motion.speeds != 0.0]
        self._direction = int(np.sign(moving[0])) if moving.size else 1

    @property
    def slips(self) -> list[SlipWithMass]:
        """In order."""
        return self._record.slips

    @property
    def begins(self) -> list[float]:
        """Times at which slips begin, also one that goes on as the path ends."""
        since = self._record.slips_since
        return [slip.begin.time for slip in self.slips] + ([] if since is None else [since])

    def watch(
        self, leg: int, begin: HeavyNode, end: HeavyNode, breaks: tuple[float, float]
    ) -> None:
        """Look at a step on a leg of the drive's motion, with the breaks per contact up to its begin and end."""
        motion = self._motion
        assert motion is not None
        speed = float(motion.speeds[leg])
        self._direction = int(np.sign(speed)) or self._direction
        lasts, ahead = end.time - begin.time, self._direction
        if not lasts > 0.0:
            return
        parts = np.linspace(0.0, 1.0, LOOKED_AT)
        place, pace = _cubic(begin, end, parts)
        times = begin.time + lasts * parts

        def forces(at: Array, x: Array) -> Array:
            return self._spring * (motion.at(at) - x)

        def at(t: float) -> Instant:
            part = np.array((t - begin.time) / lasts)
            x, _ = _cubic(begin, end, part)
            broken = breaks[0] + float(part) * (breaks[1] - breaks[0])
            force = float(forces(np.array(t), x))
            return Instant(t, float(motion.at(np.array(t))), float(x), force, broken)

        def when(index: int) -> float:
            def excess(part: float) -> float:
                return ahead * float(_cubic(begin, end, np.array(part))[1]) - ahead * speed

            low, high = parts[index : index + 2].tolist()
            return begin.time + lasts * crossing(excess, low, high)

        self._record.watch(
            Watched(
                times=times,
                speeds=ahead * pace,
                places=place,
                forces=forces(times, place),
                holding=np.full(times.size, end.holding),
                drive_speed=ahead * speed,
                drive_direction=ahead,
                at=at,
                when=when,
            )
        )


def _cubic(begin: HeavyNode, end: HeavyNode, part: Array) -> tuple[Array, Array]:
    """X and dX/dt at parts of a step's time, by the cubic with the positions and speeds at its ends."""
    lasts = end.time - begin.time
    travel = end.position - begin.position
    first, last = begin.speed * lasts, end.speed * lasts
    bend, turn = 3.0 * travel - 2.0 * first - last, first + last - 2.0 * travel
    x = begin.position + part * (first + part * (bend + part * turn))
    speed = (first + part * (2.0 * bend + part * 3.0 * turn)) / lasts
    return np.asarray(x), np.asarray(speed)
