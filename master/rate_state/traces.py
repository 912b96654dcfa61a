"""Solved answers of a rigid slider to steps of its speed, and what rests give."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from master.solve import solve
from master.steady.kinetic import kinetic_curve
from origins import Contacts
from origins.brief import brief
from origins.thresholds.law import Array

# lives of a contact, sliding from relaxed ones, after which the force may be steady: tried one after the other
LIVES = (8.0, 24.0, 72.0)
# of the largest change of force in an answer: what may be left of it before a step and at its end
SETTLED = 2e-3
# the tolerance of contacts with heat whose thresholds grow: 1e-4 takes three times as long
SLOW_TOLERANCE = 1e-3
# of the tolerance: what may be left of the start before a step
OF_TOLERANCE = 0.03
# of a life: what is left of a start goes up and down with about that period, and is looked at so often
FINE = 0.05
# slips at which an answer is known, in lives: so many even in ln(slip), as heat may act over 1e-6 of a
# threshold, and beside them even ones, over which contacts break in turn, to the end, as what is left swings about
# once in a life
LEAST_SLIP, POINTS, EVEN_STEP = 1e-7, 160, 0.02


@dataclass(frozen=True)
class VelocityStep:
    """A step of the speed in steady sliding; forces F/(N_c <k>) and slips are lengths.

    before, after : speeds, length per time
    steady_before, steady_after : F_k at these
    slip : since the step, shape (n,), from 0; force : shape (n,)
    error : of the forces, absolute; it includes what is left of the start, and of the step at its end
    settled : whether little is left of these
    """

    before: float
    after: float
    steady_before: float
    steady_after: float
    slip: Array
    force: Array
    error: float
    settled: bool

    __repr__ = brief

    @property
    def log_ratio(self) -> float:
        """ln of the speed after the step over that before."""
        return float(np.log(self.after / self.before))

    @property
    def slope(self) -> float:
        """a - b, the change of F_k for each factor e between both speeds."""
        return (self.steady_after - self.steady_before) / self.log_ratio

    @property
    def response(self) -> Array:
        """Change of the force since the step for each factor e of the speed, shape (n,): rises to a, ends at a - b."""
        return (self.force - self.steady_before) / self.log_ratio


@dataclass(frozen=True)
class Rest:
    """What a rest in steady sliding does; forces F/(N_c <k>) and slips are lengths.

    time : at rest; relaxed : the force at its end; peak : the largest force on the way on at the speed before the rest,
    at the slip `peak_slip` since; error : of both forces, absolute
    """

    time: float
    relaxed: float
    peak: float
    peak_slip: float
    error: float
    success: bool


def steps_about(
    contacts: Contacts, velocity: float, ratio: float, tolerance: float
) -> tuple[VelocityStep, VelocityStep]:
    """A step up by the factor `ratio`, and one down again, between speeds whose geometric mean is the velocity.

    tolerance : of forces, in mean thresholds
    """
    mean = contacts.mean_threshold
    slow, fast = velocity * ratio**-0.5, velocity * ratio**0.5
    curve = kinetic_curve(contacts, [slow, fast])
    steady = dict(zip((slow, fast), map(float, curve.force), strict=True))
    approach = approach_of(contacts, slow, steady[slow], OF_TOLERANCE * tolerance * mean)
    life, begin = approach.life, approach.slip
    last = begin + life * np.arange(-1.0, 0.0, FINE)
    even = life * np.arange(0.0, begin / life - 0.5 * EVEN_STEP, EVEN_STEP)
    even = np.r_[even, last[last > even[-1] + 0.5 * EVEN_STEP * life]]
    slip = np.union1d(even, np.geomspace(LEAST_SLIP * life, begin, POINTS))
    path = np.r_[0.0, last, begin + slip, begin + slip[-1] + slip[1:]]
    arrival = np.r_[0.0, last / slow, begin / slow + slip / fast]
    arrival = np.r_[arrival, arrival[-1] + slip[1:] / slow]
    solved = solve(contacts, path, tolerance, time=arrival)
    start, force = solved.force[1 : last.size + 1], solved.force[last.size + 1 :]
    up, down = force[: slip.size], force[slip.size - 1 :]
    ended = slip >= slip[-1] - life
    remaining = max(
        float(np.abs(some - steady[speed]).max())
        for some, speed in ((start, slow), (up[ended], fast), (down[ended], slow))
    )
    change = min(float(np.ptp(up)), float(np.ptp(down)))
    # below the solver's own error nothing more is known
    least = max(SETTLED * change, float(solved.force_error) * mean)
    settled = bool(solved.success and remaining <= least)
    error = (solved.force_error + float(np.max(curve.force_error))) * mean + remaining

    def step(before: float, after: float, force: Array) -> VelocityStep:
        return VelocityStep(
            before, after, steady[before], steady[after], slip, force, error, settled
        )

    return step(slow, fast, up), step(fast, slow, down)


class Approach(NamedTuple):
    """The slip from relaxed contacts to steady sliding, and the travel of a contact to its break, about; lengths."""

    slip: float
    life: float


def approach_of(contacts: Contacts, velocity: float, steady: float, most: float) -> Approach:
    """How far contacts slide at one speed until F stays nearer to the `steady` force than `most`, or through the last
    of LIVES."""
    # contacts travel to twice their mean stretch or less; those whose thresholds grow farther than <x_s>
    life = max(contacts.mean_threshold, 2.0 * steady)
    for lives in LIVES:
        slid = life * np.arange(0.0, lives, FINE)
        accuracy = most / contacts.mean_threshold
        force = solve(contacts, slid, accuracy, velocity=velocity).force
        off = np.flatnonzero(np.abs(force - steady) > most)
        settled_at = life + (float(slid[off[-1]]) if off.size else 0.0)
        if settled_at <= slid[-1]:
            return Approach(settled_at, life)
    return Approach(LIVES[-1] * life, life)


def is_slow(contacts: Contacts) -> bool:
    """Whether a velocity step takes half a minute, as each survival is an integral over thresholds and times."""
    return contacts.thermal is not None and contacts.growing is not None
