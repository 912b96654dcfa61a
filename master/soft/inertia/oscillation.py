"""The closed motion of a slider whose contacts all hold: a damped oscillator under a drive of one speed."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from master.outcome import StoppedError
from master.soft.inertia.body import RINGS
from master.soft.inertia.record import Spent
from origins.thresholds.law import Array

# Points a period at which crossings are looked for, and what a peak between them may rise above them, in amplitudes.
SAMPLES, BETWEEN = 24, 0.02
# Least distance of the two roots, in their mean: closer ones would lose digits, and at critical damping they are kept
# apart by that much.
APART = 1e-4
# Most periods that are looked through at once.
AT_ONCE = 64
# Accuracy of the times from which on, or up to which, a level is within reach, in steps between samples.
OF_LIMIT = 1e-3
# Accuracies of a peak and of a crossing, in periods, and relative; rounding of a level, relative.
OF_PEAK, OF_CROSSING, RELATIVE, ROUNDING = 1e-14, 1e-15, 1e-14, 1e-15
# Exponents below which e^z - 1 is taken by its first two terms, as the integral divides by the rate, possibly 0.
SMALL = 1e-8

# Most periods that are looked through for one crossing, some 3 s: a level within reach is reached in the next ones, but
# where rounding decides.
MOST_PERIODS = 10_000


class Pulled(NamedTuple):
    """What pulls on a slider with damping: its spring, K, the drive's speed, and the spring's force (a length) at t = 0
    and y = 0."""

    spring: float
    damping: float
    drive_speed: float
    force: float


class Held(NamedTuple):
    """How contacts pull on a slider while none breaks: the share that holds, which is their stiffness, and their force
    as the motion begins (a length); `growth`: what else that changes by, per time."""

    holding: float
    force: float
    growth: float = 0.0


# So few contacts that they bear next to nothing, on a way on which all of them break.
NONE_HOLDS = Held(0.0, 0.0)


@dataclass(frozen=True)
class Oscillation:
    """Solution of m y'' + g y' + stiffness y = pull + rate t from y, w = y' at t = 0.

    centre, drift : the slider's balance is centre + drift t
    roots, parts : y - balance = sum of the real parts of parts e^(roots t); complex, shape (2,)
    size : the departure from the balance is at most size e^(-fading t)
    """

    centre: float
    drift: float
    roots: Array
    parts: Array
    size: float
    fading: float

    @classmethod
    def of(
        cls, m: float, g: float, stiffness: float, pull: float, rate: float, y: float, w: float
    ) -> "Oscillation":
        """The motion; m, g, stiffness above 0, g from 0 on."""
        drift = rate / stiffness
        centre = (pull - g * drift) / stiffness
        half, square = 0.5 * g / m, stiffness / m
        apart = np.sqrt(complex(half**2 - square))
        apart = apart if abs(apart) > APART * half else complex(APART * half)
        small = -square / (half + apart) if apart.imag == 0.0 and half else apart - half
        roots = np.array([small, -half - apart], dtype=complex)
        u, du = y - centre, w - drift
        first = (du - roots[1] * u) / (roots[0] - roots[1])
        parts = np.array([first, u - first])
        return cls(
            centre, drift, roots, parts, float(np.abs(parts).sum()), float(-roots.real.max())
        )

    @property
    def swings(self) -> bool:
        """Whether it is below critical damping."""
        return bool(self.roots[0].imag != 0.0)

    @property
    def period(self) -> float:
        """Of the oscillation; where it is overdamped, the time in which it changes."""
        return float(2.0 * np.pi / np.abs(self.roots).max())

    def departure(self, t: Array | float, order: int = 0) -> Array:
        """The departure from the balance, or a derivative of it; as t."""
        t = np.asarray(t, dtype=float)
        return (self.parts * self.roots**order * np.exp(self.roots * t[..., None])).sum(-1).real

    def travel(self, t: Array | float) -> Array:
        """y(t)."""
        return self.centre + self.drift * np.asarray(t) + self.departure(t)

    def speed(self, t: Array | float) -> Array:
        """y'(t)."""
        return self.drift + self.departure(t, 1)

    def bound(self, t: float) -> float:
        """Largest departure at and after t."""
        return self.size * float(np.exp(-self.fading * t))

    def time_until(self, size: float) -> float:
        """Time from which the departure is at most `size`."""
        if self.size <= size:
            return 0.0
        return float(np.log(self.size / size) / self.fading) if self.fading else np.inf

    def spent(self, t: Array | float, way: Array | float, pulled: Pulled, held: Held) -> Spent:
        """Energies from 0 to t, on which the slider goes this `way`, so pulled and held; as t."""
        spring, drive_speed = pulled.spring, pulled.drive_speed
        # the spring's force is linear in the time but for y, whose integral is that of the balance and of the departure
        lag = self._departure_integral(t)
        even = (pulled.force - spring * self.centre) * t
        even += 0.5 * spring * (drive_speed - self.drift) * t**2
        on_contacts = held.force * way + 0.5 * held.holding * way**2
        if held.growth:  # from y = 0
            moved = self.centre * t + 0.5 * self.drift * t**2 + lag
            on_contacts += held.growth * (t * way - moved)
        damped = pulled.damping * self._squared_speed(t)
        return Spent(drive_speed * (even - spring * lag), damped, on_contacts)

    def _squared_speed(self, t: Array | float) -> Array:
        """Integral of y'^2 from 0 to t."""
        t = np.asarray(t, dtype=float)
        pairs = self.roots[:, None] + self.roots
        grown = _grown(pairs, t[..., None, None])
        weights = np.outer(self.parts * self.roots, self.parts * self.roots)
        own = (weights * grown).sum((-2, -1)).real
        return (
            self.drift**2 * t + 2.0 * self.drift * (self.departure(t) - self.departure(0.0)) + own
        )

    def _departure_integral(self, t: Array | float) -> Array:
        """Integral of the departure from 0 to t."""
        t = np.asarray(t, dtype=float)
        return (self.parts * _grown(self.roots, t[..., None])).sum(-1).real

    def first_passing(self, low: float, high: float, end: float) -> tuple[float, int]:
        """The first time up to `end` at which y rises through `high`, and 1, or falls through `low`, and -1; else
        `end` and 0. At t = 0 y lies between them, or leaves one of them inwards."""
        found = min(
            (self._first_above(1.0, high, end), 1), (self._first_above(-1.0, -low, end), -1)
        )
        return found if found[0] < np.inf else (end, 0)

    def _first_above(self, sign: float, level: float, end: float) -> float:
        """The first time at which sign y rises above a level; inf if there is none up to `end`."""

        def above(t: float) -> float:
            return sign * (self.centre + self.drift * t) + self.bound(t) - level

        if not self.size:  # it moves as its balance does: no period has to be looked at
            ahead, rises = level - sign * self.centre, sign * self.drift
            passes = max(ahead, 0.0) / rises if rises > 0.0 else np.inf
            return float(passes) if passes <= end else np.inf
        # the bound of sign y is convex: below the level between two times at most
        begin, step = 0.0, self.period / SAMPLES
        if above(0.0) < 0.0:
            if not np.isfinite(end) or above(end) < 0.0:
                return np.inf
            begin = max(0.0, float(brentq(above, 0.0, end, xtol=OF_LIMIT * step)) - step)
        looked_at = 0
        while begin < end:
            looked_at += AT_ONCE
            # time may have too few digits for a period
            if self.swings and (begin + step <= begin or looked_at > MOST_PERIODS):
                raise StoppedError(RINGS)
            whole = end - begin
            lasts = whole if self._fades(whole) else min(whole, AT_ONCE * self.period)
            times = begin + self._looked_at(lasts)
            values = sign * self.travel(times) - level
            close = BETWEEN * np.abs(self.departure(times)).max() + ROUNDING * abs(level)
            for at in (np.flatnonzero(values[1:-1] > -close) + 1).tolist():
                found = self._passing_near(sign, level, *times[at - 1 : at + 2].tolist())
                if found is not None:
                    return found
            if values[-1] > 0.0:
                return float(brentq(lambda x: sign * self.travel(x) - level, times[-2], times[-1]))
            begin = float(times[-2]) if lasts < end - begin else end
            # jump over the times at which the bound is below the level
            if begin < end and above(begin) < 0.0:
                if not np.isfinite(end) or above(end) < 0.0:
                    return np.inf
                begin = max(begin, float(brentq(above, begin, end, xtol=OF_LIMIT * step)) - step)
        return np.inf

    def _fades(self, lasts: float) -> bool:
        """Whether the motion is overdamped, so that times in equal ratios show all of it, however long it lasts."""
        return not self.swings and np.isfinite(lasts) and lasts > self.period

    def _looked_at(self, lasts: float) -> Array:
        """Times from 0 on at which a crossing is looked for: SAMPLES a period, or a decade where the motion fades."""
        if not self._fades(lasts):
            return np.linspace(0.0, lasts, max(int(np.ceil(lasts * SAMPLES / self.period)), 4) + 1)
        first = self.period / SAMPLES
        decades = np.log10(lasts / first)
        times = np.append(0.0, np.geomspace(first, lasts, int(np.ceil(decades * SAMPLES)) + 1))
        times[-1] = lasts
        return times

    def _passing_near(
        self, sign: float, level: float, before: float, at: float, after: float
    ) -> float | None:
        """The time between `before` and `after` at which sign y rises above the level, or None."""

        def value(t: float) -> float:
            return float(sign * self.travel(t) - level)

        def rise(t: float) -> float:
            return float(sign * self.speed(t))

        if value(before) > 0.0 and rise(before) <= 0.0:
            return None  # y begins at the level and leaves it
        top = at
        if value(at) <= 0.0:
            if rise(before) <= 0.0 or rise(after) >= 0.0:
                return None
            top = float(brentq(rise, before, after, xtol=OF_PEAK * self.period, rtol=RELATIVE))
            if value(top) <= 0.0:
                return None
        if value(before) >= 0.0:
            return before
        return float(brentq(value, before, top, xtol=OF_CROSSING * self.period, rtol=RELATIVE))


def _grown(rate: Array, t: Array) -> Array:
    """Integral of e^(rate t) from 0 to t."""
    small = np.abs(rate * t) < SMALL
    safe = np.where(rate == 0.0, 1.0, rate)
    return np.where(small, t * (1.0 + 0.5 * rate * t), np.expm1(rate * t) / safe)
