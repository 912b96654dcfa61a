"""Compiled functions of one contact: its break under laws that do not change its threshold, and its sums.

The loops select a law by the type of its settings: BREAKS holds the function that breaks a contact, AGED the one that
returns its threshold at a later instant. Cold contacts have none in BREAKS: they break in rows (row_breaks.py).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from eq_model.blocks import Whole
from eq_model.compiling import bare, inlined, real, rounded, unsigned, whole
from eq_model.draws.births import LEVEL_UNIT, DrawnBirths
from eq_model.draws.streams import Stream
from eq_model.draws.tables import QuantileTable
from eq_model.whole_drive import STIFFNESS_UNIT, WholeDrive
from origins.laws.compiled import CompiledRates


class Contact(NamedTuple):
    """A contact that holds at a stretch (in whole units) at an instant of the clock."""

    clock: np.int64
    leg: np.int64
    stretch: np.int64
    threshold: np.int64
    log_exposure: float  # ln of the integral of its rate at which it breaks
    breaks_at: np.int64  # the stretch at which its rate breaks it if its first leg goes on
    stiffness: float  # divided by the mean one
    fresh: bool  # False for contacts of the start
    lane: int
    drawn: np.int64  # steps for which its lane has drawn words
    stream: Stream


class Break(NamedTuple):
    """Instant at which a contact breaks; a clock beyond the drive's end if it holds until then.

    It is the instant of its birth if the contact never held.
    """

    clock: np.int64
    leg: np.int64
    drawn: np.int64


class Work(NamedTuple):
    """All that is needed to follow a block of contacts but their law: what takes no law is compiled once for all."""

    stream: Any  # Stream of the block
    starts: DrawnBirths  # at X = 0
    reforming: DrawnBirths
    exposures: QuantileTable  # logs of the integrals of rates at which contacts break
    forward: bool  # whether the law is a Forward
    at_once: bool  # whether contacts that break form again at once and relaxed
    drive: WholeDrive
    mean: float  # threshold (units) of mean stiffness
    wait: float  # a time
    ticks: Any  # (m,): of the clock in that time, on each leg
    needs_exposure: bool  # whether the law breaks contacts at a rate, or at a hazard
    linked: bool  # whether stiffness is proportional to the threshold
    measured: bool  # whether squares are summed for the variance


class Cold(NamedTuple):
    """Breaks at the threshold only, which counts as reached within `tie` units where the slider turns or stops."""

    tie: np.int64
    further: Whole  # (m,): see whole_drive.further_legs


class Warm(NamedTuple):
    """Breaks at the rate of a law, in the drive's units of length and time."""

    rates: Any
    unit: float  # a length
    log_slow: Any  # (m,): ln of the time per length, of each leg


def by_law(choose: Callable[[type], Any]) -> Any:
    """A function for kernels that calls the one which `choose` returns for the class of its first argument."""

    def function(law, *rest):  # type: ignore[no-untyped-def]
        raise NotImplementedError

    # those of compiling.inlined
    options: Any = {"nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": True}
    options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

    @overload(function, jit_options=options, strict=False)
    def found(law, *rest):  # type: ignore[no-untyped-def]
        return choose(law.instance_class)

    return function


BREAKS: dict[type, Callable[..., Any]] = {}
AGED: dict[type, Callable[..., Any]] = {}
# functions by the class of their law: laws.settings.law_of fills RATES; the others are filled below and in laws/*.py
RATES: dict[type, CompiledRates] = {}
ROWS: dict[type, Callable[..., Any]] = {}
# break_of(law, contact, drive, counts): the break of a contact
break_of = by_law(BREAKS.__getitem__)
# aged_threshold(law, contact, drive, instant): its threshold at a later instant; below 0 if `break_of` counts it
# itself, or if nothing tells it, so that the engine refuses histograms
aged_threshold = by_law(lambda law: AGED.get(law, lambda law, contact, drive, instant: -1.0))
log_rate = by_law(lambda law: RATES[law].log_rate)
passed = by_law(lambda law: RATES[law].passed)
reached = by_law(lambda law: RATES[law].reached)
most = by_law(lambda law: RATES[law].most)


