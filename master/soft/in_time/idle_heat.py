"""Heat that steps in time do not resolve: what it changes in the force at most, and whether it is left out.

Where barriers are some 1e5 k_BT, contacts break by heat only in a skin below their thresholds that is thinner than the
cells of thresholds which a Memory has. Steps in time would then leave heat out without a word.

The bound is about one force, that at a given X. With y(x_s) the stretch from which on heat may break a contact, S the
survival function of thresholds and n the generations of breaks until sliding is steady (`largest_effect`),

    effect = n^(1/2) (max over x_s of y [S(y) - S(x_s)] + mean of x_s - y) / <x_s>,
    error  = effect (1 + K [way of the drive]/<x_s>), K in N_c <k>, 1 at most: the drive's path repeats the effect.

In: contacts with heat (lengths), for how long it acts on them at most (`duration`, a time), and the drive. Out: `Idle`,
contacts without heat or as they were, and the effect, in mean thresholds like all errors here.

An example, which a test computes: P_c(1, 0.1), heat ("soft", 1e-5, 1e6), the duration 10. A contact of the threshold 1
is quiet up to y = 0.99968: its rate there, times the duration, is below 1e-6, and above at the next stretch that is
looked at, 0.99971. The largest loss is 0.00130, births come earlier by 0.00032, in all 0.00162; times the root of n =
5.9, the effect is 0.0040. `master.solve` of a rigid slider with and without this heat, along 10 mean thresholds,
differs by 0.00013. On that way at K = 0.2 the error is 0.0119.
"""

from typing import NamedTuple

import numpy as np

from master.numerics.averages import stretch_nodes
from master.renewal.births import reforming_law
from master.soft.in_time.memory import NO_THRESHOLD, Memory, ThresholdMemory, cold_nodes
from master.survival.age.extent import narrowest
from origins import Contacts, Drive
from origins.thresholds.law import Array

# Heat is left out where it changes the force by less than this part of the tolerance.
PART_OF_TOLERANCE = 0.1
# Heat that steps do not resolve is left out, too, where it changes the force by less than this, in mean thresholds:
# slips without it still tell the regime. Steps would not know the force any better.
WEAK_EFFECT = 0.1
# Spring, in N_c <k>, on which hardly any contact holds on after a slip. On stiffer ones, under "reform-after", it
# depends on where a slip begins which contacts break in it, and a bound on the force does not bound that.
SOFT_SPRING = 0.03
# Heat may break each contact anywhere near its threshold; farther from it, at most this fraction of the contacts, which
# is `early` of largest_effect. It adds to the effect, and a smaller one makes "near" wider. Where the effect is to be
# far below the tolerance, it is this part of that; where the effect itself is told, this small number.
EARLY_OF_TOLERANCE, EARLY_OF_CONTACTS = 1e-3, 1e-6
# How many thresholds there are at which rates are looked at, and the distances of stretches from each of them, in that
# threshold; from one to the next the distances fall by a tenth.
THRESHOLDS, DISTANCES = 4000, np.geomspace(1.0, 1e-12, 300)
# Most contacts that are weaker than the first threshold, or stronger than the last.
TAIL = 1e-9
# Cells that nearly resolve the skin may also give heat too much effect: up to twice the largest in all cases tried.
WRONG_EFFECT = 3.0
# Allowance for births that come earlier where contacts that form again may be stiffer than those that broke.
STIFFER = 4.0
# How often steps are halved where most answers end: heat that its cells resolve is followed, however little it does.
USUAL_HALVINGS = 2
# How often at most: heat that even these cells do not resolve is not followed.
MOST_HALVINGS = 5


class Idle(NamedTuple):
    """Contacts without the heat that was left out, and what the message says before the error.

    effect : of this heat on the force of relaxed contacts at a given X, at most (mean thresholds)
    repeats : how often such an effect adds up along the drive's path
    """

    contacts: Contacts
    effect: float = 0.0
    repeats: float = 1.0
    message: str = ""

    @property
    def error(self) -> float:
        """What leaving it out changes in the force along the path, at most (mean thresholds)."""
        return self.effect * self.repeats


