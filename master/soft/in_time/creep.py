"""Creep: how a slider on a soft spring goes on once contacts that heat breaks have forgotten their start.

On the spring of a machine a slider moves by a million thresholds before the force is that of steady sliding, too many
for steps. But while its speed changes little as it moves by the few thresholds that contacts live, F is F_k(V), the
force of steady sliding at the speed V that it has, and the balance of forces an ordinary differential equation,

    K (X_T - X) = F_k(V),    so that    F_k'(u) du/dt = K (v - V),    u = ln V,

which leads to V = v. By s, ds = K max(v, V)/F_k'(u) dt, its solution is

    V/v = 1/[1 + (v/V_0 - 1) e^(-s)]  from below,    V/v = 1 + (V_0/v - 1) e^(-s)  from above:

from V_0 = v/2, say, V/v = 1/(1 + e^-s) is 0.5, 0.731 and 0.993 at s = 0, 1 and 5; from 2 v it is 2, 1.368 and 1.007.

In: the nodes of a section, the ends of its steps (the time; X and F/(N_c <k>), which are lengths), and K in N_c <k>.
Out: such nodes up to the end of the drive's path (`Crept.sections`), and the error of F on them (a length).

Steps hand over where F - F_k(V) is steady along the last part of the way; F lags behind F_k(V) by little, in the first
order of the change of V with X; F_k rises with the speed from V to v; and there steady sliding is stable on this spring
(master/steady/response.py). From there on V follows from F, so that it does not matter that steps have it less well
than F. The error is F - F_k(V) in the limit of short steps, by sliders with halved ones, or the lag if it is larger,
and how much F - F_k(V) varied: as F_k rises with V, F is drawn to within that of F_k(V).

An example, whose numbers a test holds: P_c ~ x e^(-x²/2a²) of the mean 1, heat by "eyring" of the width 0.03, K = 3e-3,
v = 1e-4, the tolerance 1e-2. The last of three sliders creeps from X_T = 178.3 on, with F = 0.5045:

    its way, 10.14 <x_s> on 178 steps, is 20 mean stretches F/N_c<k> for the first time
    along its last quarter F_k(V) rises by 0.019 for each factor e of V, and F - F_k(V) varies by 8.6e-5 <= 0.0019
    F lags by 1.6e-4 <= 0.0025, a quarter of the tolerance
    F - F_k(V) is -7.41e-3, -1.43e-3 and -2.23e-4 of the three: at step 0 |-2.23e-4 + 1.43e-3/4|/(3/4) = 1.8e-4, more
        than the lag, so that the error is 1.8e-4 + 8.6e-5 = 2.6e-4
    V = 0.837 v from here on, where F_k is F; to rounding v after 40 units of s
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from master.motion import Motion
from master.soft.in_time.steps import Node
from master.steady.kinetic_table import KineticTable, tabulated
from master.steady.response import has_response, is_stable, response
from origins import Contacts, Drive
from origins.thresholds.law import Array


class CreepControl(NamedTuple):
    """Numbers of the search for steady creep; none has a unit but mean thresholds, m, and tolerances.

    least_distance : travel of a section, in mean stretches F/N_c<k>, from which on creep is looked for
    next_look : factor on the number of the section's steps when creep was looked for last, at which it is next
    last_part : of the way, along which F is compared with F_k(V)
    variation : by how much F - F_k(V) may vary along it, in dF_k/d ln V
    square_of_ratio : largest square of the ratio of two sliders' steps (fine over coarse; halved steps have 1/4) by
        which the limit of F - F_k(V) for steps of 0 is extrapolated
    lag : lag of F behind F_k(V) up to which it is left out, in tolerances
    speed_ranges : factors on the speeds seen, and on that of the drive, within which F_k is tabulated, tried in turn
    table_error, of_change : error of that table, in tolerances, and where thresholds change, whose F_k takes long
    wave_number : (1/m) at which F_k' and the lag are read off the response; slow is small
    slope_difference : of F_k' by the response and by the table, largest relative one
    fewest_steps : along the last part of the way
    s_per_step, s_at_end : steps of s; and s at which F is F_k(v) to rounding, e^-40
    """

    least_distance: float = 20.0
    next_look: float = 1.2
    last_part: float = 0.25
    variation: float = 0.1
    square_of_ratio: float = 0.5
    lag: float = 0.25
    speed_ranges: tuple[float, ...] = (20.0, 1e3, 1e5)
    table_error: float = 1e-3
    of_change: float = 1e-2
    wave_number: float = 1e-2
    slope_difference: float = 0.02
    fewest_steps: int = 3
    s_per_step: float = 0.125
    s_at_end: float = 40.0


CREEP = CreepControl()
# Speeds at which the slope of F_k is looked at; and a time in place of 0, for a finite speed of steps that took none.
SLOPES, NO_TIME = 65, 1e-300


class Crept(NamedTuple):
    """How a slider goes on by steady creep: its sections up to the end of the path, the error of F (a length), and the
    time from which on F is within the tolerance of F_k at the drive's speed, also beyond that end."""

    sections: list[list[Node]]
    error: float
    steady_from: float


