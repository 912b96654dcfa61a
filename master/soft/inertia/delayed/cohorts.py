"""The contacts of a slider with mass: cohorts that formed at one position each."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from master.numerics.averages import stretch_nodes
from master.soft.inertia.delayed.panel import POSITION, TimePanel
from master.soft.inertia.delayed.survival import Survival
from master.survival.life import TIE
from origins import Contacts
from origins.thresholds.law import Array

# Weight times survival below which a cohort is dropped: a thousand of them are below rounding.
DEAD = 1e-19
# Ways, ahead and back, in which cohorts are merged in pairs, each time to half of them at most.
PASSES = (1, 1, -1, -1)
# Nodes for a start with a width.
STARTS = 200
# Distances that are tried at once for how far contacts hold, and how often they are refined: to a tenth.
TRIED, REFINED = 12, 2
# The farthest of them, in the largest stretches: no contact holds beyond twice that.
FARTHEST = 4.0


class Response(NamedTuple):
    """What contacts do at positions X; arrays of shape (n,).

    holding, force : share that holds, and F/(N_c<k>) (a length); slope, of_holding : their derivatives by X
    """

    holding: Array
    force: Array
    slope: Array
    of_holding: Array


@dataclass(frozen=True)
class Cohorts:
    """Contacts by the position at which they formed; arrays of shape (n,).

    survival : of the law of thresholds
    born : X at which they were relaxed (a length); largest : largest |x| so far (a length)
    weight : share of all contacts at birth
    """

    survival: Survival
    born: Array
    largest: Array
    weight: Array

    @classmethod
    def at_start(cls, contacts: Contacts, survival: Survival) -> "Cohorts":
        """Those at t = 0, where X = 0."""
        rule = stretch_nodes(contacts.start, survival.longest, STARTS)
        size = np.abs(rule.stretch)
        return cls(survival, -rule.stretch, size, rule.weight / contacts.thresholds.sf(size))

    def response(self, x: Array) -> Response:
        """At positions X (n,), each reached straight from here."""
        stretch = x[:, None] - self.born
        size = np.abs(stretch)
        breaking = size >= self.largest
        largest = np.maximum(size, self.largest)
        survival, density = self.survival.sf_and_pdf(largest * (1.0 + TIE))
        holding, lost = self.weight * survival, np.where(breaking, self.weight * density, 0.0)
        slope = (holding - size * lost).sum(axis=1)
        return Response(
            holding=holding.sum(axis=1),
            force=(stretch * holding).sum(axis=1),
            slope=slope,
            of_holding=-(np.sign(stretch) * lost).sum(axis=1),
        )

    @cached_property
    def _holding(self) -> Array:
        """Share of all contacts that holds, of each cohort."""
        return self.weight * self.survival.sf(self.largest * (1.0 + TIE))

    def unbroken(self) -> float:
        """Share that holds."""
        return float(self._holding.sum())

    def stored(self, x: float) -> float:
        """Energy of the contacts at a position, per N_c<k> (length squared)."""
        size = np.abs(x - self.born)
        holding = self.weight * self.survival.sf(np.maximum(size, self.largest) * (1.0 + TIE))
        return 0.5 * float((size**2 * holding).sum())

    def moved(self, x: float) -> "Cohorts":
        """After a straight move to this position; without those of which none holds any more."""
        largest = np.maximum(self.largest, np.abs(x - self.born))
        # a weight may be below 0: what panels miss of the number that holds is made up for by the next births
        alive = np.abs(self.weight * self.survival.sf(largest * (1.0 + TIE))) > DEAD
        return replace(
            self, born=self.born[alive], largest=largest[alive], weight=self.weight[alive]
        )

    def and_born(self, born: Array, weight: Array, x: float) -> "Cohorts":
        """These, and others that formed at these positions on the straight way to the position x."""
        return replace(
            self,
            born=np.append(self.born, born),
            largest=np.append(self.largest, np.abs(x - born)),
            weight=np.append(self.weight, weight),
        )

    def after(self, panel: TimePanel, birth_rate: Array, least_force: float) -> "Cohorts":
        """After a panel on which the slider does not turn; `birth_rate` is that at its nodes. Those born on it count as
        born at one place where that changes the force by less than `least_force`."""
        x, weight = panel.nodes(POSITION), panel.weights * birth_rate
        end = float(x[-1])
        later, size = self.moved(end), float(np.abs(weight).sum())
        if size == 0.0:
            return later
        width = self.survival.width
        if size * (np.ptp(x) / width) ** 2 * width <= least_force:
            x = np.array([float(np.abs(weight) @ x) / size])
            weight = weight.sum(keepdims=True)
        return later.and_born(x, weight, end)

    def merged(self, least_force: float, near: float) -> "Cohorts":
        """Fewer cohorts: two that are alike become one, born at their mean place and stretched by their mean most. As
        many hold as before, and pull as strongly, but for those that have a weight below 0; what is lost in the force,
        now and later, is less than `least_force` in all, of second order in how far two differ. Cohorts are merged only
        where they break on from the same position, ahead or behind, but for a distance `near`: the force has a kink
        there; and none at exact thresholds."""
        if self.survival.atoms.size:
            return self
        found = self
        for direction in PASSES:
            found = found._in_pairs(direction, least_force / len(PASSES), near)
        return found

    def _in_pairs(self, direction: int, least_force: float, near: float) -> "Cohorts":
        """In the order of the positions from which they break on this way, then by birth, the first and the second, the
        third and the fourth, and so on, where they are alike and these positions the same, up to `near`."""
        place = self.born + direction * self.largest
        order = np.lexsort((self.born, np.round(place / near)))
        born, largest, weight = (each[order] for each in (self.born, self.largest, self.weight))
        place = place[order]
        holding, second = self._holding[order], np.arange(1, order.size, 2)
        pair = holding[second - 1] + holding[second]
        apart = np.hypot(born[second] - born[second - 1], largest[second] - largest[second - 1])
        # a weight may be below 0, see `moved`; two that nearly cancel have no mean place
        sizes = np.abs(holding[second - 1]), np.abs(holding[second])
        alike, lost = np.abs(pair) > 0.5 * np.maximum(*sizes), np.full(second.size, np.inf)
        alike &= np.abs(place[second] - place[second - 1]) <= near
        mean = np.divide(sizes[0] * sizes[1], np.abs(pair), out=np.zeros(pair.size), where=alike)
        # the larger one's place is taken where only one is below 0
        moves = np.where(holding[second - 1] * holding[second] < 0.0, np.minimum(*sizes), 0.0)
        lost[alike] = (apart * (mean * apart / self.survival.width + moves))[alike]
        cheapest = np.argsort(lost)
        merge = cheapest[np.cumsum(lost[cheapest]) <= least_force]
        pair, second = pair[merge], second[merge]
        of_second = np.clip(holding[second] / pair, 0.0, 1.0)
        for values in (born, largest):
            values[second - 1] += of_second * (values[second] - values[second - 1])
        weight[second - 1] = pair / self.survival.sf(largest[second - 1] * (1.0 + TIE))
        stays = np.ones(order.size, dtype=bool)
        stays[second] = False
        return replace(self, born=born[stays], largest=largest[stays], weight=weight[stays])

    def distance_to_break(
        self, x: float, direction: int, least: float, least_force: float, enough: float = np.inf
    ) -> float:
        """How far the slider can move from x before breaks lower the force of its contacts by more than `least_force`;
        0 for less than the distance `least`, inf where nothing holds. It is told to a tenth; where they do not up to
        the distance `enough`, that is what is told."""
        if self.survival.atoms.size:
            return self._to_atoms(x, direction, self.survival.atoms)
        holding = self._holding

        def lost(distance: Array) -> Array:
            size = np.abs(x + direction * distance[:, None] - self.born)
            still = self.weight * self.survival.sf(np.maximum(size, self.largest) * (1.0 + TIE))
            return np.asarray((size * np.maximum(holding - still, 0.0)).sum(axis=1))

        far = float(np.abs(x - self.born).max(initial=0.0) + self.largest.max(initial=least))
        far = FARTHEST * max(far, self.survival.longest)
        if (self.largest * holding).sum() + far * holding.sum() <= least_force:
            return np.inf
        if enough < far and lost(np.array([enough]))[0] <= least_force:
            return enough
        low, high = least, far
        for _ in range(REFINED):
            tried = np.geomspace(low, high, TRIED)
            too_far = lost(tried) > least_force
            first = int(np.argmax(too_far)) if too_far.any() else TRIED
            if first == 0:
                return 0.0
            if first == TRIED:
                return np.inf
            low, high = float(tried[first - 1]), float(tried[first])
        return low

    def breaking_on_from(self, x: float, near: float) -> float:
        """Share of the contacts whose next break, ahead or behind, comes within the distance `near` of a position."""
        off = np.minimum(np.abs(self.born + self.largest - x), np.abs(self.born - self.largest - x))
        return float(np.abs(self._holding[off <= near]).sum())

    def all_broken_beyond(self, x: float) -> float:
        """How far the slider has to move from x until all have broken, either way; inf where none is there."""
        if not self.born.size:
            return np.inf
        return float(np.abs(x - self.born).max()) + self.survival.longest

    def _to_atoms(self, x: float, direction: int, atoms: Array) -> float:
        """How far the slider can move from x before contacts at an exact threshold break together."""
        stretch = x - self.born
        unmet = atoms > self.largest[:, None] * (1.0 + TIE)
        distance = np.where(unmet, atoms - direction * stretch[:, None], np.inf)
        return float(distance.min(initial=np.inf))
