"""Lifshitz and Slyozov's sizes in mpmath, quadrature for steep densities, and the distance of samples from a law."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from references import mp

TAIL = 10.0 ** -np.array([0.01, 0.3, 1, 3, 8, 12, 14, 30, 100, 200, 270])
LOW = 10.0 ** -np.array([0.05, 0.5, 1, 3, 8, 15, 30])
BARELY = 2.0 / 3.0 * (1.0 + 1e-6)


def sizes(u: mp.mpf) -> mp.mpf:
    """P_LS as the paper and Lifshitz and Pitaevskii print it."""
    front = 81 * mp.e / 2 ** (mp.mpf(5) / 3) * u * u
    return (
        front
        * mp.exp(-1 / (1 - 2 * u / 3))
        / ((u + 3) ** (mp.mpf(7) / 3) * (mp.mpf(3) / 2 - u) ** (mp.mpf(11) / 3))
    )


def psi(y: mp.mpf) -> mp.mpf:
    return mp.mpf(4) / 3 * mp.log1p(y / 2) + mp.mpf(5) / 3 * mp.log1p(-y) + y / (1 - y)


def gauss_rule(n: int) -> list[tuple[mp.mpf, mp.mpf]]:
    """Nodes and weights on (0, 1) in 40 digits, Newton's from numpy's."""
    with mp.workdps(40):
        out = []
        for start in np.polynomial.legendre.leggauss(n)[0]:
            x = mp.mpf(float(start))
            for _ in range(2):
                slope = n * (x * mp.legendre(n, x) - mp.legendre(n - 1, x)) / (x * x - 1)
                x -= mp.legendre(n, x) / slope
            slope = n * (x * mp.legendre(n, x) - mp.legendre(n - 1, x)) / (x * x - 1)
            out.append(((1 + x) / 2, 1 / ((1 - x * x) * slope * slope)))
        return out


RULE = gauss_rule(16)


def integral(f: Callable[[mp.mpf], mp.mpf], marks: list[mp.mpf]) -> mp.mpf:
    """Gauss-Legendre between marks close enough together, each piece to its own relative accuracy."""
    return mp.fsum(
        (b - a) * mp.fsum(w * f(a + t * (b - a)) for t, w in RULE) for a, b in pairwise(marks)
    )


def relative(found: np.ndarray, exact: list[mp.mpf]) -> float:
    return max(
        abs(float(mp.mpf(float(a)) / b - 1)) for a, b in zip(np.ravel(found), exact, strict=True)
    )
