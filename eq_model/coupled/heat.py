"""Coupled contacts that also break by heat: proposals at rates above their own, of which each is accepted by chance.

A contact has a window of positions of the slider, and in it a level, one of the rates ..., b, 4b, 16b, ... which its
own does not exceed there. While the slider stays in all windows breaks are proposed at the sum of all levels. Contacts
are drawn in proportion to their levels, and break with the probability rate/level, at the slider's X of that time:
exact whatever the windows are (Lewis and Shedler, 1979). The queue of slide_kernel holds where each window ends, at the
contact's threshold or before. As the slider gets there the contact breaks, or has another window. A place of one that
heat has broken is passed over.

A contact that pushes the slider takes it back as it breaks. Windows extend backward, too, and where one ends there all
contacts have new ones.
"""

from math import frexp
from typing import Any, NamedTuple

import numpy as np

from eq_model.blocks import Whole
from eq_model.compiling import bare, inlined, real, whole
from eq_model.contact import by_law, most, rate_at
from eq_model.coupled.ages import NoHeat, place_of, threshold_of
from eq_model.draws.streams import STEPS, Stream, uniform, words_at
from origins import Contacts, Drive
from origins.thresholds.law import Array

# Time of a break beside that of contacts without heat: some 0.6 to 1 µs, in place of 22 to 68 ns.
SLOWER = 30.0
# Levels, by factors of 4, end where all contacts together propose a thousandth of a break on the drive.
PROPOSED = 1e-3
# Share of the slider's own rate, its speed over <x_s>, below which a contact's rate need not be known better.
ALLOWED_RATE = 0.1
# A proposal with a smaller chance than this to be accepted gives the contact a lower level.
RARE = 1.0 / 16.0
# In mean thresholds: how far windows extend backward. The slider goes back by |x|/N where a contact breaks at x < 0.
MARGIN = 1.0 / 32.0
NOWHERE = -(1 << 62)  # a position that no slider gets to


class Heat(NamedTuple):
    """Rates, and the contacts by their levels: `order[first[j] : first[j + 1]]` are those of level j."""

    rates: Any
    unit: float  # a length
    mean: float  # threshold at which k_i = <k>; 0 if all k_i are equal
    end: float  # of the drive, a time
    margin: int
    allowed: int  # the level that a window may have whatever the contact's rate is
    bounds: Array  # rates of the levels; that of level 0 is 0, of contacts that do not hold
    first: Whole
    order: Whole
    slot: Whole  # where each contact stands in `order`
    level: Whole  # of each contact
    ends: Whole  # where its window ends ahead of the slider
    stream: Stream


def heat_of(contacts: Contacts, drive: Drive, n: int, unit: float, stream: Stream) -> Any:
    """Of n contacts that are yet to form, lengths in `unit`; NoHeat if they break at their thresholds alone."""
    from eq_model.laws.settings import rates_of

    if contacts.thermal is None:
        return NoHeat()
    time = np.append(0.0, drive.arrival_times())
    distances, times = np.abs(np.diff(drive.path, prepend=0.0)), np.diff(time)
    spring, mean = drive.spring or np.inf, contacts.mean_threshold
    fastest = float(
        np.divide(distances, times, out=np.zeros(distances.size), where=times > 0.0).max()
    )
    scale = contacts.thermal.rates.scale
    least = min(PROPOSED / (n * max(time[-1], 1e-300)), scale)
    levels = 3 + int(np.ceil(np.log2(scale / least) / 2.0))
    bounds = np.append(0.0, least * 4.0 ** np.arange(levels - 1))
    allowed = np.searchsorted(bounds, ALLOWED_RATE * fastest * spring / (1.0 + spring) / mean) - 1
    return Heat(
        rates=rates_of(contacts).law,
        unit=unit,
        mean=mean / unit if contacts.stiffness == "linked" else 0.0,
        end=float(time[-1]),
        margin=int(MARGIN * mean / unit),
        allowed=max(int(allowed), 1),
        bounds=bounds,
        first=np.zeros(levels + 1, np.int64),
        order=np.empty(n, np.int64),
        slot=np.empty(n, np.int64),
        level=np.empty(n, np.int64),
        ends=np.empty(n, np.int64),
        stream=stream,
    )


@inlined
def _swap(heat, contact, j):  # type: ignore[no-untyped-def]
    """Exchange a contact with the one at place j."""
    i, other = heat.slot[contact], heat.order[j]
    heat.order[i], heat.slot[other] = other, i
    heat.order[j], heat.slot[contact] = contact, j


@bare
def set_level(heat, contact, level):  # type: ignore[no-untyped-def]
    """Move a contact to another level, over the border of each on the way."""
    first, old = heat.first, heat.level[contact]
    while old < level:
        old += 1
        first[old] -= 1
        _swap(heat, contact, first[old])
    while old > level:
        _swap(heat, contact, first[old])
        first[old] += 1
        old -= 1
    heat.level[contact] = level


@inlined
def level_of(heat, near, far, least, largest, k):  # type: ignore[no-untyped-def]
    """The lowest level above all rates at stretches from near to far, of thresholds from least to largest (units)."""
    unit = heat.unit
    bound = most(heat.rates, real(near) * unit, real(far) * unit, least * unit, largest * unit, k)
    return min(1 + max((frexp(bound / heat.bounds[1])[1] + 1) >> 1, 0), heat.bounds.size - 1)


