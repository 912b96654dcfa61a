"""A slider with mass that follows its drive slowly: nothing rings, and the balance of forces tells where it is."""

from typing import NamedTuple

import numpy as np

from master.soft.inertia.body import STAYS_SLOW, Body, Mode
from master.soft.inertia.record import Instant, Spent, crossing
from master.soft.inertia.slow import Slow, slope_of_speed, slow_motion
from origins.thresholds.law import Array

# Panels of F that are looked ahead, and points of each; and the way, in mean thresholds, that is solved ahead first.
PANELS, POINTS, AHEAD = 40, 17, 2.0
# The spring's force falls where F', but for the lag, is below this: above it is rounding.
FALLS = -1e-9
# Longest way that is looked ahead on a panel, in mean thresholds: steady breaks have an endless one.
FURTHEST = 1e9
# Shortest slow way, in mean thresholds, for which a slider above critical damping leaves `moving`: that mode takes
# longer steps there than a way that ends at once, after which both would alternate.
WORTH_IT = 1e-3
# Distance from a panel's beginning of the place just inside, in widths of the panel.
JUST_INSIDE = 1e-9
# A slider accelerates too much to be slow where the force on its mass is above so much of what counts as rest, and of
# the ringing that a start at the drive's speed would give: slow motion takes far less than the second.
OF_REST, OF_START = 3.0, 1e-2
# Bisections for where the slider gets fast, between two of the points: to a millionth of their distance.
BISECTIONS = 20
# The balance is looked for from so far, in mean thresholds, behind the slider on, which lags behind it.
BEHIND = 1e-3
# Gauss nodes on each panel, of the degree 16, in the integrals of energies.
GAUSS = 16
# Points of a panel at which the spring's force may begin to fall.
WATCHED = 9
# Slopes of 0 are taken as that where they divide.
TINY = 1e-300


class Ahead(NamedTuple):
    """How far the slider goes slowly: up to a travel, where F drops, or behind which it is fast, or neither."""

    travel: float
    drops: bool
    fast: bool


