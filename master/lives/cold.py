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

    def _held(self, m: Array, side: Array) -> Array:
        """Survival at m, and with linked stiffness also <x_s; x_s > m>/<x_s>; shape (1 or 2, n).

        Exact thresholds below `side` are broken.
        """
        # contacts with m <= quiet all hold: the law need not be evaluated there
        some, smooth = m > self.quiet, np.ones(m.shape)
        if self.atoms.size or self._linked:
            some = np.ones(m.shape, dtype=bool)
        smooth[some] = self._smooth(m[some])
        out = smooth[None]
        if self._linked:
            # thresholds lie below `reach`: in the far tail this bound is more accurate than the table
            most = np.maximum(self.reach - m, 0.0) * smooth
            beyond = np.clip(self._linked.beyond(np.minimum(m, self.reach)), 0.0, most)
            out = np.stack([smooth, (m * smooth + beyond) / self._mean])
        for position, weight in zip(self.atoms, self.atom_weights, strict=True):
            stiff = np.array([1.0, position / self._mean])[: out.shape[0], None]
            out = out + stiff * weight * (side < position * (1.0 - TIE))
        return out

    def survivors(self, pair: Rows, born: Array, side: Array, moves: Moves) -> Array:
        """See Life."""
        first = np.abs(born)
        whole = self._held(first, first)[0]
        held = self._held(moves.largest(pair, born), side)
        held = np.divide(held, whole, out=np.zeros_like(held), where=whole > 0.0)
        return np.stack([held[0], held[-1] * (born + moves.now[pair])])
