"""(Q15) in steady sliding: one P_c for all contacts, which diffuses to P_cf and is reset to P_ci.

In steady sliding (Q15) gives Q = S/C with S the survival of P_c, as in (Q11a), so that P Q = P_c/C and

    - D_X L P_c = (P_ci - P_c)/C,        C = <x>,        F_k/(N_c <k>) = <x²>/(2 C).

P_c is represented by weights of cells between a wall at the lower end of P_cf and one beyond nearly all weight.
Errors are series in even powers of the cell width, which extrapolation over halved cells removes.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg.lapack import get_lapack_funcs

from master.survival.age.extent import highest
from origins import Ageing, Contacts, InputError, Thresholds
from origins.contacts import check_contacts
from origins.laws.diffusion import Diffusion
from origins.thresholds.law import Array
from origins.thresholds.scipy_laws import as_thresholds

PRINTED = "(Q15), the paper's closure of ageing,"
# Grids of cells, each halved from the one before; and the cells of the first.
GRIDS, CELLS = 5, 2000
# Survivals to which cells are nearly equal, and to which they go: beyond lie a contact in a thousand, and none.
BULK, FARTHEST = 1e-3, 1e-25
# Most steps of Newton's method for C, each of which squares its error.
MOST_STEPS = 50
# Factor on the largest difference between extrapolations that leave out one of the grids.
SAFETY = 4.0
# Relative rounding of all values, measured by scaling.
ROUNDING = 1e-10


def ageing_of(contacts: Contacts) -> Ageing:
    """The ageing of contacts that (Q15) takes, with a start that has a width; else InputError."""
    if contacts.ageing is None:
        raise InputError("contacts.ageing: is None; without ageing use master.solve")
    if contacts.start.is_single:
        fault = f"all contacts at the one stretch {contacts.start.mean():g}: there (Q15) multiplies"
        hint = 'give it a width, as gaussian_start(mean=0.1, std=0.025), or use closure = "exact"'
        raise InputError(f"start: {fault} what is infinite by what it empties; {hint}")
    check_contacts(contacts, PRINTED, ("ageing",))
    return contacts.ageing


def make_ageing(hops: Diffusion, amount: complex) -> Callable[[Array], Array]:
    """The function that applies (1 - amount L)^-1 to the weights (n,) of cells, with the same sum; amount : D t, a
    length squared. The net weight y[i] that crosses the edge i upwards is solved for: y[i] = amount (up[i] w[i] -
    down[i] w[i+1]) after w[i] has gained y[i-1] - y[i]."""
    diagonal = 1.0 + amount * (hops.up + hops.down)
    factor, solve = get_lapack_funcs(("gttrf", "gttrs"), (diagonal,))
    factors = factor(-amount * hops.up[1:], diagonal, -amount * hops.down[:-1])[:5]

    def age(weights: Array) -> Array:
        net = amount * (hops.up * weights[:-1] - hops.down * weights[1:])
        return np.asarray(weights - np.diff(solve(*factors, net)[0], prepend=0.0, append=0.0))

    return age


def paper_steady(contacts: Contacts, velocity: float) -> dict[str, Any]:
    """(Q15), (Q11c), (Q11d): fields of SteadyState; InputError for fresh thresholds outside the support of the final
    law, and for a final law with a gap that thresholds would have to cross. Exact single values are allowed."""
    from scipy.stats import rv_histogram

    check_contacts(contacts, PRINTED, ("ageing",))
    assert contacts.ageing is not None
    fresh, final = contacts.thresholds, contacts.ageing.final
    contacts.ageing.check_fresh(fresh)
    diffusion = contacts.ageing.rate / velocity
    solved = list[_OnCells]()
    length = final.mean()
    for halvings in range(GRIDS):
        found = _solve(fresh, final, diffusion, _edges(fresh, final, halvings), length)
        # errors fall as the square of the width, so that the next change of C is a quarter of this one
        length = found.length + (0.25 * (found.length - solved[-1].length) if solved else 0.0)
        solved.append(found)
    values = np.array([[one.force, one.length, one.fresh_mean] for one in solved])
    best = _extrapolated(values)
    others = np.array([_extrapolated(values[:-1]), _extrapolated(values[1:])])
    # the mean of the fresh law is known: it shows errors that all extrapolations have alike
    differ = np.abs(best - others).max(axis=0) + abs(best[2] - fresh.mean())
    off = SAFETY * differ + ROUNDING * best
    # what lies beyond the last cell
    end = float(solved[-1].edges[-1])
    off += end * float(final.sf(end)) * np.array([end / best[1], 1.0, 0.0])
    force, length, _ = best.tolist()
    force_error, length_error, _ = (off / fresh.mean()).tolist()
    # weights on the coarser of the last two grids, extrapolated from both
    coarse, fine = solved[-2:]
    weights = (4.0 * fine.weights.reshape(-1, 2).sum(axis=1) - coarse.weights) / 3.0
    counts = np.maximum(weights, 0.0), coarse.edges
    thresholds = as_thresholds(rv_histogram(counts, density=False))
    return {
        "force": force,
        "force_error": force_error,
        "holding": 1.0,
        "thresholds": thresholds,
        "mean_threshold": length,
        "cycle_length": length,
        "cycle_length_error": length_error,
        "_survival_at": lambda x: np.where(x >= 0.0, thresholds.sf(x), 0.0),
        "positivity_defect": abs(float(weights[weights < 0.0].sum())),
    }


def _edges(fresh: Thresholds, final: Thresholds, halvings: int) -> Array:
    """Edges of some CELLS 2^halvings cells, nearly equal over the bulk of both laws and growing along a far tail: they
    are equal in s, where x = lower + bulk sinh(s), so that errors extrapolate. There are edges where either law bends,
    jumps or has an atom."""
    lower, end = final.support()
    high = min(end, max(float(fresh.isf(BULK)), float(final.isf(BULK))))
    upper = min(end, highest(fresh, final, FARTHEST))
    bulk = high - lower
    corners = np.concatenate([fresh.breakpoints, fresh.atoms[0], final.breakpoints, [lower, upper]])
    corners = np.unique(corners.clip(lower, upper))
    s = np.arcsinh((corners - lower) / bulk)
    cell = s[-1] / CELLS
    apart = np.append(np.diff(s) >= cell, True)  # no cells narrower than that
    s = s[apart]
    corners = corners[apart]
    s[0] = 0.0
    corners[0] = lower
    cells = np.maximum(np.rint(np.diff(s) / cell), 1.0).astype(int) * 2**halvings
    place = np.append(0, cells.cumsum())
    edges = lower + bulk * np.sinh(np.interp(np.arange(place[-1] + 1), place, s))
    edges[place] = corners
    return np.asarray(edges)


def _extrapolated(values: Array) -> Array:
    """Romberg's limit of rows whose errors are series in h², h halved from row to row."""
    for order in range(1, len(values)):
        values = values[1:] + np.diff(values, axis=0) / (4.0**order - 1.0)
    return values[0]


