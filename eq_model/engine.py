"""Blocks of independent contacts: their events as sums of whole numbers, and the force from these sums."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Blocks, State, is_measured
from eq_model.histogram import BINS, chosen_points, histogram, make_edges
from eq_model.lattice import STIFFNESS_UNIT, TIE, whole_drive
from eq_model.physics import Reach, law_of, seconds_of
from origins import Contacts, Drive
from origins.contacts import LAWS, check_contacts
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]


class Moments(NamedTuple):
    """At the points of the path: fraction that holds, mean force (a length), its variance between contacts."""

    holding: Array
    force: Array
    variance: Array


class Engine:
    """Follows the blocks of one ensemble; `seconds`: estimated time for one contact."""

    MOST = 1 << 37  # largest number of contacts of all replicas
    # with ageing, one in so many contacts is followed once more in steps so many times longer, to estimate their error
    COARSER = 8

    def __init__(
        self, contacts: Contacts, drive: Drive, seed: int, histograms: npt.ArrayLike, total: int
    ) -> None:
        """Choose unit, bins and law; InputError for contacts and drives that cannot be followed."""
        check_contacts(contacts, "eq_model.simulate", LAWS, own_rates=True)
        if contacts.each_by_itself() is not contacts:
            name = "thermal" if getattr(contacts.thermal, "closure", "") == "paper" else "ageing"
            raise InputError(
                f'contacts.{name}: closure = "paper" is an approximation of the master equation, which single '
                'contacts do not know; use closure = "exact"'
            )
        from eq_model.contact import Work
        from eq_model.draws.births import births_of, exposures
        from eq_model.lanes import Forward

        self.contacts, self._seed, self._total, self._drive = contacts, seed, total, drive
        # the same law all along the path: without laws nothing depends on time
        steady = not contacts.laws or (contacts.laws == ("thermal",) and drive.time is None)
        forward, scale = drive.forward and steady, contacts.mean_threshold
        self._reach = reach = Reach(contacts, drive)
        linked = contacts.stiffness == "linked"
        stiffest = max(reach.largest / scale, 1.0) if linked else 1.0
        course = Drive(drive.path, drive.velocity) if forward else drive
        exact = contacts.thresholds.atoms[0].size > 0
        way = whole_drive(course, scale, 2.0 * reach.longest * stiffest, exact)
        law = law_of(contacts, way, TIE * exact)
        self.seconds = seconds_of(contacts, drive, law)
        # the points of histograms, in the order of the clock
        self._points = points = chosen_points(histograms, drive.path.size)
        self._order = np.argsort(way.bin_of_point[points], kind="stable")
        furthest = float(reach.span[points].max(initial=0.0)) + reach.furthest
        self._edges = make_edges(furthest, reach.largest, contacts)
        watched = way.bin_of_point[points][self._order]
        stretches, thresholds = (way.unit / float(edges[2] - edges[1]) for edges in self._edges)
        self._work = Work(
            None,
            *births_of(contacts, way.unit),
            exposures=exposures(),
            law=Forward(law) if forward else law,
            way=way._replace(
                watched=watched,
                before=np.searchsorted(watched, np.arange(way.bin_ends.size + 2)),
                per_stretch=stretches,
                per_threshold=thresholds,
            ),
            mean=scale / way.unit,
            wait=contacts.waiting_time,
            needs_exposure=contacts.thermal is not None or contacts.grains is not None,
            linked=linked,
            measured=False,
        )

    def nothing(self) -> State:
        """The state of no blocks."""
        kind = np.uint32 if self._total < 1 << 32 else np.uint64
        counts = np.zeros((self._points.size, 2, BINS), kind)
        return State(np.zeros(self._shape, np.int64), counts)

    @property
    def _shape(self) -> tuple[int, ...]:
        """Shape of the sums: limbs; kinds (all, measured, with ageing coarser steps); bins; columns of count_event."""
        kinds = 2 if self.contacts.ageing is None else 3
        return 2, kinds, self._work.way.bin_ends.size, 6 if self._work.linked else 3

    def follow(self, blocks: Blocks, block: int) -> State:
        """Follow a block of contacts to the drive's end; -1 only compiles."""
        from eq_model.draws.streams import make_stream
        from eq_model.lanes import follow

        count, measured = blocks.size(block) if block >= 0 else 0, is_measured(block)
        counts = np.zeros((self._points.size, 2, BINS), np.uint32)
        work = self._work._replace(stream=make_stream(self._seed, max(block, 0)), measured=measured)
        _, kinds, bins, columns = self._shape
        # column by column, so that the column that is used most stays in the L1 cache
        sums, coarse = (np.zeros((bins + 1, columns), np.int64, order="F") for _ in range(2))
        breaks = follow(work, count, sums, counts)
        if kinds == 3:
            work = work._replace(law=work.law.coarser(self.COARSER), measured=True)
            follow(work, -(-count // self.COARSER), coarse, counts[:0])
        found = np.stack([sums, sums * measured, coarse][:kinds])[:, :-1]
        limbs = np.stack([found >> 32, found & 0xFFFFFFFF])
        return State(limbs, counts, breaks=int(breaks))

    def fields(self, blocks: Blocks, state: State) -> dict[str, Any]:
        """Fields of the result."""
        contacts, path, n = self.contacts, self._drive.path, state.contacts
        measured, sums = blocks.measured(state.done), state.sums
        found, variance = self._moments(n, sums[:, 0]), np.full(path.size, np.inf)
        if measured > 1:
            variance = self._with_unseen(self._moments(measured, sums[:, 1]).variance, n)
        # where contacts may be out, the error includes one that happened not to be
        waits = contacts.delay is not None or contacts.grains is not None
        varies = np.maximum(found.holding * (1.0 - found.holding), 1.0 / n if waits else 0.0)
        order = np.argsort(self._order)[: len(state.counts)]  # none where they are not wanted
        counts = zip(self._points.tolist(), state.counts[order], strict=False)
        return {
            "force": found.force,
            "force_standard_error": np.sqrt(variance / n),
            "step_error": self._step_error(blocks, state.done, sums),
            "holding": found.holding,
            "holding_standard_error": np.sqrt(varies / n),
            "histograms": [histogram(k, float(path[k]), self._edges, own, n) for k, own in counts],
        }

    def _moments(self, n: int, limbs: Whole) -> Moments:
        """Moments of n contacts from the high and low 32 bits of their sums, without loss by cancellation.

        y is minus a contact's stretch at the end of its bin; sums of k y are whole lengths,
        sums of k are in units of 1/STIFFNESS_UNIT.
        """
        way, part, unit = self._work.way, int(STIFFNESS_UNIT), self._work.way.unit
        whole = limbs[0].astype(object) * (1 << 32) + limbs[1].astype(object)
        count, ky, square, *rest = whole.T
        k, kky, kk = rest or (count * part, ky, count * part)
        places, per_square = way.bin_positions.astype(object), round(1.0 / way.square)
        far = square * (per_square * part) + places * (2 * part * kky + kk * places)
        born, squares_born = ky * part + k * places, kky * part + kk * places
        changes = np.cumsum([count, k, born, kk, squares_born, far], axis=1)
        holds, held, born, squares, squares_born, far = changes[:, way.bin_of_point]
        # the rounding of a single starting stretch is corrected as a displacement of the slider
        start = self.contacts.start
        rounded = start.is_single * (start.mean() - round(start.mean() / unit) * unit)
        positions = self._drive.path + rounded
        at = np.rint(positions / unit).astype(np.int64)
        beside, x = positions - at * unit, at.astype(object)
        force = held * x - born
        spread = ((squares * x - 2 * squares_born) * x + far) * (part * n) - force * force
        mean = (force.astype(float) * unit + held.astype(float) * beside) / (part * n)
        variance = np.full(mean.size, np.inf)
        if n > 1:
            variance = spread.astype(float) * (unit / part) ** 2 / n / (n - 1)
        return Moments(holds.astype(float) / n, mean, np.maximum(variance, 0.0))

    def _with_unseen(self, seen: Array, n: int) -> Array:
        """The variance, at least what one break more or less would make in n contacts, where one may happen."""
        contacts, reach, start = self.contacts, self._reach, self.contacts.start
        stretch = np.minimum(reach.span + reach.furthest, reach.longest)
        law, again, share = contacts.thresholds, contacts.reforming, np.full(seen.size, 1.0 / n)
        constant = contacts.ageing is None and contacts.grains is None
        if constant and contacts.thermal is None:
            alike = start.is_single and not np.diff(law.support())[0]
            if alike and (again is None or again.law.is_single):
                return np.zeros(seen.size)  # all contacts do the same
            # an expected number of 1e-9 breaks counts as none
            held = law.sf(abs(start.mean()) if start.is_single else 0.0)
            share *= (n * (held - law.sf(reach.begun)) > 1e-9 * held) & (reach.span > 0.0)
        if constant:
            # one in a hundred ensembles has a contact with a larger threshold
            stretch = np.minimum(stretch, max(float(law.isf(0.01 / n)), reach.furthest))
        if contacts.stiffness == "linked":  # a contact's threshold is not below its stretch
            typical = np.maximum(stretch, float(np.sqrt(law.moment(2))))
            stretch = stretch * typical / contacts.mean_threshold
        rounding = self._work.way.unit**2 / self._work.way.square  # of squares of stretches
        return np.maximum(np.where(seen < rounding, 0.0, seen), stretch**2 * share)

    def _step_error(self, blocks: Blocks, done: list[range], sums: Whole) -> Array:
        """Bound on the error of the force by the inner steps of ageing, at the points (a length); 0 without ageing.

        It assumes that the error is proportional to the step, while it grows faster.
        """
        if sums.shape[1] == 2:
            return np.zeros(self._drive.path.size)
        n = blocks.measured(done)
        some = sum(-(-blocks.size(block) // self.COARSER) for part in done for block in part)
        if not some or not n:
            return np.full(self._drive.path.size, np.inf)
        fine, coarse = self._moments(n, sums[:, 1]), self._moments(some, sums[:, 2])
        doubt = np.sqrt(fine.variance / n + coarse.variance / some)
        return (np.abs(coarse.force - fine.force) + doubt) / (self.COARSER - 1.0)
