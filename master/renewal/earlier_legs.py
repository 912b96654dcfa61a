"""Births on earlier legs: number and force, on the present leg, of contacts born where the slider moved otherwise.

The births of a leg add the integrals of E(t, s) dJ(s) and K(t, s) dJ(s) over the times s of birth. dJ/ds is a
polynomial on each panel. Over s, E and K bend where the largest |x| of a contact changes sides or meets a bend of the
law, and are smooth in between. So for each t the leg is cut into pieces at these s (`pieces_of_births`); on each piece
E and K are approximated by polynomials through a few nodes (`_fitted`); pieces on which these are too rough are halved
(`_rough`); the others are summed (`_integrated`). Where thresholds grow, E is largest and bends at other s: even pieces
are narrow enough to see where, and halving finds the bend.

`bends_of_births` is more than a way to save halvings: pieces of which no contact holds are left out (`_some_may_hold`),
told by a few births inside. Where a bend is missing, births that hold would be left out with their piece; that is a
fault.

All times are counted from the beginning of the present leg (see past.py), those of births too.
"""

import time as clock
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.motion import Motion
from master.numerics import polynomials
from master.numerics.polynomials import Pieces
from master.outcome import FaultError
from master.renewal.births import MOST_WORK, BirthPanels, Births, Sums
from origins.thresholds.law import Array

# Nodes of a piece that are tried first where a survival takes long; they are doubled before the piece is halved. Of 5
# two coefficients may be small by chance, and were taken for the error; seven take as long.
FIRST_NODES = 7
# Where the slider turns, and no bend tells at which birth a survival is largest: width of the first pieces, in
# resolution lengths of the life, on which nodes see the peak; and most of them on a leg, wider where the longest
# stretch is far.
SEEN_WITHIN, MOST_CUTS = 4.0, 50
# Rounding of a time of birth, relative: that of some sums and differences of times.
ROUNDED_TIME = 1e-14
# Births that stand for all on a piece, as parts of it: those inside tell of a piece on which all hold, or none, whether
# that is so; the ends and the middle leave none out where some hold.
NEAR_ENDS_AND_MIDDLE, ENDS_AND_MIDDLE = np.array([0.02, 0.5, 0.98]), np.array([0.0, 0.5, 1.0])


class Fitted(NamedTuple):
    """E and K on pieces as polynomials in the time of birth.

    series : Legendre coefficients of E and K, shape (2, pieces, nodes)
    left_out : about the first coefficient that is left out, shape (pieces,): the larger of that of E, and of K divided
        by the longest stretch on the motion
    fall : the factor by which coefficients fall from one to the next, shape (pieces,)
    survival_error : that of E at the nodes

    An example, of four nodes on one piece: of E the coefficients are of the sizes 8e-4, 2e-5, 2e-4 and 5e-6. The larger
    of the last two is 2e-4, a quarter of that of the two before: so `fall` is 1/4^(1/2) = 1/2, and the first that is
    left out about 2e-4/2 = 1e-4. If births weigh the four by 0.2, 0.01, 0.002 and 0.001, those that are left out are
    taken for 1e-4 (0.001 + 0.002/2 + 0.01/4 + 0.2/8) = 3.0e-6 of the number (`EarlierLegs._integrated`).
    """

    series: Array
    left_out: Array
    fall: Array
    survival_error: float


