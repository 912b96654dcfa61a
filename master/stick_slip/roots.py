"""Roots: the rates and frequencies with which F(X) decays to the kinetic force.

Number conservation of contacts that move steadily forward has a Laplace transform over the distance x
since birth (docs/equations.md). With d the travel in the delay it is

    b^(s) D(s) = 1/s - G_0^(s),      D(s) = E^(s) e^(-sd) + (1 - e^(-sd))/s,

and F - F_k is a sum of e^(sX) over the roots of D, all left of the imaginary axis, none on the real one.
There the transform w = 1 - sD of the distance from a birth to the next is 1. By the argument principle as many roots
lie right of a line of constant Re s as w crosses the real axis above 1 along it: Newton's method starts from there, and
has to find as many.
"""

import numpy as np
from scipy.optimize import brentq

from master.steady.cycle import Cycle
from master.stick_slip.transform import Complex, Transform
from master.survival.life import ALL_ATOMS
from origins.thresholds.tail import tail_rate

# Roots are searched up to this share of the decay rate of E's tail, or of that of exact values.
NEAR = 0.9
# Ratio of the longest to the mean life beyond which the few longest ones cannot be resolved.
BROAD = 1e4
# Largest error of D, times the decay rate, with which the turns of w = 1 - sD, counted around 1, are sure.
COUNTABLE = 1e-3
# Angle in radians by which w turns at most from one frequency to the next: neighbours tell which way it turned.
TURN = 0.5
# The highest frequency times the mean distance from birth to birth; and most frequencies times nodes of one integral,
# which limits the work.
MOST_FREQUENCIES, MOST_SUMMANDS = 2e3, 1e8
# |w| below which w is taken not to turn around 1, with a margin. Frequencies are enough where w is smaller beyond this
# fraction of the highest.
QUIET, LAST_PART = 0.8, 0.7
# Steps in frequency by which a root may lie left of the line and be kept, and the least ln |w| = -BESIDE from which
# Newton's method starts: between frequencies w is interpolated, so that a counted root may seem to lie just left.
BESIDE = 0.02
# Deeper waves vanish within a mean life: e^-40 is below the rounding of F.
VANISHED = 40.0
# The search goes deeper while it is not this near to the deepest line, and gives up where a line that failed cannot be
# replaced by one deeper than those before by so much, or by a share of the deepest.
AT_THE_DEEPEST, LEAST_DEEPER, SHALLOWEST = 0.99, 1.05, 1e-3
# Newton's method: most steps, and in steps of frequency the last one, whose square is about the error.
MOST_NEWTON, LAST_NEWTON = 20, 1e-8
# Relative last step of a root that is kept; and steps of frequency within which two are one.
CONVERGED, SAME = 1e-7, 1e-6


def crowding(cycle: Cycle) -> float:
    """Decay rate (per length) near which infinitely many roots of ever higher frequency crowd, due to
    exact thresholds; inf without any, 0 where all contacts break at exact thresholds."""
    distances = cycle.atoms[(cycle.atoms > 0.0) & (cycle.atoms <= cycle.longest)]
    # the share that breaks at each is that just before less that just after it
    sides = np.multiply.outer([1.0 - 1e-11, 1.0 + 1e-11], distances)
    before, after = cycle.scaled(sides.reshape(-1, 1)).survival.reshape(sides.shape)
    distances, fractions = distances[before > after] + cycle.wait, (before - after)[before > after]
    if not distances.size or fractions.sum() > ALL_ATOMS:
        return 0.0 if distances.size else np.inf
    logs = np.log(fractions)
    ends = 0.0, -2.0 * float(logs.max()) / float(distances.min())
    return float(
        brentq(lambda rate: np.logaddexp.reduce(rate * distances + logs), *ends, xtol=1e-300)
    )


def decoherence_length(cycle: Cycle) -> tuple[float, float]:
    """X* of the slowest term e^(-X/X*), and its error; inf where nothing decays exponentially.

    It is inf for exact values alone (F is periodic or nearly so), and for a tail slower than any exponential. Where a
    few contacts live more than 10,000 times as long as the mean, the error is inf. Where exact values have a share of
    the weight, roots slower than the rate at which infinitely many crowd may not exist: X* is that of this rate.
    """
    rate, off = min(tail_rate(cycle.contacts.thresholds), (crowding(cycle), 0.0))
    if rate == 0.0:
        return np.inf, 0.0
    if cycle.longest > BROAD * cycle.length:
        # X* depends on the few contacts that live longest, which the table of E does not resolve
        return cycle.longest, np.inf
    transform = Transform(cycle, deepest_wave(cycle, rate))
    roots, searched = leading_roots(transform, 1)
    if roots.size:
        decay, error = -float(roots[0].real), float(transform(roots[:1]).root_error()[0])
        # with a very long delay the decay may be smaller than its rounding error
        return (1.0 / decay, error / decay**2) if error < decay else (1.0 / error, np.inf)
    if searched > 0.95 * NEAR * rate:  # an undetected root may lie from there to the rate
        return 1.0 / rate, (off + rate - searched) / rate**2
    return (0.5 / searched, 0.5 / searched) if searched else (cycle.length, np.inf)


