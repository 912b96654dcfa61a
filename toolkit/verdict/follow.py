"""What one slider does under one slip rule: the drive goes on until it has slipped often enough, or slides."""

import time
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError, refuse
from origins.thresholds.law import Array
from toolkit.processes.ranks import cores_of
from toolkit.scene.drive import machine_number
from toolkit.scene.tables import DriveTable

# slips after which stick-slip is believed, and points of a path
ENOUGH_SLIPS, POINTS = 5, 600
# lengths of the drive's path in loadings, from no force to the static one: tried one after the other
LOADINGS = (6.5, 20.0, 60.0)
# of the force, in mean thresholds: at T = 0, and where a law of the contacts depends on time; and the error up to which
# a regime and its forces are told, the numerical error beside them
TOLERANCE, TOLERANCE_IN_TIME, ENOUGH = 1e-6, 1e-3, 0.05
# sliders of the ensemble, which differ by chance; where it takes the place of the master equation, contacts of each,
# and the least delay, in times of a slip
SLIDERS, CONTACTS, LONG_DELAY = 4, 20_000, 3.0
SEED = 1
# of critical damping, taken where none is given and the slider rings for too long
DAMPED = 0.1
# of the contacts whose sliders tell how long all of them would take, and the least number of these
PILOT, FEW = 1 / 20, 500

# mean thresholds of the slider's way, after which it slides; before, it may only be stretching its contacts
SLID = 10.0
NOT_SLID, NO_TIME = (
    "its path ended before it slid or slipped",
    "no time was left: give more wall_time",
)


@dataclass(frozen=True)
class Machine:
    """What pulls the slider, in the units of the solvers: spring K/(N_c <k>), mass M/(N_c <k>) (time²; None: none),
    damping γ/(N_c <k>) (time), and the drive's velocity."""

    spring: float
    mass: float | None
    damping: float
    velocity: float

    def keywords(self, rule: str) -> dict[str, Any]:
        """Keywords of both solvers under this slip rule; "mass": with mass and damping in its place."""
        given: dict[str, Any] = {"velocity": self.velocity, "spring": self.spring}
        if rule == "mass":
            return given | {"mass": self.mass, "damping": self.damping}
        return given | {"slip": rule}


def machine_of(table: DriveTable, contacts: Contacts) -> Machine | None:
    """The machine of a scene's [drive] on these contacts; None without a spring. Raises InputError, also for a mass
    without a spring."""
    spring, mass, damping = (
        machine_number(name, table, contacts) for name in ("spring", "mass", "damping")
    )
    if spring is None:
        if mass is not None:
            refuse("drive.mass", table.mass, "needs a spring that pulls it; give drive.spring")
        return None
    if mass is None and damping:
        refuse("drive.damping", table.damping, "needs a mass; give drive.mass too")
    return Machine(spring, mass, damping or 0.0, table.velocity)


@dataclass(frozen=True)
class Behaviour:
    """What a slider does under one rule; forces F/(N_c <k>) and distances are lengths.

    rule : "reset", "reform-after" or "instant"; "mass" where mass, damping and delay decide
    kind : "stick-slip", "smooth", or "undecided"
    before, after : spring force before and after a slip, the last one; both the sliding force where it is smooth
    period : of the drive, between the last two slips; slips : how many there were
    slip_time, top_speed : of the last slip; None where slips take no time
    damping : γ/(N_c <k>) (time) of a mass without one, which was taken for it to come to rest; None: as given
    error : of the force, in mean thresholds: estimated from above; by the ensemble one standard error between
        sliders
    drive, force : the trace, with each slip at its own place
    """

    rule: str
    kind: str
    before: float
    after: float
    period: float | None
    slips: int
    error: float
    success: bool
    message: str
    run_time: float
    slip_time: float | None = None
    top_speed: float | None = None
    damping: float | None = None
    drive: Array = field(default_factory=lambda: np.empty(0))
    force: Array = field(default_factory=lambda: np.empty(0))


