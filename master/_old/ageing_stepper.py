"""One step of (Q15) as printed: cohorts of contacts, and P_c on cells; see ageing_transient.

Contacts are cohorts at (i + 1/2) h, which the stretch moves from edge to edge of the cells that hold P_c. Each step is
half a step of ageing, the breaks with the survival of the middle of the step, and half a step of ageing: errors fall as
h² while mass and sign of P_c are both kept, and as h from where they are not.
"""

from collections.abc import Callable
from typing import Literal

import numpy as np
import numpy.typing as npt

from master._old.ageing_paper import AgeingSteadyState, check_alone
from master._old.ageing_propagator import AgeingPropagator
from origins import Contacts, InputError
from origins.diffusion import Diffusion
from origins.errors import refuse

Array = npt.NDArray[np.float64]
Keep = Literal["positivity", "mass"]

_BULK = np.array([1e-3, 0.03, 0.5])
_CHANGE = 2.0
_FEWEST_CELLS, _MOST_CELLS_EACH = 4, 128
_PARTS, _MOST_PARTS = 8.0, 16
_FAR = 1e-13
_SLIVER = 0.25  # of a cell: a wall closer than this to an edge takes its place
_STANDING = 1e-14
_MOST_CELLS = 20_000


class PaperStepper:
    """Cohorts of contacts and cells of P_c, one step of X at a time.

    Attributes
    ----------
    step : float
    edges : array (m + 1,), of all cells
    walls : array (m / cells + 1,), those on which cohorts stand
    stretches, cohorts : arrays (k,)
    """

    def __init__(
        self, contacts: Contacts, step: float, velocity: float, keep: Keep, cells: int, parts: int = 1
    ) -> None:
        ageing = contacts.ageing
        assert ageing is not None
        fresh, final, start = contacts.thresholds, ageing.final, contacts.start
        self.step, self._keep = step, keep
        lower, end = final.support()
        amount = ageing.rate / velocity * step
        upper = float(fresh.isf(_FAR))
        if amount > 0.0:
            upper = min(end, max(upper, float(final.isf(_FAR))))
        low, high = min(start.span[0], 0.0), max(upper, start.span[1])
        if (high - low) / step > _MOST_CELLS:
            refuse("step", step, f"needs more than {_MOST_CELLS:,} cells; write step={(high - low) / 2000.0:.3g} or so")
        first, last = int(np.floor(low / step)) - 1, int(np.ceil(high / step)) + 1
        self.stretches: Array = step * (np.arange(first, last, dtype=float) + 0.5)
        self._born = -first  # index of h/2
        inner = self.stretches[self.stretches > lower + _SLIVER * step]
        if upper == end:
            inner = np.append(inner[inner < upper - _SLIVER * step], upper)
        else:
            inner = inner[: int(np.searchsorted(inner, upper)) + 1]
        self.walls = np.append(lower, inner)
        self._cells = cells
        place = np.arange(cells * (self.walls.size - 1) + 1) / cells
        self.edges = np.interp(place, np.arange(self.walls.size), self.walls)
        ends = np.append(self.stretches - 0.5 * step, self.stretches[-1] + 0.5 * step)
        self.cohorts = np.diff(start.cdf(ends))
        self.cohorts /= self.cohorts.sum()
        group = np.searchsorted(self.walls, 0.5 * (self.stretches[:-1] + self.stretches[1:]), side="right") - 1
        self._group = np.clip(group, 0, self.walls.size - 2)
        self._fresh = np.diff(fresh.cdf(self.edges))
        self._fresh /= self._fresh.sum()
        self._whole: Callable[[Array], Array] = _unchanged
        self._half: Callable[[Array], Array] = _unchanged
        if amount > 0.0:
            diffusion = Diffusion(final, self.edges)
            self._half = AgeingPropagator(diffusion, 0.5 * amount, parts)
            self._whole = AgeingPropagator(diffusion, amount, parts)
        # P_c in the middle of two steps' breaks: half a step of ageing is still to come
        self._weights = self._fresh.copy()
        self._aged = self._half(self._weights)

    def weights(self) -> Array:
        """P_c, as weights of the cells."""
        return self._half(self._weights)

    def histogram(self) -> Array:
        """The same, between the walls."""
        return np.asarray(self.weights().reshape(-1, self._cells).sum(axis=1))

    def settle(self, steady: AgeingSteadyState) -> None:
        """Stand in a steady state."""
        stretches = steady.distribution(self.stretches)
        self.cohorts = stretches / stretches.sum()
        weights = np.diff(steady.thresholds.cdf(self.edges))
        self._weights = weights / weights.sum()
        self._aged = self._half(self._weights)

    def state(self) -> tuple[float, float, float]:
        """F/(N_c <k>), mass of P_c less 1, weight of P_c below 0."""
        w = self._weights
        return float(self.stretches @ self.cohorts), float(w.sum()) - 1.0, abs(float(w[w < 0.0].sum()))

    def advance(self) -> bool:
        """One step; False, and nothing done, where contacts stand at a survival that is not above 0."""
        begun, ended = self._aged, self._aged
        for _ in range(2):  # the second time with the survival in the middle of the step
            broken = self._break(0.5 * (begun + ended))
            if broken is None:
                return False
            cohorts, lost, births = broken
            ended = begun - lost + births * self._fresh
            if self._keep == "positivity":
                ended = np.maximum(ended, 0.0)
        self.cohorts, self._weights = cohorts, ended
        self._aged = self._whole(ended)
        return True

    def _break(self, weights: Array) -> tuple[Array, Array, float] | None:
        """Cohorts after the step, thresholds lost from the cells and births, by the survival of `weights`."""
        groups = weights.reshape(-1, self._cells)
        mass = groups.sum(axis=1)
        tail = np.append(np.cumsum(mass[::-1])[::-1], 0.0)
        survival = np.interp(self.stretches, self.walls, tail)
        before, after = survival[:-1], survival[1:]
        standing = self.cohorts[:-1]
        dead = before <= 0.0
        if self._keep == "mass" and (dead & (standing > _STANDING)).any():
            return None
        holds = np.where(dead, 0.0, after / np.where(dead, 1.0, before))
        moved = standing * holds
        lost = standing - moved
        total = float(lost.sum()) + float(self.cohorts[-1])
        cohorts = np.concatenate([[0.0], moved])
        cohorts[self._born] += total
        # those born in the step stand at h/2 on average: some of them break and are born again
        births = total * float(tail[0] / survival[self._born])
        lost[self._born - 1] += births - total
        # the cells that cohorts cross in a step lose in proportion to what they hold
        size = np.abs(groups)
        whole_size = size.sum(axis=1)[:, None]
        share = np.where(whole_size > 0.0, size / np.where(whole_size > 0.0, whole_size, 1.0), 1.0 / self._cells)
        by_group = np.asarray(np.bincount(self._group, lost, minlength=mass.size), dtype=float)
        return cohorts, (share * by_group[:, None]).ravel(), births