class _OnCells(NamedTuple):
    """The steady state on cells between these edges: F_k, C and the mean of the fresh law there (lengths), and the
    weights of P_c."""

    force: float
    length: float
    fresh_mean: float
    weights: Array
    edges: Array


def _solve(
    fresh: Thresholds, final: Thresholds, diffusion: float, edges: Array, length: float
) -> _OnCells:
    """The steady state at D_X (a length). C, of which `length` is a guess, is the mean of P_c; from the final mean
    Newton's method comes to it from one side, as ageing slows down."""
    hops = Diffusion(final, edges)
    born = hops.weights(fresh)
    middle = 0.5 * (edges[1:] + edges[:-1])
    for atom, fraction in zip(*fresh.atoms, strict=True):
        k = int(np.searchsorted(edges, atom))
        if 0 < k < edges.size - 1 and edges[k] == atom:  # on an edge: two cells, with the same <x>
            moved = fraction * (atom - middle[k - 1]) / (middle[k] - middle[k - 1])
            born[k - 1 : k + 1] += moved * np.array([-1.0, 1.0])
    for _ in range(MOST_STEPS):
        age = make_ageing(hops, diffusion * length)
        gained = age(born) - born
        by_length = age(gained) / length  # derivative by C
        change = (fresh.mean() + middle @ gained - length) / (1.0 - middle @ by_length)
        length = float(length + change)
        gained = gained + change * by_length
        if abs(change) <= 1e-8 * length:  # its square is rounding
            break
    else:  # no law is known for which it happens
        raise InputError("ageing: C of (Q15) was not found; use a final law with one peak")
    square = fresh.moment(2) + float(middle**2 @ gained)
    return _OnCells(0.5 * square / length, length, float(middle @ born), born + gained, edges)
