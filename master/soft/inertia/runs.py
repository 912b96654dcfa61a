"""Runs of a slider with mass, with ever smaller tolerances, until the forces of the last two agree.

The error is twice their difference (SAFETY), and what both may miss alike (UNSEEN). That of the share that holds, which
contacts with a delay leave and come back to when a slip comes, and those of energies are told, and not asked for.
"""

from typing import NamedTuple

import numpy as np

from master.outcome import Progress
from master.soft.inertia.body import QUIET
from master.soft.inertia.delayed.small_swings import UNRESOLVED
from master.soft.inertia.energy_errors import (
    PARTS,
    UNKNOWN,
    EnergyError,
    Unseen,
    Ways,
    energy_errors,
)
from master.soft.inertia.growing_swings import GrowingSwings
from master.soft.inertia.heat_left_out import beside_slips
from master.soft.inertia.reaction import ALIKE
from master.soft.inertia.run import OF_PANELS, Differences, Run, times_apart
from master.survival.life import ALL_ATOMS
from origins import Contacts
from origins.drive import Drive

# Tolerances of the runs, in units of the one that is asked for: each run shows the error of the one before, and errors
# fall about in proportion.
TOLERANCES = 10.0, 2.0, 0.4, 0.08, 0.016
# And of a run by which the first is judged where a finer one is stopped, in units of that of the first: as far apart.
COARSER = 5.0
# Parts of a run's tolerance that both runs may miss alike, so that their difference does not show them: panels, forces
# taken as those of contacts of which none breaks or of steady breaks, and ringing that is taken as rest.
UNSEEN = OF_PANELS + ALIKE + QUIET
# Times the difference of two runs in the error: errors fall less regularly than tolerances, and with a delay births
# repeat those of breaks (in 1 of 63 random machines with a delay, and 1 of 100 without, the difference alone was 1.1 to
# 2.3 times too small).
SAFETY = 2.0
# And part of a run's tolerance that its error is at least told with: both runs may agree by chance (of 64 random
# machines with a delay one was off by 0.09 of it, and 2.7 times what both differed by; of 110 without one by 0.085).
LEAST_ERROR = 0.1
# The same part for the share that holds, of which a panel's error is no part, as new contacts bear no force: of 40
# random machines with a delay one was off by 0.43 of the run's tolerance.
LEAST_OF_SHARE = 1.0
# Times the errors of the load and of forces at slips where contacts catch a slider anywhere in its swing
# (Run.caught_anywhere): the next slip begins at random then, and runs may agree by chance (of eight on a scan with a
# delay of 1.4 s, any two differed by 4e-5 to 2.1e-3, whatever their tolerances; of 233 pairs of runs of 23 drawn
# machines 6 told up to 8 times too little without it, none with it).
CAUGHT_SAFETY = 10.0
# Smallest tolerance of a run, in mean thresholds: below it all is rounding.
LEAST = 1e-11
# Tolerance of exact thresholds beside others, where none smaller is asked for, and the factor on the error as their
# runs tell it: contacts that form again at once break at ever new places, and F falls there by ever smaller parts, of
# which a coarse run passes over those that decide on a slip. (Of 70 random machines at 1e-2 to 1e-4 the errors of 12
# were told too small, up to 60 times; of 21 at 1e-6 those of 4, up to 60 times, too; of 33 others at 1e-6 none: there
# the true error was 0.6 of the one before the factor at most, and 0.06 as a rule.)
OF_EXACT, EXACT_SAFETY = 1e-6, 100.0


class HeatLeftOut(NamedTuple):
    """What heat that is left out changes in the contacts' force at most (a length), and the error of the spring's force
    by it (mean thresholds)."""

    effect: float = 0.0
    error: float = 0.0


