"""The numbers of a run that one looks at first."""

from dataclasses import asdict
from typing import Any

import numpy as np

from toolkit.results.records import AgeingRecord, Result, SoftRecord, is_coupled
from toolkit.results.slips import slips_beside


def summary(result: Result) -> dict[str, Any]:
    """The numbers of a run that one looks at first; lengths in the unit of the thresholds, times in seconds."""
    asked, solved, eq, sweep = result.asked, result.master, result.eq, result.sweep
    content = _of(result, "name title version mean_threshold success")
    content["unit"] = result.thresholds.unit
    if solved is not None and asked.master is not None:
        own = _of(solved, "force_error run_time success message")
        own |= {"tolerance": asked.master.tolerance, "last_force": float(solved.force[-1])}
        if isinstance(solved, SoftRecord):
            error = float(solved.slips.drive_error)
            own |= _of(solved.regime, "verdict reason critical_spring critical_spring_error slips")
            own |= {"slip_drive_error": error, "period": float(solved.period)}
            own["period_error"] = 2.0 * error
        if isinstance(solved, AgeingRecord):
            own["largest_mass_defect"] = float(np.abs(solved.mass_defect).max())
            own["largest_positivity_defect"] = float(solved.positivity_defect.max())
            own["outrun"] = float(solved.outrun)
        content["master"] = own
    if eq is not None and asked.eq is not None:
        own = _of(asked.eq, "contacts replicas seed tolerance")
        own |= _of(eq, "success message run_time compile_time breaks")
        own["followed"] = int(eq.contacts)
        own["largest_standard_error"] = float(np.max(eq.force_standard_error))
        own["largest_step_error"] = float(np.max(eq.step_error))
        own["breaks_per_rank"] = [int(breaks) for breaks in eq.breaks_per_rank]
        own["last_force"] = float(eq.force[-1])
        if is_coupled(eq):
            own["slip_fraction"], own["slips"] = float(eq.slip_fraction), eq.slips.number.size
            own["slips_beside"] = [slip._asdict() for slip in slips_beside(result)]
        content["eq"] = own
    if sweep is not None:
        own = _of(sweep, "run_time success message")
        own |= {"along": list(sweep.along), "points": sweep.force.size}
        own["largest_force_error"] = float(sweep.force_error.max())
        if sweep.critical_spring_error is not None:
            own["largest_critical_spring_error"] = float(sweep.critical_spring_error.max())
        content["sweep"] = own
    if result.interface is not None:
        content["interface"] = {name: asdict(number) for name, number in result.interface.items()}
    return content | {"notes": list(result.notes)}


def _of(answer: object, names: str) -> dict[str, Any]:
    """Some fields, as JSON knows numbers."""
    values = {name: getattr(answer, name) for name in names.split()}
    return {
        name: value.item() if isinstance(value, np.generic) else value
        for name, value in values.items()
    }
