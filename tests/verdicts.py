"""What tests of verdicts share: sliders as solvers tell them, and verdicts on these that follow none."""

from typing import Any

from origins import Contacts, gaussian
from toolkit.scene.scale import Scale, scale_of
from toolkit.verdict.answers import Answer, Quantity, Verdict
from toolkit.verdict.sliders.machine import Machine
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.text.words import page

# a slider on a spring far below K*, and its contacts
SOFT = Machine(spring=1e-4, mass=None, damping=0.0, velocity=1.0)
WIDE = Contacts(gaussian(1.0, 0.3))


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


def verdict(
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
