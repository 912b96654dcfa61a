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

# Panels that the span of a law is cut into at first, and last coefficients at which they are not halved.
PANELS, ACCURACY = 8, 1e-12
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


def stretch_rule(born: Start, most: float, count: int) -> StretchRule:
    """The Gauss rule of `count` nodes for the stretches of `born` below `most` in size.

    It averages polynomials of degree 2 count - 1 over the law exactly. One node where all contacts
    stand at one stretch.
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
    """Gauss rules for laws of stretches, with as many nodes as the survivals ask for.

    Parameters
    ----------
    most : float
        Size of stretches beyond which none holds.
    accuracy : float
        Error of the share that holds that is aimed at.
    shares : callable
        What holds, at many moments, of contacts born at the stretches of a rule.
    until : float
        Reading of time.monotonic() after which no more nodes are tried.

    Attributes
    ----------
    error : float
        By what the rules' shares changed last.
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