class Runs(NamedTuple):
    """The last two runs of those that were followed to their end, or the first one alone.

    errors : of the last one, estimates from above by what it differs from the one before, inf where there is none
    nodes : of all runs; stopped : why a run was not followed to its end, "" where all were
    parting : where the two part, in words
    factor : on what the two differ in, beside SAFETY
    """

    best: Run
    coarser: Run
    errors: Differences
    nodes: int
    stopped: str
    parting: str
    factor: float

    def energy_error(
        self, drive: Drive, of_force: float, beside: float, of_contacts: float
    ) -> EnergyError:
        """Errors of the energies of the last run, by what they differ from those of the one before.

        of_force, beside : of the spring's force as it is told, see Unseen (lengths)
        of_contacts : of the contacts' force, by what no run shows (a length)
        """
        best, coarser = self.best, self.coarser
        if not np.isfinite(beside) or best is coarser:
            return UNKNOWN
        ours, theirs, slips = best.energy(), coarser.energy(), best.slips(0.0)
        n = min(ours.drive.size, theirs.drive.size)
        off = {name: np.abs(getattr(ours, name)[:n] - getattr(theirs, name)[:n]) for name in PARTS}
        changes = {name: self.factor * SAFETY * float(each.max()) for name, each in off.items()}
        path = np.append(best.balance, drive.path)
        forces = np.append(best.force, slips.force_before)
        ways = Ways.of(path, slips.after - slips.before, best.spring, forces, best.unit)
        apart = times_apart(slips, coarser.slips(0.0), coarser.slips(0.0))
        by_time = ways.largest * ways.per_spring * best.unknown_fall(slips, apart)
        at_begin = best.unit * best.unknown_hold(slips, apart)
        on_the_way = self.factor * QUIET * best.tolerance * best.unit + of_contacts
        unseen = Unseen(of_force, beside, on_the_way, by_time, at_begin)
        return energy_errors(changes, ours, unseen, ways)


def _errors(best: Run, other: Run, earlier: Run | None, allowed: float) -> Differences:
    """Errors of the run `best` by what it differs from another; see Run.differ. `allowed` : the tolerance of one of
    them (mean thresholds)."""
    unseen, least = UNSEEN * allowed, LEAST_ERROR * allowed
    differ = best.differ(other, earlier)
    errors = Differences(*(max(SAFETY * off + unseen, least) for off in differ))
    if best.caught_anywhere:
        by_chance = (CAUGHT_SAFETY - 1.0) * errors.force_and_load
        errors = errors._replace(
            force=errors.force + by_chance, force_and_load=errors.force_and_load + by_chance
        )
    return errors._replace(holding=min(max(errors.holding, LEAST_OF_SHARE * allowed), 1.0))


def run_ever_finer(
    contacts: Contacts,
    drive: Drive,
    tolerance: float,
    until: float,
    progress: Progress,
    grows: GrowingSwings | None,
    heat: HeatLeftOut,
) -> Runs:
    """Runs until their difference and the heat that is left out are within the tolerance together; the first one is so
    fine that swings of steady sliding that grow are none of errors.

    Exact thresholds beside others are followed to OF_EXACT.
    """
    unit = contacts.mean_threshold
    mixed = 0.0 < contacts.thresholds.atoms[1].sum() < ALL_ATOMS
    sought = min(tolerance / EXACT_SAFETY, OF_EXACT) if mixed else tolerance
    coarsest = TOLERANCES[0] * sought
    first = grows.coarsest(coarsest) / coarsest if grows else 1.0
    parts, nodes = [first * part for part in TOLERANCES], 0
    while True:
        best = Run(contacts, drive, sought, parts.pop(0), until)
        nodes += best.nodes
        if best.stopped != UNRESOLVED or not parts:
            break
    coarser, stopped, parting = best, best.stopped, ""
    errors, before_last = Differences(*(np.inf,) * len(Differences._fields)), np.inf
    for part in parts:
        of_swings = best.goes_on.force / unit if best.goes_on is not None else 0.0
        # what heat that is left out may change no run lessens
        room = sought - heat.error - beside_slips(best, drive, heat.effect).force / unit
        enough = errors.force + of_swings <= (room if room > 0.0 else sought)
        in_vain = best.caught_anywhere and errors.force_and_load > before_last
        if stopped or enough or in_vain or part * sought < LEAST:
            break
        before, earlier, run = best, coarser, Run(contacts, drive, sought, part, until)
        nodes, stopped = nodes + run.nodes, run.stopped
        if not stopped:
            best, coarser, before_last = run, before, errors.force_and_load
            errors = _errors(best, before, earlier, part * sought)
            parting = run.parting(before, (sought - UNSEEN * part * sought) / SAFETY)
            progress(errors.force)
    if stopped and coarser is best and not best.stopped:
        # what the first run has found is told by the error of a coarser one, which is larger
        allowed = COARSER * first * coarsest
        run = Run(contacts, drive, sought, allowed / sought, until)
        nodes += run.nodes
        if not run.stopped:
            coarser, errors = run, _errors(best, run, None, allowed)
    factor = EXACT_SAFETY if mixed else 1.0
    errors = Differences(*(factor * error for error in errors))
    return Runs(best, coarser, errors, nodes, stopped, parting, factor)
