"""(Q15): the paper's transients of contacts that age, as printed, and their defects.

    dQ/dX + dQ/dx + P Q = delta(x) b,    b = integral of P Q
    dP_c/dX = D_X L P_c - P Q + P_ci b
    P_c = P exp(-integral of P),         that is P = P_c/S, S the survival of P_c

(Q15) takes one P_c as both the law of new thresholds and the histogram of those that hold, which is right only in the
steady state. From a peaked start the contacts outrun P_c: they reach stretches at which the thresholds that would break
them are used up, and P_c would have to become negative to lose as many thresholds as contacts break. From there on
either its mass or its sign is wrong, and the answer depends on which; both defects are returned at every X.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline

from master.outcome import Progress, outcome
from master.steady.q15 import ageing_of, make_ageing
from master.survival.age.extent import highest
from origins import Contacts, Drive
from origins.brief import brief
from origins.errors import one_of, positive, refuse, whole
from origins.laws.diffusion import Diffusion
from origins.thresholds.law import Array

Keep = Literal["positivity", "mass"]

# Cells of P_c per step, which resolve how P_cf changes over a step; survival of P_ci or P_cf at which they end, so
# small a share being negligible; and most steps across them: more would take hours.
CELLS, TAIL, MOST_STEPS = 4, 1e-13, 20_000


@dataclass(frozen=True)
class AgeingTransient:
    """F(X) of (Q15) and its defects; arrays of shape (n,) unless another is given.

    path, force : positions X, as far as the solution goes, and F/(N_c <k>) there; lengths.
    force_error : estimate of its largest error in units of the mean fresh threshold; inf for a single step.
    holding : fraction of contacts that hold: 1.
    mass_defect, positivity_defect : mass of P_c minus 1, and negative weight of P_c, without its sign.
    edges : thresholds from the lowest to the largest, shape (m + 1,), lengths, one step apart except for the outermost.
    weights : P_c at each X, as its weight between each edge and the next, shape (n, m).
    step : h, a length.
    outrun : X from which on contacts have stretches at which no thresholds are left, a length; inf if that never
        happens. From there on (Q15) does not determine the answer: it depends on `keep`, and on where the table of P_c
        ends, at a survival of 1e-13, where all contacts break.
    success, message : whether the path was followed to its end with the requested accuracy; that reached, and the
        defects of P_c.
    run_time : s.
    """

    path: Array
    force: Array
    force_error: float
    holding: Array
    mass_defect: Array
    positivity_defect: Array
    edges: Array = field(repr=False)
    weights: Array = field(repr=False)
    step: float
    outrun: float
    success: bool
    message: str
    run_time: float

    __repr__ = brief


def paper_transient(
    contacts: Contacts,
    path: npt.ArrayLike,
    step: float,
    velocity: float = 1.0,
    keep: Keep = "positivity",
    cells: int = CELLS,
) -> AgeingTransient:
    """(Q15) as printed, along a rigid slider's path, with steps of one length.

    contacts : with `ageing`, and a start that is no single value.
    path : positions X >= 0 that never turn back, shape (n,), lengths.
    step : h, of X and between cohorts, a length; at most a tenth of the narrowest width of start and laws serves well.
    velocity : v > 0, length per time; D_X = D/v.
    keep : what is conserved where both cannot be. "positivity": thresholds that are missing are not subtracted, and the
        mass grows. "mass": P_c becomes negative; the solution ends where contacts stand at a survival not above 0.
    cells : number of cells of P_c per step.

    Raises InputError for other contacts and for paths that turn back.
    """
    began = time.perf_counter()
    ageing = ageing_of(contacts)
    positions = Drive(path).only_forward("the paper's closure of ageing").path
    one_of("keep", keep, get_args(Keep))
    step, velocity = positive("step", step), positive("velocity", velocity)
    state = _State(contacts, step, ageing.rate / velocity * step, whole("cells", cells, 1))

    steps = int(np.ceil(positions[-1] / step * (1.0 - 1e-12)))  # despite rounding of whole steps
    # P_c at each position is that of the last step before it
    last_step = np.minimum(np.floor(positions / step * (1.0 + 1e-12)).astype(int), steps)
    numbers, shown = [state.numbers()], {0: state.histogram()}
    while len(numbers) <= steps and state.advance(keep):
        if len(numbers) in last_step:
            shown[len(numbers)] = state.histogram()
        numbers.append(state.numbers())
    at: Array = step * np.arange(len(numbers), dtype=float)
    finished = len(numbers) > steps
    kept = positions[positions <= at[-1] * (1.0 + 2e-12)]
    force, mass, below = np.array(numbers).T
    defective = np.flatnonzero(np.maximum(np.abs(mass), below) > 1e-6)  # contacts have outrun P_c
    outrun, message = np.inf, "P_c kept its mass and its sign"
    if defective.size:
        outrun, off = float(at[defective[0]]), np.abs(mass).max()
        message = f"from X = {outrun:g} on contacts outrun P_c; its mass is off by up to {off:.2g}"
    if not finished:
        outrun = min(outrun, float(at[-1]))
        message = f"from X = {len(numbers) * step:g} on contacts stand where no thresholds are left"
    # between steps the force is a spline of a degree above the order of the steps
    spline = make_interp_spline(at, force, k=min(5, at.size - 1))
    return AgeingTransient(
        path=kept,
        force=np.asarray(spline(kept)),
        force_error=np.inf,
        holding=np.ones(kept.size),
        mass_defect=np.interp(kept, at, mass),
        positivity_defect=np.interp(kept, at, below),
        edges=state.group_ends,
        weights=np.array([shown[n] for n in last_step[: kept.size].tolist()]),
        step=step,
        outrun=outrun,
        success=finished,
        message=message,
        run_time=time.perf_counter() - began,
    )


def solve_q15(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress, until: float
) -> AgeingTransient:
    """F along drive.path (paper, Eq. Q15), extrapolated in h². The step h is halved until the force is known to
    `tolerance` (in mean fresh thresholds), or further steps would take more than some ten seconds, or end after the
    reading `until` of time.monotonic(). Twice the change of the extrapolated force counts as its error."""
    began, end = time.perf_counter(), float(drive.path[-1])
    step = 0.5 * narrowest_half_width(contacts)  # coarser steps do not resolve the laws
    fine = paper_transient(contacts, drive.path, step, drive.velocity)
    better, error = fine.force, np.inf
    stuck, late = False, ""  # whether finer steps no longer help; why they were left out
    while error > tolerance and not stuck and CELLS * fine.edges.size * end / step <= 2.5e7:
        if time.monotonic() + 4.0 * fine.run_time > until:  # halved steps take four times as long
            late = ", as wall_time leaves no time for finer ones"
            break
        step, coarse, before = 0.5 * step, fine, better
        fine = paper_transient(contacts, drive.path, step, drive.velocity)
        better = (4.0 * fine.force - coarse.force) / 3.0
        change = 2.0 * float(np.abs(better - before).max()) / contacts.mean_threshold
        # where contacts have outrun P_c, finer steps may not reduce the error
        stuck, error = fine.outrun < end and change > 0.5 * error, change
        progress(error)
    reason = f"error estimate {error:.1e} at the step {step:.2g} is above {tolerance:.1e}{late}"
    success, message = outcome(contacts, error, tolerance, reason)
    message, run_time = f"{message}; {fine.message}", time.perf_counter() - began
    return replace(
        fine, force=better, force_error=error, success=success, message=message, run_time=run_time
    )


class _State:
    """Cohorts of contacts and cells of P_c, one step of X at a time.

    Contacts are cohorts at (i + 1/2) h, which a step moves across a whole group of cells of P_c, from one of
    `group_ends` (lengths, shape (m + 1,)) to the next. Each step is half a step of ageing, the breaks, with the
    survival in the middle of the step, and half a step of ageing. Errors fall as h² while mass and sign are kept, and
    as h after that.
    """

    def __init__(self, contacts: Contacts, step: float, amount: float, cells: int) -> None:
        """Choose the cells of thresholds, which age by `amount` = D_X h (a length squared) in a step."""
        fresh, start, final = contacts.thresholds, contacts.start, ageing_of(contacts).final
        lower, end = final.support()
        upper = min(end, highest(fresh, final, TAIL))
        low, high = min(start.span[0], 0.0), max(upper, start.span[1])
        if (high - low) / step > MOST_STEPS:
            example = f"write step={(high - low) / 2000.0:.3g} or so"
            refuse("step", step, f"needs more than {MOST_STEPS:,} steps; {example}")
        first, last = int(np.floor(low / step)) - 1, int(np.ceil(high / step)) + 1
        cohort_ends: Array = step * np.arange(first, last + 1, dtype=float)
        self._stretches, self._born = cohort_ends[:-1] + 0.5 * step, -first  # the index of h/2
        self._cohorts = np.diff(start.cdf(cohort_ends))
        self._cohorts /= self._cohorts.sum()

        # no cell lies beyond the end of P_cf, and none is narrower than a quarter of a step
        top = min(float(self._stretches[np.searchsorted(self._stretches, upper)]), end)
        apart = (self._stretches > lower + 0.25 * step) & (self._stretches < top - 0.25 * step)
        self.group_ends = np.concatenate([[lower], self._stretches[apart], [top]])
        groups = self.group_ends.size - 1
        place = np.arange(cells * groups + 1) / cells
        cell_ends = np.interp(place, np.arange(groups + 1), self.group_ends)
        after = np.searchsorted(self.group_ends, cohort_ends[1:-1], "right")
        self._group = np.clip(after - 1, 0, groups - 1)
        self._cells, self._fresh = cells, np.diff(fresh.cdf(cell_ends))
        self._fresh /= self._fresh.sum()
        hops = Diffusion(final, cell_ends)
        self._half, self._whole = (_exponential(hops, part * amount) for part in (0.5, 1.0))
        # P_c after a step's breaks, and after the ageing up to the next breaks
        self._broken, self._aged = self._fresh, self._half(self._fresh)

    def histogram(self) -> Array:
        """P_c, as weights of the groups of cells."""
        return np.asarray(self._half(self._broken).reshape(-1, self._cells).sum(axis=1))

    def numbers(self) -> Array:
        """F/(N_c <k>) (a length), mass of P_c minus 1, and negative weight of P_c without its sign."""
        w = self._broken
        return np.array([self._stretches @ self._cohorts, w.sum() - 1.0, -w[w < 0.0].sum()])

    def advance(self, keep: Keep) -> bool:
        """Take one step; with keep = "mass" none, and False, where contacts stand at a survival not above 0."""
        begun = middle = self._aged
        for _ in range(2):  # the second time with the survival in the middle of the step
            tail = np.append(middle[::-1].cumsum()[:: -self._cells], 0.0)
            survival = np.interp(self._stretches, self.group_ends, tail)
            standing, dead = self._cohorts[:-1], survival[:-1] <= 0.0
            # a share of 1e-14, where no thresholds are left, counts as none
            if keep == "mass" and (dead & (standing > 1e-14)).any():
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
            size = np.abs(middle.reshape(-1, self._cells)) + 1e-300
            fraction = size / size.sum(axis=1, keepdims=True)
            by_group = np.bincount(self._group, lost, minlength=fraction.shape[0])
            ended = begun - (fraction * by_group[:, None]).ravel() + births * self._fresh
            ended = np.maximum(ended, 0.0) if keep == "positivity" else ended
            middle = 0.5 * (begun + ended)
        self._cohorts, self._broken, self._aged = cohorts, ended, self._whole(ended)
        return True


def _exponential(hops: Diffusion, amount: float) -> Callable[[Array], Array]:
    """The function that ages weights (n,) by `amount` = D t (a length squared), their sum kept.

    exp(z) ≈ Re (1 - i)/(1 - (1 + i) z/2) is of second order, damps fast modes and makes hardly any weight negative.
    """
    age = make_ageing(hops, (0.5 + 0.5j) * amount)
    return lambda weights: np.asarray(((1.0 - 1.0j) * age(weights)).real, dtype=float)


def narrowest_half_width(contacts: Contacts) -> float:
    """The narrowest half width (a length) of the middle two thirds of start and laws."""
    laws = contacts.thresholds, contacts.start, ageing_of(contacts).final
    widths = [0.5 * float(law.isf(0.16) - law.ppf(0.16)) for law in laws]
    return min(width for width in widths if width > 0.0)  # single values do not count
