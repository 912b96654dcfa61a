"""(Q15): one step of the paper's system of ageing as printed, on cohorts and cells.

    dQ/dX + dQ/dx + P Q = delta(x) b,    b = integral of P Q
    dP_c/dX = D_X L P_c - P Q + P_ci b
    P_c = P exp(-integral of P),         that is P = P_c/S, S the survival of P_c

Contacts are cohorts at (i + 1/2) h, which a step moves across whole cells of P_c. Each step consists
of half a step of ageing, the breaks, with the survival in the middle of the step, and half a step of
ageing. Errors fall as h² as long as mass and sign of P_c are both conserved, and as h after that.
"""

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg.lapack import zgttrf, zgttrs

from master.paper.q15_steady import check_alone
from origins import Ageing, Contacts, InputError, Thresholds
from origins.errors import refuse
from origins.laws.diffusion import Diffusion
from origins.start import Start

Array = npt.NDArray[np.float64]
Keep = Literal["positivity", "mass"]
Ages = Callable[[Array], Array]

# Survival of P_ci or P_cf at which the table of P_c ends; so small a share is negligible.
_TAIL = 1e-13
# A wall of P_cf nearer than this to an edge of cells, in steps, replaces the edge.
_SLIVER = 0.25
# Largest share of contacts, where no thresholds are left, that counts as none.
_STANDING = 1e-14
# Most steps across the table of P_c: more would take hours.
_MOST_STEPS = 20_000
# Largest change of ln P_cf over a cell that the hops between cells resolve; and quantiles of P_ci at
# which it is evaluated.
_CHANGE, _BULK = 2.0, np.array([1e-3, 0.03, 0.5])
_FEWEST_CELLS, _MOST_CELLS = 4, 128  # per step
# Parts of ageing per relaxation time of P_cf, and most parts of one step.
_PARTS, _MOST_PARTS = 8.0, 16


class Defects(NamedTuple):
    """F/(N_c <k>) (a length), mass of P_c minus 1, and negative weight of P_c without its sign."""

    force: float
    mass: float
    below: float


class Q15Stepper:
    """Cohorts of contacts and cells of P_c, one step of X at a time.

    Attributes
    ----------
    step : float
        h, a length.
    edges : array (m + 1,)
        Ends of all cells (lengths).
    walls : array (m / cells + 1,)
        Ends of the groups of cells that cohorts cross in a step (lengths).
    stretches, cohorts : arrays (k,)
        Stretches of the cohorts (lengths), and Q as their shares of the contacts.
    """

    def __init__(
        self,
        contacts: Contacts,
        step: float,
        velocity: float,
        keep: Keep = "positivity",
        cells: int | None = None,
        parts: int | None = None,
    ) -> None:
        ageing, start, fresh = ages(contacts), contacts.start, contacts.thresholds
        cells = enough_cells(contacts, step) if cells is None else cells
        parts = enough_parts(contacts, step, velocity) if parts is None else parts
        amount = ageing.rate / velocity * step
        lower, end = ageing.final.support()
        upper = float(fresh.isf(_TAIL))
        if amount > 0.0:
            upper = min(end, max(upper, float(ageing.final.isf(_TAIL))))
        low, high = min(start.span[0], 0.0), max(upper, start.span[1])
        if (high - low) / step > _MOST_STEPS:
            example = f"write step={(high - low) / 2000.0:.3g} or so"
            refuse("step", step, f"needs more than {_MOST_STEPS:,} cells; {example}")

        self.step, self._keep, self._cells = step, keep, cells
        first, last = int(np.floor(low / step)) - 1, int(np.ceil(high / step)) + 1
        self.stretches: Array = step * (np.arange(first, last, dtype=float) + 0.5)
        self._born = -first  # index of h/2
        ends = np.append(self.stretches - 0.5 * step, self.stretches[-1] + 0.5 * step)
        self.cohorts = np.diff(start.cdf(ends))
        self.cohorts /= self.cohorts.sum()

        inner = self.stretches[self.stretches > lower + _SLIVER * step]
        inner = inner[: int(np.searchsorted(inner, upper)) + 1]
        if inner[-1] > end - _SLIVER * step:  # no cell may lie beyond the wall of P_cf
            inner = np.append(inner[inner < end - _SLIVER * step], end)
        self.walls = np.append(lower, inner)
        place = np.arange(cells * inner.size + 1) / cells
        self.edges = np.interp(place, np.arange(self.walls.size), self.walls)
        group = np.searchsorted(self.walls, self.stretches[:-1] + 0.5 * step, side="right") - 1
        self._group = np.clip(group, 0, inner.size - 1)

        self._fresh = np.diff(fresh.cdf(self.edges))
        self._fresh /= self._fresh.sum()
        self._half: Ages = np.positive  # at D = 0 nothing ages
        self._whole: Ages = np.positive
        if amount > 0.0:
            diffusion = Diffusion(ageing.final, self.edges)
            self._half = make_ageing(diffusion, 0.5 * amount, parts)
            self._whole = make_ageing(diffusion, amount, parts)
        # P_c after a step's breaks, and after the ageing up to the next breaks
        self._broken, self._aged = self._fresh, self._half(self._fresh)

    def weights(self) -> Array:
        """P_c, as weights of the cells (m,)."""
        return self._half(self._broken)

    def histogram(self) -> Array:
        """P_c, as weights between the walls."""
        return np.asarray(self.weights().reshape(-1, self._cells).sum(axis=1))

    def state(self) -> Defects:
        """The force, and the defects of P_c."""
        w = self._broken
        below = abs(float(w[w < 0.0].sum()))
        return Defects(float(self.stretches @ self.cohorts), float(w.sum()) - 1.0, below)

    def advance(self) -> bool:
        """Take one step. With keep = "mass", returns False without a step where contacts have a
        stretch with a survival that is not above 0."""
        begun = middle = self._aged
        for _ in range(2):  # the second time with the survival in the middle of the step
            broken = self._break(begun, middle)
            if broken is None:
                return False
            cohorts, ended = broken
            middle = 0.5 * (begun + ended)
        self.cohorts, self._broken = cohorts, ended
        self._aged = self._whole(ended)
        return True

    def _break(self, begun: Array, middle: Array) -> tuple[Array, Array] | None:
        """Cohorts (k,) and weights (m,) after the breaks of a step, with the survival of `middle`;
        None where `advance` returns False."""
        groups = middle.reshape(-1, self._cells)
        tail = np.append(np.cumsum(groups.sum(axis=1)[::-1])[::-1], 0.0)
        survival = np.interp(self.stretches, self.walls, tail)
        before, after = survival[:-1], survival[1:]
        standing = self.cohorts[:-1]
        dead = before <= 0.0
        if self._keep == "mass" and (dead & (standing > _STANDING)).any():
            return None
        moved = standing * np.where(dead, 0.0, after / np.where(dead, 1.0, before))
        lost = standing - moved
        total = float(lost.sum()) + float(self.cohorts[-1])
        cohorts = np.append(0.0, moved)
        cohorts[self._born] += total
        # contacts born in the step end at h/2 on average: some of them break and are born again
        births = total * float(tail[0] / survival[self._born])
        lost[self._born - 1] += births - total
        # the cells that a cohort crosses lose in proportion to what they hold
        size = np.abs(groups)
        whole = size.sum(axis=1, keepdims=True)
        share = np.where(whole > 0.0, size / np.where(whole > 0.0, whole, 1.0), 1.0 / self._cells)
        by_group = np.asarray(np.bincount(self._group, lost, minlength=tail.size - 1), dtype=float)
        ended = begun - (share * by_group[:, None]).ravel() + births * self._fresh
        return cohorts, np.maximum(ended, 0.0) if self._keep == "positivity" else ended


