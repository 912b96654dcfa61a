"""The slider with mass and what pulls it: forces, energies, and falls of the spring's force."""

from math import frexp
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Whole
from eq_model.compiling import inlined, unsigned
from eq_model.coupled.mass.nearest import Nearest
from origins.drive import FASTER
from origins.thresholds.law import Array

# Of a fall of the spring's force: X_T as it begins, X and K (X_T - X) as it begins and ends, and more
DRIVE, X_BEFORE, X_AFTER, F_BEFORE, F_AFTER, BREAKS, DURATION, TOP_SPEED = range(8)
WORK, DAMPED, RELEASED, STORED = range(4)  # in Pull.energy
# In Pull.at_points, with the energies of WORK to STORED behind them.
POSITION, FORCE, HOLDING, SPEED, CONTACT_FORCE, ENERGIES = range(6)

# Lengths are whole units; forces of contacts, stiffness and energies of breaks are sums over the contacts with k_i in
# units of <k>.
SLIDER = np.dtype(
    [
        ("at", np.int64),  # X is at + off
        ("off", np.float64),
        ("speed", np.float64),
        ("force", np.float64),  # of the contacts if the slider were at `at`
        ("stiffness", np.float64),  # of the contacts that hold
        ("n_holding", np.int64),  # number of contacts that hold
        ("breaks", np.int64),
        ("leg", np.int64),  # index of the drive's present leg
        ("elapsed", np.float64),  # time since that leg began
        ("due", np.float64),  # time until contacts form again after their delay
        ("since", np.float64),  # time since the last break that waits for its return
        ("returning", np.int64),  # index of the next return
        ("returns", np.int64),  # index after the last one
        ("falling", np.bool_),  # whether the slider is faster than the drive
        ("broken", np.int64),  # breaks since it is
        ("stuck", np.bool_),  # whether the slider has stuck since the last slip
        ("loose", np.int64),  # breaks since it last stuck
        ("tried", np.int64),  # of these at the last fall without a break: the next is smaller
        ("rest", np.float64),  # X from which it may be sticking
        ("rest_force", np.float64),  # and the spring's force there
        ("rest_breaks", np.int64),  # and the number of all breaks before
        ("seen", np.int64),  # number of all breaks, but for those at the present place
    ]
)


class Contacts(NamedTuple):
    """Contacts: a place ahead of which, and one behind which, the slider breaks each of them."""

    ahead: Nearest
    behind: Nearest  # with the opposite sign
    out: npt.NDArray[np.int32]  # numbers of those that wait for their return
    waits: Array  # time between each break that waits and the one before, a ring


class Pull(NamedTuple):
    """The drive, the slider's constants for n contacts, and arrays for the results."""

    n: int
    spring: float  # K/(N <k>)
    per_mass: float  # N <k>/M
    damping: float  # γ/(N <k>)
    rate: float  # γ/M
    mean: float  # threshold at which k_i = <k>; 0 if all k_i are equal
    wait: float  # the delay, below 0 if there is none
    slip: int  # fewest breaks of a fall of the force that is a slip
    room: float  # way in which a slider sticks
    rise: float  # of the spring's force per N <k> meanwhile, and its least fall in a slip
    most_breaks: int
    places: Array  # X_T where each leg of the drive begins
    speeds: Array  # its speed on each leg
    lasts: Array  # the time that it takes
    at_points: Array  # (9, legs), at the end of each leg
    fall: Array  # (8,), the present fall of the spring's force, or the last one
    slipped: Array  # (8,), the last one that was a slip
    falls: Whole  # numbers of those that are no slips in which 1, 2-3, 4-7, ... contacts broke
    energy: Array  # (4, 2): sums, and what rounding has taken from them; STORED by the contacts if the slider were `at`


@inlined
def add(sums, k, value):  # type: ignore[no-untyped-def]
    """Add to a sum of very many terms, and keep what rounding loses (Kahan)."""
    value -= sums[k, 1]
    new = sums[k, 0] + value
    sums[k, 1] = (new - sums[k, 0]) - value
    sums[k, 0] = new


@inlined
def spring_force(s, pull):  # type: ignore[no-untyped-def]
    """K (X_T - X) per N <k>."""
    drive = pull.places[unsigned(s.leg)] + pull.speeds[unsigned(s.leg)] * s.elapsed
    return pull.spring * ((drive - np.float64(s.at)) - s.off)


@inlined
def contact_force(s, pull):  # type: ignore[no-untyped-def]
    """F per N <k>."""
    return (s.force + s.stiffness * s.off) / pull.n