def deepest_wave(cycle: Cycle, rate: float) -> float:
    """Decay rate to which roots are searched (per length): deeper waves vanish within a mean life."""
    return min(NEAR * rate, VANISHED / cycle.birth_to_birth)


def leading_roots(transform: Transform, count: int) -> tuple[Complex, float]:
    """All roots of D with Im s > 0 right of Re s = -searched, slowest first, and `searched` (per length):
    at least `count`, or as deep as the transform; fewer where one is missed or D is too inaccurate (0: everywhere)."""
    roots, searched, deepest = np.empty(0, dtype=complex), 0.0, transform.deepest
    decay = min(0.5 / transform.cycle.birth_to_birth, deepest)
    while roots.size < count and searched <= AT_THE_DEEPEST * deepest:
        found, number = _right(transform, decay, roots)
        if found.size >= number:
            roots, searched = found[found.real > -decay], decay
            decay = min(2.0 * decay, deepest)
        elif decay < max(LEAST_DEEPER * searched, SHALLOWEST * transform.deepest):
            break
        else:
            deepest, decay = decay, float(np.sqrt(searched * decay)) or 0.5 * decay
    return roots, searched


def _right(transform: Transform, decay: float, some: Complex) -> tuple[Complex, float]:
    """Roots right of the line Re s = -decay, or hardly left of it, of which `some` are known; and how many are right of
    it, inf where D is too inaccurate to tell."""
    cycle, s = transform.cycle, np.array([complex(-decay)])
    end = transform(s)
    if not end.conserved_error[0] * decay < COUNTABLE:
        return some, np.inf
    # the slope of w = 1 - sD on the real axis is the mean distance, weighted by e^(decay x)
    step = float((TURN * (1.0 - s * end.conserved) / (end.conserved + s * end.slope)).real[0])
    by_work = np.sqrt(MOST_SUMMANDS * step / transform.table.end[-1])
    highest = min(MOST_FREQUENCIES / cycle.birth_to_birth, by_work)
    # waves that are shorter than E's resolution fade in its transform; and some steps at least, to count turns at all
    last = max(4.0 / cycle.resolution_length, 15.0 * step)
    while True:
        last = min(2.0 * last, highest)
        s = -decay + 1j * step * np.arange(int(np.ceil(last / step)) + 2)
        w = (1.0 - s * transform.survival_on_line(decay, step, s.size)) * np.exp(-s * cycle.wait)
        loudest = float(s[np.flatnonzero(np.abs(w) > QUIET)[-1]].imag)
        if loudest < LAST_PART * last or last >= highest:
            break
    phase, size = np.angle(w), np.log(np.abs(w))
    turn = phase[:-1] - phase[1:]
    real = ((phase[:-1] > 0.0) != (phase[1:] > 0.0)) & (np.abs(turn) < np.pi)
    place = np.divide(phase[:-1], turn, out=np.zeros(turn.size), where=real)
    size = size[:-1] + place * np.diff(size)
    # where w crosses the real axis beyond 1, it has turned once around 1, which a root does
    number = float(np.sign(turn)[real & (size > 0.0)].sum())
    starts = (s[:-1] + 1j * step * place)[real & (size > -BESIDE)]
    return _newton(transform, np.append(some, starts), decay, step), number


def _newton(transform: Transform, starts: Complex, decay: float, step: float) -> Complex:
    """Roots of log w near `starts` right of Re s = -decay, or by BESIDE steps left of it, slowest first."""
    nodes = transform.nodes(float(np.abs(starts).max(initial=0.0)) + step, decay + step)
    ends, last, off = starts.copy(), np.full(starts.size, np.inf), np.zeros(starts.size)
    for _ in range(MOST_NEWTON):
        moving = last > LAST_NEWTON * step
        if not moving.any():
            break
        s = ends[moving]
        found = transform(s, nodes)
        with np.errstate(all="ignore"):
            broken = 1.0 - s * found.conserved
            move = np.log1p(-s * found.conserved) * broken / (found.conserved + s * found.slope)
        ends[moving] += move
        last[moving], off[moving] = np.abs(move), found.root_error()
    # of each pair one: the others lie below the real axis, and s = 0 on it, which is no root
    good = (last <= CONVERGED * np.abs(ends)) & (ends.imag > 0.1 * step)
    good &= ends.real > -decay - BESIDE * step
    ends, off = ends[good], off[good]
    # deep roots are known so little that Newton's method may end beside one twice
    same = np.maximum(SAME * step, np.add.outer(off, off))
    ends = ends[~np.tril(np.abs(np.subtract.outer(ends, ends)) <= same, -1).any(axis=1)]
    return ends[np.argsort(-ends.real, kind="stable")]
