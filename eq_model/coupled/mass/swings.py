"""Swings of the spring's force from turn to turn, which of them are slips, and where the slider sticks in between.

The force falls where the slider is faster than the drive. Of finitely many contacts it does so at many breaks, also
while it rises on the whole: a *swing down* leads from a maximum to a minimum such that no rise within it, and no fall
outside, is as large as a level. That level is the larger of RISE and of what chance does in smooth sliding. All is done
where the force turns, in a few operations each time.
"""

from math import frexp

import numpy as np

from eq_model.compiling import inlined, unsigned
from eq_model.coupled.mass.motion import begin_of, meets, moment_at, next_extreme
from eq_model.coupled.mass.state import (
    BREAKS,
    DRIVE,
    DURATION,
    F_AFTER,
    F_BEFORE,
    TOP_SPEED,
    X_AFTER,
    X_BEFORE,
    speed_limit,
)
from origins.drive import FASTER, LOWER, RISE

SLOW = 1e-9  # a share of the largest excess of speed, far below what anyone measures
# In whole units of length: a spring's force that rings by less, 1e-9 mean thresholds, does not turn.
STILL = 0.25
# Extremes of the speed on a move in which nothing breaks, after which only those of its last turns are looked at.
LOOKED_AT = 6


@inlined
def _level(s, pull):  # type: ignore[no-untyped-def]
    """Rises and falls as large as this are swings."""
    return max(pull.rise, pull.chance[unsigned(s.leg)])


@inlined
def _rest_at(s, x, force):  # type: ignore[no-untyped-def]
    """From here on the slider may be sticking."""
    s.rest, s.rest_force, s.rest_breaks = x, force, s.breaks


@inlined
def has_loosened(s, pull):  # type: ignore[no-untyped-def]
    """Whether so many contacts have broken since the slider stuck that the next swing down is a slip."""
    return s.stuck and s.loose >= max(
        pull.slip_fraction * s.held, pull.least_breaks[unsigned(s.leg)], 1.0
    )


@inlined
def watch(s, pull, before, travel_before):  # type: ignore[no-untyped-def]
    """Whether the slider sticks: its contacts hold it in a narrow room, and few break, while the spring's force rises
    to its value so long before the present, when the slider was so far behind.

    It is called before a contact breaks or forms while the force rises, and where it is largest: so what it finds
    does not depend on where else the slider is looked at. The slider also sticks, however far it moves, where the
    force has risen since a contact last broke or formed; but not if a share `slip_fraction` of the contacts to which
    it stuck has broken: a heavy slider then gathers speed, and the force rises until it is as fast as the drive. A
    small part of the contacts that held it before does not hold it: a heavy slider that slowly breaks the last ones,
    as it gathers speed, has begun to slip. Neither does it stick anew in a small rise within a fall. One that moves
    back beyond the room has only turned there: no contact that it stuck to holds it."""
    x = np.float64(s.at) + (s.off - travel_before)
    drive = pull.places[unsigned(s.leg)] + pull.speeds[unsigned(s.leg)] * (s.elapsed - before)
    force = pull.spring * (drive - x)
    if x < s.stuck_at - pull.room:
        s.stuck = False
    least_holding = max(RISE * pull.n, pull.slip_fraction * s.held if s.stuck else 0.0)
    holds, loaded, near = s.n_holding >= least_holding, False, abs(x - s.rest) <= pull.room
    risen = near and force - s.rest_force >= pull.rise
    if risen:
        loaded = s.breaks - s.rest_breaks < pull.slip_fraction * s.n_holding
    if not holds or not near or risen:
        _rest_at(s, s.lowest_at, s.lowest)
    if force - s.lowest >= pull.rise and not has_loosened(s, pull):
        loaded = True
    if holds and loaded and force >= s.highest:
        s.stuck, s.stuck_at, s.held, s.loose = True, x, s.n_holding, 0


@inlined
def lowest_here(s, x, force):  # type: ignore[no-untyped-def]
    """The spring's force is the lowest since a contact broke or formed."""
    s.lowest_at, s.lowest = x, force


@inlined
def begin_fall(s, pull, before, travel_before, top):  # type: ignore[no-untyped-def]
    """A fall of the spring's force began so long before the present, when the slider was so far behind. Returns whether
    a slip has ended, as the force has risen from its lowest by so much that it is in its next swing."""
    swing, speed = pull.swing, pull.speeds[unsigned(s.leg)]
    drive = pull.places[unsigned(s.leg)] + speed * (s.elapsed - before)
    x = np.float64(s.at) + (s.off - travel_before)
    force = pull.spring * (drive - x)
    s.falling, s.broken, s.force_before, s.top = True, 0, force, top
    lead, ended = force + (FASTER - 1.0) * pull.spring * drive, False
    if s.in_swing and force - swing[F_AFTER] >= _level(s, pull):
        ended = take_slip(s, pull)
        s.in_swing = False
        swing[F_BEFORE] = -np.inf
    if not s.in_swing and force >= swing[F_BEFORE]:
        swing[DRIVE], swing[X_BEFORE], swing[F_BEFORE], swing[TOP_SPEED] = drive, x, force, 0.0
        s.clock, s.lead, s.rushed = before, lead, False
    s.lead, s.highest = max(s.lead, lead), max(s.highest, force)
    return ended


