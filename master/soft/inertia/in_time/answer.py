"""What sliders with mass answer on steps halved each time: the limit of steps 0, and its error.

As of sliders without mass (master.soft.in_time.answer.extrapolation) errors fall as the square of the steps, so that a
third of the last change is left, and is added. The error is the last change of the plain or of the extrapolated
answers, whichever is larger, or where the last two agree by chance what the change before leaves: times SAFETY, and
with what no change shows. The smaller of both changes was less than the error for slips of nearly equal contacts on
long steps. X moves on smoothly: no slip has to be left out.
"""

from typing import NamedTuple

import numpy as np

from master.soft.followed import ELSEWHERE, LEAVE_HEAT, LOOSEN, ErrorPart, total
from master.soft.in_time.idle_heat import unresolved_heat
from master.soft.inertia.in_time.clocks import COLUMNS, FORCE, HOLDING, PLACE, Clocks
from master.soft.inertia.in_time.slider import HeavySlider
from origins import Contacts, Drive
from origins.thresholds.law import Array

# See master.soft.in_time.answer.extrapolation.
REST_OF_CHANGE = 1.0 / 3.0
INSTANTS = 65
# Factor on the last change in the error, as without mass; of contacts that age, too, whose slips with mass were held
# against shorter steps alone.
SAFETY = 3.0
# Changes fall by 4 from one halving to the next; where by more than this, the last two answers agree by chance.
FALL, MOST_FALL = 4.0, 8.0
ROUNDING = 1e-13
# Part of the force that ends a slip up to which its error may be, so that the slip's end is known.
OF_END = 0.1
# Times the time from rest to a flight in the error of a slip's duration: of 50 random machines one was 0.7 of it off.
OF_START = 2.0
# Halved steps of as many sliders tell an error.
COMPARED = 3


class SlipRows(NamedTuple):
    """Slips, arrays of shape (n,): as they begin X_T, X and the spring's force, and X and that force after them
    (lengths); when they begin, their duration, and the largest speed."""

    drive: Array
    before: Array
    after: Array
    force_before: Array
    force_after: Array
    time: Array
    duration: Array
    top_speed: Array


class Beside(NamedTuple):
    """What errors may be larger at some asked times, as the slips' own times are not known so well: that of the force
    of spring and contacts (mean thresholds), and of the share that holds."""

    force: ErrorPart
    contact_force: float
    holding: float


class HeavyAnswer(NamedTuple):
    """The limit of some sliders at times (n,), and its errors.

    columns : by the names of HeavyNode, arrays of shape (n,); lengths, and energies per N_c<k>
    changes : of columns, see `_changes`, shape (3, columns, n); inf where too few sliders tell them
    slips : of the last slider, in the limit where all have as many
    parts : of the error of the spring's force (mean thresholds); of_contacts : error of the contacts' force (the same)
    of_holding : error of the share that holds; duration_error : of the slips' durations; of_slip_forces : of those
        before and after slips (mean thresholds)
    beside : what the errors of both forces and of holding may be larger where slips are near
    """

    columns: dict[str, Array]
    changes: Array
    slips: SlipRows
    parts: tuple[ErrorPart, ...]
    of_contacts: float
    of_holding: ErrorPart
    duration_error: float
    of_slip_forces: float
    beside: Beside

    @property
    def error_of_force_and_load(self) -> float:
        """That of the spring's force, but at points near slips, and of K X_T at slips, in mean thresholds."""
        return total(self.parts)


