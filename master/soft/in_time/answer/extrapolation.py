"""Extrapolation to step 0 of the answers of three sliders, whose steps are halved from one to the next; and the error.

Errors of the answers fall about as the square of the step, faster with ageing, more slowly where thresholds grow
or births jump; all are extrapolated as if by the square. The error estimate is three times, with ageing once, the last
change of the extrapolated or of the plain answers, whichever is smaller, plus the error of the contacts' memory,
rounding, and what the steps do not resolve (unresolved.py), which no change shows. The error of the force, and of the
load K X_T at slips, is claimed; where it is above the tolerance the message tells the largest of its parts.

Where smooth sliding gets unstable its first slips are small, and finer steps may have one more or one less. Of all
three sliders as many of the largest slips are compared, and the largest drop of the others is added to the changes.

An example, which a test computes: at one time three made-up sliders have F = 0.76, 0.716 and 0.7042, in mean
thresholds, of which 0.7 would be right. Each slips once, the last one a second time, in which F drops by 0.02 only.

    plain answers       changed by -0.044, then by -0.0118
    extrapolated ones   0.716 - 0.044/3 = 0.70133, then 0.7042 - 0.0118/3 = 0.70027, which is answered: by -0.00107
    steps               the smaller of both last changes, 0.00107, three times: an error of 0.0032
    a slip left over    the last slider has it alone; it stays in the answer as it is, with an error of 3 * 0.02 = 0.06
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.soft.followed import GIVE_WIDTH, LEAVE_HEAT, LOOSEN, ErrorPart, Followed, total
from master.soft.in_time.answer.aligned import aligned_holding
from master.soft.in_time.answer.near_slip import undecided_end
from master.soft.in_time.answer.reading import read, read_holding
from master.soft.in_time.contacts import COMPARED
from master.soft.in_time.idle_heat import unresolved_heat
from master.soft.in_time.slider import Slider
from master.soft.in_time.steps import CONTROL
from master.soft.slips import slips_of
from origins import Contacts, Drive
from origins.thresholds.law import Array

# Errors fall by 4 with each halving as the square of the steps: 1/3 of the last change is left, and is added.
REST_OF_CHANGE = 1.0 / 3.0
# Instants at which the error is looked for beside the points of the path: few points would hardly tell it.
INSTANTS = 65
# Rounding of the force in one step, in mean thresholds.
ROUNDING = 1e-13
# What an error is of, in messages.
SHARE = "the share that holds"


class SlipArrays(NamedTuple):
    """K X_T, F before and F after each of the slips (n,), in mean thresholds."""

    load: Array
    before: Array
    after: Array


class SliderAnswer(NamedTuple):
    """What a slider answers: F in mean thresholds and the fraction that holds at times (n,), and all its slips."""

    force: Array
    holding: Array
    slips: SlipArrays


class Limit(NamedTuple):
    """An answer at step 0, the parts of the error of force and load at slips, and the error of the holding fraction, a
    share of the contacts."""

    answer: SliderAnswer
    parts: list[ErrorPart]
    of_holding: ErrorPart


class ComparedSlips(NamedTuple):
    """The slips of three sliders that are compared: of each the largest, as many (m) as all of them have, in order.

    times : when they begin, shape (3, m): slider, slip
    lengths : the rows of SlipArrays, shape (3, 3, m): slider, row, slip
    of_last : indices of these among all slips of the last slider, shape (m,)
    remaining : the largest drop of F in slips that are not compared, in mean thresholds
    """

    times: Array
    lengths: Array
    of_last: npt.NDArray[np.intp]
    remaining: float

    def beside(self, times: Array) -> npt.NDArray[np.bool_]:
        """Which of the times (n,) lie between a slip's times in one slider and in the next, or nearly so."""
        return np.asarray(np.any([_beside(times, *pair) for pair in pairwise(self.times)], axis=0))

    def as_far_from_slip(self, times: Array) -> tuple[Array, Array]:
        """Where to read the last slider for an answer at step 0 at these times (n,): as long before or after its own
        slip as each of them is from the same slip at step 0, the nearest one; and what to add to the force that is read
        there (n,), as those before and after that slip are extrapolated, too. There must be a slip."""
        _, middle, fine = self.times
        later = REST_OF_CHANGE * (fine - middle)
        nearest = np.abs(times[:, None] - fine - later).argmin(axis=1)
        _, before, after = REST_OF_CHANGE * (self.lengths[2] - self.lengths[1])
        added = np.where(times < (fine + later)[nearest], before[nearest], after[nearest])
        return np.asarray(times - later[nearest]), np.asarray(added)