@inlined
def rate_at(x, y, law, k):  # type: ignore[no-untyped-def]
    """The rate of breaking at the stretch x >= 0 and threshold y (units), of which 0 counts as a tiny one."""
    y = max(y, 1e-9)
    return np.exp(log_rate(law.rates, min(x, y) * law.unit, y * law.unit, k))


@inlined
def bin_of(clock, drive):  # type: ignore[no-untyped-def]
    """Index of the first point at or after an instant of the clock; the instant is not after the end."""
    if drive.even:
        return max((clock + drive.offset) >> drive.shift, whole(0))
    j = whole(drive.first_bin[unsigned(clock >> drive.shift)])
    j += whole(drive.bin_ends[unsigned(j)] < clock)  # nearly always enough, and no branch
    while drive.bin_ends[unsigned(j)] < clock:
        j += 1
    return j


@inlined
def place_of(clock, leg, drive):  # type: ignore[no-untyped-def]
    """The slider's position at an instant of a leg (in whole units)."""
    k = unsigned(leg)
    return drive.positions[k] + drive.directions[k] * (clock - drive.begins[k])


@bare
def later(clock, leg, time, drive):  # type: ignore[no-untyped-def]
    """Clock and leg after `time` has passed; a clock beyond the drive's end if that comes first."""
    while leg < drive.directions.size:
        pace, end = drive.paces[unsigned(leg)], drive.begins[unsigned(leg + 1)]
        remaining = (end - clock) * pace
        if time <= remaining:
            ticks = whole(np.floor(time / pace + 0.5)) if pace > 0.0 else whole(0)
            return min(clock + ticks, end), leg
        time -= remaining
        leg, clock = leg + 1, end
    return clock + 1, leg


@inlined
def count_event(sign, stiffness, birth, j, work, sums):  # type: ignore[no-untyped-def]
    """Add to bin j a contact that is born (sign 1) or breaks (-1).

    birth : the slider's position at which the contact is relaxed
    sums : (bins + 1, 6), of the number, k y, in measured blocks k² y², k, and in measured blocks k² y and k², where
    y = -(stretch at the bin's end). The last three columns are missing where all k are 1. Ignore the last row: breaks
    beyond the path.
    """
    y, place = birth - work.drive.bin_positions[unsigned(j)], unsigned(j)
    sums[place, 0] += sign
    if work.measured:
        count_squares(sign, stiffness, birth, j, work, sums)
    if not work.linked:
        sums[place, 1] += sign * y
        return
    sums[place, 1] += sign * rounded(stiffness * real(y))
    sums[place, 3] += sign * rounded(stiffness * STIFFNESS_UNIT)


@inlined
def count_squares(sign, stiffness, birth, j, work, sums):  # type: ignore[no-untyped-def]
    """What `count_event` adds in measured blocks alone."""
    j = unsigned(j)
    exact, k = real(birth - work.drive.bin_positions[j]), stiffness * stiffness
    sums[j, 2] += sign * rounded(k * exact * exact * work.drive.square)
    if work.linked:
        sums[j, 4] += sign * rounded(k * exact)
        sums[j, 5] += sign * rounded(k * STIFFNESS_UNIT)


@bare
def look_at(k, birth, threshold, drive, counts):  # type: ignore[no-untyped-def]
    """Count a contact at the k-th watched point.

    birth : the slider's position at which the contact is relaxed (whole units). counts : (points, 2, bins),
    of stretches of either sign and of thresholds.
    """
    many = counts.shape[2]
    place = drive.bin_positions[drive.watched[k]]
    x = real(place - birth) * drive.per_stretch + 0.5 * many
    y = threshold * drive.per_threshold
    counts[k, 0, whole(min(max(np.floor(x), 0.0), many - 1.0))] += 1
    counts[k, 1, whole(min(max(y, 0.0), many - 1.0))] += 1


@inlined
def _integral(law, x, threshold, k):  # type: ignore[no-untyped-def]
    """The integral of the rate over the stretch from 0 to x (whole units), an odd function; threshold : a length."""
    if x == 0:
        return 0.0
    far = min(abs(real(x)) * law.unit, threshold)
    return np.copysign(passed(law.rates, far, threshold, k), x)