def answer(
    sliders: list[HeavySlider], contacts: Contacts, drive: Drive, asked: Array
) -> HeavyAnswer:
    """The answer at times (n,) of the last three sliders; of fewer the last one's own, with an infinite error."""
    last, unit = sliders[-1], contacts.mean_threshold
    times = np.append(asked, np.linspace(0.0, asked.max(initial=0.0), INSTANTS))
    rows, clocks = _rows_of_ended(sliders), Clocks(sliders, times)
    same = len(sliders) == COMPARED and len({one.drive.size for one in rows}) == 1
    begun = {len(one.falls.begins) for one in sliders}
    if same and len(begun) == 1 and all(one.passes_slips for one in sliders):
        begins = np.array([one.falls.begins for one in sliders])
        clocks.set_by_slips(begins, _at_step_0(begins))
    read_from = np.array([clocks.read(k) for k in range(len(sliders))])
    limit, slips = read_from[-1], rows[-1]
    unknown = ErrorPart("steps, of which fewer than three halvings were solved", np.inf)
    parts, of_contacts, of_holding = [unknown], np.inf, unknown
    duration_error = of_slip_forces = np.inf
    of_columns = np.full((3, len(COLUMNS), asked.size), np.inf)
    at_end = ErrorPart("a slip that may come before the path ends", 0.0, ELSEWHERE)
    unseen, beside = _unseen(last, contacts, drive), Beside(at_end, 0.0, 0.0)
    if len(sliders) == COMPARED:
        limit, changes = _at_step_0(read_from), _changes(read_from)
        of_columns = changes[:, :, : asked.size]
        safety = max(last.contacts.memory.safety, SAFETY)
        of_spring = last.spring * changes[:, PLACE] / unit
        of_slips = np.zeros((3, 0))
        if same:
            lengths = np.array([np.array(one[:5]) for one in rows])
            lengths[:, :3] *= last.spring
            of_slips = _changes(lengths).reshape(3, -1) / unit
            forces = np.array([[one.force_before, one.force_after] for one in rows])
            of_forces = _changes(forces).reshape(3, -1) / unit
            of_slip_forces = error_by(of_forces, safety) + total(unseen)
            slips = SlipRows(*_at_step_0(np.array([np.array(one) for one in rows])))
            of_durations = _changes(np.array([one.duration for one in rows]))[1:].max(initial=0.0)
            duration_error = safety * float(of_durations)
        # X before and after a slip follows from X_T and the force
        at_slips = (error_by(of_slips, safety) + total(unseen)) * unit / last.spring
        # one that goes on to the end is near up to there
        far = clocks.far(at_slips, np.append(slips.duration, np.inf))
        all_changes = np.append(of_spring[:, far], of_slips, axis=1)
        near = _near(last, of_spring[:, far], times[far])
        what = f"steps, by which the spring's force changed as they were halved{near}"
        parts = [ErrorPart(what, error_by(all_changes, safety))]
        if not same:
            drops = np.concatenate([one.force_before - one.force_after for one in rows])
            of = "slips that not all halvings have"
            parts.append(ErrorPart(of, float(np.abs(drops).max()) / unit))
        of_contacts = error_by(changes[:, FORCE, far] / unit, safety)
        most = error_by(changes[:, HOLDING, far], safety)
        if last.may_pass_slips:
            ahead = clocks.holding_ahead(total(unseen) * unit / last.spring)
            most += float(ahead[far].max(initial=0.0))
        most = min(most, 1.0)
        of_holding = ErrorPart("steps, by which the share that holds changed", most)
        if last.passes_slips:
            # beside a slip it is extrapolated across what comes back at once, and told with an error as large
            limit[HOLDING] = np.clip(limit[HOLDING], 0.0, 1.0)
            more = max((bound.holding for bound in last.flown), default=0.0)
            of_holding = of_holding._replace(size=min(most + more, 1.0))
            errors = total((*parts, *unseen)), total(unseen), of_contacts, of_holding.size
            beside = _beside(clocks, of_columns, np.array(errors), safety)
        in_time = total((*parts, *unseen)) * unit / last.spring
        if last.may_pass_slips and (len(begun) > 1 or clocks.may_slip(in_time)):
            # as large as any, and none may hold
            most = float(np.abs(clocks.pull(asked, limit[PLACE, : asked.size])).max(initial=0.0))
            beside = Beside(at_end._replace(size=most / unit), most / unit, 1.0)
    parts = [*parts, *unseen]
    duration_error += _of_durations(slips, total(parts) * unit, last, drive)
    if any(slip.fades for slip in last.falls.slips):
        duration_error = np.inf
    columns = {of: limit[k, : asked.size] for k, of in enumerate(COLUMNS)}
    more_of_contacts = max((slid.of_contacts for slid in last.slides), default=0.0) / unit
    of_contacts += total(unseen) + more_of_contacts
    return HeavyAnswer(
        columns,
        of_columns,
        slips,
        tuple(parts),
        of_contacts,
        of_holding,
        duration_error,
        of_slip_forces,
        beside,
    )


def _beside(clocks: Clocks, changes: Array, errors: Array, safety: float) -> Beside:
    """What errors may be larger at asked times, which come first, with these changes of their columns. `errors`: of the
    spring's force, what is in it that no change of steps shows, of the contacts' force, and of holding."""
    last, count = clocks.last, changes.shape[-1]
    unit = last.contacts.unit
    spread = clocks.spread(count, errors[0] * unit / last.spring)
    by_step = safety * np.stack([changes[:, of] for of in (PLACE, FORCE, HOLDING)])[:, 1:].max(
        axis=1
    )
    off = spread + by_step * np.array([last.spring, 1.0, 1.0])[:, None]
    off[:2] = off[:2] / unit
    most = off.max(axis=1, initial=0.0) + np.array([errors[1], 0.0, 0.0])
    more = np.maximum(most - errors[[0, 2, 3]], 0.0).tolist()
    where = clocks.near(off[0]) if more[0] else ""
    of_force = ErrorPart(f"slips, whose times are not known so well{where}", more[0], ELSEWHERE)
    return Beside(of_force, more[1], min(more[2], 1.0))


