"""Falls of the spring's force in a motion of closed form, as a rule an oscillation: of many swings only the first and
the last are looked at."""

from collections.abc import Callable

import numpy as np

from master.soft.inertia.oscillation import Oscillation
from master.soft.inertia.record import Record, Watched
from origins.thresholds.law import Array

# Periods at the beginning and at the end of a closed motion that are looked at, and points of each pair. Swings fade:
# the first one beyond the drive is the largest, and only the last may go on in the motion that follows.
PERIODS, POINTS = 2.0, 97
# Shortest time, in periods, that is looked at where the motion does not swing.
SHORTEST = 1e-3


def watch_closed(
    record: Record, motion: Oscillation, lasts: float, seen: Callable[[Array], Watched]
) -> None:
    """Let the record watch a motion of closed form that lasts so long; `seen` tells the slider at times from its
    beginning on."""
    near = PERIODS * motion.period
    if not lasts:  # it begins at its end, where breaks begin
        record.watch(seen(np.zeros(1)))
    elif not motion.swings:
        # the difference of two exponentials and a constant changes its sign twice at most
        record.watch(seen(np.append(0.0, _spread(min(SHORTEST * near, 0.5 * lasts), lasts))))
    elif lasts <= 2.0 * near:
        record.watch(seen(np.linspace(0.0, lasts, 2 * POINTS)))
    else:
        record.watch(seen(np.linspace(0.0, near, POINTS)))
        record.forget_fall()
        record.watch(seen(np.linspace(lasts - near, lasts, POINTS)))


def _spread(first: float, last: float) -> Array:
    """Times from the first to the last, in equal ratios."""
    times = np.geomspace(first, last, POINTS)
    times[-1] = last
    return times
