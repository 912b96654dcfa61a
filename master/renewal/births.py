"""Births: what is born along a motion, on panels or together, and pieces of it to integrate over.

A contact that breaks at s is out until s + delay, where it is born again at a stretch r. As long as it is out it counts
among the contacts, but carries no force. So with E and K of its life the contributions to number and force are

    number: 1 for t < s + delay, E(t, s + delay) after,      force: 0, then K(t, s + delay).

Both are integrated against the derivative of the number of breaks, a polynomial on each panel
(present: births on the present leg; past: births on the legs before).
"""

from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.motion import History, Motion
from master.numerics import polynomials
from master.numerics.polynomials import Pieces, Rows
from master.survival.life import Life
from origins import Contacts
from origins.start import SingleStart, Start
from origins.thresholds.law import Array
from origins.thresholds.numerical import clipped

# The smallest normal number: it keeps quotients by widths that are 0 by rounding finite.
TINY = float(np.finfo(float).tiny)
# Survivals jump at exact thresholds: a time at the end of a panel is moved into it by this part of its width.
OFF_PANEL_END = 1e-9
# Work (see Births.work) after which nothing is halved any more: some 30 s, two minutes with heat on hundreds of legs.
MOST_WORK = 25_000_000
# Work of a survival averaged over many stretches at birth, in that at one: a rough figure, for MOST_WORK alone.
WORK_OF_AVERAGE = 40


def reforming_law(contacts: Contacts) -> Start:
    """The law of the stretches at which broken contacts form again."""
    return SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law


def roughly_holding(life: Life, law: Start, history: History) -> Array:
    """Of contacts born at stretches of a law the part that holds, for a history of one column, by eight of them where
    it has a width: their average, to a solution's accuracy, may take as long as the solution."""
    few = [law] if law.is_single else [SingleStart(x) for x in law.ppf((np.arange(8) + 0.5) / 8.0)]
    each = [life.survival_and_force(one, history).survival[:, 0] for one in few]
    return np.asarray(np.mean(each, axis=0))


@dataclass
class Births:
    """Births of contacts with one life along one motion.

    law : of the stretches at which broken contacts form again
    delay : time for which a broken contact is out, in the unit of the motion's times
    accuracy : of sums over births of earlier legs, a share of the contacts. It is asked of each piece of a sum, as
        ErrorBudget says, and bounds no sum of pieces: what these miss is in Past.error
    until : reading of time.monotonic() at which to stop, and after which no piece is halved
    longest_stretch : the longest |x| on the motion, or force per contact born; at most the longest of the life. An
        error of the number times this is one of the force
    work : of the integrals over births so far, 1 for a piece whose survival is looked up; see add_work, MOST_WORK
    """

    life: Life
    law: Start
    motion: Motion
    delay: float = 0.0
    accuracy: float = 1e-15
    until: float = np.inf
    longest_stretch: float = np.inf
    work: int = 0

    def __post_init__(self) -> None:
        """Averages over stretches at birth stop at `until`, too: of a life of its own, as others may share this one."""
        self.life = copy(self.life)
        self.life.until = self.until
        self.longest_stretch = min(self.longest_stretch, self.life.largest_stretch)

    def add_work(self, pieces: int) -> None:
        """Add the work of so many pieces: 1 each, or pair_work at a node; WORK_OF_AVERAGE times that where contacts are
        born at many stretches."""
        cost = 1 if self.life.quick else polynomials.PANEL_NODES * self.life.pair_work
        self.work += pieces * cost * (1 if self.law.is_single else WORK_OF_AVERAGE)

    def may_hold(self, law: Start, history: History) -> npt.NDArray[np.bool_]:
        """Whether any contacts born at stretches of a law, with the moves of a row, hold; shape (rows,).

        The births of a row stand for all in between: the smallest of their largest displacements, and the largest of
        their smallest, are those of the contact that was stretched least. None is left out that may hold."""
        low, high = law.span
        highs, lows = history.high.min(axis=1), history.low.max(axis=1)
        return np.maximum(low + highs, -(high + lows)) <= self.life.largest_stretch


class Sums(NamedTuple):
    """Sums over births at some times.

    both : number and force, whose first axis has the length 2
    error, survival_error : of the number: that of the sums, and that of the survivals in them
    holding_by_leg : of births on earlier legs, by the leg's index: the share of all contacts that was born on it and
        holds at the latest of the times; None where that is not told
    """

    both: Array
    error: float
    survival_error: float = 0.0
    holding_by_leg: dict[int, float] | None = None


class Lump(NamedTuple):
    """Contacts that are born at one instant, or hold at t = 0 (paper, Eqs. Q7b and Q6e): time of the
    birth, weight (share of all contacts) and law of the stretches at birth. Of contacts that break
    together the birth is one delay after the break: until then they count as out, see lumps.py."""

    birth: float
    weight: float
    law: Start


