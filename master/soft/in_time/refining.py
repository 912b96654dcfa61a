"""Refining: the whole path solved again and again, with steps halved each time, until force and holding are known."""

import time
from typing import Any

import numpy as np

from master.motion import Motion, drive_motion
from master.outcome import FaultError, Progress, StoppedError
from master.soft.followed import Followed
from master.soft.in_time.answer.extrapolation import extrapolated
from master.soft.in_time.changing import memory_by_law
from master.soft.in_time.contacts import COMPARED, MOST_STEPS, MOST_WORK, ContactsInSteps
from master.soft.in_time.creep import creep_of, may_creep
from master.soft.in_time.decohered import decohered
from master.soft.in_time.idle_heat import or_without_heat
from master.soft.in_time.memory import MeanRateMemory, Memory, ThresholdMemory
from master.soft.in_time.slider import Slider
from master.soft.in_time.steps import CONTROL
from master.soft.in_time.unresolved import OF_BIRTHS
from origins import Contacts, Drive
from origins.errors import refuse

# A drive that begins this near the balance, in mean thresholds, begins there: the difference is rounding.
AT_BALANCE = 1e-12
# Slips in which F changes by less than this part of the tolerance are not listed.
UNLISTED = 1.0 / 3.0
# A delay is too long to be followed where the drive moves by this many mean thresholds in it, and the spring's force
# rises by this part of one: in all of 8 cases with thresholds 1 +- 0.2 steps had no answer, below in none of 5.
LONG_DELAY, LOADED = 30.0, 8e-3
# The same with heat that leaves most relaxed contacts up to the first slip: of 8 cases with 100 and 0.1 or more, T =
# 0.01 and 0.05 <x_s>², 6 had no answer after 2,000 coarsest steps, 2 none in 8 s; with 30 and 0.3 both were solved.
LONG_IN_HEAT, LOADED_IN_HEAT = 100.0, 0.09
# Springs, in N_c<k>, below which contacts that age are not followed beyond their static force under "instant": of 50
# drawn machines below, D = 1e-5 to 0.1 <x_s>v, none had an answer to 1e-3 or 1e-2 after 4 to 8 s; of 19 on springs of
# 1e-3 to 1e-2 two had.
SOFT_FOR_AGED = 1e-3
# What a refusal says that holds under each slip rule.
NO_SLIP_YET = "no slip has come by then"
# Thresholds at which the first breaks are looked at.
QUANTILES = 2000
# The next halving takes twice the steps, each of which has twice the groups, and where cells get finer, too, as many
# times the work of this one as this one took of the last; and errors below this many times that of the memory are not
# made smaller by it.
MORE_STEPS, MORE_WORK, NEAR_MEMORY_ERROR = 2.0, 4.0, 2.0

# Of contacts that age under "instant", with each halving: the factor on the work, by which the unknown force of births
# falls, and on what that leaves in the end, as steps have an error, too (K = 1e-6, D = 1e-4 to 1e-2: 5.5 to 5.9, 3.4 to
# 4.2, 1.1 to 1.4).
WORK_OF_HALVING, UNKNOWN_FALL, MARGIN = 6.0, 3.5, 1.2


def memory_of(
    contacts: Contacts, halvings: int, fastest: float, motion: Motion | None = None
) -> Memory:
    """The memory of contacts on a drive of at most this speed, and of this motion; its meshes are made for steps halved
    so often. Raises InputError for a law by which thresholds change that has neither a memory nor a life."""
    if contacts.changing is not None:
        return memory_by_law(contacts, halvings, fastest, motion)
    if contacts.thermal is not None and contacts.thermal.closure == "paper":
        return MeanRateMemory(contacts, halvings)
    return ThresholdMemory(contacts, halvings)


def balance_of(contacts: Contacts, drive: Drive) -> float:
    """X_T = F(0)/K, where the drive begins (a length); refuses a path in time that begins elsewhere."""
    start = ContactsInSteps(contacts, memory_of(contacts, 0, 1.0), 0, np.inf)
    balance = start.force / float(drive.spring or 0.0)
    if abs(drive.path[0] - balance) <= AT_BALANCE * contacts.mean_threshold:
        return float(drive.path[0])
    if drive.time is not None and drive.time[0] == 0.0:
        hint = f"at time 0 the drive stands where it balances the start, {balance:.9g}"
        refuse("path[0]", drive.path[0], hint)
    return balance


