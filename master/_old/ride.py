"""A soft slider at T = 0: a spring K between the drive X_T and the slider X, K (X_T - X) = F(X); slips take no time.

Where F'(X) = -K the slider slips. What a slip does is a rule that must be said:

    "reset"         all contacts are drawn anew, relaxed; the slider jumps to where K (X_T - X) = F, which is X = X_T;
    "instant"       contacts re-form at once; the slider goes to the first X' that balances again, F(X') + K X' = K X_T;
    "reform-after"  broken contacts stay out until the slip ends, those that hold stretch and may break; it ends where
                    K (X_T - X) meets the force of those that hold, and then the broken are back at x = 0.

The drive begins where it balances the start, X_T = F(0)/K at X = 0, and moves straight from there to the first point
of its path.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.cohort import SLACK, Cohort
from master._old.curve import inverse, landing, onset
from master._old.forward import first_step, least_share
from master._old.law import Law
from master._old.leg import Leg, State
from master._old.moves import moves
from master._old.sliding import Holding, Sliding
from origins.drive import SlipRule

Array = npt.NDArray[np.float64]

_HORIZON = 3.0
_LONGER = 2.5
_ACCURACY = 1e-13
_WATCHED = 2049
_BEND = 1e-4


@dataclass(frozen=True)
class Slip:
    """One slip, in units of the mean threshold; `bend` is |F''| where it begins, 0 where the force drops at once."""

    drive: float
    before: float
    after: float
    force_before: float
    force_after: float
    bend: float


class Ride:
    """One drive of a soft slider on one level of refinement; lengths in units of the mean threshold.

    Attributes
    ----------
    position, force : arrays of shape (n,)
        X and F where the drive stands at the positions asked for.
    slips : list of Slip
    least_slope : float
        Smallest F'(X) + K met while the slider did not slip.
    """

    def __init__(
        self, law: Law, begin: State, spring: float, rule: SlipRule, drive: Array, tolerance: float, level: int
    ) -> None:
        self._law, self._spring, self._rule = law, spring, rule
        self._tolerance, self._scale = tolerance, 0.5**level
        self._accuracy = min(1e-6 * tolerance, _ACCURACY)
        self._relaxed: dict[int, tuple[Sliding, float]] = {}
        self.position, self.force = np.empty(drive.size), np.empty(drive.size)
        self.slips: list[Slip] = []
        self.least_slope, self.least_share, self.nodes = np.inf, 0.0, 0
        self._state, self._known_to = begin, 0.0
        balance = begin.at + begin.force(law)[1] / spring
        for move in moves(drive - balance):
            self._direction = move.direction
            self._end = balance + move.turn + move.direction * move.travel
            self._asked = move.direction * drive[move.points]
            self._position, self._force = self.position[move.points], self.force[move.points]
            self._follow()

    @property
    def error(self) -> float:
        """What the series of breaks and births are off by."""
        return self._state.error

    def _follow(self) -> None:
        """The drive goes straight on to its end, through all slips on the way."""
        while True:
            if self._rule == "reset" and self.slips and self._state.at == self.slips[-1].after and self._repeat():
                return
            state, d = self._state, self._direction
            target = self._spring * d * (self._end - state.at)
            curve, let_go = self._until_slip(state, target)
            begin = 0.0
            while True:
                last, level, dropped = _holds_to(curve, let_go)
                if level >= target or not np.isfinite(let_go):
                    self._answer(curve, state.at, begin, last, np.inf)
                    at_end = float(inverse(curve, np.array([target]), begin, last)[0])
                    self._state, self._known_to = curve.leg.end_state(at_end).whole(self._law), curve.leg.step
                    return
                self._answer(curve, state.at, begin, last, level)
                if self._rule != "instant":
                    break
                begin = min(landing(curve, let_go, level, dropped), curve.end)
                self._note(curve, state.at, let_go, begin, level)
                let_go, least = onset(curve, begin)
                self.least_slope = min(self.least_slope, least)
            if self._rule == "reset":
                self._note(curve, state.at, let_go, level / self._spring, level)
                self._state, self._known_to = relaxed(self.slips[-1].after), 0.0
            else:
                self._slip_and_hold(curve, state.at, last, let_go, level, dropped)

    def _repeat(self) -> bool:
        """Cycle after cycle from relaxed contacts, all alike, to the drive's end; False if they do not slip again."""
        at, d, spring = self._state.at, self._direction, self._spring
        if d not in self._relaxed:
            curve, let_go = self._until_slip(relaxed(0.0), spring * d * (self._end - at))
            if not np.isfinite(let_go):
                return False
            self._relaxed[d] = curve, let_go
        curve, let_go = self._relaxed[d]
        last, level, _ = _holds_to(curve, let_go)
        period = level / spring
        travel = d * (self._end - at)
        cycles = int(travel / period)
        asked = self._asked - d * at
        before = np.floor(asked / period)
        y = inverse(curve, spring * (asked - period * before), 0.0, last)
        self._position[:] = at + d * (period * before + y)
        self._force[:] = d * curve.force(y)
        for cycle in range(cycles):
            self._note(curve, at + d * period * cycle, let_go, period, level)
        rest = np.array([spring * (travel - period * cycles)])
        state = curve.leg.end_state(float(inverse(curve, rest, 0.0, last)[0])).whole(self._law)
        self._state, self._known_to = state.moved(at + d * period * cycles), curve.leg.step
        return True

    def _until_slip(self, state: State, target: float) -> tuple[Sliding, float]:
        """A leg long enough to show the next slip or to carry the target, and where it lets go."""
        d, law = self._direction, self._law
        # where nothing pulls back, K y alone carries as much
        cap = max(target / self._spring, state.backward(d), 1e-12)
        end = cap if self._rule == "instant" else min(cap, _HORIZON)
        while True:
            step = first_step(law, True, end, self._tolerance) * self._scale
            watched = np.linspace(0.0, end, _WATCHED)
            leg = Leg(law, state, d, end, step, self._accuracy, self._known_to, watched)
            curve = Sliding(leg, self._spring)
            let_go, least = onset(curve, 0.0)
            carried = float(curve.load(np.array([min(let_go, end)]))[0])
            if np.isfinite(let_go) or carried >= target or end >= cap:
                self.least_slope = min(self.least_slope, least)
                self.least_share = max(self.least_share, least_share(leg.problem, step))
                self.nodes = max(self.nodes, leg.nodes)
                return curve, let_go
            end = min(cap, _LONGER * end)

    def _answer(self, curve: Sliding, at: float, low: float, high: float, level: float) -> None:
        """X and F at those points of the drive that come before the load `level`."""
        loads = self._spring * (self._asked - self._direction * at)
        count = int(np.searchsorted(loads, level))
        if count:
            y = inverse(curve, loads[:count], low, high)
            self._position[:count] = at + self._direction * y
            self._force[:count] = self._direction * curve.force(y)
            self._asked = self._asked[count:]
            self._position, self._force = self._position[count:], self._force[count:]

    def _note(self, curve: Sliding, at: float, let_go: float, landed: float, level: float) -> None:
        d, spring = self._direction, self._spring
        near = np.clip(let_go + _BEND * np.array([-1.0, 1.0]), 0.0, curve.end)
        bend = 0.0 if let_go in curve.drops else float(np.abs(np.diff(curve.slope(near)) / np.diff(near))[0])
        before, after = level - spring * let_go, level - spring * landed
        self.slips.append(
            Slip(at + d * level / spring, at + d * let_go, at + d * landed, d * before, d * after, bend)
        )

    def _slip_and_hold(
        self, curve: Sliding, at: float, last: float, let_go: float, level: float, dropped: bool
    ) -> None:
        d, law, spring = self._direction, self._law, self._spring
        state = curve.leg.end_state(last).whole(law)
        backward, whole = state.backward(d), level / spring - last
        longest = float(np.append(law.edges[-1:], law.atoms).max()) + backward
        end = max(min(max(whole, backward), longest), 1e-12)
        hold = Holding(law, state, d, end, self._accuracy, curve.leg.step, spring)
        # the exact value that breaks lies a little ahead of where the state was taken
        begin = float(hold.drops[0]) * (1.0 + SLACK) if dropped and hold.drops.size else 0.0
        slipped = landing(hold, begin, level - spring * last, dropped)
        # where none of the contacts is left the slider goes all the way
        slipped = slipped if np.isfinite(slipped) else whole
        self._note(curve, at, let_go, last + slipped, level)
        self._state, self._known_to = hold.end_state(slipped).whole(law), curve.leg.step


def relaxed(at: float) -> State:
    """All contacts relaxed, and fresh, where the slider stands."""
    return State(at, [Cohort(at, at, positions=np.array([at]), weights=np.ones(1))])


def _holds_to(curve: Sliding, let_go: float) -> tuple[float, float, bool]:
    """Last travel before it lets go, the load there, and whether that falls at once."""
    dropped = let_go in curve.drops
    last = let_go * (1.0 - 10.0 * SLACK) if dropped else min(let_go, curve.end)
    at = np.array([last])
    # the load that it lets go of is the one just before the drop
    rise = float(curve.slope(at)[0]) * (let_go - last) if dropped else 0.0
    return last, float(curve.load(at)[0]) + rise, dropped
