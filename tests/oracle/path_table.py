"""Every law of a contact on every kind of drive: one case for each cell of that table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

import origins
from oracle.case import (
    Array,
    Case,
    MakeContacts,
    along_turns,
    force_along,
    holding_along,
    propensity,
    steady_force,
)
from oracle.warm_families import slide_hold_slide


@dataclass(frozen=True)
class Row:
    """Contacts of one law, and the tolerances that they are asked to."""

    make: MakeContacts
    forward: float = 1e-8
    path: float = 1e-5
    spring: float = 1e-3
    stiffness: float = 0.2  # K/(N_c<k>): below K* of nearly all rows, so that the slider slips
    only_forward: float | None = None  # the end of the path where contacts are taken there alone


@dataclass(frozen=True)
class Drive:
    """Positions of the slider or of the spring's other end, and the other keywords of solve."""

    path: Array
    keywords: dict[str, Any] = field(default_factory=dict)


def path_table_cases() -> Iterator[Case]:
    """All rows on all drives; those of a rigid slider first."""
    rows = law_rows()
    for law, row in rows.items():
        yield Case(f"table steady {law}", "table steady", steady_force(row.make))
        forward = np.linspace(0.0, row.only_forward or 4.0, 81)
        answer = force_along(row.make, forward, row.forward, velocity=0.7)
        yield Case(f"table forward {law}", "table forward", answer)
        if row.only_forward:
            continue
        yield Case(f"table propensity {law}", "table steady", propensity(row.make, tolerance=1e-6))
        for name, drive in rigid_drives().items():
            answer = force_along(row.make, drive.path, row.path, **drive.keywords)
            yield Case(f"table {name}: {law}", "table path", answer)
        for name, drive in soft_drives(all_drives=" and " not in law).items():
            keywords = {"spring": row.stiffness} | drive.keywords
            answer = force_along(row.make, drive.path, row.spring, **keywords)
            yield Case(f"table {name}: {law}", "table soft", answer)
    for law in ("delay", "delay and linked", "heat and delay", "grains"):
        for name, drive in rigid_drives().items():
            answer = holding_along(rows[law].make, drive.path, rows[law].path, **drive.keywords)
            yield Case(f"table holding, {name}: {law}", "table path", answer)


def rigid_drives() -> dict[str, Drive]:
    """Turns at one speed, turns in their own time, velocity steps without turns, a hold."""
    loop = along_turns([0.0, 1.6, -0.7, 1.2], 61)
    forward = np.linspace(0.0, 3.0, 61)
    steps = np.interp(forward, [0.0, 0.75, 1.5, 2.25, 3.0], [0.0, 0.5, 5.0, 5.5, 10.0])
    place, time = slide_hold_slide(20.0)
    return {
        "turns": Drive(loop),
        "turns in time": Drive(loop, {"time": along_turns([0.0, 1.0, 6.0, 7.0], 61)}),
        "velocity steps": Drive(forward, {"time": steps}),
        "hold": Drive(place, {"time": time}),
    }


def soft_drives(all_drives: bool) -> dict[str, Drive]:
    """Each slip rule forward, a drive that turns, one that rests, and a stiff spring.

    Contacts with two laws take seconds to minutes on each, and are asked on the first two alone.
    """
    forward = np.linspace(0.0, 5.0, 51)
    back = along_turns([0.0, 4.0, 1.0, 3.0], 61)
    rest = along_turns([0.0, 3.0, 3.0, 5.0], 61)
    # the drive begins where it balances the start, and has come to 0 by the first of these times
    time = along_turns([0.4, 3.4, 8.4, 10.4], 61)
    first = {
        "spring, reset": Drive(forward, {"slip": "reset"}),
        "stiff spring": Drive(np.linspace(0.0, 3.0, 31), {"spring": 30.0}),
    }
    if not all_drives:
        return first
    return first | {
        "spring, reform-after": Drive(forward, {"slip": "reform-after"}),
        "spring, instant": Drive(forward, {"slip": "instant"}),
        "spring, turns": Drive(back),
        "spring, rest": Drive(rest, {"time": time}),
    }


def law_rows() -> dict[str, Row]:
    """Contacts with each law of a contact, and with those that are taken together."""
    return {**cold_rows(), **warm_rows(), **ageing_rows(), **grain_rows()}


