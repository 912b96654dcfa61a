"""The kinetic force along speeds, temperatures, rates of ageing and delays, in one call.

A delay does not change what happens between birth and break: with C the slider's travel from one to
the other, v tau its travel during the delay and F_0 the force without delay, F_k = F_0 C/(C + v tau).
So points that differ only in the delay share one steady state.
"""

import time
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from master.outcome import WELL, judged
from master.steady.steady import state_at
from master.steady.sums import SURE, is_summed, summed
from master.survival.make import steady_life
from origins import Ageing, Contacts, Delay, Thermal
from origins.brief import brief
from origins.contacts import LAWS, check_contacts
from origins.errors import InputError, between, non_negative, refuse
from origins.thresholds.law import Array


@dataclass(frozen=True)
class Along:
    """Answers at many points; all arrays have the shape to which the arguments broadcast.

    velocity : v, length per time.
    temperature, rate, delay : T = k_BT/<k> (a length squared), D (a length squared per time), tau_m (a time); None
        without such a law.
    run_time : s.
    success, message : whether each answer is within the tolerance; the accuracy reached, and the number of points that
        miss it.
    """

    velocity: Array
    temperature: Array | None
    rate: Array | None
    delay: Array | None
    run_time: float
    success: npt.NDArray[np.bool_]
    message: str

    __repr__ = brief


class Points:
    """The points at which to solve, of one `shape`; `rows`, of shape (n, 4), are their speeds, temperatures, rates
    and delays, 0 for a law that the contacts do not have."""

    def __init__(self, contacts: Contacts, **asked: npt.ArrayLike | None) -> None:
        """Check and broadcast velocity, temperature, rate and delay, in this order; None: the contacts' own."""
        self._began, self._contacts = time.perf_counter(), contacts
        # a rate law of the user's own has no temperature, and a named one need not have it
        own_temperature = getattr(contacts.thermal, "temperature", None)
        if asked["temperature"] is not None and own_temperature is None:
            hint = 'thermal = Thermal("soft", 0.1), or a rate law of your own at each temperature'
            raise InputError(f"temperature: these contacts have no law for it; give them {hint}")
        if asked["rate"] is not None and contacts.ageing is None:
            hint = "give them ageing = Ageing(final, rate)"
            raise InputError(f"rate: these contacts do not age; {hint}")
        own = {
            "temperature": own_temperature,
            "rate": contacts.ageing.rate if contacts.ageing else None,
            "delay": contacts.delay.time if contacts.delay else None,
        }
        given = asked | {name: own[name] for name in own if asked[name] is None}
        numbers = {k: _numbers(k, v) for k, v in given.items() if v is not None or k == "velocity"}
        try:
            arrays = dict(zip(numbers, np.broadcast_arrays(*numbers.values()), strict=True))
        except ValueError as error:
            shapes = ", ".join(f"{name} {value.shape}" for name, value in numbers.items())
            fault = f"{', '.join(numbers)}: have shapes that do not fit together: {shapes}"
            raise InputError(fault) from error
        self._fields: dict[str, Any] = dict.fromkeys(given) | arrays
        self.shape, none = arrays["velocity"].shape, np.zeros(arrays["velocity"].size)
        self.rows = np.stack([np.ravel(arrays.get(name, none)) for name in given], axis=1)

    def outcome(self, success: npt.NDArray[np.bool_], message: str) -> dict[str, Any]:
        """All fields of `Along`."""
        run_time = time.perf_counter() - self._began
        return {**self._fields, "run_time": run_time, "success": success, "message": message}

    def contacts(self, temperature: float, rate: float, delay: float = 0.0) -> Contacts:
        """The contacts at one temperature, rate and delay (0: none)."""
        thermal, ageing = self._contacts.thermal, self._contacts.ageing
        if isinstance(thermal, Thermal) and thermal.temperature is not None:
            thermal = replace(thermal, temperature=float(temperature)) if temperature else None
        if ageing is not None:
            ageing = Ageing(ageing.final, float(rate), ageing.closure)
        return self._contacts.replace(thermal=thermal, ageing=ageing, delay=Delay(float(delay)))


