"""The rate-and-state law of Dieterich and Ruina, on a slider whose speed is given.

F = F_k + a ln(v/v_0) + b ln(v_0 θ/D_c), θ being the state, a time: the age of the contacts. At a steady speed v it is
D_c/v, so that F_k falls by b - a for each factor e of the speed. Two laws say how it goes there (A. Ruina, J. Geophys.
Res. 88, 10359, 1983): dθ/dt = 1 - v θ/D_c, "ageing", and dθ/dt = -(v θ/D_c) ln(v θ/D_c), "slip".
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from origins.thresholds.law import Array

EvolutionLaw = Literal["slip", "ageing"]
# of ln θ, by scipy
_ACCURACY = 1e-10


@dataclass(frozen=True)
class RateStateLaw:
    """a, b and kinetic_force (forces), slip_distance D_c (a length), all at the speed v_0 = velocity."""

    kinetic_force: float
    velocity: float
    a: float
    b: float
    slip_distance: float
    evolution: EvolutionLaw = "slip"

    def force(self, velocity: float, state: Array) -> Array:
        """F at a speed and at states θ (times), of their shape."""
        aged = np.log(self.velocity * state / self.slip_distance)
        return self.kinetic_force + self.a * np.log(velocity / self.velocity) + self.b * aged

    def step(self, slip: Array, before: float, after: float) -> Array:
        """F at slips since a step from one steady speed to another, by scipy's solve_ivp; at 0 just after the step."""
        states = self.states(slip / after, after, self.slip_distance / before)
        return self.force(after, states)

    def after_rest(self, rests: Array) -> Array:
        """The largest force on the way on at v_0, after steady sliding at v_0 and rests of these times, shape (n,)."""
        return self.force(
            self.velocity, self.states(rests, 0.0, self.slip_distance / self.velocity)
        )

    def states(self, times: Array, velocity: float, state: float) -> Array:
        """θ at rising times >= 0 since it was `state`, at one speed >= 0, by scipy's solve_ivp, shape (n,); NaN without
        a D_c."""
        from scipy.integrate import solve_ivp

        def rate(_: float, log_state: Array) -> Array:
            slid = velocity * np.exp(log_state) / self.slip_distance
            if self.evolution == "ageing":
                return (1.0 - slid) * np.exp(-log_state)
            return -velocity / self.slip_distance * np.log(slid) if velocity else 0.0 * log_state

        if not np.isfinite(state) or times.max(initial=0.0) <= 0.0:
            return np.full(times.shape, state)
        accuracy = {"rtol": _ACCURACY, "atol": _ACCURACY}
        found = solve_ivp(
            rate, (0.0, times[-1]), [np.log(state)], "LSODA", t_eval=times, **accuracy
        )
        return np.exp(found.y[0])


def remaining_of_step(
    slip: Array, slip_distance: float, ratio: float, evolution: EvolutionLaw
) -> Array:
    """ln(v θ/D_c) at slips since a step of the speed by a factor `ratio`: ln(ratio) at 0, and 0 in the end; the closed
    solution of the two laws at one speed."""
    decayed = np.exp(-slip / slip_distance)
    return np.log1p((ratio - 1.0) * decayed) if evolution == "ageing" else np.log(ratio) * decayed
