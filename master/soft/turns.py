"""What follows where the place of a turn is not quite known, for a soft slider at T = 0.

The drive turns at a known X_T. There the force at a given travel is off by e, and the history of the move lies off by s
in X. The slider then turns at another travel, and at another X, than was computed, by

    (e + K s)/(F' + K)    and    (e + F' s)/(F' + K).

Either history may go on behind the turn:

- that of the move, off by s. The contacts that broke on the way from one turn to the other, or did not, bear another
  force: 1 - F' per way, as F' is 1 where none breaks (`loss_of_breaks`).
- the same, carried along to where the slider turns. The contacts then are as they were a way before, which is nothing
  new where breaks are steady (`unsteadiness`): all that is off there is X, on which the force does not depend.

In steady sliding F' is 0, and the first one would make the error larger by 1/K, turn after turn.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from master.numerics import polynomials
from master.renewal.births import panel_at
from master.soft.curve import LoadCurve
from master.soft.followed import LEAVE_OUT, LOOSEN, SHORTEN, UNRELIABLE
from master.soft.moves import Move


class Misplaced(NamedTuple):
    """Of a history: the error of the force at a given travel, and that of its place in X (lengths)."""

    error: float
    shift: float


class LegEnd(NamedTuple):
    """Where the drive turns or ends (X_T, a length), and the error of the force up to there (mean thresholds)."""

    end: float
    error: float


def remedy_of(legs: Sequence[LegEnd], heat: float, tolerance: float) -> str:
    """What the user may do to make the error smaller; it grows from turn to turn, which no looser tolerance changes.
    `heat` : what heat that is left out changes in F at a given X; all in mean thresholds."""
    last = LOOSEN if heat <= tolerance else LEAVE_OUT
    known = tolerance if legs and legs[-1].error < UNRELIABLE else UNRELIABLE
    within = [leg for leg in legs if leg.error < known]
    if 0 < len(within) < len(legs):
        place = f"X_T = {within[-1].end:.6g}, up to which it is {within[-1].error:.1e}"
        return f"end the path at the turn at {place}, or {last}"
    return SHORTEN if heat <= tolerance else f"end the path sooner, or {last}"


def behind_turn(move: Move, curve: LoadCurve, y: float, shift: float) -> Misplaced:
    """Errors of the history behind a turn after the travel y, of a move whose history lies off by `shift`."""
    spring, error = move.contacts.spring, float(curve.error_at(y))
    off_in_travel = float(curve.travel_errors(y, 0.0, spring * shift))
    off_in_position = float(curve.travel_errors(y, shift))
    stays = Misplaced(error + loss_of_breaks(move, curve, y) * off_in_travel, shift)
    carried = Misplaced(error + unsteadiness(move, y) * off_in_travel, off_in_position)
    return min(stays, carried, key=lambda one: one.error + spring * one.shift)


def loss_of_breaks(move: Move, curve: LoadCurve, y: float) -> float:
    """By how much, per way, the force is another later on if contacts have broken on a little more of the way.

    At once it is by the stiffness of those that hold, less F'. Where weak ones have broken, those that form may bear
    more later: at a stretch x some x k(x) sf(x), at most <k x_s> by Markov's inequality.
    """
    contacts, slope = move.contacts, float(curve.load_slope(y)) - move.contacts.spring
    at_once = abs(contacts.steady_stiffness - slope)
    solved, now = move.march.solved, move.loaded.move_begins_at + move.travel_of_state(y)
    panel = panel_at(solved.begin, now)
    width = solved.width[panel]
    place = np.array([(now - solved.begin[panel]) / width])
    rate = polynomials.legendre_values(place) @ (polynomials.SLOPES @ solved.breaks[panel]) / width
    return max(at_once, float(rate[0]) * contacts.steady_stiffness * contacts.unit)


def unsteadiness(move: Move, y: float) -> float:
    """By how much, per way, the force may be another later on if the contacts of the travel y are carried along.

    Of births on the move at the rate b, those that hold are then as many as b was a way before. Contacts from before
    the move are stretched by another length; their force changes no faster than by the largest one over the
    break length (ColdContacts). No bound is known where thresholds are exact, nor on a move of no length.
    """
    contacts, march, before = move.contacts, move.march, move.loaded.move_begins_at
    now = before + move.travel_of_state(y)
    solved = march.solved.up_to(now, 0.0).pick(slice(move.first, None))
    if contacts.life.atoms.size or not solved.count:
        return np.inf
    leg = int(march.motion.leg(0.5 * (before + now)))
    number = float(march.births_on_leg(np.array([now - before]), leg, solved)[0, 0])
    nodes = polynomials.gauss(polynomials.PANEL_NODES).nodes
    lags = now - (solved.begin[:, None] + solved.width[:, None] * nodes)
    holding = march.present.look_up(float(move.direction), np.maximum(lags, 0.0).reshape(-1, 1))
    changes = np.abs(np.diff(solved.rates_from(before).ravel(), prepend=0.0))
    of_births = float(changes @ holding[0, :, 0])
    largest = contacts.life.largest_stretch
    return largest * (of_births + max(1.0 - number, 0.0) / contacts.break_length)
