"""Contacts that break only at their thresholds (T = 0): E = S(m)/S(|r|), m the largest |x| so far."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.life import NONE_LEFT, TIE, LawLife, Moves
from master.renewal.table import Table
from origins import Contacts, InputError

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Thresholds below this many mean thresholds underflow in sums.
LOWEST = 1e-290


class ColdLife(LawLife):
    """The life of contacts without heat and without ageing (paper, Eq. Nik04); a Life."""

    quick = timeless = True

    def __init__(self, contacts: Contacts) -> None:
        """Find where the survival bends; InputError where P_c has weight too near to 0."""
        law, self._mean = contacts.thresholds, contacts.mean_threshold
        beneath = float(law.cdf(LOWEST * self._mean))
        if beneath > 1e-12:
            raise InputError(
                f"thresholds: a weight of {beneath:.2g} lies below {LOWEST:g} of the mean, where floating "
                "point ends; leave such contacts out and count them apart"
            )
        super().__init__(contacts)
        self.grain *= 0.5  # these panels are those of the survival, with 12 nodes
        # a narrow law breaks only between `quiet` and `reach`
        lowest = float(law.support()[0])
        self.quiet = min([lowest or float(law.ppf(NONE_LEFT)), *self.atoms])
        ends = [0.0, self.quiet, self.reach]
        edges = np.unique(np.concatenate([ends, self.bends, self.panels]))
        self.marks = edges[edges <= self.reach]
        # where a start reaches into a heavy tail, the few contacts beyond may carry much force
        self.birth_reach = self.reach if self.reach == law.support()[1] else np.inf
        self._linked: Table | None = None
        if contacts.stiffness == "linked":
            shortest = 1e-9 * self._mean
            self._linked = Table(lambda x: self._smooth(x)[None], self.marks, 1e-12, shortest)

    def _smooth(self, m: Array) -> Array:
        """Survival at m without the exact thresholds."""
        out = np.asarray(self.law.sf(m), dtype=float)
        for position, weight in zip(self.atoms, self.atom_weights, strict=True):
            out = out - weight * (m < position)
        return np.maximum(out, 0.0)

    def _borne(self, m: Array, side: Array, held: Array) -> Array:
        """Survivors weighted by their stiffness k_i/<k>: <x_s; x_s > m>/<x_s> where it is linked."""
        if not self._linked:
            return held
        smooth = self._smooth(m)
        # thresholds lie below `reach`: in the far tail this bound is more accurate than the table
        most = np.maximum(self.reach - m, 0.0) * smooth
        out = m * smooth + np.clip(self._linked.beyond(np.minimum(m, self.reach)), 0.0, most)
        for position, weight in zip(self.atoms, self.atom_weights, strict=True):
            out = out + position * weight * (side < position * (1.0 - TIE))
        return np.asarray(out / self._mean)

    def survivors(self, pair: Rows, born: Array, side: Array, moves: Moves) -> Array:
        """See Life."""
        first, m = np.abs(born), moves.largest(pair, born)
        whole, held = self.held(first, first), np.ones(m.shape)
        # contacts with m <= quiet all hold: the law need not be evaluated there
        some = m > self.quiet * (1.0 - 2.0 * TIE)
        held[some] = self.held(m[some], side[some])
        out = np.stack([held, self._borne(m, side, held) * (born + moves.now[pair])])
        return np.divide(out, whole, out=np.zeros_like(out), where=whole > 0.0)
