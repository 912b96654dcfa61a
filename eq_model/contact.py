"""Compiled: one contact, the law that breaks it, and where its birth and its break are counted.

A law is known to the loop by the type of its settings: LIVES holds the function that breaks a contact,
SEEN the one that tells its threshold later on.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba.extending import overload

from eq_model.compiling import bare, inlined
from eq_model.draws.births import Births
from eq_model.draws.streams import Stream
from eq_model.draws.tables import Table
from eq_model.lattice import Bins, Course
from eq_model.moments import STIFFNESS_UNIT

Whole = npt.NDArray[np.int64]
_U, _I, _F = np.uint64, np.int64, np.float64


class Settings(NamedTuple):
    """What all contacts share, beside their law."""

    starts: Births  # at X = 0
    again: Births
    exposures: Table  # ln e, e of the exponential law of mean 1
    mean: float  # threshold (units) of mean stiffness
    wait: float  # a time
    bears: bool  # whether the law asks what contacts bear
    linked: bool  # stiffness to the threshold


class Contact(NamedTuple):
    """One that holds at a stretch (whole) at a moment of the clock."""

    clock: np.int64
    leg: np.int64
    stretch: np.int64
    threshold: np.int64
    exposure: float  # ln of the integral of its rate that it bears
    stiffness: float  # over the mean one
    fresh: bool  # is not one of those at X = 0
    lane: np.int64
    drawn: np.int64  # steps that its lane has drawn words for
    stream: Stream


class Break(NamedTuple):
    """Where a contact breaks; a clock beyond the drive's end where it holds so long."""

    clock: np.int64
    leg: np.int64
    drawn: np.int64
    held: bool  # False of one that did not hold at all


class Watch(NamedTuple):
    """Points at which contacts are counted by stretch and threshold, in the order of the clock."""

    before: Whole  # (bins + 2,): how many of them lie before each bin
    moments: Whole  # (m,): the last moments that count
    places: Whole  # (m,): slider there
    per_stretch: float  # histogram bins per unit of |x|
    per_threshold: float


class Work(NamedTuple):
    """What a block of contacts is followed with; `measured`: its squares count for the variance."""

    stream: Stream
    settings: Settings
    law: Any
    course: Course
    bins: Bins
    watch: Watch
    measured: bool


def by_law(choose: Callable[[type], Any]) -> Any:
    """A function for kernels, a part of them, which `choose` finds by the class of its first argument's law."""

    def function(law, *rest):  # type: ignore[no-untyped-def]
        raise NotImplementedError

    options: Any = {"nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": True}

    @overload(function, jit_options=options, strict=False)
    def found(law, *rest):  # type: ignore[no-untyped-def]
        return choose(law.instance_class)

    return function


LIVES: dict[type, Callable[..., Any]] = {}
SEEN: dict[type, Callable[..., Any]] = {}
# life(law, contact, course, watch, counts): the break of a contact
life = by_law(LIVES.__getitem__)
# seen(law, contact, course, moment): its threshold at a later moment; below 0 where `life` counts it
seen = by_law(SEEN.__getitem__)


@inlined
def bin_of(clock, bins):  # type: ignore[no-untyped-def]
    """The first point at or after a moment of the clock, which is not after the end."""
    if bins.even:
        return max((clock + bins.offset) >> bins.shift, _I(0))
    j = _I(bins.first[_U(clock >> bins.shift)])
    while bins.points[_U(j)] < clock:
        j += 1
    return j


@inlined
def place_of(clock, leg, course):  # type: ignore[no-untyped-def]
    """The slider's position (whole)."""
    k = _U(leg)
    return course.positions[k] + course.directions[k] * (clock - course.begins[k])


@bare
def later(clock, leg, time, course):  # type: ignore[no-untyped-def]
    """The clock when `time` has passed, and the leg; beyond the drive's end where it is over by then."""
    while leg < course.directions.size:
        pace = course.paces[leg]
        left = (course.begins[leg + 1] - clock) * pace
        if time <= left:
            ticks = _I(np.floor(time / pace + 0.5)) if pace > 0.0 else _I(0)
            return min(clock + ticks, course.begins[leg + 1]), leg
        time -= left
        leg += 1
        clock = course.begins[leg]
    return clock + 1, leg


@inlined
def count_event(sign, stiffness, birth, j, work, sums):  # type: ignore[no-untyped-def]
    """Add to bin j a contact that is born (sign 1) or breaks (-1); birth: slider where it is relaxed.

    sums : (bins + 1, 6), of all the number, k y and k, of measured blocks besides k² y², k² y and k²;
    y : the contact's stretch when its bin ends, with the other sign. Stiffnesses of 1 are not
    summed. The last row is of no use.
    """
    j = _U(j)
    y, square = birth - work.bins.places[j], work.bins.square
    exact = _F(y)
    sums[j, _U(0)] += sign
    if not work.settings.linked:
        sums[j, _U(1)] += sign * y
        if work.measured:
            sums[j, _U(3)] += sign * _I(np.floor(exact * exact * square + 0.5))
        return
    sums[j, _U(1)] += sign * _I(np.floor(stiffness * exact + 0.5))
    sums[j, _U(2)] += sign * _I(np.floor(stiffness * STIFFNESS_UNIT + 0.5))
    if work.measured:
        k = stiffness * stiffness
        sums[j, _U(3)] += sign * _I(np.floor(k * exact * exact * square + 0.5))
        sums[j, _U(4)] += sign * _I(np.floor(k * exact + 0.5))
        sums[j, _U(5)] += sign * _I(np.floor(k * STIFFNESS_UNIT + 0.5))


@bare
def look_at(k, birth, threshold, watch, counts):  # type: ignore[no-untyped-def]
    """Count a contact at the k-th watched point.

    birth : slider where the contact is relaxed (whole). counts : (points, 2, bins), of stretches of
    either sign and of thresholds.
    """
    many = counts.shape[2]
    x = _F(watch.places[k] - birth) * (0.5 * watch.per_stretch) + 0.5 * many
    y = threshold * watch.per_threshold
    counts[k, 0, _I(min(max(np.floor(x), 0.0), many - 1.0))] += 1
    counts[k, 1, _I(min(max(y, 0.0), many - 1.0))] += 1
