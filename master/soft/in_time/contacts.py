"""All contacts of a slider in steps of time: where a step would lead them, and the steps taken.

With B(t) the breaks per contact since t = 0, J(t) the births, and E(t, s) the survival of contacts born at s, number
conservation says (docs/equations.md)

    G_0(t) + integral of E(t, s) dJ(s) + [B(t) - J(t)] = 1,        J(t) = B(t - delay).

Contacts are independent: the survival of those born at one instant depends on the motion since and on nothing else.
They are represented by a cohort born at the end of each step, and each cohort by one group for each stretch at which
contacts form again. Within a step the rate of births is taken as constant: half of its births belong to the cohort at
its begin, half to that at its end, of second order in the step.
"""

import numpy as np

from master.numerics.averages import StretchNodes, stretch_nodes
from master.outcome import FaultError, StoppedError, stop_after
from master.renewal.births import reforming_law
from master.soft.in_time.breaks import BirthsUpTo, BreaksInSteps
from master.soft.in_time.groups import (
    UNACCOUNTED,
    Groups,
    Trial,
    check_number,
    divided_by_survival,
    steady_groups,
    survivals_at_birth,
)
from master.soft.in_time.memory import Memory
from master.soft.in_time.unresolved import (
    OF_BIRTHS,
    OF_STEADY_SLIP,
    Unresolved,
    unknown_force_of_births,
)
from origins import Contacts
from origins.thresholds.law import Array

# Nodes for the stretches at which contacts form again, where these are many, on the coarsest steps, and those more with
# each halving, so that their error shows.
FORMED_NODES, MORE_FORMED_NODES = 8, 4
# Survival below which a group is dropped: its force is below round-off even if there are a thousand of them.
DEAD = 1e-19
# Most steps, and most operations in them: a minute or less. A group costs as many operations in a step as numbers in
# its record and FIXED_WORK. A step of a slip, one trial, counts as OF_SLIP: others try four or more for their balance.
# An interval of a flight, in closed form, counts as OF_FLIGHT, one that is repeated, without any work, as OF_REPEATED.
MOST_STEPS, MOST_WORK, FIXED_WORK, OF_SLIP, OF_FLIGHT, OF_REPEATED = 8e3, 1e9, 60, 0.25, 0.05, 0.05
# An error estimate needs as many sliders, each with its steps halved once more, so that the coarser ones may take only
# a part of that.
COMPARED = 3


