"""E and K of contacts on a slider that moves straight, over the lag since their birth."""

from collections.abc import Callable
from copy import copy
from typing import NamedTuple

import numpy as np

from master.motion import History, Motion, middle_of
from master.numerics.polynomials import Rows
from master.numerics.table import Table
from master.outcome import stop_after
from master.renewal.births import BirthPanels
from master.survival.life import NO_SURVIVAL, TIE, Life, Survivors
from origins.errors import refuse
from origins.start import Start
from origins.thresholds.law import Array
from origins.thresholds.numerical import clipped

# Allowed error of a table at its panels' ends, divided by the last coefficients; it is larger beside a square root.
AT_ENDS = 10.0
# Width of the narrowest panel of a table, in units of the typical lag from a birth to the break.
NARROWEST_PANEL = 1e-13
# Ratio of lags at which the survival is sampled to find where contacts break, and how many are sampled together.
RATIO, LAGS_TOGETHER = 4.0, 6
# Lags below this part of the longest one are not searched for breaks: their squares come near the smallest number.
SHORTEST_LAG = 1e-150
# Not even the heaviest tail is followed beyond this many times the longest stretch: squares stay far from overflow.
FURTHEST_LAG = 1e120
# Relative distance of two edges below which they count as one: some fifty times the rounding of a lag.
SAME_EDGE = 1e-14
# Shares of contacts: AT_FIRST may break before a table's first edge; NEGLIGIBLE adds nothing to integrals.
AT_FIRST, NEGLIGIBLE = 1e-3, 1e-17


class _Ladder(NamedTuple):
    """Lags, shape (n,), E after each, and `typical` of Straight."""

    lags: Array
    survival: Array
    typical: float


