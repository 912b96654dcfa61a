"""Contacts that break only at their thresholds (T = 0): E = S(m)/S(|r|), m the largest |x| so far."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.averages import Moves, averaged
from master.lives.life import Life
from master.motion.motion import History
from master.renewal.table import Table
from origins import Contacts, InputError
from origins.start import Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Survivals below this count as 0, and those within it of 1 as 1: a hundredth of the rounding of the
# sums that contain them.
NONE_LEFT = 1e-18
# Thresholds below this many mean thresholds underflow in sums.
LOWEST = 1e-290
# An exact threshold within this relative distance above |x| counts as met: a turning point placed
# exactly at it may be off by rounding.
TIE = 1e-12
# Factor on the largest measured error of an average over stretches, as only some errors are measured.
MARGIN = 2.0
# Last coefficients below which pieces of the stretches are not halved: near a cusp of S(|r|) the error
# of the sums is a twentieth of it; a larger error could appear as a slip of a soft slider.
RESOLVED = 1e-12


class ColdLife(Life):
    """The life of contacts without heat and without ageing (paper, Eq. Nik04); a Life.

    `grain` is the length over which the survival has to be resolved: the mean width, weighted by
    the contacts that break there, of the panels on which a polynomial follows it.
    """

    quick = timeless = True

    def __init__(self, contacts: Contacts) -> None:
        """Find where the survival bends; InputError where P_c has weight too near to 0."""
        law = contacts.thresholds
        self._law, self._mean = law, contacts.mean_threshold
        self._linked = contacts.stiffness == "linked"
        self.atoms: Array = law.atoms[0]
        self._weights = law.atoms[1]
        upper = law.support()[1]
        beneath = float(law.cdf(LOWEST * self._mean))
        if beneath > 1e-12:
            raise InputError(
                f"thresholds: a weight of {beneath:.2g} lies below {LOWEST:g} of the mean, where floating "
                "point ends; leave such contacts out and count them apart"
            )
        # a contact born in the far tail has a threshold even farther out
        births = [contacts.start] + ([contacts.reforming.law] if contacts.reforming else [])
        furthest = max(abs(end) for born in births for end in born.span)
        least = max(float(law.sf(furthest)), 1e-280)
        self.reach = min(float(upper), float(law.isf(NONE_LEFT * least)))
        if self.atoms.size:
            self.reach = max(self.reach, float(self.atoms.max()))
        marks = np.concatenate([law.breakpoints, self.atoms])
        self.bends: Array = np.unique(marks[(marks > 0.0) & (marks <= self.reach)])
        self.quiet = self._quiet()
        # an irrational edge, so that halving does not hit undeclared corners by chance
        odd = self.reach * (0.5 * 5.0**0.5 - 0.5)
        # a narrow law breaks only between `quiet` and `reach`, and nodes of wider panels would miss it
        self._end = self.reach
        edges = np.unique(np.concatenate([[0.0, self.quiet, odd, self.reach], self.bends]))
        # in a heavy tail all nodes could lie beyond most thresholds
        far = law.isf(np.array([1e-2, 1e-4, 1e-7, 1e-10, 1e-13]))
        if self.reach > 20.0 * float(far[0]):
            edges = np.union1d(edges, far[(far > 0.0) & (far < self.reach)])
            self._end = float(upper)  # the few contacts that hold beyond may carry much force
        shortest = 1e-9 * self._mean
        self._table = Table(lambda x: self._smooth(x)[None], edges, 1e-12, shortest)
        self.marks = np.union1d(self.bends, self._table.edges)
        lost = -np.diff(self._smooth(self._table.edges))
        weight = lost.sum()
        self.grain = float(self._table.widths @ lost / weight) if weight > 0.0 else self.reach

    def atom_share(self, atom: float, stretch: float) -> float:
        """See Life."""
        whole = np.array([abs(stretch)])
        return float(self._weights[self.atoms == atom].sum() / self._held(whole, whole)[0])

    def _quiet(self) -> float:
        """The largest |x| up to which no contact breaks."""
        low = float(self._law.ppf(NONE_LEFT)) if self._law.support()[0] == 0.0 else 0.0
        low = max(low, float(self._law.support()[0]))
        return min([low, *self.atoms])

    def _smooth(self, m: Array) -> Array:
        """Survival at m without the exact thresholds."""
        out = np.asarray(self._law.sf(m), dtype=float)
        for position, weight in zip(self.atoms, self._weights, strict=True):
            out = out - weight * (m < position)
        return np.maximum(out, 0.0)

    def _held(self, m: Array, side: Array) -> Array:
        """Survival at m; exact thresholds below `side` are broken."""
        if not self.atoms.size:
            # contacts with m <= quiet all hold: the law need not be evaluated there
            some, out = m > self.quiet, np.ones(m.shape)
            out[some] = self._law.sf(m[some])
            return out
        out = self._smooth(m)
        for position, weight in zip(self.atoms, self._weights, strict=True):
            out = out + weight * (side < position * (1.0 - TIE))
        return out

    def _borne(self, m: Array, side: Array, held: Array) -> Array:
        """Survivors weighted by their stiffness k_i/<k>: <x_s; x_s > m>/<x_s> where it is linked."""
        if not self._linked:
            return held
        smooth = self._smooth(m)
        # thresholds lie below `reach`: in the far tail this bound is more accurate than the table
        most = np.maximum(self.reach - m, 0.0) * smooth
        out = m * smooth + np.clip(self._table.beyond(np.minimum(m, self.reach)), 0.0, most)
        for position, weight in zip(self.atoms, self._weights, strict=True):
            out = out + position * weight * (side < position * (1.0 - TIE))
        return np.asarray(out / self._mean)

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life."""
        if not isinstance(born, Start) or born.is_single:
            r = np.array([[born.mean()]]) if isinstance(born, Start) else born
            m = np.maximum(np.abs(r), np.maximum(r + history.high, -(r + history.low)))
            return self._left(r, m, r + history.now)
        moves = Moves.of(history)

        def inside(pair: Rows, r: Array) -> Array:
            return self._left(r, moves.largest(pair, r), r + moves.now[pair, None])

        pieces = int(np.clip((born.span[1] - born.span[0]) / (4.0 * self.grain), 8, 64))
        # without a cusp, as at S(|r|) = 1, the error of the sums is the square of the coefficients
        cusp = float(self._law.cdf(max(-born.span[0], born.span[1]))) > NONE_LEFT
        resolved = RESOLVED if cusp else 1e-8
        found = averaged(born, moves, self._end, self.bends, inside, resolved, pieces)
        self.error = max(self.error, MARGIN * float(found.missed[0]))
        return found.value.reshape(2, *history.now.shape)

    def _left(self, r: Array, m: Array, x: Array) -> Array:
        """Share and force of contacts born at r, with the largest |x| so far, m, and the stretch x."""
        share = self._held(np.abs(r), np.abs(r[:, r.shape[1] // 2, None]))
        share = np.divide(1.0, share, out=np.zeros_like(share), where=share > 0.0)
        side = m[:, m.shape[1] // 2, None]
        held = share * self._held(m, side)
        borne = held if not self._linked else share * self._borne(m, side, held)
        return np.stack([held, x * borne])
