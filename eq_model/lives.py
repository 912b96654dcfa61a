"""Contacts with laws of their own, or on a path that turns or takes its time: the ensemble's second engine."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model.ageing_tables import drift_table
from eq_model.beginning import Beginning, deep_table, reforming_table
from eq_model.compiled_table import kernel_table
from eq_model.course import Course, make_course
from eq_model.histogram import BINS, Histogram, Made, histogram, make_range
from eq_model.lattice import TIE, Whole, joined, split
from eq_model.often import check_growth, check_steps, duration
from eq_model.rare import unseen_break
from eq_model.tally import Counts, Tally
from eq_model.thermal_tables import growth_tables, law_for_kernel
from origins import Contacts, Drive, GrainContact
from origins.errors import InputError
from origins.quantile import DEEPEST

Array = npt.NDArray[np.float64]

STEP = 0.02  # of the time in which old thresholds forget: the bridge within a step is that of free diffusion
STEP_ELSE = 0.5  # squares of the standard deviation that a law's table allows
_TOLD = 256  # units of the lattice in which half of the contacts break again: their mean is told to 1e-5
_SPREAD = 9.0  # standard deviations beyond which no threshold of 1e17 diffuses
# contacts followed besides in steps COARSER times longer, whose force tells the error of the steps: the first of each
# _EACH contacts, _FIRST of them
COARSER = 16
_FIRST, _EACH = 512, 4096


def physics(contacts: Contacts, unit: float) -> tuple[Any, ...]:
    """Laws as the kernel takes them: thermal, tables for it, wait, whether stiffness is linked, mean threshold,
    ageing and its steps, growth."""
    law = law_for_kernel(contacts.thermal, unit)
    linked, mean = contacts.stiffness == "linked", contacts.mean_threshold / unit
    ageing = _ageing(contacts, unit)
    return law, growth_tables(), contacts.waiting_time, linked, mean, *ageing, _growth(contacts.grains, unit)


def _growth(grains: GrainContact | None, unit: float) -> tuple[int, float, float, float]:
    """How thresholds grow: whether, tau_m, B^(1/2) and the age since pinning at X = 0 in units of tau_m."""
    if grains is None or grains.age is None:
        return 0, 1.0, 0.0, 0.0
    first = grains.growth.first_pinning_time
    return 1, first, float(np.sqrt(grains.growth.B)) * unit, (grains.age - first) / first


def _ageing(contacts: Contacts, unit: float) -> tuple[tuple[Any, ...], tuple[float, float]]:
    """How a threshold diffuses, and its steps: the longest in time near the stretch that it must not meet, for laws
    that are not Gaussian where thresholds typically are, and how much coarser than need be the others are."""
    nothing, ageing = np.zeros(2), contacts.ageing
    none = 0.0, 1.0, nothing, nothing, nothing, 0.0, np.inf, 0.0, np.inf
    if ageing is None:
        return (0, 0.0, 0.0, 0.0, 0.0, *none), (0.0, 1.0)
    diffusion = ageing.rate / unit**2
    if ageing.normal is not None:
        normal = ageing.normal
        return (1, normal.mean / unit, normal.std / unit, normal.rate, diffusion, *none), (STEP / normal.rate, 1.0)
    table = drift_table(ageing.final, contacts.thresholds)
    ended = np.isfinite(table.ends[1])
    first = table.first - (0.0 if ended else np.log(unit))
    shares = (table.spreads / table.typical) ** 2
    ends = tuple(end / unit for end in (*table.ends, *table.reach))
    settings = (2, 0.0, 0.0, 0.0, diffusion, first, table.step, table.values, table.slopes, shares, *ends)
    return settings, (STEP_ELSE * table.typical**2 / ageing.rate, 1.0)


def _largest(contacts: Contacts, drive: Drive, fresh: float) -> float:
    """The largest threshold (a length) there may come to be, of which `fresh` is that of the fresh ones."""
    grains, ageing = contacts.grains, contacts.ageing
    if grains is not None and grains.age is not None:
        # in the end, when no contact is older than those at X = 0
        return max(fresh, float(grains.quantile(1.0, grains.age + duration(drive))))
    if ageing is None or ageing.rate == 0.0:
        return fresh
    if ageing.normal is not None:
        return max(fresh, ageing.normal.mean) + _SPREAD * ageing.normal.std
    return max(fresh, float(ageing.final.isf(DEEPEST)))


def _typical(contacts: Contacts, longest: float) -> float:
    """About as long as stretches and thresholds are (a length); `longest` where these grow."""
    if contacts.grains is not None:
        return longest
    laws = [contacts.start, *(one.law for one in (contacts.reforming,) if one is not None)]
    final = 0.0 if contacts.ageing is None else contacts.ageing.final.mean()
    return max(contacts.mean_threshold, final, *(abs(law.mean()) for law in laws))


def _check_excess(contacts: Contacts, unit: float) -> None:
    """InputError where contacts all form again so near to the last thresholds that lengths of `unit` do not tell them
    apart."""
    reforming, thresholds = contacts.reforming, contacts.thresholds
    assert reforming is not None
    stretch = abs(reforming.law.mean())
    excess = float(thresholds.isf(0.5 * thresholds.sf(stretch))) - stretch
    if excess < _TOLD * unit:
        raise InputError(
            f"reforming: at |x| = {stretch:g} half of the contacts break again within {excess:.1g}, and the ensemble "
            f"takes lengths in steps of {unit:.1g}; use a smaller stretch, or a shorter path"
        )


def coarse(part: range) -> list[range]:
    """Those of these contacts that are followed in coarser steps besides, in order."""
    chunks = range(part.start // _EACH * _EACH, part.stop, _EACH)
    found = (range(max(chunk, part.start), min(chunk + _FIRST, part.stop)) for chunk in chunks)
    return [one for one in found if len(one)]


def columns(linked: bool) -> int:
    """Sums of each bin: contacts, stretch and its square, where stiffnesses differ with these as well; then breaks,
    and the squares of the forces that they took."""
    return 8 if linked else 5


def moments(course: Course, linked: bool, n: int, limbs: Whole) -> tuple[Array, Array, Array]:
    """Fraction of n contacts that hold, mean force (a length) and its variance between contacts, at the path's points.

    limbs : shape (2, columns * bins), of the events of each bin; whole numbers to the end, so nothing cancels.
    """
    from eq_model.life_kernel import STIFFNESS_UNIT

    lattice, part = course.lattice, int(STIFFNESS_UNIT)
    order = np.lexsort((lattice.bin_point, lattice.bin_cell))
    last = np.searchsorted(lattice.bin_point[order], np.arange(lattice.points.size), side="right")[lattice.place] - 1
    rows = (limbs[0].astype(object) * (1 << 32) + limbs[1].astype(object)).reshape(-1, columns(linked))[order]
    reference = course.reference[order].astype(object)
    # columns of stretches are whole lengths, those of stiffnesses parts of STIFFNESS_UNIT
    weight, squared = (rows[:, 1], rows[:, 3]) if linked else (rows[:, 0] * part, rows[:, 0] * part)
    first, first_squared = (rows[:, 2], rows[:, 4]) if linked else (rows[:, 1], rows[:, 1])
    second = (rows[:, 5] if linked else rows[:, 2]) * (round(1.0 / lattice.square) * part)
    count, held, born, squares, squares_born, squares_far = (
        np.cumsum(change)[last]
        for change in (
            rows[:, 0],
            weight,
            first * part + weight * reference,
            squared,
            first_squared * part + squared * reference,
            second + reference * (2 * part * first_squared + squared * reference),
        )
    )
    at = np.rint(course.path / lattice.unit).astype(np.int64)
    beside = course.path - at * lattice.unit
    x = at.astype(object)
    force = held * x - born
    spread = (squares * x - 2 * squares_born) * x + squares_far
    variance = (spread * (part * n) - force * force).astype(float) * (lattice.unit / part) ** 2 / n
    mean = (force.astype(float) * lattice.unit + held.astype(float) * beside) / (part * n)
    if n == 1:
        return count.astype(float), mean, np.full(mean.size, np.inf)
    return count.astype(float) / n, mean, np.maximum(variance, 0.0) / (n - 1)


class Lives:
    """The sums of such contacts, and what they say of the force.

    size : of the sums, columns * bins, the events of each bin; with ageing once more, of the contacts followed in
    coarser steps. weight : about how much longer a break takes than one of the other engine's. steps : of a contact
    that ages, at most.
    """

    def __init__(self, drive: Drive, beginning: Beginning, points: npt.NDArray[np.intp]) -> None:
        contacts, table = beginning.contacts, beginning.table
        self._beginning, self.linked = beginning, contacts.stiffness == "linked"
        self.weight = 10.0 if contacts.ageing is None and contacts.grains is None else 300.0
        reforming = contacts.reforming
        furthest = max(map(abs, contacts.start.span))
        if reforming is not None:
            furthest = max(furthest, *map(abs, reforming.law.span))
        last, deep = float(table.upper(0.0)) * table.scale, deep_table(contacts)
        if deep is not None:
            last = max(last, float(deep[0].upper(0.0)) * table.scale)
        longest = max(last, furthest)
        stiffest = max(longest / contacts.mean_threshold, 1.0) if self.linked else 1.0
        path = np.append(0.0, drive.path)
        span = (np.maximum.accumulate(path) - np.minimum.accumulate(path))[1:]
        longest = _largest(contacts, drive, longest)
        self._reached, self._differ = np.minimum(span + furthest, longest), 0.0
        if self.linked:
            # what breaks first is weak; but no contact is weaker than it is stretched
            usual = min(float(np.sqrt(contacts.thresholds.moment(2))) / contacts.mean_threshold, stiffest)
            self._reached *= np.maximum(self._reached / contacts.mean_threshold, usual)
            self._differ = max(usual**2 - 1.0, 0.0)
        # a bin holds births as well as breaks
        exact = contacts.thresholds.atoms[0].size > 0
        check_growth(contacts, drive, min(longest, span[-1] + furthest))
        self.course = make_course(drive, table.scale, 2.0 * min(longest, span[-1] + furthest) * stiffest, exact)
        unit = self.course.lattice.unit
        beginning.compile(unit)
        self._again, single = beginning.compiled, 0
        self._deep: tuple[Any, float, float] = beginning.compiled, float(np.log2(DEEPEST)), np.inf
        if deep is not None:
            self._deep = kernel_table(deep[0], unit), float(np.log2(deep[0].upper.edges[0])), deep[1] / unit
        spread = reforming is not None and not reforming.law.is_single
        if reforming is not None and not spread:
            single = round(reforming.law.mean() / unit)
            _check_excess(contacts, unit)
        if spread:
            self._again = kernel_table(reforming_table(contacts), unit)
        self._physics = (*physics(contacts, unit), spread, single, TIE if exact else 0)
        self.steps = check_steps(contacts, drive, self._physics[6][0])
        moments = self.course.lattice.points[self.course.lattice.place[points]]
        self._points, self._order = points, np.argsort(moments, kind="stable")
        places = np.rint(drive.path[points] / unit).astype(np.int64)[self._order]
        # stretches from here on are drawn again; a single one has thresholds beyond it
        top = last if spread and np.isfinite(contacts.thresholds.support()[1]) else np.inf
        reach = float(span[points].max(initial=0.0)) + furthest
        self._range = make_range(reach, longest, _typical(contacts, longest))
        self._watch = (moments[self._order], places, self._range.per(unit), min(top / unit, 2.0**58))
        self._events = columns(self.linked) * self.course.lattice.bin_cell.size
        self._ages = contacts.ageing is not None
        self.size = self._events * (1 + self._ages)
        self._block_sums = np.zeros(self._events, np.int64)
        # of one block, and as much as a block needs: of all blocks they are in a file
        self._counts = np.zeros((points.size, 2, BINS), np.uint32)

    def follow(self, block: range) -> tuple[Whole, Counts, int, int]:
        """Follow a block of contacts to the drive's end: sums as two limbs, shape (2, size); counts at the moments
        watched, in their order, until the next block; breaks and inner steps."""
        births, firsts = self._beginning.draw(block)
        self._block_sums[:], self._counts[:] = 0, 0
        breaks, steps = self._run(block, births, firsts, self._physics, self._watch, self._block_sums, self._counts)
        sums = [split(self._block_sums)]
        if self._ages:
            coarser = np.zeros(self._events, np.int64)
            longest, _ = self._physics[6]
            # the integral of a rate is of fourth order in the change of its logarithm
            physics = (*self._physics[:6], (COARSER * longest, COARSER**0.25), *self._physics[7:])
            nothing = np.empty(0, np.int64)
            watch = (nothing, nothing, *self._watch[2:])
            for part in coarse(block):
                mine = slice(part.start - block.start, part.stop - block.start)
                self._run(part, births[mine], firsts[mine], physics, watch, coarser, self._counts[:0])
            sums.append(split(coarser))
        return np.concatenate(sums, axis=1), self._counts, int(breaks), int(steps)

    def _run(
        self, part: range, births: Whole, firsts: Whole, physics: Any, watch: Any, sums: Whole, counts: Counts
    ) -> tuple[int, int]:
        from eq_model import life_kernel

        breaks, steps = life_kernel.run(
            part.start,
            births.size,
            self._beginning.n_contacts,
            self._beginning.words,
            self._beginning.compiled,
            self._again,
            self._deep,
            births,
            firsts,
            physics,
            self.course.for_kernel,
            self.course.lattice.for_kernel,
            self.course.reference,
            watch,
            sums,
            counts,
        )
        return int(breaks), int(steps)

    def moments(self, done: list[range], sums: Whole) -> tuple[Array, Array, Array]:
        """Fraction that holds, mean force (a length) of these contacts and its variance between them, at the points."""
        n = sum(map(len, done))
        holding, force, variance = moments(self.course, self.linked, n, sums[:, : self._events])
        lattice, width = self.course.lattice, columns(self.linked)
        breaks, squares = joined(sums[:, : self._events]).reshape(-1, width)[:, -2:].T
        taken = squares * (lattice.unit**2 / lattice.square)
        thermal = self._beginning.contacts.thermal is not None
        unseen = unseen_break(lattice, breaks, taken, n, variance + force**2, self._reached, thermal)
        # the stiffest contacts may be in none of few
        return holding, force, np.maximum(variance, np.maximum(unseen, self._differ * force**2))

    def step_error(self, done: list[range], sums: Whole) -> Array:
        """What the inner steps of ageing may add to the force at the points (a length); 0 without ageing.

        The error grows faster than in proportion to the step, so this is more than it is.
        """
        if not self._ages:
            return np.zeros(self.course.path.size)
        n, some = sum(map(len, done)), sum(len(part) for block in done for part in coarse(block))
        if not some:
            return np.full(self.course.path.size, np.inf)
        _, fine, variance = moments(self.course, self.linked, n, sums[:, : self._events])
        _, other, scatter = moments(self.course, self.linked, some, sums[:, -self._events :])
        doubt = np.sqrt(variance / n + scatter / some)
        return (np.abs(other - fine) + doubt) / (COARSER - 1.0)

    def histograms(self, n: int, counts: Tally) -> Sequence[Histogram]:
        """What stood at the chosen points, in their order."""
        points, path, back = self._points, self.course.path, np.argsort(self._order)

        def make(index: int) -> Histogram:
            point = int(points[index])
            return histogram(point, float(path[point]), self._range, counts.at(int(back[index])), n)

        return Made(points.size, make)
