"""(Q15) in steady sliding: one P_c for all contacts, which diffuses to P_cf and is reset to P_ci.

In steady sliding (Q15) gives Q = S/C with S the survival of P_c, as in (Q11a), so that P Q = P_c/C
and

    - D_X L P_c = (P_ci - P_c)/C,        C = <x>,        F_k/(N_c <k>) = <x²>/(2 C).

P_c is represented by weights of cells between a wall at the lower end of P_cf and one beyond nearly
all weight. Between two resets the net weight y[i] crosses the edge i upwards:

    y[i] = C D_X (up[i] w[i] - down[i] w[i+1]),          w[i] = w_fresh[i] + y[i-1] - y[i].

Errors are series in even powers of the cell width, which extrapolation over halved cells removes.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator
from scipy.linalg import solve_banded
from scipy.optimize import brentq

from origins import Ageing, Contacts, InputError, Thresholds
from origins.laws.diffusion import Diffusion

Array = npt.NDArray[np.float64]

# Cells of the coarsest and of the finest grid, which takes some 20 ms for one solution.
_FEWEST_CELLS, _MOST_CELLS = 1000, 32_000
# Survivals of P_ci or P_cf at which the table of P_c ends, and up to which its cells are nearly
# equal. The end is negligible in <x²> for all laws but tails of low powers.
_TAIL, _BULK = 1e-25, 1e-3
# Relative round-off of C and F_k, and the relative error at which the grid is fine enough.
_ROUND_OFF = 1e-13
_ENOUGH = 1e-11
# Smaller weights of cells are set to 0: the interpolation divides by slopes, and would overflow.
_FAINTEST = 1e-200

# Change of the weights of the two cells beside an edge when weight moves up across it.
_UP = np.array([-1.0, 1.0])


class Steady(NamedTuple):
    """Steady sliding with one P_c for all contacts.

    force, force_error : F_k/(N_c <k>) and its error (lengths)
    length, length_error : C, the mean of P_c, and its error (lengths): contacts break at the rate
        1/C per unit of advance
    thresholds : P_c, from a table of weights
    below : sum of the negative weights of that table, without the sign; the density leaves them out
    """

    force: float
    force_error: float
    length: float
    length_error: float
    thresholds: Thresholds
    below: float


def check_alone(contacts: Contacts) -> None:
    """Raise InputError for laws of a contact that (Q15) does not include."""
    for name in ("thermal", "delay", "reforming"):
        if getattr(contacts, name) is not None:
            raise InputError(
                f"contacts.{name}: (Q15), the paper's closure of ageing, does not have it; leave "
                f'{name} out of the contacts, or use closure = "exact"'
            )


def paper_steady(law: Thresholds, ageing: Ageing, diffusion: float) -> Steady:
    """(Q15), (Q11c), (Q11d): the steady state from fresh thresholds P_ci at D_X (a length), any final law.

    Exact single values are allowed. Raises InputError for fresh thresholds outside the support of
    the final law, and for a final law with a gap that thresholds would have to cross.
    """
    ageing.check_fresh(law)
    grid = _make_grid(law, ageing.final)
    rows: list[list[Array]] = []  # Romberg's table of (F_k, C), lengths
    weights: list[Array] = []
    edges, off = grid(0), np.full(2, np.inf)
    while len(rows) < 4 or ((off > _ENOUGH * rows[-1][-1]).any() and edges.size <= _MOST_CELLS):
        edges = grid(len(rows))
        known, found = _solve(law, ageing.final, diffusion, edges)
        weights = [*weights[-1:], found]
        row = [known]
        for k, coarser in enumerate(rows[-1] if rows else []):
            row.append(row[k] + (row[k] - coarser) / (4.0 ** (k + 1) - 1.0))
        if rows:
            off = np.abs(row[-1] - rows[-1][-1]) + _ROUND_OFF * row[-1]
            # contributions to <x²> and <x> from beyond the table
            off += edges[-1] * ageing.final.sf(edges[-1]) * np.array([edges[-1] / known[1], 1.0])
        rows.append(row)
    force, length = rows[-1][-1].tolist()
    # weights on the coarser of the last two grids, extrapolated from both
    coarse, fine = weights
    better = (4.0 * fine.reshape(-1, 2).sum(axis=1) - coarse) / 3.0
    thresholds = TabulatedLaw(edges[::2], np.maximum(better, 0.0))
    below = abs(float(better[better < 0.0].sum()))
    return Steady(force, float(off[0]), length, float(off[1]), thresholds, below)


def _make_grid(fresh: Thresholds, final: Thresholds) -> Callable[[int], Array]:
    """grid(k): edges of some 1,000 2^k cells, nearly equal over the bulk of both laws and growing
    along a far tail: they are equal in s, where x = lower + bulk sinh(s), so that errors extrapolate.
    There are edges where either law bends, jumps or has an atom."""
    lower, end = final.support()
    upper, bulk = (
        min(end, max(float(fresh.isf(tail)), float(final.isf(tail)))) - lower
        for tail in (_TAIL, _BULK)
    )
    corners = np.concatenate([fresh.breakpoints, fresh.atoms[0], final.breakpoints])
    points = np.unique(np.append(corners[(corners > lower) & (corners < lower + upper)], lower))
    s = np.arcsinh((points - lower) / bulk)
    last = float(np.arcsinh(upper / bulk))
    cell = last / _FEWEST_CELLS
    apart = np.diff(np.append(s, last)) >= cell  # no cells narrower than that
    marks = np.append(s[apart], last)
    exact = np.append(points[apart], lower + upper)
    numbers = np.append(0, np.maximum(np.rint(np.diff(marks) / cell), 1.0).astype(int).cumsum())

    def grid(halvings: int) -> Array:
        place = numbers * 2**halvings
        edges = lower + bulk * np.sinh(np.interp(np.arange(place[-1] + 1), place, marks))
        edges[place] = exact
        return edges

    return grid


def _solve(
    fresh: Thresholds, final: Thresholds, diffusion: float, edges: Array
) -> tuple[Array, Array]:
    """(F_k, C), lengths, and the weights of P_c on given cells; C is the mean of P_c."""
    hops = Diffusion(final, edges)
    born = hops.weights(fresh)
    middle = 0.5 * (edges[1:] + edges[:-1])
    for atom, share in zip(*fresh.atoms, strict=True):
        k = int(np.searchsorted(edges, atom))
        if 0 < k < edges.size - 1 and edges[k] == atom:  # on an edge: two cells, with the same <x>
            born[k - 1 : k + 1] += share * (atom - middle[k - 1]) / np.diff(middle)[k - 1] * _UP
    gained = hops.up * born[:-1] - hops.down * born[1:]

    def crossed(length: float) -> Array:
        """y: the net weight that crosses each inner edge upwards between two resets, `length` apart."""
        amount = diffusion * length
        band = np.zeros((3, gained.size))
        band[0, 1:] = -amount * hops.down[:-1]
        band[1] = 1.0 + amount * (hops.up + hops.down)
        band[2, :-1] = -amount * hops.up[1:]
        return np.asarray(solve_banded((1, 1), band, amount * gained, check_finite=False))

    def mean(length: float) -> float:
        return fresh.mean() + float(crossed(length) @ np.diff(middle))

    low, high = sorted([fresh.mean(), final.mean()])  # C lies between; margins for coarse cells
    length = float(brentq(lambda c: mean(c) - c, 0.5 * low, 2.0 * high, xtol=1e-300, rtol=1e-14))
    upwards = crossed(length)
    square = fresh.moment(2) + float(upwards @ np.diff(middle**2))
    weights = born - np.diff(upwards, prepend=0.0, append=0.0)
    return np.array([0.5 * square / length, length]), weights


class TabulatedLaw(Thresholds):
    """Thresholds known by their weights (n,) >= 0 in cells between edges (n + 1,), lengths: cdf and
    survival are smooth monotone curves through the edges, each summed from its own end."""

    onset_power = 0.0

    def __init__(self, edges: Array, weights: Array) -> None:
        weights = np.where(weights > _FAINTEST, weights, 0.0) / weights.sum()
        self._edges = edges
        self._below = PchipInterpolator(edges, np.append(0.0, np.cumsum(weights)))
        self._above = PchipInterpolator(edges, np.append(np.cumsum(weights[::-1])[::-1], 0.0))
        self._slope = self._below.derivative()

    def support(self) -> tuple[float, float]:
        return float(self._edges[0]), float(self._edges[-1])

    def _pdf(self, x: Array) -> Array:
        return np.maximum(self._slope(x), 0.0)

    def _cdf(self, x: Array) -> Array:
        return np.clip(self._below(x), 0.0, 1.0)

    def _sf(self, x: Array) -> Array:
        return np.clip(self._above(x), 0.0, 1.0)