def refined(
    contacts: Contacts,
    drive: Drive,
    balance: float,
    tolerance: float,
    progress: Progress,
    until: float,
) -> Followed:
    """Slips, and force and holding at the points of the path, on finer and finer steps.

    until : reading of time.monotonic() at which to stop

    Raises InputError where the coarsest steps take too long.
    """
    if time.monotonic() <= until:
        refuse_long_slides(contacts, drive)
        refuse_long_delays(contacts, drive)
        refuse_slips_of_the_aged(contacts, drive)
    motion, asked = drive_motion(drive, balance), drive.arrival_times(balance)
    fastest = 0.0 if motion is None else float(np.abs(motion.speeds).max())
    slowest = slowest_stuck(drive, motion)
    sliders, best, halvings = list[Slider](), None, 0
    creep = creep_of(contacts, drive, motion, tolerance, until)
    while True:
        memory = memory_of(contacts, halvings, fastest, motion)
        memory.resolve_creep(slowest)
        needed = halvings_needed(memory, drive, tolerance)
        cohorts = ContactsInSteps(contacts, memory, halvings, until)
        least_drop = UNLISTED * tolerance * contacts.mean_threshold
        after_long_slips = decohered(contacts, drive, memory.starts, tolerance)
        slider = Slider(cohorts, drive, motion, needed, least_drop, after_long_slips, creep)
        try:
            slider.run()
        except StoppedError as why:
            if best is None:
                if time.monotonic() <= until and not isinstance(why, FaultError):
                    hint = f"end the path sooner{or_without_heat(contacts, float(asked[-1]))}"
                    seen = f": {NO_SLIP_YET}" * (not slider.slips)
                    refuse("path[-1]", drive.path[-1], f"{why}{seen}; {hint}")
                asked = asked[asked <= cohorts.now]
                best = extrapolated([slider], contacts, drive, balance, asked)
            return best._replace(stopped_because=str(why))
        sliders = [*sliders[-2:], slider]
        if halvings == 1 and memory.error_of_slips and drive.slip == "instant":
            refuse_unknown_births(cohorts, tolerance)
        found = extrapolated(sliders, contacts, drive, balance, asked)
        if slider.creeps_from is not None:
            found = found._replace(**_creeping(slider, motion))
        progress(found.error_of_force_and_load)
        if best is None or found.largest_error <= best.largest_error:
            best = found
        before = sliders[-2:][0].contacts.work  # the first slider's own, as long as it is alone
        more_work = max(MORE_WORK, cohorts.work / before if before else 0.0)
        steps, work = MORE_STEPS * cohorts.cost, more_work * cohorts.work
        as_good_as_memory = found.largest_error < NEAR_MEMORY_ERROR * memory.error
        too_many = steps > MOST_STEPS or work > MOST_WORK
        if best.largest_error <= tolerance or as_good_as_memory:
            return best
        if too_many:
            many = f"{steps:.0f} steps, above {MOST_STEPS:.0f}"
            what = many if steps > MOST_STEPS else f"{work:.1e} operations, above {MOST_WORK:.0e}"
            return best._replace(stopped_because=f"steps are not halved again, which takes {what}")
        halvings += 1


def _creeping(slider: Slider, motion: Motion | None) -> dict[str, Any]:
    """What is to be said of a slider that creeps steadily to the end of its path, and the position of the drive from
    which on its force is that of steady sliding."""
    if motion is None or slider.creeps_from is None:
        return {}
    since, end = motion.at(np.array([slider.creeps_from, motion.times[-1]])).tolist()
    steady_from = end + motion.speeds[-1] * (slider.steady_from - motion.times[-1])
    note = f"from X_T = {since:.6g} on it creeps, at the speed at which F is that of steady sliding"
    return {"note": note, "steady_from": float(steady_from)}


def slowest_stuck(drive: Drive, motion: Motion | None) -> float:
    """The lowest speed of a slider that sticks to a drive which moves; inf where it never does."""
    speeds = np.abs([] if motion is None else motion.speeds)
    spring = float(drive.spring or 0.0)
    return spring / (1.0 + spring) * float(speeds[speeds > 0.0].min(initial=np.inf))


def halvings_needed(memory: Memory, drive: Drive, tolerance: float) -> int:
    """Halvings without which a path with slips does not meet the tolerance."""
    least = COMPARED - 1
    if not memory.error_of_slips or drive.slip != "instant":
        return least
    more = np.log(memory.error_of_slips / tolerance) / np.log(memory.fall_of_slips)
    return least + max(int(np.ceil(more)), 0)


def refuse_unknown_births(contacts: ContactsInSteps, tolerance: float) -> None:
    """InputError where contacts that age, on steps that were halved once, slide under "instant" so far that births of a
    step, of which many break before its end, stay unknown by more than the tolerance on the finest steps there may be.
    That is told before these are taken: they take ten times as long as all before."""
    by_work = np.log(MOST_WORK / contacts.work) / np.log(WORK_OF_HALVING)
    by_steps = np.log2(MOST_STEPS / contacts.cost)
    halvings = max(int(min(by_work, by_steps)), 0)
    unknown = contacts.unresolved.error_of(OF_BIRTHS) / contacts.unit
    least = MARGIN * unknown / UNKNOWN_FALL**halvings
    if least > tolerance:
        fault = f"of contacts that age F would be known to some {least:.1e} at best, with the finest steps,"
        where = 'where the slider slides with its drive under "instant"'
        hint = 'loosen it, or take slip = "reset"'
        refuse("tolerance", tolerance, f"{fault} {where}; {hint}")