class Offset(NamedTuple):
    """F - F_k(V) along the last part of the way: its mean, and the largest minus the smallest (lengths); and the mean
    travel of a step there (a length)."""

    mean: float
    variation: float
    step_length: float

    def at_step_0(self, before: "Offset | None") -> float:
        """The size of the mean in the limit of steps of 0. Its error goes as the square of the step, so that the offset
        `before`, of a slider with longer steps, gives the limit; without that, or if its steps are hardly longer, the
        size as it is."""
        square = (self.step_length / before.step_length) ** 2 if before else 1.0
        if before is None or square > CREEP.square_of_ratio:
            return abs(self.mean)
        return abs(self.mean - square * before.mean) / (1.0 - square)


class SteadyCreep(NamedTuple):
    """What the last nodes of a section tell of steady creep: the table of F_k, ln V from here on, the offset of F from
    F_k(V), and the lag of F (a length)."""

    table: KineticTable
    log_speed: float
    offset: Offset
    lag: float


class Creep:
    """Steady creep on the last leg of a drive that goes on at one speed; lengths are along the motion."""

    def __init__(
        self, contacts: Contacts, drive: Drive, motion: Motion, tolerance: float, until: float
    ) -> None:
        """tolerance : of F, in mean thresholds; until : as in `creep_of`."""
        self._contacts, self._spring = contacts, float(drive.spring or 0.0)
        self._unit, self._motion = contacts.mean_threshold, motion
        self._speed, self._sign = abs(float(motion.speeds[-1])), float(np.sign(motion.speeds[-1]))
        self._tolerance, self._until = tolerance * self._unit, until
        self._table: KineticTable | None = None
        self._offset_of_longer_steps: Offset | None = None  # of the slider before
        self._nodes_at_last_look = 0  # so many the section had when creep was looked for last
        self._stable_at = dict[float, bool]()  # by ln V; sliders with halved steps ask for the same

    def begin_section(self) -> None:
        """At the begin of a smooth section nothing of its way is known."""
        self._nodes_at_last_look = 0

    def from_here(self, nodes: list[Node], most_steps: float) -> Crept | None:
        """How the slider goes on from the last of the nodes of a section on the last leg. None where it goes on in
        steps: where creep is not steady or not known to be, and where `most_steps`, as long on the average as those of
        the section so far, lead to the end of the path."""
        last, sign = nodes[-1], self._sign
        distance = sign * (last.position - nodes[0].position)
        # too early, or looked at a few steps ago
        if (
            distance < CREEP.least_distance * abs(last.force)
            or len(nodes) < CREEP.next_look * self._nodes_at_last_look
        ):
            return None
        self._nodes_at_last_look = len(nodes)
        distance_of_steps = most_steps * distance / len(nodes)
        # the drive is so near to its end that steps lead there
        if self._speed * (self._motion.times[-1] - last.time) < distance_of_steps:
            return None
        steady = self._steady(nodes, distance)
        if steady is None:
            return None
        sections, steady_from = self._sections(last, steady.log_speed, steady.table)
        # the slider's own way to the end may be shorter than the drive's
        distance_ahead = sign * (sections[-1][-1].position - last.position)
        if distance_ahead < distance_of_steps or not self._stable(steady.log_speed):
            return None
        error = max(steady.offset.at_step_0(self._offset_of_longer_steps), steady.lag)
        self._offset_of_longer_steps = steady.offset
        error += steady.offset.variation + steady.table.error
        return Crept(sections, float(error), steady_from)

    def _steady(self, nodes: list[Node], distance: float) -> SteadyCreep | None:
        """Whether creep is steady along the last part of the way of these nodes, but for its stability: it goes
        forward, F_k is known at its speeds and rises from there to the drive's, F - F_k(V) hardly varies, and F lags
        behind by little. None where one of these is not so."""
        last, sign = nodes[-1], self._sign
        position, time, force = np.array([(n.position, n.time, n.force) for n in nodes]).T
        late = np.flatnonzero(sign * (last.position - position) <= CREEP.last_part * distance)
        speeds = sign * np.diff(position[late]) / np.maximum(np.diff(time[late]), NO_TIME)
        if speeds.size < CREEP.fewest_steps or speeds.min() <= 0.0:
            return None
        log_speeds = np.log(speeds)
        table = self._tabulated(log_speeds, sign * last.force)
        if table is None:
            return None
        # the speed from here on is that at which F is F_k, not the last one of the steps
        log_speed = table.log_speed(sign * last.force)
        offsets = 0.5 * sign * (force[late][1:] + force[late][:-1]) - table.force(log_speeds)
        late_distance = sign * (last.position - position[late[0]])
        offset = Offset(float(offsets.mean()), float(np.ptp(offsets)), late_distance / speeds.size)
        rise_per_length = abs(log_speeds[-1] - log_speeds[0]) / late_distance
        lag = self._lag(log_speed, rise_per_length, table)
        if offset.variation > CREEP.variation * self._slope(log_speed, table) or np.isinf(lag):
            return None
        return SteadyCreep(table, log_speed, offset, lag)

    def _slope(self, log_speed: float, table: KineticTable) -> float:
        """dF_k/d ln V at this ln V (a length), where F_k rises with the speed from there to the drive's; else 0."""
        slopes = table.force(np.linspace(log_speed, np.log(self._speed), SLOPES), 1)
        return float(slopes[0]) if slopes.min() > 0.0 else 0.0

    def _lag(self, log_speed: float, rise_per_length: float, table: KineticTable) -> float:
        """By how much F lags behind F_k(V) at this ln V (a length), in the first order of d ln V/dX, `rise_per_length`
        (1/length); inf where it matters, or is not known. To a disturbance e^(iqX) of X, by which ln V changes by iq
        times as much and d ln V/dX by -q², F answers by G(iq) = iq F_k' + c q² for small q (master/steady/response.py):
        F = F_k(V) - c d ln V/dX."""
        wave, slope = CREEP.wave_number / self._unit, self._slope(log_speed, table)
        if not slope > 0.0:
            return float("inf")
        answer = complex(response(self._contacts, float(np.exp(log_speed)), np.array([wave]))[0])
        if abs(answer.imag / wave - slope) > CREEP.slope_difference * slope:
            return float("inf")
        lag = abs(answer.real) / wave**2 * rise_per_length
        return float(lag) if lag <= CREEP.lag * self._tolerance else float("inf")

    def _stable(self, log_speed: float) -> bool:
        """Whether steady sliding is stable from this ln V to that of the drive, looked at once a decade."""
        drive = float(np.log(self._speed))
        decade = np.copysign(np.log(10.0), log_speed - drive)
        for at in [*np.arange(drive, log_speed, decade).tolist(), log_speed]:
            if at not in self._stable_at:
                speed = float(np.exp(at))
                self._stable_at[at] = is_stable(self._contacts, speed, self._spring, self._until)
            if not self._stable_at[at]:
                return False
        return True

    def _tabulated(self, log_speeds: Array, force: float) -> KineticTable | None:
        """A table with these ln V, that of the drive, and that at which F_k is this force, also where steps are so long
        that it is far from all of them; None where F_k is not smooth in ln V, or there is no such speed."""
        needed = np.append(log_speeds, np.log(self._speed))
        ends = np.array([needed.min(), needed.max()])
        table = self._table
        holds_all = table is not None and table.ends[0] <= ends[0] and ends[1] <= table.ends[1]
        if table is not None and holds_all and not np.isnan(table.log_speed(force)):
            return table
        for factor in CREEP.speed_ranges:
            wider = ends + np.log(factor) * np.array([-1.0, 1.0])
            error = CREEP.of_change if self._contacts.changing else CREEP.table_error
            table = tabulated(self._contacts, wider, error * self._tolerance, self._until, force)
            if table is not None and not np.isnan(table.log_speed(force)):
                self._table = table
                return table
        return None

    def _sections(
        self, begin: Node, log_speed: float, table: KineticTable
    ) -> tuple[list[list[Node]], float]:
        """The sections from this node, at this ln V, to the end of the drive's path: V(s) as at the head, and the time
        by an integral over s. On the second one, if there is time left, V is the drive's speed. And `steady_from`."""
        drive, sign, end = np.log(self._speed), self._sign, float(self._motion.times[-1])
        first_log_ratio = log_speed - drive  # ln V_0/v
        s = np.arange(0.0, abs(first_log_ratio) + CREEP.s_at_end, CREEP.s_per_step)
        # ln V/v, for both signs of ln V_0/v
        rise_above_1 = np.expm1(abs(first_log_ratio)) * np.exp(-s)
        log_ratio = np.sign(first_log_ratio) * np.log1p(rise_above_1)
        # dt/ds = F_k'(u)/(K max(v, V))
        time_per_s = table.force(log_ratio + drive, 1) / (
            self._spring * self._speed * np.exp(np.maximum(log_ratio, 0.0))
        )
        time = begin.time + make_interp_spline(s, time_per_s, k=5).antiderivative()(s)
        force = sign * table.force(log_ratio + drive)
        off = np.flatnonzero(np.abs(force - force[-1]) > self._tolerance)
        steady_from = float(time[off[-1] + 1 if off.size else 0])
        if time[-1] > end:
            at_end = make_interp_spline(time, np.stack([s, force], axis=1), k=3)(end)
            until = time < end
            s, time, force = (
                np.append(values[until], last)
                for values, last in zip((s, time, force), (at_end[0], end, at_end[1]), strict=True)
            )
        sections = [self._section(s, time, force)]
        if time[-1] < end:
            sections.append(self._section(s[:2], np.array([time[-1], end]), force[[-1, -1]]))
        return sections, steady_from

    def _section(self, s: Array, time: Array, force: Array) -> list[Node]:
        """Nodes in whose `sizes_so_far` s stands, over which answer/reading.py interpolates; all contacts hold."""
        position = self._motion.at(time) - force / self._spring
        rows = np.stack([s, time, force, np.ones(s.size), position], axis=1)
        return [Node(*row) for row in rows.tolist()]


def creep_of(
    contacts: Contacts, drive: Drive, motion: Motion | None, tolerance: float, until: float
) -> Creep | None:
    """Steady creep of these contacts, None where it is not known; StoppedError after `until`, of time.monotonic()."""
    if motion is None or not may_creep(contacts, motion):
        return None
    return Creep(contacts, drive, motion, tolerance, until)


def may_creep(contacts: Contacts, motion: Motion | None) -> bool:
    """Whether steady creep is known: where the answer of F to a disturbance is, the drive moves to its end, and F_k is
    finite; but not for exact thresholds, where births may repeat for ever."""
    law, moves = contacts.thresholds, motion is not None and bool(motion.speeds[-1])
    known = moves and has_response(contacts) and not law.atoms[0].size
    return bool(known and np.isfinite(law.moment(3)))
