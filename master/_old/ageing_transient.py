"""Transients of contacts that age, in the paper's closure as printed (Eq. Q15), and what it does not keep.

    ∂Q/∂X + ∂Q/∂x + P Q = δ(x) b,    ∂P_c/∂X = D_X L P_c - P Q + P_ci b,    P = P_c/∫_x^∞ P_c,    b = ∫ P Q.

One P_c is both the law new contacts draw their thresholds from and the histogram of those that hold. Only in the steady
state is it both. From a peaked start the contacts outrun it: they stand where the thresholds that would break them are
used up already, and no P_c that is nowhere negative can lose as many thresholds as contacts break. From there on either
its mass is not kept or its sign, and the answer depends on which; both defects are told at every X.
"""

import time
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline

from master._old.ageing_stepper import Keep, PaperStepper, check_closure, enough_cells, enough_parts
from master.outcome import Progress, unheard
from origins import Contacts, Drive
from origins.brief import brief
from origins.errors import positive, refuse, whole

Array = npt.NDArray[np.float64]

_COARSEST = 0.5  # of the narrowest width
_MOST_WORK = 1e8  # cells times steps
_SPLINE = 5
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
        Estimate of its largest error in units of the mean fresh threshold; inf where one step alone was tried.
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
    stretches : array (k,)
        Where the cohorts stand (lengths).
    cohorts : array (n, k)
        Q at each X, as fractions of the contacts.
    step : float
        h, a length.
    outrun : float
        X from which contacts stand where no thresholds are left (a length); inf where that never happens. From there
        on the answer is one of many: what (Q15) does not say has been decided by `keep`, and by where the table of P_c
        ends, at a survival of 1e-13 of P_ci or P_cf, where all break.
    success : bool
        Whether the path was followed to its end, and the force is as good as asked for.
    message : str
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
    stretches: Array = field(repr=False)
    cohorts: Array = field(repr=False)
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
    """(Q15) as printed, along a rigid slider's path.

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
        What is kept where both cannot be. "positivity": thresholds that are not there cannot be lost, and the mass
        grows. "mass": P_c goes below 0; the solution ends where contacts stand at a survival that is not above 0.
    cells : int, optional
        Of P_c, to each step; None: at least four, and enough for thresholds to fall apart by diffusion as they should.
    parts : int, optional
        In which each step ages; None: enough for what is fast.

    Raises InputError for contacts without ageing, with thermal breaking, delay, re-forming away from 0 or linked
    stiffness, and for a start from a single value: there P Q is a product of what is infinite and what it empties,
    and (Q15) has no meaning.
    """
    began = time.perf_counter()
    check_closure(contacts)
    positions = Drive(path).only_forward("the paper's closure of ageing").path
    if keep not in ("positivity", "mass"):
        refuse("keep", keep, 'must be "positivity" or "mass"')
    positive("step", step)
    cells = enough_cells(contacts, step) if cells is None else whole("cells", cells, 1)
    velocity = positive("velocity", velocity)
    parts = enough_parts(contacts, step, velocity) if parts is None else whole("parts", parts, 1)
    stepper = PaperStepper(contacts, step, velocity, keep, cells, parts)
    steps = int(np.ceil(positions[-1] / step * (1.0 - 1e-12)))
    told = [stepper.state()]
    reached = np.searchsorted(positions, step * np.arange(steps + 1) * (1.0 + 1e-12), side="right")
    snapshots: list[tuple[Array, Array]] = []
    message = ""
    for n in range(steps + 1):
        if n > 0:
            if not stepper.advance():
                message = f"from X = {n * step:g} on contacts stand where no thresholds are left to break them"
                break
            told.append(stepper.state())
        # snapshots are those of the last step before each position
        before = int(reached[n - 1]) if n else 0
        upto = int(reached[n]) if n < steps else positions.size
        if upto > before:
            snapshot = stepper.histogram(), stepper.cohorts.copy()
            snapshots += [snapshot] * (upto - before)
    at: Array = step * np.arange(len(told), dtype=float)
    kept = positions if len(told) > steps else positions[positions <= at[-1] * (1.0 + 1e-12)]
    force, mass, below = np.array(told).T
    lost = np.flatnonzero(np.maximum(np.abs(mass), below) > _NOTICED)
    outrun = float(at[lost[0]]) if lost.size else float(at[-1]) if message else np.inf
    if not message and lost.size:
        message = f"from X = {outrun:g} on contacts outrun P_c; its mass is off by up to {np.abs(mass).max():.2g}"
    return AgeingTransient(
        path=kept,
        force=_between(kept, at, force),
        force_error=np.inf,
        holding=np.ones(kept.size),
        mass_defect=np.interp(kept, at, mass),
        positivity_defect=np.interp(kept, at, below),
        edges=stepper.walls,
        weights=np.array([w for w, _ in snapshots[: kept.size]]),
        stretches=stepper.stretches,
        cohorts=np.array([q for _, q in snapshots[: kept.size]]),
        step=step,
        outrun=outrun,
        success=len(told) > steps,
        message=message or "P_c kept its mass and its sign",
        run_time=time.perf_counter() - began,
    )


def solve_paper(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress = unheard
) -> AgeingTransient:
    """(Q15) along drive.path with steps halved until the force, extrapolated in h², changes little enough."""
    began = time.perf_counter()
    check_closure(contacts)
    step = _COARSEST * _narrowest(contacts)
    cells, parts = enough_cells(contacts, step), enough_parts(contacts, step, drive.velocity)
    end, unit = float(drive.path[-1]), contacts.mean_threshold
    finest = paper_transient(contacts, drive.path, step, drive.velocity, cells=cells, parts=parts)
    before: Array | None = None
    error, force = np.inf, finest.force
    # halving makes twice the steps, each over twice the cells; at least three lengths of step
    work = 4.0 * finest.edges.size * cells * parts * (end / step + 1.0)
    stuck = False
    while error > tolerance and not stuck and (work <= _MOST_WORK or not np.isfinite(error)):
        coarser, step = finest, 0.5 * step
        finest = paper_transient(contacts, drive.path, step, drive.velocity, cells=cells, parts=parts)
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
        message = f"error estimate {error:.1e} at the step {step:.2g} is above the tolerance {tolerance:.1e}"
    return replace(
        finest,
        force=force,
        force_error=error,
        success=error <= tolerance,
        message=f"{message}; {finest.message}",
        run_time=time.perf_counter() - began,
    )


def _narrowest(contacts: Contacts) -> float:
    """Half of the width that holds the middle two thirds of start, fresh or final thresholds, whichever is least;
    single values have none."""
    assert contacts.ageing is not None
    laws = contacts.thresholds, contacts.start, contacts.ageing.final
    widths = [0.5 * float(law.isf(0.16) - law.ppf(0.16)) for law in laws]
    return min(width for width in widths if width > 0.0)


def _between(x: Array, at: Array, values: npt.ArrayLike) -> Array:
    """Values read between steps."""
    if at.size < 2:
        return np.full(x.size, np.asarray(values)[0])
    return np.asarray(make_interp_spline(at, values, k=_SPLINE if at.size > _SPLINE else 1)(x))
