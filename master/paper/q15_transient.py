"""(Q15): the paper's transients of contacts that age, as printed, and what they do not keep.

One P_c is both the law of new thresholds and the histogram of those that hold. Only in the steady
state is it both. From a peaked start the contacts outrun it: they stand where the thresholds that
would break them are used up already, and no P_c that is nowhere negative can lose as many
thresholds as contacts break. From there on either its mass or its sign is lost, and the answer
depends on which; both defects are told at every X. The steps are those of q15_step.
"""

import time
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline

from master.outcome import Progress, unheard
from master.paper.q15_step import Keep, Q15Stepper, ages, enough_cells, enough_parts, half_width
from origins import Contacts, Drive
from origins.brief import brief
from origins.errors import positive, refuse, whole

Array = npt.NDArray[np.float64]

# First step of `solve_q15`, of the narrowest width: coarser ones see nothing of the laws.
_COARSEST = 0.5
# Cells times steps times parts after which no finer step is tried: about ten seconds.
_MOST_WORK = 1e8
# Degree of the polynomials by which the force is read between steps: above the order of the steps.
_SPLINE = 5
# Defect of mass or sign from which on contacts are said to have outrun P_c.
_NOTICED = 1e-6


@dataclass(frozen=True)
class AgeingTransient:
    """F(X) of (Q15) and its defects; arrays of shape (n,) unless said.

    Attributes
    ----------
    path : array
        Positions X (lengths), as far as the solution goes.
    force : array
        F/(N_c <k>), a length.
    force_error : float
        Estimate of its largest error in units of the mean fresh threshold; inf for a single step.
    holding : array
        Fraction of contacts that hold: 1.
    mass_defect : array
        Mass of P_c less 1.
    positivity_defect : array
        Weight of P_c below 0, as a positive number.
    edges : array (m + 1,)
        Ends of cells of P_c (lengths), a step wide but for the outermost.
    weights : array (n, m)
        P_c at each X, as weights of the cells.
    step : float
        h, a length.
    outrun : float
        X from which contacts stand where no thresholds are left (a length); inf if they never do.
        From there on the answer is one of many: what (Q15) does not say has been decided by `keep`,
        and by where the table of P_c ends, at a survival of 1e-13, where all break.
    success : bool
        Whether the path was followed to its end, and the force is as good as asked for.
    message : str
        In words: what was reached, and what P_c did not keep.
    run_time : float
        Seconds.
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
    cells: int | None = None,
    parts: int | None = None,
) -> AgeingTransient:
    """(Q15) as printed, along a rigid slider's path, with steps of one length.

    Parameters
    ----------
    contacts : Contacts
        With `ageing`, and a start that is no single value.
    path : array of shape (n,)
        Positions X >= 0 that never turn back (lengths).
    step : float
        h, of X and between cohorts (a length): a tenth of the narrowest of start and laws, or less.
    velocity : float
        v > 0; D_X = D/v.
    keep : "positivity" or "mass"
        What is kept where both cannot be. "positivity": thresholds that are not there cannot be
        lost, and the mass grows. "mass": P_c goes below 0; the solution ends where contacts stand
        at a survival that is not above 0.
    cells, parts : int, optional
        Cells of P_c to each step, and parts in which each step ages; None: enough.

    Raises InputError for contacts without ageing, with thermal breaking, delay or re-forming away
    from 0, and for a start from a single value: there P Q is a product of what is infinite and what
    it empties, and (Q15) has no meaning.
    """
    began = time.perf_counter()
    ages(contacts)
    positions = Drive(path).only_forward("the paper's closure of ageing").path
    if keep not in ("positivity", "mass"):
        refuse("keep", keep, 'must be "positivity" or "mass"')
    step, velocity = positive("step", step), positive("velocity", velocity)
    cells = None if cells is None else whole("cells", cells, 1)
    parts = None if parts is None else whole("parts", parts, 1)
    stepper = Q15Stepper(contacts, step, velocity, keep, cells, parts)

    steps = int(np.ceil(positions[-1] / step * (1.0 - 1e-12)))  # a path of whole steps ends on one
    # at each position P_c is that of the last step before it
    last_step = np.minimum(np.floor(positions / step * (1.0 + 1e-12)).astype(int), steps)
    told = [stepper.state()]
    shown = {0: stepper.histogram()}
    while len(told) <= steps and stepper.advance():
        if len(told) in last_step:
            shown[len(told)] = stepper.histogram()
        told.append(stepper.state())
    at: Array = step * np.arange(len(told), dtype=float)
    finished = len(told) > steps
    kept = positions if finished else positions[positions <= at[-1] * (1.0 + 1e-12)]
    force, mass, below = np.array(told).T
    lost = np.flatnonzero(np.maximum(np.abs(mass), below) > _NOTICED)
    outrun = float(at[lost[0]]) if lost.size else np.inf if finished else float(at[-1])
    message = "P_c kept its mass and its sign"
    if not finished:
        message = f"from X = {len(told) * step:g} on contacts stand where no thresholds are left"
    elif lost.size:
        off = np.abs(mass).max()
        message = f"from X = {outrun:g} on contacts outrun P_c; its mass is off by up to {off:.2g}"
    degree = _SPLINE if at.size > _SPLINE else min(1, at.size - 1)
    return AgeingTransient(
        path=kept,
        force=np.asarray(make_interp_spline(at, force, k=degree)(kept)),
        force_error=np.inf,
        holding=np.ones(kept.size),
        mass_defect=np.interp(kept, at, mass),
        positivity_defect=np.interp(kept, at, below),
        edges=stepper.walls,
        weights=np.array([shown[n] for n in last_step[: kept.size].tolist()]),
        step=step,
        outrun=outrun,
        success=finished,
        message=message,
        run_time=time.perf_counter() - began,
    )


def solve_q15(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress = unheard
) -> AgeingTransient:
    """F along drive.path (paper, Eq. Q15): steps are halved until it, extrapolated, changes by less
    than `tolerance` (in mean fresh thresholds), or the work is too much; the error says which."""
    began = time.perf_counter()
    step = _COARSEST * _narrowest(contacts)
    # the same at all steps: errors of both then fall as h²
    cells, parts = enough_cells(contacts, step), enough_parts(contacts, step, drive.velocity)
    end, unit = float(drive.path[-1]), contacts.mean_threshold

    def follow(step: float) -> AgeingTransient:
        return paper_transient(contacts, drive.path, step, drive.velocity, cells=cells, parts=parts)

    finest = follow(step)
    force, error = finest.force, np.inf
    before: Array | None = None
    # half the step makes twice the steps, each over twice the cells
    work = 4.0 * finest.edges.size * cells * parts * (end / step + 1.0)
    stuck = False
    while error > tolerance and not stuck and (work <= _MOST_WORK or not np.isfinite(error)):
        coarser, step = finest, 0.5 * step
        finest = follow(step)
        force = (4.0 * finest.force - coarser.force) / 3.0
        if before is not None:
            change = 2.0 * float(np.abs(force - before).max()) / unit
            # where contacts outran P_c finer steps need not help
            stuck = finest.outrun < end and change > 0.5 * error
            error = change
            progress(error)
        before, work = force, 4.0 * work
    message = f"error estimate {error:.1e} is within the tolerance {tolerance:.1e}"
    if error > tolerance:
        message = f"error estimate {error:.1e} at the step {step:.2g} is above {tolerance:.1e}"
    return replace(
        finest,
        force=force,
        force_error=error,
        success=error <= tolerance,
        message=f"{message}; {finest.message}",
        run_time=time.perf_counter() - began,
    )


def _narrowest(contacts: Contacts) -> float:
    """The least width (a length) of start, fresh and final thresholds; single values have none."""
    laws = contacts.thresholds, contacts.start, ages(contacts).final
    return min(width for width in [half_width(law) for law in laws] if width > 0.0)