@inlined
def stiffness_of(heat, ages, contact):  # type: ignore[no-untyped-def]
    return ages.fresh[contact] / heat.mean if heat.mean > 0.0 else 1.0


@bare
def _window(heat, ages, contact, s, allowed):  # type: ignore[no-untyped-def]
    """Give a contact a window with a level of at most `allowed`, or the one above its rate's. Returns its end ahead, or
    the slider's X where it is at its threshold."""
    x, k = s.at - ages.zero[contact], stiffness_of(heat, ages, contact)
    y, oldest = threshold_of(ages, contact, s.now), threshold_of(ages, contact, heat.end)
    ahead, back = whole(np.rint(y)) - abs(x), min(heat.margin, whole(np.rint(y)) - abs(x))
    if ahead <= 0:
        set_level(heat, contact, max(heat.level[contact], 1))
        heat.ends[contact] = s.at
        return s.at
    if x < 0:
        ahead -= 2 * x
    else:
        back = min(heat.margin, back + 2 * x)
    level = level_of(heat, max(abs(x) - back, 0), abs(x), y, oldest, k)
    allowed = max(allowed, level + 1)
    while True:
        far = max(x + ahead, back - x)
        level = level_of(heat, max(x - back, -x - ahead, 0), far, y, oldest, k)
        if level <= allowed or ahead + back <= 2:
            break
        if back - x > x + ahead:
            back = max(back >> 1, 1)
        else:
            ahead = max(ahead >> 1, 1)
    set_level(heat, contact, level)
    heat.ends[contact], s.back = s.at + ahead, max(s.back, s.at - back)
    return s.at + ahead


@bare
def _time_to_proposal(heat, s):  # type: ignore[no-untyped-def]
    """The time until a break is proposed if all levels stay; infinite if none ever is."""
    s.total = 0.0
    for j in range(1, heat.bounds.size):
        s.total += real(heat.first[j + 1] - heat.first[j]) * heat.bounds[j]
    return max(s.budget, 0.0) / s.total if s.total > 0.0 else np.inf


@bare
def draw_budget(heat, s):  # type: ignore[no-untyped-def]
    """Draw the integral of the levels' total over the time until the next proposal; returns a further chance."""
    words = words_at(0, s.draws, heat.stream, STEPS)
    s.draws += 1
    s.budget = -np.log(uniform(words[0], words[1]))
    return uniform(words[2], words[3])


@bare
def proposed(heat, ages, s):  # type: ignore[no-untyped-def]
    """The contact whose break is proposed, whether it is accepted, and whether its level is far above its rate."""
    words = words_at(1, s.draws, heat.stream, STEPS)
    rest, j, first = draw_budget(heat, s) * s.total, heat.bounds.size - 1, heat.first
    while j > 1 and rest >= real(first[j + 1] - first[j]) * heat.bounds[j]:
        rest -= real(first[j + 1] - first[j]) * heat.bounds[j]
        j -= 1
    i = min(first[j] + whole(rest / heat.bounds[j]), heat.order.size - 1)
    contact = heat.order[i]
    bound = heat.bounds[heat.level[contact]]
    x, y = abs(s.at - ages.zero[contact]), threshold_of(ages, contact, s.now)
    rate = rate_at(real(x), y, heat, stiffness_of(heat, ages, contact))
    return contact, uniform(words[0], words[1]) * bound < rate, rate < RARE * bound


@inlined
def _leave(heat, contact):  # type: ignore[no-untyped-def]
    """Let a contact hold no more; the queue's key of it is passed over."""
    set_level(heat, contact, 0)
    heat.ends[contact] = NOWHERE


@bare
def _leave_all(heat):  # type: ignore[no-untyped-def]
    """Let no contact hold."""
    heat.first[0] = 0
    heat.first[1:] = heat.order.size
    heat.level[:], heat.ends[:] = 0, NOWHERE
    for i in range(heat.order.size):
        heat.order[i] = heat.slot[i] = i


def by_heat(heat: Any, without: Any) -> Any:
    """The function for kernels that is `heat` with heat, and `without` else."""
    return by_law(lambda law: heat if law is Heat else without)


# queue_position(heat, ages, contact, s): where the queue holds a contact from now on; the slider's X if it breaks now
queue_position = by_heat(
    lambda heat, ages, contact, s: _window(heat, ages, contact, s, heat.allowed),
    lambda heat, ages, contact, s: place_of(ages, contact, s),
)
lower = by_heat(
    lambda heat, ages, contact, s: _window(heat, ages, contact, s, 1),
    lambda heat, ages, contact, s: s.at,
)
leave = by_heat(lambda heat, contact: _leave(heat, contact), lambda heat, contact: None)
leave_all = by_heat(lambda heat: _leave_all(heat), lambda heat: None)
# whether a key at the slider's X is of a contact that has broken, or has another window
is_gone = by_heat(
    lambda heat, contact, at: heat.ends[contact] != at, lambda heat, contact, at: False
)
time_to_next = by_heat(lambda heat, s: _time_to_proposal(heat, s), lambda heat, s: np.inf)
