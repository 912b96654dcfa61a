"""Contacts that form while the slider passes many thresholds: as many break, and what holds follows from the present.

With j births per travel, C, D and E the integrals of S, y S and y² S up to the travel u of the panel so far,

    share that holds = j C - j' D,    force = j D - j' E,

j' the derivative of j by the travel; the next terms are smaller by the square of j'/j times a mean threshold.

Where the speed V, too, changes slowly beside the delay τ, as many form as break, and with a the rise of V by time

    j = j_0 - a j_0^3 (τ D/V + τ^2 C/2),    j_0 = 1/(C + τ V),    force = j D + a τ j_0^2 E/V,

as all contacts hold or wait, j C - j' D + j V τ + ... = 1: those waiting are the births of the delay to come. This is
to first order in a; steadily F is F_k of the present speed (`nearly_steady`).
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from master.soft.inertia.delayed.panel import NODES, POSITION, STAGES, TimePanel
from origins.thresholds.law import Array, ThresholdLaw

# Share of the contacts that still hold after one passage of the slider, of which no account is taken.
STILL_HELD = 1e-12
# Pieces of [0, largest threshold] on which survivals are integrated, and Gauss nodes of each.
PIECES, GAUSS = 24, 6
# Matrices from values at the nodes to the coefficients of the polynomial through them, in powers of the place, and to
# its slopes at the nodes, per width.
_POWERS = np.linalg.inv(np.vander(NODES, STAGES, increasing=True))
_SLOPES_OF_POWERS = np.vander(NODES, STAGES - 1, increasing=True) * np.arange(1, STAGES)
_SLOPES: Array = _SLOPES_OF_POWERS @ _POWERS[1:]
# Most steps of Newton's method for the time at which the slider was at a place: of a polynomial that increases.
MOST_TRIES = 20
# Distance to that place at which the search ends, in ways: the next step squares it.
CLOSE = 1e-8


class BornOnPanel(NamedTuple):
    """Contacts born on the panel, at its nodes: the share that holds, its force, and the error of that (a length)."""

    holding: Array
    force: Array
    missed: float


class NearlySteady(NamedTuple):
    """Contacts of a slider whose sliding is nearly steady, at the nodes of a panel; arrays.

    birth_rate, holding, force : births per time, share that holds, and force along the way (a length)
    by_speed, by_rise : derivatives of the force by the speed V, to leading order, and by its rise by time
    change : part by which sliding changes while a contact lives and waits
    missed : estimate from above of the error of the force (a length): of four laws it was up to a fifth of that
    """

    birth_rate: Array
    holding: Array
    force: Array
    by_speed: Array
    by_rise: Array
    change: Array
    missed: Array


class FastSliding:
    """What the law of thresholds says of contacts on a slider that passes many of them on one panel.

    passage : travel after which hardly any contact holds that formed before it (a length)
    """

    def __init__(self, law: ThresholdLaw) -> None:
        at, weight = np.polynomial.legendre.leggauss(GAUSS)
        self.passage = max([float(law.isf(STILL_HELD)), *law.atoms[0]])
        edges = np.linspace(0.0, self.passage, PIECES + 1)
        half = 0.5 * np.diff(edges)[:, None]
        places = edges[:-1, None] + half * (1.0 + at)
        powers = np.arange(3)[:, None]
        parts = (half * weight * law.sf(places) * places ** powers[:, :, None]).sum(axis=-1)
        sums = np.pad(np.cumsum(parts, axis=1), ((0, 0), (1, 0)))
        slopes = law.sf(edges) * edges**powers
        self._integrals = CubicHermiteSpline(edges, sums.T, slopes.T)

    def at(self, travel: Array, rate: Array, speed: Array, width: float) -> BornOnPanel:
        """At the nodes of a panel of this width: travels (a length), births per time, and speeds, all above 0."""
        c, d, e = self._integrals(np.minimum(travel, self.passage)).T
        j = rate / speed
        rise = (_SLOPES @ j) / width / speed
        force = j * d - rise * e
        # the next terms, squares of j'/j times a mean threshold
        whole_c, whole_d, _ = self._integrals(self.passage)
        off = np.abs(rise) * whole_d**2 / whole_c
        missed = np.divide(off**2, np.abs(force), out=np.zeros(off.size), where=force != 0.0)
        return BornOnPanel(j * c - rise * d, force, float(np.minimum(missed, j * d).max()))

    def nearly_steady(self, speed: Array, rise: Array, delay: float) -> NearlySteady:
        """At speeds above 0 that rise by so much a time, where contacts form again after the delay; see the head of
        this file."""
        c, d, e = self._integrals(self.passage)
        steady = 1.0 / (c + delay * speed)
        lag = steady**3 * (delay * d / speed + 0.5 * delay**2 * c)
        j = steady - rise * lag
        slope = -delay * steady**2 * rise / speed
        change = np.abs(rise) / speed * (e / (d * speed) + delay)
        # without a delay F is the same at all speeds: what is left out is of F that the delay takes
        missed = steady * d * (delay * speed * steady) * change**2
        by_rise = delay * steady**2 * e / speed - lag * d
        by_speed = -delay * steady**2 * d
        return NearlySteady(
            j * speed, j * c - slope * d, j * d - slope * e, by_speed, by_rise, change, missed
        )

    def born(
        self, panel: TimePanel, whole: TimePanel, rate: Array, least_force: float
    ) -> tuple[Array, Array]:
        """Positions and weights of contacts that form on the last thresholds of a panel; `rate`, births per time at the
        nodes of the `whole` panel of which it may be a part. They count as born at one place where all their force is
        below `least_force`."""
        begin, end = (float(panel.at(t, POSITION)) for t in (panel.begin, panel.end))
        direction, far = np.sign(end - begin), min(self.passage, abs(end - begin))
        at, weight = np.polynomial.legendre.leggauss(GAUSS)
        half = 0.5 * far / PIECES
        middle = far * (np.arange(PIECES) + 0.5) / PIECES
        # distances behind the slider at which contacts form, and when it was there, by Newton's method
        back, weights = (middle[:, None] + half * at).ravel(), np.tile(half * weight, PIECES)
        t = np.full(back.size, panel.end)
        for _ in range(MOST_TRIES):
            lack = direction * (end - panel.at(t, POSITION)) - back
            t = np.clip(t + lack / np.abs(panel.slope(t, POSITION)), panel.begin, panel.end)
            if np.abs(lack).max() <= CLOSE * far:
                break
        place = (t - whole.begin) / whole.width
        births = np.vander(place, STAGES, increasing=True) @ (_POWERS @ rate)
        places = end - direction * back
        fraction = weights * births / np.abs(panel.slope(t, POSITION))
        born = float(fraction.sum())
        if 0.0 < born * far <= least_force:
            return np.array([float(fraction @ places) / born]), np.array([born])
        return places, fraction