def without_idle_heat(contacts: Contacts, drive: Drive, duration: float, tolerance: float) -> Idle:
    """The contacts without heat, where its skin is too thin for the cells, and its effect is far below the tolerance or
    so weak that the answer without it is known better than steps would know it."""

    def missed_by_cells(halvings: int) -> bool:
        return not ThresholdMemory(contacts, halvings).resolves_heat

    # asked first, as it takes least: heat that the usual cells resolve is resolved by the finer ones, too
    if contacts.changing is not None or not missed_by_cells(USUAL_HALVINGS):
        return Idle(contacts)
    repeats = repeats_of_effect(contacts, drive)
    idle = Idle(contacts.replace(thermal=None), 0.0, repeats)
    idle = idle._replace(effect=largest_effect(contacts, duration, EARLY_OF_TOLERANCE * tolerance))
    if idle.error < PART_OF_TOLERANCE * tolerance:
        return idle._replace(message="heat is left out: it changes the force by at most")
    idle = idle._replace(effect=largest_effect(contacts, duration, EARLY_OF_CONTACTS))
    # without heat such contacts are followed without steps
    stepless = not {"delay", "reforming"}.intersection(contacts.laws)
    if drive.slip == "reform-after":
        stepless &= float(drive.spring or 0.0) < SOFT_SPRING
    if stepless and idle.error < WEAK_EFFECT and missed_by_cells(MOST_HALVINGS):
        note = "heat is left out, as steps in time miss it: it may change the force by up to"
        return idle._replace(message=note)
    return Idle(contacts)


def without_weak_heat(contacts: Contacts, drive: Drive, duration: float) -> Idle:
    """The contacts without heat, where it changes the force by less than WEAK_EFFECT, for a slider with mass, which at
    T = 0 is followed without steps in time; else as they are, with its effect."""
    effect = largest_effect(contacts, duration, EARLY_OF_CONTACTS)
    idle = Idle(contacts, effect, repeats_of_effect(contacts, drive))
    if not idle.error < WEAK_EFFECT:
        return idle
    note = "heat is left out beside a mass: it may change the force by up to"
    return idle._replace(contacts=contacts.replace(thermal=None), message=note)


def or_without_heat(contacts: Contacts, duration: float) -> str:
    """Words for who may leave heat out, and by how much the force before a slip is off then; "" where that is
    WEAK_EFFECT or more. It is no bound along a path of many slips, where it adds up: heat is not left out unasked."""
    effect = largest_effect(contacts, duration, EARLY_OF_CONTACTS)
    if not effect < WEAK_EFFECT:
        return ""
    changes = f"changes the force of new contacts, and so that before a slip, by at most {effect:.1e} mean thresholds"
    return f", or leave out contacts.thermal, which {changes}"


def unresolved_heat(contacts: Contacts, memory: Memory, drive: Drive, duration: float) -> float:
    """The error of the force (mean thresholds) due to heat that the memory's cells do not resolve, 0 where they do."""
    if memory.resolves_heat:
        return 0.0
    effect = largest_effect(contacts, duration, EARLY_OF_CONTACTS)
    return WRONG_EFFECT * effect * repeats_of_effect(contacts, drive)


def repeats_of_effect(contacts: Contacts, drive: Drive) -> float:
    """How often the drive's path loads contacts up to slips, at least 1: K X_T of each slip is as much off as the force
    before it, and so is what comes after."""
    travel = float(np.abs(np.diff(drive.path, prepend=0.0)).sum()) / contacts.mean_threshold
    return 1.0 + min(float(drive.spring or 0.0), 1.0) * travel


