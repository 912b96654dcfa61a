"""The scenes that are shipped, as the command runs them: the master equation and the sweep."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import master
from oracle.case import Answer, Case, few

KEPT_SPEEDS = 15  # of a sweep


def scene_cases() -> Iterator[Case]:
    """One case for the path of each scene, and one for its sweep."""
    from toolkit.scene.scene import load_scene, shipped_scenes

    for name in shipped_scenes():
        # asked without building the contacts, which takes seconds for islands and surfaces
        tables = scene_tables(name)
        if "master" in tables:
            yield Case(f"scene {name}", "scenes", lambda name=name: solved_scene(load_scene(name)))
        if "sweep" in tables:
            yield Case(
                f"scene {name}, sweep", "scenes", lambda name=name: swept_scene(load_scene(name))
            )


def scene_tables(name: str) -> dict[str, Any]:
    """The tables of a shipped scene's file."""
    import tomllib
    from importlib.resources import files

    file = files("toolkit").joinpath("scenes", f"{name}.toml")
    return tomllib.loads(file.read_text(encoding="utf-8"))


def solved_scene(scene: Any) -> Answer:
    """The force along the scene's drive; with a spring also where the drive stands at each slip."""
    drive, contacts = scene.drive, scene.contacts
    keywords: dict[str, Any] = {"velocity": drive.velocity, "time": drive.time}
    if drive.spring is not None:
        keywords |= {"spring": drive.spring, "slip": drive.slip}
    solution = master.solve(contacts, scene.path, scene.master.tolerance, **keywords)
    values = few(solution.force) / contacts.mean_threshold
    claims = np.full(values.size, solution.force_error)
    if drive.spring is not None:
        slips = solution.slips
        values = np.append(values, slips.drive / contacts.mean_threshold)
        claim = slips.drive_error / contacts.mean_threshold
        claims = np.append(claims, np.full(slips.drive.size, claim))
    return Answer(values, claims, solution.success)


def swept_scene(scene: Any) -> Answer:
    """The kinetic force over the sweep's table, at some of its speeds."""
    sweep, unit = scene.sweep, scene.contacts.mean_threshold
    curve = master.kinetic_curve(
        scene.contacts,
        sweep.velocity,
        temperature=sweep.temperature,
        rate=sweep.rate,
        delay=sweep.delay,
    )
    longest = int(np.argmax(curve.force.shape))
    force, error = (
        few(np.moveaxis(table, longest, 0), KEPT_SPEEDS).ravel()
        for table in (curve.force / unit, curve.force_error)
    )
    return Answer(force, error, bool(curve.success.all()))
