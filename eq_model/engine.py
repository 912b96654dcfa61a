"""Blocks of independent contacts: their events as sums of whole numbers, and the force from these sums."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.histogram import BINS, chosen_points, histogram, make_edges, no_counts
from eq_model.lattice import STIFFNESS_UNIT, TIE, make_way
from eq_model.layout import Blocks, is_measured
from eq_model.physics import Reach, law_of, seconds_of
from eq_model.state import State
from origins import Contacts, Drive
from origins.contacts import LAWS, check_contacts
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

_LIMB = 32  # bits of the low one of the two numbers that hold a sum of all blocks
# with ageing, one in EACH contacts of a block is followed once more in steps COARSER times longer, to
# estimate the error of the steps
COARSER, EACH = 8, 8
# expected number of contacts with a larger threshold than the largest that n contacts are assumed to have
_RARE = 0.01
_NEVER = 1e-9  # expected number of breaks that counts as none


class Moments(NamedTuple):
    """At the points of the path: fraction that holds, mean force (a length), its variance between contacts."""

    holding: Array
    force: Array
    variance: Array


def _split(sums: Whole) -> Whole:
    """Whole sums as two limbs, high and low, shape (2, ...), which can be added over many blocks and ranks."""
    return np.stack([sums >> _LIMB, sums & ((1 << _LIMB) - 1)])


class Engine:
    """Follows the blocks of one ensemble; `seconds`: estimated time for one contact."""

    MOST = 1 << 37  # largest number of contacts of all replicas

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
        from eq_model.draws.births import LEVEL_UNIT, births_of, exposures

        self.contacts, self._seed, self._total = contacts, seed, total
        # the same law all along the path: without laws nothing depends on time
        steady = not contacts.laws or (contacts.laws == ("thermal",) and drive.time is None)
        self._plain, scale = drive.forward and steady, contacts.mean_threshold
        self._reach = reach = Reach(contacts, drive)
        linked = contacts.stiffness == "linked"
        stiffest = max(reach.largest / scale, 1.0) if linked else 1.0
        course = Drive(drive.path, drive.velocity) if self._plain else drive
        exact = contacts.thresholds.atoms[0].size > 0
        way = make_way(course, scale, 2.0 * reach.longest * stiffest, exact)
        self._drive, unit = drive, way.unit
        law = law_of(contacts, way, TIE * exact)
        self.seconds = seconds_of(contacts, drive, law)
        # the points of histograms, in the order of the clock
        self._points = chosen_points(histograms, drive.path.size)
        own = way.place[self._points]
        self._order = np.argsort(own, kind="stable")
        furthest = float(reach.span[self._points].max(initial=0.0)) + reach.furthest
        self._edges = make_edges(furthest, reach.largest, contacts)
        per = [unit / float(edges[2] - edges[1]) for edges in self._edges]
        self._work = Work(
            None,
            *births_of(contacts, unit),
            exposures=exposures().in_units(LEVEL_UNIT),
            law=law,
            way=way.watched(own[self._order], *per),
            mean=scale / unit,
            wait=contacts.waiting_time,
            needs_exposure=contacts.thermal is not None or contacts.grains is not None,
            linked=linked,
            measured=False,
        )

    def nothing(self) -> State:
        """The state of no blocks."""
        counts = no_counts(self._points.size, self._total)
        return State(np.zeros(self._shape, np.int64).reshape(2, -1), counts)

    @property
    def _shape(self) -> tuple[int, ...]:
        """Shape of the sums: limbs; kinds (all, measured, with ageing coarser steps); bins; columns of count_event."""
        kinds = 2 if self.contacts.ageing is None else 3
        return 2, kinds, self._work.way.points.size, 6 if self._work.linked else 3

    def follow(self, blocks: Blocks, block: int) -> State:
        """Follow a block of contacts to the drive's end; -1 only compiles."""
        from eq_model.draws.streams import make_stream
        from eq_model.lanes import follow_lives, forward

        count, measured = blocks.size(block) if block >= 0 else 0, is_measured(block)
        counts = np.zeros((self._points.size, 2, BINS), np.uint32)
        out, kernel = np.zeros(self._shape, np.int64), forward if self._plain else follow_lives
        work = self._work._replace(stream=make_stream(self._seed, max(block, 0)), measured=measured)
        # column by column, so that the column that is used most stays in the L1 cache
        sums = np.zeros((self._shape[2] + 1, self._shape[3]), np.int64, order="F")
        breaks, steps = kernel(work, count, sums, counts)
        out[:, 0] = _split(sums[:-1])
        if measured:
            out[:, 1] = out[:, 0]
        if self.contacts.ageing is not None:
            work = work._replace(law=work.law.coarser(COARSER), measured=True)
            sums[:] = 0
            kernel(work, -(-count // EACH), sums, counts[:0])
            out[:, 2] = _split(sums[:-1])
        return State(out.reshape(2, -1), counts, breaks=int(breaks), steps=int(steps))

    def told(self, blocks: Blocks, state: State) -> dict[str, Any]:
        """Fields of the result."""
        n, sums = state.contacts, state.sums.reshape(self._shape)
        found = self._all_moments(blocks, state.done, sums)
        # where contacts may be out, the error includes one that happened not to be
        waits = self.contacts.delay is not None or self.contacts.grains is not None
        varies = np.maximum(found.holding * (1.0 - found.holding), 1.0 / n if waits else 0.0)
        order = np.argsort(self._order)[: len(state.counts)]  # none where they are not wanted
        counts = zip(self._points.tolist(), state.counts[order], strict=False)
        path = self._drive.path
        return {
            "force": found.force,
            "force_standard_error": np.sqrt(found.variance / n),
            "step_error": self._step_error(blocks, state.done, sums),
            "holding": found.holding,
            "holding_standard_error": np.sqrt(varies / n),
            "histograms": [histogram(k, float(path[k]), self._edges, own, n) for k, own in counts],
        }

    def _moments(self, n: int, limbs: Whole) -> Moments:
        """Moments of n contacts from limbs of their sums, in whole numbers, so that nothing is lost by cancellation.

        y is minus a contact's stretch at the end of its bin, at `places`; sums of k y are whole lengths,
        sums of k are in units of 1/STIFFNESS_UNIT.
        """
        way, part, unit = self._work.way, int(STIFFNESS_UNIT), self._work.way.unit
        whole = limbs[0].astype(object) * (1 << _LIMB) + limbs[1].astype(object)
        count, ky, square, *rest = whole.reshape(-1, self._shape[3]).T
        k, kky, kk = rest or (count * part, ky, count * part)
        places, per_square = way.places.astype(object), round(1.0 / way.square)
        far = square * (per_square * part) + places * (2 * part * kky + kk * places)
        born, squares_born = ky * part + k * places, kky * part + kk * places
        changes = np.cumsum([count, k, born, kk, squares_born, far], axis=1)
        holds, held, born, squares, squares_born, far = changes[:, way.place]
        # the rounding of a single starting stretch is corrected as a displacement of the slider
        start = self.contacts.start
        lost = (start.mean() - round(start.mean() / unit) * unit) * start.is_single
        told = self._drive.path + lost
        at = np.rint(told / unit).astype(np.int64)
        beside, x = told - at * unit, at.astype(object)
        force = held * x - born
        spread = ((squares * x - 2 * squares_born) * x + far) * (part * n) - force * force
        mean = (force.astype(float) * unit + held.astype(float) * beside) / (part * n)
        variance = np.full(mean.size, np.inf)
        if n > 1:
            variance = spread.astype(float) * (unit / part) ** 2 / n / (n - 1)
        return Moments(holds.astype(float) / n, mean, np.maximum(variance, 0.0))

    def _all_moments(self, blocks: Blocks, done: list[range], sums: Whole) -> Moments:
        """Moments of these blocks; the variance, from measured blocks, has a lower limit for unseen breaks."""
        n, measured = blocks.contacts(done), blocks.measured(done)
        mean = self._moments(n, sums[:, 0])
        if measured < 2:
            return mean._replace(variance=np.full(mean.force.size, np.inf))
        seen = self._moments(measured, sums[:, 1]).variance
        return mean._replace(variance=self._no_less(seen, n))

    def _no_less(self, seen: Array, n: int) -> Array:
        """The variance, at least that which one break more or less would make in n contacts."""
        contacts, reach, start = self.contacts, self._reach, self.contacts.start
        stretch = np.minimum(reach.span + reach.furthest, reach.longest)
        law, again, mean = contacts.thresholds, contacts.reforming, contacts.mean_threshold
        constant = contacts.ageing is None and contacts.grains is None
        cold = constant and contacts.thermal is None
        alike = start.is_single and not np.diff(law.support())[0]
        if cold and alike and (again is None or again.law.is_single):
            return np.zeros(seen.size)  # all contacts do the same
        # one break among n contacts, wherever breaks are possible
        share = np.full(seen.size, 1.0 / n)
        if cold:
            held = law.sf(abs(start.mean()) if start.is_single else 0.0)
            broken = n * (held - law.sf(reach.begun)) > _NEVER * held
            share *= broken & (reach.span > 0.0)
        if constant:
            stretch = np.minimum(stretch, max(float(law.isf(_RARE / n)), reach.furthest))
        linked = contacts.stiffness == "linked"
        if linked:  # a contact's threshold is not below its stretch
            stretch = stretch * np.maximum(stretch, float(np.sqrt(law.moment(2)))) / mean
        least = stretch**2 * share
        rounded = self._work.way.unit**2 / self._work.way.square  # rounding of squares of stretches
        if linked or not start.is_single:
            return np.maximum(seen, np.maximum(least, rounded))
        return np.maximum(np.where(seen < rounded, 0.0, seen), least)

    def _step_error(self, blocks: Blocks, done: list[range], sums: Whole) -> Array:
        """Bound on the error of the force by the inner steps of ageing, at the points (a length); 0 without ageing.

        It assumes that the error is proportional to the step, while it grows faster.
        """
        if sums.shape[1] == 2:
            return np.zeros(self._drive.path.size)
        n = blocks.measured(done)
        some = sum(-(-blocks.size(block) // EACH) for part in done for block in part)
        if not some or not n:
            return np.full(self._drive.path.size, np.inf)
        fine, other = self._moments(n, sums[:, 1]), self._moments(some, sums[:, 2])
        doubt = np.sqrt(fine.variance / n + other.variance / some)
        return (np.abs(other.force - fine.force) + doubt) / (COARSER - 1.0)
