"""The equations of steady sliding of a slider with mass, without steps; see steady_sliding.py."""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from master.outcome import FaultError, stop_after
from master.steady.kinetic_table import KineticTable
from origins.thresholds.law import Array

# Force, in mean thresholds, that inertia may take of a slider that is followed in balance; and in times of it, that
# below which a slider is followed so, and that above which it is not any more.
LEFT_OUT, IN_BALANCE, INERTIAL = 1e-6, 0.5, 2.0
# Change of the spring's force in a unit of the integrator's variable, in mean thresholds, as u changes by 1 at most;
# fewest of these units; nodes in each.
OF_FORCE, FEWEST, NODES = 0.1, 4.0, 16
# Relative accuracy of the integrator, and most units.
ACCURACY, MOST_UNITS = 1e-8, 1e5
# Most change of ln V on a memory of F in a long slip, beyond which a lag of first order is not known.
MOST_CHANGE = 0.5
# Stiffness in place of one that is not above 0 (a length).
TINY = 1e-300


class SlidingMachine(NamedTuple):
    """A slider of mass M and damping γ on a spring K, per N_c<k>, whose drive has this speed.

    unit, life : mean threshold, and the longest life (lengths)
    until : reading of time.monotonic() at which to stop
    memory : the way for which F remembers the speed, on the average (a length)
    allowed_lag : by how much F may lag behind F_k(V) in a long slip (a length)
    """

    mass: float
    damping: float
    spring: float
    drive_speed: float
    unit: float
    life: float
    until: float
    memory: float = 0.0
    allowed_lag: float = np.inf

    def stiffness(self, u: Array | float, table: KineticTable) -> Array:
        """Change of F_k and damping by u = ln V (a length)."""
        return np.asarray(table.force(np.asarray(u), 1) + self.damping * np.exp(u))

    def inertia(self, u: float, table: KineticTable) -> float:
        """M V u' of a slider in balance (a length): u' is the spring's loading, K (v - V), over the stiffness."""
        speed = float(np.exp(u))
        loading = self.spring * (self.drive_speed - speed)
        return self.mass * speed * loading / max(float(self.stiffness(u, table)), TINY)

    def lag(self, u: float, rise_per_length: float, table: KineticTable) -> float:
        """By how much F lags behind F_k(V) at this ln V (a length), in the first order of d ln V/dX (1/length)."""
        slope = abs(float(table.force(np.asarray(u), 1)))
        return self.memory * abs(rise_per_length) * slope


class SteadyMotion:
    """The equations of steady sliding over a variable in which the motion is smooth: on a unit of it u changes by 1, S
    by OF_FORCE of a mean threshold, and the time by a FEWEST-th of all, at most.

    A state is u, S, the time, the energies that the drive gave and damping and contacts took, and the travel.
    `swings`: whether inertia mattered anywhere.
    """

    def __init__(self, machine: SlidingMachine, table: KineticTable, duration: float) -> None:
        self._of, self._table, self._of_time = machine, table, FEWEST / duration
        self._in_balance = self.swings = False

    def followed(self, state: Array, end: float, most_change: float) -> tuple[Array, bool]:
        """The variable and states, shape (8, n), from this one on until the time `end`, or until V changes by
        `most_change` on a life; and whether the end has come."""
        of, begun, rows = self._of, 0.0, list[Array]()
        self._in_balance = self._left_out(state) < 1.0
        # of a slider in balance the change at the begin was small enough
        most = max(most_change, 1.01 * self._change(state))

        def ends(_: float, state: Array) -> float:
            return float(end - state[2])

        def changes(_: float, state: Array) -> float:
            return most - self._change(state)

        def leaves(_: float, state: Array) -> float:
            low, high = self._table.ends.tolist()
            return float(min(state[0] - low, high - state[0]))

        def switches(_: float, state: Array) -> float:
            return (
                INERTIAL - self._left_out(state)
                if self._in_balance
                else self._left_out(state) - IN_BALANCE
            )

        events = [ends, changes, leaves, switches]
        for event in events:
            event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        given = {"method": "Radau", "rtol": ACCURACY, "atol": ACCURACY * of.unit}
        while True:
            self.swings |= not self._in_balance
            stop_after(of.until)
            # numerical slopes by the time and the energies, on which no rate depends, overflow and are 0
            with np.errstate(over="ignore"):
                found = solve_ivp(
                    self._rates, (0.0, MOST_UNITS), state, events=events, dense_output=True, **given
                )
            if found.status != 1:
                raise FaultError(f"steady sliding is not followed beyond {found.y[2, -1]:.6g}")
            at = np.linspace(0.0, found.t[-1], int(np.ceil(NODES * found.t[-1])) + 1)
            rows.append(np.vstack([begun + at, found.sol(at)])[:, bool(rows) :])
            state, begun = found.y[:, -1], begun + float(found.t[-1])
            if not found.t_events[3].size:
                return np.concatenate(rows, axis=1), bool(found.t_events[0].size)
            self._in_balance = not self._in_balance

    def _left_out(self, state: Array) -> float:
        """The force that the equations of balance leave out, in times of LEFT_OUT: inertia as the spring loads; and of
        a slider that is not followed in balance, by how much it is off it."""
        of, u, load = self._of, state[0], state[1]
        force = abs(of.inertia(u, self._table))
        if not self._in_balance:
            off = load - of.damping * np.exp(u) - self._table.force(u)
            force = max(force, float(abs(off)))
        return force / (LEFT_OUT * of.unit)

    def _change(self, state: Array) -> float:
        """|d ln V| on a life."""
        return float(self._of.life * abs(self._slope(state)) / np.exp(state[0]))

    def _slope(self, state: Array) -> float:
        """du/dt."""
        of, u, load = self._of, state[0], state[1]
        speed = np.exp(u)
        if self._in_balance:
            loading = of.spring * (of.drive_speed - speed)
            return float(loading / of.stiffness(u, self._table))
        force = float(self._table.force(u))
        return float((load - of.damping * speed - force) / (of.mass * speed))

    def _rates(self, _: float, state: Array) -> Array:
        """The state's derivative by the variable."""
        of, u, load = self._of, state[0], state[1]
        speed, faster, force = np.exp(u), self._slope(state), float(self._table.force(u))
        loading = of.spring * (of.drive_speed - speed)
        energies = load * of.drive_speed, of.damping * speed**2, force * speed
        units = faster, loading / (OF_FORCE * of.unit), self._of_time
        pace = np.sqrt(sum(one**2 for one in units))
        return np.array([faster, loading, 1.0, *energies, speed]) / pace


class SlipMotion(SteadyMotion):
    """The same in a long slip, where the change of V on a life matters by the lag of F alone: it is told in lags that
    are allowed, or in parts of MOST_CHANGE of ln V on a memory."""

    def _change(self, state: Array) -> float:
        """See the class."""
        of, u = self._of, float(state[0])
        rise = abs(self._slope(state)) / float(np.exp(u))
        return max(of.lag(u, rise, self._table) / of.allowed_lag, of.memory * rise / MOST_CHANGE)
