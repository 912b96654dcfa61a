"""What blocks of contacts do, as sums of whole numbers, and what these say of the force."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.drawn import cells_of, exposure_cells
from eq_model.histogram import BINS, Counts, Histogram, Made, histogram, make_range
from eq_model.lattice import SUM_BITS, TIE, make_lattice
from eq_model.layout import BLOCK, Blocks, is_measured
from eq_model.moments import COARSER, EACH, Readout, split
from eq_model.often import check_growth, check_steps, duration
from eq_model.tables import DEEPEST, FAR, LEVEL_UNIT, Table
from origins import Contacts, Drive, GrainContact
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

_TOLD = 256  # units in which half of the contacts break again: their mean is told to 1e-5
_SPREAD = 9.0  # standard deviations beyond which no threshold of 1e17 diffuses


class Found(NamedTuple):
    """Of one block: sums as two limbs, shape (2, size); counts of histograms; breaks; steps."""

    sums: Whole
    counts: Counts
    breaks: int
    steps: int


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
        reached, differ = np.minimum(span + furthest, longest), 0.0
        stiffest = max(longest / scale, 1.0) if self.linked else 1.0
        if self.linked:
            # what breaks first is weak; but no contact is weaker than it is stretched
            usual = min(float(np.sqrt(contacts.thresholds.moment(2))) / scale, stiffest)
            reached *= np.maximum(reached / scale, usual)
            differ = max(usual**2 - 1.0, 0.0)
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
        told = self.lattice.path + (start.mean() - self._begun * unit) * start.is_single
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
        self.readout = Readout(
            contacts,
            self.lattice,
            self._plain,
            int(self._begun),
            self._start_square,
            told,
            self._columns,
            self._parts,
            reached,
            differ,
            self._longest,
        )

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
        if self._parts[2]:
            coarse = Sums(np.zeros_like(every), np.zeros_like(some), True)
            self._kernel(stream, -(-count // EACH), coarse, counts[:0], self._law.coarser(COARSER))
            out[:, first + second :] = split(np.hstack([coarse.all, coarse.some]).ravel())
        return Found(out, counts, breaks, steps)

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