def _numbers(name: str, value: npt.ArrayLike | None) -> Array:
    """The value as an array; InputError unless all numbers are finite and in the argument's range."""
    try:
        numbers = np.array(value, dtype=float)
        ends = numbers.min(), numbers.max()
    except (TypeError, ValueError):
        refuse(name, value, "must be a number or an array of numbers, and must not be empty")
    check = partial(between, least=1e-100, most=1e100) if name == "velocity" else non_negative
    for number in ends:
        check(name, number)
    return numbers


@dataclass(frozen=True, repr=False)
class KineticCurve(Along):
    """Smooth sliding at many points; `success` where the force is known to a relative 1e-3.

    force : F_k/(N_c <k>), a length; its error is in units of the mean threshold.
    holding : fraction of the contacts that hold, C/(C + v tau_m).
    """

    force: Array
    force_error: Array
    holding: Array
    holding_error: Array


def kinetic_curve(
    contacts: Contacts,
    velocity: npt.ArrayLike = 1.0,
    *,
    temperature: npt.ArrayLike | None = None,
    rate: npt.ArrayLike | None = None,
    delay: npt.ArrayLike | None = None,
) -> KineticCurve:
    """F_k and the fraction that holds along v, T, D or tau_m, of contacts with any laws.

    contacts : with any laws that `steady_state` takes; the start does not matter.
    velocity : v > 0, length per time, a number or an array.
    temperature, rate, delay : numbers or arrays in place of the contacts' own: T >= 0 of their thermal law, D >= 0 of
        their ageing, tau_m >= 0 of their delay (they need not have one); 0 switches the law off; None: their own.
        Arrays broadcast: velocity[:, None] and temperature give a table.

    Contacts that break by heat alone (closure "exact") and re-form relaxed are summed at all speeds together; at T = 0
    all speeds have one answer; other points are solved individually.

    Raises InputError as `steady_state` does, for values that are not finite or too small, for shapes that do not
    broadcast, for a temperature or a rate of contacts without that law, and for speeds so low that squares of stretches
    at a break underflow.
    """
    check_contacts(contacts, "master.kinetic_curve", LAWS, own_rates=True)
    asked = {"velocity": velocity, "temperature": temperature, "rate": rate, "delay": delay}
    points = Points(contacts.replace(start=None), **asked)
    cases, which = np.unique(points.rows[:, :3], axis=0, return_inverse=True)
    steady = np.empty((4, len(cases)))
    for laws in np.unique(cases[:, 1:], axis=0):
        these = np.flatnonzero((cases[:, 1:] == laws).all(axis=1))
        steady[:, these] = _at_once(points.contacts(*laws), cases[these, 0])
    found = steady[:, which.ravel()].reshape(4, *points.shape)
    force, force_error, length, length_error = found
    # in addition to the delay new contacts may have to wait until they can hold
    out = contacts.replace(delay=None).waiting_time
    # a row's first is the speed, its last the delay
    speeds, waits = (points.rows[:, k].reshape(points.shape) for k in (0, 3))
    holding = length / (length + speeds * (waits + out))
    off = holding * (1.0 - holding) * length_error / length
    force, force_error = force * holding, force_error * holding + np.abs(force) * off
    return KineticCurve(
        **points.outcome(*judged("F_k", force_error / np.abs(force), WELL)),
        force=force,
        force_error=force_error / contacts.mean_threshold,
        holding=holding,
        holding_error=off + 4e-16,  # the round-off of the share that holds
    )


def _at_once(contacts: Contacts, speeds: Array) -> Array:
    """Force, its error, C and its error (lengths) at each speed without delay, shape (4, n)."""
    unit = contacts.mean_threshold
    found = np.full((4, speeds.size), np.nan)
    force, force_error, length, length_error = found
    if is_summed(contacts):
        sums = summed(contacts, speeds)
        length[:], length_error[:] = sums.length, sums.length_error
        force[:] = sums.area / length
        force_error[:] = (sums.area_error + force * length_error) / length
    # points not known well enough from these sums are solved individually, with one life
    rest = np.flatnonzero(~(force_error < SURE * force))
    life = steady_life(contacts, 1.0) if rest.size and contacts.changing is None else None
    solved = rest[:1] if life and life.timeless else rest  # at T = 0 the speed does not matter
    for i in solved:
        state = state_at(contacts, float(speeds[i]), life)
        force[i] = state.force / state.holding
        force_error[i] = state.force_error * unit / state.holding
        length[i], length_error[i] = state.cycle_length, state.cycle_length_error * unit
    found[:, rest] = found[:, solved]
    return found
