"""Blocks of independent contacts: the law by which they break, their events as whole sums, and the force from these."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import BLOCK, Blocks, State, Whole
from eq_model.draws.tables import DEEPEST
from eq_model.result import BINS, chosen_points, histogram, make_edges
from eq_model.whole_drive import STIFFNESS_UNIT, TIE, durations, ticks_of, whole_drive
from origins import Contacts, Drive
from origins.contacts import LAWS, check_contacts
from origins.errors import InputError
from origins.thresholds.law import Array


class Moments(NamedTuple):
    """At the points of the path: fraction that holds, mean force (a length), its variance between contacts."""

    holding: Array
    force: Array
    variance: Array


class Engine:
    """Follows the blocks of one ensemble; `nothing`: the state of no blocks."""

    MOST = 1 << 37  # largest number of contacts of all replicas
    # with ageing, one in so many contacts is followed once more in steps so many times longer, to estimate their error
    COARSER = 8

    def __init__(
        self, contacts: Contacts, drive: Drive, blocks: Blocks, seed: int, histograms: npt.ArrayLike
    ) -> None:
        """Choose unit, bins, law and smaller blocks; InputError for contacts and drives that cannot be followed."""
        check_contacts(contacts, "eq_model.simulate", LAWS, own_rates=True)
        if contacts.each_by_itself() is not contacts:
            name = "thermal" if getattr(contacts.thermal, "closure", "") == "paper" else "ageing"
            raise InputError(
                f'contacts.{name}: closure = "paper" is an approximation of the master equation, which single contacts '
                'do not know; use closure = "exact"'
            )
        from eq_model.contact import AGED, Work
        from eq_model.draws.births import births_of, exposures
        from eq_model.laws.settings import law_of
        from eq_model.row_breaks import Forward

        self.contacts, self._seed, self._drive = contacts, seed, drive
        # the same law all along the path: without laws nothing depends on time
        steady = not contacts.laws or (contacts.laws == ("thermal",) and drive.time is None)
        forward, scale = drive.forward and steady, contacts.mean_threshold
        self._limits = limits = StretchLimits(contacts, drive)
        linked = contacts.stiffness == "linked"
        begins_at_0 = contacts.growing is not None and contacts.growing.begins_at_0
        stiffest = max(limits.largest_threshold / scale, 1.0) if linked else 1.0
        course = Drive(drive.path, drive.velocity) if forward else drive
        exact = contacts.thresholds.atoms[0].size > 0
        in_units = whole_drive(course, scale, 2.0 * limits.largest_stretch * stiffest, exact)
        law = law_of(contacts, in_units, TIE * exact)
        # a block takes at most 0.25 s, after which a run can be stopped
        slow = max(int(0.25 / max(seconds_of(contacts, drive, law), 1e-12)), 1)
        self.blocks = blocks._replace(each=min(slow, blocks.each, BLOCK))
        # the points of histograms, in the order of the clock
        self._points = points = chosen_points(histograms, drive.path.size)
        if points.size and type(law) not in AGED:
            instead = "leave them out, see docs/extending.md"
            raise InputError(
                f"histograms: the kernel of {', '.join(contacts.laws)} has no line of AGED; {instead}"
            )
        self._order = np.argsort(in_units.bin_of_point[points], kind="stable")
        furthest = float(limits.span[points].max(initial=0.0)) + limits.largest_birth
        self._edges = make_edges(furthest, limits.largest_threshold, limits.typical_threshold)
        watched = in_units.bin_of_point[points][self._order]
        per_x, per_y = (in_units.unit / float(edges[2] - edges[1]) for edges in self._edges)
        before = np.searchsorted(watched, np.arange(in_units.bin_ends.size + 1))
        in_units = in_units._replace(
            watched=watched, before=before, per_stretch=per_x, per_threshold=per_y
        )
        self._law: Any = Forward(law) if forward else law
        self._work = Work(
            None,
            *births_of(contacts, in_units.unit),
            exposures=exposures(),
            forward=forward,
            at_once=contacts.waiting_time == 0.0 and contacts.reforming is None,
            drive=in_units,
            mean=scale / in_units.unit,
            wait=contacts.waiting_time,
            ticks=ticks_of(in_units, contacts.waiting_time),
            needs_exposure=begins_at_0
            or (contacts.thermal is not None and contacts.growing is None),
            linked=linked,
            measured=False,
        )
        # of sums: limbs; kinds (all, measured, with ageing coarser steps); bins; columns of count_event
        self._shape = (
            2,
            2 + (contacts.ageing is not None),
            in_units.bin_ends.size - 1,
            6 if linked else 3,
        )
        kind = np.uint32 if blocks.total < 1 << 32 else np.uint64
        counts = np.zeros((points.size, 2, BINS), kind)
        self.nothing = State(np.zeros(self._shape, np.int64), counts)

    def follow(self, block: int) -> State:
        """Follow a block of contacts to the drive's end; -1 only compiles."""
        from eq_model.draws.births import make_scratch
        from eq_model.draws.streams import make_stream
        from eq_model.lanes import follow, follow_anew

        if not type(self._law).__module__.startswith("eq_model."):
            follow = follow_anew
        count, measured = self.blocks.size(block), self.blocks.is_measured(block)
        counts = np.zeros((self._points.size, 2, BINS), np.uint32)
        work = self._work._replace(stream=make_stream(self._seed, max(block, 0)), measured=measured)
        _, kinds, bins, columns = self._shape
        # column by column, so that the column that is used most stays in the L1 cache
        sums, coarse = (np.zeros((bins + 1, columns), np.int64, order="F") for _ in range(2))
        breaks = follow(self._law, work, make_scratch(), count, sums, counts)
        if kinds == 3:
            law, work = self._law.coarser(self.COARSER), work._replace(measured=True)
            follow(law, work, make_scratch(), -(-count // self.COARSER), coarse, counts[:0])
        found = np.stack([sums, sums * measured, coarse][:kinds])[:, :-1]
        return State(np.stack([found >> 32, found & 0xFFFFFFFF]), counts, breaks=int(breaks))

    def fields(self, state: State) -> dict[str, Any]:
        """Fields of the result."""
        contacts, path, n = self.contacts, self._drive.path, state.contacts
        measured, sums = self.blocks.measured(state.done), state.sums
        found, variance = self._moments(n, sums[:, 0]), np.full(path.size, np.inf)
        if measured > 1:
            variance = self._with_unseen(self._moments(measured, sums[:, 1]).variance, n)
        # where contacts may be out, the error includes one that happened not to be
        least = 1.0 / n if contacts.waiting_time else 0.0
        varies = np.maximum(found.holding * (1.0 - found.holding), least)
        order = np.argsort(self._order)[: len(state.counts)]  # none where they are not wanted
        counts = zip(self._points.tolist(), state.counts[order], strict=False)
        return {
            "force": found.force,
            "force_standard_error": np.sqrt(variance / n),
            "step_error": self._step_error(state.done, sums),
            "holding": found.holding,
            "holding_standard_error": np.sqrt(varies / n),
            "histograms": [histogram(k, float(path[k]), self._edges, own, n) for k, own in counts],
        }

    def _moments(self, n: int, limbs: Whole) -> Moments:
        """Moments of n contacts from the high and low 32 bits of their sums, without loss by cancellation.

        y is minus a contact's stretch at the end of its bin; sums of k y are whole lengths,
        sums of k are in units of 1/STIFFNESS_UNIT.
        """
        drive, part, unit = self._work.drive, int(STIFFNESS_UNIT), self._work.drive.unit
        whole = limbs[0].astype(object) * (1 << 32) + limbs[1].astype(object)
        count, ky, square, *rest = whole.T
        k, kky, kk = rest or (count * part, ky, count * part)
        places, per_square = drive.bin_positions[:-1].astype(object), round(1.0 / drive.square)
        far = square * (per_square * part) + places * (2 * part * kky + kk * places)
        born, squares_born = ky * part + k * places, kky * part + kk * places
        changes = np.cumsum([count, k, born, kk, squares_born, far], axis=1)
        holds, stiffness, born, squares, squares_born, far = changes[:, drive.bin_of_point]
        # the rounding of a single starting stretch is corrected as a displacement of the slider
        start = self.contacts.start
        rounded = start.is_single * (start.mean() - round(start.mean() / unit) * unit)
        positions = self._drive.path + rounded
        at = np.rint(positions / unit).astype(np.int64)
        beside, x = positions - at * unit, at.astype(object)
        force = stiffness * x - born
        spread = ((squares * x - 2 * squares_born) * x + far) * (part * n) - force * force
        mean = (force.astype(float) * unit + stiffness.astype(float) * beside) / (part * n)
        variance = np.full(mean.size, np.inf)
        if n > 1:
            variance = spread.astype(float) * (unit / part) ** 2 / n / (n - 1)
        return Moments(holds.astype(float) / n, mean, np.maximum(variance, 0.0))

    def _with_unseen(self, seen: Array, n: int) -> Array:
        """The variance, at least what one break more or less would make in n contacts, where one may happen."""
        contacts, limits, start = self.contacts, self._limits, self.contacts.start
        stretch = np.minimum(limits.span + limits.largest_birth, limits.largest_stretch)
        law, reforming, weight = (
            contacts.thresholds,
            contacts.reforming,
            np.full(seen.size, 1.0 / n),
        )
        constant = contacts.changing is None
        if constant and contacts.thermal is None:
            alike = start.is_single and not np.diff(law.support())[0]
            if alike and (reforming is None or reforming.law.is_single):
                return np.zeros(seen.size)  # all contacts do the same
            # an expected number of 1e-9 breaks counts as none
            survival = law.sf(abs(start.mean()) if start.is_single else 0.0)
            weight *= (n * (survival - law.sf(limits.largest_of_start)) > 1e-9 * survival) & (
                limits.span > 0.0
            )
        if constant:
            # one in a hundred ensembles has a contact with a larger threshold
            stretch = np.minimum(stretch, max(float(law.isf(0.01 / n)), limits.largest_birth))
        if contacts.stiffness == "linked":  # a contact's threshold is not below its stretch
            typical = np.maximum(stretch, float(np.sqrt(law.moment(2))))
            stretch = stretch * typical / contacts.mean_threshold
        rounding = self._work.drive.unit**2 / self._work.drive.square  # of squares of stretches
        # stretches or stiffnesses so narrow that their variance is lost in rounding may still have that much
        least = 0.0 if start.is_single and contacts.stiffness != "linked" else rounding
        return np.maximum(np.where(seen < rounding, least, seen), stretch**2 * weight)

    def _step_error(self, done: list[range], sums: Whole) -> Array:
        """Bound on the error of the force by the inner steps of ageing, at the points (a length); 0 without ageing.

        It assumes that the error is proportional to the step, while it grows faster.
        """
        if sums.shape[1] == 2:
            return np.zeros(self._drive.path.size)
        n = self.blocks.measured(done)
        some = sum(-(-self.blocks.size(block) // self.COARSER) for part in done for block in part)
        if not some or not n:
            return np.full(self._drive.path.size, np.inf)
        fine, coarse = self._moments(n, sums[:, 1]), self._moments(some, sums[:, 2])
        doubt = np.sqrt(fine.variance / n + coarse.variance / some)
        return (np.abs(coarse.force - fine.force) + doubt) / (self.COARSER - 1.0)


class StretchLimits:
    """How far contacts may be stretched on a drive, lengths.

    largest_birth : the largest stretch at which contacts form; largest_threshold : at any time; typical_threshold :
    about that of old contacts, or the mean stretch of the start if that is larger; largest_stretch : at any time;
    span : shape (n,), the range of slider positions up to each point of the path; largest_of_start : shape (n,), the
    largest stretch up to there of contacts of the start that have not broken.
    """

    def __init__(self, contacts: Contacts, drive: Drive) -> None:
        """Compute the limits from the supports of the laws and from the path."""
        from eq_model.draws.births import laws_of, tables_of

        path, ends = np.append(0.0, drive.path), contacts.start.span
        high, low = np.maximum.accumulate(path)[1:], np.minimum.accumulate(path)[1:]
        self.span = high - low
        self.largest_of_start = np.maximum(
            np.maximum(ends[1] + high, -ends[0] - low), max(np.abs(ends))
        )
        self.largest_threshold = tables_of(contacts)["thresholds"].largest
        born = max(abs(end) for law in laws_of(contacts).values() for end in law.span)
        self.largest_birth = min(born, self.largest_threshold)
        lasts = float(durations(drive).sum())
        if (changing := contacts.changing) is not None:
            self.largest_threshold = changing.largest_threshold(
                self.largest_threshold, DEEPEST, lasts
            )
        self.typical_threshold = max(contacts.oldest_threshold(lasts), abs(contacts.start.mean()))
        self.largest_stretch = min(
            self.largest_threshold, float(self.span[-1]) + self.largest_birth
        )


def breaks_by_heat(contacts: Contacts, lasts: float) -> float:
    """About how often a relaxed contact breaks by heat in a time; rather too few, as contacts hold longest relaxed."""
    assert contacts.thermal is not None
    fresh = contacts.thresholds.ppf((np.arange(256) + 0.5) / 256.0)
    with np.errstate(over="ignore"):
        holds = np.exp(-contacts.thermal.log_rate(0.0, fresh, contacts.relative_stiffness(fresh)))
    return float(lasts / (np.minimum(holds, lasts).mean() + contacts.waiting_time))


def seconds_of(contacts: Contacts, drive: Drive, law: Any) -> float:
    """Estimated seconds for one contact.

    Raises InputError where it breaks, pins again or takes steps of ageing more than 3e7 times.
    """
    from eq_model.laws.settings import kernel_of

    lasts, moved = durations(drive), np.abs(np.diff(drive.path, prepend=0.0))
    total, travel = float(lasts.sum()), float(moved.sum())
    thermal, reforming, changing = contacts.thermal, contacts.reforming, contacts.changing
    often, slower = dict[str, float](), 0.0
    if changing is not None:
        kernel = kernel_of(changing)
        often[changing.law] = kernel.often(contacts, lasts, moved, law)
        slower = (kernel.SECONDS - 1e-7) * often[changing.law]
    if reforming is not None and reforming.law.is_single:
        # half of the contacts break again within this distance
        stretch, thresholds = abs(reforming.law.mean()), contacts.thresholds
        distance = float(thresholds.isf(0.5 * thresholds.sf(stretch))) - stretch
        often["reforming"] = travel / max(distance, 1e-300)
    begins_at_0 = contacts.growing is not None and contacts.growing.begins_at_0
    if thermal is not None and not begins_at_0 and total > 0.0:
        often["thermal"] = breaks_by_heat(contacts, total)
    elif thermal is not None:
        often["thermal"] = thermal.rates.scale * total
    key = max(often, key=lambda each: often[each], default="")
    if key and often[key] > 3e7:  # which take some ten seconds without interruption
        name = "ages in steps," if key == "ageing" else "breaks"
        raise InputError(
            f"{key}: each contact {name} about {often[key]:.0e} times on the drive, which takes {total:.1g}; "
            "take a shorter or faster drive, other units of time, or the master equation"
        )
    # seconds of a cold break, and of one under other laws or of a step of ageing
    return 2e-8 * travel / contacts.mean_threshold + 1e-7 * sum(often.values()) + slower