def refuse_long_slides(contacts: Contacts, drive: Drive) -> None:
    """InputError where a slider under "instant" slides with its drive for longer than the coarsest steps may take.

    Each travel of the drive by one step is a step; only the way that the slider goes in a slip takes none. With heat F
    falls less at higher speeds, so that it slips far once at most, before X_T = F/K. From relaxed contacts F is at most
    <x_s^2>/<x_s>, by Lorden's inequality of renewal theory: behind X_T = <x_s^2>/(<x_s> K) all of the path takes steps.
    """
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.stiffness == "independent"
    if drive.slip != "instant" or not (relaxed and contacts.laws == ("thermal",) and drive.forward):
        return
    if may_creep(contacts, drive_motion(drive, 0.0)):
        return
    law, memory = contacts.thresholds, memory_of(contacts, 0, 1.0)
    latest = law.moment(2) / law.mean() / float(drive.spring or 0.0)
    distance = float(drive.path[-1]) - latest
    steps = distance / (CONTROL.coarsest * memory.scales.length)
    most = MOST_STEPS * 0.5 ** (COMPARED - 1)
    if steps > most:
        goes = f'by {distance:.3g} or more with its drive under "instant", in {steps:.2g} steps'
        hint = f"end the path before {latest + distance * most / steps:.4g}"
        refuse("path[-1]", drive.path[-1], f"the slider goes {goes}, above {most:.2g}; {hint}")


def refuse_slips_of_the_aged(contacts: Contacts, drive: Drive) -> None:
    """InputError where contacts that age are pulled beyond their static force under "instant" by a soft spring.

    They creep far before a slip, and behind a long one F is that of fresh contacts, on which it seeks its balance in
    many small slips. From relaxed contacts, as long as none has formed anew, a share S(x) of them bears x: at most the
    largest x S(x) of fresh thresholds and of old ones. Others, and those with linked stiffness, are not refused here.
    """
    ageing, spring = contacts.ageing, float(drive.spring or 0.0)
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.stiffness == "independent"
    alone = contacts.laws == ("ageing",) and relaxed
    if ageing is None or drive.slip != "instant" or not alone or spring >= SOFT_FOR_AGED:
        return
    shares = (np.arange(QUANTILES) + 0.5) / QUANTILES
    static = max(
        float((law.isf(shares) * shares).max()) for law in (contacts.thresholds, ageing.final)
    )
    furthest = float(np.abs(drive.path).max())
    if spring * furthest > static:
        fault = f"contacts that age are followed up to their static force on springs below {SOFT_FOR_AGED}"
        hint = f'take slip = "reset", or end the path before |X_T| = {static / spring:.4g}'
        refuse(
            "slip",
            drive.slip,
            f"{fault} N_c<k>, and the path leads to |X_T| = {furthest:.4g}; {hint}",
        )


def refuse_long_delays(contacts: Contacts, drive: Drive) -> None:
    """InputError where slips follow each other too fast: contacts that broke shortly before a slip come back one after
    another behind it, hold the slider, and let it slip again, for as long as the delay.

    From relaxed contacts F(X) begins as the force of those that have not broken, X S(X), plus that of those born since,
    so that F' is 1 - X P_c(X) as long as none breaks twice. If that falls below -K, the first slip comes before
    X_T = <x_s^2>/(<x_s> K), as in `refuse_long_slides`.
    """
    law, spring, unit = contacts.thresholds, float(drive.spring or 0.0), contacts.mean_threshold
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.stiffness == "independent"
    distance = drive.velocity * contacts.waiting_time
    hot = contacts.thermal is not None
    long, loaded = (LONG_IN_HEAT, LOADED_IN_HEAT) if hot else (LONG_DELAY, LOADED)
    follows = drive.slip == "reset" or drive.time is not None or not drive.forward
    short = distance < long * unit or spring * distance < loaded * unit
    latest = law.moment(2) / law.mean() / spring
    alone = set(contacts.laws) <= {"thermal", "delay"}
    if follows or short or not (alone and relaxed) or drive.path[-1] < latest:
        return
    if contacts.thermal is not None:
        rate = float(contacts.thermal.rates.rate(0.0, law.isf(0.5), 1.0))
        if rate * latest > drive.velocity:
            return
    x = law.isf((np.arange(QUANTILES) + 0.5) / QUANTILES)
    if law.atoms[0].size or float((x * law.pdf(x)).max()) <= 1.0 + spring:
        return
    fault = f"contacts come back one by one for a delay after a slip, in which the drive moves by {distance / unit:.3g}"
    most = f"mean thresholds; that is followed up to {max(long, loaded / spring):.3g}"
    if hot:
        most = f"mean thresholds; in heat that takes too many steps from {max(long, loaded / spring):.3g} on"
    hint = f'end the path before {latest:.4g}, shorten the delay, or take "reset"'
    refuse("path[-1]", drive.path[-1], f"{fault} {most}; {hint}")