@inlined
def _break_at(law, x, goal, threshold, k):  # type: ignore[no-untyped-def]
    """The stretch >= x at which the integral of the rate from 0 reaches the goal in forward motion."""
    log_amount = np.log(max(abs(goal), 1e-300))
    far = np.copysign(min(reached(law.rates, log_amount, threshold, k), threshold), goal)
    return max(whole(np.floor(far * (1.0 / law.unit) + 0.5)), x)


@bare
def _from_rest(law, n, x, log_amounts, breaks_at):  # type: ignore[no-untyped-def]
    """As `_in_row`, for contacts of the mean stiffness that form relaxed."""
    for i in range(unsigned(n)):
        threshold = real(x[i]) * law.unit
        far = min(reached(law.rates, log_amounts[i], threshold, 1.0), threshold)
        breaks_at[i] = whole(np.floor(far * (1.0 / law.unit) + 0.5))


def _in_row(law, n, x, breaks_at, lanes, work):  # type: ignore[no-untyped-def]
    """Set `breaks_at`, the stretches in the directions of their legs at which n contacts break if the legs go on."""
    legs, log_amounts = lanes.leg, lanes.log_amount
    for i in range(unsigned(n)):
        log_amounts[i] = real(lanes.log_exposure[i]) * LEVEL_UNIT - law.log_slow[unsigned(legs[i])]
    _from_rest(law, n, x, log_amounts, breaks_at)
    for i in range(n if work.linked or not work.reforming.relaxed else 0):
        r = -lanes.stretch[i] if work.drive.directions[legs[i]] < 0 else lanes.stretch[i]
        if r != 0 or work.linked:
            threshold, k = real(x[i]) * law.unit, real(x[i]) / work.mean if work.linked else 1.0
            goal = _integral(law, r, threshold, k) + np.exp(log_amounts[i])
            breaks_at[i] = _break_at(law, r, goal, threshold, k)
    return breaks_at


def _by_rate(law, contact, drive, counts):  # type: ignore[no-untyped-def]
    """The break of a contact, where the integral of its rate over time reaches its exposure."""
    clock, leg, x, k = contact.clock, contact.leg, contact.stretch, contact.stiffness
    moved, d = contact.breaks_at - drive.directions[leg] * x, drive.directions[leg]
    legs, room = drive.directions.size, drive.begins[leg + 1] - clock
    if d != 0 and (moved <= room or leg + 1 == legs):
        return Break(clock + min(moved, room + 1), leg, contact.drawn)
    threshold, budget, slow = real(contact.threshold) * law.unit, np.exp(contact.log_exposure), 0.0
    while leg < legs:
        room, d, pace = drive.begins[leg + 1] - clock, drive.directions[leg], drive.paces[leg]
        # on a leg a contact breaks where the product of the time per length and the integral reaches the budget, a time
        here = _integral(law, x, threshold, k)
        remaining, slow = max(budget - slow * here, 1e-300), d * (pace / law.unit)
        budget = remaining + slow * here
        if d == 0:
            hazard = rate_at(abs(real(x)), real(contact.threshold), law, k) * pace
            if hazard * room >= remaining:
                return Break(clock + min(whole(remaining / hazard), room), leg, contact.drawn)
            budget -= hazard * room
        elif leg != contact.leg:
            moved = _break_at(law, d * x, budget * (law.unit / pace), threshold, k) - d * x
            if moved <= room:
                return Break(clock + moved, leg, contact.drawn)
        x += d * room
        leg += 1
        clock = drive.begins[leg]
    return Break(clock + 1, leg, contact.drawn)


BREAKS[Warm] = _by_rate
AGED |= dict.fromkeys((Cold, Warm), lambda law, contact, drive, instant: real(contact.threshold))
ROWS[Warm] = _in_row
# breaks_in_row(law, n, x, breaks_at, lanes, work): the stretches at which contacts break in steady motion, or their
# thresholds x under laws that do not give them
breaks_in_row = by_law(lambda law: ROWS.get(law, lambda law, n, x, *rest: x))
