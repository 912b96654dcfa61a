"""Long slips of a slider with mass without steps: once contacts have lost their common start, F is F_k(V).

On the spring of a machine a slip is a million thresholds long. Contacts that form again at once, and grow stronger with
their age, have forgotten the begin of the slip after some tens of thresholds. From there on

    M V' = S - γ V - F_k(V),    S' = K (v - V),

with S the spring's force, the equations of steady_sliding.py. They hold as long as F lags little behind F_k(V). In the
first order of the change of V, with l the mean stretch of contacts, weighted by their force,

    |F - F_k(V)| <= l |dF_k/d ln V| |d ln V/dX|.

As V^2 grows in proportion to the way X from the slip's begin, d ln V/dX = 1/2X: the lag falls, until the slider comes
to rest, some tens of thresholds before which steps go on with contacts as in steady sliding at that speed.

The error of F is what it is off F_k(V) by as steps end, how much that varied along the last part of the way, and the
lag. That of the spring's force is far smaller, as F is so far off on a small part of the slip alone.
"""

import numpy as np

from master.motion import Motion
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.creep import CREEP
from master.soft.inertia.in_time.node import HeavyNode
from master.soft.inertia.in_time.steady_motion import SlipMotion
from master.soft.inertia.in_time.steady_sliding import Slid, SlidingBegin, SteadySliding
from master.steady.kinetic_table import KineticTable, tabulated
from origins import Contacts, Drive
from origins.laws.proportional import ProportionalGrowth
from origins.thresholds.law import Array

# Part of the tolerance by which F may lag behind F_k(V), and by which what it is off may vary along the last part of
# the way.
LAG, VARIATION = 0.25, 0.25
# That part is this many mean thresholds at least, on which contacts that began together would break once.
COMPARED = 1.5
# Ratio of M V^2 to F_k times the memory above which the contacts hardly change the slider's speed while they break.
HEAVY = 4.0
# Factor on the error of the spring's force by the lag of first order.
SAFETY = 2.0
# Least length of a slip that is worth it, in longest lives.
WORTH = 5.0
# Factors on the speed of the slider as its slip is tabulated: it ends nearly as slow as it began.
TABLE_DOWN_BY, TABLE_UP_TO = 100.0, 2.0