def make_ageing(diffusion: Diffusion, amount: float, parts: int = 1) -> Ages:
    """(L): the function that ages weights (n,) by `amount` = D t (a length squared), sum kept.

    The exponential of the hops between cells, in `parts` steps each of one tridiagonal solution:
    exp(z) ≈ 1/(1 - z + z²/2) = Re (1 - i)/(1 - (1 + i) z/2), of second order; it damps fast modes
    and makes hardly any weight negative.
    """
    up, down = amount / parts * diffusion.up, amount / parts * diffusion.down
    leaving = np.append(up, 0.0) + np.append(0.0, down)
    pole = 0.5 + 0.5j
    factors = zgttrf(-pole * up, 1.0 + pole * leaving, -pole * down)[:5]

    def age(weights: Array) -> Array:
        for _ in range(parts):
            after = ((1.0 - 1.0j) * zgttrs(*factors, weights.astype(complex))[0]).real
            # restore the sum, which many hops change by rounding
            weights = after + (weights.sum() - after.sum()) * diffusion.stationary
        return weights

    return age


def enough_cells(contacts: Contacts, step: float) -> int:
    """Cells per step, so many that ln P_cf changes little over a cell where fresh thresholds lie."""
    final, fresh = ages(contacts).final, contacts.thresholds
    beside = 1e-4 * float(fresh.std() or fresh.mean())
    x = fresh.ppf(_BULK)
    ends = np.clip(np.stack([x - beside, x + beside]), *final.support())
    slope = np.abs(np.diff(final.logpdf(ends), axis=0) / np.diff(ends, axis=0))
    steepest = float(slope[np.isfinite(slope)].max(initial=0.0))
    return int(np.clip(np.ceil(step * steepest / _CHANGE), _FEWEST_CELLS, _MOST_CELLS))


def enough_parts(contacts: Contacts, step: float, velocity: float) -> int:
    """Parts of a step, so many that thresholds relax little in each."""
    ageing = ages(contacts)
    approach = ageing.rate / velocity * step / ageing.final.std() ** 2
    return int(np.clip(np.ceil(_PARTS * approach), 1, _MOST_PARTS))


def half_width(law: Thresholds | Start) -> float:
    """Half the width of a law's middle two thirds (a length); 0 for a start at one stretch."""
    if isinstance(law, Start) and law.is_single:
        return 0.0
    return 0.5 * float(law.isf(0.16) - law.ppf(0.16))


def ages(contacts: Contacts) -> Ageing:
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