def enough_cells(contacts: Contacts, step: float) -> int:
    """Cells to a step over which the potential of the final law changes by little where fresh thresholds lie."""
    ageing = contacts.ageing
    assert ageing is not None
    x = contacts.thresholds.ppf(_BULK)
    lower, upper = ageing.final.support()
    beside = 1e-4 * float(contacts.thresholds.std() or contacts.mean_threshold)
    ends = np.clip(np.stack([x - beside, x + beside]), lower, upper)
    rise = np.diff(ageing.final.logpdf(ends), axis=0)[0] / np.diff(ends, axis=0)[0]
    slope = float(np.abs(rise[np.isfinite(rise)]).max(initial=0.0))
    return int(np.clip(np.ceil(step * slope / _CHANGE), _FEWEST_CELLS, _MOST_CELLS_EACH))


def enough_parts(contacts: Contacts, step: float, velocity: float) -> int:
    """Parts of a step in which the final law is approached by little."""
    ageing = contacts.ageing
    assert ageing is not None
    approach = ageing.rate / velocity * step / ageing.final.std() ** 2
    return int(np.clip(np.ceil(_PARTS * approach), 1, _MOST_PARTS))


def check_closure(contacts: Contacts) -> None:
    if not isinstance(contacts, Contacts):
        refuse("contacts", contacts, "must be contacts, such as origins.Contacts(origins.gaussian(mean=1.0, std=0.05))")
    if contacts.ageing is None:
        raise InputError("contacts.ageing: is None; without ageing use master.solve")
    if contacts.start.is_single:
        raise InputError(
            f"start: all contacts at the one stretch {contacts.start.mean():g}: there (Q15) multiplies what is infinite"
            " by what it empties; use a start with a width, such as origins.gaussian_start(mean=0.1, std=0.025), or "
            'closure = "exact"'
        )
    check_alone(contacts)


def _unchanged(weights: Array) -> Array:
    return weights
