"""Soft contacts so cold that those which break below their thresholds are a thin layer of the law.

As every contact breaks where its A reaches a number e of the exponential law, what is left of a strand is the mean,
over e, of the survival S beyond the threshold whose A has reached e: with A = W e^(-ξ²/2T) and m the largest |x|,

    S(m) e^(-A(m)) + integral of e^(-e) S(ξ(e)) de up to A(m),        ξ(e)² = 2T ln(W/e).

S hardly changes over the layer, so that few nodes in ln e see through it, however low the temperature.
"""

import numpy as np
import numpy.typing as npt

from master._old.cut_law import SLACK
from master._old.thermal_wear import Softly
from master._old.timeline import Piece
from master._old.wear import Left
from origins import Contacts
from origins.thresholds.scipy_laws import FrozenThresholds

Array = npt.NDArray[np.float64]

_TOP = 3.7  # ln A: e^(-A) is nothing
_DEPTH = 40.0
_RULES = ((2.5, 4), (1.25, 5), (1.25, 8), (0.625, 8), (0.3125, 8))  # lengths of panels in ln e, and nodes on them
_FINE = 10.0  # of ln e, beyond which all is in proportion to e
_ACCURACY = 1e-10
_SAMPLE = 150
_LEAST = 1e-12  # of the mean threshold
_CHUNK = 20_000
_BESIDE = (-3.0, 4.0)  # ln A between which a contact hardly holds, and hardly breaks
_MOST_SPEEDS = 3
_FROZEN = 20.0  # functions of scipy.stats


class LayerWear(Softly):
    """The same as master.thermal_wear.SoftWear."""

    forgets = False

    def __init__(self, contacts: Contacts, length: float) -> None:
        thermal = contacts.thermal
        assert thermal is not None
        super().__init__(contacts, length)
        self._law = contacts.thresholds
        self._atoms, self._atom_weights = self._law.atoms
        self.slow = _FROZEN if isinstance(self._law, FrozenThresholds) else 2.0
        self._least = _LEAST * contacts.mean_threshold
        self.error, (self._way, self._weights) = self._chosen()
        self.work = self._way.size + 50
        self.skin = thermal.temperature / contacts.mean_threshold

    def left(self, worn: Array, stretch: Array, furthest: Array) -> Left:
        reached = furthest * (1.0 + SLACK)
        level = worn[:, 0] - self._spring * furthest * furthest
        kept = np.exp(-np.exp(np.minimum(level, _TOP + 4.0)))
        held = kept * self._beyond(reached)
        inner = np.flatnonzero(level > -_DEPTH)
        rows = max(1, _CHUNK // self._way.size)
        for i in range(0, inner.size, rows):
            some = inner[i : i + rows]
            held[some] += self._layer(level[some], furthest[some], self._way, self._weights)
        for atom, weight in zip(self._atoms, self._atom_weights, strict=True):
            spent = np.exp(np.minimum(worn[:, 0] - self._spring * atom * atom, _TOP + 4.0))
            held += weight * (reached < atom) * np.exp(-spent)
        edge = self._law.pdf(furthest) * kept
        return Left(held, held, edge, edge)

    def keeper(self) -> None:
        return None

    def _layer(self, level: Array, furthest: Array, way: Array, weights: Array) -> Array:
        """The integral, from ln A(m) and m; the rule's nodes lie so far below the largest e that is felt."""
        top = np.minimum(level, _TOP)
        most = np.exp(top)
        share = np.exp(-most[:, None] * np.exp(-way)) * weights
        # all nodes together weigh as much as there is
        share *= (-np.expm1(-most) / share.sum(axis=1))[:, None]
        rise = ((level - top)[:, None] + way) / self._spring
        return np.asarray((share * self._beyond(np.sqrt(furthest[:, None] ** 2 + rise))).sum(axis=1))

    def _beyond(self, x: Array) -> Array:
        """S without exact single values."""
        out = self._law.sf(x)
        for atom, weight in zip(self._atoms, self._atom_weights, strict=True):
            out = out - weight * (x < atom)
        return out

    def _chosen(self) -> tuple[float, tuple[Array, Array]]:
        """A rule fine enough, and what it is off by, as finer ones tell."""
        shares = (np.arange(_SAMPLE) + 0.5) / _SAMPLE
        places = np.concatenate([self._law.ppf(shares), self._law.isf(10.0 ** np.linspace(-9.0, -2.5, 20)),
                                 self._law.breakpoints])
        places = np.unique(places[(places > self._least) & np.isfinite(places)])
        level, furthest = np.empty(0), np.empty(0)
        for way in (-2.0, 0.0, 1.5, 3.0, 20.0):  # ln A at the largest |x|
            x = np.sqrt(np.maximum(places**2 - max(way, 0.0) / self._spring, 0.0))
            level, furthest = np.append(level, np.full(x.size, way)), np.append(furthest, x)
        level[-places.size :] = self._spring * places**2
        furthest[-places.size :] = 0.0
        best: tuple[float, tuple[Array, Array]] | None = None
        finest = self._layer(level, furthest, *_rule(*_RULES[-1]))
        for rule in _RULES[:-1]:
            one = _rule(*rule)
            error = float(np.abs(self._layer(level, furthest, *one) - finest).max(initial=0.0))
            if best is None or error < best[0]:
                best = error, one
            if error < _ACCURACY:
                break
        assert best is not None
        return best[0] + 1e-15, best[1]


def reaches(contacts: Contacts, limits: Array, course: list[Piece]) -> Array:
    """Stretches between which relaxed contacts of these thresholds break by themselves, at the speeds of a course and
    in its holds."""
    thermal = contacts.thermal
    assert thermal is not None
    springs, rooted = contacts.relative_stiffness(limits), thermal.rates.vanishes_at_threshold
    barrier = springs * limits**2 / (2.0 * thermal.temperature)
    lasts = sorted({float(f"{one.duration:.2g}") for one in course if one.travel == 0.0})
    speeds = sorted({float(f"{abs(one.travel) / one.duration:.2g}") for one in course if one.travel != 0.0})
    out = [np.empty(0)]
    for way in _BESIDE:
        for speed in speeds[:_MOST_SPEEDS]:
            x = thermal.inverse(np.full(limits.size, speed * np.exp(way)), limits, 0.0, springs)
            out.append(x[x < limits])
        for last in lasts[-_MOST_SPEEDS:]:
            share = (np.log(thermal.attempt_frequency * last) - way) / barrier
            inside = (share > 0.0) & (share < 1.0)
            left = share[inside]
            out.append(limits[inside] * (1.0 - np.cbrt(left) ** 2 if rooted else np.sqrt(1.0 - left)))
    return np.unique(np.concatenate(out))


def _rule(length: float, number: int) -> tuple[Array, Array]:
    """Ways y below the largest ln e, and weights of e^(-y) dy."""
    edges = np.concatenate([np.arange(0.0, _FINE, length), [_FINE, 1.5 * _FINE, 2.5 * _FINE, _DEPTH]])
    nodes, weights = np.polynomial.legendre.leggauss(number)
    width = np.diff(edges)[:, None]
    way = (edges[:-1, None] + width * (0.5 * (nodes + 1.0))).ravel()
    return way, (width * (0.5 * weights)).ravel() * np.exp(-way)
