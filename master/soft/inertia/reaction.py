"""Reaction: the force of the contacts along one straight move of a slider with mass, and what they store."""

from bisect import bisect_left
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import brentq

from master.motion import History
from master.numerics import polynomials
from master.renewal.present import Present
from master.soft.cold_contacts import ColdContacts
from master.soft.curve import LoadCurve
from master.soft.moves import LoadingHistory, Move
from master.survival.life import ColdLife, Life, Survivors
from origins.thresholds.law import Array

# Share of the tolerance by which the force may differ from that of contacts of which none breaks, or of steady breaks.
ALIKE = 0.02
# Travel along which breaks have to be steady, in longest stretches: a life, and a tenth for the panels at its ends.
LIFE = 1.1
# Width of the endless panel of the last force behind steady breaks, in mean thresholds: farther than any drive goes.
ENDLESS = 1e15
# Panels are solved up to so many times the way so far, and so many resolution lengths beyond, at once.
FURTHER, AND_FURTHER = 1.2, 2.0
# Rounding of a travel, relative; accuracy of the end of the elastic travel, relative: it bounds a closed motion only.
ROUNDING, OF_ELASTIC_END = 1e-13, 1e-6
# Least travel, in mean thresholds, at which energies are asked for: at 0 contacts of the move before count.
BEGUN = 1e-12
# Shares of a panel at which the force is compared.
FRACTIONS = np.linspace(1.0 / 16.0, 1.0, 16)
# Matrix from Legendre coefficients to those of powers, the highest first.
POWERS: Array = np.array(
    [
        np.pad(legendre.leg2poly(row[: k + 1]), (0, polynomials.DEGREE - k))[::-1]
        for k, row in enumerate(np.eye(polynomials.DEGREE + 1))
    ]
)


@dataclass(frozen=True)
class Panel:
    """The force on one panel as powers of z = 2 (y - begin)/width - 1."""

    begin: float
    width: float
    powers: tuple[float, ...]

    def force(self, y: float) -> float:
        """F along the motion; a straight line beyond the panel's ends."""
        z = 2.0 * (y - self.begin) / self.width - 1.0
        inside, value = min(max(z, -1.0), 1.0), 0.0
        for coefficient in self.powers:
            value = value * inside + coefficient
        return value if inside == z else value + (z - inside) * self._rise(inside)

    def slope(self, y: float) -> float:
        """F'."""
        return self._rise(min(max(2.0 * (y - self.begin) / self.width - 1.0, -1.0), 1.0)) * (
            2.0 / self.width
        )

    def _rise(self, z: float) -> float:
        """dF/dz."""
        value = rise = 0.0
        for coefficient in self.powers:
            rise, value = rise * z + value, value * z + coefficient
        return rise


