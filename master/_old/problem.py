"""One scene in units of its mean stretch at a break: the law, the first breaks, the atomic chain."""

from copy import copy

import numpy as np
import numpy.typing as npt

from master._old.atomic import AtomicChain
from master._old.births import standing
from master._old.cycle import Cycle
from master._old.first import FirstBreaks
from master._old.law import Law
from master._old.piecewise import Piecewise
from master._old.powers import Powers, find_powers
from master._old.release import PLAIN, Release
from origins import Contacts

Array = npt.NDArray[np.float64]

POWERS_FELT = 0.1  # of the tolerance: what powers a lattice may smear
_BEYOND = 1.7  # lattices reach past the last position, at most by 24 of the coarsest steps


class Problem:
    """What does not depend on the lattice, up to X = `end` and for errors well below `tolerance` (both in
    units of the cycle's length)."""

    release: Release = PLAIN
    powers: Powers | None = None  # places where J_1 is known to be a power of the distance
    table: Piecewise | None = None  # P_c, where it diverges

    def __init__(
        self,
        contacts: Contacts,
        end: float,
        tolerance: float,
        cycle: Cycle | None = None,
        law: Law | None = None,
        powers: Powers | None = None,
    ) -> None:
        self.contacts = contacts
        self.cycle = cycle = Cycle(contacts) if cycle is None else cycle
        self.unit = cycle.unit
        self.end = end
        furthest = _BEYOND * end
        self.law = law_of(contacts, end, cycle) if law is None else law
        self.first = self._first(furthest, 1e-4 * tolerance)
        self.table = self._table(furthest, 1e-4 * tolerance)
        # corners of the law or of the first breaks above X = 0 make errors uneven
        self.rough = self.law.rough or self.first.has_corners
        if powers is not None:
            self.powers = powers
        elif self.rough and cycle.law is contacts.thresholds:
            self.powers = find_powers(contacts, self.law, end, POWERS_FELT * tolerance, cycle.release.stiffness)
        self.release = cycle.release
        self.chain = AtomicChain(self.law, self.first.atoms, self.first.atom_weights, end, self.release)
        self._standing = (self.first.mean_start, 1.0)
        if self.release.stiffness:
            self._standing = standing(contacts, self.unit)

    def _table(self, end: float, accuracy: float) -> Piecewise | None:
        """P_c with the weight that the cdf tells beside the poles that it declares; None where it has none."""
        if self.cycle.law is not self.contacts.thresholds or not self.law.declares_poles:
            return None
        if self.first.single and self.first.mean_start == 0.0:
            return self.first.density
        return FirstBreaks(Contacts(self.contacts.thresholds), self.law, end, accuracy).density

    def with_release(self, release: Release) -> "Problem":
        """The same where breaks and births do other things to the force."""
        other = copy(self)
        other.release = release
        return other

    def known(self, x: Array) -> Array:
        """F at x as the starting contacts and the births after their breaks, as if these never broke, make it."""
        first, release = self.first, self.release
        force, stiffness = self._standing
        total = force + stiffness * x - first.released(x)
        if release.plain:
            return total
        since = x - release.delay
        total += release.birth_stiffness * first.count.twice(since) - first.softened.twice(x)
        return total + release.birth_force * first.count.once(x, release.delay)

    def known_rate(self, x: Array) -> Array:
        """Slope of `known`, atoms left out."""
        first, release = self.first, self.release
        total = self._standing[1] - first.rate(x)
        if release.plain:
            return total
        since = x - release.delay
        total += release.birth_stiffness * first.count.once(x, release.delay) - first.softened.once(x)
        return total + release.birth_force * first.density(since)

    def _first(self, end: float, accuracy: float) -> FirstBreaks:
        contacts, breaking = self.contacts, self.cycle.breaking
        if breaking is None or (contacts.start.span == (0.0, 0.0) and not self.cycle.grown):
            law = self.law
            if breaking is None and self.cycle.law is not contacts.thresholds:
                law = Law(contacts, end + max(contacts.start.span[1], 0.0) / self.unit)
            elif breaking is not None and not self.cycle.release.plain:
                law = Law(contacts, end, self.cycle.relaxed, self.unit)
            if breaking is None or not self.cycle.release.stiffness:
                return FirstBreaks(contacts, law, end, accuracy)
        relaxed = self.law
        if self.cycle.law is not self.cycle.relaxed:
            relaxed = Law(contacts, end + max(contacts.start.span[1], 0.0) / self.unit, self.cycle.relaxed, self.unit)
        from master._old.origin_breaks import OriginBreaks

        return OriginBreaks(contacts, relaxed, breaking, end, 100.0 * accuracy)  # sums of sums, each with rounding


def law_of(contacts: Contacts, end: float, cycle: Cycle) -> Law:
    """The law of travels between breaks, as far as a path up to X = end (in units of the cycle's length) needs it."""
    return Law(contacts, _BEYOND * end + max(contacts.start.span[1], 0.0) / cycle.unit, cycle.law, cycle.unit)
