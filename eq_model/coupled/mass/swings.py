"""Swings of the spring's force from turn to turn, which of them are slips, and where the slider sticks in between.

The force falls where the slider is faster than the drive. Of finitely many contacts it does so at many breaks, also
while it rises on the whole: a *swing down* leads from a maximum to a minimum such that no rise within it, and no fall
outside, is as large as a level. That level is the larger of RISE and of what chance does in smooth sliding. All is done
where the force turns, in a few operations each time.
"""

from math import frexp

import numpy as np

from eq_model.compiling import inlined, unsigned
from eq_model.coupled.mass.state import (
    BREAKS,
    DRIVE,
    DURATION,
    F_AFTER,
    F_BEFORE,
    TOP_SPEED,
    X_AFTER,
    X_BEFORE,
)
from origins.drive import FASTER, RISE

# Share of a swing below which a second minimum does not count as lower: a slider that no contact holds comes close to
# the force of its damping again and again, and the swing has ended where it first does.
LOWER = 1e-3


@inlined
def _level(s, pull):  # type: ignore[no-untyped-def]
    """Rises and falls as large as this are swings."""
    return max(pull.rise, pull.chance[unsigned(s.leg)])


@inlined
def _rest_at(s, x, force):  # type: ignore[no-untyped-def]
    """From here on the slider may be sticking."""
    s.rest, s.rest_force, s.rest_breaks = x, force, s.breaks


@inlined
def watch(s, pull):  # type: ignore[no-untyped-def]
    """Whether the slider sticks: its contacts hold it in a narrow room, and few break, while the spring's force rises.

    Called where a move ends, as one move may load it all the way to its next break; where the slider is fast by then,
    the force was largest as it became so. A small part of the contacts that held it before does not hold it: a heavy
    slider that slowly breaks the last ones, as it gathers speed, has begun to slip. Neither does it stick anew in a
    small rise within a fall. One that moves back beyond the room has only turned there: no contact that it stuck to
    holds it."""
    before, travel_before = (s.fast_for, s.fast_way) if s.fast else (0.0, 0.0)
    x = np.float64(s.at) + (s.off - travel_before)
    drive = pull.places[unsigned(s.leg)] + pull.speeds[unsigned(s.leg)] * (s.elapsed - before)
    force = pull.spring * (drive - x)
    if x < s.stuck_at - pull.room:
        s.stuck = False
    least_holding = max(RISE * pull.n, pull.slip_fraction * s.held if s.stuck else 0.0)
    if s.n_holding >= least_holding and force - s.lowest >= pull.rise:
        _rest_at(s, x, s.lowest)  # this move alone tells, in which nothing broke
    if s.n_holding < least_holding or abs(x - s.rest) > pull.room:
        _rest_at(s, x, force)
    elif force - s.rest_force >= pull.rise:
        few = s.breaks - s.rest_breaks < pull.slip_fraction * s.n_holding
        if few and (s.in_swing or force >= pull.swing[F_BEFORE]):
            s.stuck, s.stuck_at, s.held, s.loose, s.tried = True, x, s.n_holding, 0, 0
        _rest_at(s, x, force)


@inlined
def has_loosened(s, pull):  # type: ignore[no-untyped-def]
    """Whether so many contacts have broken since the slider stuck that the next swing down is a slip."""
    return s.stuck and s.loose >= max(
        pull.slip_fraction * s.held, pull.least_breaks[unsigned(s.leg)], 1.0
    )


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
    s.lead = max(s.lead, lead)
    return ended


@inlined
def begin_if_fast(s, pull):  # type: ignore[no-untyped-def]
    """Where the slider is faster than the drive at an event, a fall has begun; returns as `begin_fall`. One that begins
    and ends between two events does not count, wherever a contact was looked at in between."""
    if not s.fast:
        return False
    s.fast = False
    return begin_fall(s, pull, s.fast_for, s.fast_way, s.top)


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
    s.falling, s.lowest = False, force
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
        if lower or begins:
            swing[BREAKS] = s.breaks - s.before_slip
            # one that sticks may ring, and no contact breaks: it goes on to stick
            if s.slipping or s.breaks > s.rest_breaks:
                _rest_at(s, x, force)
    if size > 0 and not s.slipping:
        pull.falls[frexp(size)[1] - 1] += 1  # by the number of its bits
