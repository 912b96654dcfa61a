"""Leading roots, and what they carry, where contacts wait for hundreds of times as long as they hold, or 1e12 times.

All is said of the travel y without the wait d, since x = d + y is known to no more than the rounding of d. With p_0 the
transform of y's law and m the force of one contact from its birth to its break, F later than the starting contacts has
the transform b_0^(s) m^(s) / [e^{sd} - p_0(s)]. At a root is e^{sd} = p_0(s): it carries

    c = 2 b_0^(s) m^(s) / [p_0(s) (d + <y e^{-sy}>/p_0(s))],     m = <k r y e_1(sy) + k y² e_2(sy)>,

with e_1(z) = (1 - e^{-z})/z and e_2(z) = (1 - e^{-z} - z e^{-z})/z². Along a line Re s = -γ the phase of e^{-sd} turns
many times while all else hardly changes, so that the mean of 1/|1 - p^| over a turn bounds what is left out of F.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.special as special

from master._old.decoherence import survival_error, wave_nodes
from master._old.decoherence_roots import Complex, Lines
from master._old.decoherence_terms import Term, first_breaks, released_by
from master._old.long_wait import Waves, slowest_waves
from master._old.problem import Problem
from origins.errors import InputError
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

_ROUND_OFF, _SETTLED = 1e-15, 1e-14
_SMALL, _TERMS = 0.5, 18
_NEAR_ZERO = 8  # frequencies of the lattice below which m is summed, not a difference of transforms
_HIGHEST = 20.0
_LATTICE = 1e-10  # error of ln |p^| on it
_SAFE = 1.5


@dataclass(frozen=True)
class _Motion:
    """The law of y as nodes, and what a contact does that breaks at each."""

    waves: Waves
    travel: Array
    mass: Array
    birth_force: Array
    stiffness: Array

    def force(self, s: complex) -> complex:
        """m^(s)."""
        once, twice = _means(np.asarray(s * self.travel))
        each = self.birth_force * self.travel * once + self.stiffness * self.travel**2 * twice
        return complex((self.mass * each).sum())


def waiting_terms(
    problem: Problem, edges: Array, wait: float, count: int, limit: float
) -> tuple[list[Term], float, float]:
    """The terms of the `count` slowest roots, slowest first, or of those right of Re s = -limit; a rate γ beyond them,
    and B: all that is left out is below B e^{-γX}.

    `problem` is that of the same contacts if they did not wait, `wait` is d in its units.
    """
    law, noise = problem.law, survival_error(problem.cycle)
    motions = [_motion(problem, edges, wait, finer) for finer in (2.0, 3.0)]
    roots = [slowest_waves(motion.waves, law.narrowest, count + 1) for motion in motions]
    found = [(a, b, off) for (a, _), (b, off) in zip(*roots, strict=True) if -b.real < limit]
    decays = [-b.real for _, b, _ in found] + [limit] * (len(found) <= count)
    if not found:
        raise InputError(
            "thresholds: no root of the waiting contacts decays more slowly than the law's own tail; use a longer delay"
        )
    unsure = noise * (float(edges[-1]) / min(law.narrowest, 1.0)) ** 2
    terms = [_term(problem, motions, wait, pair, unsure) for pair in found[:count]]
    # the middle of the gap keeps the line clear of the roots to either side
    last = min(count, len(decays) - 1)
    gamma = 0.5 * (decays[last - 1] + decays[last])
    clear = 0.25 * (decays[last] - decays[last - 1])
    left = _along(problem, motions[0], edges, wait, gamma, clear)
    return terms, gamma, left


def _motion(problem: Problem, edges: Array, wait: float, finer: float) -> _Motion:
    nodes, log_mass = wave_nodes(problem.law, edges, finer / min(problem.law.narrowest, 1.0))
    mass = np.exp(log_mass)
    forces, stiffness = released_by(problem, nodes)
    return _Motion(Waves(nodes, mass, wait), nodes, mass, forces - stiffness * nodes, stiffness)


def _term(
    problem: Problem, motions: list[_Motion], wait: float, pair: tuple[complex, complex, float], unsure: float
) -> Term:
    """The term of a root that two sets of nodes have as `pair`, with the error of its real part."""
    amplitudes: list[complex] = []
    lost = 0.0
    for motion, s in zip(motions, pair[:2], strict=True):
        wave = motion.mass * np.exp(-s * motion.travel)
        law = complex(wave.sum())
        later = wait + complex((wave * motion.travel).sum()) / law
        begun, begun_error = first_breaks(problem, s, 3, wait)
        amplitudes.append(2.0 * motion.force(s) * begun / (law * later))
        lost = begun_error / max(abs(begun), 1e-300)
    first, s, off = pair
    decay_error = off + abs((s - first).real) + unsure * abs(s.real)
    # a rounding of d + C turns the phase, not the decay
    root_error = abs(s - first) + decay_error + (4.0 * _ROUND_OFF + unsure / motions[1].waves.whole) * abs(s)
    c = amplitudes[1]
    return Term(s, root_error, c, abs(c - amplitudes[0]) + abs(c) * (lost + unsure + _SETTLED), decay_error)


def _along(problem: Problem, motion: _Motion, edges: Array, wait: float, gamma: float, clear: float) -> float:
    """What e^{-γX} is to be multiplied by: (1/π) times the integral over frequencies of the modulus of the transform of
    F's later part at Re s = -γ, which no root is nearer to than `clear`."""
    release, whole = problem.release, motion.waves.whole
    lines = Lines(problem, edges, _HIGHEST)
    frequency = lines.frequency
    law, force, *rest, first = lines.rows(gamma)
    s = -gamma + 1j * frequency
    moved = ((release.birth_stiffness - (rest[0] if rest else law)) / s - force + release.birth_force) / s
    # beside s = 0 that is a small difference, and b_0^ at most what it is on the axis
    ends = np.linspace(0.0, frequency[_NEAR_ZERO], 5)
    near = max(abs(motion.force(complex(-gamma, one))) for one in gauss(ends[:-1], ends[1:])[0].ravel())
    size = np.abs(moved * first)
    size[: _NEAR_ZERO + 1] = np.maximum(size[_NEAR_ZERO], near * abs(first[0]))
    # ln |p^|, and at what distance from 0 its crossing passes roots
    high = np.log(np.maximum(np.abs(law), 1e-300)) + gamma * wait
    high[: _NEAR_ZERO + 1] = 0.0
    apart = np.where(high[1:] * high[:-1] > 0.0, np.minimum(np.abs(high[1:]), np.abs(high[:-1])), 0.0)
    mean = _mean_inverse(np.maximum(apart - _LATTICE, clear * whole))
    turns = np.ceil(np.diff(frequency) * whole / (2.0 * np.pi)) + 1.0
    total = float((np.maximum(size[1:], size[:-1]) * mean * turns).sum()) * 2.0 * np.pi / whole
    # a density that jumps leaves something above all frequencies looked at
    last = size.size // 8
    total += float(size[-last:].max() * mean[-last:].max()) * float(frequency[-1])
    return _SAFE * total * float(np.exp(gamma * wait)) / np.pi


def _mean_inverse(apart: Array) -> Array:
    """Mean of 1/|1 - p^| over all phases of p^, ln |p^| being `apart` from 0 or further."""
    return 2.0 / np.pi * special.ellipkm1(-np.expm1(-2.0 * apart))


def _means(z: npt.NDArray[Any]) -> tuple[Complex, Complex]:
    """e_1 and e_2."""
    once, twice = np.empty(z.shape, dtype=complex), np.empty(z.shape, dtype=complex)
    small = np.abs(z) < _SMALL
    few, many = z[small], z[~small]
    factor, first, second = np.ones_like(few), np.zeros_like(few), np.zeros_like(few)
    for n in range(_TERMS):
        # (-z)^n/n!, of which e_1 has 1/(n + 1) and e_2 has 1/(n + 2)
        first += factor / (n + 1)
        second += factor / (n + 2)
        factor = factor * -few / (n + 1)
    once[small], twice[small] = first, second
    fallen = np.exp(-many)
    once[~small] = (1.0 - fallen) / many
    twice[~small] = (1.0 - fallen - many * fallen) / many**2
    return once, twice
