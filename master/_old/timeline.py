"""A path in time as stretches of constant speed, cut into steps.

Steps end wherever the motion changes, and where births of finite weight - all that start from one stretch, or what
was born in a hold - come back to the largest |x| of their lives: there the number of breaks bends. After each of these
the delay brings the same again.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from origins import Drive

Array = npt.NDArray[np.float64]

_SAME = 1e-9  # of a speed
_ROUNDING = 1e-15  # of times
_CLOSE = 1e-10
_MOST_MARKS = 400
WIDTH = 1e-10  # of the whole time, to either side of a jump


@dataclass(frozen=True)
class Piece:
    """Constant speed from time `begin` to `end`, from X = `before` to `after`."""

    begin: float
    end: float
    before: float
    after: float

    @property
    def travel(self) -> float:
        return self.after - self.before

    @property
    def duration(self) -> float:
        return self.end - self.begin


def times(drive: Drive, origin: float = 0.0) -> Array:
    """When the path's points are reached, from `origin` at t = 0."""
    if drive.time is not None:
        return drive.time
    return np.abs(np.diff(drive.path, prepend=origin)).cumsum() / drive.velocity


def pieces(drive: Drive, origin: float = 0.0) -> list[Piece]:
    """From `origin` at t = 0 to the end of the path; what goes on at one speed is one piece."""
    clock = np.append(0.0, times(drive, origin))
    place = np.append(origin, drive.path)
    out: list[Piece] = []
    for begin, end, before, after in zip(clock[:-1], clock[1:], place[:-1], place[1:], strict=True):
        if end <= begin:
            continue
        last = out[-1] if out else None
        if last is not None:
            speed, own = last.travel / last.duration, (after - before) / (end - begin)
            rounding = _ROUNDING * max(end / (end - begin), last.end / last.duration)
            if abs(speed - own) <= (_SAME + rounding) * max(abs(speed), abs(own)):
                out[-1] = Piece(last.begin, float(end), last.before, float(after))
                continue
        out.append(Piece(float(begin), float(end), float(before), float(after)))
    return out


@dataclass(frozen=True)
class Part:
    """Steps between two marks on one piece: even in X, or in a hold even in ln(1 + t/first)."""

    begin: float
    end: float
    before: float
    after: float
    steps: int
    first: float = np.inf
    whole: bool = False  # one step around a time at which a finite share breaks, however fine the others

    def clock(self, at: Array) -> Array:
        """Time after a share `at` of the steps."""
        if not np.isfinite(self.first):
            return self.begin + (self.end - self.begin) * at
        return self.begin + self.first * np.expm1(at * np.log1p((self.end - self.begin) / self.first))

    def share(self, time: Array) -> Array:
        """Share of the steps done at a time."""
        if not np.isfinite(self.first):
            return (time - self.begin) / (self.end - self.begin)
        return np.log1p((time - self.begin) / self.first) / np.log1p((self.end - self.begin) / self.first)

    def finer(self, level: int) -> Part:
        return self if self.whole else replace(self, steps=self.steps * 2**level)


def parts(
    course: list[Piece], marks: Array, length: float, time: float, rate: float, per_decade: float
) -> list[Part]:
    """The coarsest steps: `length` is the longest travel of one, and 1/rate the longest time of one that moves."""
    out = []
    for piece in course:
        inner = marks[(marks > piece.begin) & (marks < piece.end)]
        edges = np.concatenate([[piece.begin], inner, [piece.end]])
        for begin, end in pairwise(edges.tolist()):
            share = (np.array([begin, end]) - piece.begin) / piece.duration
            before, after = (piece.before + piece.travel * share).tolist()
            if end - begin <= 3.0 * WIDTH * course[-1].end:
                out.append(Part(begin, end, before, after, 1, whole=True))
                continue
            if piece.travel == 0.0:
                first = time if np.isfinite(time) else np.inf
                decades = np.log1p((end - begin) / time) if np.isfinite(time) else 0.0
                out.append(Part(begin, end, before, after, 1 + int(per_decade * decades), first))
                continue
            steps = max(abs(after - before) / length, (end - begin) * rate)
            out.append(Part(begin, end, before, after, max(2, int(np.ceil(min(steps, 1e9))))))
    return out


def marks(course: list[Piece], lone: list[float], again: float, limits: Array, delay: float) -> Array:
    """Times at which the number of breaks bends: where contacts of which many stand at one stretch - `lone` at t = 0,
    `again` where they are born in holds - come back to the largest |x| of their lives, or pass one of the stretches
    `limits`."""
    groups = [[-x, abs(x)] for x in lone]  # place, largest |x|
    found: list[float] = []
    for piece in course:
        if piece.travel == 0.0:
            groups.append([piece.after - again, abs(again)])
            continue
        for group in groups:
            place, furthest = group
            first, last = piece.before - place, piece.after - place
            for at in np.concatenate([[furthest, -furthest], limits[limits > furthest], -limits[limits > furthest]]):
                share = (at - first) / (last - first)
                if 0.0 < share < 1.0 and at * piece.travel > 0.0:
                    found.append(piece.begin + share * piece.duration)
            group[1] = max(furthest, abs(first), abs(last))
    whole: Array = np.array(sorted({*found, *(piece.begin for piece in course), *(piece.end for piece in course)}))
    end = course[-1].end
    if delay > 0.0 and delay * _MOST_MARKS > end / max(whole.size, 1):
        later = whole[:, None] + delay * np.arange(1, 4)
        whole = np.union1d(whole, later.ravel())
    whole = whole[(whole > 0.0) & (whole < end)][:_MOST_MARKS]
    apart = np.diff(whole, prepend=-np.inf) > _CLOSE * end
    return whole[apart]


def ways(course: list[Piece], since: float, place: float) -> Iterator[tuple[float, float, float, float, float]]:
    """Each motion of a contact that has formed at a time, unstretched where the slider is at `place`: begin and end in
    time, first and last stretch, speed."""
    for piece in course:
        if piece.end <= since or piece.travel == 0.0:
            continue
        begin = max(piece.begin, since)
        speed = piece.travel / piece.duration
        yield begin, piece.end, piece.before + speed * (begin - piece.begin) - place, piece.after - place, speed


def beside(marks: Array, times: list[float], end: float) -> Array:
    """The marks, and both sides of each of the times."""
    near = WIDTH * end
    if not times:
        return marks
    at = np.array(times)
    free = marks[np.abs(marks[:, None] - at).min(axis=1) > 2.0 * near] if marks.size else marks
    at = at[np.diff(at, prepend=-np.inf) > 4.0 * near]
    return np.sort(np.concatenate([free, at - near, at + near]))


def where(course: list[Piece], time: float) -> float:
    """X at a time."""
    piece = next((piece for piece in course if time <= piece.end), course[-1])
    return piece.before + piece.travel * (time - piece.begin) / piece.duration
