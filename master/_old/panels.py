"""Panels in time on which the number of breaks is a polynomial, and how a path is cut into them.

A panel's unknowns stand at the Radau nodes of (0, 1], its end among them. Panels are graded towards the ends of all
that goes on at one speed, where rates change fast, and in a hold grow with the time since its beginning.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master._old.jumps import Jump
from master._old.timeline import Piece

Array = npt.NDArray[np.float64]

MOST_NODES = 8  # on the coarsest level
SLOW = 0.25  # of a panel's length over that on which things change: what its polynomials' next term is smaller by
_SHARE = SLOW**MOST_NODES
ROUNDED = 1e-13  # of the last time: times closer to one another are rounded too much for panels
_GROWTH = 2.0
_MORE = 3
_MOST_PANELS = 1e9
_ROUNDING = 2e-14


@dataclass(frozen=True)
class Panel:
    """Constant speed from time `begin` to `end`, from X = `before` to `after`; `count` nodes; `jump` is what goes on
    there at once, if anything does."""

    begin: float
    end: float
    before: float
    after: float
    count: int
    jump: Jump | None = None

    @property
    def duration(self) -> float:
        return self.end - self.begin

    @property
    def travel(self) -> float:
        return self.after - self.before

    @property
    def nodes(self) -> Array:
        """Times of the unknowns, in (begin, end]."""
        out = self.begin + self.duration * radau(self.count).nodes
        out[-1] = self.end
        return out

    def parts(self) -> list["Panel"]:
        """The same in more detail: more nodes, or two panels."""
        if self.count < MOST_NODES:
            return [replace(self, count=min(self.count + _MORE, MOST_NODES))]
        middle = 0.5 * (self.begin + self.end)
        at = float(self.place(np.array([middle]))[0])
        return [replace(self, end=middle, after=at), replace(self, begin=middle, before=at)]

    def place(self, time: Array) -> Array:
        """X at times."""
        return self.before + self.travel * ((time - self.begin) / self.duration)

    @property
    def spot(self) -> float | None:
        """Where all is born that is born at once, if that is one place."""
        return None if self.jump is None else self.jump.spot

    def births(self, time: Array) -> Array:
        """X of births at times."""
        return self.place(time) if self.spot is None else np.full(time.size, self.spot)


class Radau:
    """`count` nodes on (0, 1], weights of their sums, and polynomials through these and 0."""

    def __init__(self, count: int) -> None:
        self.count = count
        both = np.zeros(count + 1)
        both[count - 1], both[count] = 1.0, -1.0
        roots = np.sort(np.real(legendre.legroots(both)))
        self.nodes = 0.5 * (roots + 1.0)
        self.nodes[-1] = 1.0
        system = legendre.legvander(2.0 * self.nodes - 1.0, count - 1)
        goal = np.zeros(count)
        goal[0] = 1.0
        self.weights = np.linalg.solve(system.T, goal)
        every = legendre.legvander(2.0 * np.append(0.0, self.nodes) - 1.0, count)
        self._last = np.linalg.inv(every)[-2:]
        self._series = np.linalg.inv(_powers(np.append(0.0, self.nodes), count + 1))
        self._slopes = 2.0 * np.arange(1.0, count + 1.0)[:, None] * self._series[1:]

    def tail(self, values: Array) -> float:
        """How large the last terms of the polynomial through values at 0 and the nodes are, as a series of Legendre's;
        no less than what it lacks, where they fall."""
        last = np.abs(self._last @ values)
        return float(max(last[1], SLOW * last[0]))

    def values(self, at: Array) -> Array:
        """Weights of the values at 0 and the nodes in the polynomial's at shares `at`, shape (m, count + 1)."""
        return _powers(at, self.count + 1) @ self._series

    def slope(self, values: Array) -> Array:
        """Its slope through such values, in powers of the place between -1 and 1."""
        return np.asarray(self._slopes @ values)

    def slopes(self, at: Array) -> Array:
        """The same in its slope's."""
        return _powers(at, self.count) @ self._slopes


def _powers(at: Array, number: int) -> Array:
    """Powers of 2 at - 1 from 0 on, shape (m, number)."""
    out = np.ones((at.size, number))
    z = 2.0 * at - 1.0
    for k in range(1, number):
        np.multiply(out[:, k - 1], z, out=out[:, k])
    return out


