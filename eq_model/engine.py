"""What blocks of independent contacts do, as sums of whole numbers, and what these say of the force."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model.draws.drawn import births_of, cells_of, exposure_cells
from eq_model.draws.tables import LEVEL_UNIT
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
from eq_model.moments import COARSER, COLUMNS, EACH, Readout, split
from eq_model.physics import furthest_threshold, law_of, seconds_of
from eq_model.state import Found, State
from origins import Contacts, Drive
from origins.contacts import LAWS, check_contacts
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

_TOLD = 256  # units in which half of the contacts break again: their mean is told to 1e-5


class Engine:
    """The blocks of one ensemble; `seconds`: about what a contact takes."""

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
        self._points = chosen_points(histograms, drive.path.size)
        # alike all along the path: without laws contacts know no time
        steady = not contacts.laws or (contacts.laws == ("thermal",) and drive.time is None)
        plain, scale = drive.forward and steady, contacts.mean_threshold
        laws = [contacts.start] + ([contacts.reforming.law] if contacts.reforming else [])
        furthest = max(abs(end) for law in laws for end in law.span)
        path = np.append(0.0, drive.path)
        high, low = np.maximum.accumulate(path)[1:], np.minimum.accumulate(path)[1:]
        span, ends = high - low, contacts.start.span
        begun = np.maximum(np.maximum(ends[1] + high, -ends[0] - low), max(np.abs(ends)))
        fresh = max(cells_of(contacts)["thresholds"].largest, furthest)
        largest = furthest_threshold(contacts, drive, fresh)
        longest = min(largest, float(span[-1]) + furthest)
        stiffest = max(largest / scale, 1.0) if contacts.stiffness == "linked" else 1.0
        course = Drive(drive.path, drive.velocity) if plain else drive
        exact = contacts.thresholds.atoms[0].size > 0
        self.lattice = make_lattice(course, scale, 2.0 * longest * stiffest, exact)
        self._plain, unit = plain, self.lattice.unit
        self._check_excess(unit)
        self._watch_points(span, furthest, largest)
        self._settings = self._make_settings()
        self._law = law_of(contacts, self.lattice, TIE * exact)
        self.seconds = seconds_of(contacts, drive, self._law)
        # of a single start what its rounding leaves is told of the slider
        start = contacts.start.mean()
        beside = (start - round(start / unit) * unit) * contacts.start.is_single
        told = self.lattice.path + beside
        self._readout = Readout(contacts, self.lattice, told, furthest, longest, span, begun)

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

    def _watch_points(self, span: Array, furthest: float, largest: float) -> None:
        """What is counted at the chosen points, in the order of the clock."""
        from eq_model.contact import Watch

        bins, own = self.lattice.bins, self.lattice.place[self._points]
        self._order = np.argsort(own, kind="stable")
        own = own[self._order]
        reach = float(span[self._points].max(initial=0.0)) + furthest
        self._range = make_range(reach, largest, self.contacts)
        before = np.searchsorted(own, np.arange(bins.points.size + 2))
        per = self._range.per(self.lattice.unit)
        self._watch = Watch(before, bins.points[own], bins.places[own], *per)

    def _make_settings(self) -> Any:
        from eq_model.contact import Settings

        contacts, unit = self.contacts, self.lattice.unit
        return Settings(
            *births_of(contacts, unit),
            exposures=exposure_cells().table(LEVEL_UNIT),
            mean=contacts.mean_threshold / unit,
            wait=contacts.waiting_time,
            bears=contacts.thermal is not None or contacts.grains is not None,
            linked=contacts.stiffness == "linked",
        )

    def nothing(self) -> tuple[Any, Any, Any]:
        """What no block found."""
        counts = no_counts(self._points.size, self._total)
        return np.zeros(self._shape, np.int64).reshape(2, -1), counts, np.empty(0)

    @property
    def _shape(self) -> tuple[int, ...]:
        """Of the sums: limbs; of all blocks, of measured ones, with ageing of those in coarser steps; bins; columns."""
        kinds = 2 if self.contacts.ageing is None else 3
        return 2, kinds, self.lattice.bins.points.size, COLUMNS

    def follow(self, blocks: Blocks, block: int) -> Found:
        """Follow a block of contacts to the drive's end; -1 does nothing, compiled."""
        count = blocks.size(block) if block >= 0 else 0
        counts = np.zeros((self._points.size, 2, BINS), np.uint32)
        out, measured = np.zeros(self._shape, np.int64), is_measured(block)
        out[:, 0], breaks, steps = self._run(block, count, measured, self._law, counts)
        if measured:
            out[:, 1] = out[:, 0]
        if self.contacts.ageing is not None:
            some, coarser = -(-count // EACH), self._law.coarser(COARSER)
            out[:, 2], _, _ = self._run(block, some, True, coarser, counts[:0])
        return Found(out.reshape(2, -1), counts, np.empty(0), breaks, steps)

    def _run(
        self, block: int, count: int, measured: bool, law: Any, counts: Counts
    ) -> tuple[Whole, int, int]:
        """Limbs of the sums, breaks and steps of the first `count` contacts of a block."""
        from eq_model.contact import Work
        from eq_model.draws.streams import make_stream
        from eq_model.forward import forward
        from eq_model.lives import follow_lives

        stream, lattice = make_stream(self._seed, max(block, 0)), self.lattice
        course, bins, watch = lattice.course, lattice.bins, self._watch
        work = Work(stream, self._settings, law, course, bins, watch, measured)
        # each column by itself: what is summed into most stays in the L1 cache
        sums = np.zeros((bins.points.size + 1, COLUMNS), np.int64, order="F")
        kernel = forward if self._plain else follow_lives
        breaks, steps = kernel(work, count, sums, counts)
        return split(sums[:-1]), int(breaks), int(steps)

    def told(self, blocks: Blocks, state: State) -> dict[str, Any]:
        """Fields of the result."""
        n, sums = state.contacts, state.sums.reshape(self._shape)
        found = self._readout.moments(blocks, state.done, sums)
        # where contacts may wait, or not pin, one that might have been is in the error
        waits = self.contacts.delay is not None or self.contacts.grains is not None
        varies = np.maximum(found.holding * (1.0 - found.holding), 1.0 / n if waits else 0.0)
        return {
            "force": found.force,
            "force_standard_error": np.sqrt(found.variance / n),
            "step_error": self._readout.step_error(blocks, state.done, sums),
            "holding": found.holding,
            "holding_standard_error": np.sqrt(varies / n),
        }

    def histograms(self, n: int, counts: Counts) -> Sequence[Histogram]:
        """What stood at the chosen points, in their order."""
        points, path, back = self._points, self.lattice.path, np.argsort(self._order)

        def make(index: int) -> Histogram:
            point = int(points[index])
            return histogram(point, float(path[point]), self._range, counts[int(back[index])], n)

        return Made(points.size, make)