class ContactsInSteps:
    """Contacts on a slider, from X = 0 and t = 0 on, which re-form one delay after they break.

    `trial` says where any step would lead and changes nothing; `take` takes it. Which steps are taken, what force is
    balanced and what a slip does is up to the caller: nothing here knows a spring.

    position, now, force, holding : X (a length), the time, F/(N_c <k>) (a length), the fraction that holds
    past_breaks : those at the ends of all steps, and what will be born of them
    are_new : whether all contacts stand as after a reset, so that what comes does not depend on what was
    unit, jumps, until : mean threshold (a length), whether P_c may jump, and as given
    largest_stiffness : k_i/<k> of the stiffest contacts
    halvings : how often steps are halved; steps, cost, work : those taken so far, by OF_SLIP, and operations in them
    unresolved : errors of F that finer steps may not show; those who find one note it

    births : J up to now; _births_in_cohorts : the same by the weights of all cohorts, which are to agree
    _left_out : share of all contacts in groups that were left out while they held
    _of_start : so many groups are of the contacts at t = 0 or a reset; they stand first, then cohort after cohort
    """

    def __init__(self, contacts: Contacts, memory: Memory, halvings: int, until: float) -> None:
        """All contacts at the beginning; `until` is a reading of time.monotonic() at which to stop."""
        self.memory, self.until = memory, until
        self.delay = contacts.waiting_time
        self.halvings, self.steps, self.cost, self.work = halvings, 0, 0.0, 0.0
        self.position, self.now, self.unresolved = 0.0, 0.0, Unresolved()
        self.unit = contacts.mean_threshold
        self.largest_stiffness = float(contacts.relative_stiffness(memory.largest_stretch))
        law, ends = contacts.thresholds, contacts.thresholds.breakpoints
        self.jumps = bool((law.pdf(ends[ends > 0.0]) > 0.0).any())
        start = stretch_nodes(contacts.start, memory.largest_stretch, memory.starts)
        most = FORMED_NODES + MORE_FORMED_NODES * halvings
        reformed = stretch_nodes(reforming_law(contacts), memory.largest_stretch, most)
        # the groups of a cohort, by the stretches at its birth
        self._at_birth = divided_by_survival(memory, reformed)
        self._survival_at_birth = survivals_at_birth(memory, reformed.stretch)
        # part of all births that is in cohorts: at stretches that no contact bears contacts break as they form
        self._part_in_cohorts = float(reformed.weight[self._survival_at_birth > 0.0].sum())
        count = reformed.stretch.size
        self._newest, self._last_two = slice(-count, None), slice(-2 * count, None)
        # weights in the last two cohorts per contact born in a step: half of its births belong to the cohort at its
        # begin, half to that at its end
        self._per_birth = 0.5 * np.tile(self._at_birth.weight, 2)
        at_start, at_birth = divided_by_survival(memory, start), self._at_birth
        record, fresh = memory.start(start.stretch), memory.fresh(at_birth.stretch, 0.0)
        self._replace_all(at_start, record)
        pairs = zip((*at_start, record), (*at_birth, fresh), strict=True)
        self.are_new = all(np.array_equal(*pair) for pair in pairs)

    def relax(self) -> None:
        """Replace all contacts, also those that are out, by those just formed again."""
        self._replace_all(self._at_birth, self.memory.fresh(self._at_birth.stretch, 0.0))
        self.are_new = True

    def decohere(self, along: StretchNodes, sign: float) -> None:
        """Replace all contacts by those with these stretches along the motion, which is of this sign, and with
        thresholds of fresh ones that bear them."""
        stretches = along._replace(stretch=sign * along.stretch)
        record = self.memory.start(stretches.stretch)
        self._replace_all(divided_by_survival(self.memory, stretches), record)

    def slide_to(
        self, position: float, now: float, velocity: float, step: float, life: float = np.inf
    ) -> None:
        """Be there at this time after long steady sliding at this velocity, along which a cohort was born on each
        `step`, and none is left beyond a `life` (lengths)."""
        self.position, self.now = position, now
        groups = steady_groups(self.memory, self._at_birth, velocity, life, step)
        self._begin_with(groups, abs(velocity))

    def stored_at(self, speed: float, step: float, life: float) -> float:
        """Energy of the contacts in steady sliding at this speed (length squared); arguments as those of `slide_to`."""
        return steady_groups(self.memory, self._at_birth, speed, life, step).stored(self.memory)

    def _replace_all(self, start: StretchNodes, record: Array) -> None:
        """Set these contacts in place of all others, as if no contact had broken before."""
        self._begin_with(Groups(start.stretch, np.abs(start.stretch), start.weight, record), 0.0)

    def _begin_with(self, groups: Groups, speed: float) -> None:
        """The same of groups, on a slider of this speed |dX/dt|."""
        sums = groups.survival_and_force(self.memory)
        self.holding, self.force = (sums @ groups.weight).tolist()
        self.are_new, self._of_start = False, groups.stretch.size
        # the cohort at the begin of the first step, whose size tells the slider's speed
        self.groups = groups.and_born(self.memory, self._at_birth, 0.0, speed)
        self.past_breaks = BreaksInSteps(self.delay, self.now)
        self.past_breaks.repeat_bend(self.now)  # before there were no breaks
        self.births = self._births_in_cohorts = self._left_out = 0.0

    def trial(self, travel: float, end: float, without_births: bool = False) -> Trial:
        """A step by `travel` until the time `end`; `without_births`, broken contacts stay out. StoppedError as `take`.

        Number conservation at its end, with J_0 the births before it, is

            kept + survival (J - J_0) + B - J = 1,        J = per_break B + rest,

        with `kept` the share of all that hold at its begin and end, and `survival` that of those born in it; so that,
        with broken_of_new = 1 - survival,

            B (1 - broken_of_new per_break) = 1 - kept + survival J_0 + broken_of_new rest.

        For `per_break` and `rest` see BirthsUpTo. None form, J = J_0, with a delay in a step of no time, as none ends
        in it; without one in a step so fast that contacts break as they form.
        """
        stop_after(self.until)  # the search for a step may need hundreds of trials
        duration = end - self.now
        speed = abs(travel) / duration if duration > 0.0 else np.inf
        groups = self.groups.moved(self.memory, travel, duration)
        groups = groups.and_born(self.memory, self._at_birth, 0.0, speed)
        sums = groups.survival_and_force(self.memory)
        kept, force_of_kept = (sums @ groups.weight).tolist()
        # of those born in this step, per contact born: survival and force at its end
        survival, force_of_new = (sums[:, self._last_two] @ self._per_birth).tolist()
        per_break, rest = BirthsUpTo(0.0, self.births)
        nothing_forms = (end == self.now) if self.delay else (survival <= 0.0)
        if not (without_births or nothing_forms):
            per_break, rest = self.past_breaks.births_up_to(begin=self.now, end=end)
            # No birth is taken back, although an earlier step may have told too many (see births_up_to). J is `rest`
            # alone where per_break = 0. Else J = p B(end) + (1 - p) B(begin) >= B(begin) takes none back, as breaks
            # never fall, and `rest`, a part of J, is no bound: without a delay, say, it is 0.
            if not per_break:
                rest = max(rest, self.births)
        broken_of_new = 1.0 - survival  # of those born in this step, per contact born
        breaks = 1.0 - kept + survival * self.births + broken_of_new * rest
        # 1 - broken_of_new per_break, in a form that keeps its digits where hardly any of those born hold
        breaks /= (1.0 - per_break) + survival * per_break
        new = per_break * breaks + rest - self.births
        force, holding = force_of_kept + force_of_new * new, kept + survival * new
        return Trial(travel, end, groups, sums, force, holding, breaks, self.births + new, kept)

    def take(self, trial: Trial, size: float) -> None:
        """Take the step, of this size (0 in a slip): its groups, with the births in it, become those of the contacts;
        the trial stays as it is. StoppedError where there are too many steps."""
        sums, weight = trial.survival_and_force, trial.groups.weight.copy()
        begin, self.are_new = self.now, False
        self.steps, part = self.steps + 1, 1.0 if size else OF_SLIP
        self.cost += part
        self.work += part * weight.size * (self.memory.work + FIXED_WORK)
        self._stop_at_limits()
        new = (trial.births - self.births) * self._per_birth
        weight[self._last_two] += new
        self._births_in_cohorts += float(new @ np.tile(self._survival_at_birth, 2))
        trial.groups.check_largest(trial.end)
        self.past_breaks.add(trial.end, trial.breaks, size)
        self.past_breaks.check_births(begin, trial.end, trial.births, trial.births - self.births)
        self.position, self.now = self.position + trial.travel, trial.end
        self.force, self.holding = trial.force, trial.holding
        holding, force = (sums @ weight).tolist()
        self._check_number(trial.births, holding)
        trial.check(holding, force, self.position, self.memory.largest_stretch)
        of_cohorts = slice(self._of_start, None)
        count = self._at_birth.stretch.size
        unknown = unknown_force_of_births(weight[of_cohorts], sums[:, of_cohorts], count)
        self.unresolved.note(OF_BIRTHS, unknown, self.now)
        groups = self._without_dead(trial.groups._replace(weight=weight), sums[0])
        self.groups = groups.without_negligible_cohorts(self._of_start, count)
        self.births = trial.births

    def _check_number(self, births: float, holding: float) -> None:
        """See check_number."""
        formed, expected = births * self._part_in_cohorts, 1.0 + births - self.past_breaks.total
        place = f"after t = {self.now:.6g}, X = {self.position:.6g}"
        check_number(births, (formed, self._births_in_cohorts), (expected, holding), place)

    def _without_dead(self, groups: Groups, survival: Array) -> Groups:
        """The groups of which some contacts hold; all groups of a cohort go together. The last cohort stays, as it
        shares the births of the next step. FaultError where groups go of which more than UNACCOUNTED of the contacts
        hold: at the next step these would count as broken, which _check_number cannot see."""
        count = self._at_birth.stretch.size
        alive = survival > DEAD
        cohorts = survival[self._of_start :].reshape(-1, count)
        alive[self._of_start :] = np.repeat(cohorts.max(axis=1) > DEAD, count)
        alive[self._newest] = True
        self._left_out += float(survival[~alive] @ groups.weight[~alive])
        if self._left_out > UNACCOUNTED:
            raise FaultError(
                f"number is not conserved: until t = {self.now:.6g}, X = {self.position:.6g} a share "
                f"{self._left_out:.6g} of the contacts was left out while it held, a fault of the program"
            )
        self._of_start = int(np.count_nonzero(alive[: self._of_start]))
        return groups.pick(alive)

    def slide_steadily(self, travel: float, error: float) -> None:
        """Slide on at this instant, by the travel on which the spring relaxes to F: breaks are followed by births, and
        stretches stay distributed as they are. `error` bounds what F changes on the way (a length)."""
        self.position += travel
        self.unresolved.note(OF_STEADY_SLIP, error, self.now)

    @property
    def most_steps(self) -> float:
        """As many as leave finer steps, by which the error is known, below MOST_STEPS."""
        return MOST_STEPS * 0.5 ** max(COMPARED - 1 - self.halvings, 0)

    def fly_to(self, position: float, now: float, size: float, holding: float) -> None:
        """Be there at this time, after a way of this size on which those that were due formed, and all broke but this
        share; `land` comes behind the last one. StoppedError as `take`."""
        before, births = self.now, self.past_breaks.births_up_to(begin=self.now, end=now).rest
        births = max(births, self.births)
        breaks = 1.0 + births - holding
        self.past_breaks.add(now, breaks, size)
        self.past_breaks.check_births(before, now, births, births - self.births)
        self._births_in_cohorts += self._part_in_cohorts * (births - self.births)
        self.births, self.position, self.now = births, position, now
        self.holding, self.force = holding, 0.0
        self.cost += OF_FLIGHT
        self._stop_at_limits()

    def land(self, groups: Groups) -> None:
        """Set these in place of all contacts, behind a flight on which they formed."""
        self.groups, self._of_start = groups.and_born(self.memory, self._at_birth, 0.0, 0.0), 0
        sums = self.groups.survival_and_force(self.memory)
        holding, self.force = (sums @ self.groups.weight).tolist()
        self._check_number(self.births, holding)

    def repeat(self, steps: int, now: float) -> None:
        """Go to this time in as many steps as new contacts took before, and replace all; StoppedError as `take`."""
        self.steps, self.cost, self.now = self.steps + steps, self.cost + OF_REPEATED * steps, now
        self._stop_at_limits()
        self.relax()

    def take_back_early_births(self) -> None:
        """Behind a slip in which all broke: births are the breaks one delay before, of which a step may have told more
        (see births_up_to). Held back until then, none would pull, and the slider would slip again and again."""
        told = self.past_breaks.births_up_to(begin=self.now, end=self.now).rest
        early = self.past_breaks.take_back(self.births - told)
        self.births -= early
        self._births_in_cohorts -= self._part_in_cohorts * early

    def _stop_at_limits(self) -> None:
        """Raise StoppedError after too many steps, or too much work in them."""
        part = self.most_steps / MOST_STEPS
        if self.cost > self.most_steps or self.work > MOST_WORK * part**2:
            ends = f"{self.steps - 1} steps lead to t = {self.now:.4g}"
            raise StoppedError(f"{ends}, and more are not taken, however much time there is")

    def form_due(self) -> None:
        """Let all contacts that broke together one delay ago form now, as a cohort of their own."""
        fraction = self.past_breaks.take_due(self.now)
        if fraction > 0.0:
            # what those lose that pin on a moving slider, the first, short step of the next section tells
            self.groups = self.groups.and_born(self.memory, self._at_birth, fraction, speed=0.0)
            new = self.groups.pick(self._newest)
            holding, force = (new.survival_and_force(self.memory) @ new.weight).tolist()
            self.holding, self.force = self.holding + holding, self.force + force
            self.births += fraction
            self._births_in_cohorts += float(new.weight @ self._survival_at_birth)
            self._check_number(self.births, self.holding)
        if fraction:
            self.past_breaks.check_repeated(self.births)
