"""A slider with mass, from event to event: breaks ahead and behind, returns after a delay, points of the path."""

import numpy as np

from eq_model.compiling import bare, entry, inlined, unsigned
from eq_model.coupled.heat import leave, time_to_next
from eq_model.coupled.mass.heat import begin_heat, propose, reach_of, stiffness_by_places
from eq_model.coupled.mass.motion import first_passage
from eq_model.coupled.mass.moves import MOVED, closed_move, damped_move, motion_of, quick_move
from eq_model.coupled.mass.nearest import (
    FAR,
    FETCHED,
    KNOWN,
    NEXT,
    WHO,
    fetch,
    look_through,
    nearest,
    set_place,
)
from eq_model.coupled.mass.state import (
    CONTACT_FORCE,
    ENERGIES,
    F_AFTER,
    F_BEFORE,
    FORCE,
    HOLDING,
    POSITION,
    RELEASED,
    SPEED,
    STORED,
    add,
    contact_force,
    go_to,
    speed_limit,
    spring_force,
    stored,
    time_now,
)
from eq_model.coupled.mass.swings import (
    begin_fall,
    end_fall,
    lowest_here,
    slow_again,
    take_slip,
    watch,
)
from eq_model.draws.supply import take

PATH_DONE, SLIP_ENDED, TOO_MANY, GOING_ON = range(4)
AT_ONCE = 1 << 17  # events after which Python can handle an interrupt


@inlined
def _form(s, contacts, i, supply, pull, age):  # type: ignore[no-untyped-def]
    """Contact i, of this age, forms at the slider's present place."""
    x, r = take(supply)
    k = np.float64(x) / pull.mean if pull.mean > 0.0 else 1.0
    ages = contacts.ages
    if ages.numbered:
        s.now = time_now(s, pull)
        ages.fresh[i], ages.born[i] = ages.fresh_ratio * np.float64(x), s.now - age
        ages.zero[i] = s.at - r
        x = reach_of(ages.heat, ages, i, s)
    s.n_holding += 1
    s.stiffness += k
    s.force += k * np.float64(r)
    set_place(contacts.ahead, i, s.at - r + x)
    set_place(contacts.behind, i, x - s.at + r)
    stretch = np.float64(r)
    add(pull.energy, STORED, 0.5 * k * stretch * stretch)
    # positions are whole numbers: formed at `at` it is stretched by `off` at once, an energy that nobody gives, which
    # is taken off what breaks release
    add(pull.energy, RELEASED, -0.5 * k * s.off * s.off)


@entry
def form_all(slider, contacts, supply, pull):  # type: ignore[no-untyped-def]
    """All contacts form at X = 0, where the slider rests."""
    s = slider[0]
    s.stuck, s.held, s.highest, pull.swing[F_BEFORE] = True, np.int64(pull.n), -np.inf, -np.inf
    begin_heat(contacts.ages.heat, s)
    for i in range(np.int64(pull.n)):
        _form(s, contacts, i, supply, pull, pull.age)
    s.lowest = s.rest_force = contact_force(s, pull)  # which the spring balances


@inlined
def _move_if_grown(s, contacts, i, pull):  # type: ignore[no-untyped-def]
    """Where contact i has grown since its places were set, or they lie before its threshold, move them on. Returns
    whether it was so."""
    ahead = contacts.ahead.places[i]
    before = (ahead + contacts.behind.places[i]) // 2
    s.now = time_now(s, pull)
    now = reach_of(contacts.ages.heat, contacts.ages, i, s)
    if now <= before:
        return False
    set_place(contacts.ahead, i, ahead + (now - before))
    set_place(contacts.behind, i, now - (ahead - before))
    return True


@inlined
def _met(s, contacts, side, pull):  # type: ignore[no-untyped-def]
    """Move the slider to the very place ahead (side 1) or behind (-1) that it has reached. Returns the number of the
    contact that breaks there, or -1 as it holds on."""
    if side > 0:
        if contacts.ahead.at[NEXT] >= contacts.ahead.at[FETCHED]:
            fetch(contacts.ahead, contacts.behind)
        i = contacts.ahead.at[WHO]
        go_to(s, pull, contacts.ahead.places[i])
    else:
        i = contacts.behind.at[WHO]
        go_to(s, pull, -contacts.behind.places[i])
    if contacts.ages.numbered and _move_if_grown(s, contacts, i, pull):
        return np.int64(-1)
    return np.int64(i)


