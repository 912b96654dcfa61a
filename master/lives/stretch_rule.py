"""Sums over the stretches at which contacts start or form again."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.lives.halving import Pieces, nodes_of
from origins.start import Start
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]

# First number of panels of a law's span, and last coefficients below which they are not halved.
PANELS, ACCURACY = 8, 1e-12
# Numbers of stretches that represent a law, tried in this order; the last one gives some 1e-8 for a
# start across 0, where survivals of contacts that age have a kink.
COUNTS = (6, 9, 13, 19, 28)


class StretchRule(NamedTuple):
    """Stretches that represent a law of stretches, and their weights.

    stretch : array of shape (n,), lengths
    weight : array of shape (n,), of sum 1
    """

    stretch: Array
    weight: Array


def stretch_rule(born: Start, most: float, count: int) -> StretchRule:
    """The Gauss rule of `count` nodes for the stretches of `born` below `most` in size.

    It averages polynomials of degree 2 count - 1 over the law exactly. It has one node where all
    contacts have the same stretch.
    """
    if born.is_single:
        return StretchRule(np.array([born.mean()]), np.ones(1))
    low, high = max(born.span[0], -most), min(born.span[1], most)
    edges = np.append(np.linspace(low, high, PANELS + 1), born.breakpoints)
    edges = np.unique(np.clip(edges, low, high))
    whole = Pieces(np.zeros(edges.size - 1, dtype=int), edges[:-1], edges[1:])
    nodes, weights = nodes_of(lambda _, x: finite_density(born, x)[None], whole, ACCURACY)
    kept = weights > 0.0
    nodes, weights = nodes[kept], weights[kept] / weights[kept].sum()
    if nodes.size <= count:
        return StretchRule(nodes, weights)
    # orthogonal polynomials on the nodes: their Jacobi matrix has the rule's nodes as eigenvalues
    middle, scale = 0.5 * (nodes.min() + nodes.max()), 0.5 * np.ptp(nodes)
    at, root = (nodes - middle) / scale, np.sqrt(weights)
    basis = np.linalg.qr(root[:, None] * legendre.legvander(at, count - 1))[0]
    values, vectors = np.linalg.eigh(basis.T @ (at[:, None] * basis))
    return StretchRule(middle + scale * values, (root @ basis @ vectors) ** 2)


class StretchRules:
    """Gauss rules for laws of stretches, with as many nodes as the survivals need.

    Parameters
    ----------
    most : float
        |x| beyond which no contact holds.
    accuracy : float
        Aimed-at error of the share that holds.
    shares : callable
        Share that holds, at many moments, of contacts born at the stretches of a rule.
    until : float
        Reading of time.monotonic() after which no more nodes are tried.

    Attributes
    ----------
    error : float
        Largest last change of the shares with the number of nodes.
    """

    def __init__(
        self,
        most: float,
        accuracy: float,
        shares: Callable[[StretchRule], Array],
        until: float = np.inf,
    ) -> None:
        self._most, self._accuracy, self._shares, self._until = most, accuracy, shares, until
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
                if missed <= self._accuracy or clock.monotonic() > self._until:
                    break
            self.error = max(self.error, missed)
        self._known.append((born, rule))
        return rule
