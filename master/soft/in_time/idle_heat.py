"""Heat that does next to nothing: what it changes in the force at most, and whether it is left out.

Where barriers are some 1e5 k_BT, contacts break by heat only in a skin below their thresholds that is thinner than the
cells of thresholds which a Memory has. Steps in time would then leave heat out without a word.
"""

from typing import NamedTuple

import numpy as np

from master.soft.in_time.memory import Memory
from origins import Contacts, Drive
from origins.thresholds.law import Array

# Heat is left out where it changes the force by less than this part of the tolerance.
IDLE = 0.1
# Fraction of the contacts that heat breaks before their stretch is near the threshold, in tolerances, which is allowed
# for beside those that it breaks near there.
EARLY = 1e-3
# The same where heat is not left out, as a number.
WHOLE_EARLY = 1e-6
# Thresholds and distances to them at which rates are compared; the distances are a tenth apart.
THRESHOLDS, DISTANCES = 4000, np.geomspace(1.0, 1e-12, 300)
# Most contacts that are weaker than the first threshold, or stronger than the last.
TAIL = 1e-9
# Cells that nearly resolve the skin may also give heat too much effect: up to twice the largest in all cases tried.
WRONG_EFFECT = 3.0
# Allowance for what comes after the first breaks; see `largest_effect`.
LATER = 2.0


# How often steps are halved where most answers end: heat that its cells resolve is followed, however little it does.
USUAL_HALVINGS = 2


class Idle(NamedTuple):
    """Contacts without the heat that was left out, what that changes in the force (mean thresholds), and a message."""

    contacts: Contacts
    error: float = 0.0
    message: str = ""


def without_idle_heat(contacts: Contacts, drive: Drive, duration: float, tolerance: float) -> Idle:
    """The contacts without heat, where its skin is too thin for the cells and its effect is far below the tolerance."""
    effect = largest_effect(contacts, drive, duration, EARLY * tolerance)
    if not effect < IDLE * tolerance or Memory(contacts, USUAL_HALVINGS).resolves_heat:
        return Idle(contacts)
    note = f"; heat is left out: it changes the force by at most {effect:.1e} mean thresholds"
    return Idle(contacts.replace(thermal=None), effect, note)


def unresolved_heat(contacts: Contacts, memory: Memory, drive: Drive, duration: float) -> float:
    """The error of the force (mean thresholds) due to heat that the memory's cells do not resolve, 0 where they do."""
    if memory.resolves_heat:
        return 0.0
    return WRONG_EFFECT * largest_effect(contacts, drive, duration, WHOLE_EARLY)


def largest_effect(contacts: Contacts, drive: Drive, duration: float, early: float) -> float:
    """What heat changes in the force within this duration, in mean thresholds; inf where nothing is known.

    Let y(x_s) be the largest stretch up to which the rate of a contact, times the duration, stays below `early`: no
    more than this fraction of such contacts breaks before y, and all have broken at x_s. Until contacts break a second
    time the force from X on relaxed contacts is then X times a survival between that of thresholds y and that of x_s:
    it is lower than without heat by at most X P(y < X < x_s), plus what the early ones bear, X `early`.

    Later breaks come earlier by as much. If y = (1 - e) x_s for all thresholds, all lengths are smaller by 1 - e, and
    K X_T of each slip by e K X_T: hence the factor of the loads along the drive's path, in mean thresholds, and another
    factor of 2 as e differs between thresholds. The latter is an allowance, not a theorem.
    """
    thermal, law = contacts.thermal, contacts.thresholds
    others = {"grains", "ageing"}.intersection(contacts.laws)
    if thermal is None or thermal.closure == "paper" or others or law.atoms[0].size:
        return np.inf
    unit = contacts.mean_threshold
    threshold = law.isf(np.linspace(1.0 - TAIL, TAIL, THRESHOLDS))
    threshold = np.maximum(threshold, 1e-12 * unit)
    near = _last_quiet_stretch(contacts, threshold, np.log(early / max(duration, 1e-300)))
    lost = float((near * (law.sf(near) - law.sf(threshold))).max()) / unit
    travel = float(np.abs(np.diff(drive.path, prepend=0.0)).sum()) / unit
    loads = 1.0 + min(float(drive.spring or 0.0), 1.0) * travel
    return LATER * loads * (lost + early + TAIL)


def _last_quiet_stretch(contacts: Contacts, threshold: Array, log_rate: float) -> Array:
    """The largest of some stretches up to which each contact breaks at a lower rate than this, 0 for none."""
    assert contacts.thermal is not None
    stiffness = np.asarray(contacts.relative_stiffness(threshold))
    stretch = threshold * (1.0 - DISTANCES[:, None])
    with np.errstate(all="ignore"):
        rate = contacts.thermal.rates.log_rate(stretch, threshold, stiffness)
    quiet = np.logical_and.accumulate(rate < log_rate, axis=0)
    last = quiet.sum(axis=0) - 1
    return np.where(last >= 0, stretch[last, np.arange(threshold.size)], 0.0)