def extrapolated(
    sliders: list[Slider], contacts: Contacts, drive: Drive, balance: float, asked: Array
) -> Followed:
    """The answer at times (n,) of three sliders; of fewer, with an infinite error."""
    unit, spring, last = contacts.mean_threshold, float(drive.spring or 0.0), sliders[-1]
    times = np.append(asked, np.linspace(0.0, asked.max(initial=0.0), INSTANTS))
    if len(sliders) == COMPARED:
        limit = _limit(sliders, times)
    else:
        unknown = ErrorPart("steps, of which fewer than three halvings were solved", np.inf)
        limit = Limit(_answer(last, times), [unknown], unknown)
    cohorts, slips = last.contacts, limit.answer.slips
    # round-off of the force grows with the number of steps, and where the slider slips with K, as K X_T does
    stiff = spring if slips.load.size else min(spring, 1.0)
    rounding = ROUNDING * (1.0 + cohorts.steps) * (1.0 + stiff)
    duration = 0.0 if last.motion is None else float(last.motion.times[-1])
    cold_skin = unresolved_heat(contacts, cohorts.memory, drive, duration)
    parts = (
        *limit.parts,
        ErrorPart("the memory of the contacts' history", cohorts.memory.error, LOOSEN),
        ErrorPart(f"rounding in {cohorts.steps} steps", rounding, LOOSEN),
        ErrorPart("heat in a skin thinner than the cells of thresholds", cold_skin, LEAVE_HEAT),
        _at_exact_thresholds(last, contacts, slips.load.size, duration),
        _unresolved(last),
    )
    error = total(parts)
    drive_and_forces = np.array(
        [slips.load * unit / spring, slips.before * unit, slips.after * unit]
    )
    return Followed(
        balance=balance,
        force=limit.answer.force[: asked.size] * unit,
        holding=limit.answer.holding[: asked.size],
        slips=slips_of(drive_and_forces, spring, error * unit / spring),
        error_of_force_and_load=error,
        of_holding=limit.of_holding,
        nodes=cohorts.steps,
        parts=parts,
    )


def _at_exact_thresholds(slider: Slider, contacts: Contacts, slips: int, time: float) -> ErrorPart:
    """Half a step, for slips of contacts that heat breaks at exact thresholds, most of them within one step. Halved
    steps end at the same places, so that sliders agree on a slip by chance (to 1e-6, where it was off by 8e-3)."""
    thermal, at_exact = contacts.thermal, float(contacts.thresholds.atoms[1].sum())
    broken_by_heat = 0.0  # at most
    if thermal and slips:
        broken_by_heat = min(thermal.rates.scale * time, at_exact)
    step = CONTROL.coarsest * slider.contacts.memory.scales.length * 0.5**slider.contacts.halvings
    of_slips = "slips where heat breaks contacts at exact thresholds, most within one step"
    return ErrorPart(of_slips, 0.5 * broken_by_heat * step / slider.contacts.unit, GIVE_WIDTH)


def _unresolved(slider: Slider) -> ErrorPart:
    """The largest error that finer steps may not show; of the kinds it is not the sum, as they tell of the same F."""
    largest = slider.contacts.unresolved.largest
    if not largest:
        return ErrorPart("what steps do not resolve", 0.0)
    of = max(largest, key=lambda kind: largest[kind].error)
    near = _near(slider, largest[of].time)
    return ErrorPart(f"{of}, {near}", largest[of].error / slider.contacts.unit)


def _near(slider: Slider, time: float) -> str:
    """Where a time on the drive's path is, in words."""
    if slider.motion is None:
        return "where the drive begins"
    return f"near t = {time:.6g}, X_T = {float(slider.motion.at(np.array(time))):.6g}"


def _answer(slider: Slider, times: Array) -> SliderAnswer:
    """What one slider answers at times (n,)."""
    unit = slider.contacts.unit
    force, holding = read(slider.sections, times)
    if slider.contacts.delay:
        holding = read_holding(slider.sections, times, slider.contacts.delay)
    lengths = [(slip.load, slip.force_before, slip.force_after) for slip in slider.slips]
    return SliderAnswer(force / unit, holding, SlipArrays(*np.reshape(lengths, (-1, 3)).T / unit))


def _limit(sliders: list[Slider], times: Array) -> Limit:
    """The answer of three sliders at step 0, with its error; its slips are those of the last one."""
    last, answers = sliders[-1], [_answer(one, times) for one in sliders]
    slips = _compared(sliders, answers)
    answer, beside = _at_step_0(answers, slips), slips.beside(times)
    if beside.any():
        read_at, added = slips.as_far_from_slip(times[beside])
        from_slip = _answer(last, read_at)
        answer.force[beside], answer.holding[beside] = from_slip.force + added, from_slip.holding
    # beside a slip F changes by its drop, which is no error; K X_T at slips says how far F is off
    far = ~beside
    parts = [_of_force(last, answers, slips, far, times), _of_slips_unmatched(last, slips)]
    undecided = _of_undecided_end(sliders, answer)
    if undecided is not None and undecided.size > total(parts):
        parts = [undecided]
    changes = _changes(np.array([one.holding[far] for one in answers]))
    of_holding = _of_steps(last, changes, times[far], SHARE)
    aligned = aligned_holding(sliders, slips.times, times)
    if aligned is not None:
        off = _of_steps(last, aligned.changes[:, far], times[far], SHARE)
        if off.size < of_holding.size:
            of_holding = off
            answer.holding[far] = aligned.holding[far]
    return Limit(answer, parts, of_holding._replace(size=min(of_holding.size, 1.0)))


