"""Births on earlier legs of contacts that age: strands which follow the slider.

Where contacts age, the survival has no closed form in the slider's displacements. So contacts born at some instants s_i
of the leg (the strands) are followed once along each later leg. The sum over all births is a weighted sum over strands:
on pieces of the time of birth the survival E(t, s) is a polynomial in s, through its values at the s_i,

    number(t) = integral of E(t, s) dJ(s) = sum over i of w_i E(t, s_i);        the force alike, with E x for E.

In: births J as polynomials on panels (BirthPanels), and the motion. Out: number (a share of all contacts) and force (in
N_c <k>, a length) at times of the present leg, and their errors.

An example: births on leg 0, from t = 0 to 3 on the path, at the speed 1; the narrowest width of thresholds is 0.1. With
pieces of 0.4 at most (LENGTH) there are 8 of 0.375, each with 16 strands: 128 strands. The first is born at s = 0.375 *
0.0053 = 0.002, and aged by 2.998 to the leg's end. If leg 1 is from t = 3 to 5, they are followed by 2 more.

Clocks, as the ends of names say: `own_leg` counts from the beginning of the leg on which the births are, `leg` from the
present leg's, `path` from that of the path. Ages and durations need none.
"""

import numpy as np
from numpy.polynomial import legendre

from master.motion import Motion
from master.numerics import polynomials
from master.numerics.polynomials import Pieces, Rows
from master.renewal.births import BirthPanels, Births, Sums
from master.renewal.solved import SolvedPanels
from master.survival.age.ageing import ROUNDING, AgeingLife
from master.survival.age.passages import over_root
from origins.thresholds.law import Array

# On these pieces of the time of birth the error of the number is 1e-10 (measured): Gauss nodes of a piece,
SIZE = 16
# the slider's travel on a piece, divided by the narrowest width of the thresholds,
LENGTH = 4.0
# and the fewest pieces of a leg.
FEWEST_PIECES = 3
# Factor on the geometric mean of the two estimates in `_missed`: it is about right, and twice it a bound (measured).
SAFETY = 2.0


class Strands:
    """Births on all legs before the present one, which are followed from leg to leg."""

    def __init__(self, births: Births, left_out_below: float) -> None:
        """Before the first leg. `left_out_below`: the share of all contacts, that were born on a leg and hold, below
        which they are left out for good; and the survival below which a single strand is not followed."""
        self._births, self._left_out_below = births, left_out_below
        self._leg = 0
        self._of_legs = list[StrandBirths]()

    def follow(
        self,
        motion_leg: Motion,
        to_leg: int,
        panels: SolvedPanels,
        births_begin_own_leg: Array,
        legs: Rows,
    ) -> float:
        """Make strands of the births on the legs that have ended since it was called last, and follow all strands to
        the leg `to_leg`, which begins at t = 0 of this motion; returns the share of all contacts that are left out from
        now on. `births_begin_own_leg`: when the births of each panel begin, on the leg `legs`."""
        least, left_out = self._left_out_below, 0.0
        ended, self._leg = range(self._leg, to_leg), to_leg
        for leg in ended:
            on_it = legs == leg
            number = float(np.abs(panels.breaks[on_it]).max(axis=1).sum())
            if number > least:
                births_own_leg = panels.pick(on_it).births(births_begin_own_leg[on_it])
                self._of_legs.append(StrandBirths(self._births, leg, births_own_leg))
                # single strands of which less than `least` holds are left out as they are followed (dropped_below)
                left_out += least * self._of_legs[-1].births
            else:
                left_out += number
        followed, self._of_legs = self._of_legs, []
        for each in followed:
            if each.follow_along(motion_leg, least):
                self._of_legs.append(each)
            else:
                left_out += each.holding
        return left_out

    def sums(self, t_leg: Array) -> Sums:
        """Number and force at times, shape (n,), on the leg to which they were followed; both of shape (2, n)."""
        both = np.zeros((2, t_leg.size))
        for each in self._of_legs:
            both += each.sums(t_leg)
        missed = sum(each.missed for each in self._of_legs)
        survival_error = max((each.survival_error for each in self._of_legs), default=0.0)
        return Sums(both, missed, survival_error)


