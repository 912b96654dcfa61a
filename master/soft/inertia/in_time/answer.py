"""What sliders with mass answer on steps halved each time: the limit of steps 0, and its error.

As of sliders without mass (master.soft.in_time.answer.extrapolation) errors fall as the square of the steps, so that a
third of the last change is left, and is added. The error is the last change of the plain or of the extrapolated
answers, whichever is larger, or where the last two agree by chance what the change before leaves: times SAFETY, and
with what no change shows. The smaller of both changes was less than the error for slips of nearly equal contacts on
long steps. X moves on smoothly: no slip has to be left out.
"""

from typing import NamedTuple

import numpy as np

from master.soft.followed import LEAVE_HEAT, LOOSEN, ErrorPart, total
from master.soft.in_time.answer.reading import read
from master.soft.in_time.idle_heat import unresolved_heat
from master.soft.inertia.in_time.slider import HeavyNode, HeavySlider
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
# Columns of a node that are read: all behind its size and its time.
COLUMNS = HeavyNode._fields[2:]
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


class HeavyAnswer(NamedTuple):
    """The limit of some sliders at times (n,), and its errors.

    columns : by the names of HeavyNode, arrays of shape (n,); lengths, and energies per N_c<k>
    slips : of the last slider, in the limit where all have as many
    parts : of the error of the spring's force (mean thresholds); of_contacts : error of the contacts' force (the same)
    of_holding : error of the share that holds; duration_error : of the slips' durations
    """

    columns: dict[str, Array]
    slips: SlipRows
    parts: tuple[ErrorPart, ...]
    of_contacts: float
    of_holding: ErrorPart
    duration_error: float

    @property
    def error(self) -> float:
        """That of the spring's force, in mean thresholds."""
        return total(self.parts)


def answer(
    sliders: list[HeavySlider], contacts: Contacts, drive: Drive, asked: Array
) -> HeavyAnswer:
    """The answer at times (n,) of the last three sliders; of fewer the last one's own, with an infinite error."""
    last, unit = sliders[-1], contacts.mean_threshold
    times = np.append(asked, np.linspace(0.0, asked.max(initial=0.0), INSTANTS))
    read_from = [read(one.sections, times, len(COLUMNS)) for one in sliders]
    rows = [_rows(one) for one in sliders]
    limit, slips = read_from[-1], rows[-1]
    unknown = ErrorPart("steps, of which fewer than three halvings were solved", np.inf)
    parts, of_contacts, of_holding, duration_error = [unknown], np.inf, unknown, np.inf
    if len(sliders) == COMPARED:
        limit = _at_step_0(np.array(read_from))
        same = len({one.drive.size for one in rows}) == 1
        changes = _changes(np.array(read_from))
        safety = max(last.contacts.memory.safety, SAFETY)
        force, place, holding = (COLUMNS.index(of) for of in ("force", "position", "holding"))
        of_spring = last.spring * changes[:, place] / unit
        of_slips = np.zeros((3, 0))
        if same:
            lengths = np.array([np.array(one[:5]) for one in rows])
            lengths[:, :3] *= last.spring
            of_slips = _changes(lengths).reshape(3, -1) / unit
            slips = SlipRows(*_at_step_0(np.array([np.array(one) for one in rows])))
            of_durations = _changes(np.array([one.duration for one in rows]))[1:].max(initial=0.0)
            duration_error = safety * float(of_durations)
        # X before and after a slip follows from X_T and the force
        all_changes = np.append(of_spring, of_slips, axis=1)
        what = f"steps, by which the spring's force changed as they were halved{_near(last, of_spring, times)}"
        parts = [ErrorPart(what, error_by(all_changes, safety))]
        if not same:
            drops = np.concatenate([one.force_before - one.force_after for one in rows])
            of = "slips that not all halvings have"
            parts.append(ErrorPart(of, float(np.abs(drops).max()) / unit))
        of_contacts = error_by(changes[:, force] / unit, safety)
        most = min(error_by(changes[:, holding], safety), 1.0)
        of_holding = ErrorPart("steps, by which the share that holds changed", most)
    unseen = _unseen(last, contacts, drive)
    errors = (*parts, *unseen)
    # the durations of one slip may agree by chance: as much of each as the error of the force is of its fall
    drops = np.abs(slips.force_before - slips.force_after)
    part = total(errors) * unit * slips.duration / drops
    duration_error += float(part.max(initial=0.0))
    columns = {of: limit[k, : asked.size] for k, of in enumerate(COLUMNS)}
    more = total(unseen)
    return HeavyAnswer(columns, slips, errors, of_contacts + more, of_holding, duration_error)


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
