"""What one root s of p^(s) = 1 carries: c e^{sX}, with c = 2 m^(s) b_0^(s) / (transform of x p at s).

m is the force of one contact from a break up to the next. With the force r_f and the stiffness r_k that breaks release,
f_b and k_b what births bring after the wait d,

    s m^(s) = [k_b e^{-sd} - r_k^(s)]/s - r_f^(s) + f_b e^{-sd}.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.decoherence import transform_error, wave_nodes
from master._old.piecewise import Piecewise
from master._old.problem import Problem
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

_ROUND_OFF = 1e-15
_WAVE = 1.5


@dataclass(frozen=True)
class Term:
    """A root, its error, c and its error, in units of the problem."""

    root: complex
    root_error: float
    amplitude: complex
    amplitude_error: float
    decay_error: float  # of -Re s


def term(problem: Problem, edges: Array, s: complex, noise: float) -> Term:
    """The term of a root found near s, by two and three times as many nodes as it was found with; `noise` is the error
    of the law's survival."""
    law, release = problem.law, problem.release
    amplitudes: list[complex] = []
    ends: list[complex] = []
    for finer in (2, 3):
        nodes, log_mass = wave_nodes(law, edges, finer * abs(s))
        # from so near a Newton step is the distance
        wave = np.exp(log_mass - s * nodes)
        slope = complex((wave * nodes).sum())
        root = s + complex(wave.sum() - 1.0) / slope
        size = np.abs(wave)
        lost = _ROUND_OFF * float((size * (1.0 + abs(s) * nodes)).sum())
        lost += transform_error(s, noise, edges)
        # travels are known to the rounding of the wait
        lost += float(np.spacing(release.delay))
        wave = np.exp(log_mass - root * nodes)
        slope = complex((wave * nodes).sum())
        waited = np.exp(-root * release.delay)
        force = slope
        if not release.plain:
            forces, stiffness = released_by(problem, nodes)
            released = complex((wave * forces).sum())
            softened = complex((wave * stiffness).sum())
            force = released - release.birth_force * waited
            force -= (release.birth_stiffness * waited - softened) / root
        begun, begun_error = first_breaks(problem, root, finer, release.delay)
        amplitudes.append(-2.0 * force / root * begun / slope)
        ends.append(root)
        off = lost / abs(slope)
    root_error = abs(ends[1] - ends[0]) + abs(ends[1] - s) + off
    c = amplitudes[1]
    scale = float(np.abs((wave * nodes**2).sum())) / abs(slope)
    change = abs(c) * ((scale + 1.0 / abs(s)) * root_error + begun_error / max(abs(begun), 1e-300) + _ROUND_OFF)
    return Term(ends[1], root_error, c, abs(c - amplitudes[0]) + change, root_error)


def released_by(problem: Problem, nodes: Array) -> tuple[Array, Array]:
    """Force and stiffness that a break at each of the nodes releases."""
    law, release = problem.law, problem.release
    density = law.pdf(nodes)
    rows = release.densities(nodes, density)
    ratios = [np.divide(row, density, out=np.zeros(nodes.size), where=density > 0.0) for row in rows]
    at_atoms = np.isin(nodes, law.atoms)
    force = np.where(at_atoms, release.force_at(nodes), ratios[0])
    stiffness = np.where(at_atoms, release.stiffness_at(nodes), ratios[1]) if len(ratios) > 1 else np.ones(nodes.size)
    return force, stiffness


def first_breaks(problem: Problem, s: complex, finer: int, wait: float) -> tuple[complex, float]:
    """b_0^(s) at a root s, and its error; contacts wait for `wait`."""
    first, release = problem.first, problem.release
    if problem.contacts.start.span == (0.0, 0.0) and release.born is None:
        # the first breaks come as the later ones do, without a wait
        return complex(np.exp(s * wait)), 0.0
    table: Piecewise = first.density
    total, off = 0.0 + 0.0j, 0.0
    if table.edges.size > 1:
        left, width = table.edges[:-1], np.diff(table.edges)
        pieces = np.maximum(np.ceil(width * finer * abs(s) / _WAVE), 1).astype(int)
        share = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        narrow = np.repeat(width / pieces, pieces)
        start = np.repeat(left, pieces) + share * narrow
        nodes, weights = gauss(start, start + narrow)
        total = complex((weights * table(nodes.ravel()).reshape(nodes.shape) * np.exp(-s * nodes)).sum())
        growth = np.exp(-s.real * table.edges[1:])
        sizes = np.abs(table.coefficients)
        off = float(((sizes[-2:].sum(axis=0) + _ROUND_OFF * sizes.max(axis=0)) * width * growth).sum())
    total += complex((first.atom_weights * np.exp(-s * first.atoms)).sum())
    return total, off
