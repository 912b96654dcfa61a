"""Times at which a finite share of the contacts breaks, or is born, at once: those that stand at one stretch or were
born at one place, at exact thresholds, and all that follows from that.

What goes on at such a time does so within a sliver of time. All that is born in one stands at the place where the
thresholds were met, so that what follows is met at a place known to rounding; a stretch that rounding alone keeps from
its threshold has reached it. Where two such places are so close that their slivers touch, it is known to these alone.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.bends import sliver
from master._old.cut_law import SLACK
from master._old.timeline import Piece, ways, where

Array = npt.NDArray[np.float64]

_CLOSE = 1e-10
_MOST = 200


@dataclass(frozen=True)
class Jump:
    """A sliver from time - width to time + width.

    moments : when and where (a length) the slider is at all that goes on in it
    spot : where, if that is one place but for rounding
    rounding : what places are known to (a length)
    """

    time: float
    width: float
    moments: tuple[tuple[float, float], ...]
    spot: float | None
    rounding: float

    @property
    def begin(self) -> float:
        return self.time - self.width

    @property
    def end(self) -> float:
        return self.time + self.width

    def over(self, time: float, place: float, direction: float, since: float) -> bool | None:
        """Whether a slider that moves in a direction since some time has come to it all at a time and X = place, but
        for rounding, or to nothing of it; None where to some."""
        come = [when <= since or self._met(when - time, where - place, direction) for when, where in self.moments]
        return come[0] if all(come) or not any(come) else None

    def _met(self, later: float, further: float, direction: float) -> bool:
        return later <= SLACK * self.time if direction == 0.0 else direction * further <= self.rounding


def jumps(course: list[Piece], lone: list[float], again: float, atoms: Array, delay: float) -> list[Jump] | None:
    """Of contacts that stand at the stretches `lone` at t = 0, of those born in a hold, and of all that form again at
    `again` after breaking at once, in their order; None where they are more than can be followed."""
    if not atoms.size:
        return []
    found = _listed(course, lone, again, atoms, delay, exact=True)
    if found is not None and any(one.spot is None for one in found):
        found = _listed(course, lone, again, atoms, delay, exact=False)
    return found


def _listed(
    course: list[Piece], lone: list[float], again: float, atoms: Array, delay: float, exact: bool
) -> list[Jump] | None:
    """The same; unless `exact` slivers are wide enough for all that was born anywhere in a sliver before."""
    # since when, X less the stretch there, and how far from that some are
    pending = [(0.0, -x, 0.0) for x in lone]
    pending += [(one.end, one.after - again, 0.0) for one in course if one.travel == 0.0]
    known: dict[tuple[float, float], float] = {}
    found: list[Jump] = []
    size, end = float(atoms.max()), course[-1].end
    while pending:
        since, place, apart = pending.pop()
        key = (round(since / end, 12), round(place / size, 12))
        if apart <= known.get(key, -1.0) * (1.0 + _CLOSE):
            continue
        known[key] = apart
        if len(known) > _MOST:
            return None
        furthest = abs(again) if since > 0.0 else abs(place)
        for begin, until, first, last, speed in ways(course, since, place):
            for atom in atoms[(atoms > furthest * (1.0 + SLACK)) & (atoms <= abs(last) * (1.0 + SLACK))]:
                reached = float(np.copysign(atom, last))
                at = min(begin + (reached - first) / speed, until)
                broken = _jump(at, sliver(course, at) + apart / abs(speed), place + reached, atom, exact)
                found.append(broken)
                born = broken
                if delay:
                    width = broken.width + sliver(course, at + delay)
                    born = _jump(at + delay, width, where(course, at + delay), atom, exact)
                    found.append(born)
                if born.time < end:
                    further = 0.0 if exact else _fastest(course, born) * born.width
                    pending.append((born.time, born.moments[0][1] - again, further))
            furthest = max(furthest, abs(first), abs(last))
    return _apart([one for one in found if one.begin < end])


def _jump(time: float, width: float, place: float, atom: float, exact: bool) -> Jump:
    return Jump(time, width, ((time, place),), place if exact else None, SLACK * max(abs(place), atom))


def _fastest(course: list[Piece], jump: Jump) -> float:
    """Largest speed within a sliver."""
    return max(abs(one.travel) / one.duration for one in course if one.end >= jump.begin and one.begin <= jump.end)


def _apart(found: list[Jump]) -> list[Jump]:
    """In their order, those that touch taken as one."""
    out: list[Jump] = []
    for one in sorted(found, key=lambda jump: jump.begin):
        if out and one.begin <= out[-1].time + 3.0 * out[-1].width:
            low, high = out[-1].begin, max(one.end, out[-1].end)
            moments, rounding = out[-1].moments + one.moments, min(out[-1].rounding, one.rounding)
            spot = _one(moments, out[-1].spot, rounding)
            out[-1] = Jump(0.5 * (low + high), 0.5 * (high - low), moments, spot, rounding)
        else:
            out.append(one)
    return out


def _one(moments: tuple[tuple[float, float], ...], spot: float | None, rounding: float) -> float | None:
    """The `spot`, where all places are there but for rounding."""
    if spot is None or any(abs(place - spot) > rounding for _, place in moments):
        return None
    return spot
