"""Laws averaged over a continuous parameter, such as the orientation of grains: a mixture at a quadrature's nodes."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from origins.errors import InputError, finite, positive, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import Mixture
from origins.thresholds.quadrature import NODES, gauss
from origins.thresholds.scipy_laws import as_thresholds

_MOST = 512  # laws in the mixture at most
_PILOTS = 16
_SAME = 1e-9  # relative distance at which two places count as equal
_JUMP = 1e-4  # least jump of a density, in units of 1/<x_s>
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
_TAILS = 10.0 ** -np.array([8.0, 5.0, 3.0, 2.0, 1.0, 0.6, 0.3])


def continuous_mixture(
    law: Callable[[float], object],
    lower: float,
    upper: float,
    density: Callable[[float], float] | None = None,
    accuracy: float = 1e-10,
) -> "ContinuousMixture":
    """P_c(x) = integral of R(phi) P_c(x; phi) dphi from lower to upper (paper, Sec. VI, grains of all orientations).

    Finitely many orientations are a mixture: mixture([law(phi_1), law(phi_2)], [R_1, R_2]).

    Parameters
    ----------
    law : function of phi
        The normalised law of one phi: Thresholds or a frozen scipy.stats distribution, smooth in phi. Where a misfit
        multiplies the strength of all grains by s(phi), it is grains(rho, B=B / s(phi)).
    lower, upper : float
        Ends of phi, in any unit.
    density : function of phi
        R(phi) >= 0, normalised here; left out: all phi equal.
    accuracy : float
        Of the survival, absolute, and of <x_s>, relative. Intervals of phi are halved until halving changes the sum by
        less.

    Returns
    -------
    thresholds : ContinuousMixture
        A mixture of the laws at the nodes, with that change as `.quadrature_error`. A tail with a probability below it
        is that of the laws at the nodes.

    Raises InputError for values outside these, where 512 laws do not reach the accuracy, and where P_c(x; phi) has
    exact values or jumps that move with phi: the average has none, while a finite mixture has one for each law, and
    therefore another K*.
    """
    lower, upper = finite("lower", lower), finite("upper", upper)
    accuracy = positive("accuracy", accuracy)
    if not upper > lower:
        refuse("upper", upper, f"must be above lower = {lower:g}")
    if not callable(law):
        such = "such as lambda phi: origins.grains(2.0, B=1.0 / strength(phi))"
        refuse("law", law, f"must be a function of phi, {such}")
    if density is not None and not callable(density):
        refuse("density", density, "must be a function of phi")
    # not at the ends of intervals, where sums could agree however rough the law is in between
    places = lower + (upper - lower) * ((np.arange(_PILOTS) + 0.5) * _GOLDEN % 1.0)
    pilots = [as_thresholds(law(float(phi))) for phi in places]
    _check_moving(pilots)
    x = np.unique([x for one in pilots for x in (*one.ppf(_TAILS), *one.isf(_TAILS))])
    scale = max(one.mean() for one in pilots)

    @cache
    def part(low: float, high: float) -> _Part:
        phis, weights = gauss(np.array(low), np.array(high))
        laws = [as_thresholds(law(float(phi))) for phi in phis]
        if density is not None:
            weights = weights * [_height(density, float(phi)) for phi in phis]
        rows = np.array([[1.0, one.mean() / scale, *one.sf(x)] for one in laws])
        return _Part(laws, weights, weights @ rows)

    @cache
    def missed(low: float, high: float) -> float:
        """Largest difference between the sums of an interval and those of its halves."""
        middle = 0.5 * (low + high)
        halves = part(low, middle).sums + part(middle, high).sums
        return float(np.abs(part(low, high).sums - halves).max())

    intervals = [(lower, upper)]
    while True:
        whole = float(sum(part(*one).sums[0] for one in intervals))
        if not whole > 0.0:
            refuse("density", density, "is zero at all phi asked")
        error = sum(missed(*one) for one in intervals) / whole
        if error <= accuracy:
            break
        if NODES * (len(intervals) + 1) > _MOST:
            rule = f"{_MOST} laws reach {error:.2g} only; ask for less, or smooth the law"
            refuse("accuracy", accuracy, rule)
        low, high = max(intervals, key=lambda one: missed(*one))
        intervals.remove((low, high))
        intervals += [(low, 0.5 * (low + high)), (0.5 * (low + high), high)]
    parts = [part(*one) for one in sorted(intervals)]
    shares = np.concatenate([one.weights for one in parts])
    laws = [law for one in parts for law in one.laws]
    used = np.flatnonzero(shares)
    found = ContinuousMixture([laws[i] for i in used], shares[used] / shares.sum())
    found.quadrature_error = error
    return found


class _Part(NamedTuple):
    """Laws at the nodes of an interval of phi, their weights, and their sums: weight, <x_s>, survivals."""

    laws: list[Thresholds]
    weights: Array
    sums: Array


def _height(density: Callable[[float], float], phi: float) -> float:
    height = finite("density", density(phi))
    if height < 0.0:
        refuse("density", height, f"must not be below zero, as at phi = {phi:g}")
    return height


def _check_moving(laws: Sequence[Thresholds]) -> None:
    """InputError where an exact value or a jump of the density is at a different place in every law."""
    found = [_hard_points(one) for one in laws]
    for i, points in enumerate(found):
        others = np.concatenate(found[:i] + found[i + 1 :])
        for point in points:
            if not (np.abs(others - point) <= _SAME * abs(point)).any():
                raise InputError(
                    f"law: an exact value or a jump of the density moves with phi, one stands at {point:.6g}: the "
                    "average has none, a mixture of finitely many laws has them all and a K* of its own; write the "
                    "average itself, as scipy.stats.uniform(1.0, 1.0) for identical(1.0 + phi), or a smooth law for "
                    "each phi, as gaussian(1.0 + phi, 0.05)"
                )


def _hard_points(law: Thresholds) -> Array:
    """Places of exact values, and those where the density jumps or diverges."""
    points = law.breakpoints[law.breakpoints > 0.0]
    below, above = (law.pdf(points * (1.0 + side)) * law.mean() for side in (-_SAME, _SAME))
    with np.errstate(invalid="ignore"):
        points = points[~(np.abs(above - below) <= _JUMP)]
    return np.concatenate([points, law.atoms[0]])


class ContinuousMixture(Mixture):
    """The mixture at the nodes; quadrature_error as in continuous_mixture."""

    quadrature_error: float