class Jump(NamedTuple):
    """A panel that is as narrow as rounding allows and still not good: the number or the force jumps on it.

    time, leg : where it begins, on the path; the leg is counted from 0
    size : its error, a share of the contacts
    behind_edge : whether it begins at an edge, so that none is missing there
    """

    time: float
    leg: int
    size: float
    behind_edge: bool


class Nodes(NamedTuple):
    """Nodes at which births are integrated over pieces of time. A piece may lie on several panels; its part on one of
    them, where births are a polynomial, has PANEL_NODES nodes.

    target, panel : of each part: the owner of its piece, the instant for which is integrated, and its panel; (parts,)
    place, time : of each node: its place on the panel, from 0 to 1, and its time; (parts, PANEL_NODES)
    weight : of each node in an integral over the place
    """

    target: Rows
    panel: Rows
    place: Array
    time: Array
    weight: Array

    @classmethod
    def of(cls, ends: Array, pieces: Pieces) -> "Nodes":
        """From panels with these ends, shape (panels + 1,), and pieces; each lies on some panel."""
        last_panel = ends.size - 2
        first = clipped(np.searchsorted(ends, pieces.low, "right") - 1, 0, last_panel)
        after = clipped(np.searchsorted(ends, pieces.high, "left"), first + 1, last_panel + 1)
        # a part for each piece and each of its panels, from `first` to before `after`
        parts_of = after - first
        piece = np.repeat(np.arange(parts_of.size), parts_of)
        parts_before = np.cumsum(parts_of) - parts_of
        panel = first[piece] + np.arange(piece.size) - parts_before[piece]
        begin = ends[panel, None]
        width = np.maximum(np.diff(ends)[panel], TINY)[:, None]
        # the part's ends, as places on its panel
        low = clipped((pieces.low[piece, None] - begin) / width, 0.0, 1.0)
        high = clipped((pieces.high[piece, None] - begin) / width, 0.0, 1.0)
        lobatto = polynomials.lobatto(polynomials.PANEL_NODES)
        place = low + (high - low) * lobatto.nodes
        weight = (high - low) * lobatto.series[:, 0]
        return cls(pieces.owner[piece], panel, place, begin + width * place, weight)

    def pick(self, which: npt.NDArray[np.bool_]) -> "Nodes":
        """Those of some of the parts."""
        owners = self.target[which], self.panel[which]
        return Nodes(*owners, self.place[which], self.time[which], self.weight[which])


class BirthPanels(NamedTuple):
    """Births on panels without gaps between them.

    ends : when each panel begins, and the last one ends, shape (n + 1,); widths may differ. Their clock is that of the
        births as a whole, whose name ends in it (past.py): `births_leg`, `births_own_leg`
    slopes : Legendre coefficients of the births' derivative by the place on the panel, shape (n, DEGREE + 1)
    """

    ends: Array
    slopes: Array

    def legendre_weights(self, pieces: Pieces, size: int) -> Array:
        """Integrals over pieces of the births times each one's own Legendre polynomials, shape (pieces, size)."""
        left, right = pieces.low, pieces.high
        nodes = Nodes.of(self.ends, pieces._replace(owner=np.arange(left.size)))
        births = self.at(nodes) * nodes.weight
        middle, width = (left + right)[nodes.target, None], (right - left)[nodes.target, None]
        z = clipped((2.0 * nodes.time - middle) / width, -1.0, 1.0)
        weights = (births[:, None] @ legendre.legvander(z, size - 1))[:, 0]
        return np.add.reduceat(weights, np.flatnonzero(np.diff(nodes.target, prepend=-1)))

    def at(self, nodes: Nodes) -> Array:
        """The births' derivative by the place on the panel at nodes."""
        return polynomials.legendre_sum(self.slopes[nodes.panel], 2.0 * nodes.place - 1.0)

    def most_between(self, pieces: Pieces) -> Array:
        """Bound on the births on each piece: a Legendre polynomial is at most 1."""
        most = np.append(0.0, np.cumsum(np.abs(self.slopes).sum(axis=1)))
        up_to_low, up_to_high = (
            np.interp(end, self.ends, most) for end in (pieces.low, pieces.high)
        )
        return np.asarray(up_to_high - up_to_low)


def panel_at(begins: Array, t: float) -> int:
    """The panel on which the time t lies, the last that begins at t or before it; the first for earlier times."""
    return max(int(np.searchsorted(begins, t, "right")) - 1, 0)


def still_out(t: Array, delay: float, begin: Array | float, width: Array | float) -> Array:
    """Weights of a panel's breaks, at 0 and its nodes, in the number of contacts that broke on it and are out at times
    t, shape (..., DEGREE + 1): all that broke up to t, but for those up to one delay before, which have formed again.
    `begin` and `width` are the panel's, or broadcast against t."""
    places = [clipped((up_to - begin) / width, 0.0, 1.0) for up_to in (t, t - delay)]
    broken, re_formed = polynomials.values(np.stack(places))
    return np.asarray(broken - re_formed)