@inlined
def _break(s, contacts, i, pull):  # type: ignore[no-untyped-def]
    """Contact i breaks where the slider is. Returns its number if it forms again at once, or -1 as it waits."""
    ahead, behind = contacts.ahead.places[i], contacts.behind.places[i]
    x = np.float64(s.at - (ahead - behind) // 2)
    stretch = x + s.off
    k = stiffness_by_places(contacts.ages.heat, contacts.ages, i, ahead, behind, pull.mean)
    leave(contacts.ages.heat, i)
    s.force -= k * x
    s.stiffness -= k
    s.n_holding -= 1
    add(pull.energy, RELEASED, 0.5 * k * stretch * stretch)
    # as counted with the slider at a whole position
    add(pull.energy, STORED, -0.5 * k * x * x)
    if s.n_holding == 0:  # nothing is left of what rounding has added up
        s.force, s.stiffness = 0.0, 0.0
        pull.energy[STORED] = 0.0
    s.breaks += 1
    s.broken += 1
    s.loose += 1
    if pull.wait < 0.0:
        return i
    set_place(contacts.ahead, i, np.int64(FAR))
    set_place(contacts.behind, i, np.int64(FAR))
    if s.returning == s.returns:
        s.due = pull.wait
    contacts.waits[s.returns % contacts.waits.size] = s.since
    contacts.out[pull.n - s.n_holding - 1] = i
    s.since, s.returns = 0.0, s.returns + 1
    return np.int64(-1)


@inlined
def _return(s, contacts, pull):  # type: ignore[no-untyped-def]
    """The contact that broke first may form again. Returns a number for it, any that is free."""
    s.returning += 1
    s.due = np.inf
    if s.returning < s.returns:
        s.due = contacts.waits[s.returning % contacts.waits.size]
    return np.int64(contacts.out[pull.n - s.n_holding - 1])


@bare
def _end_leg(s, pull):  # type: ignore[no-untyped-def]
    """Store the slider at the end of a leg and begin the next one. Returns whether a slip has ended, as the drive
    becomes slower than the slider."""
    s.elapsed = pull.lasts[s.leg]
    out, k = pull.at_points, s.leg
    out[POSITION, k], out[HOLDING, k] = np.float64(s.at) + s.off, s.n_holding
    out[FORCE, k], out[CONTACT_FORCE, k] = spring_force(s, pull), contact_force(s, pull)
    out[SPEED, k] = s.speed
    for part in range(STORED):
        out[ENERGIES + part, k] = pull.energy[part, 0]
    out[ENERGIES + STORED, k] = stored(s, pull)
    slipped = False
    s.leg, s.elapsed = k + 1, 0.0
    if s.leg < pull.lasts.size:
        limit = speed_limit(pull.speeds[k + 1])
        if s.falling and s.speed <= limit:
            end_fall(s, pull, 0.0, 0.0)
        elif not s.falling and s.speed > slow_again(s, limit):
            watch(s, pull, 0.0, 0.0)
            slipped = begin_fall(s, pull, 0.0, 0.0, s.speed)
    elif not s.falling or out[FORCE, k] > pull.swing[F_AFTER]:
        slipped = take_slip(s, pull)  # the path ends behind it
    return slipped


@entry
def slide(slider, contacts, supply, pull):  # type: ignore[no-untyped-def]
    """Follow the slider until a slip has ended, or another reason to stop, which is returned."""
    s, each = slider[0], 1.0 / pull.n
    for _ in range(AT_ONCE):
        if s.leg == pull.lasts.size:
            return PATH_DONE
        ahead = np.float64(nearest(contacts.ahead) - s.at) - s.off
        behind = np.float64(nearest(contacts.behind) + s.at) + s.off
        known, known_behind = contacts.ahead.at[KNOWN] != 0, contacts.behind.at[KNOWN] != 0
        remaining = pull.lasts[unsigned(s.leg)] - s.elapsed
        proposal = time_to_next(contacts.ages.heat, s)
        most, slipped = max(min(remaining, s.due, proposal), 0.0), False
        side = 1 if ahead <= 0.0 else -1 if behind <= 0.0 else 0
        moves = side == 0
        if moves:
            stiffness = pull.spring + s.stiffness * each
            pulled = spring_force(s, pull)
            net = pulled - contact_force(s, pull)
            if pulled < s.lowest and not s.falling:
                lowest_here(s, np.float64(s.at) + s.off, pulled)
            if known if s.speed >= 0.0 else known_behind:
                side = quick_move(s, pull, ahead, behind, most, net, stiffness)
                if side == 0:
                    side = damped_move(s, pull, ahead, most, net, stiffness)
            if side == MOVED:
                side = 0
            elif side == 0:
                motion = motion_of(s, pull, net, stiffness)
                passage = first_passage(motion, ahead, behind, most)
                side = passage.side
                if side == 0 or (known if side > 0 else known_behind):
                    travel = ahead if side > 0 else -behind
                    slipped = closed_move(s, pull, motion, passage, travel)
        forms = breaks = np.int64(-1)
        # at a bound, where the slider has not moved yet, the places are looked up
        if side > 0 and not known:
            look_through(contacts.ahead)
        elif side < 0 and not known_behind:
            look_through(contacts.behind)
        else:
            due = side == 0 and s.due <= 0.0
            proposed = side == 0 and not due and proposal <= most
            if side != 0:
                breaks = _met(s, contacts, side, pull)
            elif proposed:
                s.now = time_now(s, pull)
                breaks = propose(contacts.ages.heat, s, contacts)
            if moves and (breaks >= 0 or due) and not s.falling:
                watch(s, pull, 0.0, 0.0)  # with the contacts that held it so far
            if breaks >= 0:
                forms = _break(s, contacts, breaks, pull)
                if s.breaks >= pull.most_breaks:
                    return TOO_MANY
            elif due:
                forms = _return(s, contacts, pull)
            elif side == 0 and not proposed and remaining <= most:
                if slipped:
                    return SLIP_ENDED  # as the leg's end may end another one
                slipped = _end_leg(s, pull) or slipped
            if breaks >= 0 or due:
                s.lowest = np.inf
        if forms >= 0:
            _form(s, contacts, forms, supply, pull, 0.0)
        if slipped:
            return SLIP_ENDED
    return GOING_ON
