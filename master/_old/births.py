"""Contacts that stand at stretches of a given law: how stiff they are, and when those that form again so break."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master._old.first import FirstBreaks
from master._old.law import Law
from master._old.piecewise import tabulate
from master._old.starting import StartSum
from origins import Contacts, Thresholds

if TYPE_CHECKING:
    from master._old.origin_breaks import Breaking

Array = npt.NDArray[np.float64]

_ACCURACY, _BY_A_RATE = 1e-14, 1e-11
_FELT = 1e-13
_SOME, _NONE = 0.5, 1e-20  # of the way to the furthest birth; of the contacts


def standing(contacts: Contacts, unit: float) -> tuple[float, float]:
    """Means of k x and of k over the start of `contacts`, x in `unit`s."""
    law = Law(contacts, np.inf, unit=unit)
    single = contacts.start.is_single
    if contacts.stiffness == "independent":
        return (contacts.start.mean() / unit if single else StartSum(contacts, law).mean), 1.0
    beyond = tabulate(lambda x: (x * law.pdf(x))[None], law.edges, _ACCURACY)[0] if law.edges.size > 1 else None

    def stiffness(x: Array) -> Array:
        """Integral of k P_c beyond |x|."""
        least = np.abs(x)
        total = np.zeros(x.shape) if beyond is None else beyond.total - beyond.integral(least)
        for atom, weight in zip(law.atoms, law.atom_weights, strict=True):
            total = total + np.where(atom > least, weight * atom, 0.0)
        return total * unit / contacts.mean_threshold

    if single:
        x = np.array([contacts.start.mean() / unit])
        mean = float((stiffness(x) / law.sf(np.abs(x)))[0])
        return float(x[0]) * mean, mean
    nodes, shares = StartSum(contacts, law).sample
    found = shares * stiffness(nodes)
    return float((found * nodes).sum()), float(found.sum())


def born(contacts: Contacts, unit: float, breaking: "Breaking | None", law: Thresholds) -> FirstBreaks:
    """Breaks after births by `contacts.reforming`, over the travel since the birth in `unit`s."""
    assert contacts.reforming is not None
    law_of = contacts.reforming.law
    again = contacts.replace(start=law_of, delay=None, reforming=None)
    if breaking is None:
        far = Law(again, np.inf)
        end = float(np.concatenate([far.edges, far.atoms]).max()) - min(law_of.span[0] / unit, 0.0)
        return FirstBreaks(again, far, end, _ACCURACY)
    from master._old.origin_breaks import OriginBreaks

    breaking = breaking.of(law_of)
    end = (min(breaking.top, _furthest(again, breaking, law)) - law_of.span[0]) / unit
    return OriginBreaks(again, Law(again, np.inf, law, unit), breaking, end, _BY_A_RATE)


def _furthest(again: Contacts, breaking: "Breaking", law: Thresholds) -> float:
    """Stretch that next to none of these contacts passes: one that sums over all thresholds pass may be any number of
    times as far."""
    far, mean = max(law.support()[1], *np.abs(again.start.span)), again.start.mean()
    origins = mean + np.array([-_SOME, 0.0, _SOME]) * (np.array([mean, mean, mean]) - again.start.span[0])
    held = np.maximum(again.thresholds.sf(np.abs(origins)), 1e-300)
    while far < breaking.top and (breaking.rows(np.full(3, far), origins)[1] > _NONE * held).any():
        far *= 2.0
    return float(far)


class TravelLaw(Thresholds):
    """The law p of the travel from one break to the next: a wait, then a stretch from r to the break.

    Parameters
    ----------
    relaxed : Thresholds
        Stretches at which relaxed births break.
    after : FirstBreaks or None
        Breaks after births at other stretches, in `unit`s; None: births are relaxed.
    delay, unit : float
        Lengths.
    """

    def __init__(self, relaxed: Thresholds, after: FirstBreaks | None, delay: float, unit: float) -> None:
        self._relaxed, self._after, self._delay, self._unit = relaxed, after, delay, unit
        self.onset_power = relaxed.onset_power
        self.knows_breakpoints = relaxed.knows_breakpoints
        if after is None:
            lower, upper = relaxed.support()
            marks = relaxed.breakpoints
            positions, self._weights = relaxed.atoms
            begins = float(relaxed.pdf(lower))
        else:
            table = after.density
            positions, self._weights = after.atoms * unit, after.atom_weights
            ends = np.append(table.edges[[0, -1]] * unit, positions)
            lower, upper = float(ends.min()), float(ends.max()) * 1.001
            marks = np.append(after.jumps[np.abs(after.jump_sizes) > _FELT], after.bends) * unit
            begins = float(table(table.edges[:1])[0]) / unit if table.edges.size > 1 else 0.0
            # births all around 0: what breaks at once is little, but begins at the wait's end
            self.onset_power = 0.0
            self.knows_breakpoints = True
        self._positions = positions + delay
        self._support = lower + delay, upper + delay
        inner = marks[marks > lower] + delay
        felt = begins * unit > _FELT or self._support[0] == 0.0
        self._marks = np.unique(np.append(inner, self._support[0])) if felt else np.unique(inner)

    def support(self) -> tuple[float, float]:
        return self._support

    @property
    def breakpoints(self) -> Array:
        return self._marks

    @property
    def panels(self) -> Array | None:
        known = self._relaxed.panels
        if self._after is not None and self._after.density.edges.size > 1:
            edges = self._after.density.edges * self._unit
            known = np.sort(np.append(edges, 0.5 * (edges[1:] + edges[:-1])))
        return None if known is None else known + self._delay

    @property
    def atoms(self) -> tuple[Array, Array]:
        return self._positions, self._weights

    def _pdf(self, x: Array) -> Array:
        if self._after is None:
            return self._relaxed.pdf(x - self._delay)
        return np.maximum(self._after.density((x - self._delay) / self._unit) / self._unit, 0.0)

    def _sf(self, x: Array) -> Array:
        if self._after is None:
            return self._relaxed.sf(x - self._delay) + self._moved(x)
        return np.maximum(1.0 - self._cdf(x), 0.0)

    def _cdf(self, x: Array) -> Array:
        if self._after is None:
            return self._relaxed.cdf(x - self._delay) - self._moved(x)
        broken = self._after.density.integral((x - self._delay) / self._unit)
        return np.minimum(broken + _steps(x, self._positions, self._weights), 1.0)

    def _moved(self, x: Array) -> Array:
        """What rounding of x less the wait puts to the wrong side of an exact value."""
        return _steps(x - self._delay, *self._relaxed.atoms) - _steps(x, self._positions, self._weights)


def _steps(x: Array, positions: Array, weights: Array) -> Array:
    """Weight of exact values up to x."""
    total = np.zeros(x.shape)
    for position, weight in zip(positions, weights, strict=True):
        total += np.where(x >= position, weight, 0.0)
    return total
