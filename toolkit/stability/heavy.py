"""The spring's force on a slider with mass, by roads that the solvers have no part in.

Gaussian thresholds without laws have F in closed form, so that the motion is an ordinary differential equation; beside
other laws the slider is moved in small even steps of time, and its contacts as cohorts.
"""

from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import scipy

from origins.contacts import Contacts
from origins.drive import Drive
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.judge.closed_form import closed_form
from toolkit.stability.case import Truth
from toolkit.stability.cohorts import SteppedCohorts

_STEPS = (512, 1024, 2048)  # of the whole motion
_PARTS = 8  # nodes of the start, as those of so many steps between two points
_SAFETY = 3.0  # on the last change of the extrapolation
# part of what it changes in the finest steps: kinks at turns make it less regular
_BY_CHANCE = 0.1
_UNBROKEN = 1e-13  # share of contacts that may break on a way back, where none is let break
_DIGITS = 1e-11  # of the integrator, relative


class _Pulled(NamedTuple):
    """The drive as its places at times, both from the balance of the slider at rest on: X_T = F/K."""

    times: Array
    places: Array

    @classmethod
    def of(cls, drive: Drive, force: float) -> "_Pulled":
        places = np.append(force / (drive.spring or np.inf), drive.path)
        if drive.time is not None:
            return cls(np.append(0.0, drive.time), places)
        return cls(np.append(0.0, np.cumsum(np.abs(np.diff(places))) / drive.velocity), places)


def by_equation_of_motion(contacts: Contacts, path: Array, drive: Mapping[str, Any]) -> Truth:
    """F(X) of the rigid slider in closed form while X is farther than ever, and on ways back, which break no contact,
    N_c<k> times the way less than there; at one speed of a drive that goes forward.

    Nothing is said of points after a way back on which contacts may break. Raises InputError for contacts that have
    laws, are not Gaussian or do not start from one stretch from 0 on.
    """
    asked = Drive(path, **drive)
    pulled = _Pulled.of(asked, contacts.start.mean())
    single = contacts.start.is_single and contacts.start.mean() >= 0.0
    forward = asked.time is None and (np.diff(pulled.places) >= 0.0).all()
    if not single or contacts.laws or not forward:
        raise InputError("start: here of one stretch from 0 on, on a drive that goes forward")
    # in mean thresholds, and times in which the drive passes one
    unit = contacts.mean_threshold
    second = unit / asked.velocity
    room = float(contacts.thresholds.ppf(_UNBROKEN)) / unit
    spring, mass, damping = asked.spring or np.inf, asked.mass or np.nan, asked.damping / second
    mass /= second**2
    times, places = pulled.times / second, pulled.places / unit

    def rigid(x: float) -> float:
        return float(closed_form(contacts, np.array([x * unit]))[0][0]) / unit

    def push(t: float, y: Array, farthest: float | None) -> list[float]:
        """Speed and acceleration, ahead of all places so far or behind the farthest of them."""
        held = rigid(y[0]) if farthest is None else rigid(farthest) - (farthest - y[0])
        pull = spring * (places[0] + t - y[0])
        return [y[1], (pull - held - damping * y[1]) / mass]

    def passes(t: float, y: Array, farthest: float | None) -> float:
        if farthest is None:
            return float(y[1])
        return float(y[0]) - farthest if y[1] > 0.0 else -1.0

    def slowest(t: float, y: Array, farthest: float | None) -> float:
        return push(t, y, farthest)[1]

    passes.terminal, slowest.direction = True, 1.0  # type: ignore[attr-defined]
    x, state, now = np.full(times.size, np.nan), np.zeros(2), 0.0
    farthest: float | None = None
    while now < times[-1]:
        # the slider turns back as its speed falls to 0, and is ahead again as it passes the farthest place
        passes.direction = -1.0 if farthest is None else 1.0  # type: ignore[attr-defined]
        found = scipy.integrate.solve_ivp(
            *(push, (now, times[-1]), state, "DOP853"),
            events=[passes, slowest],
            args=(farthest,),
            dense_output=True,
            rtol=_DIGITS,
            atol=0.01 * _DIGITS * np.array([1.0, np.sqrt((1.0 + spring) / mass)]),
        )
        end, state = found.t[-1], found.y[:, -1].copy()
        # it may turn and go on within a step
        lowest = zip(found.t_events[1], found.y_events[1], strict=True)
        back = [t for t, (_, speed) in lowest if t > now and speed < 0.0]
        if farthest is None and back:
            before = found.t[found.t < back[0]][-1]
            end = float(scipy.optimize.brentq(partial(_speed, found.sol), before, back[0]))
            state = found.sol(end)
        if farthest is None:
            state[1] = 0.0
        if farthest is not None and found.y[0].min() < farthest - room:
            break
        inside = (times > now) & (times <= end)
        if inside.any():
            x[inside] = found.sol(times[inside])[0]
        farthest, now = (float(state[0]) if farthest is None else None), end
    values = spring * (places - x)[1:]
    error = np.where(np.isfinite(values), 1e-9 * (1.0 + spring), np.inf)
    return Truth(np.nan_to_num(values), error, "the equation of motion, with F in closed form")


def _speed(motion: Any, t: float) -> float:
    return float(motion(t)[1])


def by_steps(contacts: Contacts, path: Array, drive: Mapping[str, Any]) -> Truth:
    """In even steps of time by the velocity Verlet rule, contacts as cohorts, which may have the laws that these take;
    the error is estimated from two halvings of all steps."""
    found = [_in_steps(contacts, Drive(path, **drive), steps) for steps in _STEPS]
    rows = np.array(found) / contacts.mean_threshold
    before, last = (4.0 * rows[1:] - rows[:-1]) / 3.0
    # of all points so far: a slip that comes late is late for good
    error = np.maximum(_SAFETY * np.abs(last - before), _BY_CHANCE * np.abs(last - rows[-1]))
    error = np.maximum.accumulate(error) + 1e-12
    return Truth(last, error, "cohorts beside a mass in even steps, extrapolated")


def _in_steps(contacts: Contacts, drive: Drive, steps: int) -> Array:
    """The spring's force at the path's points, a length, by so many steps of the whole motion."""
    cohorts = SteppedCohorts(contacts, 0.0, 0.0, _PARTS)
    held = cohorts.force_at_first
    pulled = _Pulled.of(drive, held)
    spring, mass = drive.spring or np.inf, drive.mass or np.nan
    times = np.linspace(0.0, pulled.times[-1], steps + 1)
    drive_at = np.interp(times, *pulled)
    h, x, v = times[1], 0.0, 0.0
    pull, way = held, [0.0]
    for place, now in zip(drive_at[1:], times[1:], strict=True):
        v += 0.5 * h * (pull - held - drive.damping * v) / mass
        x += h * v
        held, pull = cohorts.move(x, float(now)), spring * (place - x)
        v += 0.5 * h * (pull - held) / mass
        v /= 1.0 + 0.5 * h * drive.damping / mass
        way.append(x)
    there = scipy.interpolate.CubicSpline(times, way)(pulled.times[1:])
    return np.asarray(spring * (pulled.places[1:] - there))
