"""(Q15): one step of the paper's system of ageing as printed, on cohorts and cells.

dQ/dX + dQ/dx + P Q = delta(x) b,    b = integral of P Q
dP_c/dX = D_X L P_c - P Q + P_ci b
P_c = P exp(-integral of P),         that is P = P_c/S, S the survival of P_c
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

# Survival of P_ci or P_cf at which the table of P_c ends; so small a share is negligible.
_TAIL = 1e-13
# A wall of P_cf nearer than this to an edge of cells, in steps, replaces the edge.
_SLIVER = 0.25
# Most steps across the table of P_c: more would take hours.
_MOST_STEPS = 20_000


class State(NamedTuple):
    """F/(N_c <k>) (a length), mass of P_c minus 1, and negative weight of P_c without its sign."""

    force: float
    mass: float
    below: float


class Q15Stepper:
    """Cohorts of contacts and cells of P_c, one step of X at a time.

    Contacts are cohorts at (i + 1/2) h, which a step moves across whole groups of cells of P_c. Each
    step consists of half a step of ageing, the breaks, with the survival in the middle of the step,
    and half a step of ageing. Errors fall as h² as long as mass and sign of P_c are both conserved,
    and as h after that. For the parameters see `paper_transient`.

    Attributes
    ----------
    walls : array (m + 1,)
        Ends of the groups of cells that cohorts cross in a step (lengths).
    """

    def __init__(
        self,
        contacts: Contacts,
        step: float,
        velocity: float,
        keep: Keep = "positivity",
        cells: int | None = None,
        parts: int = 1,
    ) -> None:
        """Choose the cells of thresholds and factorise the diffusion of one step."""
        ageing, start, fresh = ages(contacts), contacts.start, contacts.thresholds
        cells = enough_cells(contacts, step) if cells is None else cells
        amount = ageing.rate / velocity * step
        lower, end = ageing.final.support()
        upper = float(fresh.isf(_TAIL))
        if amount > 0.0:
            upper = min(end, max(upper, float(ageing.final.isf(_TAIL))))
        low, high = min(start.span[0], 0.0), max(upper, start.span[1])
        if (high - low) / step > _MOST_STEPS:
            example = f"write step={(high - low) / 2000.0:.3g} or so"
            refuse("step", step, f"needs more than {_MOST_STEPS:,} cells; {example}")

        self._keep, self._cells = keep, cells
        first, last = int(np.floor(low / step)) - 1, int(np.ceil(high / step)) + 1
        ends: Array = step * np.arange(first, last + 1, dtype=float)
        self._stretches = ends[:-1] + 0.5 * step
        self._born = -first  # index of h/2
        self._cohorts = np.diff(start.cdf(ends))
        self._cohorts /= self._cohorts.sum()

        inner = self._stretches[self._stretches > lower + _SLIVER * step]
        inner = inner[: int(np.searchsorted(inner, upper)) + 1]
        if inner[-1] > end - _SLIVER * step:  # no cell may lie beyond the wall of P_cf
            inner = np.append(inner[inner < end - _SLIVER * step], end)
        self.walls = np.append(lower, inner)
        place = np.arange(cells * inner.size + 1) / cells
        edges = np.interp(place, np.arange(self.walls.size), self.walls)
        group = np.searchsorted(self.walls, ends[1:-1], side="right") - 1
        self._group = np.clip(group, 0, inner.size - 1)

        self._fresh = np.diff(fresh.cdf(edges))
        self._fresh /= self._fresh.sum()
        self._half: Callable[[Array], Array] = np.positive  # at D = 0 nothing ages
        self._whole: Callable[[Array], Array] = np.positive
        if amount > 0.0:
            diffusion = Diffusion(ageing.final, edges)
            self._half = make_ageing(diffusion, 0.5 * amount, parts)
            self._whole = make_ageing(diffusion, amount, parts)
        # P_c after a step's breaks, and after the ageing up to the next breaks
        self._broken, self._aged = self._fresh, self._half(self._fresh)

    def histogram(self) -> Array:
        """P_c, as weights between the walls."""
        return np.asarray(self._half(self._broken).reshape(-1, self._cells).sum(axis=1))

    def state(self) -> State:
        """The force, and the defects of P_c."""
        w = self._broken
        below = abs(float(w[w < 0.0].sum()))
        return State(float(self._stretches @ self._cohorts), float(w.sum()) - 1.0, below)

    def advance(self) -> bool:
        """Take one step. With keep = "mass", returns False without a step where contacts have a
        stretch with a survival that is not above 0."""
        begun = middle = self._aged
        for _ in range(2):  # the second time with the survival in the middle of the step
            tail = np.append(middle[::-1].cumsum()[:: -self._cells], 0.0)
            survival = np.interp(self._stretches, self.walls, tail)
            standing, dead = self._cohorts[:-1], survival[:-1] <= 0.0
            # a share of 1e-14, where no thresholds are left, counts as none
            if self._keep == "mass" and (dead & (standing > 1e-14)).any():
                return False
            kept = np.divide(survival[1:], survival[:-1], out=np.zeros(dead.size), where=~dead)
            lost = standing * (1.0 - kept)
            total = float(lost.sum()) + float(self._cohorts[-1])
            cohorts = np.append(0.0, standing * kept)
            cohorts[self._born] += total
            # contacts born in the step end at h/2 on average: some of them break and are born again
            births = total * float(tail[0] / survival[self._born])
            lost[self._born - 1] += births - total
            # the cells that a cohort crosses lose in proportion to what they hold
            size = np.abs(middle.reshape(-1, self._cells))
            whole = size.sum(axis=1, keepdims=True)
            share = np.divide(
                size, whole, out=np.full_like(size, 1.0 / self._cells), where=whole > 0.0
            )
            by_group = np.bincount(self._group, lost, minlength=whole.size)
            ended = begun - (share * by_group[:, None]).ravel() + births * self._fresh
            ended = np.maximum(ended, 0.0) if self._keep == "positivity" else ended
            middle = 0.5 * (begun + ended)
        self._cohorts, self._broken, self._aged = cohorts, ended, self._whole(ended)
        return True


def make_ageing(diffusion: Diffusion, amount: float, parts: int) -> Callable[[Array], Array]:
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
    """Cells per step, so many that ln P_cf changes by at most 2 over a cell where fresh thresholds lie."""
    final, fresh = ages(contacts).final, contacts.thresholds
    beside = 1e-4 * float(fresh.std() or fresh.mean())
    x = fresh.ppf(np.array([1e-3, 0.03, 0.5]))
    ends = np.clip(np.stack([x - beside, x + beside]), *final.support())
    slope = np.abs(np.diff(final.logpdf(ends), axis=0) / np.diff(ends, axis=0))
    steepest = float(slope[np.isfinite(slope)].max(initial=0.0))
    return int(np.clip(np.ceil(0.5 * step * steepest), 4, 128))


def enough_parts(contacts: Contacts, step: float, velocity: float) -> int:
    """Parts of a step, so many that thresholds relax by at most an eighth in each, but at most 16."""
    ageing = ages(contacts)
    return int(np.clip(8.0 * ageing.rate / velocity * step / ageing.final.std() ** 2, 0, 15)) + 1


def narrowest(*laws: Thresholds | Start) -> float:
    """The narrowest half width (a length) of the laws' middle two thirds; single values do not count."""
    spread = [law for law in laws if not (isinstance(law, Start) and law.is_single)]
    widths = [0.5 * float(law.isf(0.16) - law.ppf(0.16)) for law in spread]
    return min(width for width in widths if width > 0.0)


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
