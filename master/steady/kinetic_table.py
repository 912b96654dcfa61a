"""The kinetic force along speeds as a polynomial, for those who ask for it at many speeds, or for its slope."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from master.outcome import stop_after
from master.steady.cycle import Cycle
from master.steady.kinetic import kinetic_curve
from master.survival.make import steady_life
from origins import Contacts
from origins.thresholds.law import Array

# Degrees of the polynomial of F_k in ln V, tried in turn: of all contacts, and of those whose thresholds change.
DEGREES, DEGREES_OF_CHANGING = (12, 24, 48, 96), (12, 24, 48)
# The coefficients of a series fall from each BLOCK to the next. Of 1700 drawn tables (families of thresholds with heat
# of each law, ranges of 2 to 12 decades) none was off by more than is claimed with this SAFETY; with blocks of 2 and
# none, as coefficients do not fall one by one, the half was, by up to 24 times as much.
BLOCK, SAFETY, MOST_RATIO = 6, 3.0, 0.9
# Part of the error of the table that one force may have; and between which accuracies, in mean thresholds.
PART_OF_ERROR, ACCURACIES = 0.1, (1e-9, 1e-6)
# Largest ln V, either sign, of which F_k is known: of speeds up to 1e100.
FARTHEST = 230.0


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


def tabulated(
    contacts: Contacts,
    ends: Array,
    most_error: float,
    until: float = np.inf,
    held: float | None = None,
) -> KineticTable | None:
    """The table between these ends (2,) of ln V; None where its error would be above the most (a length), as F_k is not
    smooth in ln V, and at speeds beyond all, as of a slider that moves on in the last digit of the time. `until`:
    reading of time.monotonic() after which StoppedError comes. `held`: a force (a length); None where it does not lie
    between those at the ends, which takes two speeds in place of a table of dozens."""
    if np.abs(ends).max() > FARTHEST:
        return None
    if held is not None:
        at_ends, missed = _forces(contacts, np.exp(ends), most_error, until)
        if at_ends.max() + missed < held or held < at_ends.min() - missed:
            return None
    forces, off = np.empty(0), 0.0
    for degree in DEGREES if contacts.changing is None else DEGREES_OF_CHANGING:
        # places where the polynomial of this degree is 1 or -1: each second one stands in the list before
        nodes = np.cos(np.pi * np.arange(degree + 1) / degree)
        new = np.s_[1::2] if forces.size else np.s_[:]
        found, missed = _forces(
            contacts, np.exp(ends.mean() + 0.5 * np.diff(ends) * nodes[new]), most_error, until
        )
        before, forces = forces, np.empty(nodes.size)
        if before.size:
            forces[::2] = before
        forces[new], off = found, max(off, missed)
        series = np.asarray(chebyshev.chebfit(nodes, forces, degree), float)
        error = _left_out(series) + off
        if error <= most_error:
            return KineticTable(ends, series, error)
    return None


def _left_out(series: Array) -> float:
    """What a polynomial of these Chebyshev coefficients (n,) is off by at most, if those that are left out fall on as
    the last ones do. Each counts twice: at the nodes it is taken for one of the polynomial's own."""
    before, last = np.abs(series[-2 * BLOCK :]).reshape(2, BLOCK).sum(axis=1).tolist()
    ratio = min(last / before, MOST_RATIO) if before else MOST_RATIO
    return float(SAFETY * last * (1.0 + 2.0 * ratio / (1.0 - ratio)))


def _forces(
    contacts: Contacts, speeds: Array, most_error: float, until: float
) -> tuple[Array, float]:
    """F_k at these speeds (lengths), and an error of all (a length): of contacts whose thresholds change each speed
    takes long, and the less the larger its error may be."""
    stop_after(until)
    if contacts.changing is None:
        curve = kinetic_curve(contacts, speeds)
        return curve.force, float(curve.force_error.max()) * contacts.mean_threshold
    accuracy = float(np.clip(PART_OF_ERROR * most_error / contacts.mean_threshold, *ACCURACIES))
    found = np.empty((speeds.size, 2))
    for number, speed in enumerate(speeds.tolist()):
        stop_after(until)
        found[number] = Cycle(contacts, steady_life(contacts, speed), speed, accuracy).force()
    return found[:, 0], float(found[:, 1].max())
