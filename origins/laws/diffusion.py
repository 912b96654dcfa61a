"""Diffusion of thresholds towards any law, in finite volumes: positive, mass-conserving, and at rest in that law."""

import numpy as np
import numpy.typing as npt
import scipy

from origins.errors import InputError, finite_array, refuse
from origins.thresholds.law import Array, Thresholds


class Diffusion:
    """∂P/∂t = D ∂_x (Ũ' + ∂_x) P with P_cf ~ exp(-Ũ) (paper, Eq. L), between impermeable walls.

    The weights of P in n cells obey a master equation of hops between neighbours (Scharfetter and Gummel, IEEE Trans.
    Electron Devices 16, 64, 1969): up[i] from cell i to i + 1, down[i] back, both per unit of D, in balance where the
    densities in the cells are as those of P_cf in their middles. Errors fall as the square of the cell width, more
    slowly where P_cf begins as a power. A propagator, such as scipy.linalg.expm or master/steady/q15.py, gives
    the weights after a time.

    final : P_cf.
    edges : rising ends of the cells (lengths), shape (n + 1,); the outermost are the walls, the lower one usually 0.
        Every breakpoint of P_cf should be among them.
    up, down : the rates, shape (n - 1,), per length squared.

    Raises InputError for edges that do not increase or are fewer than three, and for a P_cf without weight in a cell
    or with more than 1e-12 of it beyond the walls.
    """

    def __init__(self, final: Thresholds, edges: npt.ArrayLike) -> None:
        """Make the rates between neighbouring cells, in balance with the final law."""
        self.edges = finite_array("edges", edges)
        widths, middles = np.diff(self.edges), 0.5 * (self.edges[1:] + self.edges[:-1])
        if widths.size < 2 or not (widths > 0.0).all():
            refuse("edges", self.edges, "must be three or more that increase, as np.arange(9.0)")
        self.weights(final, "final")
        log_density = final.logpdf(middles)
        for middle in middles[~np.isfinite(log_density)]:
            hint = "use a law whose density is positive between the outermost edges"
            raise InputError(f"final: has no finite density at {middle:g}; {hint}")
        uphill, distances = -np.diff(log_density), np.diff(middles)
        self.up = 1.0 / (scipy.special.exprel(np.minimum(uphill, 600)) * widths[:-1] * distances)
        self.down = 1.0 / (scipy.special.exprel(np.minimum(-uphill, 600)) * widths[1:] * distances)

    def weights(self, law: Thresholds, name: str = "law") -> Array:
        """Weight of `law` in each cell, shape (n,); InputError, with `name`, for more than 1e-12 beyond the walls."""
        cdf, sf = law.cdf(self.edges), law.sf(self.edges)
        if not (beyond := cdf[0] + sf[-1]) <= 1e-12:
            at = f"beyond the outermost edges, {self.edges[0]:g} and {self.edges[-1]:g}; widen them"
            raise InputError(f"{name}: has a weight of {beyond:.3g} {at}")
        cdf[0] = sf[-1] = 0.0  # the walls hold back what lies beyond
        # from the smaller of cdf and survival, which has more digits
        return np.where(cdf[:-1] < 0.5, np.diff(cdf), -np.diff(sf))
