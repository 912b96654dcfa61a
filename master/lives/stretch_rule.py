"""Sums over the stretches at which contacts start or form again."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.start import Start
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

# Panels that the span of a law is cut into at first; a normal law of 16.6 standard deviations is
# then integrated to 1e-14 by eight Gauss nodes each.
PANELS = 16
# Times that a panel is halved at most: beside a density that diverges what is left weighs nothing.
HALVINGS = 40
# Share of all weight that a panel may be off by.
ACCURACY = 1e-14
# Numbers of stretches that stand for a law, tried one after the other: with the last of them a start
# across 0, where survivals of contacts that age bend, is good to some 1e-8.
COUNTS = (6, 9, 13, 19, 28)


class StretchRule(NamedTuple):
    """Stretches that stand for a law of stretches, and their weights.

    stretch : array of shape (n,), lengths
    weight : array of shape (n,), of sum 1
    """

    stretch: Array
    weight: Array


def stretch_panels(born: Start) -> Array:
    """Edges of panels on each of which eight Gauss nodes integrate the density of the stretches.

    Returns an array of shape (n + 1,), lengths. `born` has a density.
    """
    low, high = born.span
    inner = born.breakpoints[(born.breakpoints > low) & (born.breakpoints < high)]
    edges = np.unique(np.concatenate([np.linspace(low, high, PANELS + 1), inner]))
    done = [edges]
    left, right = edges[:-1], edges[1:]
    for _ in range(HALVINGS):
        middle = 0.5 * (left + right)
        halves = _weight(born, left, middle) + _weight(born, middle, right)
        rough = np.abs(_weight(born, left, right) - halves) > ACCURACY
        done.append(middle[rough])
        if not rough.any():
            break
        left, right = (
            np.append(left[rough], middle[rough]),
            np.append(middle[rough], right[rough]),
        )
    return np.unique(np.concatenate(done))


def finite_density(born: Start, stretch: Array) -> Array:
    """Density of the stretches, 0 where a node was rounded onto a point at which it diverges."""
    density = np.asarray(born.pdf(stretch))
    return np.where(np.isfinite(density), density, 0.0)


def _weight(born: Start, left: Array, right: Array) -> Array:
    nodes, weights = gauss(left, right)
    return np.asarray((weights * finite_density(born, nodes)).sum(axis=-1))


def stretch_rule(born: Start, most: float, count: int) -> StretchRule:
    """The Gauss rule of `count` nodes for the stretches of `born` below `most` in size.

    It averages polynomials of degree 2 count - 1 over the law exactly; by Lanczos' steps. One
    node where all contacts stand at one stretch.
    """
    if born.is_single:
        return StretchRule(np.array([born.mean()]), np.ones(1))
    edges = stretch_panels(born)
    nodes, weights = gauss(edges[:-1], edges[1:])
    weights = (weights * finite_density(born, nodes)).ravel()
    kept = (weights > 0.0) & (np.abs(nodes.ravel()) < most)
    nodes, weights = nodes.ravel()[kept], weights[kept] / weights[kept].sum()
    if nodes.size <= count:
        return StretchRule(nodes, weights)
    return _gauss_rule(nodes, weights, count)


class StretchRules:
    """Gauss rules for laws of stretches, with as many nodes as the survivals ask for.

    Parameters
    ----------
    most : float
        Size of stretches beyond which none holds.
    accuracy : float
        Error of the share that holds that is aimed at.
    shares : callable
        What holds, at many moments, of contacts born at the stretches of a rule.

    Attributes
    ----------
    error : float
        By what the rules' shares changed last.
    """

    def __init__(
        self, most: float, accuracy: float, shares: Callable[[StretchRule], Array]
    ) -> None:
        self._most, self._accuracy, self._shares = most, accuracy, shares
        self._known: list[tuple[Start, StretchRule]] = []
        self.error = 0.0

    def of(self, born: Start) -> StretchRule:
        """The rule for stretches of the law `born`; the same object has the same rule."""
        for known, rule in self._known:
            if known is born:
                return rule
        rule = stretch_rule(born, self._most, COUNTS[0])
        if rule.stretch.size > 1:
            before, missed = self._shares(rule), np.inf
            for count in COUNTS[1:]:
                rule = stretch_rule(born, self._most, count)
                now = self._shares(rule)
                missed, before = float(np.abs(now - before).max()), now
                if missed <= self._accuracy:
                    break
            self.error = max(self.error, missed)
        self._known.append((born, rule))
        return rule


def _gauss_rule(nodes: Array, weights: Array, count: int) -> StretchRule:
    """Gauss rule for a law of many nodes: eigenvalues of the Jacobi matrix that Lanczos finds."""
    middle, scale = 0.5 * (nodes.min() + nodes.max()), 0.5 * np.ptp(nodes)
    at = (nodes - middle) / scale
    basis = [np.sqrt(weights)]
    jacobi = np.zeros((count + 1, count + 1))
    for k in range(count):
        vector = at * basis[-1]
        jacobi[k, k] = vector @ basis[-1]
        for _ in range(2):  # twice, or round-off brings the old directions back
            for old in basis:
                vector = vector - (old @ vector) * old
        jacobi[k, k + 1] = jacobi[k + 1, k] = np.linalg.norm(vector)
        basis.append(vector / jacobi[k, k + 1])
    values, vectors = np.linalg.eigh(jacobi[:count, :count])
    return StretchRule(middle + scale * values, vectors[0] ** 2)
