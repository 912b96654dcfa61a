"""What pulls a slider, and what is known of it before it is followed."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from origins.contacts import Contacts
from origins.errors import refuse
from toolkit.scene.drive import machine_number
from toolkit.scene.tables import DriveTable

RULES = ("reset", "reform-after", "instant")
# how the slip rules are named where a user reads of them
NAMED = {
    "reset": "a slip renews all contacts",
    "reform-after": "contacts re-form after the slip",
    "instant": "contacts re-form at once",
    "mass": "mass, damping and delay decide",
}
# points of a drive's path, and where a mass swings: of each swing, and of all
POINTS, PER_SWING, MOST_POINTS = 600, 16, 20_000


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

    def points(self, length: float) -> int:
        """At how many points of a drive's path of this length the trace is drawn. Where a mass swings each swing has
        PER_SWING of them, as fewer would draw slower swings that do not exist. A path that needs more than MOST_POINTS
        has the usual ones, which tell slips and no single swings."""
        swing = 2.0 * self.velocity * half_a_swing(self)
        needed = PER_SWING * length / (swing or np.inf)
        return round(max(needed, POINTS)) if needed <= MOST_POINTS else POINTS


def half_a_swing(machine: Machine) -> float:
    """π (M/K)^(1/2), the time of a slip in which no contact holds; 0 without a mass."""
    return float(np.pi * np.sqrt((machine.mass or 0.0) / machine.spring))


def critical_damping(machine: Machine) -> float:
    """2 (K M)^(1/2), above which mass and spring do not swing; 0 without a mass."""
    return float(2.0 * np.sqrt(machine.spring * (machine.mass or 0.0)))


def top_speed(machine: Machine, force: float) -> float:
    """The largest speed of a mass that this force of the spring, F/(N_c <k>), lets go where no contact holds."""
    part = machine.damping / critical_damping(machine)
    beyond = abs(1.0 - part**2) ** 0.5
    angle = (np.arccosh(part) if part > 1.0 else np.arccos(part)) / beyond if beyond else 1.0
    return float(force / np.sqrt(machine.spring * (machine.mass or 0.0)) * np.exp(-part * angle))


def slip_duration(machine: Machine, force: float) -> float:
    """How long a slip from this force takes in which no contact holds: half a damped swing, or beyond critical damping
    until the mass is as slow as the drive; without a mass 0."""
    if not machine.mass:
        return 0.0
    part = machine.damping / critical_damping(machine)
    frequency = np.sqrt(machine.spring / machine.mass)
    beyond = frequency * np.sqrt(abs(1.0 - part**2))
    if part < 1.0:
        return float(np.pi / beyond)
    slower, lasts = part * frequency - beyond, 1.0 / frequency
    fastest = force / machine.mass / machine.velocity  # speed over that of the drive, for each time
    for _ in range(50):  # to round-off, as only the logarithm of a time is on the right
        apart = -np.expm1(-2.0 * beyond * lasts) / (2.0 * beyond) if beyond else lasts
        lasts = max(np.log(fastest * apart) / slower, 1.0 / frequency)
    return float(lasts)


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
class RigidSlider:
    """What is known of a rigid slider on these contacts before a soft one is followed.

    static, kinetic : F_s/(N_c <k>) and F_k/(N_c <k>), lengths; kinetic_error : of the latter, a length
    critical_spring : K*/(N_c <k>), inf where every spring slips
    memory : the decoherence length (a length), over which F - F_k falls by e; inf where it does not
    contacts : their number on the area; None: not known
    """

    static: float
    kinetic: float
    kinetic_error: float
    critical_spring: float
    memory: float
    contacts: float | None = None


def rigid_slider(
    contacts: Contacts, steady: Any, propensity: Any, number: float | None
) -> RigidSlider:
    """What is known from the master equation's steady state and propensity; `number`: of contacts on the area."""
    return RigidSlider(
        static=propensity.static_to_kinetic * steady.force,
        kinetic=steady.force,
        kinetic_error=steady.force_error * contacts.mean_threshold,
        critical_spring=propensity.critical_spring,
        memory=propensity.decoherence_length,
        contacts=number,
    )
