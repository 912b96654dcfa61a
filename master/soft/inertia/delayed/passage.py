"""Contacts that form while the slider passes many thresholds: as many break, and what holds follows from the present.

With j births per travel, C, D and E the integrals of S, y S and y² S up to the travel u of the panel so far,

    share that holds = j C - j' D,    force = j D - j' E,

j' the derivative of j by the travel; the next terms are smaller by the square of j'/j times a mean threshold.
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from master.soft.inertia.delayed.panel import NODES, POSITION, STAGES, Panel
from origins.thresholds.law import Array, ThresholdLaw

# Pieces of [0, largest threshold] on which survivals are integrated, and Gauss nodes of each.
PIECES, GAUSS = 24, 6
# Matrices from values at the nodes to the polynomial's coefficients, and to its slopes at the nodes, per width.
_POWERS = np.linalg.inv(np.vander(NODES, STAGES, increasing=True))
_SLOPES: Array = (np.vander(NODES, STAGES - 1, increasing=True) * np.arange(1, STAGES)) @ _POWERS[
    1:
]


class Passing(NamedTuple):
    """Contacts born on the panel, at its nodes: the share that holds, its force, and the error of that (a length)."""

    holding: Array
    force: Array
    missed: float


class Passage:
    """What the law of thresholds says of contacts on a slider that passes them.

    longest : travel after which no contact holds any more (a length)
    """

    def __init__(self, law: ThresholdLaw, longest: float) -> None:
        at, weight = np.polynomial.legendre.leggauss(GAUSS)
        edges = np.linspace(0.0, longest, PIECES + 1)
        half = 0.5 * np.diff(edges)[:, None]
        places = edges[:-1, None] + half * (1.0 + at)
        self.longest, self._law = longest, law
        powers = np.arange(3)[:, None]
        parts = (half * weight * law.sf(places) * places ** powers[:, :, None]).sum(axis=-1)
        sums = np.pad(np.cumsum(parts, axis=1), ((0, 0), (1, 0)))
        slopes = law.sf(edges) * edges**powers
        self._integrals = CubicHermiteSpline(edges, sums.T, slopes.T)

    def at(self, travel: Array, rate: Array, speed: Array, width: float) -> Passing:
        """At the nodes of a panel of this width: travels (a length), births per time, and speeds, all above 0."""
        c, d, e = self._integrals(np.minimum(travel, self.longest)).T
        j = rate / speed
        rise = (_SLOPES @ j) / width / speed
        force = j * d - rise * e
        off = (
            np.abs(rise) * self._integrals(self.longest)[1] ** 2 / self._integrals(self.longest)[0]
        )
        missed = np.divide(off**2, np.abs(force), out=np.zeros(off.size), where=force != 0.0)
        return Passing(j * c - rise * d, force, float(np.minimum(missed, j * d).max()))

    def born(self, panel: Panel, whole: Panel, rate: Array) -> tuple[Array, Array]:
        """Positions and weights of contacts that form on the last thresholds of a panel; `rate`, births per time at the
        nodes of the `whole` panel of which it may be a part."""
        begin, end = (float(panel.at(t, POSITION)) for t in (panel.begin, panel.end))
        way, far = np.sign(end - begin), min(self.longest, abs(end - begin))
        at, weight = np.polynomial.legendre.leggauss(GAUSS)
        half = 0.5 * far / PIECES
        middle = far * (np.arange(PIECES) + 0.5) / PIECES
        back = (middle[:, None] + half * at).ravel()
        weights = np.tile(half * weight, PIECES)
        t = np.full(back.size, panel.end)
        for _ in range(20):
            lack = way * (end - panel.at(t, POSITION)) - back
            t = np.clip(t + lack / np.abs(panel.slope(t, POSITION)), panel.begin, panel.end)
        place = (t - whole.begin) / whole.width
        births = np.vander(place, STAGES, increasing=True) @ (_POWERS @ rate)
        speed = np.abs(panel.slope(t, POSITION))
        return end - way * back, weights * births / speed
