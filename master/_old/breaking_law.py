"""The stretches at which contacts born relaxed break at a temperature, as a law of thresholds."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master._old.piecewise import Piecewise, tabulate
from master._old.thermal_law import ThermalBreaking
from master._old.thermal_paper import PaperBreaking
from origins import Contacts, Thresholds
from origins.thresholds.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]

_ACCURACY = 1e-13
_TAIL = 1e-20
_CUTS, _CLOSE = 40, 1e-3
_TOWARDS = 0.7 ** np.arange(400.0)
_STEEPEST = 30.0  # powers of x beyond which a tail that weighs so little is nothing
_NOISE, _SUMS = 1e-10, 1e-10  # of moments: beyond, what is left of them is not noise; and what tables are off by there
_DOWN, _ACROSS = np.geomspace(1e-12, 1.0, 33)[:-1], np.linspace(0.0, 1.0, 34)[1:-1]
_LADDER, _STEEP, _SEEN = 16.0 ** -np.arange(0.5, 19.0), 1.5, 1e-14
LEAST = 1e-140  # of a mean threshold: squares of it are still numbers


class BreakingLaw(Thresholds):
    """The stretches at which contacts born relaxed break, as a law.

    Parameters
    ----------
    contacts : Contacts with `thermal`
    velocity : float
        v > 0, length per time.

    Attributes
    ----------
    stiffness : Piecewise or None
        The same with the relative stiffness beside each contact, where that depends on the threshold; atoms left out.
    """

    def __init__(self, contacts: Contacts, velocity: float) -> None:
        assert contacts.thermal is not None
        paper = contacts.thermal.closure == "paper"
        breaking = PaperBreaking(contacts, velocity) if paper else ThermalBreaking(contacts, velocity)
        self.breaking: ThermalBreaking | PaperBreaking = breaking
        self._unit, self._attempts = contacts.mean_threshold, contacts.thermal.attempt_frequency / velocity
        self.onset_power = 0.0
        # a threshold of exact value: what has not broken before does there
        self._atoms = breaking.atoms
        left = breaking.held(breaking.atoms, breaking.atoms, np.zeros(breaking.atoms.size))
        self._atom_weights = breaking.atom_weights * left
        self._end = self._reach(_TAIL)
        seeds = np.append(np.linspace(0.0, self._end, 9), breaking.marks[breaking.marks < self._end])
        seeds = np.append(seeds, early(lambda x: breaking.rows(x)[0], self._end, LEAST * self._unit))
        tables = tabulate(self._rows, np.unique(seeds), _ACCURACY)
        self._breaks, self._held = tables[:2]
        self.stiffness: Piecewise | None = tables[2] if breaking.linked else None

    def _reach(self, tail: float) -> float:
        """Stretch that fewer than `tail` pass."""
        low, high = 0.0, self.breaking.top
        for _ in range(_CUTS):
            # the strongest may be any number of times as strong as most
            at = low + (high - low) * _ACROSS if low > 0.0 else high * _DOWN
            passed = int((self.breaking.rows(at)[1] > tail).sum())
            low, high = (at[passed - 1] if passed else low), (at[passed] if passed < at.size else high)
            if high - low < _CLOSE * low:
                break
        # an exact value at the very end is told from what comes before by what comes after
        return float(high) * 1.001 if high in self._atoms else float(high)

    def _rows(self, x: Array) -> Array:
        """p, E in units of the mean threshold, and p with stiffnesses where they differ, shape (rows, *x.shape)."""
        rows = self.breaking.rows(x.ravel())[:3]
        rows[1] /= self._unit
        return rows.reshape(-1, *x.shape)

    @property
    def panels(self) -> Array:
        """Edges between which p and E are series, each halved."""
        edges = self._breaks.edges
        return np.sort(np.append(edges, 0.5 * (edges[1:] + edges[:-1])))

    def beyond(self) -> tuple[Array, Array, Array]:
        """What tails that fall as a power add beyond x = R, where `support` ends: R E and R² E/2 there, the integrals
        of E and x E further on, and what these are off by; shapes (2,). Where all break at one rate they are those of
        S, of which there are closed forms, times what is left; else E falls about as fast as it does at R."""
        end, powers = self._end, np.array([1.0, 2.0])
        last, later = self.breaking.rows(np.array([end, 2.0 * end]))[1].tolist()
        ends = end**powers / powers * last
        fall = np.log2(last / later) if later > 0.0 else np.inf
        if fall > _STEEPEST:
            return ends, np.zeros(2), np.zeros(2)
        if not isinstance(self.breaking, PaperBreaking):
            rest = powers * ends / (fall - powers) if fall > powers[1] else ends
            return ends, rest, rest
        law = self.breaking.law
        edges = np.concatenate([panel_edges(law), law.atoms[0], law.support()[:1], end * _TOWARDS])
        edges = np.unique(np.clip(edges, law.support()[0], end))
        nodes, weights = gauss(edges[:-1], edges[1:])
        held = weights * law.sf(nodes)
        known = edges[0] ** powers / powers + np.array([held.sum(), (held * nodes).sum()])
        whole = np.array([law.mean(), 0.5 * law.moment(2)])
        # of light tails nothing is left but what the sums are off by
        rest = np.where(whole - known > _NOISE * whole, whole - known, 0.0)
        survival = float(law.sf(end))
        share = last / survival if survival > 0.0 else 0.0
        # by themselves hardly any break there: none at more than the attempt frequency
        return ends, share * rest, share * (self._attempts * rest[0] * rest + _SUMS * whole * (rest > 0.0))

    def support(self) -> tuple[float, float]:
        return 0.0, self._end

    @property
    def breakpoints(self) -> Array:
        marks = self.breaking.marks
        return np.append(0.0, marks[marks <= self._end])

    @property
    def atoms(self) -> tuple[Array, Array]:
        felt = self._atom_weights > _TAIL
        return self._atoms[felt], self._atom_weights[felt]

    def _pdf(self, x: Array) -> Array:
        return np.maximum(self._breaks(x), 0.0)

    def _sf(self, x: Array) -> Array:
        return np.clip(self._held(x) * self._unit, 0.0, 1.0)

    def _cdf(self, x: Array) -> Array:
        return np.clip(self._breaks.integral(x) + self._atoms_below(x), 0.0, 1.0)

    def _moment(self, n: int) -> float:
        nodes, weights = gauss(self.panels[:-1], self.panels[1:])
        return float((weights * self._breaks(nodes) * nodes**n).sum()) + float(self._atom_weights @ self._atoms**n)

    def rough_quantiles(self, below: Array, above: Array) -> tuple[Array, Array]:
        edges = self.panels
        x = np.unique(np.concatenate([gauss(edges[:-1], edges[1:])[0].ravel(), edges]))
        # by tables alone: beside round-off at either end they need not rise or fall
        found = np.maximum.accumulate(self._cdf(x)), np.maximum.accumulate(-self._sf(x))
        return np.interp(below, found[0], x), np.interp(-above, found[1], x)

    def _atoms_below(self, x: Array) -> Array:
        total = np.zeros(x.shape)
        for atom, weight in zip(*self.atoms, strict=True):
            total += np.where(x >= atom, weight, 0.0)
        return total


def early(density: Callable[[Array], Array], end: float, least: float) -> Array:
    """Travels towards 0, down to `least`, over which a density of breaks falls steeply: panels as wide as the longest
    lives, up to `end`, would miss it."""
    x = end * _LADDER
    x = x[x > least]
    p = np.maximum(density(x), 1e-300)
    steep = np.flatnonzero((np.abs(np.diff(np.log(p))) > _STEEP) & (np.maximum(p[1:] * x[1:], p[:-1] * x[:-1]) > _SEEN))
    return x[np.unique(np.concatenate([steep, steep + 1]))]