def largest_effect(contacts: Contacts, duration: float, early: float) -> float:
    """What heat changes in the force at a given X within this duration, in mean thresholds; inf where nothing is known.

    Let y(x_s) be the largest stretch up to which the rate of a contact, times the duration, stays below `early`: no
    more than this fraction of such contacts breaks before y, and all have broken at x_s. Until contacts break a second
    time the force from X on relaxed contacts is then X times a survival between that of thresholds y and that of x_s:
    it is lower than without heat by at most X P(y < X < x_s), plus what the early ones bear, X `early`. Of contacts
    born at the stretch r, whose thresholds lie beyond |r|, it is this by 1/P(x_s > |r|).

    Births come earlier by the mean of x_s - y, which is more where the weakest break at once. If y = (1 - e) x_s for
    all thresholds, all lengths are smaller by 1 - e, and F at X differs by e (X F' - F): from one generation of
    breaks to the next X grows in proportion to their number n, and the slopes of F fall as n^(-1/2) until after
    mean^2/(2 pi^2 std^2) of them F is steady. Hence the root of that number. What comes after the first breaks is
    an allowance, not a theorem; in some hundred cases of nine laws on rigid sliders, at temperatures from 1e-8 to 1e-4
    <x_s^2>, the largest true effect was 0.25 of the result, with linked stiffness 0.75.
    """
    thermal, law = contacts.thermal, contacts.thresholds
    applies = thermal is not None and thermal.closure == "exact" and contacts.changing is None
    if not applies or law.atoms[0].size:
        return np.inf
    unit = contacts.mean_threshold
    threshold = law.isf(np.linspace(1.0 - TAIL, TAIL, THRESHOLDS))
    threshold = np.maximum(threshold, NO_THRESHOLD * unit)
    log_rate = np.log(early / duration) if duration > 0.0 else np.inf
    quiet_until = _last_quiet_stretch(contacts, threshold, log_rate)  # y(x_s), a length
    stiffness = np.maximum(contacts.relative_stiffness(threshold), 1.0)
    # X P(y < X < x_s) at the X at which contacts of each threshold are no longer quiet, y = X
    lost = quiet_until * (law.sf(quiet_until) - law.sf(threshold)) * stiffness
    # and at larger X, beyond the largest y: P(x_s > X), as heat may break all contacts there before their thresholds
    lost_beyond = (threshold * law.sf(threshold) * stiffness)[threshold > quiet_until[-1]]
    # a travel of the slider, on which F rises by as much at most
    births_earlier_by = float((threshold - quiet_until).mean())
    births_earlier_by *= STIFFER if contacts.stiffness == "linked" else 1.0
    most_lost = max(float(lost.max()), float(lost_beyond.max(initial=0.0))) + births_earlier_by
    generations = 1.0 + (unit / narrowest(law)) ** 2 / (2.0 * np.pi**2)
    lost_of_born = _most_lost_of_born(contacts, most_lost / unit)
    return float(np.sqrt(generations) * (lost_of_born + early + TAIL))


def _most_lost_of_born(contacts: Contacts, lost: float) -> float:
    """A force lost by relaxed contacts (mean thresholds), for contacts that begin or form again at their stretches."""
    law, unit = contacts.thresholds, contacts.mean_threshold
    strongest = float(law.isf(TAIL))
    bounds = [lost]
    for born in (contacts.start, reforming_law(contacts)):
        nodes = stretch_nodes(born, strongest, cold_nodes(0))
        holding = np.maximum(law.sf(np.abs(nodes.stretch)), TAIL)
        bounds.append(float(np.minimum(lost / holding, strongest / unit) @ nodes.weight))
    return max(bounds)


def _last_quiet_stretch(contacts: Contacts, threshold: Array, log_rate: float) -> Array:
    """The largest of some stretches up to which each contact breaks at a lower rate than this, 0 for none."""
    assert contacts.thermal is not None
    stiffness = np.asarray(contacts.relative_stiffness(threshold))
    stretch = threshold * (1.0 - DISTANCES[:, None])
    with np.errstate(all="ignore"):
        rates = contacts.thermal.rates
        rate = np.maximum(
            rates.log_rate(stretch, threshold, stiffness),
            rates.log_rate(-stretch, threshold, stiffness),
        )
    quiet = np.logical_and.accumulate(rate < log_rate, axis=0)
    last = quiet.sum(axis=0) - 1
    return np.where(last >= 0, stretch[last, np.arange(threshold.size)], 0.0)
