"""The plain twin of soft sliders at T = 0 under "reform-after": births at Gauss's nodes, sums over all of them.

With b(X) the births per travel, p and S = 1 - P the density of thresholds and the survival,

    b(X) = sum over births of p(X - u),        F(X) = sum over births of (X - u) k(X - u),

k(x) being the stiffness of contacts whose threshold is above x. A slip begins where F' = -K; on its way nothing is
born; where F + K X is again what it was, all that broke forms. The drive moves forward, from relaxed contacts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.optimize import brentq
from scipy.stats import norm

NODES, WEIGHTS = (0.5 * (1.0 + leggauss(12)[0]), 0.5 * leggauss(12)[1])
WITHIN, OF_WITHIN = (0.5 * (1.0 + leggauss(20)[0]), 0.5 * leggauss(20)[1])
Function = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Law:
    """Thresholds: density, survival, stiffness beyond x over <k>; the width of a panel; the mean, and the largest."""

    pdf: Function
    sf: Function
    stiffness: Function
    width: float
    mean: float
    largest: float
    linked: bool


def groups(parts: list[tuple[float, float, float]], linked: bool = False) -> Law:
    """Normal thresholds above 0 of these shares, means and widths."""

    def over(term: Callable[[float, float, np.ndarray], np.ndarray]) -> Function:
        return lambda x: sum(
            share * term(mean, std, np.asarray(x)) / norm.sf(-mean / std)
            for share, mean, std in parts
        )

    pdf = over(lambda mean, std, x: norm.pdf((x - mean) / std) / std * (x >= 0.0))
    sf = over(lambda mean, std, x: norm.sf((x - mean) / std))
    # the integral of x p(x) from x on
    first = over(
        lambda mean, std, x: mean * norm.sf((x - mean) / std) + std * norm.pdf((x - mean) / std)
    )
    mean = float(first(np.zeros(1))[0])
    width, largest = (
        0.8 * min(std for _, _, std in parts),
        max(mean + 9.0 * std for _, mean, std in parts),
    )
    return Law(pdf, sf, (lambda x: first(x) / mean) if linked else sf, width, mean, largest, linked)


def between(z: np.ndarray) -> np.ndarray:
    """Matrix from values at the nodes of a panel to those at places z of it, 0 to 1."""
    others = NODES[:, None] - NODES + np.eye(NODES.size)
    away = z[:, None] - NODES
    terms = 1.0 / (np.where(away == 0.0, 1e-300, away) * others.prod(axis=1))
    return terms / terms.sum(axis=1, keepdims=True)


class Pulled:
    """Contacts by the positions `born` and the numbers `births`, X counted from the last slip.

    slips : rows of X_T, F before and after, and the fraction of the contacts that breaks
    """

    def __init__(self, law: Law, spring: float) -> None:
        self.law, self.spring, self.born, self.births = law, spring, np.zeros(1), np.ones(1)
        self.position, self.slips = 0.0, list[tuple[float, float, float, float]]()
        of_panel = law.width * NODES
        self.own_breaks = np.array([self.of_panel(law.pdf, y) for y in of_panel])

    def force(self, x: np.ndarray) -> np.ndarray:
        """Of a contact stretched by x."""
        return np.asarray(x * self.law.stiffness(x))

    def slope(self, x: np.ndarray) -> np.ndarray:
        """Of that force."""
        of_break = x / self.law.mean if self.law.linked else 1.0
        return np.asarray(self.law.stiffness(x) - x * of_break * self.law.pdf(x))

    def of_panel(self, term: Function, y: float) -> np.ndarray:
        """What births at the nodes of a panel give up to the travel y on it."""
        values = term(y * (1.0 - WITHIN)) * OF_WITHIN * y
        return np.asarray(values @ between(y * WITHIN / self.law.width))

    def slip_after(self, travel: float) -> float | None:
        """Follow the slider until F' = -K; X there, None where it goes on for so far."""
        law, x = self.law, 0.0
        while x < travel:
            nodes = x + law.width * NODES
            breaks = law.pdf(nodes[:, None] - self.born) @ self.births
            rate = np.linalg.solve(np.eye(NODES.size) - self.own_breaks, breaks)

            def rise(y: float, x: float = x, rate: np.ndarray = rate) -> float:
                of_old = self.slope(x + y - self.born) @ self.births
                return float(of_old + self.of_panel(self.slope, y) @ rate + self.spring)

            ends = np.linspace(0.0, law.width, 5)
            falls = np.flatnonzero([rise(y) < 0.0 for y in ends])
            y = (
                brentq(rise, *ends[falls[0] - 1 : falls[0] + 1], xtol=1e-16)
                if falls.size
                else law.width
            )
            at = between(y * NODES / law.width) @ rate
            self.born = np.append(self.born, x + y * NODES)
            self.births = np.append(self.births, WEIGHTS * y * at)
            x += y
            if falls.size:
                return x
        return None

    def slip(self, x: float) -> None:
        """Let the slider slip from X, and all that broke form where it ends."""
        before = float(self.force(x - self.born) @ self.births)

        def load(y: float) -> float:
            return float(self.force(x + y - self.born) @ self.births) - before + self.spring * y

        low, y = 0.0, 1e-3 * self.law.width
        assert load(y) < 0.0
        while load(y) < 0.0:
            low, y = y, y + 0.05 * self.law.width
        y = brentq(load, low, y, xtol=1e-16)
        after = float(self.force(x + y - self.born) @ self.births)
        broken = 1.0 - float(self.law.sf(x + y - self.born) @ self.births)
        self.slips.append((self.position + x + before / self.spring, before, after, broken))
        self.position += x + y
        self.born = np.append(self.born - (x + y), 0.0)
        self.births = np.append(self.births, broken)
        holds = self.born > -self.law.largest
        self.born, self.births = self.born[holds], self.births[holds]


def pulled(law: Law, spring: float, slips: int) -> np.ndarray:
    """Rows of so many slips, or fewer where none follows within ten mean thresholds; see Pulled."""
    slider = Pulled(law, spring)
    while len(slider.slips) < slips and (x := slider.slip_after(10.0 * law.mean)) is not None:
        slider.slip(x)
    return np.array(slider.slips)
