"""What rate_state returns: a, b and D_c with their errors, the solved answers, and the law beside them."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from master.rate_state.law import RateStateLaw
from master.rate_state.reading import Reading
from master.rate_state.traces import Rest, VelocityStep
from origins.brief import brief
from origins.thresholds.law import Array

# of a number: how far it may change in the range of speeds, or of rests, in which it is constant
CONSTANT = 0.1


@dataclass(frozen=True)
class Parameter:
    """A number read from solved answers: `error`, numerical, from above; `definition`, how far other readings of the
    same answers are from it, NaN where there are none; and the speeds (of healing: the rests) from `low` to `high`
    between which it changes by less than CONSTANT, or as far as it was looked for."""

    value: float
    error: float
    definition: float
    low: float
    high: float

    @property
    def known(self) -> bool:
        """Whether it is above its numerical error; what is 0, as where the force does not rise, is known."""
        size = abs(self.value)
        return bool(self.error < size or (size == 0.0 and np.isfinite(self.error)))


@dataclass(frozen=True)
class Misfit:
    """Largest difference of the rate-and-state law from the solved answers to the steps, as a part of the larger of
    |a| and |b| for each factor e, and the slip since the step (a length) where it is."""

    share: float
    slip: float


@dataclass(frozen=True)
class SpeedScan:
    """a, b, a - b (forces) and D_c (a length) at other speeds, arrays of shape (n,)."""

    velocity: Array
    a: Array
    b: Array
    a_minus_b: Array
    slip_distance: Array

    __repr__ = brief

    @classmethod
    def of(cls, speeds: Array, own: Reading) -> Self:
        """NaN but at the middle one of the speeds, whose reading this is."""
        scan = cls(speeds, *np.full((4, speeds.size), np.nan))
        scan.keep(speeds.size // 2, own)
        return scan

    def keep(self, number: int, found: Reading) -> None:
        """Take over a reading at the speed of this number."""
        self.a[number], self.b[number] = found.a, found.b
        self.a_minus_b[number] = found.a - found.b
        self.slip_distance[number] = found.slip_distance


@dataclass(frozen=True)
class RateState:
    """Rate and state of contacts at a speed; forces F/(N_c <k>) and slips are lengths, springs K/(N_c <k>).

    velocity : v (length per time); kinetic_force : F_k there, and its error
    a, b, a_minus_b : direct effect, evolution effect, and the slope of F_k, forces for each factor e of the speed
    slip_distance : D_c
    direct_slip : slip over which the direct effect comes up; the law has it at once
    healing : rise of the largest force after a rest, for each decade of the time at rest; None without rests
    law : the rate-and-state law with these numbers
    steps, rests : the solved answers; law_steps, law_rests : forces of the law in their place, the latter by the
        ageing law, as the slip law does not heal at rest
    misfit, misfit_later : of the law, along the whole answer, and once the direct effect is over
    critical_spring : (b - a)/D_c, 0 where a > b, NaN where b > a and there is no D_c, with its error
    critical_spring_solved : below which smooth sliding is unstable by the solved answer to small steps; its error
        holds what steps that are not small leave out; NaN where neither a nor b is above its error, and where the
        force swings on at the end of an answer to a small step
    scan : the numbers at other speeds
    run_time : s; success, message : whether the answers are known to the tolerance and have become steady
    """

    velocity: float
    kinetic_force: float
    kinetic_force_error: float
    a: Parameter
    b: Parameter
    a_minus_b: Parameter
    slip_distance: Parameter
    direct_slip: float
    healing: Parameter | None
    law: RateStateLaw
    steps: tuple[VelocityStep, ...]
    law_steps: tuple[Array, ...]
    rests: tuple[Rest, ...]
    law_rests: Array
    misfit: Misfit
    misfit_later: Misfit
    critical_spring: float
    critical_spring_error: float
    critical_spring_solved: float
    critical_spring_solved_error: float
    scan: SpeedScan
    run_time: float
    success: bool
    message: str

    __repr__ = brief
