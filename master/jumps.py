"""Times at which a finite share of the contacts breaks, or is born, at once: those that stand at one stretch or were
born at one place, at exact thresholds, and all that follows from that.

What goes on at such a time does so within a sliver of time, wide enough for all that was born in a sliver before.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.bends import sliver
from master.timeline import Piece, ways, where

Array = npt.NDArray[np.float64]

_CLOSE = 1e-10
_MOST = 200


@dataclass(frozen=True)
class Jump:
    """A sliver from time - width to time + width."""

    time: float
    width: float


def jumps(course: list[Piece], lone: list[float], again: float, atoms: Array, delay: float) -> list[Jump] | None:
    """Of contacts that stand at the stretches `lone` at t = 0, of those born in a hold, and of all that form again at
    `again` after breaking at once, in their order; None where they are more than can be followed."""
    if not atoms.size:
        return []
    # since when, X less the stretch there, and how far from that some are
    pending = [(0.0, -x, 0.0) for x in lone]
    pending += [(one.end, one.after - again, 0.0) for one in course if one.travel == 0.0]
    known: dict[tuple[float, float], float] = {}
    found: list[Jump] = []
    size, end = float(atoms.max()), course[-1].end
    while pending:
        since, place, apart = pending.pop()
        key = (round(since / end, 12), round(place / size, 9))
        if apart <= known.get(key, -1.0) * (1.0 + _CLOSE):
            continue
        known[key] = apart
        if len(known) > _MOST:
            return None
        furthest = abs(again) if since > 0.0 else abs(place)
        for begin, _, first, last, speed in ways(course, since, place):
            for atom in atoms[(atoms > furthest * (1.0 + _CLOSE)) & (atoms <= abs(last) * (1.0 + _CLOSE))]:
                reached = float(np.copysign(atom, last))
                at = begin + (reached - first) / speed
                broken = Jump(at, sliver(course, at) + apart / abs(speed))
                born = Jump(at + delay, broken.width + (sliver(course, at + delay) if delay else 0.0))
                found += [broken, born] if delay else [broken]
                if born.time < end:
                    further = _fastest(course, born) * born.width
                    pending.append((born.time, where(course, born.time) - again, further))
            furthest = max(furthest, abs(first), abs(last))
    return _apart([one for one in found if one.time - one.width < end])


def _fastest(course: list[Piece], jump: Jump) -> float:
    """Largest speed within a sliver."""
    begin, end = jump.time - jump.width, jump.time + jump.width
    return max(abs(one.travel) / one.duration for one in course if one.end >= begin and one.begin <= end)


def _apart(found: list[Jump]) -> list[Jump]:
    """In their order, those that touch taken as one."""
    out: list[Jump] = []
    for one in sorted(found, key=lambda jump: jump.time - jump.width):
        if out and one.time - one.width <= out[-1].time + 3.0 * out[-1].width:
            low = out[-1].time - out[-1].width
            high = max(one.time + one.width, out[-1].time + out[-1].width)
            out[-1] = Jump(0.5 * (low + high), 0.5 * (high - low))
        else:
            out.append(one)
    return out
