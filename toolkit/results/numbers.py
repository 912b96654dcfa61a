"""The numbers of a run on a surface in the units of its forces: newtons of an area, pascals without one."""

from typing import Any

import numpy as np

from toolkit.results.kinds import is_coupled, is_precise
from toolkit.results.slips import main_slips
from toolkit.scene.interfaces import Number
from toolkit.scene.scale import ROUNDING, with_uncertainty, written

_SEEN = 1e-6  # of the largest force of a run: a smaller error is not told


def numbers_of(result: Any) -> dict[str, Number]:
    """Forces, friction coefficients, springs and slips of a run, by name, in the units of its `scale`, each with its
    numerical or its standard error. The master equation's where it is solved, else the ensemble's."""
    solved, eq, scale = result.master, result.eq, result.scale
    found, force = dict[str, Number](), scale.force_unit
    if solved is not None and is_precise(solved) and solved.force.size:
        error = np.full(solved.force.size, solved.force_error * result.mean_threshold)
        found |= _of_curve(solved.force, error, scale)
        if solved.regime is not None:
            regime = solved.regime
            value, off = regime.critical_spring, regime.critical_spring_error
            found["critical_spring"] = Number(
                value * scale.spring, off * scale.spring, scale.spring_unit
            )
        if solved.slips is not None and solved.slips.drive.size:
            last = solved.slips.main[-1]
            before, after = solved.slips.force_before[last], solved.slips.force_after[last]
            found["before_slip"] = Number(before * scale.force, error[0] * scale.force, force)
            found["after_slip"] = Number(after * scale.force, error[0] * scale.force, force)
            if (period := solved.slips.period) is not None:
                off = float(solved.slips.period_error)
                found["period"] = Number(period, off, scale.length_unit)
    elif eq is not None:
        found |= _of_curve(eq.force, eq.force_standard_error + eq.step_error, scale)
        if is_coupled(eq) and eq.slips.number.size:
            found |= _of_slips(eq, scale)
    found = _without_rounding(found)
    found |= _over_load(found, scale.load) if scale.load else {}
    if result.sweep is not None and result.sweep.smooth:
        for name, factor, unit in (
            ("force", scale.force, force),
            ("critical_spring", scale.spring, scale.spring_unit),
        ):
            if (values := getattr(result.sweep, name)) is not None:
                off = getattr(result.sweep, f"{name}_error")
                off = off * (result.mean_threshold if name == "force" else 1.0) * factor
                for word, at in (("least", np.argmin(values)), ("most", np.argmax(values))):
                    here = float(values.flat[at]) * factor
                    found[f"swept_{name}_{word}"] = Number(here, float(off.flat[at]), unit)
    return found


def _of_curve(force: Any, error: Any, scale: Any) -> dict[str, Number]:
    """The force at the end of the path and the largest one."""
    found = dict[str, Number]()
    for name, at in (("last_force", -1), ("largest_force", int(np.argmax(force)))):
        value, off = float(force[at]) * scale.force, float(error[at]) * scale.force
        found[name] = Number(value, off, scale.force_unit)
    return found


def _without_rounding(found: dict[str, Number]) -> dict[str, Number]:
    """The numbers of a curve and its slips, with 0 for a force that is round-off beside the largest of them, and for
    its error where that is no more."""
    forces = {name: found[name] for name in found if name.endswith(("_force", "_slip"))}
    least = ROUNDING * max((abs(one.value) for one in forces.values()), default=0.0)
    zero = {
        name: Number(0.0, one.error if (one.error or 0.0) >= least else 0.0, one.unit)
        for name, one in forces.items()
        if abs(one.value) < least
    }
    return found | zero


def _over_load(found: dict[str, Number], load: float) -> dict[str, Number]:
    """The forces of a curve over the load."""
    return {
        f"{name}_over_load": Number(found[name].value / load, (found[name].error or 0.0) / load, "")
        for name in ("last_force", "largest_force")
        if name in found
    }


def _of_slips(eq: Any, scale: Any) -> dict[str, Number]:
    """The last main slip that every replica has, or the first one, mean over the replicas."""
    slips = main_slips(eq.slips)
    last = int(max(np.bincount(slips.replica, minlength=len(eq.forces)).min() - 1, 0))
    found = dict[str, Number]()
    for name, own in (("before_slip", "force_before"), ("after_slip", "force_after")):
        value, off = slips.mean(own, last)
        found[name] = Number(value * scale.force, off * scale.force, scale.force_unit)
    return found


def is_rough(result: Any) -> bool:
    """Whether the contacts are those of a rough surface: another patch, step, threshold law or contact model changes
    its forces by some per cent at least, and K* by orders of magnitude."""
    return result.interface is not None and "area_fraction" in result.interface


def in_words(result: Any) -> list[str]:
    """Lines of a report on these numbers, of a rough surface to the digits that other readings of it may leave."""
    numbers, lines = numbers_of(result), list[str]()
    forces, springs = (3, 2) if is_rough(result) else (4, 4)

    each = [abs(numbers[name].value) for name in numbers if name.endswith(("_force", "_slip"))]

    def said(name: str) -> str:
        own, digits = numbers[name], springs if "spring" in name else forces
        error = own.error or 0.0
        # that of a force of 0 after a slip is seen beside the others
        if name.endswith(("_force", "_slip")) and error <= _SEEN * max(each):
            error = 0.0
        return with_uncertainty(own.value, error, own.unit, digits)

    def over_load(name: str) -> str:
        own = numbers.get(f"{name}_over_load")
        return "" if own is None else f" (µ = {written(own.value, '', own.error or 0.0)})"

    if "last_force" in numbers:
        at_end = f"{said('last_force')}{over_load('last_force')} at the end"
        most = f"at most {said('largest_force')}{over_load('largest_force')}"
        where = " at the path's points" * ("before_slip" in numbers)  # slips begin between them
        lines.append(f"force   {at_end}, {most}{where}")
    if "before_slip" in numbers:
        every = f", period {said('period')}" if "period" in numbers else ""
        lines.append(f"slip    from {said('before_slip')} to {said('after_slip')}, the last{every}")
    if (spring := numbers.get("critical_spring")) is not None:
        lines.append(
            f"spring  K* {'is not known' if spring.lost else '= ' + said('critical_spring')}"
        )
    for name, symbol in (("force", "F_k"), ("critical_spring", "K*")):
        if f"swept_{name}_least" in numbers:
            range_text = f"{said(f'swept_{name}_least')} to {said(f'swept_{name}_most')}"
            lines.append(f"sweep   {symbol} = {range_text}")
    return lines
