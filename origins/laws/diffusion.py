"""Diffusion of thresholds towards any law, in finite volumes: positive, mass-conserving, and at rest in that law."""

import numpy as np
import numpy.typing as npt
from scipy.special import exprel, logsumexp

from origins.errors import InputError, finite_array, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import gauss


class Diffusion:
    """∂P/∂t = D ∂_x (Ũ' + ∂_x) P with P_cf ~ exp(-Ũ) (paper, Eq. L), between impermeable walls.

    The weights of P in n cells obey a master equation of hops between neighbours (Scharfetter and Gummel, IEEE Trans.
    Electron Devices 16, 64, 1969): up[i] from cell i to i + 1, down[i] back, both per unit of D. Their ratio is that
    of the densities of P_cf, averaged over the cells, so the weights of P_cf are stationary at any resolution. Errors
    fall as the square of the cell width. A propagator, such as scipy.linalg.expm or master/paper/q15_steady.py,
    gives the weights after a time.

    Parameters
    ----------
    final : Thresholds
        P_cf.
    edges : array of shape (n + 1,)
        Ends of the cells, increasing (lengths); the outermost are the walls, the lower one usually 0. Every
        breakpoint of P_cf should be among them.

    Attributes
    ----------
    edges : array (n + 1,)
    stationary : array (n,), weights of P_cf between the walls, adding up to 1
    up, down : arrays (n - 1,), per length squared

    Raises InputError for edges that do not increase or are fewer than three, and for a P_cf without weight in a cell
    or with more than 1e-12 of it beyond the walls.
    """

    def __init__(self, final: Thresholds, edges: npt.ArrayLike) -> None:
        """Make the rates between neighbouring cells, in balance with the final law."""
        self.edges = finite_array("edges", edges)
        if self.edges.size < 3 or not (np.diff(self.edges) > 0.0).all():
            rule = "must be at least three and increase, such as np.linspace(0.0, 2.0, 401)"
            refuse("edges", self.edges, rule)
        known = self.weights(final, "final")
        # smaller weights are summed from the log-density, which neither underflows nor knows of walls
        faint = ~(known > 1e-11)
        nodes, factors = gauss(self.edges[:-1][faint], self.edges[1:][faint])
        with np.errstate(divide="ignore", invalid="ignore"):
            log_weights = np.log(known)
            log_weights[faint] = logsumexp(final.logpdf(nodes), axis=-1, b=factors)
        empty = np.flatnonzero(~np.isfinite(log_weights))
        if empty.size:
            low, high = self.edges[empty[0]], self.edges[empty[0] + 1]
            raise InputError(
                f"final: has no weight, or one that is no number, between {low:g} and {high:g}: thresholds cannot "
                "diffuse there; use a law whose density is positive between the outermost edges"
            )
        weights = np.exp(log_weights - log_weights.max())
        self.stationary = weights / weights.sum()
        widths, distances = np.diff(self.edges), 0.5 * (self.edges[2:] - self.edges[:-2])
        uphill = -np.diff(log_weights - np.log(widths))
        self.up = 1.0 / (exprel(uphill) * widths[:-1] * distances)
        self.down = 1.0 / (exprel(-uphill) * widths[1:] * distances)

    def weights(self, law: Thresholds, name: str = "law") -> Array:
        """Weight of `law` in each cell, shape (n,), with what lies beyond the walls it adds up to 1.

        InputError, with `name`, where more than 1e-12 of it does.
        """
        cdf, sf = law.cdf(self.edges), law.sf(self.edges)
        if not cdf[0] + sf[-1] <= 1e-12:
            ends = f"{self.edges[0]:g} and {self.edges[-1]:g}; widen them"
            fault = f"has a weight of {cdf[0] + sf[-1]:.3g} beyond the outermost edges"
            raise InputError(f"{name}: {fault}, {ends}")
        cdf[0] = sf[-1] = 0.0  # the walls hold back what lies beyond
        # from the smaller of cdf and survival, which has more digits
        return np.where(cdf[:-1] < 0.5, np.diff(cdf), -np.diff(sf))
