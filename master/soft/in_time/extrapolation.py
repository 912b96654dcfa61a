"""Extrapolation to step 0 of the answers of three sliders, whose steps are halved from one to the next; and the error.

Errors of the answers fall about as the square of the step, faster with ageing, more slowly where thresholds grow
or births jump; all are extrapolated as if by the square. The error estimate is three times, with ageing once, the last
change of the extrapolated or of the plain answers, whichever is smaller, plus the error of the contacts' memory,
rounding, and what the steps do not resolve (unresolved.py), which no change shows. The error of the force, and of the
load K X_T at slips, is claimed; where it is above the tolerance the message tells the largest of its parts.

Where smooth sliding gets unstable its first slips are small, and finer steps may have one more or one less. Of all
three sliders as many of the largest slips are compared, and the largest drop of the others is added to the changes.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline
from scipy.optimize.elementwise import find_root

from master.soft.followed import LEAVE_HEAT, LOOSEN, ErrorPart, Followed, total
from master.soft.in_time.contacts import COMPARED
from master.soft.in_time.idle_heat import unresolved_heat
from master.soft.in_time.near_slip import undecided_end
from master.soft.in_time.slider import Node, Slider, Slip
from master.soft.slips import slips_of
from origins import Contacts, Drive
from origins.thresholds.law import Array

# Errors fall by 4 with each halving as the square of the steps: 1/3 of the last change is left, and is added.
REST_OF_CHANGE = 1.0 / 3.0
# Instants at which the error is looked for beside the points of the path: few points would hardly tell it.
INSTANTS = 65
# Rounding of the force in one step, in mean thresholds.
ROUNDING = 1e-13
# Highest degree of the splines between the ends of steps; they are best at odd ones.
DEGREE = 5


class Answer(NamedTuple):
    """What a slider answers; lengths in mean thresholds.

    force, holding : at times (n,)
    slips : K X_T, F before and F after each slip, shape (3, slips)
    """

    force: Array
    holding: Array
    slips: Array


class Limit(NamedTuple):
    """An answer at step 0, the parts of the error of force and load at slips, and the error of the holding fraction, a
    share of the contacts."""

    answer: Answer
    parts: list[ErrorPart]
    of_holding: ErrorPart


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
    stiff = spring if slips.size else min(spring, 1.0)
    rounding = ROUNDING * (1.0 + cohorts.steps) * (1.0 + stiff)
    duration = 0.0 if last.motion is None else float(last.motion.times[-1])
    cold_skin = unresolved_heat(contacts, cohorts.memory, drive, duration)
    parts = (
        *limit.parts,
        ErrorPart("the memory of the contacts' history", cohorts.memory.error, LOOSEN),
        ErrorPart(f"rounding in {cohorts.steps} steps", rounding, LOOSEN),
        ErrorPart("heat in a skin thinner than the cells of thresholds", cold_skin, LEAVE_HEAT),
        _unresolved(last),
    )
    error = total(parts)
    return Followed(
        balance=balance,
        force=limit.answer.force[: asked.size] * unit,
        holding=limit.answer.holding[: asked.size],
        slips=slips_of(slips * unit / [[spring], [1.0], [1.0]], spring, error * unit / spring),
        error=error,
        of_holding=limit.of_holding,
        nodes=cohorts.steps,
        parts=parts,
    )


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


def _answer(slider: Slider, times: Array) -> Answer:
    """What one slider answers at times (n,)."""
    unit = slider.contacts.unit
    force, holding = read(slider.sections, times)
    slips = np.reshape([slip[1:] for slip in slider.slips], (-1, 3)).T
    return Answer(force / unit, holding, slips / unit)


def _limit(sliders: list[Slider], times: Array) -> Limit:
    """The answer at step 0 of three sliders; its slips are those of the last one."""
    answers = [_answer(one, times) for one in sliders]
    force = np.array([one.force for one in answers])
    holding = np.array([one.holding for one in answers])
    compared = _compared([one.slips for one in answers])
    slips = np.array(
        [one.slips[:, some] for one, some in zip(answers, compared.which, strict=True)]
    )
    instants = [
        np.array([slip.time for slip in one.slips])[some]
        for one, some in zip(sliders, compared.which, strict=True)
    ]
    # at times between two sliders' slips F changes by its drop, which is no error; K X_T says how far F is off
    beside = np.any([_beside(times, *pair) for pair in pairwise(instants)], axis=0)
    of_slips = _changes(slips.reshape(COMPARED, -1))
    of_force = np.append(_changes(force[:, ~beside]), of_slips, axis=1)
    of_holding = _changes(holding[:, ~beside])
    safety = sliders[-1].contacts.memory.safety
    told_at = times[~beside]
    with_slips = np.append(told_at, np.tile(instants[2], len(Slip._fields) - 1))
    parts = [
        _of_steps(sliders[-1], safety * of_force, with_slips, "F and loads at slips"),
        ErrorPart("slips that not all halvings have", safety * compared.left_over),
    ]
    limit = Answer(
        force[2] + REST_OF_CHANGE * (force[2] - force[1]),
        holding[2] + REST_OF_CHANGE * (holding[2] - holding[1]),
        answers[2].slips.copy(),
    )
    limit.slips[:, compared.which[2]] += REST_OF_CHANGE * (slips[2] - slips[1])
    if beside.any():  # read F as long before or after the slip as it is from the extrapolated slip
        later = REST_OF_CHANGE * (instants[2] - instants[1])
        nearest = np.abs(times[beside, None] - instants[2] - later).argmin(axis=1)
        there = _answer(sliders[2], times[beside] - later[nearest])
        limit.force[beside], limit.holding[beside] = there.force, there.holding
    if (end := undecided_end(sliders)) is not None:
        largest_force = float(np.abs(limit.force).max())
        if largest_force > total(parts):  # known is that much: F is between 0 and the largest
            of = f"a slip that may come just before the drive turns or ends, {_near(sliders[-1], end)}"
            parts = [ErrorPart(of, largest_force, "turn or end the path a little elsewhere")]
    of_shares = _of_steps(sliders[-1], safety * of_holding, told_at, "the share that holds")
    return Limit(limit, parts, of_shares)


def _of_steps(slider: Slider, changes: Array, times: Array, what: str) -> ErrorPart:
    """The error by the size of steps: the smaller of the largest changes, of plain and of extrapolated answers. Those
    have the shape (2, n), with what changes by them at these times (n,)."""
    largest = changes.max(axis=1, initial=0.0)
    smaller = int(largest.argmin())
    near = _near(slider, times[changes[smaller].argmax()]) if times.size else "at no time"
    of = f"steps, by which {what} changed as they were halved, {near}"
    return ErrorPart(of, float(largest[smaller]))


class ComparedSlips(NamedTuple):
    """The slips of some sliders that are compared.

    which : indices of the largest slips of each slider, in order, as many as all of them have
    left_over : the largest drop of F in the others, in mean thresholds
    """

    which: list[npt.NDArray[np.intp]]
    left_over: float


def _compared(slips: list[Array]) -> ComparedSlips:
    """Which slips of each slider are compared, from K X_T, F before and F after, shape (3, slips)."""
    drops = [np.abs(before - after) for _, before, after in slips]
    fewest = min(drop.size for drop in drops)
    which, left_over = [], 0.0
    for drop in drops:
        by_size = np.argsort(-drop, kind="stable")
        which.append(np.sort(by_size[:fewest]))
        left_over = max(left_over, float(drop[by_size[fewest:]].max(initial=0.0)))
    return ComparedSlips(which, left_over)


def _changes(three: Array) -> Array:
    """Sizes of the last change of three plain answers, and of the extrapolated ones, shape (2, n)."""
    before, last = np.diff(three, axis=0)
    return np.abs([last, last + REST_OF_CHANGE * (last - before)])


def _beside(times: Array, before: Array, now: Array) -> npt.NDArray[np.bool_]:
    """Times that the change of a slip's time moves across it, or nearly so."""
    apart, crossed = times[:, None] - now, (times[:, None] < now) != (times[:, None] < before)
    return np.asarray(((np.abs(apart) <= np.abs(now - before)) | crossed).any(axis=1))


