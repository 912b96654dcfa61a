"""Contacts that all break at one mean rate H(x): the closure "paper" (Eqs. temper3, temper4)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.averages import Integrals, integrals_above
from master.lives.heat.thermal import RESOLVED
from master.lives.life import SMALLEST, LawLife, Moves
from master.renewal.table import Table
from origins import Contacts
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Least H, in attempt frequencies, whose relative error matters: one break in 1e35 attempts.
_NEVER = 1e-35
# Relative last coefficients of H below which panels of its table are not halved.
_ACCURACY = 1e-13
_EPSILON = float(np.finfo(float).eps)
# Rounding of the distance between two lengths, relative to these lengths.
_ROUNDING = 1e-14


class MeanRateLife(LawLife):
    """The Life of contacts with P_T = P + H/v (paper, Eqs. temper2 and temper4).

    H(x), the integral of h(x; x_s) P_c(x_s) over x_s > |x|, is the rate of all contacts, and

        E = product over all ways out of S(|x_end|)/S(|x_begin|) exp(-integral of H over time),

    a way out being one on which |x| grows beyond |r|. As in App. C, a contact that was pulled back and goes out
    again may break at thresholds that it has passed before; on one leg the product is S(|x|)/S(|r|).

    Parameters
    ----------
    contacts : Contacts
        With thermal; independent stiffness.
    resolved : float
        See Life.
    """

    pair_work = 6

    def __init__(self, contacts: Contacts, resolved: float = RESOLVED) -> None:
        """Tabulate the mean rate H and its integral."""
        super().__init__(contacts)
        assert contacts.thermal is not None
        self.resolved, self.birth_reach = resolved, self.reach
        rates = self._rates = contacts.thermal.rates
        edges = np.unique(np.concatenate([[0.0, self.reach], self.bends, self.panels]))
        scale, far = rates.scale, self.reach
        barrier = float(np.log(scale) - rates.log_rate(0.0, far, 1.0))
        # relative rounding of h per k_BT of the barrier, over the accuracy; halving cannot reduce it
        rounding = 16.0 * _EPSILON * max(barrier, 1.0) / _ACCURACY

        def found(x: Array) -> Array:
            return self.mean_rate(x.ravel()).reshape(1, *x.shape)

        def felt(values: Array, widths: Array) -> Array:
            most = np.maximum(np.abs(values[0]).max(axis=1), _NEVER * scale)
            # near a bend panels get narrow and add little to L
            return np.asarray(most / np.minimum(1.0, widths / (1e-3 * far)))

        given = found, edges[edges <= far], _ACCURACY, 1e-13 * far
        table = self._table = Table(*given, size=14, felt=felt, rounding=rounding)
        # the table is checked away from its nodes; an error of H counts by its part of L, the integral
        # of H, and one of ln L changes the survival e^-L by at most 1/e of it
        at = table.begin + 0.02 * table.widths
        wrong = np.abs(self.rate(at) - self.mean_rate(at))
        wrong += [self._above(np.array([x])).missed[0] for x in at]
        grown = np.maximum(self.grown(table.edges[1:]), _NEVER * scale * far)
        self.error = float((np.cumsum(wrong * table.widths) / grown).max(initial=0.0)) / np.e

    def rate(self, x: Array) -> Array:
        """H at x >= 0, from the table; same shape."""
        return np.asarray(self._table(x)[0])

    def grown(self, x: Array) -> Array:
        """L, the integral of H from 0 to x, of either sign; same shape."""
        return np.sign(x) * self._table.before(np.abs(x))

    def mean(self, near: Array, far: Array) -> Array:
        """Mean of H over short ways from near to far on one side of 0, by Simpson's rule; same shape."""
        near, far = np.abs(near), np.abs(far)
        return (self.rate(near) + 4.0 * self.rate(0.5 * (near + far)) + self.rate(far)) / 6.0

    def mean_rate(self, x: Array) -> Array:
        """H at stretches x >= 0, shape (n,), by its definition (paper, Eq. temper3)."""
        out = self._above(x).value[0]
        for position, weight in zip(self.atoms, self.atom_weights, strict=True):
            below = x < position
            out[below] += weight * self._rates.rate(x[below], position, 1.0)
        return out

    def _above(self, x: Array) -> Integrals:
        """h averaged over the thresholds above x, without exact ones; shape (1, n)."""

        def breaking(row: Rows, xi: Array) -> Array:
            return (self._rates.rate(x[row, None], xi, 1.0) * finite_density(self.law, xi))[None]

        # right below an edge the distance of thresholds from x suffers from rounding
        edges = np.append(self.panels, np.inf)
        edge = edges[np.searchsorted(self.panels, x, "right")]
        relative = np.maximum(2e-12, _ROUNDING * x / np.maximum(edge - x, _ROUNDING * x))
        given = breaking, np.maximum(x, SMALLEST), self.panels, True
        about = integrals_above(*given, np.inf).value[0]
        return integrals_above(*given, relative * about)

    def survivors(self, pair: Rows, born: Array, side: Array, moves: Moves) -> Array:
        """See Life."""
        displacement, duration, speeds = moves.legs
        spent, rounded, share = np.zeros(pair.size), np.zeros(pair.size), np.ones(pair.size)
        x, first = born, np.abs(born)  # no threshold lies below |r|
        for leg, speed in enumerate(speeds):
            lasts, before, x = duration[pair, leg], x, born + displacement[pair, leg + 1]
            if speed:
                grown = self.grown(x) / speed
                spent += np.abs(grown - self.grown(before) / speed)
                rounded += _EPSILON * np.abs(grown) * (lasts > 0.0)  # may exceed the difference
            else:
                spent += lasts * self.rate(np.abs(x))
            # a way out through 0 begins at |r|; a way towards 0 has the factor 1
            begin = np.where(before * x < 0.0, first, np.maximum(np.abs(before), first))
            held, whole = (self.held(m, side) for m in (np.maximum(np.abs(x), begin), begin))
            share *= np.divide(held, whole, out=np.zeros_like(whole), where=whole > 0.0)
        share = np.minimum(share, 1.0) * np.exp(-spent)
        self.error = max(self.error, float((share * rounded).max(initial=0.0)))
        return np.stack([share, share * x])
