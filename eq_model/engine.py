"""What blocks of contacts do, as sums of whole numbers, and what these say of the force."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.drawn import cells_of, exposure_cells
from eq_model.histogram import (
    BINS,
    Counts,
    Histogram,
    Made,
    chosen_points,
    histogram,
    make_range,
    no_counts,
)
from eq_model.lattice import TIE, make_lattice
from eq_model.layout import Blocks, is_measured
from eq_model.moments import COARSER, EACH, Readout, split
from eq_model.physics import law_of
from eq_model.state import Found, State
from eq_model.tables import DEEPEST, FAR, LEVEL_UNIT, Table
from eq_model.work import duration, events
from origins import Contacts, Drive, GrainContact
from origins.contacts import LAWS, check_contacts
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

_TOLD = 256  # units in which half of the contacts break again: their mean is told to 1e-5
_SPREAD = 9.0  # standard deviations beyond which no threshold of 1e17 diffuses


class _Ran(NamedTuple):
    """Sums of all contacts and more of measured ones, shape (bins, columns); breaks and steps."""

    every: Whole
    some: Whole
    breaks: int
    steps: int


class Engine:
    """The blocks of one ensemble; `seconds`: about what a contact takes, `size`: of the sums."""

    MOST = 1 << 37  # contacts of all replicas

    def __init__(
        self, contacts: Contacts, drive: Drive, seed: int, histograms: npt.ArrayLike, total: int
    ) -> None:
        check_contacts(contacts, "eq_model.simulate", LAWS, own_rates=True)
        for name, law in (("thermal", contacts.thermal), ("ageing", contacts.ageing)):
            if law is not None and law.closure == "paper":
                raise InputError(
                    f'contacts.{name}: closure = "paper" is an approximation of the master equation, which single '
                    'contacts do not know; use closure = "exact"'
                )
        self.contacts, self._seed, self._total = contacts, seed, total
        points = chosen_points(histograms, drive.path.size)
        self._cells = cells_of(contacts)
        self._linked = contacts.stiffness == "linked"
        # alike all along the path: without laws contacts know no time
        steady = not contacts.laws or (contacts.laws == ("thermal",) and drive.time is None)
        self._plain = drive.forward and steady
        scale, laws = contacts.mean_threshold, [contacts.start]
        laws += [] if contacts.reforming is None else [contacts.reforming.law]
        furthest = max(abs(end) for law in laws for end in law.span)
        path = np.append(0.0, drive.path)
        low, high = np.minimum.accumulate(path)[1:], np.maximum.accumulate(path)[1:]
        span = high - low
        largest = _largest(contacts, drive, max(self._cells["thresholds"].largest, furthest))
        longest = min(largest, float(span[-1]) + furthest)
        stiffest = max(largest / scale, 1.0) if self._linked else 1.0
        course = Drive(drive.path, drive.velocity) if self._plain else drive
        exact = contacts.thresholds.atoms[0].size > 0
        self.lattice = make_lattice(course, scale, 2.0 * longest * stiffest, exact)
        unit = self.lattice.unit
        self._check_excess(unit)
        self._watch_points(points, span, furthest, largest)
        self._begun = np.int64(round(contacts.start.mean() / unit))
        self._settings = self._make_settings()
        self._law = law_of(contacts, self.lattice, TIE * exact)
        steps = 0.0 if contacts.ageing is None else duration(drive) / self._law.longest
        travel = float(np.abs(np.diff(drive.path, prepend=0.0)).sum()) / scale
        self.seconds = 2e-8 * travel + 1e-7 * events(contacts, drive, steps) + 2e-7 * steps
        self._columns = (3, 3) if self._linked else (2, 1)
        # all blocks' sums, those of measured blocks, and with ageing of blocks in coarser steps
        measured, ages = sum(self._columns), contacts.ageing is not None
        rows = self.lattice.bins.points.size
        self._parts = rows * np.array([self._columns[0], measured, measured * ages])
        self.size = int(self._parts.sum())
        # of a single start what its rounding leaves is told of the slider
        beside = (contacts.start.mean() - self._begun * unit) * contacts.start.is_single
        told = self.lattice.path + beside
        stretch = np.minimum(span + furthest, longest)
        self.readout = Readout(
            contacts, self.lattice, told, self._columns, self._parts, furthest, low, high, stretch
        )

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
        self, points: npt.NDArray[np.intp], span: Array, furthest: float, largest: float
    ) -> None:
        from eq_model.contact import Watch

        bins, own = self.lattice.bins, self.lattice.place[points]
        self._points, self._order = points, np.argsort(own, kind="stable")
        own = own[self._order]
        reach = float(span[points].max(initial=0.0)) + furthest
        self._range = make_range(reach, largest, _typical(self.contacts, largest))
        before = np.searchsorted(own, np.arange(bins.points.size + 2))
        per = self._range.per(self.lattice.unit)
        self._watch = Watch(before, bins.points[own], bins.places[own], *per)

    def _table(self, name: str) -> Table:
        """The cells of that name, or any where all is a single value."""
        return self._cells.get(name, self._cells["thresholds"]).table(self.lattice.unit)

    def _make_settings(self) -> Any:
        from eq_model.contact import Settings

        contacts, again, unit = self.contacts, self.contacts.reforming, self.lattice.unit
        spread = again is not None and not again.law.is_single
        return Settings(
            thresholds=self._table("thresholds"),
            starts=self._table("start"),
            reforming=self._table("reforming"),
            exposures=exposure_cells().table(LEVEL_UNIT),
            begun=self._begun,
            single=np.int64(0 if again is None or spread else round(again.law.mean() / unit)),
            top=np.int64(min(contacts.thresholds.support()[1] / unit, float(FAR))),
            mean=contacts.mean_threshold / unit,
            wait=contacts.waiting_time,
            drawn=not contacts.start.is_single,
            spread=spread,
            bears=contacts.thermal is not None or contacts.grains is not None,
            linked=self._linked,
        )

    def follow(self, blocks: Blocks, block: int) -> Found:
        """Follow a block of contacts to the drive's end; -1 does nothing, compiled."""
        count = blocks.size(block) if block >= 0 else 0
        counts = np.zeros((self._points.size, 2, BINS), np.uint32)
        out, (first, second, _) = np.zeros((2, self.size), np.int64), self._parts
        every, some, breaks, steps = self._run(block, count, is_measured(block), self._law, counts)
        out[:, :first] = split(every.ravel())
        if is_measured(block):
            out[:, first : first + second] = split(np.hstack([every, some]).ravel())
        if self._parts[2]:
            law = self._law.coarser(COARSER)
            every, some, *_ = self._run(block, -(-count // EACH), True, law, counts[:0])
            out[:, first + second :] = split(np.hstack([every, some]).ravel())
        return Found(out, counts, np.empty(0), breaks, steps)

    def _run(self, block: int, count: int, measured: bool, law: Any, counts: Counts) -> _Ran:
        """Sums of all and more sums, breaks and steps of the first `count` contacts of a block."""
        from eq_model.contact import Sums
        from eq_model.forward import forward
        from eq_model.lives import follow_lives
        from eq_model.streams import make_stream

        rows, lattice = self.lattice.bins.points.size + 1, self.lattice
        every, some = (np.zeros((rows, many), np.int64) for many in self._columns)
        sums = Sums(every, some, measured)
        stream, watch = make_stream(self._seed, max(block, 0)), self._watch
        settings, course, bins = self._settings, lattice.course, lattice.bins
        kernel = forward if self._plain else follow_lives
        breaks, steps = kernel(stream, count, settings, law, course, bins, watch, sums, counts)
        return _Ran(every[:-1], some[:-1], int(breaks), int(steps))

    def nothing(self) -> tuple[Any, Any, Any]:
        """What no block found."""
        counts = no_counts(self._points.size, self._total)
        return np.zeros((2, self.size), np.int64), counts, np.empty(0)

    def told(self, blocks: Blocks, state: State) -> dict[str, Any]:
        """Fields of the result."""
        n, found = state.contacts, self.readout.moments(blocks, state.done, state.sums)
        # where contacts may wait, or not pin, one that might have been is in the error
        waits = self.contacts.delay is not None or self.contacts.grains is not None
        varies = np.maximum(found.holding * (1.0 - found.holding), 1.0 / n if waits else 0.0)
        return {
            "force": found.force,
            "force_standard_error": np.sqrt(found.variance / n),
            "step_error": self.readout.step_error(blocks, state.done, state.sums),
            "holding": found.holding,
            "holding_standard_error": np.sqrt(varies / n),
        }

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
