"""Kinks put right: what a lattice smears where jumps and exact values add up, replaced by the closed form, locally.

A break of finite weight folded with a jump of r leaves a jump in the rate at which stretch is released, and J_1 bends
there; two jumps fold to (X - z)_+, and the rate bends. Exact values among the thresholds carry both along from
generation to generation, and the onset of P_c with them. A lattice smears each over the nodes around its place z.
Folding bare steps and shares of exact values on a few nodes of the same lattice, placed alike between them, shows by
how much.
"""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from master._old.problem import Problem
from master._old.singular import AHEAD, BEHIND, Reading, Singular, join, merge, units

Array = npt.NDArray[np.float64]

_LARGEST = 1e3  # beyond, round-off of the correction would exceed 1e-13
_MOST, _MOST_AT_ONCE = 2_000, 300  # places


class Kinks:
    """Corrections of the rate of later breaks and of what they release, on a lattice of `step` up to X = `end`; those
    that J_1 would feel by less than `tiny` are left out, and those of least height where there are thousands; `dropped`
    is the sum of them all, and of what would have followed from them."""

    def __init__(self, problem: Problem, step: float, end: float, tiny: float) -> None:
        law, first = problem.law, problem.first
        force_at, self._force_at = problem.release.force_at, problem.release.force_at
        self._step, self._tiny = step, tiny
        self._end = end / step
        self._lost = 0.0
        self._atoms, self._weights = law.atoms / step, law.atom_weights
        self._births, self._birth_weights = problem.chain.births / step, problem.chain.weights
        self._later: list[Singular] = []
        self._released: list[Singular] = []

        jumps, heights = units(1.0, law.jumps / step), law.jump_sizes * step
        bends, slopes = units(2.0, law.bends / step), law.bend_sizes * step**2
        begun = units(1.0, first.jumps / step).times(first.jump_sizes * step)
        born = self._after_chain(jumps.times(heights))
        self._released.append(self._after_chain(jumps.times(heights * force_at(law.jumps))))
        steps = self._follow([begun], [born])
        begun = units(2.0, first.bends / step).times(first.bend_sizes * step**2)
        born = self._after_chain(bends.times(slopes))
        self._follow([begun], [born, self._fold(steps, jumps, heights)])
        # what steps by j at z in P_c bends by j in x P_c
        more = units(2.0, law.jumps / step).times(heights * step * problem.release.slope_at(law.jumps))
        self._released += [self._after_chain(part) for part in (bends.times(slopes * force_at(law.bends)), more)]
        self._released.append(self._fold(steps, jumps, heights * force_at(law.jumps)))
        self._follow_onset(problem)
        self._released += [self._kept(part) for part in self._brought(problem)]

    def _brought(self, problem: Problem) -> list[Singular]:
        """What births bring of the force, and the stiffness that the contacts lack while they are out."""
        release, found = problem.release, []
        for part in self._later:
            born = part
            if release.delay > 0.0:
                born = part.after(np.full(part.height.size, release.delay / self._step))
            if release.birth_force != 0.0:
                found.append(born.times(-release.birth_force))
            if not release.plain and (release.delay > 0.0 or release.stiffness):
                found.append(born.summed().times(-release.birth_stiffness * self._step))
                if not release.stiffness:
                    found.append(part.summed().times(self._step))
        return found

    def _follow_onset(self, problem: Problem) -> None:
        """Where exact values carry the lower end of the law, P_c ~ c (x - a)^m."""
        if problem.law.onset is None:
            return
        (power, height), lowest = problem.law.onset, problem.law.support[0] / self._step
        order = 1.0 + power
        at_end = units(order, np.array([lowest])).times(height * self._step**order)
        begun = units(order, problem.first.onsets / self._step)
        begun = begun.times(problem.first.onset_heights * self._step**order)
        self._follow([begun], [self._after_chain(at_end)])
        begins = np.array([lowest * self._step])
        if float(self._force_at(begins)[0]) > 0.0:
            self._released.append(self._after_chain(at_end.times(self._force_at(begins))))
        else:
            slope = problem.release.slope_at(begins)
            more = units(order + 1.0, np.array([lowest])).times(height * slope * self._step ** (order + 1.0))
            self._released.append(self._after_chain(more))

    @property
    def dropped(self) -> float:
        """See above; inf where all weight is exact."""
        others = 1.0 - float(self._weights.sum())
        return self._lost / others if others > 0.0 else np.inf

    def released(self, x: Array) -> Array:
        """What J_1 as read from the lattice lacks at x."""
        return self._sum(x, self._released, True)

    def rate(self, x: Array) -> Array:
        """What dJ_1/dX as read from the lattice lacks at x."""
        return self._sum(x, self._released, False) / self._step

    def count(self, x: Array) -> Array:
        """What the number of later breaks as read from the lattice lacks at x."""
        return self._sum(x, self._later, True)

    def births(self, x: Array) -> Array:
        """What the density of later breaks as read from the lattice lacks at x."""
        return self._sum(x, self._later, False) / self._step

    def _sum(self, x: Array, parts: Iterable[Singular], integrated: bool) -> Array:
        order = np.argsort(x, kind="stable")
        reading = Reading(x[order] / self._step)
        total = np.zeros(x.size)
        for part in parts:
            total[order] += part.missing(reading, integrated)
        return total

    def _fold(self, steps: Singular, jumps: Singular, heights: Array) -> Singular:
        """Bends where `steps` fold with the unit `jumps`, each times the height given."""
        return self._kept(steps.folded(jumps.times(heights)))

    def _after_chain(self, seeds: Singular) -> Singular:
        """All that follows from `seeds` when a contact was born at one of the exact places of the chain."""
        if not self._births.size:
            return seeds[:0]
        heights = np.abs(seeds.height[:, None] * self._birth_weights)
        taken = heights > self._tiny
        if heights.size > _MOST:
            taken &= heights >= np.partition(heights.ravel(), -_MOST)[-_MOST]
        within = seeds.position[:, None] + self._births < self._end + AHEAD
        self._lost += float(heights[within & ~taken].sum())
        seed, birth = np.nonzero(taken)
        return self._kept(seeds[seed].times(self._birth_weights[birth]).after(self._births[birth]))

    def _follow(self, first: list[Singular], later: list[Singular]) -> Singular:
        """All places in the rate of breaks that those of the first breaks and of later ones lead to; what of them is
        released at exact thresholds is noted, and so are those of later breaks."""
        order = (first + later)[0].order
        pending = self._kept(join(order, first + later))
        found, carried, released = [pending[:0]], list(later), []
        count, atoms = 0, self._atoms.size
        while atoms and pending.height.size and count < _MOST:
            every, pending = pending, pending.largest(_MOST_AT_ONCE)
            self._lost += float(every.size.sum() - pending.size.sum())
            now = pending.position < pending.position.min() + float(self._atoms.min())
            ready = pending[now]
            count += ready.height.size * atoms
            found.append(ready)
            rows = np.repeat(np.arange(ready.height.size), atoms)
            atom = np.tile(np.arange(atoms), ready.height.size)
            more = ready[rows].times(self._weights[atom])
            felt = self._felt(more)
            within = more.position + self._atoms[atom] < self._end + AHEAD
            self._lost += float(more.size[within & ~felt].sum())
            more, atom = more[felt], atom[felt]
            more = more.after(self._atoms[atom])
            carried.append(more)
            released.append(more.times(self._force_at(self._atoms[atom] * self._step)))
            pending = self._kept(merge(join(order, [pending[~now], more])))
        self._lost += float(pending.size.sum())
        self._later.append(join(order, carried))
        self._released.append(join(order, released))
        return join(order, [*found, pending])

    def _kept(self, singular: Singular) -> Singular:
        """Those that are felt and within the path."""
        felt, within = self._felt(singular), singular.position < self._end + AHEAD
        self._lost += float(singular.size[within & ~felt].sum())
        return singular[felt & within]

    def _felt(self, singular: Singular) -> npt.NDArray[np.bool_]:
        """Those that are felt, and that round-off allows to put right."""
        return (singular.size > self._tiny) & (np.abs(singular.height) * BEHIND**singular.order < _LARGEST)