@lru_cache
def radau(count: int) -> Radau:
    return Radau(count)


@lru_cache
def gauss(count: int) -> tuple[Array, Array]:
    """Gauss's nodes on (0, 1), and weights."""
    nodes, weights = legendre.leggauss(count)
    return 0.5 * (nodes + 1.0), 0.5 * weights


@dataclass(frozen=True)
class Scales:
    """What panels must resolve.

    length, first : float
        Travel over which births change, and at the beginning of a motion (lengths).
    time : float
        The shortest time over which they do in a hold.
    rate : float
        At which fresh contacts break.
    start : float
        Like `first`, where all begins.
    """

    length: float
    first: float
    time: float
    rate: float
    start: float = np.inf


def panels(
    course: list[Piece], bends: Array, sharp: list[Jump] | None, scales: Scales, fine: float, level: int
) -> list[Panel]:
    """Panels of `course` between all bends, `fine` times as many as the fewest, each with one more node a level; one
    for each of the slivers of what is sharp."""
    out: list[Panel] = []
    end = course[-1].end
    scales = replace(scales, time=max(scales.time, ROUNDED * end))
    for piece in course:
        inner = bends[(bends > piece.begin) & (bends < piece.end)]
        edges = np.concatenate([[piece.begin], inner, [piece.end]])
        speed = abs(piece.travel) / piece.duration
        for number, (begin, last) in enumerate(pairwise(edges.tolist())):
            size = last - begin
            jump = next((one for one in sharp or [] if one.begin <= begin and last <= one.end), None)
            if jump is not None or size <= 0.1 * ROUNDED * end:
                cuts, counts = np.array([begin, last]), [1]
            elif speed == 0.0:
                cuts = _held(begin, last, piece.begin, scales.time, fine)
                counts = [MOST_NODES + level if np.isfinite(scales.time) else 2] * (cuts.size - 1)
            else:
                longest = min(scales.length / speed, 1.0 / scales.rate if scales.rate > 0.0 else np.inf)
                first = scales.first if piece is not course[0] else min(scales.first, scales.start)
                # what is sooner than rounding of times is at once
                first = min(max(first / speed, _ROUNDING * begin), longest) if number == 0 else longest
                cuts = _moving(begin, last, first / fine, longest / fine, _GROWTH ** (1.0 / fine))
                counts = [_count(fine * (b - a) / longest) + level for a, b in pairwise(cuts.tolist())]
            places = piece.before + piece.travel * ((cuts - piece.begin) / piece.duration)
            if last == piece.end:
                places[-1] = piece.after
            for k, count in enumerate(counts):
                begun, until, before, after = cuts[k], cuts[k + 1], places[k], places[k + 1]
                out.append(Panel(float(begun), float(until), float(before), float(after), count, jump))
    return out


def _count(share: float) -> int:
    """Nodes for a panel of this share of the longest."""
    return int(np.clip(np.ceil(np.log(_SHARE) / np.log(SLOW * min(share, 1.0))), 2, MOST_NODES))


def _moving(begin: float, end: float, first: float, longest: float, growth: float) -> Array:
    """Edges from `begin` to `end`: the first panel is `first` long, others `growth` times the one before at most."""
    sizes = []
    size, left = first, end - begin
    while size < longest and left > 0.0:
        sizes.append(size)
        left -= size
        size *= growth
    if left > 0.0:
        number = int(np.ceil(min(left / longest, _MOST_PANELS)))
        sizes += [left / number] * number
    ways = np.cumsum(sizes)
    return np.append(begin, begin + ways * ((end - begin) / ways[-1]))


def _held(begin: float, end: float, since: float, time: float, fine: float) -> Array:
    """Edges even in the logarithm of the time since the hold began."""
    if not np.isfinite(time):
        return np.array([begin, end])
    low, high = np.log1p((begin - since) / time), np.log1p((end - since) / time)
    number = max(1, int(np.ceil(fine * (high - low) / np.log(_GROWTH))))
    cuts = since + time * np.expm1(np.linspace(low, high, number + 1))
    cuts[0], cuts[-1] = begin, end
    return np.asarray(cuts)
