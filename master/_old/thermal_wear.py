"""Contacts that break at their own rates h(|x|; ξ), with closure "exact".

A contact that holds with its threshold ξ has done so with the probability e^(-A), A the integral of h over time. Of
soft contacts that are equally stiff h is a product, ω e^(-ξ²/2T) e^(x²/2T), so that one number for each strand, the
integral W of ω e^(x²/2T), is all there is to remember: A = W e^(-ξ²/2T).
"""

import numpy as np
import numpy.typing as npt

from master._old.cut_law import SLACK, CutLaw
from master._old.wear import Keeper, Left
from origins import Contacts, SoftRates
from origins.thresholds.quadrature import NODES, finite_density, gauss, panel_edges

Array = npt.NDArray[np.float64]

_GONE = 6.0  # e^(-e^6) is nothing
_CHANGE = 1.5  # of ln A that eight nodes see through, but for ERROR
ERROR = 5e-9
_CHUNK = 40_000
_NEVER = -35.0  # ln A
_WEAK = 0.3
_STEEPER = 1.75  # a stiff contact's barrier changes so much faster with its threshold, at most


def resolved(contacts: Contacts, furthest: float, longest: float) -> tuple[Array, Array]:
    """Thresholds, and the widths over which ln A changes by as much as nodes see through; none break, and all is wide,
    far beyond the `furthest` stretch in the `longest` time."""
    thermal = contacts.thermal
    assert thermal is not None
    at = contacts.mean_threshold * 2.0 ** np.linspace(-20.0, 20.0, 400)
    steep = _STEEPER if thermal.rates.vanishes_at_threshold else 1.0
    springs = contacts.relative_stiffness(at)
    widths = _CHANGE / steep * thermal.temperature / (at * springs)
    if np.isfinite(furthest):
        cost = thermal.log_rate(np.minimum(furthest, at), at, springs) + np.log(longest)
        widths[1:][(at[:-1] > furthest) & (cost[:-1] < _NEVER)] = np.inf
    return at, widths


def error_of(cut: CutLaw) -> float:
    """What sums over nodes are off by; where these are too few, e^(-A) is a step between them."""
    return ERROR * cut.spread**4 if cut.spread < 2.0 else 0.3 * float(np.abs(np.diff(cut.law.sf(cut.edges))).max())


def fresh_rate(contacts: Contacts) -> float:
    """Rate at which relaxed fresh contacts break; the weakest three in ten do not count, as it is soon gone
    and others feel little of it."""
    thermal, law = contacts.thermal, contacts.thresholds
    assert thermal is not None
    weakest = float(law.isf(1.0 - _WEAK))
    edges = panel_edges(law)
    nodes, weights = gauss(edges[:-1], edges[1:])
    nodes, weights = np.append(nodes, law.atoms[0]), np.append(weights * finite_density(law, nodes), law.atoms[1])
    rates = thermal.rate(np.zeros(nodes.size), nodes, contacts.relative_stiffness(nodes))
    return min(float(weights @ rates), float(thermal.rate(0.0, weakest, contacts.relative_stiffness(weakest))))


class Softly:
    """What equally stiff soft contacts keep of the past: one number, ln W; h = ω e^(-barrier) e^(x²/2T), and W is what
    the last factor adds up to, in attempts."""

    width = 1

    def __init__(self, contacts: Contacts, length: float) -> None:
        thermal = contacts.thermal
        assert thermal is not None
        self._growth = SoftRates(thermal.temperature)
        self._spring, self._log_frequency = 0.5 / thermal.temperature, float(np.log(thermal.attempt_frequency))
        self.length, self.time, self.rate = length, 1.0 / thermal.attempt_frequency, fresh_rate(contacts)

    def fresh(self, stretch: Array) -> Array:
        return np.full((stretch.size, 1), -np.inf)

    def advance(self, worn: Array, begin: Array, end: Array, furthest: Array, duration: float | Array) -> None:
        if np.any(duration):
            with np.errstate(divide="ignore"):
                spent = _log_mean(begin, end, self._growth) + (self._log_frequency + np.log(duration))
            np.logaddexp(worn[:, 0], spent, out=worn[:, 0])

    def settle(self, worn: Array, stretch: Array, furthest: Array) -> None:
        pass


class SoftWear(Softly):
    """Their thresholds' density on nodes."""

    forgets, slow, skin = False, 1.0, 0.0

    def __init__(self, contacts: Contacts, cut: CutLaw, length: float) -> None:
        super().__init__(contacts, length)
        self._contacts, self._cut = contacts, cut
        self.error, self.work = error_of(cut), cut.nodes.size + 50
        self._barrier, self._atom_barrier = (self._spring * at * at for at in (cut.nodes, cut.atoms))

    def left(self, worn: Array, stretch: Array, furthest: Array) -> Left:
        cut, level = self._cut, worn[:, 0]
        panel = cut.panel(furthest)
        held = np.empty(level.size)
        rows = max(1, _CHUNK // max(self._barrier.size, 1))
        first = NODES * (panel + 1)
        order = np.argsort(first, kind="stable")
        for i in range(0, level.size, rows):
            some = order[i : i + rows]
            # panels below all cuts need not be looked at
            low = int(first[some[0]])
            share = _kept(level[some, None] - self._barrier[low:])
            if first[some[-1]] > low:
                share *= np.arange(low, self._barrier.size) >= first[some, None]
            held[some] = share @ cut.weights[low:]
        inside = np.flatnonzero((panel >= 0) & (panel < cut.edges.size - 1))
        if inside.size:
            nodes, weights = cut.own(furthest[inside], panel[inside])
            held[inside] += (weights * _kept(level[inside, None] - self._spring * nodes * nodes)).sum(-1)
        for atom, weight, barrier in zip(cut.atoms, cut.atom_weights, self._atom_barrier, strict=True):
            held += weight * (furthest * (1.0 + SLACK) < atom) * _kept(level - barrier)
        edge = cut.law.pdf(furthest) * _kept(level - self._spring * furthest * furthest)
        return Left(held, held, edge, edge)

    def keeper(self) -> Keeper:
        # of contacts of many ages W does not tell enough
        from master._old.spent_wear import SpentWear

        return SpentWear(self._contacts, self._cut, self.length, plain=True)


def _log_mean(begin: Array, end: Array, rates: SoftRates) -> Array:
    """ln of the mean of e^(x²/2T) between two stretches, by the formulas of a soft contact of threshold 0 and ω = 1."""
    first, last = np.abs(begin), np.abs(end)
    near, far = np.minimum(first, last), np.maximum(first, last)
    way = np.abs(end - begin)
    out = np.asarray(0.5 / rates.temperature * far * far)
    moved = way > 1e-12 * far
    across = moved & ((begin < 0.0) != (end < 0.0)) & (near > 0.0)
    plain = moved & ~across
    with np.errstate(divide="ignore"):
        if plain.any():
            both = rates.log_passed(near[plain], far[plain], 0.0, 1.0)
            out[plain] = both - np.log(way[plain])
        if across.any():
            parts = (rates.log_passed(0.0, some[across], 0.0, 1.0) for some in (near, far))
            out[across] = np.logaddexp(*parts) - np.log(way[across])
    return out


def _kept(log_spent: Array) -> Array:
    """e^(-A)."""
    out = np.minimum(log_spent, _GONE)
    np.exp(out, out=out)
    np.negative(out, out=out)
    return np.exp(out, out=out)
