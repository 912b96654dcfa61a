"""What blocks of contacts do, as sums of whole numbers, and what these say of the force."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.histogram import BINS, Counts, Histogram, Made, histogram, make_range
from eq_model.lattice import SUM_BITS, TIE, make_lattice
from eq_model.layout import BLOCK, Blocks, is_measured
from eq_model.often import check_growth, check_steps, duration
from eq_model.rare import Seen, unseen_break, unseen_variance
from eq_model.tables import DEEPEST, FAR, LEVEL_UNIT, Table, cells_of, exposure_cells
from origins import Contacts, Drive, GrainContact
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

_LIMB = 32  # bits of the low one of the two numbers that hold a sum of all blocks
_TOLD = 256  # units in which half of the contacts break again: their mean is told to 1e-5
_SPREAD = 9.0  # standard deviations beyond which no threshold of 1e17 diffuses
# contacts of every _EACH-th block are followed once more in steps COARSER times longer, whose force
# tells the error of the steps
COARSER, _EACH = 16, 8


class Found(NamedTuple):
    """Of one block: sums as two limbs, shape (2, size); counts of histograms; breaks; steps."""

    sums: Whole
    counts: Counts
    breaks: int
    steps: int


@dataclass(frozen=True)
class Moments:
    """At the points of the path: fraction that holds, mean force (a length), its variance between contacts."""

    holding: Array
    force: Array
    variance: Array


def split(sums: Whole) -> Whole:
    """Whole sums as two limbs, shape (2, ...), high and low; limbs of many blocks and ranks may be added up."""
    return np.stack([sums >> _LIMB, sums & ((1 << _LIMB) - 1)])


def _rows(limbs: Whole, columns: int) -> npt.NDArray[np.object_]:
    """Limbs as whole numbers of any size, a row for each bin, and one for the start."""
    return (limbs[0].astype(object) * (1 << _LIMB) + limbs[1].astype(object)).reshape(-1, columns)


class Engine:
    """The blocks of one ensemble; `steps`: that a contact takes at most, `size`: of the sums."""

    def __init__(
        self, contacts: Contacts, drive: Drive, seed: int, points: npt.NDArray[np.intp]
    ) -> None:
        self.contacts, self.drive, self._seed = contacts, drive, seed
        self._cells = cells_of(contacts)
        self.linked = contacts.stiffness == "linked"
        # alike all along the path: without laws contacts know no time
        self._plain = drive.forward and (
            not contacts.laws or (contacts.laws == ("thermal",) and drive.time is None)
        )
        scale = contacts.mean_threshold
        furthest = self._furthest()
        path = np.append(0.0, drive.path)
        span = (np.maximum.accumulate(path) - np.minimum.accumulate(path))[1:]
        longest = _largest(contacts, drive, max(self._cells["thresholds"].largest, furthest))
        self._longest = min(longest, float(span[-1]) + furthest)
        check_growth(contacts, drive, self._longest)
        self._reached, self._differ = np.minimum(span + furthest, longest), 0.0
        stiffest = max(longest / scale, 1.0) if self.linked else 1.0
        if self.linked:
            # what breaks first is weak; but no contact is weaker than it is stretched
            usual = min(float(np.sqrt(contacts.thresholds.moment(2))) / scale, stiffest)
            self._reached *= np.maximum(self._reached / scale, usual)
            self._differ = max(usual**2 - 1.0, 0.0)
        course = Drive(drive.path, drive.velocity) if self._plain else drive
        self._exact = contacts.thresholds.atoms[0].size > 0
        self.lattice = make_lattice(course, scale, 2.0 * self._longest * stiffest, self._exact)
        unit = self.lattice.unit
        self._check_excess(unit)
        self._watch_points(points, span, furthest, longest)
        top = contacts.thresholds.support()[1] / unit
        self._top = np.int64(min(top, float(FAR)))
        self._law: Any = None
        start = contacts.start
        self._begun = np.int64(round(start.mean() / unit))
        # of a single start what its rounding leaves is told of the slider
        self._told = self.lattice.path + (start.mean() - self._begun * unit) * start.is_single
        # squares of a block's starts add up to 61 bits, however narrow the start
        apart = 1.0 + max(abs(end - start.mean()) for end in start.span) / unit
        spare = SUM_BITS - np.log2(BLOCK) - 2 * np.ceil(np.log2(apart))
        self._start_square = 2.0 ** min(spare, 0.0)
        self._kernel = self._forward() if self._plain else self._lives()
        self._columns = (2, 1) if self._plain else ((3, 5) if self.linked else (2, 3))
        rows = self.lattice.bins.points.size + 1
        # all blocks' sums, those of measured blocks, and with ageing of blocks in coarser steps
        self._parts = rows * np.array([self._columns[0], sum(self._columns), 0])
        if contacts.ageing is not None:
            self._parts[2] = self._parts[1]
        self.size = int(self._parts.sum())

    def _furthest(self) -> float:
        laws = [self.contacts.start]
        laws += [] if self.contacts.reforming is None else [self.contacts.reforming.law]
        return max(abs(end) for law in laws for end in law.span)

    def _check_excess(self, unit: float) -> None:
        """InputError where contacts all form again too near to the last thresholds for lengths of `unit`."""
        reforming, thresholds = self.contacts.reforming, self.contacts.thresholds
        if reforming is None or not reforming.law.is_single:
            return
        stretch = abs(reforming.law.mean())
        excess = float(thresholds.isf(0.5 * thresholds.sf(stretch))) - stretch
        if excess < _TOLD * unit:
            raise InputError(
                f"reforming: at |x| = {stretch:g} half of the contacts break again within {excess:.1g}, and the "
                f"ensemble takes lengths in steps of {unit:.1g}; use a smaller stretch, or a shorter path"
            )

    def _watch_points(
        self, points: npt.NDArray[np.intp], span: Array, furthest: float, longest: float
    ) -> None:
        from eq_model.watch import Watch

        bins, unit = self.lattice.bins, self.lattice.unit
        own = self.lattice.place[points]
        self._points, self._order = points, np.argsort(own, kind="stable")
        own = own[self._order]
        reach = float(span[points].max(initial=0.0)) + furthest
        self._range = make_range(reach, longest, _typical(self.contacts, longest))
        before = np.searchsorted(own, np.arange(bins.points.size + 2))
        self._watch = Watch(before, bins.points[own], bins.places[own], *self._range.per(unit))

    def _table(self, name: str) -> Table:
        """The cells of that name, or any where all is a single value."""
        return self._cells.get(name, self._cells["thresholds"]).table(self.lattice.unit)

    def _forward(self) -> Callable[..., tuple[int, int]]:
        from eq_model.forward import Plain, forward
        from eq_model.physics import rates_of

        start = self.contacts.start
        plain = Plain(
            self._table("thresholds"),
            self._table("start"),
            not start.is_single,
            self._begun,
            self._start_square,
            self._top,
            exposure_cells().table(LEVEL_UNIT),
            self.contacts.thermal is not None,
            rates_of(self.contacts),
            self.lattice.unit,
            1.0 / self.drive.velocity,
        )

        def run(stream: Any, count: int, sums: Any, counts: Counts, law: Any) -> tuple[int, int]:
            bins, watch = self.lattice.bins, self._watch
            made = forward(
                stream, count, plain, bins, watch, sums.measured, sums.all, sums.some, counts
            )
            return int(made), 0

        return run

    def _lives(self) -> Callable[..., tuple[int, int]]:
        from eq_model.lives import Settings, follow_lives
        from eq_model.physics import law_of

        contacts, unit = self.contacts, self.lattice.unit
        start, again = contacts.start, contacts.reforming
        spread = again is not None and not again.law.is_single
        self._law = law_of(contacts, self.lattice, TIE if self._exact else 0)
        settings = Settings(
            thresholds=self._table("thresholds"),
            reforming=self._table("reforming"),
            exposures=exposure_cells().table(LEVEL_UNIT),
            single=np.int64(0 if again is None or spread else round(again.law.mean() / unit)),
            top=self._top,
            mean=contacts.mean_threshold / unit,
            wait=contacts.waiting_time,
            starts=self._table("start"),
            begun=self._begun,
            square=self._start_square,
            drawn=not start.is_single,
            spread=spread,
            bears=contacts.thermal is not None or contacts.grains is not None,
            linked=self.linked,
        )

        def run(stream: Any, count: int, sums: Any, counts: Counts, law: Any) -> tuple[int, int]:
            course, bins, watch = self.lattice.course, self.lattice.bins, self._watch
            breaks, steps = follow_lives(
                stream, count, settings, law, course, bins, watch, sums, counts
            )
            return int(breaks), int(steps)

        return run

    @property
    def steps(self) -> float:
        """Steps in time that a contact takes at most; InputError where they are too many."""
        return check_steps(self.contacts, self.drive, getattr(self._law, "longest", 0.0))

    def seconds(self, often: float) -> float:
        """About how long a contact takes that breaks `often` at a temperature: what the size of blocks goes by."""
        travel = (
            float(np.abs(np.diff(self.drive.path, prepend=0.0)).sum())
            / self.contacts.mean_threshold
        )
        if self._plain:
            return 2e-9 * travel + 1e-7 * often
        return 2e-8 * travel + 1e-7 * often + 2e-7 * self.steps

    def follow(self, blocks: Blocks, block: int) -> Found:
        """Follow a block of contacts to the drive's end; -1 does nothing, compiled."""
        from eq_model.lives import Sums
        from eq_model.streams import make_stream

        rows, measured = self.lattice.bins.points.size + 1, is_measured(block)
        stream, count = (
            make_stream(self._seed, max(block, 0)),
            blocks.size(block) if block >= 0 else 0,
        )
        counts = np.zeros((self._points.size, 2, BINS), np.uint32)
        out = np.zeros((2, self.size), np.int64)
        every, some = (np.zeros((rows, many), np.int64) for many in self._columns)
        sums = Sums(every, some, measured)
        breaks, steps = self._kernel(stream, count, sums, counts, self._law)
        first, second, _ = self._parts
        out[:, :first] = split(sums.all.ravel())
        if measured:
            out[:, first : first + second] = split(np.hstack([sums.all, sums.some]).ravel())
        if self._parts[2] and (block < 0 or block % _EACH == 0):
            coarse = Sums(np.zeros_like(every), np.zeros_like(some), True)
            self._kernel(stream, count, coarse, counts[:0], self._law.coarser(COARSER))
            out[:, first + second :] = split(np.hstack([coarse.all, coarse.some]).ravel())
        return Found(out, counts, breaks, steps)

    def _moments(self, n: int, limbs: Whole) -> Moments:
        """Of n contacts, from limbs of all and some sums side by side; whole numbers, so nothing cancels."""
        from eq_model.lives import STIFFNESS_UNIT

        lattice, part, columns = self.lattice, int(STIFFNESS_UNIT), sum(self._columns)
        rows, reference = _rows(limbs, columns), lattice.bins.places.astype(object)
        start, rows = rows[-1], rows[:-1]
        some = rows[:, self._columns[0] :]
        number, back = 1.0 / lattice.bins.square, some[:, 0]
        # columns of stretches are whole lengths, those of stiffnesses parts of STIFFNESS_UNIT
        weight, first = (rows[:, 1], rows[:, 2]) if self.linked else (rows[:, 0] * part, rows[:, 1])
        squared, first_squared = (some[:, 3], some[:, 4]) if self.linked else (weight, first)
        count, held, born, squares, squares_born, squares_far = (
            np.cumsum(change)[lattice.place]
            for change in (
                rows[:, 0],
                weight,
                first * part + weight * reference,
                squared,
                first_squared * part + squared * reference,
                back * (round(number) * part)
                + reference * (2 * part * first_squared + squared * reference),
            )
        )
        if not self.linked:
            # contacts are relaxed where the slider is at minus their stretch at X = 0
            begun, many = int(self._begun), start[0]
            births = -part * (start[1] + many * begun)
            far = round(1.0 / self._start_square) * start[2] + begun * (2 * start[1] + many * begun)
            count, held, born = count + many, held + many * part, born + births
            squares, squares_born = squares + many * part, squares_born + births
            squares_far = squares_far + far * part
        at = np.rint(self._told / lattice.unit).astype(np.int64)
        beside, x = self._told - at * lattice.unit, at.astype(object)
        force = held * x - born
        spread = (squares * x - 2 * squares_born) * x + squares_far
        variance = (
            (spread * (part * n) - force * force).astype(float) * (lattice.unit / part) ** 2 / n
        )
        mean = (force.astype(float) * lattice.unit + held.astype(float) * beside) / (part * n)
        variance = np.maximum(variance, 0.0) / (n - 1) if n > 1 else np.full(mean.size, np.inf)
        return Moments(count.astype(float) / n, mean, variance)

    def _mean(self, n: int, limbs: Whole) -> Moments:
        """Without the variance, from limbs of all contacts' sums."""
        wide = np.zeros((2, limbs.shape[1] // self._columns[0], sum(self._columns)), np.int64)
        wide[:, :, : self._columns[0]] = limbs.reshape(2, -1, self._columns[0])
        return self._moments(n, wide.reshape(2, -1))

    def moments(self, blocks: Blocks, done: list[range], sums: Whole) -> Moments:
        """Of these blocks, with the variance that breaks too rare to be seen add."""
        n, measured = blocks.contacts(done), blocks.measured(done)
        first, second, _ = self._parts
        mean = self._mean(n, sums[:, :first])
        if not measured:
            return Moments(mean.holding, mean.force, np.full(mean.force.size, np.inf))
        limbs = sums[:, first : first + second]
        spread = self._moments(measured, limbs).variance
        seen = self._seen(n / measured, limbs)
        contacts, reached = self.contacts, self._reached.copy()
        if self._plain and contacts.thermal is None:
            # so early the first breaks are known better than that one might have been
            unseen, known = unseen_variance(contacts, self.lattice.path, measured)
            spread = np.maximum(spread, unseen)
            reached[:known] = 0.0
        warm = contacts.thermal is not None
        alike = contacts.start.is_single and not np.diff(contacts.thresholds.support())[0]
        if self._plain and alike and not warm:
            spread = np.zeros(spread.size)  # but for rounding: contacts are all alike
        else:
            present = spread + mean.force**2
            rare = unseen_break(seen, self.lattice.place, n, present, reached, warm)
            # the stiffest contacts may be in none of few
            spread = np.maximum(spread, np.maximum(rare, self._differ * mean.force**2))
        return Moments(mean.holding, mean.force, spread)

    def _seen(self, scale: float, limbs: Whole) -> Seen:
        """Breaks of `scale` times as many contacts as are measured."""
        unit, bins, held = self.lattice.unit, self.lattice.bins, self._columns[0]
        rows = _rows(limbs, sum(self._columns))[:-1].astype(float)
        points, area = bins.points.astype(float), unit**2 / bins.square
        if not self._plain:
            return Seen(points, rows[:, held + 1] * scale, rows[:, held + 2] * area * scale)
        # each break releases x at b, and x² + 2x (end - b) of the second moments about the bin's end
        stretches = np.maximum(rows[:, 1], 0.0) * unit
        squares = np.clip(-rows[:, held] * area, 0.0, self._longest * stretches)
        largest = squares.sum() / max(stretches.sum(), unit)
        breaks = stretches * (scale / largest) if largest > 0.0 else np.zeros(stretches.size)
        return Seen(points, breaks, squares * scale)

    def step_error(self, blocks: Blocks, done: list[range], sums: Whole) -> Array:
        """What the inner steps of ageing may add to the force at the points (a length); 0 without ageing.

        The error grows faster than in proportion to the step, so this is more than it is.
        """
        first, second, third = self._parts
        if not third:
            return np.zeros(self.lattice.path.size)
        coarse = [range(block, block + 1) for part in done for block in part if block % _EACH == 0]
        n, some = blocks.measured(done), blocks.contacts(coarse)
        if not some or not n:
            return np.full(self.lattice.path.size, np.inf)
        fine = self._moments(n, sums[:, first : first + second])
        other = self._moments(some, sums[:, first + second :])
        doubt = np.sqrt(fine.variance / n + other.variance / some)
        return (np.abs(other.force - fine.force) + doubt) / (COARSER - 1.0)

    def histograms(self, n: int, counts: Counts) -> Sequence[Histogram]:
        """What stood at the chosen points, in their order."""
        points, path, back = self._points, self.lattice.path, np.argsort(self._order)

        def make(index: int) -> Histogram:
            point = int(points[index])
            own = counts[int(back[index])]
            return histogram(point, float(path[point]), self._range, own, n)

        return Made(points.size, make)


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
    if isinstance(contacts.grains, GrainContact):
        return longest
    laws = [contacts.start, *(one.law for one in (contacts.reforming,) if one is not None)]
    final = 0.0 if contacts.ageing is None else contacts.ageing.final.mean()
    return max(contacts.mean_threshold, final, *(abs(law.mean()) for law in laws))