@inlined
def take_slip(s, pull):  # type: ignore[no-untyped-def]
    """The present swing down is over. Returns whether it was a slip, which is kept."""
    slipped, s.slipping = s.slipping, False
    if slipped:
        for k in range(pull.swing.size):
            pull.slipped[k] = pull.swing[k]
    return slipped


@inlined
def end_fall(s, pull, before, travel_before):  # type: ignore[no-untyped-def]
    """The fall ended so long before the present."""
    swing, speed, size = pull.swing, pull.speeds[unsigned(s.leg)], s.broken
    drive = pull.places[unsigned(s.leg)] + speed * (s.elapsed - before)
    x = np.float64(s.at) + (s.off - travel_before)
    force, chance = pull.spring * (drive - x), pull.chance[unsigned(s.leg)]
    s.falling = False
    if force < s.lowest:
        lowest_here(s, x, force)
    swing[TOP_SPEED] = max(swing[TOP_SPEED], s.top)
    if s.top >= FASTER * speed and s.force_before - force >= chance:
        s.rushed = True
    # in several falls: beside a drive FASTER times as fast the force would have fallen, too
    if s.lead - (force + (FASTER - 1.0) * pull.spring * drive) >= chance:
        s.rushed = True
    if not s.in_swing and swing[F_BEFORE] - force >= _level(s, pull):
        s.in_swing = True
        swing[F_AFTER] = np.inf
    if s.in_swing:
        lower = swing[F_AFTER] - force > LOWER * (swing[F_BEFORE] - force)
        begins = not s.slipping and s.rushed and has_loosened(s, pull)
        if begins:
            s.slipping, s.stuck, s.before_slip = True, False, s.breaks - s.loose
        if lower:
            swing[X_AFTER], swing[F_AFTER], swing[DURATION] = x, force, s.clock - before
            s.highest = -np.inf
        if lower or begins:
            swing[BREAKS] = s.breaks - s.before_slip
            # one that sticks may ring, and no contact breaks: it goes on to stick
            if s.slipping or s.breaks > s.rest_breaks:
                _rest_at(s, x, force)
    if size > 0 and not s.slipping:
        pull.falls[frexp(size)[1] - 1] += 1  # by the number of its bits


@inlined
def slow_again(s, limit):  # type: ignore[no-untyped-def]
    """The speed at which a fall is over that only comes close to its end: of a slider that does not ring and drifts
    with the drive, as no contact holds or the drive holds."""
    return limit + SLOW * max(s.top - limit, 0.0)


@inlined
def see_turns(s, pull, m, t, travel):  # type: ignore[no-untyped-def]
    """Begin and end falls of the spring's force on a move m of time t that has ended here, in order. Returns whether a
    slip has ended.

    The speed goes one way between two of its extremes. Of a slider that rings for long the first turns are seen, which
    are the largest, and the last ones, which lie the farthest ahead; those in which the force hardly changes are none,
    but for a fall that has not ended yet.
    """
    limit, ended, looked = speed_limit(pull.speeds[unsigned(s.leg)]), False, 0
    comes_close = not m.rings and m.drift >= (1.0 - 1e-12) * limit
    at, here = 0.0, begin_of(m)
    while at < t:
        reach = np.sqrt(here.change**2 + (m.own * here.u) ** 2)
        if not s.falling:
            if m.drift + reach <= limit:
                break  # it never gets as fast again
            still = 2.0 * pull.spring * reach < STILL * m.own
            if still and s.speed <= limit:
                break
            if m.rings and looked >= 0 and (still or looked >= LOOKED_AT):
                turn = 2.0 * np.pi / m.beat
                at += turn * max(np.floor((t - at) / turn) - 1.0, 0.0)
                here, looked = moment_at(m, at), -1000  # once
        end = min(at + next_extreme(m, at, here.u, here.change), t)
        there = moment_at(m, end)
        level, over = limit, there.speed > max(limit, here.speed)
        if s.falling:
            s.top = max(s.top, there.speed)
            level = slow_again(s, limit) if comes_close else limit
            over = there.speed <= level
        if over:
            when, then = at, here
            if (here.speed > level) == s.falling:
                when, then = meets(m, True, not s.falling, level, at, end, at)
            before, behind = t - when, travel - then.travel
            if s.falling:
                end_fall(s, pull, before, behind)
            else:
                watch(s, pull, before, behind)
                ended = begin_fall(s, pull, before, behind, there.speed) or ended
        at, here, looked = end, there, looked + 1
    return ended