class StrandBirths:
    """The births of one finished leg, for contacts that age.

    missed : error of the number, as polynomials in the time of birth approximate the survival
    survival_error : that of the survival at the strands, on all legs so far

    _passages : the strands, where they are now: at the end of the leg `_at_end_of`
    _moves : a generator; each `next` moves `_passages` on along one more leg, and gives the survival and force on it.
        Legs are asked for one by one, as each takes long, and before the next all may have broken
    """

    def __init__(self, births: Births, leg: int, births_own_leg: BirthPanels) -> None:
        """Begin a strand at each node of the births on a leg, aged up to its end.

        An example: leg 1 lasts from 2 to 5 on the path. A contact born 0.4 into it is 5 - 2 - 0.4 = 2.6 old at its end.
        """
        life, motion_path = births.life, births.motion
        assert isinstance(life, AgeingLife)
        self._at_end_of, self.missed = leg, 0.0
        ends_own_leg, speed = births_own_leg.ends, float(motion_path.speeds[leg])
        count = max(FEWEST_PIECES, np.ptp(ends_own_leg) * abs(speed) / (LENGTH * life.width))
        edges_own_leg = np.linspace(ends_own_leg[0], ends_own_leg[-1], int(np.ceil(count)) + 1)
        pieces_own_leg = Pieces(
            np.arange(edges_own_leg.size - 1), edges_own_leg[:-1], edges_own_leg[1:]
        )
        basis, widths = polynomials.gauss(SIZE), pieces_own_leg.high - pieces_own_leg.low
        nodes_own_leg = pieces_own_leg.low[:, None] + widths[:, None] * basis.nodes
        duration = motion_path.times[leg + 1] - motion_path.times[leg]
        ages = np.maximum(duration - nodes_own_leg.ravel(), 0.0)
        stretches = life.stretches(births.law)
        fresh = life.begin(stretches.nodes)
        fresh.until = births.until
        self._passages = fresh.aged(speed, ages)
        self._moves, self._stretches_error = life.follow(self._passages, leg + 1), stretches.error
        # w_i, of the pieces' nodes in a sum over all births, shape (pieces, SIZE)
        self._weight = births_own_leg.legendre_weights(pieces_own_leg, SIZE) @ basis.series.T

    @property
    def births(self) -> float:
        """Share of all contacts that were born on the leg."""
        return float(np.abs(self._weight).sum())

    @property
    def holding(self) -> float:
        """Share of all contacts that were born on the leg and hold where the strands are now."""
        return float(np.abs(self._weight).ravel() @ self._passages.surviving_fractions()[0])

    @property
    def survival_error(self) -> float:
        """By the stretches at birth, the first passages with splines between instants, and rounding."""
        return self._stretches_error + self._passages.error + ROUNDING

    def follow_along(self, motion_leg: Motion, left_out_below: float) -> bool:
        """Follow the strands along the leg that begins at t = 0 of this motion, to its end; whether more than this
        share hold at its begin."""
        self._passages.dropped_below = left_out_below
        present_leg = int(motion_leg.leg(np.finfo(float).tiny))  # the one on which t = 0+ is
        while self._at_end_of < present_leg:
            if not self.holding > left_out_below:
                return False
            # ages `_passages` in place, to the leg's end: `holding` is then that at this end
            times_leg, followed = next(self._moves)
            self._at_end_of += 1
            survivors = followed.reshape(*followed.shape[:-1], -1, SIZE)
            self.missed = max(self.missed, float(_missed(survivors[:, 0], self._weight).sum()))
            self._sums = over_root(times_leg, np.einsum("jkpi,pi->jk", survivors, self._weight))
        return True

    def sums(self, t_leg: Array) -> Array:
        """Number and force at times, shape (n,), since the leg's beginning; shape (2, n)."""
        return np.moveaxis(self._sums(t_leg), -1, 0)


def _missed(survival: Array, weight: Array) -> Array:
    """Error of the sums over each piece's nodes; the survival has shape (times, pieces, SIZE).

    Its coefficients alone, extrapolated by their decay, overestimate the error up to 1e4 times, as the rate of
    births is nearly constant; what the last ones contribute to the sums underestimates it up to 20 times. The
    geometric mean of both is about right, SAFETY times that a bound.

    An example, of one piece: the last coefficients are 1e-6 and fall to a tenth over two; births of 0.2 on the piece,
    of which the last two moments are 0.001. Then `alone` is 1e-6 * 0.1² * 0.2 = 2e-9, `changed` 2 * 1e-6 * 0.001 =
    2e-9, and the error 4e-9.
    """
    basis = polynomials.gauss(SIZE)
    size = np.abs(survival @ basis.series)
    last, fall_of_two = polynomials.last_and_fall(size)
    # four coefficients after the last: Gauss nodes sum those up to twice the degree exactly where births are constant
    alone = (last * fall_of_two**2).max(axis=0) * np.abs(weight).sum(axis=1)
    moments_of_births = np.abs(weight @ legendre.legvander(2.0 * basis.nodes - 1.0, SIZE - 1))
    changed = (size[..., -2:] * moments_of_births[:, -2:]).sum(axis=-1).max(axis=0)
    return np.asarray(SAFETY * np.sqrt(alone * changed))