class Reaction(Move):
    """Contacts at T = 0 while a slider with mass moves in one direction, +1 or -1.

    steady_from : the travel from which breaks are steady, so that F no longer changes; inf while that is not known
    """

    def __init__(
        self, contacts: ColdContacts, direction: int, loaded: LoadingHistory, tolerance: float
    ) -> None:
        """`tolerance` is that of the force, a length."""
        super().__init__(contacts, direction, loaded)
        self._alike, self.steady_from = ALIKE * tolerance, np.inf
        self._begins, self._panels = list[float](), list[Panel]()
        self._extend(0.0)

    def _extend(self, y: float) -> None:
        """Solve the force up to the travel y."""
        self.curve = curve = self._with_steady_end(self.curve_to(y))
        n_solved = len(self._panels)
        powers = curve.series[n_solved:] @ POWERS
        for begin, width, row in zip(
            curve.from_travel[n_solved:], curve.width[n_solved:], powers, strict=True
        ):
            self._begins.append(float(begin))
            self._panels.append(Panel(float(begin), float(width), tuple(row.tolist())))

    def _with_steady_end(self, curve: LoadCurve) -> LoadCurve:
        """The curve, with one endless panel of the last force behind, where breaks have been steady for a life."""
        memory = LIFE * self.contacts.life.largest_stretch
        if curve.to_travel < memory or (curve.drops > curve.to_travel - memory).any():
            return curve
        first = int(np.searchsorted(curve.from_travel, curve.to_travel - memory, "right")) - 1
        rates = self._rates(self.first + max(first, 0))
        force = curve.series[max(first, 0) :]
        change = np.abs(force[:, 1:]).sum(axis=1).max() + np.ptp(force[:, 0])
        if change > self._alike or np.ptp(rates) > self._alike / self.contacts.unit * rates.mean():
            return curve
        self.steady_from = curve.to_travel
        series = np.zeros((1, curve.series.shape[1]))
        series[0, 0] = curve.series[-1, 0]
        return replace(
            curve,
            from_travel=np.append(curve.from_travel, curve.to_travel),
            width=np.append(curve.width, ENDLESS * self.contacts.unit),
            series=np.concatenate([curve.series, series]),
            error=np.append(curve.error, curve.error[-1] + change),
            own_error=np.append(curve.own_error, 0.0),
        )

    def _steady_force(self) -> None:
        """Steady breaks are looked for by `_with_steady_end`, to the tolerance of the motion."""
        return None

    def _rates(self, first: int) -> Array:
        """Breaks per contact and length on the panels from one on."""
        solved = self.march.solved
        return np.asarray(solved.breaks[first:, -1] / solved.width[first:])

    def panel_at(self, y: float, last: float = np.inf) -> Panel:
        """The panel on which y lies, an edge on the one that it ends; none that begins at `last` or later."""
        rounding = ROUNDING * (self.loaded.move_begins_at + y)
        # behind steady breaks F stays as it is, however far a stage of the integrator that will be rejected lies ahead
        while y > self.curve.to_travel + rounding and self.steady_from == np.inf:
            # step by step, to see where breaks have become steady
            beyond = AND_FURTHER * self.contacts.life.resolution_length
            self._extend(min(y, FURTHER * self.curve.to_travel + beyond))
        at = bisect_left(self._begins, min(y, last)) - 1
        return self._panels[max(at, 0)]

    def next_drop(self, y: float) -> float:
        """The next travel beyond y, as far as the force is solved, at which contacts break together; inf if none."""
        later = self.curve.drops[self.curve.drops > y]
        return float(later[0]) if later.size else np.inf

    @cached_property
    def elastic_end(self) -> float:
        """The travel up to which F grows as if no contact broke."""
        first, y = self._panels[0].force(0.0), 0.0

        def off(y: float) -> float:
            return abs(self.panel_at(y).force(y) - first - y) - self._alike

        while True:
            for panel in self._panels:
                low = panel.begin
                for high in (panel.begin + panel.width * FRACTIONS).tolist():
                    if abs(panel.force(high) - first - high) > self._alike:
                        return (
                            low
                            if off(low) >= 0.0
                            else float(brentq(off, low, high, rtol=OF_ELASTIC_END))
                        )
                    low = high
            y = self.curve.to_travel
            self.panel_at(y + self.contacts.life.resolution_length)

    def breaks(self, y: float) -> float:
        """Breaks per contact since the move's beginning."""
        steady = min(y, self.steady_from)
        self.panel_at(steady)
        march, at = self.march, self.loaded.move_begins_at + steady
        begins = march.solved.begin[self.first :]
        index = self.first + max(int(np.searchsorted(begins, at)) - 1, 0)
        fraction = np.clip((at - march.solved.begin[index]) / march.solved.width[index], 0.0, 1.0)
        done = float(march.solved.breaks[self.first : index, -1].sum())
        done += float(polynomials.values(np.array([fraction]))[0] @ march.solved.breaks[index])
        done += sum(
            one.weight for one in march.lumps[1:] if self.loaded.move_begins_at < one.birth < at
        )
        if y > steady:
            done += (y - steady) * float(self._rates(march.solved.count - 1).mean())
        return done

    def stop(self, y: float, error: float) -> LoadingHistory:
        """The history after the travel y; once breaks are steady they look alike anywhere."""
        return self.stopped(min(y, self.steady_from), error)

    def stored(self, y: Array) -> Array:
        """Energy of the contacts at travels y, the mean of k x^2/2 divided by <k> (length squared); as y."""
        y = np.minimum(np.asarray(y, dtype=float), self.steady_from)
        if not y.size:
            return np.zeros(0)
        self.panel_at(float(y.max()))
        # what was reached before the time was over has its energies, too
        births = replace(self.march.births, life=_StoredLife(self.march.life), until=np.inf)
        march = self.march.cut(self.march.solved.end, births)
        march.present = Present(births)
        at = np.maximum(
            self.loaded.move_begins_at + y, self.loaded.move_begins_at + BEGUN * self.contacts.unit
        )
        different, back = np.unique(at, return_inverse=True)
        return np.asarray(march.enter_and_sum_at(different[:, None])[1, :, 0][back])


class _StoredLife(ColdLife):
    """A life that gives the energy which a contact stores in place of its force."""

    def __init__(self, life: Life) -> None:
        """`life` is a ColdLife."""
        self.__dict__.update(life.__dict__)

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """Share and energy of contacts with these moves; see Life."""
        out = super().survivors(born, side, history)
        return out._replace(force=0.5 * out.force * (born + history.now))