def cold_rows() -> dict[str, Row]:
    """Contacts at T = 0 whose thresholds are Gaussian, 1 with a width of 0.2."""
    law = origins.gaussian(mean=1.0, std=0.2)
    wait = origins.Delay(time=0.3)
    spread = origins.gaussian_start(mean=0.05, std=0.03)

    def row(**laws: Any) -> Row:
        return Row(partial(origins.Contacts, law, **laws))

    return {
        "none": Row(partial(origins.Contacts, law), path=1e-8, spring=1e-6),
        "start": Row(partial(origins.Contacts, law, spread), path=1e-8, spring=1e-6),
        "delay": row(delay=wait),
        "delay and start": row(delay=wait, start=spread),
        "re-forming at one stretch": row(reforming=0.1),
        "re-forming behind": row(reforming=-0.1),
        "re-forming at many stretches": row(reforming=spread),
        "Boltzmann re-forming": row(reforming=origins.boltzmann_reforming(0.01)),
        "linked": row(stiffness="linked"),
        "delay and linked": row(delay=wait, stiffness="linked"),
        "delay and re-forming": row(delay=wait, reforming=0.1),
    }


def warm_rows() -> dict[str, Row]:
    """Contacts with temperature in both closures, and with a second law beside it."""
    law = origins.gaussian(mean=1.0, std=0.2)
    soft = origins.Thermal("soft", temperature=0.05)
    stiff = origins.Thermal("stiff", temperature=0.05)

    def row(thermal: origins.Thermal, thresholds: object = law, **laws: Any) -> Row:
        make = partial(origins.Contacts, thresholds, thermal=thermal, **laws)
        return Row(make, forward=1e-7, stiffness=0.1)

    def rate(name: str, temperature: float, attempts: float, closure: str) -> origins.Thermal:
        return origins.Thermal(name, temperature, attempts, closure)

    return {
        "soft": row(soft),
        "soft, paper's closure": row(rate("soft", 0.05, 1.0, "paper")),
        "stiff": row(stiff),
        "stiff, paper's closure": row(rate("stiff", 0.05, 1.0, "paper")),
        "soft, hot": row(rate("soft", 0.5, 3.0, "exact")),
        "soft, cold": row(rate("soft", 1e-3, 1e3, "exact")),
        "stiff, cold": row(rate("stiff", 1e-3, 1e3, "exact")),
        "soft, with a jump": row(soft, origins.rectangular(0.5, 1.5)),
        "soft, with an exact value": row(
            soft, origins.mixture([origins.identical(0.8), law], [0.3, 0.7])
        ),
        "soft and start": row(soft, start=origins.gaussian_start(mean=0.1, std=0.03)),
        "stiff and start": row(stiff, start=origins.gaussian_start(mean=0.1, std=0.03)),
        "heat and delay": row(soft, delay=origins.Delay(time=0.3)),
        "heat and re-forming": row(soft, reforming=0.1),
        "heat and linked": row(soft, stiffness="linked"),
    }


def ageing_rows() -> dict[str, Row]:
    """Thresholds that diffuse: Gaussian finals, others, with heat, and the paper's closure."""
    young = origins.gaussian(mean=0.6, std=0.08)
    old = origins.gaussian(mean=1.0, std=0.05)

    def row(final: object, closure: str = "exact", **laws: Any) -> Row:
        ageing = origins.Ageing(final=final, rate=1e-3, closure=closure)
        make = partial(origins.Contacts, young, ageing=ageing, **laws)
        if closure == "paper":
            # further on contacts outrun the thresholds of this closure
            return Row(make, forward=2e-3, only_forward=0.6)
        return Row(make, forward=1e-6, path=1e-3, spring=1e-2)

    return {
        "ageing": row(old),
        "ageing and start": row(old, start=origins.gaussian_start(mean=0.05, std=0.02)),
        "ageing to a law that is not Gaussian": row(origins.persson(1.0, 0.4)),
        "ageing and heat": row(old, thermal=origins.Thermal("soft", 0.02)),
        "ageing and delay": row(old, delay=origins.Delay(time=0.2)),
        "ageing, paper's closure": row(
            old, "paper", start=origins.gaussian_start(mean=0.1, std=0.025)
        ),
    }


def grain_rows() -> dict[str, Row]:
    """Grains that grow, cold and warm."""
    growing = origins.growing_grains(1.0, 1.0, age=4.0)

    def row(**laws: Any) -> Row:
        path = 1e-2 if "thermal" in laws else 1e-3
        return Row(partial(origins.Contacts, growing, **laws), 1e-6, path, 1e-2)

    return {
        "grains": row(),
        "grains and start": row(start=0.1),
        "grains and delay": row(delay=origins.Delay(time=0.1)),
        "grains, soft": row(thermal=origins.Thermal("soft", 0.1)),
        "grains, stiff": row(thermal=origins.Thermal("stiff", 0.1)),
    }