class LongSlips(SteadySliding):
    """Long slips on a drive of one speed; lengths are along the motion."""

    # of SlipMotion._change, in which the allowed lag is 1: where it gets larger the way without steps ends, and
    # steps let the slider stop
    in_slips, _most_change = True, 1.0

    def __init__(
        self, contacts: Contacts, drive: Drive, motion: Motion, tolerance: float, until: float
    ) -> None:
        """See Creep."""
        super().__init__(contacts, drive, motion, tolerance, until)
        law, self.motion = contacts.thresholds, motion
        # the mean stretch of steadily sliding contacts, weighted by their force, at a speed at which none grows
        self._memory_of_fresh = float(law.moment(3) / (1.5 * law.moment(2)))
        allowed = LAG * self._tolerance
        self._machine = self._machine._replace(allowed_lag=allowed)

    def slide(self, way: list[HeavyNode], contacts: ContactsInSteps) -> Slid | None:
        """See SteadySliding."""
        last, sign = way[-1], self._sign
        distance, speed = sign * (last.position - way[0].position), sign * last.speed
        looked = len(way) < CREEP.next_look * self._nodes_at_last_look
        if speed <= 0.0 or looked:
            return None
        self._machine = of = self._machine._replace(memory=self._memory_at(speed))
        load = self._load(last)
        is_light = of.mass * speed**2 < HEAVY * load * of.memory
        if is_light or distance < 2.0 * COMPARED * of.unit:
            return None
        self._nodes_at_last_look = len(way)
        if load - sign * last.force < WORTH * of.spring * of.life:
            return None
        begin = self._in_slip(way, distance)
        if begin is None:
            return None
        # what F is off by at the begin enters the error of the spring's force by its energy, in _of_spring
        slid = self._slid(last, begin._replace(error=0.0), contacts, SlipMotion)
        of_spring = self._of_spring(slid, begin, distance)
        # the lag where it ends may be as large as is allowed
        of_contacts = max(begin.error, of.allowed_lag)
        return slid._replace(error=slid.error + of_spring, of_contacts=of_contacts)

    def _memory_at(self, speed: float) -> float:
        """The way for which F remembers the speed, at this one (a length): contacts grow stronger on it."""
        growth, fresh = self._contacts.changing, self._memory_of_fresh
        assert isinstance(growth, ProportionalGrowth)
        return fresh * float(growth.factor(fresh / speed))

    def _of_spring(self, slid: Slid, begin: SlidingBegin, distance: float) -> float:
        """The error of the spring's force S behind a slip (a length), as F lags behind F_k(V). That takes the energy W
        from the slider: its integral over X, l |dF_k|, and on the first part of the way, as long as that before, what F
        is off by at its begin. As the slider stops, (S - F)^2/2K is off by W."""
        last, of, sign = slid.nodes[-1], self._machine, self._sign
        forces = np.array([node.force for node in slid.nodes])
        energy = of.memory * float(np.abs(np.diff(forces)).sum()) + begin.error * distance
        most = (2.0 * of.spring * energy) ** 0.5
        pulled = abs(self._load(last) - sign * last.force)
        return SAFETY * min(most, of.spring * energy / pulled if pulled else np.inf)

    def _in_slip(self, way: list[HeavyNode], distance: float) -> SlidingBegin | None:
        """The begin of sliding in a slip; None where F is not known to be F_k(V)."""
        last, sign, of = way[-1], self._sign, self._machine
        position, force, speed = sign * np.array([(n.position, n.force, n.speed) for n in way]).T
        late = position >= position[-1] - max(CREEP.last_part * distance, COMPARED * of.unit)
        if np.count_nonzero(late) < CREEP.fewest_steps or speed[late].min() <= 0.0:
            return None
        table = self._table_of_slip(speed[late], self._load(last))
        if table is None:
            return None
        u = float(np.log(speed[-1]))
        offsets = force[late] - table.force(np.log(speed[late]))
        way_compared = float(np.ptp(position[late]))
        variation = float(np.ptp(offsets))
        faster = float(np.log(speed[-1] / speed[late][0])) / way_compared
        lag = of.lag(u, faster, table)
        if variation > VARIATION * self._tolerance or lag > of.allowed_lag:
            return None
        return SlidingBegin(u, table, max(abs(float(offsets.mean())), lag) + variation)

    def _table_of_slip(self, speeds: Array, load: float) -> KineticTable | None:
        """F_k at these speeds, and at those that a spring with this force may give the slider."""
        of = self._machine
        most = TABLE_UP_TO * (float(speeds.max()) + load / (of.spring * of.mass) ** 0.5)
        needed, table = np.log([float(speeds.min()), most]), self._table
        if table is None or table.ends[0] > needed[0] or needed[1] > table.ends[1]:
            needed[0] -= np.log(TABLE_DOWN_BY)
            error = CREEP.of_change * self._tolerance
            self._table = tabulated(self._contacts, needed, error, self._until)
        return self._table


def long_slips_of(
    contacts: Contacts, drive: Drive, motion: Motion | None, tolerance: float, until: float
) -> LongSlips | None:
    """Long slips of these contacts, None where F_k(V) is not what they lead to, or is not known."""
    law, growth = contacts.thresholds, contacts.changing
    # what follows a slip on a drive that turns, stops or changes its speed is not known by the slip's own clock
    one_speed = motion is not None and motion.speeds.size == 1 and bool(motion.speeds[0])
    if motion is None or not one_speed or not isinstance(growth, ProportionalGrowth):
        return None
    alone = set(contacts.laws) <= {growth.law}
    if not alone or law.atoms[0].size or not np.isfinite(law.moment(3)):
        return None
    return LongSlips(contacts, drive, motion, tolerance, until)
