"""Slips beyond the end of a path, of a slider at T = 0 whose contacts form again at once, on a drive that goes forward.

Such a slider passes along F(X) of a rigid one, in its slips, too. So contacts forget the slips, and what is to come is
known once F falls nowhere more steeply than K. When none of the contacts of the move's begin is left, nor of those born
before, F is a mean of its values over the longest life (renewal equation), and so is F'. From there on F' stays within
its values over one life: if the load rises all along one, with the error of F' counted, it rises for good. Where F' is
found only before that, it falls as e^(-y/X*), y the travel.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from master.outcome import StoppedError
from master.soft.decohered import DECOHERES, HIDDEN, TWO_LIVES
from master.soft.moves import Move

# Most instants at which number conservation is solved beyond the path's end: some 0.5 s.
MOST_NODES = 20_000
# Part of K that |F'| may be where e^(-y/X*) tells from where on it is so small, and that its error may be.
OF_SPRING = 0.1


class SlipsAhead(NamedTuple):
    """Slips beyond a path's end.

    drive : X_T of those that were found, in order (lengths)
    all_found : whether none comes behind them
    """

    drive: tuple[float, ...]
    all_found: bool

    def behind(self, count: int) -> str:
        """In words that they follow `count` slips, and that none comes behind them."""
        slips = "1 slip" if count == 1 else f"{count} slips"
        more = f", {len(self.drive)} more up to X_T = {self.drive[-1]:.4g}" if self.drive else ""
        return (
            f"{slips} up to the end of the path{more}, then none: F falls no more as steeply as K"
        )


def nothing_ahead_known() -> SlipsAhead:
    """Of slips beyond the path's end nothing is known."""
    return SlipsAhead((), False)


def slips_ahead(move: Move, y: float, begin: float) -> Callable[[], SlipsAhead]:
    """What finds the slips of this forward move, which begins at X = `begin`, behind its travel y (lengths)."""

    def find() -> SlipsAhead:
        found, at, most = list[float](), y, move.contacts.nodes + MOST_NODES
        try:
            # contacts of exact thresholds may keep their step for ever
            while not move.contacts.life.atoms.size:
                travel = _next_slip(move, at, most)
                if not np.isfinite(travel):
                    return SlipsAhead(tuple(found), bool(np.isinf(travel)))
                slip = move.next_slip(at, np.inf)
                found.append(begin + slip.load / slip.curve.spring)
                at = move.end_of_slip(slip.travel, slip.load, slip, goes_on=True).travel
        except StoppedError:
            pass
        return SlipsAhead(tuple(found), False)

    return find


def _next_slip(move: Move, after: float, most_nodes: int) -> float:
    """The first travel behind `after` at which a slip begins; inf where none does, nan where that is not found soon."""
    contacts, travel = move.contacts, after
    while contacts.nodes < most_nodes:
        curve = move.curve_to(travel, after)
        if np.isfinite(begins := curve.slip_begins(after)):
            return begins
        if _rises_from(move) <= max(after, move.solved_to):
            # a fall within the error of F' may be one
            return np.nan if np.isfinite(curve.may_fall(after)) else np.inf
        if move.steady:
            break
        travel = curve.to_travel + contacts.life.resolution_length
    return np.nan


def _rises_from(move: Move) -> float:
    """A travel from which on the load rises for good; inf where none is known yet."""
    contacts, end = move.contacts, move.solved_to
    largest, life = contacts.life.largest_stretch, move.march.present.straight(1.0).longest
    # the travel after which no contact from before the move is left
    renewed = max(life, largest - min(move.loaded.start.span[0], 0.0))
    undisturbed = end - max(0.0, move.march.lumps[-1].birth - move.loaded.move_begins_at)
    if undisturbed < renewed + life:
        return np.inf
    slope, error = move.solved_curve(since=end - life).largest_slope(end - life, end)
    spring = contacts.spring
    if slope + error < spring:
        return end
    # the error of F' is no part of what falls
    slow = undisturbed < DECOHERES * TWO_LIVES * largest
    if slow or error > OF_SPRING * spring or not np.isfinite(contacts.decoherence_length):
        return np.inf
    lengths = float(np.log(HIDDEN * slope / (OF_SPRING * spring)))
    return end + lengths * contacts.decoherence_length