class EarlierLegs:
    """Births on some of the legs before the present one."""

    def __init__(
        self,
        births: Births,
        motion_leg: Motion,
        leg: int,
        legs: npt.NDArray[np.intp],
        births_leg: BirthPanels,
        accuracy: float,
    ) -> None:
        """`births_leg` are the births on all legs before `leg`, of which those on `legs` count."""
        self._births, self._life, self._motion_leg = births, births.life, motion_leg
        self._leg, self._legs = leg, legs
        self._births_leg, self._accuracy = births_leg, accuracy

    def sums(self, t_leg: Array) -> Sums:
        """Number and force at times, shape (n,); both of shape (2, n)."""
        both, missed, survival_error = np.zeros((2, t_leg.size)), np.zeros(t_leg.size), 0.0
        holding_at_latest = np.zeros(self._leg)  # by leg
        pieces = self.pieces_of_births(t_leg)
        size = polynomials.PANEL_NODES if self._life.pair_work == 1 else FIRST_NODES
        while pieces.owner.size:
            fitted = self._fitted(pieces, t_leg, size)
            survival_error = max(survival_error, fitted.survival_error)
            rough = self._rough(pieces, fitted)
            good = pieces.pick(~rough)
            (number, force), lost = self._integrated(good, fitted, ~rough)
            both[0] += np.bincount(good.owner, number, t_leg.size)
            both[1] += np.bincount(good.owner, force, t_leg.size)
            missed += np.bincount(good.owner, lost, t_leg.size)
            at_latest = t_leg[good.owner] == t_leg.max()
            leg = self._motion_leg.leg(0.5 * (good.low + good.high)[at_latest])
            holding_at_latest += np.bincount(leg, number[at_latest], self._leg)
            pieces = pieces.pick(rough)
            if size == polynomials.PANEL_NODES:
                pieces = pieces.halves()
            size = min(2 * size, polynomials.PANEL_NODES)
        holding_by_leg = {leg: float(holding_at_latest[leg]) for leg in self._legs.tolist()}
        return Sums(both, float(missed.max()), survival_error, holding_by_leg)

    def _fitted(self, pieces: Pieces, t_leg: Array, size: int) -> Fitted:
        """Polynomials of E and K on pieces, as seen from these times, through so many nodes."""
        # pieces may end at exact thresholds, where the survival jumps
        nodes = (polynomials.gauss if self._life.atoms.size else polynomials.lobatto)(size)
        birth_leg = pieces.low[:, None] + (pieces.high - pieces.low)[:, None] * nodes.nodes
        self._births.add_work(pieces.owner.size * size // polynomials.PANEL_NODES)
        history = self._motion_leg.history(t_leg[pieces.owner, None], birth_leg)
        found = self._life.survival_and_force(self._births.law, history)
        series = found.both @ nodes.series
        last, fall_of_two = polynomials.last_and_fall(np.abs(series[..., -4:]))
        # the first coefficient that is left out comes one after the last, and `fall_of_two` is the ratio over two
        fall, unit = np.sqrt(fall_of_two), np.array([[1.0], [self._births.longest_stretch]])
        left_out = (last * fall / unit).max(axis=0)
        return Fitted(series, left_out, fall.max(axis=0), found.error)

    def _rough(self, pieces: Pieces, fitted: Fitted) -> npt.NDArray[np.bool_]:
        """The pieces to be halved; none after too much work. The accuracy is asked of each piece, see ErrorBudget, and
        errors are taken times the number of legs, so that all legs together stay within that of one."""
        off = fitted.left_out * self._births_leg.most_between(pieces) * self._legs.size
        goes_on = self._births.work <= MOST_WORK and clock.monotonic() <= self._births.until
        wide = pieces.high - pieces.low > self._narrowest(pieces)
        return (off > self._accuracy) & wide & goes_on

    def _narrowest(self, pieces: Pieces) -> Array:
        """The width below which both ends of a piece are equal by rounding, shape (pieces,)."""
        leg = self._motion_leg.leg(0.5 * (pieces.low + pieces.high))
        durations = np.diff(self._motion_leg.times)[leg]
        return np.asarray(polynomials.CLOSE * durations + ROUNDED_TIME * np.abs(pieces.low))

    def _integrated(
        self, pieces: Pieces, fitted: Fitted, which: npt.NDArray[np.bool_]
    ) -> tuple[Array, Array]:
        """Number and force of births on the pieces, shape (2, pieces), and what the number misses; `which` of the
        polynomials are theirs."""
        series = fitted.series[:, which]
        weights = self._births_leg.legendre_weights(pieces, series.shape[-1])
        # Left out are the coefficients c of degrees n + k, about |c_n| fall^k, with n the first that is left out; each
        # is multiplied by the births' weight w of its degree: missed = |c_n| (sum over k of |w_(n + k)| fall^k). Of
        # weights those below n alone are known, so that |w_(n - 1 - k)| is taken for |w_(n + k)|. It is no smaller as a
        # rule, as weights of smooth births fall with the degree: an estimate, which `make promise` tests.
        fading = fitted.fall[which, None] ** np.arange(series.shape[-1])[::-1]
        missed = fitted.left_out[which] * (np.abs(weights) * fading).sum(axis=1)
        return (series * weights).sum(axis=-1), missed

    def pieces_of_births(self, t_leg: Array) -> Pieces:
        """Pieces of the births on each leg, for each target, with ends where the survival bends; without those of which
        none holds."""
        motion_leg, law, legs = self._motion_leg, self._births.law, self._legs
        # arrays of shape (targets, legs, ends of pieces)
        begin_of_births, end_of_births = self._births_leg.ends[[0, -1]]
        first = np.clip(motion_leg.times[legs], begin_of_births, end_of_births)[None, :, None]
        last = np.clip(motion_leg.times[legs + 1], begin_of_births, end_of_births)[None, :, None]
        cuts = [np.broadcast_to(end, (t_leg.size, legs.size, 1)) for end in (first, last)]
        if law.is_single:
            cuts.append(np.clip(self.bends_of_births(t_leg, law.mean()), first, last))
        speeds = self._motion_leg.speeds
        if not self._life.peaks_at_bends and speeds.min() < 0.0 < speeds.max():
            even = self._even_cuts(first, last)
            cuts.append(np.broadcast_to(even, (t_leg.size, *even.shape[1:])))
        edges = np.concatenate(cuts, axis=2).reshape(t_leg.size * legs.size, -1)
        all_edges = Pieces.between(edges)
        pieces = Pieces(all_edges.owner // legs.size, all_edges.low, all_edges.high)
        return pieces.pick(self._some_may_hold(pieces, t_leg))

    def _some_may_hold(self, pieces: Pieces, t_leg: Array) -> npt.NDArray[np.bool_]:
        """Whether any contacts born on a piece hold at its target, told by births at three places, shape (pieces,).

        With one stretch at birth pieces end where contacts have met the end of P_c, so that all on a piece hold, or
        none. FaultError where some do: a bend is missing, and births that hold would be left out unseen."""
        law, width = self._births.law, pieces.high - pieces.low
        places = NEAR_ENDS_AND_MIDDLE if law.is_single else ENDS_AND_MIDDLE
        birth_leg = pieces.low[:, None] + width[:, None] * places
        if not law.is_single:
            moves = self._motion_leg.history(t_leg[pieces.owner, None], birth_leg)
            return self._births.may_hold(law, moves)
        now_leg = np.repeat(t_leg[pieces.owner], places.size)
        moves = self._motion_leg.history(now_leg[:, None], birth_leg.reshape(-1, 1))
        holds = self._births.may_hold(law, moves).reshape(-1, places.size)
        wide = width > 2.0 * self._narrowest(pieces) / places[0]
        # times behind the leg's end, where the slider has turned, are asked for and not read (March._numbers_at_edge)
        on_leg = t_leg[pieces.owner] <= self._motion_leg.times[self._leg + 1]
        cut_by_a_bend = wide & on_leg & holds.any(axis=1) & ~holds.all(axis=1)
        if cut_by_a_bend.any():
            first = int(np.argmax(cut_by_a_bend))
            raise FaultError(
                f"of the births between {pieces.low[first]:.6g} and {pieces.high[first]:.6g} after leg {self._leg} "
                "begins some hold, where all do or none: a bend of the survival is missing there"
            )
        return np.asarray(holds.any(axis=1))

    def _even_cuts(self, first: Array, last: Array) -> Array:
        """Times that cut the births of each leg, from its last one back to where none holds, shape (1, legs, cuts)."""
        far = self._life.largest_stretch
        count = min(int(np.ceil(far / (SEEN_WITHIN * self._life.resolution_length))), MOST_CUTS)
        distance = np.linspace(0.0, far, count + 1)[1:]
        abs_speed = np.abs(self._motion_leg.speeds[self._legs, None])
        rests = np.full((abs_speed.size, count), np.inf)  # births in a hold are not cut
        before_last = np.divide(distance, abs_speed, out=rests, where=abs_speed > 0.0)
        return np.maximum(last - before_last, first)

    def bends_of_births(self, t_leg: Array, born: float) -> Array:
        """Times of birth, at the one stretch `born`, for which the survival at `t_leg` bends or its force does, shape
        (targets, legs, bends); some lie outside the leg.

        An example: X goes from 0 to 1 and back at speed 1, P_c ends at 0.6, born = 0. Births on the way up are at o = s
        from 0 to 1. Seen from X = 0.5 at t = 1.5: low = 0.5, high = 1, so that high - 0.6 = 0.4, low + 0.6 = 1.1,
        middle = 0.75. Those born before s = 0.4 are out, as X was more than 0.6 above o; from 0.4 to 0.75 the largest
        |x| is 1 - o, and from 0.75 to 1, o - 0.5, at most 0.5; 1.1 lies outside. There is one more bend at s = 0.5,
        where x = 0.

        Let low and high be the ends of the move since then, and o = X(s) - born the place where the contact is relaxed.
        Its stretch is x = now - o, and its largest |x| so far is that at the end which is farther from o:

            low ------ high - mark ------ middle ------ low + mark ------ high      places o
             |     largest |x| = high - o    |     largest |x| = o - low    |

        A mark is a bend of P_c, |born| or the end of P_c. There is a bend where o is one of `goals`: the largest |x| is
        a mark, or changes from one end to the other (middle); or o is now, where x = 0, high or low.
        """
        motion_leg, legs = self._motion_leg, self._legs
        now = motion_leg.at(t_leg)[:, None, None]
        tops, bottoms = motion_leg.knots_between(self._leg, legs)
        high, low = np.maximum(now, tops[:, None]), np.minimum(now, bottoms[:, None])
        marks = np.append(self._life.bends, [abs(born), self._life.largest_stretch])
        middle = 0.5 * (high + low)
        now = np.broadcast_to(now, middle.shape)
        goals = [high - marks, low + marks, middle, now, high, low]
        begin, speed = motion_leg.positions[legs, None], motion_leg.speeds[legs, None]
        # from the leg's beginning to X(s) = o + born
        distance = born + np.concatenate(goals, axis=2) - begin
        into_leg = np.divide(distance, speed, out=np.zeros(distance.shape), where=speed != 0.0)
        return np.asarray(motion_leg.times[legs, None] + into_leg)