class Straight:
    """E and K over the lag since birth, a time or the slider's travel.

    born : law of the stretches at birth
    speed : dX/dt, with its sign, or 0: K has the sign of x, and contacts born at r < 0 are relaxed first where it is
        above 0. Where only its size counts it is written `abs_speed`, as in all of master/renewal
    longest : the longest lag; the table ends there or where no contact holds, if `steady` where hardly any does
    accuracy : last coefficients of E, and of K over `scale`, below which a panel of the table is not halved
    steady : whether lags are distances instead of times
    until : reading of time.monotonic() after which to raise StoppedError

    edges : array of shape (n,), lags between which E and K are polynomials, or nearly so
    table : E and K/`scale` over the lag; unless `steady`, there is none where the life is as quick
    held : a lag up to which all contacts born at one stretch hold, so that E = 1 and K is their stretch; 0 where none
        is known
    typical : a lag, to a factor of 4, after which half of the contacts have broken; only where there is a table
    scale : a length, of the stretches at a break
    survival_error : of the fraction that holds, as the life gave it for the table; known when this is made
    error : of a look-up: survival_error, and the table's own

    Raises InputError where contacts break within lags that underflow.
    """

    def __init__(
        self,
        life: Life,
        born: Start,
        speed: float,
        longest: float,
        accuracy: float,
        until: float = np.inf,
        steady: bool = False,
    ) -> None:
        """Find the lags between which E and K are smooth, and tabulate both."""
        self.life, self.born, self.longest = copy(life), born, longest
        self.life.until = until
        self.survival_error = self.error = life.error
        # the lag per time: 1, or a distance over a time if steady, where the slider moves forward
        self._speed, self._per_time = speed, speed if steady else 1.0
        self.scale, self._until = life.largest_stretch, until
        at_bends = self._lags_at(np.append(life.bends, life.largest_stretch))
        self._last = float(at_bends.max(initial=0.0)) or np.inf  # the lag of the last breaks
        self._read: Callable[[Array], Survivors] = self.scaled
        self.held = 0.0
        if life.quick and born.is_single and not steady:  # the life is as quick as a table
            if speed:
                safe = life.safe_stretch * (1.0 - 4.0 * TIE) - abs(born.mean())
                self.held = max(safe, 0.0) / abs(speed)
            self._bounds = _edges(longest, at_bends)
            self.edges = np.union1d(self._bounds, _edges(longest, self._lags_at(life.marks)))
            return
        lags, survival, self.typical = self._ladder(longest, steady)
        self.longest = float(lags[-1])
        distance = self.typical * abs(speed) / self._per_time
        self.scale = max(distance, *(abs(end) for end in born.span)) or life.largest_stretch
        first = max(int(np.argmax(survival < 1.0 - AT_FIRST)) - 1, 0)
        self._bounds = _edges(self.longest, at_bends)
        edges = _edges(self.longest, np.append(lags[first:], at_bends))
        shortest = NARROWEST_PANEL * min(self.typical, float(edges[1]))
        self.table = Table(self._for_table, edges, accuracy, shortest, at_ends=AT_ENDS)
        self._read = self._from_table
        self.edges, self.error = self.table.edges, self.survival_error + self.table.error

    def _from_table(self, lag: Array) -> Survivors:
        """As `scaled`, from the table."""
        survival, force = self.table(lag)
        return Survivors(survival, force, self.error)

    def _for_table(self, lag: Array) -> Array:
        """As `scaled`, shape (2, rows, columns), while the table is made, which counts the errors of all its values."""
        found = self.scaled(lag)
        self.survival_error = max(self.survival_error, found.error)
        return found.both

    def scaled(self, lag: Array, born: Array | None = None) -> Survivors:
        """E and K/`scale` after lags of shape (rows, columns), from the life itself; `born` as in
        Life.survival_and_force."""
        stop_after(self._until)
        if not lag.size:
            return Survivors(np.zeros(lag.shape), np.zeros(lag.shape), 0.0)
        if born is None and self.born.is_single and self.life.timeless:
            return self._of_one_stretch(lag)
        far = max(float(lag.max()), self.longest) / self._per_time
        motion = Motion(np.array([0.0, far]), np.array([0.0, far * self._speed]))
        history = motion.history(lag / self._per_time, np.zeros((1, 1)))
        found = self.life.survival_and_force(self.born if born is None else born, history)
        return found._replace(force=found.force / self.scale)

    def _of_one_stretch(self, lag: Array) -> Survivors:
        """As `scaled`, of a timeless life and one stretch at birth, by moves without a motion: most calls are short."""
        moves = History.straight((self._speed / self._per_time * lag).ravel())
        born = np.full(lag.size, self.born.mean())
        side = np.repeat(middle_of(moves.largest(born).reshape(lag.shape)), lag.shape[1])
        found = self.life.survivors(born, side, moves).reshape(*lag.shape)
        return found._replace(force=found.force / self.scale)

    def look_up(self, lag: Array) -> Survivors:
        """E and K after lags in rows, from a table if there is one; each row lies within one smooth piece, as in
        History."""
        ends, middle = self._bounds, middle_of(lag)
        after = clipped(np.searchsorted(ends, middle, "right"), 1, ends.size - 1)
        holds = (middle < self._last) | (lag < self._last * (1.0 - TIE))
        lag = clipped(lag, ends[after - 1], np.nextafter(ends[after], ends[0]))
        found = self._read(lag)
        return Survivors(found.survival * holds, found.force * holds * self.scale, found.error)

    def all_hold(self, births: BirthPanels, first: Rows, t: Array) -> Array:
        """Number and force, shape (2, n), at times t of the births on the panels from each `first` on, shape (n,), all
        of which are held."""
        share, width = births.slopes[:, 0], np.diff(births.ends)
        # by the end of the last panel, as a moment about 0 would lose digits
        from_end = births.ends[-1] - births.ends[:-1] - 0.5 * width
        moved = from_end * share - births.slopes[:, 1] * width / 6.0
        behind = np.stack([np.cumsum(part[::-1])[::-1] for part in (share, moved)])
        number, lag = np.append(behind, np.zeros((2, 1)), axis=1)[:, first]
        lag = lag + number * (t - births.ends[-1])
        return np.stack([number, self.born.mean() * number + self._speed * lag])

    def _lags_at(self, marks: Array) -> Array:
        """Lags at which contacts reach the lengths |x| of the marks; none where the slider rests."""
        sign, abs_speed, born = np.sign(self._speed), abs(self._speed), self.born
        ends = np.unique(sign * np.array([*born.span, *born.breakpoints]))
        # a contact born at r < 0 comes back to its largest |x| after a distance of -2 r
        distances = np.append(np.subtract.outer(marks, ends), -2.0 * ends)
        if not abs_speed:
            return np.empty(0)
        return np.unique(distances[distances > 0.0]) * (self._per_time / abs_speed)

    def _ladder(self, longest: float, steady: bool) -> _Ladder:
        """Lags from where nearly all contacts hold to where hardly any do, or to the longest."""
        lags = np.array([longest])
        survival = self._for_table(lags[:, None])[0, :, 0]
        while survival[0] < 1.0 - AT_FIRST and lags[0] > NEGLIGIBLE * float(
            survival[1:] @ np.diff(lags)
        ):
            if lags[0] < SHORTEST_LAG * longest:
                fault = "contacts break before they have moved a length that is a number"
                instead = "slide faster where heat breaks them, slower where thresholds grow"
                refuse("velocity", abs(self._speed), f"{fault}; {instead}")
            lower = lags[0] * RATIO ** -np.arange(LAGS_TOGETHER, 0.0, -1.0)
            lags, survival = (
                np.append(lower, lags),
                np.append(self._for_table(lower[:, None])[0], survival),
            )
        typical = float(lags[np.flatnonzero(survival > 0.5 * survival.max())[-1]])
        end = FURTHEST_LAG * longest if steady else longest
        while survival[-1] * (lags[-1] / typical) ** 2 > NEGLIGIBLE and lags[-1] < end:
            lags = np.append(lags, 2.0 * lags[-1])
            survival = np.append(survival, self._for_table(lags[-1:, None])[0])
        over = survival < NO_SURVIVAL
        count = lags.size if steady or not over.any() else int(np.argmax(over)) + 1
        return _Ladder(lags[:count], survival[:count], typical)


def _edges(longest: float, lags: Array) -> Array:
    """Sorted edges from 0 to the longest lag, without those that are equal apart from rounding."""
    edges = np.unique(np.concatenate([[0.0], lags[(lags > 0.0) & (lags < longest)], [longest]]))
    return np.append(edges[:-1][np.diff(edges) > SAME_EDGE * edges[1:]], longest)
