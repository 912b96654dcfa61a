"""Energies of sliders in steps of time, and their errors by what they change as steps are halved."""

import numpy as np

from master.soft.followed import total
from master.soft.inertia.energy_errors import UNKNOWN, EnergyError, Unseen, Ways, energy_errors
from master.soft.inertia.in_time.answer import SAFETY, HeavyAnswer, error_by
from master.soft.inertia.in_time.clocks import COLUMNS
from master.soft.inertia.in_time.slider import HeavySlider
from origins.drive import Drive
from origins.energy import Energy
from origins.thresholds.law import Array


def energies_told(
    found: HeavyAnswer, last: HeavySlider, drive: Drive, balance: float, force: Array
) -> tuple[Energy, EnergyError]:
    """Energies at the points of the path and their errors; `last`: of the sliders, `force`: of the spring (lengths)."""
    columns, mass, spring = found.columns, float(drive.mass or 0.0), last.spring
    stored, unit = columns["stored"], last.contacts.unit
    stored_first = last.sections[0][0].stored
    told = Energy(
        drive=columns["work"],
        spring=0.5 * force**2 / spring,
        contacts=stored,
        kinetic=0.5 * mass * columns["speed"] ** 2,
        damped=columns["damped"],
        released=columns["on_contacts"] - (stored - stored_first),
        start=0.5 * spring * balance**2 + stored_first,
    )
    if not np.isfinite(found.changes).all():
        return told, UNKNOWN
    safety = max(last.contacts.memory.safety, SAFETY)
    off = {name: error_by(found.changes[:, k], safety) for k, name in enumerate(COLUMNS)}
    of_speed = off["speed"] * (
        float(np.abs(columns["speed"]).max(initial=0.0)) + 0.5 * off["speed"]
    )
    changes = {
        "drive": off["work"],
        "spring": 0.0,  # as the error of the force says
        "contacts": off["stored"],
        "kinetic": mass * of_speed,
        "damped": off["damped"],
        "released": off["on_contacts"] + off["stored"],
    }
    slips, beside = found.slips, found.beside
    slid = slips.after - slips.drive + slips.force_before / spring
    path, forces = np.append(balance, drive.path), np.append(force, slips.force_before)
    ways = Ways.of(path, slid, spring, forces, unit)
    of_force, more = found.error_of_force_and_load * unit, beside.force.size * unit
    unseen = Unseen(
        of_force,
        of_force + more,
        of_contacts=total(found.parts[1:]) * unit,
        by_time=ways.largest * ways.per_spring * more,
        at_begin=beside.contact_force * unit**2,
    )
    return told, energy_errors(changes, told, unseen, ways)
