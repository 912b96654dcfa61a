"""One point of a sweep over keys of the scene: a whole scene, solved for its most important numbers."""

from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.results.kinds import is_coupled, is_precise
from toolkit.results.sliding import STILL
from toolkit.results.verdicts import disagreement, of_infinitely_many
from toolkit.running.solvers import follow, make_ensemble, solve_master
from toolkit.scene.scene import Scene, Source, checked

_NO_MORE = 1.05  # times its rise: a force that swings by no more has but risen


class Column(NamedTuple):
    """A number or a text of a point, and its unit ("": none)."""

    value: float | str
    unit: str = ""


def solve_point(
    name: str, text: str, tables: dict[str, Any], folder: str, springs: bool
) -> dict[str, Column]:
    """The columns of a point, by name: smooth sliding, K* if `springs`, then what the point's [master] and [eq] find
    along its drive. "message" says what is not as asked; a point that is refused has nothing else."""
    try:
        scene = checked(
            Source(name, text, tables, Path(folder)), bool({"master", "eq"} & set(tables))
        )
        columns = {**_sliding(scene, springs)}
        solved = eq = None
        if scene.master is not None:
            solved, found = _by_master(scene)
            columns |= found
        if scene.eq is not None:
            eq, found = _by_ensemble(scene)
            columns |= found
        if apart := disagreement(solved, eq):
            columns["message"] = Column(apart)
    except InputError as error:
        return {"message": Column(str(error))}
    columns["message"] = columns.pop("message", Column(""))  # the last
    return columns


def _sliding(scene: Scene, springs: bool) -> dict[str, Column]:
    """F_k and the fraction that holds, if asked K* and F_s/F_k, each with its error; of a surface in SI units, too."""
    import master

    contacts, surface = scene.contacts, scene.contacts.interface
    unit = scene.scale.length_unit
    steady = master.steady_state(contacts, velocity=scene.sliding)
    error = steady.force_error * contacts.mean_threshold
    found = {"mean_threshold": Column(contacts.mean_threshold, unit)}
    found |= {
        "kinetic_force": Column(steady.force, unit),
        "kinetic_force_error": Column(error, unit),
    }
    found["holding"] = Column(steady.holding)
    missed = [] if error <= 1e-3 * abs(steady.force) else [steady.message]
    if springs:
        own: Any = master.propensity(contacts, velocity=scene.sliding)
        for quantity, its in (("critical_spring", "N_c<k>"), ("static_to_kinetic", "")):
            found[quantity] = Column(getattr(own, quantity), its)
            found[f"{quantity}_error"] = Column(getattr(own, f"{quantity}_error"), its)
        if not own.success and not own.critical_spring_error <= 1e-3 * own.critical_spring:
            missed.append(own.message)
    if surface is not None and surface.contact_density is not None:
        stiffness = surface.contact_density * surface.mean_stiffness  # N/m for each m²
        found["kinetic_stress"] = Column(stiffness * steady.force, "Pa")
        if surface.pressure is not None:
            found["kinetic_force_over_load"] = Column(stiffness * steady.force / surface.pressure)
        if scene.area is not None:
            each = stiffness * scene.area
            found["contacts"] = Column(surface.contact_density * scene.area)
            found["kinetic_force_newtons"] = Column(each * steady.force, "N")
            if springs:
                found["critical_spring_newtons"] = Column(each * own.critical_spring, "N/m")
    return found | {"message": Column("; ".join(missed))}


def _by_master(scene: Scene) -> tuple[Any, dict[str, Column]]:
    """The answer, and the force along the drive, and of a slider on a spring its regime with why, and its slips."""
    tolerance: Any = scene.master
    solved = solve_master(scene, tolerance.tolerance)
    unit, mean = scene.scale.length_unit, scene.contacts.mean_threshold
    found = {"largest_force": Column(float(solved.force.max()), unit)}
    found["last_force"] = Column(float(solved.force[-1]), unit)
    found["force_error"] = Column(solved.force_error * mean, unit)
    if solved.regime is not None:
        slips: Any = solved.slips
        only = of_infinitely_many(scene, solved.regime)
        found["regime"] = Column(
            f"{solved.regime.verdict}{' for infinitely many contacts only' * only}"
        )
        found["regime_reason"] = Column(solved.regime.reason)
        farther = solved.regime.drive_to
        found["drive_to"] = Column(np.nan if farther is None else farther, unit)
        answered = is_precise(solved)
        found["slips"] = Column(slips.drive.size if answered else np.nan)
        period = solved.period if answered else None
        found["period"] = Column(np.nan if period is None else period, unit)
        for name in ("force_before", "force_after"):
            usable = answered and slips.drive.size
            last = float(getattr(slips, name)[slips.main[-1]]) if usable else np.nan
            found[f"{name}_slip"] = Column(last, unit)
    return solved, found if solved.success else found | {"message": Column(solved.message)}


def _by_ensemble(scene: Scene) -> tuple[Any, dict[str, Column]]:
    """The answer, and the ensemble's force at the end of the drive with its standard error; of sliders on a spring
    their slips, and by how much the spring's force swings over the last quarter of the path's points, nan where that of
    some is but its rise."""
    asked: Any = scene.eq
    found: Any = follow(make_ensemble(scene, asked, None))
    unit = scene.scale.length_unit
    columns = {"eq_last_force": Column(float(found.force[-1]), unit)}
    columns["eq_last_force_error"] = Column(float(found.force_standard_error[-1]), unit)
    if is_coupled(found):
        swings = _swings(found, cast(float, scene.drive.spring))
        count = len(swings)
        scatter = swings.std(ddof=1) / np.sqrt(count) if count > 1 else np.nan
        columns["eq_force_swing"] = Column(float(swings.mean()), unit)
        columns["eq_force_swing_error"] = Column(float(scatter), unit)
        columns["eq_slips_a_slider"] = Column(len(found.slips.replica) / len(found.forces))
        before = found.slips.force_before
        columns["eq_force_before_slip"] = Column(
            float(before.mean()) if len(before) else np.nan, unit
        )
    return found, columns if found.success else columns | {"message": Column(found.message)}


def _swings(found: Any, spring: float) -> Array:
    """By how much the force of each slider swings over the last quarter of the path's points (lengths); nan where it
    does nothing but rise as the drive loads the spring, before a slip that may come or not."""
    late = slice(-max(found.path.size // 4, 2), None)
    forces, way = found.forces[:, late], abs(float(found.path[-1] - found.path[late][0]))
    swings, rise = np.ptp(forces, axis=1), np.abs(forces[:, -1] - forces[:, 0])
    rising = (rise >= STILL * spring * way) & (swings <= _NO_MORE * rise)
    return np.where(rising, np.nan, swings)
