"""a, b and D_c read from the solved answers to a step up and one down, and the other readings of the same answers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from master.rate_state.law import EvolutionLaw, remaining_of_step
from master.rate_state.traces import VelocityStep
from origins.thresholds.law import Array

# of the largest change: a smaller rise of the force is no direct effect; and a fall by this ends the direct effect
NO_RISE = 1e-2
# D_c is sought from this part of the answer's slip on, first at so many places; and not where the evolution is over
# by e^-50 before the maximum, as no number would be left of it
SHORTEST, TRIALS, DECAYED = 1e-4, 60, 50.0
# an error of the forces may move D_c directly as well as by b
TWICE = 2.0
# D_c moves by at most so many times as much by errors of the force, which may differ from slip to slip, as by b alone
WORST = 5.0


class Peak(NamedTuple):
    """Where the direct effect of a step ends: the change of force for each factor e there, what sampling may make of
    it, and the slip."""

    height: float
    sampling: float
    slip: float


class OtherReading(NamedTuple):
    """a, b (forces) and D_c (a length) of the same steps, read in another way."""

    a: float
    b: float
    slip_distance: float


class Evolution(NamedTuple):
    """b (a force) and D_c (a length) of an evolution."""

    b: float
    slip_distance: float


@dataclass(frozen=True)
class Reading:
    """a, b (forces) and D_c (a length) of steps, their errors, the slip at which the direct effect ends, and `others`,
    an OtherReading in each row, shape (n, 3)."""

    a: float
    b: float
    slip_distance: float
    a_error: float
    slip_distance_error: float
    direct_slip: float
    others: Array

    @property
    def evolves(self) -> bool:
        """Whether there is a D_c."""
        return bool(np.isfinite(self.slip_distance))

    @property
    def significant(self) -> bool:
        """Whether a or b is above its error."""
        return self.evolves or abs(self.a) > self.a_error


def read_steps(steps: Sequence[VelocityStep], law: EvolutionLaw) -> Reading:
    """a: the first maximum of the change of force for each factor e of the speed, 0 where there is none, a mean of all
    steps; b = a - (a - b), a - b from the kinetic forces; D_c: that of the law with this b that is nearest to the
    forces beyond the maximum, by least squares over the slip.

    The other readings are those of the single steps; that of b and D_c by least squares together, whose a is the force
    after the direct effect, extrapolated to the step; and as D_c the slip at which b has fallen as far as by the law
    after D_c, to 1/e by the slip law. Where b is not
    above its error D_c is NaN.
    """
    slope = float(np.mean([one.slope for one in steps]))
    peaks = [direct_effect(one) for one in steps]
    a, sampling, slip = (float(np.mean(each)) for each in zip(*peaks, strict=True))
    begins = [peak.slip for peak in peaks]
    off = max(one.error / abs(one.log_ratio) for one in steps)
    a_error, b = float(off + sampling), a - slope
    if abs(b) <= a_error + off:
        return Reading(a, b, np.nan, a_error, np.inf, slip, np.empty((0, 3)))
    own = fit_evolution(steps, begins, law, b)
    others = list[OtherReading]()
    for one, peak in zip(steps, peaks, strict=True):
        own_b = peak.height - slope
        others.append(OtherReading(peak.height, *fit_evolution([one], [peak.slip], law, own_b)))
        others.append(OtherReading(a, b, _fallen(one, peak, own_b, law)))
    free = fit_evolution(steps, begins, law)
    others.append(OtherReading(free.b + slope, *free))
    moved = fit_evolution(steps, begins, law, b + np.copysign(a_error, b)).slip_distance
    return Reading(
        a,
        b,
        own.slip_distance,
        a_error,
        WORST * abs(moved - own.slip_distance),
        slip,
        np.array(others),
    )


def direct_effect(step: VelocityStep) -> Peak:
    """The first maximum of the change of force, beyond which it falls by NO_RISE of the largest change at least, and
    which is the first point where the force jumps; nothing where the force does not rise by that."""
    change, least = step.response, NO_RISE * np.abs(step.response).max()
    highest = np.maximum.accumulate(change)
    fallen = np.flatnonzero(highest - change > least)
    top = int(np.argmax(change[: fallen[0]] if fallen.size else change))
    if change[top] <= least:
        return Peak(0.0, 0.0, 0.0)
    return vertex(step.slip, change, top)


def vertex(slip: Array, values: Array, top: int) -> Peak:
    """The highest place of the parabola through the value at the index `top`, the largest, and those beside it; the
    point itself at an end."""
    if not 0 < top < values.size - 1:
        return Peak(float(values[top]), 0.0, float(slip[top]))
    near = slice(top - 1, top + 2)
    curve = np.polynomial.Polynomial.fit(slip[near], values[near], 2)
    place = slip[top]
    if curve.coef[-1]:
        place = np.clip(curve.deriv().roots()[0].real, *slip[near][[0, -1]])
    height = float(curve(place))
    return Peak(height, abs(height - float(values[top])), float(place))


def fit_evolution(
    steps: Sequence[VelocityStep],
    begins: Sequence[float],
    law: EvolutionLaw,
    b: float | None = None,
) -> Evolution:
    """b and D_c of the law that is nearest to the forces at slips beyond `begins`, by least squares over the slip; with
    b given D_c alone."""
    from scipy.interpolate import PchipInterpolator
    from scipy.optimize import minimize_scalar

    slips = [
        np.r_[begin, one.slip[one.slip > begin]] for one, begin in zip(steps, begins, strict=True)
    ]
    weight = np.sqrt(np.concatenate([trapezoids(slip) for slip in slips]))
    remaining = [
        PchipInterpolator(one.slip, one.response)(slip) - one.slope
        for one, slip in zip(steps, slips, strict=True)
    ]
    goal = weight * np.concatenate(remaining)

    def best_of(slip_distance: float) -> tuple[float, float]:
        """b, and the sum of squares that it leaves."""
        each = [
            remaining_of_step(slip, slip_distance, one.after / one.before, law) / one.log_ratio
            for slip, one in zip(slips, steps, strict=True)
        ]
        form = weight * np.concatenate(each)
        size = float(form @ goal / (form @ form)) if b is None else b
        return size, float(np.square(goal - size * form).sum())

    longest = max(float(slip[-1]) for slip in slips)
    shortest = max(SHORTEST * longest, max(begins) / DECAYED)
    trial = np.log(np.geomspace(shortest, longest, TRIALS))
    best = int(np.argmin([best_of(np.exp(each))[1] for each in trial]))
    ends = trial[max(best - 1, 0)], trial[min(best + 1, trial.size - 1)]
    found = minimize_scalar(
        lambda each: best_of(np.exp(each))[1],
        bounds=ends,
        method="bounded",
        options={"xatol": 1e-10},
    )
    distance = float(np.exp(found.x))
    return Evolution(best_of(distance)[0], distance)


def trapezoids(at: Array) -> Array:
    """The weights of an integral over rising places, shape (n,), by the trapezoidal rule."""
    return 0.5 * (np.diff(at, prepend=at[0]) + np.diff(at, append=at[-1]))


def _fallen(step: VelocityStep, peak: Peak, b: float, law: EvolutionLaw) -> float:
    """The slip since the step at which what is left of the evolution first is what the law leaves of b after D_c,
    straight between points."""
    expected = remaining_of_step(np.ones(1), 1.0, step.after / step.before, law)[0] / step.log_ratio
    remaining = np.abs(step.response - step.slope) - abs(b) * expected
    below = np.flatnonzero((remaining <= 0.0) & (step.slip > peak.slip))
    if not below.size:
        return float(step.slip[-1])
    pair = slice(below[0] - 1, below[0] + 1)
    return float(np.interp(0.0, -remaining[pair], step.slip[pair]))
