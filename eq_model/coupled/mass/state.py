"""The slider with mass and what pulls it: forces and energies."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Whole
from eq_model.compiling import inlined, unsigned
from eq_model.coupled.ages import Ages
from eq_model.coupled.mass.nearest import Nearest
from origins.thresholds.law import Array

# Of a swing down of the spring's force (`swings`): X_T as it begins, X and K (X_T - X) as it begins and ends, and more
DRIVE, X_BEFORE, X_AFTER, F_BEFORE, F_AFTER, BREAKS, DURATION, TOP_SPEED = range(8)
WORK, DAMPED, RELEASED, STORED = range(4)  # in PullWithMass.energy
# In PullWithMass.at_points, with the energies of WORK to STORED behind them.
POSITION, FORCE, HOLDING, SPEED, CONTACT_FORCE, ENERGIES = range(6)

# Lengths are whole units (`unit_of` in coupled/ensemble.py: 2^-28 mean thresholds, or more); forces of contacts,
# stiffness and energies of breaks are sums over the contacts with k_i in units of <k>.
SLIDER = np.dtype(
    [
        ("at", np.int64),  # X is at + off
        ("off", np.float64),
        ("speed", np.float64),
        ("force", np.float64),  # of the contacts if the slider were at `at`
        ("stiffness", np.float64),  # of the contacts that hold
        ("n_holding", np.int64),  # number of contacts that hold
        ("breaks", np.int64),  # number of all breaks so far
        ("leg", np.int64),  # index of the drive's present leg
        ("elapsed", np.float64),  # time since that leg began
        ("due", np.float64),  # time until contacts form again after their delay
        ("since", np.float64),  # time since the last break that waits for its return
        ("returning", np.int64),  # index of the next return
        ("returns", np.int64),  # index after the last one
        # a fall of the spring's force: the slider is faster than the drive
        ("falling", np.bool_),  # whether it is
        ("broken", np.int64),  # breaks since the fall began
        ("force_before", np.float64),  # of the spring where it began
        ("top", np.float64),  # largest speed of the slider since then
        # a swing down, of one fall or several: begins where the spring's force is largest
        ("in_swing", np.bool_),  # whether the force is in one, which no rise has ended yet
        ("clock", np.float64),  # time since it began
        ("lead", np.float64),  # largest K (FASTER X_T - X) since it began
        ("highest", np.float64),  # maximum of the spring's force since the last swing down
        # whether the slider has been FASTER times as fast as the drive since, by more than chance
        ("rushed", np.bool_),
        ("slipping", np.bool_),  # whether it is a slip
        ("before_slip", np.int64),  # number of all breaks before the slip
        # a stick: the slider is held while the spring's force rises
        ("stuck", np.bool_),  # whether the slider has stuck since the last slip
        ("stuck_at", np.float64),  # X where it last did
        ("held", np.int64),  # number of contacts that held there
        ("loose", np.int64),  # breaks since it last stuck
        # from where on the slider may be sticking
        ("rest", np.float64),  # X there
        ("rest_force", np.float64),  # the spring's force there
        ("rest_breaks", np.int64),  # number of all breaks up to there
        # the spring's lowest force since a contact broke or formed, and X there
        ("lowest", np.float64),
        ("lowest_at", np.float64),
        # with heat: the time now, the sum of all levels, its integral until the next proposal, and the number of draws
        ("now", np.float64),
        ("total", np.float64),
        ("budget", np.float64),
        ("draws", np.int64),
    ]
)


class BreakPlaces(NamedTuple):
    """Contacts: a place ahead of which, and one behind which, the slider breaks each of them."""

    ahead: Nearest
    behind: Nearest  # with the opposite sign
    out: npt.NDArray[np.int32]  # numbers of those that wait for their return
    waits: Array  # time between each break that waits and the one before, a ring
    ages: Ages  # thresholds that grow, by number; one that forms again takes any that is free


class PullWithMass(NamedTuple):
    """The drive, the slider's constants for n contacts, and arrays for the results."""

    n: int
    spring: float  # K/(N <k>)
    per_mass: float  # N <k>/M
    damping: float  # γ/(N <k>)
    rate: float  # γ/M
    mean: float  # threshold at which k_i = <k>; 0 if all k_i are equal
    wait: float  # the delay, below 0 if there is none
    slip_fraction: float  # least breaks in a slip, per contact that held where the slider stuck
    least_breaks: Array  # number of contacts that at least break in a slip, on each leg
    room: float  # way in which a slider sticks
    rise: float  # of the spring's force per N <k> meanwhile
    chance: Array  # by which that force falls by chance at most, on each leg
    most_breaks: int
    places: Array  # X_T where each leg of the drive begins
    speeds: Array  # its speed on each leg
    lasts: Array  # the time that it takes
    begins: Array  # when it begins
    age: float  # of contacts as they form at X = 0
    at_points: Array  # (9, legs), at the end of each leg
    swing: Array  # (8,), the present swing down of the spring's force, or the next one, of which the begin is known
    slipped: Array  # (8,), the last one that was a slip
    falls: Whole  # numbers of falls outside of slips in which 1, 2-3, 4-7, ... contacts broke
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
def time_now(s, pull):  # type: ignore[no-untyped-def]
    """The time since the slider rested at X = 0."""
    return pull.begins[unsigned(s.leg)] + s.elapsed


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
def speed_limit(drive):  # type: ignore[no-untyped-def]
    """The speed above which the spring's force falls. A drive that moves back to its first point counts as at rest."""
    return max(drive, 0.0)


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
    s.budget -= s.total * t
    s.due -= t
    s.since += t
    s.clock += t