def _of_durations(slips: SlipRows, error: float, slider: HeavySlider, drive: Drive) -> float:
    """The error of durations by that of the force (a length): as much of each as it is of its fall, as they may agree
    by chance. A slip in a flight ends where the spring's force, less that of the damping, has turned the slider to
    the drive's speed: where that force is hardly known, as of one that does not swing, the end is not, either."""
    drops = np.abs(slips.force_before - slips.force_after)
    part = error * slips.duration / drops
    if slider.flown and slider.motion is not None and drops.size:
        turning = slips.force_after - drive.damping * float(slider.motion.speeds[0])
        known = error < OF_END * np.abs(turning)
        radians = error / np.where(known, np.abs(turning), 1.0)
        per_radian = (float(drive.mass or 0.0) / slider.spring) ** 0.5
        part = np.where(known, np.maximum(part, radians * per_radian), np.inf)
    if slider.passes_slips:
        # rest, which leaves inertia out, tells roughly when the slider gets faster than its drive
        part += OF_START * slider.longest_start
    return float(part.max(initial=0.0))


def _rows_of_ended(sliders: list[HeavySlider]) -> list[SlipRows]:
    """The slips of each; where all have begun as many, without a last one that ended before the path on some alone."""
    rows = [_rows(one) for one in sliders]
    if len({len(one.falls.begins) for one in sliders}) > 1:
        return rows
    ended = min(one.drive.size for one in rows)
    return [SlipRows(*(of[:ended] for of in one)) for one in rows]


def _rows(slider: HeavySlider) -> SlipRows:
    """The slips of a slider."""
    found = slider.falls.slips
    begin, end = (np.reshape([slip[at] for slip in found], (-1, 5)).T for at in (0, 1))
    top = np.array([slip.top_speed for slip in found])
    return SlipRows(begin[1], begin[2], end[2], begin[3], end[3], begin[0], end[0] - begin[0], top)


def _unseen(slider: HeavySlider, contacts: Contacts, drive: Drive) -> tuple[ErrorPart, ...]:
    """Parts of the error that no change of steps shows."""
    memory, steps, unit = slider.contacts.memory, slider.contacts.steps, slider.contacts.unit
    duration = 0.0 if slider.motion is None else float(slider.motion.times[-1])
    cold_skin = unresolved_heat(contacts, memory, drive, duration)
    largest = slider.contacts.unresolved.largest
    of, error = "what steps do not resolve", 0.0
    if largest:
        of = max(largest, key=lambda kind: largest[kind].error)
        error = largest[of].error / unit
        if slider.passes_slips:  # in slips, and while the slider hardly swings before, they add up
            error = sum(one.error for one in largest.values()) / unit
        of = f"{of}, near t = {largest[of].time:.6g}"
    return (
        ErrorPart("the memory of the contacts' history", memory.error, LOOSEN),
        ErrorPart(f"rounding in {steps} steps", ROUNDING * (1.0 + steps), LOOSEN),
        ErrorPart("heat in a skin thinner than the cells of thresholds", cold_skin, LEAVE_HEAT),
        ErrorPart(of, error),
    )


def _near(slider: HeavySlider, changes: Array, times: Array) -> str:
    """Where the spring's force changes most, in words."""
    if slider.motion is None or not times.size:
        return ""
    at = float(times[changes[1:].max(axis=0).argmax()])
    return f", near t = {at:.6g}, X_T = {float(slider.motion.at(np.array(at))):.6g}"


def _at_step_0(three: Array) -> Array:
    """Three answers, along the first axis, extrapolated to step 0."""
    return np.asarray(three[2] + REST_OF_CHANGE * (three[2] - three[1]))


def _changes(three: Array) -> Array:
    """Sizes of the changes of three plain answers, the last one behind, and of the extrapolated ones, along the first
    axis."""
    before, last = three[1] - three[0], three[2] - three[1]
    return np.abs([before, last, last + REST_OF_CHANGE * (last - before)])


def error_by(changes: Array, safety: float) -> float:
    """An error by changes of shape (3, n), see `_changes`, by the largest of each kind, times the safety."""
    before, last, extrapolated = changes.max(axis=1, initial=0.0).tolist()
    by_chance = before / FALL if last < before / MOST_FALL else 0.0
    return float(safety * max(last, extrapolated, by_chance))


def spacing_error(sliders: list[HeavySlider], contacts: Contacts, drive: Drive) -> float:
    """The error (a length) of the distance of X_T from one slip to the next, by its own changes as steps are halved:
    errors of X_T add up from slip to slip, and most of them are those of both slips alike. What no change shows, such
    as inertia that rest leaves out, makes all slips late, or all early, and counts once; on a drive that turns back,
    twice, as late is further on one leg and less far on the next."""
    last = sliders[-1]
    places = [one.drive for one in _rows_of_ended(sliders)]
    if len(sliders) < COMPARED or len({one.size for one in places}) > 1:
        return np.inf
    safety = max(last.contacts.memory.safety, SAFETY)
    unseen = total(_unseen(last, contacts, drive)) * contacts.mean_threshold / last.spring
    goes_one_way = np.unique(np.sign(np.diff(drive.path))).size <= 1
    return error_by(_changes(np.diff(places, axis=1)), safety) + unseen * (1 if goes_one_way else 2)
