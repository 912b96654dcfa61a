"""Growing thresholds of a law of one's own in the ensemble: calls of its methods in plain Python, some 1 ms a break.

What identifies a contact for life, its goal, is its hazard, see origins.GrowingThresholds. Kernels know the law by
addresses of functions alone, so that one compiled kernel, which is kept on disk, serves all laws.
"""

from collections.abc import Callable
from ctypes import CFUNCTYPE, c_double, c_void_p, cast
from typing import Any, NamedTuple

import numba.experimental.function_type  # noqa: F401 - numba then takes an Address as an argument
import numpy as np
from numba import cfunc, float64
from numba.core.types import WrapperAddressProtocol
from numba.extending import is_jitted
from scipy.optimize import brentq

from eq_model.compiling import real
from eq_model.laws.growing import GROWTHS, Growth
from eq_model.whole_drive import WholeDrive
from origins import Contacts, GrowingThresholds
from origins.thresholds.law import Array

SECONDS = 1e-4  # of a break, see settings.KERNELS
# Accuracy of the stretch at which a contact breaks, in mean thresholds: the ensemble's error of the force is larger.
ACCURACY = 1e-9


class Address(WrapperAddressProtocol):
    """A function of numbers, of Python or compiled by numba.njit, which kernels may call."""

    def __init__(self, function: Callable[..., Any], count: int) -> None:
        function(*[1.0] * count)  # kernels cannot pass on errors of the law, so they show here
        self._signature = float64(*[float64] * count)
        if is_jitted(function):
            self._callback = cfunc(self._signature)(function.py_func).ctypes
        else:
            types = CFUNCTYPE(c_double, *[c_double] * count)
            self._callback = types(lambda *given: float(function(*given)))

    def __wrapper_address__(self) -> Any:
        """Where the function is; see numba."""
        return cast(self._callback, c_void_p).value

    def signature(self) -> Any:
        """Its types; see numba."""
        return self._signature


class Called(NamedTuple):
    """Growth of thresholds by functions of the law, in its units; see growing.Growth."""

    time: float
    age: float
    goal: Any  # (threshold): of a contact of the start with it, and of one that forms in its place
    lost: Any  # (speed)
    meeting: Any  # (near, speed, room, age, goal): way until the contact breaks; inf if longer than `room`
    threshold: Any  # (goal, age)
    warm: bool
    rates: Any
    unit: float


def make(contacts: Contacts, drive: WholeDrive, *heat: Any) -> Called:
    """The growth of these contacts; see settings.KERNELS."""
    law = contacts.growing
    assert law is not None
    accuracy = max(ACCURACY * contacts.mean_threshold, 0.25 * drive.unit)

    def goal(at_start: float) -> float:
        return float(law.hazard_at(at_start, law.start_pinned_for))

    def meeting(near: float, speed: float, room: float, age: float, goal: float) -> float:
        def missing(distance: float) -> float:
            return float(law.threshold_at(goal, age + distance / speed)) - near - distance

        return _first_root(missing, room, accuracy)

    age, lost = law.start_pinned_for / law.time_unit, law.lost_hazard
    called = Address(meeting, 5), Address(law.threshold_at, 2)
    return Called(law.time_unit, age, Address(goal, 1), Address(lost, 1), *called, *heat)


def _first_root(missing: Callable[[float], float], room: float, accuracy: float) -> float:
    """The way at which what is missing is 0, inf if that is beyond `room`. As thresholds do not fall, a contact breaks
    no earlier than after what is missing now."""
    low, least = 0.0, missing(0.0)
    while least > accuracy:
        if not low + least <= room:
            return np.inf
        high = min(low + 2.0 * least, room)
        if (later := missing(high)) <= 0.0:
            return float(brentq(missing, low, high, xtol=accuracy))
        if high == room:
            return np.inf
        low, least = high, later
    return low


def often(contacts: Contacts, lasts: Array, moved: Array, law: Called) -> float:
    """How often a contact breaks, or pins where thresholds begin at 0, at most; see settings.KERNELS."""
    growing: GrowingThresholds | None = contacts.growing
    assert growing is not None
    pins = lasts.sum() / max(growing.first_pinning_time, law.time) if growing.begins_at_0 else 0.0
    return float(max(moved.sum() / contacts.mean_threshold, pins))


def _born(law, contact):  # type: ignore[no-untyped-def]
    """Contacts of the start and later ones have thresholds of one law at the same age."""
    goal = law.goal(real(contact.threshold) * law.unit)
    return 0.0 if contact.fresh else law.age, goal


def _meeting(law, near, pace, room, age, goal):  # type: ignore[no-untyped-def]
    unit = law.unit
    speed = unit / (pace * law.time)
    return law.meeting(near * unit, speed, room * unit, age * law.time, goal) / unit


GROWTHS[Called] = Growth(
    _born,
    lost=lambda law, pace: law.lost(law.unit / (pace * law.time)),
    meeting=_meeting,
    threshold=lambda law, goal, age: law.threshold(goal, age * law.time) / law.unit,
)
