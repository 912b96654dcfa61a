"""Sums over the possible thresholds of a contact: those above the largest |x| of its life."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.lives.averages import Integrals, Pieces, integrals
from master.lives.heat.replay import Replay, Stiffness
from origins.laws.rate_law import RateLaw
from origins.thresholds.law import Thresholds
from origins.thresholds.quadrature import finite_density, gauss, panel_edges

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

Mask = npt.NDArray[np.bool_]
# Summands of contacts (n,) at thresholds (n, k) with the densities P_c there; (functions, n, k)
Summed = Callable[[Rows, Array, Array], Array]

# Last coefficients below which pieces are not halved; the error of sums is about their square. With a
# larger value, tables of these sums would be refined to resolve that error.
_RESOLVED = 2e-12
# Rounding of the distance between two lengths, relative to these lengths.
_ROUNDING = 1e-14
# Above ln A = _GONE a share e^-A is negligible, even where few contacts hold, and above _DEAD it is
# taken as 0. Panels with a share of contacts below _NO_WEIGHT are left out.
_GONE, _DEAD, _NO_WEIGHT = np.log(67.0), 7.0, 1e-18
SMALLEST = 1e-100  # a length: no rate is defined at a threshold of 0


def law_edges(law: Thresholds) -> Array:
    """Edges of panels on which 16 nodes sum P_c and x_s P_c; none where there are only atoms."""
    if float(law.atoms[1].sum()) > 1.0 - 1e-14:
        return np.empty(0)
    return np.maximum(panel_edges(law, tail=1e-30), SMALLEST)


class Above:
    """Sums over the thresholds x_s above m, for many contacts at once: of P_c e^-A, and of P_c h.

    The continuous part of P_c is summed on the law's own panels, which are halved. Where the rate
    vanishes at the threshold, A is a series in (x_s - m)^(1/2), which is then the variable of
    integration.

    Parameters
    ----------
    law : Thresholds
    rates : RateLaw
    stiffness : callable
        k_i/<k> at thresholds; None where it is 1 for all.

    Attributes
    ----------
    missed : float
        The largest error of the sums, as measured so far on some of the contacts.
    """

    def __init__(self, law: Thresholds, rates: RateLaw, stiffness: Stiffness | None) -> None:
        self.law, self.rates, self._stiffness = law, rates, stiffness
        self.missed, self._rooted = 0.0, rates.vanishes_at_threshold
        self.edges: Array = law_edges(law)
        xi, weight = gauss(self.edges[:-1], self.edges[1:])
        self._mass = (weight * finite_density(law, xi)).sum(axis=-1)

    def _weighed(self, xi: Array, weight: Array) -> Array:
        """Weights, and these times the relative stiffness at thresholds; shape (2, *xi.shape)."""
        return np.stack(
            [weight, weight if self._stiffness is None else weight * self._stiffness(xi)]
        )

    def sums(self, replay: Replay, share: Array) -> Array:
        """Share of contacts that hold, and its sum weighted by k_i/<k>; shape (2, n). Without atoms.

        share : array of shape (n,), the factor on P_c: 1 over the survival at birth
        """
        if not self.edges.size:
            return np.zeros((2, share.size))
        least = np.maximum(replay.furthest, SMALLEST)
        ends = np.maximum(self.edges, least[:, None])
        level = replay.log_spent(np.arange(least.size), ends)
        felt = self._mass * share[:, None] > _NO_WEIGHT
        # as a function of the threshold A rises, then falls, so that on a panel it is least at an end
        felt &= np.minimum(level[:, 1:], level[:, :-1]) < _GONE

        def held(contact: Rows, xi: Array, weight: Array) -> Array:
            spent = np.exp(np.minimum(replay.log_spent(contact, xi), _DEAD))
            return self._weighed(xi, weight * share[contact, None] * np.exp(-spent))

        found = self._over(least, felt, held, _RESOLVED)
        self.missed = max(self.missed, float(found.missed.max()))
        return found.value

    def mean_rate(self, x: Array) -> Integrals:
        """H at x >= 0, per time: h averaged over the thresholds above (paper, Eq. temper3).

        Returns it as shape (1, n), with the largest relative error; independent stiffness.
        """
        if not self.edges.size:
            nothing = Pieces(np.zeros(0, dtype=int), np.empty(0), np.empty(0))
            return Integrals(np.zeros((1, x.size)), np.zeros(1), nothing)

        def breaking(row: Rows, xi: Array, weight: Array) -> Array:
            return (weight * self.rates.rate(x[row, None], xi, 1.0))[None]

        everywhere = np.ones((x.size, self.edges.size - 1), dtype=bool)
        # right below an edge the distance of thresholds from x suffers from rounding
        edge = self.edges[np.minimum(np.searchsorted(self.edges, x, "right"), self.edges.size - 1)]
        rounding = _ROUNDING * x / np.maximum(edge - x, _ROUNDING * edge)
        accuracy = np.maximum(_RESOLVED, rounding)
        return self._over(np.maximum(x, SMALLEST), everywhere, breaking, accuracy, True)

    def _over(
        self,
        least: Array,
        panels: Mask,
        summed: Summed,
        accuracy: Array | float,
        relative: bool = False,
    ) -> Integrals:
        """Integrals over the thresholds above `least` (n,) on some of the panels, a row for each."""
        ends = np.maximum(self.edges, least[:, None])
        row, col = np.nonzero(panels & (ends[:, 1:] > ends[:, :-1]))
        low, high = ends[row, col], ends[row, col + 1]
        if self._rooted:
            low, high = np.sqrt(low - least[row]), np.sqrt(high - least[row])

        def integrand(row: Rows, at: Array) -> Array:
            xi = least[row, None] + at * at if self._rooted else at
            values = summed(row, xi, finite_density(self.law, xi))
            if not self._rooted:
                return np.concatenate([values[:1], values])
            # the first row only decides on halving and is dropped below: the weight 2 at is 0 at `least`
            whole = 2.0 * at.max(axis=1, keepdims=True)
            return np.concatenate([whole * values[:1], 2.0 * at * values])

        pieces = Pieces(row, low, high)
        found = integrals(integrand, pieces, least.size, accuracy, relative)
        return found._replace(value=found.value[1:], missed=found.missed[1:])