@inlined
def _shift(s, pull, travel):  # type: ignore[no-untyped-def]
    """Count the contacts' force and energy from a place that lies so far ahead."""
    far = np.float64(travel)
    add(pull.energy, STORED, far * (s.force + 0.5 * s.stiffness * far))
    s.force += s.stiffness * far
    s.at += travel


@inlined
def go_to(s, pull, place):  # type: ignore[no-untyped-def]
    """The slider is exactly at a whole position."""
    _shift(s, pull, place - s.at)
    s.off = 0.0


@inlined
def stored(s, pull):  # type: ignore[no-untyped-def]
    """Energy of the contacts that hold, N <k> times the sum over them per contact."""
    return pull.energy[STORED, 0] + s.off * (s.force + 0.5 * s.stiffness * s.off)


@inlined
def _rest_at(s, x, force):  # type: ignore[no-untyped-def]
    """From here on the slider may be sticking."""
    s.rest, s.rest_force, s.rest_breaks = x, force, s.seen


@inlined
def watch(s, pull, force):  # type: ignore[no-untyped-def]
    """Whether the slider sticks: its contacts hold it in a narrow room, and few break, while the spring's force rises;
    it is `force` now. Fewer contacts than break in a slip do not hold it: a heavy slider that slowly breaks the last
    ones, as it gathers speed, has begun to slip."""
    x = np.float64(s.at) + s.off
    if s.n_holding < pull.slip or abs(x - s.rest) > pull.room:
        _rest_at(s, x, force)
    elif force - s.rest_force >= pull.rise:
        if s.seen - s.rest_breaks < pull.slip:
            s.stuck, s.loose = True, s.breaks - s.seen
        _rest_at(s, x, force)


@inlined
def speed_limit(drive):  # type: ignore[no-untyped-def]
    """The speed above which the spring's force falls. A drive that moves back to its first point counts as at rest."""
    return max(drive, 0.0)


@inlined
def begin_fall(s, pull, before, travel_before, top):  # type: ignore[no-untyped-def]
    """A fall of the spring's force began so long before the present, when the slider was so far behind."""
    fall, speed = pull.fall, pull.speeds[unsigned(s.leg)]
    drive = pull.places[unsigned(s.leg)] + speed * (s.elapsed - before)
    x = np.float64(s.at) + (s.off - travel_before)
    fall[DRIVE], fall[X_BEFORE], fall[F_BEFORE] = drive, x, pull.spring * (drive - x)
    fall[DURATION], fall[TOP_SPEED] = before, top
    s.falling, s.broken = True, 0


@inlined
def end_fall(s, pull, before, travel_before):  # type: ignore[no-untyped-def]
    """It ended so long before the present. Returns whether it was a slip."""
    fall, speed, size = pull.fall, pull.speeds[unsigned(s.leg)], s.broken
    drive = pull.places[unsigned(s.leg)] + speed * (s.elapsed - before)
    x = np.float64(s.at) + (s.off - travel_before)
    fall[X_AFTER], fall[F_AFTER], fall[BREAKS] = x, pull.spring * (drive - x), s.loose
    fall[DURATION] -= before
    s.falling = False
    slips = s.stuck and s.loose >= pull.slip and fall[TOP_SPEED] >= FASTER * speed
    slips = slips and fall[F_BEFORE] - fall[F_AFTER] >= pull.rise
    if slips:
        for k in range(fall.size):
            pull.slipped[k] = fall[k]
        s.stuck = False
    elif size > 0:
        pull.falls[frexp(size)[1] - 1] += 1  # by the number of its bits
    if slips or size > 0:  # a slider that sticks rings, and no contact breaks
        _rest_at(s, x, fall[F_AFTER])
    return slips


@inlined
def pass_time(s, pull, t, travel, speed, travel_integral, squares):  # type: ignore[no-untyped-def]
    """The slider moves for a time t, by `travel`; with the integrals of that and of its squared speed."""
    drive = pull.speeds[unsigned(s.leg)]
    pulled = spring_force(s, pull) * t + pull.spring * (0.5 * drive * t * t - travel_integral)
    add(pull.energy, WORK, drive * pulled)
    add(pull.energy, DAMPED, pull.damping * squares)
    s.off += travel
    shift = np.int64(np.rint(s.off))
    s.off -= np.float64(shift)
    _shift(s, pull, shift)
    s.speed = speed
    s.elapsed += t
    s.due -= t
    s.since += t
    pull.fall[DURATION] += t
