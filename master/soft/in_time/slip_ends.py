"""Where a slip ends: at a balance, to which the slider moves while the drive holds; this takes no time.

On a soft spring a slip is as long as F/K, a million thresholds on a spring of 1e-6 N_c <k>. The work depends on the way
until breaks are steady, or until nothing holds any more; the rest of a slip is algebra.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.decohered import Decohered, SlipSoFar
from master.soft.in_time.groups import UNACCOUNTED
from master.soft.in_time.steps import CONTROL, Node, Steps
from master.soft.in_time.unresolved import OF_BALANCE

# Travels, in halves of the length over which births change, that are tried for the begin of a slip: with heat F may
# rise at first, as the weakest have broken.
FIRST_TRAVELS = (0.003, 0.01, 0.03, 0.1, 0.4, 1.0)
# Travel of a slip that none of them begins, next to none: with births a part of the slider's step, which is halved from
# one slider to the next; without, in lengths over which births change.
NO_SLIP_OF_STEP, NO_SLIP = 1e-4, 6e-6
# Accuracy of a slip's end, in mean thresholds: that of rounding.
AT_END = 1e-15
# Shortest step in the search for the end of a slip without births, in lengths over which births change: two balances
# that are nearer to each other are not told apart.
SHORTEST_STEP = 0.06
# Travel, in mean thresholds, along which F has to stay the same for breaks to be steady; and the largest change of F on
# it, in mean thresholds, which is part of the error.
STEADY_TRAVEL, STEADY = 1.0, 1e-6


def slip_without_births(contacts: ContactsInSteps, steps: Steps) -> None:
    """Move the slider to the first balance; broken contacts stay out until then, or for their delay.

    Breaks lower F, so that it rises at most with the stiffness of the contacts that still hold. Where the spring pulls
    more by d no balance is nearer than d/(K + that stiffness): steps of this length miss none, but for two that are
    nearer to each other than SHORTEST_STEP. Where nothing holds any more one of them leads to the end, X = X_T, where
    all contacts form again at once, as in a reset. With a delay those that broke stay out for it, whether others hold
    or not, and births repeat the jump of the breaks a delay later.

    An example, which a test computes: half of the thresholds are around 0.5, half around 2, K = 0.5, and the slider
    slips from X = 0 with X_T = 2. At X = 1 the weak are out: the spring pulls by 0.5 (2 - 1), and F = 0.5 * 1.
    """
    contacts.past_breaks.begin_section()
    travel, imbalance = travel_to_balance(contacts, steps)
    contacts.take(contacts.trial(travel, contacts.now, without_births=True), 0.0)
    _check_balance(contacts, steps, imbalance)
    if not (contacts.holding or contacts.delay):
        return contacts.relax()
    if contacts.delay and contacts.holding < UNACCOUNTED:
        contacts.take_back_early_births()
    contacts.past_breaks.repeat_jump(contacts.now)
    contacts.form_due()


def _check_balance(contacts: ContactsInSteps, steps: Steps, imbalance: float) -> None:
    """FaultError unless the forces differ by this imbalance (a length) where a slip has just ended."""
    end = Node(0.0, contacts.now, contacts.force, contacts.holding, contacts.position)
    steps.check_balance("a slip", imbalance, end)


def travel_to_balance(contacts: ContactsInSteps, steps: Steps) -> tuple[float, float]:
    """The travel to the first balance of a slip without births (a length, of either sign), and the imbalance there."""
    length = contacts.memory.length_in_slips
    shortest = SHORTEST_STEP * length

    def imbalance(travel: float) -> float:
        return steps.imbalance(contacts.trial(travel, contacts.now, without_births=True))

    first = _first_travel(imbalance, 0.5 * steps.sign * length)
    if not first:
        next_to_none = NO_SLIP * steps.sign * length
        return next_to_none, imbalance(next_to_none)
    low = high = first
    while True:
        trial = contacts.trial(high, contacts.now, without_births=True)
        pull = steps.imbalance(trial)
        if pull <= 0.0:
            return balance_between(imbalance, low, high, contacts)
        stiffest = steps.spring + contacts.largest_stiffness * trial.holding
        low, high = high, high + steps.sign * max(pull / stiffest, shortest)


def balance_between(
    imbalance: Callable[[float], float], low: float, high: float, contacts: ContactsInSteps
) -> tuple[float, float]:
    """The travel of a slip to the balance between two travels, and the imbalance left there (lengths).

    With heat F may jump where |x| passes the edge of a cell of thresholds, as A is read off the edges ahead of |x|. A
    balance may lie at such a jump: what is left of the imbalance there counts as an error of F, which falls with the
    cells.
    """
    travel = float(brentq(imbalance, low, high, xtol=AT_END * contacts.unit))
    left = imbalance(travel)
    contacts.unresolved.note(OF_BALANCE, abs(left), contacts.now)
    return travel, left


def slip_with_births(
    contacts: ContactsInSteps, steps: Steps, size: float, decohered: Decohered | None
) -> bool:
    """Move the slider to the first balance, in steps of this size; broken contacts re-form at once. Returns whether it
    was so long that its breaks were steady, or all contacts were replaced by those to which that leads. It ends

    - at once, as good as, where no small travel leads to a pull of the spring;
    - on the first step at whose end the spring pulls no more, once the slider is away from the balance at the begin;
    - at K (X_T - X) = F, however far, once breaks are steady: F then stays that of sliding at infinite speed;
    - there, too, once it is sure that breaks will be steady before: some way after all contacts are `decohered`.
    """
    # travels are of the sign of X here, so that a slip backward has negative ones
    length = contacts.memory.length_in_slips
    step_travel, near = size * steps.sign * CONTROL.coarsest * length, 0.5 * length
    so_far = SlipSoFar(contacts, steps.sign)

    def imbalance(travel: float) -> float:
        return steps.imbalance(contacts.trial(travel, contacts.now))

    first = _first_travel(imbalance, steps.sign * near)
    if not first:
        trial = contacts.trial(NO_SLIP_OF_STEP * step_travel, contacts.now)
        pull = steps.imbalance(trial)
        contacts.take(trial, 0.0)
        _check_balance(contacts, steps, pull)
        return False
    # a travel on the next step at which the slider still moves on: the slip ends between it and the step's end
    low = first
    # Whether the slider is already past the balance at which the slip began, as it is where a step goes beyond `first`.
    # An example: the slip begins at X = 0, pulls are above 0 from X = 0.002 on, and the step is 0.001. The first step
    # ends where the pull is still below 0; taken for a balance, that would end the slip where it began.
    away = abs(first) < abs(step_travel)
    begin = contacts.position
    while True:
        trial = contacts.trial(step_travel, contacts.now)
        pull = steps.imbalance(trial)
        if pull <= 0.0 and away:
            break
        away |= pull > 0.0 or abs(contacts.position - begin) > near
        contacts.take(trial, 0.0)
        low = 0.0
        so_far.add(contacts, pull)
        to_end = pull / steps.spring  # the way on which the spring relaxes if F stays what it is
        error = _error_of_rest(so_far, to_end, contacts.unit, decohered)
        if error is not None:
            contacts.slide_steadily(steps.sign * to_end, error)
            _check_balance(contacts, steps, 0.0)
            return True
        if decohered and np.isinf(so_far.decohered_since) and decohered.is_sure(so_far):
            # steps of finite size have a steady force a little off F_k. The steps after the slip would seek it anew, as
            # further small slips, so that F is let go there first.
            contacts.decohere(decohered.start, steps.sign)
            so_far.decohered_since = so_far.travelled[-1]
    at_end = imbalance(low)
    if at_end > 0.0:
        low, at_end = balance_between(imbalance, low, step_travel, contacts)
    else:  # contacts that were replaced by decohered ones right before may bear more than the spring pulls
        contacts.unresolved.note(OF_BALANCE, abs(at_end), contacts.now)
    contacts.take(contacts.trial(low, contacts.now), 0.0)
    _check_balance(contacts, steps, at_end)
    return bool(np.isfinite(so_far.decohered_since))


def _error_of_rest(
    slip: SlipSoFar, to_end: float, unit: float, decohered: Decohered | None
) -> float | None:
    """What F changes by at most (a length) on the rest of a slip, `to_end`, where it may be taken as it is; None where
    the slip has to be followed."""
    if to_end > unit * STEADY_TRAVEL and _steady(slip.travelled, slip.forces, unit):
        return STEADY * unit
    if decohered and decohered.ends_by_now(slip):
        return decohered.swing(slip)
    return None


def _first_travel(imbalance: Callable[[float], float], furthest: float) -> float:
    """The first of some small travels, up to the furthest, from which the slider moves on; 0 for none."""
    travels = furthest * np.array(FIRST_TRAVELS)
    return next((float(travel) for travel in travels if imbalance(travel) > 0.0), 0.0)


def _steady(travelled: list[float], forces: list[float], unit: float) -> bool:
    """Whether F has hardly changed along the last mean threshold."""
    begin = travelled[-1] - STEADY_TRAVEL * unit
    if begin < 0.0 or abs(forces[-1] - forces[-2]) > STEADY * unit:
        return False
    recent = forces[int(np.searchsorted(travelled, begin)) :]
    return max(recent) - min(recent) <= STEADY * unit
