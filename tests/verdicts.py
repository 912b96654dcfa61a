"""What tests of verdicts share: sliders as solvers tell them, and verdicts on these that follow none."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import master
from origins import Contacts, gaussian
from tests.scenes import said, write
from toolkit.scene.scale import Scale, scale_of
from toolkit.verdict.answers import Answer, Quantity, Verdict
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour, Finite, not_followed
from toolkit.verdict.text.words import page

MACHINE = {"spring": "1e6 N/m", "area": 1e-6, "velocity": 1e-6}
# contacts of which all numbers are stated
STATED = {
    "thresholds": {"kind": "gaussian", "mean": 4e-9, "std": 8e-10},
    "interface": {"mean_stiffness": 5.0, "contact_density": 5e11},
}
RESET = {"rules": ["reset"]}
# a slider on a spring far below K*, and its contacts
SOFT = Machine(spring=1e-4, mass=None, damping=0.0, velocity=1.0)
WIDE = Contacts(gaussian(1.0, 0.3))
LIGHT, HEAVY = Machine(1e-2, None, 0.0, 1.0), Machine(1e-2, 1e-4, 2e-4, 1.0)
NUMBER = Quantity(0.5, 1e-9)


def infinite(kind: str, slips: int) -> Behaviour:
    """What infinitely many contacts do under "reset"."""
    return Behaviour("reset", kind, 0.8, 0.5, None, slips, 0.0, True, "", 0.0)


def reading(
    *behaviours: Behaviour,
    contacts: Contacts = WIDE,
    machine: Machine | None = SOFT,
    kinetic: float | Quantity = 1.0,
    static: float | Quantity | None = None,
    spring: float | Quantity | None = None,
    scale: Scale | None = None,
    name: str = "own",
    **more: Any,
) -> Answer:
    """One reading with these sliders; numbers are known to 1e-9, and F_s and K* are as F_k where they are not given."""
    given = (kinetic if one is None else one for one in (kinetic, static, spring))
    numbers = (one if isinstance(one, Quantity) else Quantity(one, 1e-9) for one in given)
    scale = scale or scale_of(contacts, None)
    return Answer(name, contacts, scale, *numbers, machine, behaviours, **more)


def verdict_on(
    *readings: Answer,
    finite: tuple[Finite, ...] = (),
    other: Behaviour | None = None,
    velocity: float = 1.0,
) -> Verdict:
    """The verdict on these readings, of which the first is the scene's own; `other`: with another delay."""
    return Verdict("a", "a", velocity, readings, finite, {}, 1.0, other)


def text_of(found: Verdict) -> str:
    """Its page."""
    return "\n".join(page(found))


def slips(rule: str, **other: Any) -> Behaviour:
    """A slider that slips from 0.6, as far as its numbers go."""
    known: dict[str, Any] = {"kind": "stick-slip", "before": 0.6, "after": 0.0, "slips": 6}
    return replace(not_followed(rule, ""), **(known | {"success": True, "error": 1e-9} | other))


def told(
    *behaviours: Behaviour,
    kinetic: Quantity = NUMBER,
    machine: Machine = LIGHT,
    **more: Any,
) -> Verdict:
    """The verdict on thresholds 1 ± 0.3 with these sliders."""
    static, critical = (replace(kinetic, value=value) for value in (0.6, 0.44))
    given: Any = {"kinetic": kinetic, "static": static, "spring": critical, "machine": machine}
    return verdict_on(reading(*behaviours, contacts=WIDE.replace(**more), **given))


def rigid(contacts: Contacts) -> RigidSlider:
    """F_s, F_k, K* and the decoherence length of these contacts."""
    found, steady = master.propensity(contacts, 1e-6), master.steady_state(contacts)
    static = found.static_to_kinetic * steady.force
    springs = found.critical_spring, found.decoherence_length
    return RigidSlider(static, steady.force, 1e-9, *springs)


def raising(error: BaseException | type[BaseException]) -> Callable[..., Any]:
    """What raises this, whatever it is given: in place of a solver."""

    def raises(*_: Any, **__: Any) -> Any:
        raise error

    return raises


def judged(capsys: Any, **tables: Any) -> tuple[int, str, dict[str, Any]]:
    """Status, page and verdict.json of the command for a scene of these tables."""
    # so long that nothing hangs on the speed of the machine
    status, out, _ = said(capsys, "verdict", write(**({"master": None, "wall_time": 1e4} | tables)))
    return status, "\n".join(out), json.loads(Path("mine-output/verdict.json").read_text())