class Following(Body):
    """The mode `following`."""

    def _follows(self, part: float) -> bool:
        """Whether the slider follows its drive slowly, up to a part of what counts as rest."""
        m, rate, y = self.mass, self.spring * self._speed, self.y
        slope = self.move.panel_at(y).slope(y) + self.spring
        # what accelerates the mass
        force = float(self._pull(self.t)) - self.damping * self.w - self.spring * y - self._force(y)
        of_start = rate * np.sqrt(m / max(slope, TINY))
        quickly = OF_REST * part * self.quiet + OF_START * of_start
        if slope <= 0.0 or abs(force) > quickly:
            return False
        slow = self._slow(np.array([y]), rate, min(part, 1.0))
        if not slow.missed[0] <= part * self.quiet:
            return False
        faster = abs(self.w - slow.speed[0])
        # above critical damping nothing rings: what the slider lags behind, where F' jumps, too, it makes up at a speed
        # of its own
        if self._heavily_damped and self.damping * (faster + slow.speed[0]) > part * self.quiet:
            return False
        rings = force - slow.inertia[0], np.sqrt(m * slope) * faster
        return bool(np.hypot(*rings) <= part * self.quiet) and not self._lags_before_drop()

    def _goes_on_slowly(self, rate: float) -> bool:
        """See Body."""
        if not self._heavily_damped or rate == 0.0:
            return True
        # the balance, ahead of the slider, may be past that place already
        place = self._look_ahead(rate).travel
        ahead = (
            float(self.move.curve.force(place)) + self.spring * place - float(self._pull(self.t))
        )
        return ahead > WORTH_IT * self.unit * self.spring

    def _slow(self, balance: Array, rate: float, part: float = 1.0) -> Slow:
        """The slow motion at these balances on the present move, with this part of the changes that count as slow."""
        given = rate, self.mass, self.damping, part * self.fastest
        return slow_motion(self.move.curve, balance, *given)

    def _lags_before_drop(self) -> bool:
        """Whether the balance has passed a drop of F that the slider has not reached."""
        drop, curve = self.move.next_drop(self.y), self.move.curve
        if drop == np.inf:
            return False
        return float(self._pull(self.t)) > float(curve.force(drop)) + self.spring * drop

    def following(self) -> Mode:
        """Follow the drive slowly, until it turns or the slider gets fast."""
        rate, end = self.spring * self._speed, self._leg_end()
        if rate < 0.0:
            return self.turn()
        if not self._follows(STAYS_SLOW):
            return self.moving
        if rate == 0.0:
            which = self.record.between(self.t, end)
            self._follow_to(which, np.full(which.stop - which.start + 1, self.y), end)
            self._next_leg()
            return self.following
        ahead = self._look_ahead(rate)
        if ahead.travel <= self.y:
            return self.moving
        load = float(self.move.curve.force(ahead.travel)) + self.spring * ahead.travel
        arrival = self.t + (load - float(self._pull(self.t))) / rate
        if arrival <= self.t:
            # the slider lags behind its balance, which has passed that place: no slow way is left
            return self.moving
        until = min(arrival, end)
        which = self.record.between(self.t, until)
        loads = self._pull(np.append(self.record.times[which], until))
        low = max(min(self.y, ahead.travel) - BEHIND * self.unit, 0.0)
        self._follow_to(which, self.move.curve.travel_at(loads, low, ahead.travel), until)
        if arrival >= end:
            self._next_leg()
            return self.following
        # the balance is at the drop; the slider lags behind it, and moves on to the drop by itself
        self._break_here()
        return self.moving if ahead.drops or ahead.fast else self.following

    def _look_ahead(self, rate: float) -> Ahead:
        """How far the slider goes slowly from here, some panels ahead at most."""
        move, y = self.move, self.y
        move.panel_at(y + AHEAD * self.unit)
        curve = move.curve
        panels = slice(int(curve.panel(y)), int(curve.panel(y)) + PANELS)
        # F' may jump where panels meet: places just inside both are compared
        fractions = np.clip(np.linspace(0.0, 1.0, POINTS), JUST_INSIDE, 1.0)
        widths = np.minimum(curve.width[panels], FURTHEST * self.unit)
        places = curve.from_travel[panels, None] + widths[:, None] * fractions
        slow = self._slow(places.ravel(), rate)
        # where F' jumps, so does the speed: the slider rings
        jumps = np.abs(np.diff(slow.speed, prepend=slow.speed[0])).reshape(places.shape)
        jumps[:, 1:] = 0.0
        rings = np.sqrt(self.mass * np.maximum(slow.slope, 0.0)) * jumps.ravel()
        lags = self.damping * slow.speed * self._heavily_damped
        ahead = places.ravel()
        fast = (np.maximum(slow.missed, np.maximum(rings, lags)) > self.quiet) & (ahead > y)
        stop = float(ahead[-1])
        if fast.any():
            k = int(np.argmax(fast))
            stop, high = max(float(ahead[k - 1]) if k else y, y), float(ahead[k])
            for _ in range(BISECTIONS):
                middle = 0.5 * (stop + high)
                one = self._slow(np.array([middle]), rate)
                stop, high = (middle, high) if one.missed[0] <= self.quiet else (stop, middle)
        drop = move.next_drop(y)
        return Ahead(drop, True, False) if drop <= stop else Ahead(stop, False, bool(fast.any()))

    def _follow_to(self, which: slice, balance: Array, end: float) -> None:
        """Results at the asked times, and the state at the end, from the balances there, in this order."""
        record, move = self.record, self.move
        m, d = self.mass, move.direction
        curve, k, rate = move.curve, self.spring, self.spring * self._speed
        slow = self._slow(balance, rate)
        if rate > 0.0 and d == self.drive_direction:
            self._watch_slowly(float(balance[-1]), rate)
        y, w = np.maximum(slow.travel, 0.0), slow.speed
        energy = np.array([self._taken(one, rate) for one in y.tolist()])
        damped, on_contacts = energy.T
        # the drive's work from the balance of energy
        spring = self._pull(np.append(record.times[which], end)) - k * y
        before = float(self._pull(self.t)) - k * self.y
        gained = 0.5 * (spring**2 - before**2) / k + 0.5 * m * (w**2 - self.w**2)
        spent = self.spent.plus(Spent(gained + damped + on_contacts, damped, on_contacts))
        force = d * curve.force(y[:-1])
        record.write(which, self.base + d * y[:-1], d * w[:-1], force, spent.at(slice(None, -1)))
        record.store_later(move, which, y[:-1])
        self.t, self.y, self.w = end, float(y[-1]), float(w[-1])
        self.spent = spent.at(-1)

    def _taken(self, y: float, rate: float) -> tuple[float, float]:
        """Energy that damping and contacts take on the way to the travel y."""
        curve, low, high = self.move.curve, min(self.y, y), max(self.y, y)
        edges = curve.from_travel[(curve.from_travel > low) & (curve.from_travel < high)]
        ends = np.concatenate([[low], edges, [high]])
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
        half = 0.5 * np.diff(ends)[:, None]
        places = ends[:-1, None] + half * (1.0 + nodes)
        speed = rate / np.maximum(curve.load_slope(places), TINY)
        sign = 1.0 if y >= self.y else -1.0
        on_contacts = sign * float((half * weights * curve.force(places)).sum())
        return self.damping * float((half * weights * speed).sum()), on_contacts

    def _watch_slowly(self, stop: float, rate: float) -> None:
        """Falls of the spring's force up to a balance: it has its extremes where the slider, and not the balance behind
        which it lags, is as fast as its drive."""
        curve, k, limit = self.move.curve, self.spring, self._speed
        low = max(min(self.y, stop) - BEHIND * self.unit, 0.0)
        first = float(curve.travel_at(np.array([self._pull(self.t)]), low, stop)[0])
        edges = curve.from_travel[(curve.from_travel > first) & (curve.from_travel < stop)]
        ends = np.concatenate([[first], edges, [stop]])
        cells = ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, WATCHED)
        places = np.unique(cells.ravel())

        def slope(y: Array) -> Array:
            return slope_of_speed(curve, y, rate, self.mass, self.damping)

        def rise(y: float) -> float:
            return float(slope(np.array([y]))[0]) - k - FALLS

        def time_at(y: float | Array) -> Array:
            return self.t + (curve.force(y) + k * y - float(self._pull(self.t))) / rate

        def travel(y: Array) -> Array:
            return self._slow(y, rate).travel

        def at(y: float) -> Instant:
            place = float(travel(np.array([y]))[0])
            return self._instant(float(time_at(y)), place, place)

        slopes = slope(places)
        speeds = rate / slopes
        speeds = np.where(slopes - k - FALLS < 0.0, speeds, np.minimum(speeds, limit))
        drives = self._drive(time_at(places))
        self.record.watch(
            self._watched(
                places,
                (travel(places), speeds),
                drives,
                at,
                lambda k: crossing(rise, places[k], places[k + 1]),
            )
        )
