"""(Q15) in steady sliding: one P_c for all contacts, which diffuses to P_cf and is reset to P_ci.

In steady sliding (Q15) gives Q = S/C with S the survival of P_c, as in (Q11a), so that P Q = P_c/C
and

    - D_X L P_c = (P_ci - P_c)/C,        C = <x>,        F_k/(N_c <k>) = <x²>/(2 C).

P_c is represented by weights of cells between a wall at the lower end of P_cf and one beyond nearly
all weight. Errors are series in even powers of the cell width, which extrapolation over halved cells
removes.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator
from scipy.linalg.lapack import get_lapack_funcs
from scipy.optimize import brentq

from origins import Ageing, Contacts, InputError, Thresholds
from origins.contacts import check_contacts
from origins.laws.diffusion import Diffusion
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

# Cells of the coarsest and of the finest grid, which takes some 20 ms for one solution.
FEWEST_CELLS, MOST_CELLS = 1000, 32_000


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
    check_contacts(contacts, "(Q15), the paper's closure of ageing,", ("ageing",))


def ageing_of(contacts: Contacts) -> Ageing:
    """The ageing of contacts that (Q15) takes, with a start that has a width; else InputError."""
    if contacts.ageing is None:
        raise InputError("contacts.ageing: is None; without ageing use master.solve")
    if contacts.start.is_single:
        raise InputError(
            f"start: all contacts at the one stretch {contacts.start.mean():g}: there (Q15) "
            "multiplies what is infinite by what it empties; use a start with a width, such as "
            'origins.gaussian_start(mean=0.1, std=0.025), or closure = "exact"'
        )
    check_alone(contacts)
    return contacts.ageing


def make_ageing(hops: Diffusion, amount: complex) -> Callable[[Array], Array]:
    """The function that applies (1 - amount L)^-1 to the weights (n,) of cells, with the same sum.

    amount : D t, a length squared. The net weight y[i] that crosses the edge i upwards is solved for:
    y[i] = amount (up[i] w[i] - down[i] w[i+1]) after w[i] has gained y[i-1] - y[i].
    """
    diagonal = 1.0 + amount * (hops.up + hops.down)
    factor, solve = get_lapack_funcs(("gttrf", "gttrs"), (diagonal,))
    factors = factor(-amount * hops.up[1:], diagonal, -amount * hops.down[:-1])[:5]

    def age(weights: Array) -> Array:
        net = amount * (hops.up * weights[:-1] - hops.down * weights[1:])
        return np.asarray(weights - np.diff(solve(*factors, net)[0], prepend=0.0, append=0.0))

    return age


def paper_steady(law: Thresholds, ageing: Ageing, diffusion: float) -> Steady:
    """(Q15), (Q11c), (Q11d): the steady state from fresh thresholds P_ci at D_X (a length), any final law.

    Exact single values are allowed. Raises InputError for fresh thresholds outside the support of
    the final law, and for a final law with a gap that thresholds would have to cross.
    """
    ageing.check_fresh(law)
    grid = _make_grid(law, ageing.final)
    rows: list[list[Array]] = []  # Romberg's table of (F_k, C), lengths
    edges, fine, off = grid(0), np.empty(0), np.full(2, np.inf)
    while len(rows) < 4 or ((off > 1e-11 * rows[-1][-1]).any() and edges.size <= MOST_CELLS):
        edges, coarse = grid(len(rows)), fine
        known, fine = _solve(law, ageing.final, diffusion, edges)
        row = [known]
        for k, coarser in enumerate(rows[-1] if rows else []):
            row.append(row[k] + (row[k] - coarser) / (4.0 ** (k + 1) - 1.0))
        if rows:
            # the round-off; and contributions to <x²> and <x> from beyond the table
            off = np.abs(row[-1] - rows[-1][-1]) + 1e-13 * row[-1]
            off += edges[-1] * ageing.final.sf(edges[-1]) * np.array([edges[-1] / known[1], 1.0])
        rows.append(row)
    force, length = rows[-1][-1].tolist()
    # weights on the coarser of the last two grids, extrapolated from both
    weights = (4.0 * fine.reshape(-1, 2).sum(axis=1) - coarse) / 3.0
    thresholds = TabulatedLaw(edges[::2], np.maximum(weights, 0.0))
    below = abs(float(weights[weights < 0.0].sum()))
    return Steady(force, float(off[0]), length, float(off[1]), thresholds, below)


def _make_grid(fresh: Thresholds, final: Thresholds) -> Callable[[int], Array]:
    """grid(k): edges of some 1,000 2^k cells, nearly equal over the bulk of both laws (to a survival
    of 1e-3) and growing along a far tail (to 1e-25): they are equal in s, where x = lower + bulk
    sinh(s), so that errors extrapolate. There are edges where either law bends, jumps or has an atom."""
    lower, end = final.support()
    upper, high = (min(end, max(float(fresh.isf(q)), float(final.isf(q)))) for q in (1e-25, 1e-3))
    bulk = high - lower
    corners = np.concatenate([fresh.breakpoints, fresh.atoms[0], final.breakpoints, [lower, upper]])
    corners = np.unique(corners[(corners >= lower) & (corners <= upper)])
    s = np.arcsinh((corners - lower) / bulk)
    cell = s[-1] / FEWEST_CELLS
    apart = np.append(np.diff(s) >= cell, True)  # no cells narrower than that
    s, corners = s[apart], corners[apart]
    s[0], corners[0] = 0.0, lower
    numbers = np.append(0, np.maximum(np.rint(np.diff(s) / cell), 1.0).astype(int).cumsum())

    def grid(halvings: int) -> Array:
        place = numbers * 2**halvings
        edges = lower + bulk * np.sinh(np.interp(np.arange(place[-1] + 1), place, s))
        edges[place] = corners
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
            moved = share * (atom - middle[k - 1]) / (middle[k] - middle[k - 1])
            born[k - 1 : k + 1] += moved * np.array([-1.0, 1.0])

    def mean(length: float) -> float:
        aged = make_ageing(hops, diffusion * length)(born)
        return fresh.mean() + float(middle @ (aged - born))

    low, high = sorted([fresh.mean(), final.mean()])  # C lies between; margins for coarse cells
    length = float(brentq(lambda c: mean(c) - c, 0.5 * low, 2.0 * high, xtol=1e-300, rtol=1e-14))
    weights = make_ageing(hops, diffusion * length)(born)
    square = fresh.moment(2) + float(middle**2 @ (weights - born))
    return np.array([0.5 * square / length, length]), weights


class TabulatedLaw(Thresholds):
    """Thresholds known by their weights (n,) >= 0 in cells between edges (n + 1,), lengths: cdf and
    survival are smooth monotone curves through the edges, each summed from its own end."""

    onset_power = 0.0

    def __init__(self, edges: Array, weights: Array) -> None:
        # the interpolation divides by slopes, and would overflow with smaller weights
        weights = np.where(weights > 1e-200, weights, 0.0) / weights.sum()
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

    def _central_moment(self, n: float, centre: float) -> float:
        nodes, weights = gauss(self._edges[:-1], self._edges[1:])
        return float((weights * (nodes - centre) ** n * self._slope(nodes)).sum())
