"""The survival of thresholds as polynomials: a panel of time asks for it at a thousand stretches, several times."""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from master.numerics.table import Table
from master.survival.age.extent import narrowest
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import panel_edges

# Survivals below which no contact holds, to rounding.
NONE = 1e-18
# Error of the polynomials, below the errors of panels of time at all tolerances; their coefficients; the shortest
# piece, in mean thresholds, which only a density that diverges needs.
ACCURACY, SIZE, SHORTEST = 1e-13, 8, 1e-6
# Nodes of an integral over S up to a small stretch.
GAUSS = 8
# Error in units of that above which the law itself is asked; rounding of narrow laws is some times 1e-13.
MISSED = 10.0


class Survival:
    """S(x) of a law of thresholds, and its density.

    law : of thresholds; atoms : its exact values (lengths)
    longest : stretch beyond which no contact holds (a length)
    width : over which S changes (a length)
    """

    def __init__(self, law: Thresholds) -> None:
        """Tabulate it, but with exact values, or where polynomials miss it."""
        self.law, self.atoms = law, law.atoms[0]
        self.longest = max([float(law.isf(NONE)), *self.atoms])
        self._pieces = None if self.atoms.size else _pieces(law, self.longest)

    @cached_property
    def width(self) -> float:
        """See the class."""
        return min(narrowest(self.law), self.law.mean())

    def released(self, reach: float) -> float:
        """The energy per contact, k x_s²/2 over <k> (length squared), of those with thresholds up to this one: by parts
        the integral of x S less x² S/2 at its end."""
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
        x = 0.5 * reach * (1.0 + nodes)
        whole = 0.5 * reach * float(weights @ (x * self.sf(x)))
        return whole - 0.5 * reach**2 * float(self.sf(np.array([reach]))[0])

    def sf(self, x: Array) -> Array:
        """S at stretches from 0 on; as x."""
        return np.asarray(self.law.sf(x)) if self._pieces is None else self._pieces.at(x)[0]

    def sf_and_pdf(self, x: Array) -> tuple[Array, Array]:
        """S and its density; as x."""
        if self._pieces is None:
            return np.asarray(self.law.sf(x)), np.asarray(self.law.pdf(x))
        survival, slope = self._pieces.at(x)
        return survival, -slope


class _Pieces(NamedTuple):
    """A function as polynomials; 0 beyond the end.

    begin, per_width : of the n pieces, and 2/width; end : of the last one
    powers : coefficients of powers of z from -1 to 1 on each, the highest first, shape (SIZE, n)
    """

    begin: Array
    per_width: Array
    powers: Array
    end: float

    def at(self, x: Array) -> tuple[Array, Array]:
        """The function and its slope at x from the first piece's beginning on."""
        piece = self.begin.searchsorted(x, "right") - 1
        per_width, powers = self.per_width[piece], self.powers.take(piece, axis=1)
        z, inside = (x - self.begin[piece]) * per_width - 1.0, x < self.end
        value, slope = powers[0], np.zeros(x.shape)
        for coefficient in powers[1:]:
            slope = slope * z + value
            value = value * z + coefficient
        return value * inside, slope * per_width * inside


def _pieces(law: Thresholds, longest: float) -> _Pieces | None:
    """The survival of a law; None where polynomials miss it, as beside a density that diverges."""
    marks = np.concatenate([[0.0, longest], panel_edges(law), law.breakpoints])
    edges = np.unique(np.clip(marks, 0.0, longest))
    table = Table(lambda x: law.sf(x)[None], edges, ACCURACY, SHORTEST * law.mean(), size=SIZE)
    if table.tails.max() > MISSED * ACCURACY:
        return None
    nodes = np.polynomial.legendre.leggauss(SIZE)[0]
    values = law.sf(table.begin[:, None] + 0.5 * table.widths[:, None] * (1.0 + nodes))
    powers = np.asarray(np.linalg.solve(np.vander(nodes), values.T), dtype=float)
    return _Pieces(table.begin, 2.0 / table.widths, powers, longest)