def follow(
    machine: Machine, contacts: Contacts, rule: str, static: float, wall_time: float
) -> Behaviour:
    """Pull the slider until it has slipped five times or slides steadily.

    static : about the largest force, F_s/(N_c <k>) (a length); wall_time : s
    A combination that the solver does not take is "undecided", and its message says why; with a mass and a long delay
    the ensemble is followed then, and where the master equation does not end within half of the time.
    """
    import master

    loading = static / machine.spring + contacts.mean_threshold
    begin = contacts.start.mean() / machine.spring
    tolerance = TOLERANCE_IN_TIME if contacts.in_time else TOLERANCE
    alone = not _by_contacts(machine, contacts, rule)
    undamped = machine.mass is not None and not machine.damping
    found = not_followed(rule, NO_TIME)
    # the other half is for the ensemble, or for a slider with some damping
    until = time.monotonic() + (0.5 if undamped or not alone else 1.0) * wall_time
    for loadings in LOADINGS:
        path = begin + np.linspace(0.0, loadings * loading, POINTS)
        if (left := until - time.monotonic()) <= 0.0:
            break
        try:
            solved: Any = master.solve(
                contacts, path, tolerance, wall_time=left, **machine.keywords(rule)
            )
        except InputError as error:
            found = not_followed(rule, str(error))
            break
        found = _behaviour(rule, solved)
        if found.kind != "undecided" or not solved.success:
            break
    if found.kind == "undecided" and not found.success and not alone:
        return follow_by_contacts(machine, contacts, rule, loading, until + 0.5 * wall_time)
    if found.kind == "undecided" and undamped and machine.mass is not None:
        damped = replace(
            machine, damping=DAMPED * 2.0 * float(np.sqrt(machine.spring * machine.mass))
        )
        left = until + 0.5 * wall_time - time.monotonic()
        again = follow(damped, contacts, rule, static, left)
        if again.kind != "undecided":
            return replace(again, damping=damped.damping)
    return found


def _by_contacts(machine: Machine, contacts: Contacts, rule: str) -> bool:
    """Whether the ensemble may take the place of the master equation: with a mass and a delay far above the time of a
    slip, π (M/K)^(1/2). Else contacts re-form while it goes on, and break again at every threshold that it passes."""
    slip_time = np.pi * np.sqrt((machine.mass or 0.0) / machine.spring)
    others = contacts.held_in_time
    return rule == "mass" and not others and contacts.waiting_time >= LONG_DELAY * slip_time


def sliders(
    machine: Machine,
    contacts: Contacts,
    rule: str,
    path: Array,
    number: int,
    seconds: float,
    or_fewer: bool = False,
) -> Any:
    """The ensemble's result for sliders of so many contacts each. Where a pilot of a few of them says that all would
    take longer than so many seconds, the pilot's with `or_fewer`, else InputError, as for a slider that the ensemble
    does not take."""
    import eq_model

    asked: dict[str, Any] = {"n_replicas": SLIDERS, "seed": SEED, "threads": cores_of(None)}
    asked |= machine.keywords(rule)
    until, few = time.monotonic() + seconds, max(round(PILOT * number), FEW)
    if few < number:
        pilot = eq_model.simulate(contacts, path, n_contacts=few, **asked)
        needed, left = pilot.run_time * number / few, max(until - time.monotonic(), 0.0)
        if needed > left and or_fewer:
            return pilot
        if needed > left:
            raise InputError(
                f"{number:,} contacts would take some {needed:,.0f} s, where {left:.0f} s are left: give more wall_time"
            )
    return eq_model.simulate(contacts, path, n_contacts=number, **asked)


