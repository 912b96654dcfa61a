"""What the leading roots leave out of F(X): an integral along a line Re s = -γ left of them, bounded by its modulus."""

from typing import Any

import numpy as np
import numpy.typing as npt

from master._old.decoherence_roots import Complex, Lines, Roots
from master._old.problem import Problem
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

_LATER = 5.0  # mean travels after which the rest shall be least
_GAPS = 0.3, 0.5, 0.7
_SAFE = 1.5


def rest_beyond(problem: Problem, lines: Lines, found: Roots, kept: int, kinetic: float) -> tuple[float, float]:
    """A rate γ beyond the first `kept` roots, its line clear of others, and B: all left of it is below B e^{-γX}.

    0 and inf where nothing is known. kinetic is F_k/(N_c <k>) in units of the problem.
    """
    roots = found.roots
    if not found.searched > 0.0:
        return 0.0, np.inf
    decays = np.append(-roots.real[kept - 1 :] if kept else [0.0], found.searched)
    widest = np.argsort(-np.diff(decays))[:2]
    tried = [decays[gap] + share * (decays[gap + 1] - decays[gap]) for gap in widest for share in _GAPS]
    bounds = [(float(gamma), _along(problem, lines, float(gamma), roots, kinetic)) for gamma in tried]
    return min(bounds, key=lambda pair: np.log(pair[1]) - _LATER * pair[0])


def _along(problem: Problem, lines: Lines, gamma: float, roots: Complex, kinetic: float) -> float:
    """What e^{-γX} is to be multiplied by: (1/π) times the integral over frequencies of the modulus of the transform of
    F's later part at Re s = -γ, less the poles at s = 0, which count for nothing there."""
    release, end = problem.release, np.array([problem.end])
    slope = float(problem.known_rate(end)[0])
    level = kinetic - float(problem.known(end)[0]) + slope * problem.end
    beside = 2.0 * gamma + 1.0

    def parts(frequency: Array, rows: Complex) -> tuple[Any, Any, Any]:
        law, force, *rest, first = rows
        s = -gamma + 1j * frequency
        waited = np.exp(-s * release.delay)
        stiffness = rest[0] if rest else law
        later = law * waited * (release.birth_stiffness / s + release.birth_force) - force - stiffness / s
        poles = -slope / s**2 + level * (1.0 / s - 1.0 / (s + beside))
        return law, first * later / s, poles

    # beside s = 0 what is left without the poles is smooth
    first = max(int(np.searchsorted(lines.frequency, 0.5 * min(1.0, float(roots.imag.min(initial=2.0))))), 1)
    ends = np.linspace(0.0, lines.frequency[first], 9)
    frequency, weights = (part.ravel() for part in gauss(ends[:-1], ends[1:]))
    law, top, poles = parts(frequency, lines.at(gamma, frequency))
    total = float((weights * np.abs(top / (1.0 - law) - poles)).sum())
    law, top, poles = parts(lines.frequency, lines.rows(gamma))
    size = np.maximum(np.abs(top[first:-1]), np.abs(top[first + 1 :])) * np.diff(lines.frequency)[first:]
    total += float((size * _inverse_distance(law[first:])).sum())
    total += float((np.abs(poles[first:-1]) * np.diff(lines.frequency)[first:]).sum())
    # a density that jumps leaves something above all frequencies looked at
    total += float(np.abs(top[-(top.size // 8) :]).max()) * float(lines.frequency[-1])
    return _SAFE * total / np.pi + abs(level)


def _inverse_distance(law: Complex) -> Array:
    """Mean of 1/|1 - p^| between neighbours, ln p^ being straight from one to the next."""
    apart = 1.0 - law
    out = 1.0 / np.minimum(np.abs(apart[1:]), np.abs(apart[:-1]))
    near = np.flatnonzero(out > 2.0)
    begin, end = np.log(law[near]), np.log(law[near + 1])
    change = end - begin
    change -= 2j * np.pi * np.round(change.imag / (2.0 * np.pi))
    begin -= 2j * np.pi * np.round((begin + 0.5 * change).imag / (2.0 * np.pi))
    place = begin / change
    away = np.maximum(np.abs(place.imag), 1e-12)
    across = np.arcsinh((1.0 + place.real) / away) - np.arcsinh(place.real / away)
    out[near] = across / np.abs(change)
    return out
