"""(Q15): the paper's transients of contacts that age, as printed, and their defects.

(Q15) takes one P_c as both the law of new thresholds and the histogram of those that hold, which is
right only in the steady state. From a peaked start the contacts outrun P_c: they reach stretches at
which the thresholds that would break them are used up, and P_c would have to become negative to
lose as many thresholds as contacts break. From there on either its mass or its sign is wrong, and
the answer depends on which; both defects are returned at every X. q15_step takes the steps.
"""

import time
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline

from master.outcome import Progress, unheard
from master.paper.q15_step import Keep, Q15Stepper, ages, enough_cells, enough_parts, narrowest
from origins import Contacts, Drive
from origins.brief import brief
from origins.errors import positive, refuse, whole

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class AgeingTransient:
    """F(X) of (Q15) and its defects; arrays of shape (n,) unless another is given.

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
        Mass of P_c minus 1.
    positivity_defect : array
        Negative weight of P_c, without its sign.
    edges : array (m + 1,)
        Ends of cells of P_c (lengths), one step wide except for the outermost.
    weights : array (n, m)
        P_c at each X, as weights of the cells.
    step : float
        h, a length.
    outrun : float
        X from which on contacts have stretches at which no thresholds are left (a length); inf if
        that never happens. From there on (Q15) does not determine the answer: it depends on `keep`,
        and on where the table of P_c ends, at a survival of 1e-13, where all contacts break.
    success : bool
        Whether the path was followed to its end with the requested accuracy.
    message : str
        The accuracy reached, and the defects of P_c.
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
        h, of X and between cohorts (a length): at most a tenth of the narrowest width of start and
        laws.
    velocity : float
        v > 0; D_X = D/v.
    keep : "positivity" or "mass"
        What is conserved where both cannot be. "positivity": thresholds that are missing are not
        subtracted, and the mass grows. "mass": P_c becomes negative; the solution ends where
        contacts have a stretch with a survival that is not above 0.
    cells, parts : int, optional
        Cells of P_c per step, and parts of each step of ageing; None: chosen from the laws.

    Raises InputError for contacts without ageing, with thermal breaking, delay or re-forming away
    from 0, and for a start at a single stretch, for which (Q15) has no meaning: P Q is infinite.
    """
    began = time.perf_counter()
    ages(contacts)
    positions = Drive(path).only_forward("the paper's closure of ageing").path
    if keep not in ("positivity", "mass"):
        refuse("keep", keep, 'must be "positivity" or "mass"')
    step, velocity = positive("step", step), positive("velocity", velocity)
    cells = None if cells is None else whole("cells", cells, 1)
    parts = enough_parts(contacts, step, velocity) if parts is None else whole("parts", parts, 1)
    stepper = Q15Stepper(contacts, step, velocity, keep, cells, parts)

    steps = int(np.ceil(positions[-1] / step * (1.0 - 1e-12)))  # despite rounding of whole steps
    # P_c at each position is that of the last step before it
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
    lost = np.flatnonzero(np.maximum(np.abs(mass), below) > 1e-6)  # contacts have outrun P_c
    outrun = float(at[lost[0]]) if lost.size else np.inf if finished else float(at[-1])
    message = "P_c kept its mass and its sign"
    if not finished:
        message = f"from X = {len(told) * step:g} on contacts stand where no thresholds are left"
    elif lost.size:
        off = np.abs(mass).max()
        message = f"from X = {outrun:g} on contacts outrun P_c; its mass is off by up to {off:.2g}"
    # between steps the force is a spline of a degree above the order of the steps
    spline = make_interp_spline(at, force, k=5 if at.size > 5 else min(1, at.size - 1))
    return AgeingTransient(
        path=kept,
        force=np.asarray(spline(kept)),
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
    """F along drive.path (paper, Eq. Q15): steps are halved until the extrapolated force changes by
    less than `tolerance` (in mean fresh thresholds), or until some ten seconds are spent."""
    began, end = time.perf_counter(), float(drive.path[-1])
    # coarser steps do not resolve the laws
    step = 0.5 * narrowest(contacts.thresholds, contacts.start, ages(contacts).final)
    # the same for all steps, so that the errors of both fall as h²
    cells, parts = enough_cells(contacts, step), enough_parts(contacts, step, drive.velocity)
    runs: list[AgeingTransient] = []
    forces: list[Array] = []  # extrapolated from two steps
    error, stuck, work = np.inf, False, 0.0
    while len(forces) < 2 or (error > tolerance and not stuck and 4.0 * work <= 1e8):
        run = paper_transient(contacts, drive.path, step, drive.velocity, cells=cells, parts=parts)
        runs = [*runs[-1:], run]
        work, step = run.edges.size * cells * parts * (end / step + 1.0), 0.5 * step
        if len(runs) > 1:
            forces.append((4.0 * runs[1].force - runs[0].force) / 3.0)
        if len(forces) > 1:
            change = 2.0 * float(np.abs(forces[-1] - forces[-2]).max()) / contacts.mean_threshold
            # where contacts have outrun P_c, finer steps may not reduce the error
            stuck = run.outrun < end and change > 0.5 * error
            error = change
            progress(error)
    message = f"error estimate {error:.1e} is within the tolerance {tolerance:.1e}"
    if error > tolerance:
        message = f"error estimate {error:.1e} at the step {run.step:.2g} is above {tolerance:.1e}"
    return replace(
        run,
        force=forces[-1],
        force_error=error,
        success=error <= tolerance,
        message=f"{message}; {run.message}",
        run_time=time.perf_counter() - began,
    )
