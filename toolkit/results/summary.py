"""The numbers of a run that one looks at first."""

from dataclasses import asdict
from typing import Any

import numpy as np

from toolkit.results.records import AgeingRecord, CoupledRecord, Result, SoftRecord
from toolkit.running.coupled import slips_beside


def summary(result: Result) -> dict[str, Any]:
    """The numbers of a run that one looks at first; lengths in the unit of the thresholds, times in seconds."""
    asked = result.asked
    content: dict[str, Any] = {
        "name": result.name,
        "title": result.title,
        "version": result.version,
        "unit": result.thresholds.unit,
        "mean_threshold": result.mean_threshold,
        "success": result.success,
    }
    if result.master is not None and asked.master is not None:
        content["master"] = {
            "tolerance": asked.master.tolerance,
            "force_error": float(result.master.force_error),
            "run_time": float(result.master.run_time),
            "success": bool(result.master.success),
            "message": result.master.message,
            "last_force": float(result.master.force[-1]),
        }
        if isinstance(result.master, SoftRecord):
            soft = result.master
            content["master"] |= {
                "verdict": soft.verdict,
                "reason": soft.reason,
                "slips": int(soft.slip_drive.size),
                "slip_drive_error": soft.slip_drive_error,
                "period": soft.period,
                "period_error": 2.0 * soft.slip_drive_error,
                "critical_spring": soft.critical_spring,
                "critical_spring_error": soft.critical_spring_error,
            }
        if isinstance(result.master, AgeingRecord):
            aged = result.master
            content["master"] |= {
                "largest_mass_defect": float(np.abs(aged.mass_defect).max()),
                "largest_positivity_defect": float(aged.positivity_defect.max()),
                "outrun": float(aged.outrun),
            }
    if result.eq is not None and asked.eq is not None:
        content["eq"] = {
            "contacts": asked.eq.contacts,
            "replicas": asked.eq.replicas,
            "seed": asked.eq.seed,
            "tolerance": asked.eq.tolerance,
            "followed": int(result.eq.contacts),
            "success": bool(result.eq.success),
            "message": result.eq.message,
            "largest_standard_error": float(np.max(result.eq.force_standard_error)),
            "largest_step_error": float(np.max(result.eq.step_error)),
            "run_time": float(result.eq.run_time),
            "compile_time": float(result.eq.compile_time),
            "breaks": int(result.eq.breaks),
            "breaks_per_rank": [int(breaks) for breaks in result.eq.breaks_per_rank],
            "last_force": float(result.eq.force[-1]),
        }
        if isinstance(result.eq, CoupledRecord):
            content["eq"] |= {
                "slip_fraction": float(result.eq.slip_fraction),
                "slips": int(result.eq.slip_number.size),
                "slips_beside": [slip._asdict() for slip in slips_beside(result)],
            }
    if result.sweep is not None:
        sweep = result.sweep
        content["sweep"] = {
            "along": list(sweep.along),
            "points": int(sweep.force.size),
            "largest_force_error": float(sweep.force_error.max()),
            "run_time": float(sweep.run_time),
            "success": bool(sweep.success),
            "message": sweep.message,
        }
        if sweep.critical_spring_error is not None:
            content["sweep"]["largest_critical_spring_error"] = float(
                sweep.critical_spring_error.max()
            )
    if result.interface is not None:
        content["interface"] = {name: asdict(number) for name, number in result.interface.items()}
    content["notes"] = list(result.notes)
    return content
