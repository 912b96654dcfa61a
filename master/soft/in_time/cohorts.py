"""Cohorts: all contacts of a slider on its way, trial steps, and the steps taken.

With N(t) the births per contact since t = 0, B(t) the breaks, and E(t, s) the survival of contacts
born at s, number conservation says

    G_0(t) + integral of E(t, s) dN(s) + [B(t) - N(t)] = 1,        N(t) = B(t - delay).

Contacts are independent: the survival of those born at one moment depends on the motion since and on nothing else. They
are represented by a cohort born at the end of each step, and each cohort by one strand for each stretch at which
contacts form again. Within a step the rate of births is taken as constant: half of its births belong to the cohort at
its begin, half to that at its end, of second order in the step.
"""

from bisect import bisect_left
from typing import NamedTuple

import numpy as np
from scipy.interpolate import KroghInterpolator

from master.numerics.averages import StretchRule, stretch_rule
from master.outcome import StoppedError, stop_after
from master.renewal.births import reforming_law
from master.soft.in_time.memory import Leg, Memory
from origins import Contacts
from origins.thresholds.law import Array

# Share of a strand that holds below which it is dropped.
DEAD = 1e-19
# Most steps, and most operations in them, which take a minute or less.
MOST_STEPS, MOST_WORK = 6e3, 1e9


class Strands(NamedTuple):
    """Contacts that began or were born together at one stretch; arrays of shape (n,), (n, width).

    stretch, furthest : x and the largest |x| so far (lengths)
    share : of all contacts, divided by the share that holds at birth
    record : see Memory
    """

    stretch: Array
    furthest: Array
    share: Array
    record: Array

    def and_born(self, memory: Memory, born: StretchRule, share: float, speed: float) -> "Strands":
        """These, and as the last ones those of a new cohort, on a slider of this speed |dX/dt|."""
        x, record = born.stretch, memory.fresh(born.stretch, speed)
        new = Strands(x, np.abs(x), share * born.weight, record)
        return Strands(*(np.concatenate(both) for both in zip(self, new, strict=True)))


class Trial(NamedTuple):
    """A step that is not taken yet: its travel, its end in time, and the state it leads to.

    strands : with a new cohort that has no births yet; `held_force` is what share_and_force says of them
    force, holding : see Cohorts; breaks, births : per contact since t = 0 or a reset
    """

    travel: float
    now: float
    strands: Strands
    held_force: Array
    force: float
    holding: float
    breaks: float
    births: float


