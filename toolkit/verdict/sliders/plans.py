"""How far the drive of finitely many contacts is planned to go, and how often all of them break on the way."""

from dataclasses import dataclass, replace

import numpy as np

from origins.contacts import Contacts
from toolkit.verdict.sliders.budget import LONG_DELAY, most_breaks
from toolkit.verdict.sliders.late import SLIDERS
from toolkit.verdict.sliders.machine import Machine, slip_duration
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.sliders.steady import is_stable_with_delay
from toolkit.verdict.sliders.ways import PlannedDrive, lives_in_a_slip, way_without_contacts

# rules under which contacts re-form while a slip goes on, so that each breaks at every threshold passed
FLOWING = ("instant", "mass")
# length of the drive's path: in loadings where sliders stick and slip, else in mean thresholds beyond the first loading
LOADINGS_OF_SLIPS, BEYOND = 3.2, 40.0
# the same in loadings where five slips, each of which breaks all contacts once, are fewer breaks than MODERATE in all,
# some seconds, and with a mass, whose breaks take longer, than this part of the most that are followed
FIVE_LOADINGS, MODERATE, MODERATE_WITH_MASS = 5.2, 1.2e7, 0.3
# times F_s of a rigid slider that contacts with a law in time bear at most on one that sticks, where nobody has seen
# it: those that strengthen by a hundredth for each factor e are 1.3 times as strong after twelve decades, and heat that
# breaks the weak ones leaves those that bear more
GROWN = 2.0
# loadings of sliders whose slips are few breaks, fewer than CHEAP in all, some 0.1 s: so many tell slips of two kinds
# apart
MANY_LOADINGS, CHEAP = 8.0, 4e6


@dataclass(frozen=True)
class Asked:
    """Of which contacts, on which machine, it is asked what `number` of them do: the arguments of `follow_finite`."""

    machine: Machine
    contacts: Contacts
    number: float
    infinite: Behaviour
    static: float

    @property
    def present(self) -> int:
        """How many contacts the area holds, one at least."""
        return max(round(self.number), 1)

    @property
    def heavy(self) -> bool:
        """Whether the slider has a mass."""
        return self.infinite.rule == "mass"

    @property
    def sticks(self) -> bool:
        """Whether infinitely many contacts stick and slip."""
        return self.infinite.kind == "stick-slip"

    @property
    def sticks_on(self) -> bool:
        """Whether the master equation knows that infinitely many stick and slip on, and no chance leads to steady
        sliding, as that is unstable; not where contacts age or break by heat, so that one slip is not as another."""
        known = self.sticks and self.infinite.contacts is None and self.infinite.success
        known &= not self.contacts.held_in_time
        return known and not is_stable_with_delay(self.machine, self.contacts)

    @property
    def settles(self) -> bool:
        """Whether contacts that re-form at once go on to slide."""
        return (
            self.infinite.rule == "instant" and not self.sticks and not self.contacts.waiting_time
        )

    @property
    def waits(self) -> float:
        """The drive's way while contacts are out (a length)."""
        machine = self.machine if self.heavy else replace(self.machine, mass=None)
        return way_without_contacts(machine, self.contacts)

    @property
    def flowing(self) -> bool:
        """Whether contacts re-form while a slip goes on: with a delay far above the time of a slip of the mass (see
        `may_follow`) they are out until it is over."""
        lasts = slip_duration(self.machine, self.static) if self.heavy else 0.0
        outlasted = self.heavy and self.contacts.waiting_time >= LONG_DELAY * lasts > 0.0
        return self.infinite.rule in FLOWING and not outlasted

    def planned(self, number: int, above: float, sliding: float) -> PlannedDrive:
        """The way of the drive for so many contacts, and how often all of them break on it, at most.

        above, sliding : how far contacts that re-form at once are pulled beyond the force of infinitely many, and how
            much of that they slide at most; both in mean thresholds times N^(-2/3)
        """
        machine, contacts, infinite = self.machine, self.contacts, self.infinite
        mean, flowing, sticks = contacts.mean_threshold, self.flowing, self.sticks
        softness = number ** (-2.0 / 3.0) / machine.spring if self.settles else 0.0
        # contacts that wait hold a slider that sticks to more than F_s of one that moves with the drive
        highest_force = max(self.static, infinite.before) if sticks else self.static
        if self.heavy and infinite.kind != "undecided":
            highest_force = max(highest_force, float(infinite.force.max(initial=0.0)))
        elif self.heavy and contacts.held_in_time:
            highest_force *= GROWN
        loading = highest_force / machine.spring + (1.0 + above * softness) * mean + self.waits
        moderate = MODERATE
        if self.heavy:
            moderate = MODERATE_WITH_MASS * most_breaks(contacts, infinite.rule)
        five = not flowing and SLIDERS * number * FIVE_LOADINGS < moderate
        loadings = FIVE_LOADINGS if five else LOADINGS_OF_SLIPS
        end = loadings * loading if sticks else loading + BEYOND * mean
        if infinite.slips and infinite.period and (sticks or infinite.kind == "undecided"):
            # a heavy slider may slip for longer than the drive loads its spring
            end = max(end, (infinite.in_time.first_slip or 0.0) + loadings * infinite.period)
        longer = MANY_LOADINGS * loading
        lasting = MANY_LOADINGS if sticks else longer / mean
        if infinite.rule not in FLOWING and SLIDERS * number * lasting < CHEAP:
            end = max(end, longer)
        # in a slip that renews contacts all break once; contacts that re-form at once do at each threshold passed
        lives = 2.0 + BEYOND if not sticks else end / mean if flowing else loadings
        in_a_slip = np.inf
        if self.heavy and flowing and machine.damping and contacts.waiting_time:
            in_a_slip = lives_in_a_slip(machine, contacts, highest_force, loading)
            lives = min(lives, 2.0 + BEYOND + end / loading * in_a_slip)
        lives += sliding * softness
        if contacts.thermal is not None and not sticks:
            # A slider that does not slip creeps under any rule, long before F is that of sliding: on a spring of 2e-6
            # N_c<k> by 8,000 mean thresholds. How far is not known here, but not beyond the drive.
            lives += end / mean
        elif flowing and not sticks:
            # the spring relaxes to the force of sliding, to none where that is not known
            relaxed = infinite.after if np.isfinite(infinite.after) else 0.0
            lives += min(max(self.static - relaxed, 0.0) / machine.spring / mean, in_a_slip)
        if contacts.thermal is not None:  # and those that break while the slider sticks
            from eq_model.engine import breaks_by_heat

            lives += breaks_by_heat(contacts, end / machine.velocity)
        return PlannedDrive(end, SLIDERS * number * lives)
