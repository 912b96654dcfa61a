"""A case of the oracle: one call of the public face, and what is kept of its answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import master
import origins

Array = npt.NDArray[np.float64]
MakeContacts = Callable[[], origins.Contacts]

KEPT_POINTS = 25  # of a path, ends included: enough to see any error that is not at one point alone


class Answer(NamedTuple):
    """Numbers, the errors claimed for them (one for all, or one each), and whether it succeeded.

    Lengths are in units of the mean threshold.
    """

    values: npt.ArrayLike
    claims: npt.ArrayLike
    success: bool


@dataclass(frozen=True)
class Case:
    """A call with a name of its own; cases of one `kind` are counted and timed together."""

    name: str
    kind: str
    answer: Callable[[], Answer]


def few(values: Array, points: int = KEPT_POINTS) -> Array:
    """At most so many of the values, evenly spaced, first and last included."""
    kept = np.unique(np.round(np.linspace(0, values.shape[0] - 1, points)).astype(int))
    return values[kept]


def along_turns(turns: npt.ArrayLike, points: int) -> Array:
    """A path through the turning points in turn, so many points in all, as many on each leg."""
    corners = np.asarray(turns, float)
    return np.interp(np.linspace(0, corners.size - 1, points), np.arange(corners.size), corners)


def force_along(
    make: MakeContacts, path: npt.ArrayLike, tolerance: float = 1e-6, **drive: Any
) -> Callable[[], Answer]:
    """master.solve along the path; `drive` are its other keywords."""

    def answer() -> Answer:
        contacts = make()
        solution = master.solve(contacts, path, tolerance, **drive)
        values = few(solution.force) / contacts.mean_threshold
        return Answer(values, solution.force_error, solution.success)

    return answer


def holding_along(
    make: MakeContacts, path: npt.ArrayLike, tolerance: float = 1e-6, **drive: Any
) -> Callable[[], Answer]:
    """What fraction of the contacts holds along the path.

    The holding fraction has no error of its own. It is known as well as the force.
    """

    def answer() -> Answer:
        solution = master.solve(make(), path, tolerance, **drive)
        return Answer(few(solution.holding), solution.force_error, solution.success)

    return answer


def steady_force(make: MakeContacts, velocity: float = 1.0) -> Callable[[], Answer]:
    """master.steady_state: the kinetic force, the cycle length and the fraction that holds.

    The state in the paper's closure of ageing tells the force alone and has no `success`.
    """

    def answer() -> Answer:
        contacts = make()
        state = master.steady_state(contacts, velocity=velocity)
        if not hasattr(state, "cycle_length"):
            return Answer(state.force / contacts.mean_threshold, state.force_error, True)
        unit = state.mean_threshold
        values = [state.force / unit, state.cycle_length / unit, state.holding]
        length = state.cycle_length / unit
        holding_error = (1 - state.holding) * state.cycle_length_error / length
        claims = [state.force_error, state.cycle_length_error, holding_error + 1e-12]
        return Answer(values, claims, state.success)

    return answer


def propensity(
    make: MakeContacts, velocity: float = 1.0, tolerance: float = 1e-8
) -> Callable[[], Answer]:
    """master.propensity: K*, F_s/F_k, X* and the onset power of P_c."""

    def answer() -> Answer:
        contacts = make()
        unit = contacts.mean_threshold
        found = master.propensity(contacts, tolerance, velocity=velocity)
        names = ("critical_spring", "static_to_kinetic", "decoherence_length", "onset_power")
        scales = np.array([1.0, 1.0, unit, 1.0])
        values = np.array([getattr(found, name) for name in names]) / scales
        claims = np.array([getattr(found, f"{name}_error") for name in names]) / scales
        return Answer(values, claims, found.success)

    return answer
