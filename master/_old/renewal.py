"""Breaks of the second and later generations on one lattice, and on finer ones towards X = 0.

With p the law of thresholds, b_0 the first breaks and r the density of released stretch x P_c(x), all measures:

    b = b_0 + p * b,        J_1(X) = integral_0^X (r * b)

(physics of Sec. III as a renewal equation; F = <x_ini> + X - J_0 - J_1). Within some 50 nodes of X = 0 a lattice
cannot tell a measure from its eight-node shares; there the answer comes from a lattice sixteen times finer, and so
on until J_1 is nothing.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np
import numpy.typing as npt

from master._old.kinks import Kinks
from master._old.lattice import INTEGRATE, STENCIL, deposit_atoms, integrate, lagrange, lay
from master._old.powers import Fits
from master._old.problem import Problem
from master._old.series import convolve, renew

Array = npt.NDArray[np.float64]

_NEAR = 56
_ZOOM = 16
_MARGIN = 24
_FEW = 1e-11
_BESIDE = np.linspace(1.0, 1.25, 200)
RESOLVED = 0.3  # of the narrowest width: steps above it may miss a wave
_LESS = 3.0
_SMALLER, _SMALLEST = 1e-3, 1e-15  # kinks cost little and are put right to far below what is asked


class Renewal:
    """Later generations on the nodes 0, h, 2h, ... up to `end` (in units of the mean threshold).

    Attributes
    ----------
    step : float
    released : array
        J_1 at the nodes, without what the atomic chain releases at its own atoms.
    defect : float
        By how much the weight of all thresholds on the lattice differed from 1 before it was made so; 0 where they
        reach beyond it.
    """

    def __init__(self, problem: Problem, step: float, end: float, tiny: float) -> None:
        law, chain = problem.law, problem.chain
        self._powers = None if problem.powers is None else problem.powers.on(step)
        if self._powers is not None:
            end = self._powers.reach(end, step)
        size = int(np.ceil(end / step * (1.0 - 1e-12))) + _MARGIN + 1
        self.step = step
        self.size = size

        smooth, smooth_released, source = self._lay(problem)
        # beside its poles the table has all of the law
        atoms, weights = (law.atoms, law.atom_weights) if problem.table is None else (np.empty(0), np.empty(0))
        kernel = smooth + deposit_atoms(atoms, weights, step, size)
        does = problem.release
        release = smooth_released[0] + deposit_atoms(atoms, weights * does.force_at(atoms), step, size)
        stiffness = np.zeros(size)
        if does.stiffness:
            stiffness = smooth_released[1] + deposit_atoms(atoms, weights * does.stiffness_at(atoms), step, size)
        self.defect = 0.0
        highest = max(law.edges[-1:].max(initial=0.0), law.atoms.max(initial=0.0))
        whole = 0.0 < highest < step * (size - 1)
        if whole:
            # every generation would lose again what weight the lattice lacks
            lost = softer = 1.0 - float(kernel.sum())
            if does.stiffness:  # and contacts would keep more stiffness than they were born with
                softer = does.birth_stiffness / float(stiffness.sum()) - 1.0
            self.defect = max(abs(lost), abs(softer))
            kernel, release = kernel + lost * kernel, release + softer * release
            stiffness = stiffness + softer * stiffness
        flux = np.zeros(size)
        self._from_chain = np.zeros(size)
        if chain.births.size:
            births = deposit_atoms(chain.births, chain.weights, step, size)
            self._from_chain = convolve(smooth, births, size)
            source = source + self._from_chain
            flux += convolve(smooth_released[0], births, size)
        # what slides steadily from X = 0 on is known, and of what is left rounding does not add up on the way
        steady, often = np.zeros(size), 0.0
        if whole or not (problem.rough or law.atoms.size):
            steady, often = _steady_source(kernel, None if whole else law.sf(step * np.array([size - 1.0 - STENCIL])))
        breaks, released = renew(source - steady, kernel, release)
        breaks += often
        released += often * np.cumsum(release)
        flux += released
        if not does.plain:
            flux += self._beside(problem, smooth_released, kernel, stiffness, breaks)
        self.released = integrate(flux)
        self._flux = flux
        self._fits: Fits = {}  # beside powers
        self._kinks: Kinks | None = None
        if self._powers is None and (law.jumps.size or law.atoms.size):
            self._kinks = Kinks(problem, step, end, max(_SMALLER * tiny, _SMALLEST))
        self._kernel, self._breaks = kernel, breaks

    def _beside(
        self, problem: Problem, smooth: list[Array], kernel: Array, stiffness: Array, breaks: Array
    ) -> Array:
        """What else lets the force fall: stiffness that later breaks took away, less what their births bring."""
        chain, release, step, size = problem.chain, problem.release, self.step, self.size
        later = self._from_chain + convolve(kernel, breaks, size)
        softer = later
        if release.stiffness:
            softer = convolve(stiffness, breaks, size)
            if chain.births.size:
                births = deposit_atoms(chain.births, chain.weights, step, size)
                softer = softer + convolve(smooth[1], births, size)
        if release.delay > 0.0:
            later = convolve(later, deposit_atoms(np.array([release.delay]), np.ones(1), step, size), size)
        return step * integrate(softer - release.birth_stiffness * later) - release.birth_force * later

    def _lay(self, problem: Problem) -> tuple[Array, list[Array], Array]:
        """P_c, what its breaks release, and b_0 on the nodes, atoms left out."""
        law, first, table, step, size = problem.law, problem.first, problem.table, self.step, self.size

        def thresholds(x: Array) -> list[Array]:
            density = law.pdf(x) if table is None else table(x)
            return [density, *problem.release.densities(x, density)]

        def breaks(x: Array) -> list[Array]:
            return [first.density(x)]

        rows = 3 if problem.release.stiffness else 2
        stable = step > RESOLVED * law.narrowest
        ends, others = law.edges_for(step) if table is None else table.edges, first.edges_for(step)
        if problem.rough:
            # beside a point where P_c diverges its weight is right on its own panels alone
            smooth, *released = lay(thresholds, rows, ends, step, size, stable)
            (source,) = lay(breaks, 1, others, step, size, stable)
        else:
            every = np.concatenate([ends, others])
            smooth, *released, source = lay(lambda x: thresholds(x) + breaks(x), rows + 1, every, step, size, stable)
        return smooth, released, source

    @cached_property
    def births(self) -> Array:
        """Density of later breaks p * b at the nodes, chains of atoms left out."""
        return (self._from_chain + convolve(self._kernel, self._breaks, self.size)) / self.step

    @cached_property
    def counted(self) -> Array:
        """Later breaks up to the nodes, chains of atoms left out."""
        return integrate(self._from_chain + convolve(self._kernel, self._breaks, self.size))

    @property
    def kinks_dropped(self) -> float:
        """What the kinks that are too small to be put right add up to."""
        return np.inf if self._kinks is None else self._kinks.dropped

    def count_at(self, x: Array) -> Array:
        """Later breaks up to positions x, those of the chain at its atoms left out."""
        count = self.read(self.counted, x)
        return count if self._kinks is None else count + self._kinks.count(x)

    def births_at(self, x: Array) -> Array:
        """Density of later breaks at positions x; its kinks put right."""
        density = self.read(self.births, x)
        return density if self._kinks is None else density + self._kinks.births(x)

    def released_at(self, x: Array) -> Array:
        """J_1 at positions x, the kinks of its slope put right."""
        released = self._released_at(x)
        if self._powers is None:
            return released
        return self._powers.put_right(x, released, self._released_at, self.step, self.size, self._fits)

    def _released_at(self, x: Array) -> Array:
        released = self.read(self.released, x)
        return released if self._kinks is None else released + self._kinks.released(x)

    def rate_at(self, x: Array) -> Array:
        """dJ_1/dX at positions x, atoms of the chain left out, the kinks put right likewise."""
        rate = self.read(self._flux / self.step, x)
        return rate if self._kinks is None else rate + self._kinks.rate(x)

    def read(self, values: Array, x: Array) -> Array:
        """Interpolate values at the nodes to positions x by the eight nodes around each."""
        position = x / self.step
        cell = (position.astype(np.int64) - (STENCIL // 2 - 1)).clip(0, self.size - STENCIL)
        weights = lagrange(position - cell)
        out = weights[:, 0] * values[cell]
        for k in range(1, STENCIL):
            out += weights[:, k] * values[cell + k]
        return out


class LaterReleased:
    """J_1(X) at any X up to the path's end, from a lattice of `step` and finer ones towards X = 0.

    Attributes
    ----------
    lattice : Renewal
        The widest of them.
    left_out : float
        Bound on J_1 at those of the sorted positions x where it stays below `tiny` and was not looked for, and on kinks
        as small.
    drift : float
        Error of J_1 at the end of the path from weight of thresholds that had to be made up.
    unseen : float
        Change of J_1, where a lattice too wide for the law hands over to the next finer one: waves that it cannot show.
        They do not grow further on.
    """

    def __init__(self, problem: Problem, step: float, x: Array, tiny: float) -> None:
        self._problem, self._tiny = problem, tiny
        self._deeper: list[tuple[float, Renewal]] = []
        self.lattice = Renewal(problem, step, problem.end, tiny)
        self.drift = self.lattice.defect * (1.0 + problem.end)
        self._pieces: list[tuple[float, Renewal]] = []
        self.unseen = self.left_out = 0.0
        lattice = self.lattice
        while True:
            near = _NEAR * lattice.step if _weight_below(problem, STENCIL * lattice.step, tiny) > tiny else 0.0
            self._pieces.append((near, lattice))
            self.left_out = 0.0
            if problem.powers is not None and problem.powers.knows(near):
                break
            left = x[(x > 0.0) & (x <= near)]
            self.left_out = bound(problem, float(left[-1]), tiny) if left.size else 0.0
            wide = lattice.step > RESOLVED * problem.law.narrowest
            if self.left_out <= tiny and not wide:
                break
            beside = (near or _NEAR * lattice.step) * _BESIDE
            finer = Renewal(problem, lattice.step / _ZOOM, float(beside[-1]) if wide else near, tiny)
            if wide:
                change = np.abs(lattice.released_at(beside) - finer.released_at(beside))
                self.unseen = max(self.unseen, float(change.max()))
            lattice = finer
        if problem.law.atoms.size and problem.law.jumps.size:  # which lead to ever more and smaller kinks
            lost = sum(lattice.kinks_dropped for _, lattice in self._pieces)
            self.left_out += _LESS * min(tiny, lost)

    def step_at(self, x: Array) -> Array:
        """Step of the lattice that answers at each x."""
        out = np.zeros(x.size)
        for near, lattice in reversed(self._pieces):
            out[x > near] = lattice.step
        return out

    def __call__(self, x: Array) -> Array:
        """J_1 at positions x, releases by the atomic chain included."""
        released = self._problem.chain.released(x) + self._collect(Renewal.released_at, x)
        powers = self._problem.powers
        near = self._pieces[-1][0]
        if powers is not None and powers.begun is not None and powers.knows(near):
            begins = (x > 0.0) & (x <= near)
            released[begins] = powers.begun(x[begins])
        return released

    def rate(self, x: Array) -> Array:
        """dJ_1/dX at positions x, atoms of the chain left out."""
        return self._problem.chain.rate(x) + self._collect(Renewal.rate_at, x)

    def count(self, x: Array) -> Array:
        """Later breaks up to positions x, those of the chain left out."""
        return self._collect(Renewal.count_at, x)

    def births(self, x: Array, least: float = 0.0) -> Array:
        """Density of later breaks p * b at positions x, chains of atoms left out; near X = 0, where all that is born
        is fewer than `least`, nothing."""
        # births matter nearer to X = 0 than what they release: further lattices are made when asked for
        pieces = self._pieces + self._deeper
        near, lattice = pieces[-1]
        while ((x > 0.0) & (x <= near)).any() and self._matters(near, least):
            lattice = Renewal(self._problem, lattice.step / _ZOOM, near, self._tiny)
            near = _NEAR * lattice.step
            self._deeper.append((near, lattice))
            pieces = self._pieces + self._deeper
        return self._collect(Renewal.births_at, x, pieces)

    def _matters(self, near: float, least: float) -> bool:
        again = float(self._problem.law.cdf(np.array([near]))[0])
        return again > _FEW and again * _broken(self._problem, near) > least

    def _collect(
        self,
        answer: Callable[[Renewal, Array], Array],
        x: Array,
        pieces: "list[tuple[float, Renewal]] | None" = None,
    ) -> Array:
        out = np.zeros(x.size)
        above = np.inf
        for near, lattice in self._pieces if pieces is None else pieces:
            here = (x > near) & (x <= above)
            if here.any():
                out[here] = answer(lattice, x[here])
            above = near
        return out


def _steady_source(kernel: Array, left: Array | None) -> tuple[Array, float]:
    """First breaks, node by node, after which as many contacts break at each node for ever, and how many; `left` is
    what lies beyond the last node but STENCIL of a law that reaches beyond the lattice."""
    # from the far end: what lies beyond all is to be nothing
    longer = np.append(np.cumsum(kernel[:0:-1])[::-1], 0.0)
    if left is not None:
        last = kernel.size - 1 - STENCIL
        longer += float(left[0]) + float(INTEGRATE @ kernel[last : last - STENCIL : -1]) - longer[last]
    often = 1.0 / float(longer.sum())
    return often * longer, often


def _weight_below(problem: Problem, x: float, tiny: float) -> float:
    """Weight of thresholds or of first breaks below x: what a lattice would hold in one-sided stencils."""
    return problem.law.weight_below(x, tiny) + float(problem.first.density.integral(np.array([x]))[0])


def bound(problem: Problem, x: float, tiny: float) -> float:
    """What J_1(x) cannot exceed: every contact broken once breaks again before x, releasing at most x in all, however
    often it breaks. Where that is below `tiny`, a rougher bound."""
    again = problem.law.weight_below(x, tiny / (x + 1.0))
    release = problem.release
    each = (x + release.widest) * max(1.0, release.stiffness * (x + release.widest))
    if again < 0.5:
        often = again / (1.0 - again)
    else:  # what is released in all is what was stretched in all; otherwise nothing is known so simply
        often = 1.0 if release.plain else np.inf
    broken = _broken(problem, x)  # by rounding it may be below 0
    return each * broken * often if broken > 0.0 else 0.0


def _broken(problem: Problem, x: float) -> float:
    """First breaks up to x, and those that follow from them at exact single values."""
    chain = problem.chain
    return float(problem.first.density.integral(np.array([x]))[0]) + float(chain.weights[chain.births <= x].sum())