def read(sections: list[list[Node]], asked: Array) -> Array:
    """Force (lengths) and the fraction that holds at times (n,), shape (2, n); at a slip, after it. By splines in the
    size of all steps, in which the time, too, is smooth."""
    ends = np.array([section[-1].time for section in sections])
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(sections) - 1)
    out = np.empty((2, asked.size))
    for k in np.unique(which):
        at, nodes = asked[which == k], np.array(sections[k])[:, :4]
        nodes = nodes[np.unique(nodes[:, 0], return_index=True)[1]]
        step, times = nodes[:, 0], nodes[:, 1]
        if step.size == 1:
            out[:, which == k] = nodes[0, 2:, None]
            continue
        degree = min(DEGREE, 2 * ((step.size - 2) // 2) + 1)
        values = make_interp_spline(step, nodes[:, 1:], k=degree)
        cell = np.clip(np.searchsorted(times, at, side="left"), 1, step.size - 1)
        found = find_root(
            lambda x, time, values=values: values(x)[..., 0] - time,
            (step[cell - 1], step[cell]),
            args=(np.clip(at, times[cell - 1], times[cell]),),
        )
        # at the end of a cell rounding may take the root out of it
        place = np.where(found.success, found.x, np.interp(at, times, step))
        out[:, which == k] = values(place)[:, 1:].T
    return out
