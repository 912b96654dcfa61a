"""Where a slip begins: where a longer step would end earlier.

        τ |          . - o - .           o  the fold, where the slip begins
          |       .             .        left of it the slider moves on as the drive does
          |    .                   .     right of it a longer step would end earlier: time does not go back
          |  .                       .
        0 +----------------------------> s

A balanced step of the size s takes τ(s) time units, and the rest, s - τ(s), is its travel. τ rises from τ(0) = 0 as
long as the slider needs the drive to move on; where τ is the largest it needs no more, and slips. This lies within a
step of the size s, or just beyond, on one of three conditions (`SlipBegins._has_slip`):

- no balance after a step of this size: τ(s) <= 0, the spring pulls more than contacts bear there. A shorter step may
  have one: the slip begins where τ is the largest, and at once where it is below 0 for all;
- where P_c jumps, F falls beyond: τ(1.01 s) < τ(s). τ has a kink there, and no fold before it;
- elsewhere a fold within, τ' = 0 before s: τ(0.99 s) >= τ(s), so that the last 0.01 s is all travel, and takes no time
  or less.

τ(0.99 s) need not be solved for. With I(s, τ) the imbalance at the end of a step of the size s of which τ is time,
I(s, τ(s)) = 0; and I rises with τ. Hence τ(0.99 s) >= τ(s) if and only if I(0.99 s, τ(s)) <= 0: one trial tells.

Before contacts at an exact threshold break, the last balance is taken where it comes later than the largest τ found.

Of contacts that heat breaks long before their thresholds, by which sizes of steps are chosen, more than half may break
on one step. Then F falls as the travel grows, though the slider creeps on: half of the births count as those at the
step's begin, which are gone, and half as those at its end, which have no stretch yet. It would be a slip by the third
condition. So a slip is believed only on a step short enough to resolve the breaks; once one was not, all steps are.
Contacts at exact thresholds break together on any step, however short: there a slip is believed at once.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from master.soft.in_time.contacts import Trial
from master.soft.in_time.steps import CONTROL, FIRST_FRACTION, Root, Steps
from master.soft.in_time.unresolved import OF_BALANCE
from origins.thresholds.numerical import clipped


class OnsetControl(NamedTuple):
    """Numbers of the search for a slip; none has a unit.

    onset : accuracy of the begin of a slip, in sizes of steps: X_T is flat there, or has a kink.
    last_jump : accuracy of a size at which exact thresholds break, in sizes: F jumps there, so it is that of rounding.
    beyond_jump : factor on the size of the step that looks beyond a jump of P_c, where F falls at once.
    far_from_slip : times `StepControl.drive_weight` w: the part of a step's size above which, if it is time, no fold is
        looked for. Of a slider that is stuck to the drive w/(1 + w) of each step is time, and more where heat or a hold
        adds time units. A fold that is not looked for is met on the next step, which then has no balance.
    before_fold : factor on the size of the step that tells on which side of a fold a step ends.
    least_shrink : steps that become finer towards a slip, or to resolve breaks, are not below this factor on their
        size, as a slip that is foreseen may not come, and at a jump of P_c any step breaks many contacts.
    believed : times the e-folds of contacts that break on a step which resolves breaks, `StepControl.e_folds`, up to
        which a slip on a step is believed. Above 1, so that a step cut to that is, and half a step need not follow.
    """

    onset: float = 1e-9
    last_jump: float = 1e-14
    beyond_jump: float = 1.01
    far_from_slip: float = 0.3
    before_fold: float = 0.99
    least_shrink: float = 0.03
    believed: float = 1.5


ONSET = OnsetControl()


class SlipBegins:
    """The search for a slip along the steps of smooth sections.

    What changes from step to step, and who changes it; all but `size` outlives a step, `_resolves_breaks` and the slope
    also a section. For a slider with steps of 1/4, say, `Slider.slide` asks for the size 1/4 * shrink:

        name                  what it is                      set by                            reset by
        size                  of the step that is looked for  up_to_slip: cut at the section's  each call of up_to_slip,
                                                              end, or halved to resolve breaks  to what is asked for
        shrink                factor on the next step's size  _foresee: less than 1 near a      begin_section, _foresee:
                                                              slip; up_to_slip: to resolve      to 1, before it is set
                                                              breaks, the smaller of both
        _resolves_breaks      whether steps are to resolve    up_to_slip: a slip on one that    nobody
                              the breaks on them              did not was not believed
        _guess.time_fraction  part of the next size that is   _foresee, by the last two steps;  begin_section: to
                              time, where a search begins     _solve_along_motion, turned       FIRST_FRACTION
                                                              round; _last_before_exact
        _guess.slope          of imbalance over time units    solve: that of the last search    nobody
        _last_time_fraction   part of the last size that was  _foresee                          begin_section: to nan,
                              time                                                              unknown
        Steps.sign            direction in which travel is    _solve_along_motion, by           Steps.begin_section: to
                              above 0                         Steps.turn_round                  drive's, in a hold F's
    """

    def __init__(self, steps: Steps) -> None:
        """Before the first section."""
        self.steps, self._guess = steps, steps.first_guess
        self._resolves_breaks = False
        self.begin_section()

    def begin_section(self) -> None:
        """At the begin of a section nothing is foreseen; only the slope is still a good guess."""
        self.shrink, self._guess = 1.0, self._guess._replace(time_fraction=FIRST_FRACTION)
        self._last_time_fraction = np.nan

    def solve(self, size: float) -> Root:
        """Solve for the balanced step of this size, and keep its slope: the next search begins with it. The order of
        searches changes a root by its accuracy alone, `Memory.balance`."""
        root = self.steps.step(size, self._guess)
        self._guess = self._guess._replace(slope=root.slope)
        return root

    def _solve_along_motion(self, size: float) -> Root:
        """Solve for the balanced step of this size as `solve` does; where the slider runs against the motion on it,
        turn `Steps.sign` round and solve again. Else such a step, cut at the section's end, may have a size below 0,
        and no slip can be looked for on it.

        The first balance may have been one far back, beyond contacts that break on the way. The second search then ends
        at a near one, which lies along the first sign again: hence up to two turns."""
        steps = self.steps
        root = self.solve(size)
        for _ in range(2):
            trial = root.step.trial
            if not steps.runs_back(trial):
                break
            steps.turn_round()
            self.begin_section()
            near = min(max(steps.travelled(trial) / size, 0.0), FIRST_FRACTION)
            self._guess = self._guess._replace(time_fraction=1.0 - near)
            root = self.solve(size)
        return root

    def _chosen(self, root: Root, slips: bool) -> Trial:
        """Where the step leads that will be taken. Its imbalance is an error of F: one that is not small shows that the
        search has not converged, or has ended by a slope that is far off. Up to a slip a converged step leads to the
        fold, beyond which there may be no balance: its imbalance is no error."""
        contacts = self.steps.contacts
        if not (slips and root.converged):
            contacts.unresolved.note(OF_BALANCE, abs(root.step.imbalance), contacts.now)
        return root.step.trial

    def up_to_slip(self, size: float) -> tuple[Trial, bool]:
        """The balanced step of this size, or a shorter one that resolves breaks, or that up to a slip that begins
        within it; and whether one does.

        An example: thresholds 1 ± 0.1 with heat ("soft", 0.001, 1), K = 0.3, a slip at t = 3.507. Steps of the size 1
        lead from 2.890 to 3.060, 3.225, 3.375 and 3.484: they take less and less time, as contacts break. The next of
        that size would take 0.009 time units, one of the size 0.6 takes 0.029: a fold is within. The one that takes the
        most time ends at 3.508: the slip begins there. Of the slider with two halvings, steps have the size 1/4: 3.463,
        3.484, 3.499, 3.507, and the slip at 3.5074. The next size is that of the slider times `shrink`, which stays 1.
        A test computes these numbers.

        With the heat a hundred times as strong, more than half of the contacts may break on a step. If a tenth is kept
        on one of the size 1, 2.3 e-folds break, and steps of 0.5/2.3 = 0.22 resolve that (`resolving_factor`). If the
        one of the size 1 looks like a slip, that is not believed; those of 1/2 and 1/4 are tried, and the last is
        believed, as 1/4 < 1.5 * 0.22. From then on steps have the size 0.22 where so many break.
        """
        steps, own_size = self.steps, 0.5**self.steps.contacts.halvings
        while True:
            asked = self._solve_along_motion(size)
            step = asked.step
            if step.trial.end > steps.contacts.now:  # it may have been cut at the section's end
                size = min(size, steps.size(step.trial))
            resolving_factor = self.resolving_factor(step.trial, size)
            if not self._has_slip(asked, size):
                self._foresee(step.time_part / size, size)
                if self._resolves_breaks:
                    self.shrink = min(self.shrink, resolving_factor)
                return self._chosen(asked, slips=False), False
            if steps.contacts.memory.exact or size <= ONSET.believed * resolving_factor * own_size:
                break
            size *= 0.5
            self._resolves_breaks = True
        longest_size = self._search_up_to(asked, size)
        begin = self._at_fold(size, longest_size)
        if steps.contacts.memory.exact:
            before_exact = self._last_before_exact(size, longest_size)
            if before_exact is not None and before_exact.step.trial.end > begin.step.trial.end:
                begin = before_exact
        trial = self._chosen(begin, slips=True)
        # at the section's end, a slip may still be to come
        return trial, trial.end < steps.section_end

    def _has_slip(self, root: Root, size: float) -> bool:
        """Whether a slip begins on this step, which has this size, or just beyond: on the three conditions at the head
        of this file, in that order."""
        if not root.has_balance:
            return True
        if self.steps.contacts.jumps:
            return self._falls_beyond(root, size)
        return self._has_fold(root, size)

    def _falls_beyond(self, root: Root, size: float) -> bool:
        """Whether a longer step takes less time, τ(1.01 s) < τ(s), as F falls at once where P_c jumps."""
        # the time of this step is its size less its travel, also if it was cut
        time_part = size - self.steps.travelled(root.step.trial)
        return self.solve(ONSET.beyond_jump * size).step.time_part < time_part

    def _has_fold(self, root: Root, size: float) -> bool:
        """Whether a fold lies before the end of this step: τ(0.99 s) >= τ(s), or I(0.99 s, τ(s)) <= 0."""
        time_part = root.step.time_part
        if time_part > ONSET.far_from_slip * CONTROL.drive_weight * size:
            return False
        before = self.steps.tried(ONSET.before_fold * size, time_part, root.slope)
        return before.imbalance <= 0.0

    def _search_up_to(self, root: Root, size: float) -> float:
        """The longest step that may lead to the slip on this one: where F falls beyond a jump, a longer one."""
        falls_beyond = root.has_balance and self.steps.contacts.jumps
        return ONSET.beyond_jump * size if falls_beyond else size

    def _foresee(self, time_fraction: float, size: float) -> None:
        """Guess the next step from this one's fraction of time, and how far a slip is, where it falls to 0.

        Steps become finer near a slip of contacts that age, or grow with heat, see `Memory.nearing`: thresholds
        cross |x| step by step, and the slip would depend on where those steps end. The way to the slip is counted in
        the coarsest steps, so that sliders with halved ones shrink theirs by the same factor.
        """
        change = float(np.nan_to_num(time_fraction - self._last_time_fraction))
        self._last_time_fraction = time_fraction
        self._guess = self._guess._replace(time_fraction=time_fraction + change)
        self.shrink = 1.0
        nearing = self.steps.contacts.memory.nearing
        if change < 0.0 and np.isfinite(nearing):
            sizes_to_slip = -time_fraction * size / change
            self.shrink = min(max(nearing * sizes_to_slip, ONSET.least_shrink), 1.0)

    def resolving_factor(self, trial: Trial, size: float) -> float:
        """The factor on the size of this slider's steps at which as many contacts break on a step as is resolved, if
        they break as fast as on this one, which has this size; at most 1."""
        holding = self.steps.contacts.holding
        if trial.kept >= holding:
            return 1.0
        # e-folds that break on a step of the size 1
        loss = np.log(holding / trial.kept) / size if trial.kept > 0.0 else np.inf
        return float(clipped(CONTROL.e_folds / loss, ONSET.least_shrink, 1.0))

    def _at_fold(self, size: float, longest_size: float) -> Root:
        """The step that takes the most time: that up to a fold or a kink of τ, where -τ is the least. Each call begins
        with the slope that the last one left: that changes τ by the accuracy of a balance alone, see `solve`."""
        forward = list[Root]()

        def earlier(size: float) -> float:
            root = self.solve(size)
            if self.steps.runs_back(root.step.trial):
                return 0.0
            forward.append(root)
            return -root.step.time_part

        found = minimize_scalar(
            earlier, bounds=(0.0, longest_size), options={"xatol": ONSET.onset * size}
        )
        root = self.solve(float(found.x))
        if forward and self.steps.runs_back(root.step.trial):
            return max(forward, key=lambda root: root.step.time_part)
        return root

    def _last_before_exact(self, size: float, longest_size: float) -> Root | None:
        """The longest step after which there still is a balance, before exact thresholds break, by bisection; None
        where there is none at once."""
        low, high = 0.0, longest_size
        while high - low > ONSET.last_jump * size:
            middle = 0.5 * (low + high)
            root = self.solve(middle)
            if root.has_balance:
                low, fraction = middle, root.step.time_part / middle
                self._guess = self._guess._replace(time_fraction=fraction)
            else:
                high = middle
        return self.solve(low) if low else None
