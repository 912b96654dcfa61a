"""One contact as kernels have it, and the law by which it breaks, found by the type of its settings."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from eq_model.streams import Stream


class Contact(NamedTuple):
    """One that holds at a stretch (whole) at a moment of the clock."""

    clock: np.int64
    leg: np.int64
    stretch: np.int64
    threshold: np.int64
    exposure: float  # ln of the integral of its rate that it bears
    stiffness: float  # over the mean one
    fresh: bool  # is not one of those at X = 0
    lane: np.int64
    drawn: np.int64  # steps that its lane has drawn words for
    stream: Stream


class Break(NamedTuple):
    """Where a contact breaks; a clock beyond the drive's end where it holds so long."""

    clock: np.int64
    leg: np.int64
    drawn: np.int64
    held: bool  # False of one that did not hold at all


LIVES: dict[type, Callable[..., Any]] = {}
LOOKS: dict[type, Callable[..., Any]] = {}


def life(law, contact, course, watch, counts):  # type: ignore[no-untyped-def]
    """The break of a contact, by the type of its law."""
    raise NotImplementedError


def look(law, contact, course, born, broken, birth, watch, counts):  # type: ignore[no-untyped-def]
    """Count a contact at watched points, as of watch.look."""
    raise NotImplementedError


# as compiling.bare, and as a part of the loop
OPTIONS: Any = {"nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": True}


@overload(life, jit_options=OPTIONS)
def _life(law, contact, course, watch, counts):  # type: ignore[no-untyped-def]
    return LIVES[law.instance_class]


@overload(look, jit_options=OPTIONS)
def _look(law, contact, course, born, broken, birth, watch, counts):  # type: ignore[no-untyped-def]
    return LOOKS[law.instance_class]