class Cohorts:
    """Contacts on a slider, from X = 0 and t = 0 on, which re-form one delay after they break.

    place, now, force, holding : X (a length), the time, F/(N_c <k>) (a length), the share that holds
    unit, jumps : mean threshold (a length), and whether P_c may jump
    pending : times at which the rate of births jumps, and the shares, possibly 0, born at once there
    steps, work : number of steps taken so far, and of operations in them
    unresolved : bound on the force (a length) of contacts whose share that holds steps do not resolve
    """

    def __init__(self, contacts: Contacts, memory: Memory, level: int, until: float) -> None:
        """All contacts at the beginning; `until` is a reading of time.monotonic() to stop at."""
        self.memory, self.delay, self._until = memory, contacts.waiting_time, until
        self.level, self.steps, self.work, self.unresolved = level, 0, 0.0, 0.0
        self.place, self.now, self.unit = 0.0, 0.0, contacts.mean_threshold
        law, ends = contacts.thresholds, contacts.thresholds.breakpoints
        self.jumps = bool((law.pdf(ends[ends > 0.0]) > 0.0).any())
        start = stretch_rule(contacts.start, memory.largest_stretch, memory.starts)
        # births at many stretches have more nodes with each level
        births = stretch_rule(reforming_law(contacts), memory.largest_stretch, 8 + 4 * level)
        self._births = _over_held(memory, births)
        self._begin(_over_held(memory, start), memory.start(start.stretch))

    def relax(self) -> None:
        """Replace all contacts, also those that are out, by those just formed again."""
        self._begin(self._births, self.memory.fresh(self._births.stretch, 0.0))

    def _begin(self, start: StretchRule, record: Array) -> None:
        x = start.stretch
        strands = Strands(x, np.abs(x), start.weight, record)
        held_force = self.memory.share_and_force(strands.record, x, strands.furthest)
        self.holding, self.force = (held_force @ strands.share).tolist()
        self._started = x.size
        self.strands = strands.and_born(self.memory, self._births, 0.0, 0.0)
        # ends of steps with the breaks up to there, in smooth sections; and the births
        self._began, self._sections, self._born = self.now, [[(self.now, 0.0)]], 0.0
        self.pending: dict[float, float] = {}

    @property
    def breaks(self) -> float:
        """Breaks per contact since t = 0 or a reset."""
        return self._sections[-1][-1][1]

    def trial(self, travel: float, now: float, without_births: bool = False) -> Trial:
        """A trial step by `travel` until `now`."""
        duration, born, many = now - self.now, self._born, self._births.stretch.size
        stretch = self.strands.stretch + travel
        furthest = np.maximum(self.strands.furthest, np.abs(stretch))
        leg = Leg(self.strands.stretch, stretch, furthest, duration)
        record = self.memory.advance(self.strands.record, leg)
        speed = abs(travel) / duration if duration > 0.0 else np.inf
        strands = Strands(stretch, furthest, self.strands.share, record)
        strands = strands.and_born(self.memory, self._births, 0.0, speed)
        held_force = self.memory.share_and_force(strands.record, strands.stretch, strands.furthest)
        known, force = (held_force @ strands.share).tolist()
        # those born in this step, per contact born
        new = 0.5 * (held_force[:, -2 * many : -many] + held_force[:, -many:]) @ self._births.weight
        last, newest_force = new.tolist()
        without_births |= bool(self.delay) and now == self.now
        slope, rest = (0.0, born) if without_births else self._births_at(now)
        # known + last (N - N_before) + B - N = 1, N = slope B + rest
        breaks = (1.0 - known + last * born + (1.0 - last) * rest) / (1.0 - (1.0 - last) * slope)
        more = slope * breaks + rest - born
        force, held = force + newest_force * more, known + last * more
        return Trial(travel, now, strands, held_force, force, held, breaks, born + more)

    def _births_at(self, now: float) -> tuple[float, float]:
        """Births up to a later moment, as a linear function of the breaks B up to then: (slope, rest)."""
        if not self.delay:
            return 1.0, 0.0
        # the delay is prolonged by 1e-13 of the time, so that births at one moment do not come early
        at, last = now - self.delay - 1e-13 * (now - self._began), self.now
        if at <= self._began:
            return 0.0, 0.0
        if at <= last:
            # a cubic through the nodes beside, within one section
            nodes = next(part for part in self._sections if part[-1][0] >= at)
            begin = max(min(bisect_left(nodes, (at,)) - 2, len(nodes) - 4), 0)
            times, breaks = zip(*nodes[begin : begin + 4], strict=True)
            return 0.0, float(KroghInterpolator(times, breaks)(at))
        share = (at - last) / (now - last)
        return share, (1.0 - share) * self.breaks

    def take(self, trial: Trial) -> None:
        """Take the step."""
        strands, held_force, many = trial.strands, trial.held_force, self._births.stretch.size
        self.steps += 1
        self.work += strands.share.size * (self.memory.width + 60)
        # an error estimate needs three levels
        share = 0.5 ** max(2 - self.level, 0)
        if self.steps > MOST_STEPS * share or self.work > MOST_WORK * share**2:
            done = f"{self.steps - 1} steps led to a time of {self.now:.4g} only"
            raise StoppedError(f"{done}, and more are not taken on")
        stop_after(self._until)
        self.place, self.now = self.place + trial.travel, trial.now
        self.force, self.holding = trial.force, trial.holding
        half = 0.5 * (trial.births - self._born) * self._births.weight
        strands.share[-many:] = half
        strands.share[-2 * many : -many] += half
        # a step is unresolved if the survival of its first births is less than half that of its
        # last: then it is unknown how many of the births in between hold
        held, pull = held_force[:, self._started :]
        born = np.abs(strands.share[self._started :])
        apart = np.where(held[:-many] < 0.5 * held[many:], 0.5, 0.0)
        apart *= np.abs(pull[many:] - pull[:-many]) * np.sqrt(born[many:] * born[:-many])
        self.unresolved = max(self.unresolved, float(apart.sum()))
        # drop cohorts of which none hold; births go on between the last one and the next
        alive = held_force[0] > DEAD
        alive[self._started :] = np.repeat(held.reshape(-1, many).max(axis=1) > DEAD, many)
        alive[-many:] = True
        self._started = int(np.count_nonzero(alive[: self._started]))
        self.strands = Strands(*(part[alive] for part in strands))
        self._sections[-1].append((self.now, trial.breaks))
        self._born = trial.births

    def begin_section(self) -> None:
        """The speed and the rate of breaks may jump at this moment."""
        self._sections.append(self._sections[-1][-1:])

    def repeat_later(self, at: float, weight: float = 0.0) -> None:
        """Breaks jump by a share `weight`, or their rate jumps: births repeat it a delay later, and bend after two."""
        for later, share in ((at + self.delay, weight), (at + 2.0 * self.delay, 0.0)):
            self.pending[later] = self.pending.get(later, 0.0) + share

    def born_now(self) -> None:
        """Let all contacts that are due be born."""
        weight = sum(self.pending.pop(at) for at in list(self.pending) if at <= self.now)
        if weight > 0.0:
            at = self.strands.share.size
            self.strands = self.strands.and_born(self.memory, self._births, weight, 0.0)
            new = Strands(*(part[at:] for part in self.strands))
            held_force = self.memory.share_and_force(new.record, new.stretch, new.furthest)
            held, force = (held_force @ new.share).tolist()
            self.holding, self.force = self.holding + held, self.force + force
            self._born += weight


def _over_held(memory: Memory, rule: StretchRule) -> StretchRule:
    """The rule with weights divided by the share that holds at birth."""
    stretch = rule.stretch
    whole = memory.share_and_force(memory.start(stretch), stretch, np.abs(stretch))[0]
    share = np.divide(rule.weight, whole, out=np.zeros(whole.size), where=whole > 0.0)
    return StretchRule(stretch, share)
