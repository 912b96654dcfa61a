"""Panels in the threshold x_s: those of a law, and those of the sum over one contact's thresholds."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Thresholds
from origins.thresholds.quadrature import finite_density, panel_edges

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Stiffness = Callable[[Array], Array]

# Gauss nodes of a panel, on (0, 1)
_Z, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_X: Array = 0.5 * (_Z + 1.0)
_W: Array = 0.5 * _WEIGHTS

_TAIL = 1e-30  # survival beyond which thresholds are not summed
SMALLEST = 1e-100  # a length: no rate is defined at a threshold of 0


class Panels(NamedTuple):
    """Panels in x_s, each for one contact.

    row : array of int, shape (n,), the contact
    low, high : arrays of shape (n,), the ends
    first, last : arrays of shape (n,), ln A at the ends
    """

    row: Rows
    low: Array
    high: Array
    first: Array
    last: Array


def nodes(law: Thresholds, panels: Panels, base: Array | None) -> tuple[Array, Array]:
    """Thresholds on each panel and their weights by P_c; both of shape (n, 16).

    base : array of shape (n,), where the summand is a series in (x_s - base)^(1/2); else None
    """
    low, width = panels.low[:, None], (panels.high - panels.low)[:, None]
    if base is None:
        xi, weight = low + width * _X, width * _W
    else:
        base = base[:, None]
        near = np.sqrt(low - base)
        across = width / (np.sqrt(low - base + width) + near)  # of the roots, no cancellation
        root = near + across * _X
        xi, weight = base + root * root, 2.0 * across * root * _W
    return xi, weight * finite_density(law, xi)


def law_edges(law: Thresholds) -> Array:
    """Edges of panels on which 16 nodes sum P_c and x_s P_c; none where there are only atoms."""
    if float(law.atoms[1].sum()) > 1.0 - 1e-14:
        return np.empty(0)
    return np.maximum(panel_edges(law, tail=_TAIL), SMALLEST)
