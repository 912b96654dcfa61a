"""The kinetic force along speeds as a polynomial, for those who ask for it at many speeds, or for its slope."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from master.steady.kinetic import kinetic_curve
from origins import Contacts
from origins.thresholds.law import Array

# Degrees of the polynomial of F_k in ln V, tried in turn.
DEGREES = (12, 24, 48)


class KineticTable(NamedTuple):
    """F_k(V) over ln V: the ends (2,) of ln V, Chebyshev coefficients of F_k between them (lengths), and its error
    (a length)."""

    ends: Array
    series: Array
    error: float

    def force(self, log_speed: Array, derivative: int = 0) -> Array:
        """F_k, or its derivative in ln V, at ln V (n,)."""
        low, high = self.ends
        at = (2.0 * log_speed - low - high) / (high - low)
        series = chebyshev.chebder(self.series, derivative) if derivative else self.series
        return np.asarray(chebyshev.chebval(at, series) * (2.0 / (high - low)) ** derivative)

    def log_speed(self, force: float) -> float:
        """ln V at which F_k is this force; nan beyond the table."""
        low, high = self.ends.tolist()
        off = [float(self.force(np.array(end))) - force for end in (low, high)]
        if off[0] * off[1] > 0.0:
            return float("nan")
        return float(brentq(lambda at: float(self.force(np.array(at))) - force, low, high))


def tabulated(contacts: Contacts, ends: Array, most_error: float) -> KineticTable | None:
    """The table between these ends (2,) of ln V; None where its error would be above the most (a length), as F_k is not
    smooth in ln V."""
    for degree in DEGREES:
        nodes = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
        at = ends.mean() + 0.5 * np.diff(ends) * nodes
        forces = kinetic_curve(contacts, np.exp(at)).force
        series = np.asarray(chebyshev.chebfit(nodes, forces, degree), float)
        error = float(np.abs(series[-2:]).sum())
        if error <= most_error:
            return KineticTable(ends, series, error)
    return None