def _at_step_0(answers: list[SliderAnswer], slips: ComparedSlips) -> SliderAnswer:
    """Three answers extrapolated to step 0, slips that are compared with them; slips left over stay as they are."""
    _, middle, fine = answers
    force = fine.force + REST_OF_CHANGE * (fine.force - middle.force)
    holding = fine.holding + REST_OF_CHANGE * (fine.holding - middle.holding)
    _, of_middle, of_fine = slips.lengths
    lengths = np.array(fine.slips)
    lengths[:, slips.of_last] += REST_OF_CHANGE * (of_fine - of_middle)
    return SliderAnswer(force, holding, SlipArrays(*lengths))


def _of_force(
    last: Slider,
    answers: list[SliderAnswer],
    slips: ComparedSlips,
    far: npt.NDArray[np.bool_],
    times: Array,
) -> ErrorPart:
    """The error by the size of steps of F at those of the times (n,) that are far from slips, and of the lengths of
    slips."""
    of_force = _changes(np.array([one.force[far] for one in answers]))
    of_slips = _changes(slips.lengths.reshape(COMPARED, -1))
    slips_at = np.tile(slips.times[-1], slips.lengths.shape[1])
    changes = np.append(of_force, of_slips, axis=1)
    return _of_steps(last, changes, np.append(times[far], slips_at), "F and loads at slips")


def _of_slips_unmatched(last: Slider, slips: ComparedSlips) -> ErrorPart:
    """The error by slips that finer steps have and coarser ones have not, or the other way round."""
    size = last.contacts.memory.safety * slips.remaining
    return ErrorPart("slips that not all halvings have", size)


def _of_undecided_end(sliders: list[Slider], answer: SliderAnswer) -> ErrorPart | None:
    """The error where a slip may come before the drive turns, slows down or ends, or not: all that is known of F is
    that it lies between 0 and the largest. None where that is decided."""
    end = undecided_end(sliders)
    if end is None:
        return None
    before = "the drive turns, slows down or ends"
    of = f"a slip that may come just before {before}, {_near(sliders[-1], end)}"
    largest_force = float(np.abs(answer.force).max())
    return ErrorPart(of, largest_force, "turn or end the path a little elsewhere")


def _of_steps(slider: Slider, changes: Array, times: Array, what: str) -> ErrorPart:
    """The error by the size of steps: the memory's safety times the smaller of the largest changes, of plain and of
    extrapolated answers. `changes`, of shape (2, n), are those at the times (n,), of `what`, in words."""
    changes = slider.contacts.memory.safety * changes
    largest = changes.max(axis=1, initial=0.0)
    smaller = int(largest.argmin())
    near = _near(slider, times[changes[smaller].argmax()]) if times.size else "at no time"
    of = f"steps, by which {what} changed as they were halved, {near}"
    return ErrorPart(of, float(largest[smaller]))


def _compared(sliders: list[Slider], answers: list[SliderAnswer]) -> ComparedSlips:
    """Which slips of each slider are compared."""
    drops = [np.abs(one.slips.before - one.slips.after) for one in answers]
    fewest = min(drop.size for drop in drops)
    by_size = [np.argsort(-drop, kind="stable") for drop in drops]
    which = [np.sort(order[:fewest]) for order in by_size]
    remaining = [
        drop[order[fewest:]].max(initial=0.0) for drop, order in zip(drops, by_size, strict=True)
    ]
    times = [np.array([slip.time for slip in one.slips]) for one in sliders]
    return ComparedSlips(
        times=np.array([of[some] for of, some in zip(times, which, strict=True)]),
        lengths=np.array(
            [np.array(one.slips)[:, some] for one, some in zip(answers, which, strict=True)]
        ),
        of_last=which[-1],
        remaining=float(max(remaining)),
    )


def _changes(three: Array) -> Array:
    """Sizes of the last change of three plain answers, and of the extrapolated ones, shape (2, n)."""
    coarse, middle, fine = three
    before, last = middle - coarse, fine - middle
    return np.abs([last, last + REST_OF_CHANGE * (last - before)])


def _beside(times: Array, before: Array, now: Array) -> npt.NDArray[np.bool_]:
    """Times that the change of a slip's time moves across it, or nearly so."""
    apart, crossed = times[:, None] - now, (times[:, None] < now) != (times[:, None] < before)
    return np.asarray(((np.abs(apart) <= np.abs(now - before)) | crossed).any(axis=1))