def follow_by_contacts(
    machine: Machine, contacts: Contacts, rule: str, loading: float, until: float
) -> Behaviour:
    """Sliders with mass and a delay by the ensemble; `loading`: way of the drive up to the static force, `until`: s of
    the monotonic clock. With fewer contacts where there is no time for all."""
    path = contacts.start.mean() / machine.spring + np.linspace(0.0, LOADINGS[0] * loading, POINTS)
    try:
        found = sliders(
            machine, contacts, rule, path, CONTACTS, until - time.monotonic(), or_fewer=True
        )
    except InputError as refused:
        return not_followed(rule, str(refused))
    slips, unit = found.slips, contacts.mean_threshold
    drive, force = trace_of(found, 0)
    common = int(np.bincount(slips.replica, minlength=SLIDERS).min())
    slipped = common > 1
    before, scatter = slips.mean("force_before", common - 1) if slipped else (force[-1], np.inf)
    after = slips.mean("force_after", common - 1)[0] if slipped else force[-1]
    error = scatter if slipped else float(found.force_standard_error[-1])
    if not common and not has_slid(found, unit):
        return not_followed(rule, NOT_SLID)
    return Behaviour(
        rule=rule,
        kind="stick-slip" if slipped else "smooth",
        before=float(before),
        after=float(after),
        period=float(np.diff(slips.drive[slips.replica == 0])[-1]) if slipped else None,
        slips=common,
        error=float(error / unit),
        success=True,
        message=f"by the ensemble, {SLIDERS} sliders of {found.contacts // SLIDERS:,} contacts",
        run_time=found.run_time,
        slip_time=_last(slips, "duration"),
        top_speed=_last(slips, "top_speed"),
        drive=drive,
        force=force,
    )


def has_slid(found: Any, mean: float) -> bool:
    """Whether each slider of an ensemble has moved by so many thresholds that its contacts have formed anew."""
    return bool((found.positions[:, -1] - found.positions[:, 0]).min() >= SLID * mean)


def not_followed(rule: str, why: str) -> Behaviour:
    """A behaviour that could not be found, and why."""
    nan = float("nan")
    return Behaviour(rule, "undecided", nan, nan, None, 0, float("inf"), False, why, 0.0)


def _behaviour(rule: str, solved: Any) -> Behaviour:
    """What the solution of a soft slider says."""
    slips, verdict = solved.slips, solved.regime.verdict
    kind = {"decaying transient": "smooth"}.get(verdict, verdict)
    last = float(solved.force[-1]) if solved.force.size else float("nan")
    before, after = last, last
    if kind == "stick-slip":
        before, after = float(slips.force_before[-1]), float(slips.force_after[-1])
    drive, force = with_slips(solved)
    return Behaviour(
        rule=rule,
        kind=kind,
        before=before,
        after=after,
        period=solved.period,
        slips=slips.drive.size,
        error=solved.force_error,
        success=solved.success or (kind != "undecided" and solved.force_error < ENOUGH),
        message=solved.message if not solved.success else solved.regime.reason,
        run_time=solved.run_time,
        slip_time=_last(slips, "duration"),
        top_speed=_last(slips, "top_speed"),
        drive=drive,
        force=force,
    )


def _last(slips: Any, name: str) -> float | None:
    """A property of the last slip, where the solution has it: slips without mass take no time."""
    values = getattr(slips, name, None)
    return None if values is None or not len(values) else float(values[-1])


def trace_of(found: Any, replica: int) -> tuple[Array, Array]:
    """Drive and force of one slider of an ensemble, as a mean over several has no drops."""
    slips, own = found.slips, found.slips.replica == replica
    of_one = {name: getattr(slips, name)[own] for name in ("drive", "force_before", "force_after")}
    one = SimpleNamespace(**of_one)
    return with_slips(SimpleNamespace(path=found.path, force=found.forces[replica], slips=one))


def with_slips(solved: Any) -> tuple[Array, Array]:
    """Drive and force at the path's points, and before and after each slip, so that no slip is drawn aslant."""
    slips = solved.slips
    drive = np.concatenate([solved.path, slips.drive, slips.drive])
    force = np.concatenate([solved.force, slips.force_before, slips.force_after])
    # at one place of the drive: the points before the slip, its begin, its end
    rank = np.repeat([0, 1, 2], [solved.path.size, slips.drive.size, slips.drive.size])
    order = np.lexsort((rank, drive))
    return drive[order], force[order]
