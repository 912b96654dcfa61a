"""Groups of contacts that began or were born together at one stretch, and where a step would lead them."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.numerics.averages import StretchNodes
from master.outcome import FaultError
from master.soft.in_time.memory import Memory
from master.soft.in_time.threshold_cells import StraightMove
from origins.thresholds.law import Array

# Share of the contacts born in a cohort below which it does not matter in which step they are born: far below errors.
NEGLIGIBLE = 1e-11
# Rounding of the number of contacts, for each that formed: far above that of sums of thousands of steps, far below
# what a contact lost or counted twice in one of them changes.
UNACCOUNTED = 1e-9


class Groups(NamedTuple):
    """Contacts that began or were born together at one stretch; arrays of shape (n,), (n, width).

    stretch, largest : x and the largest |x| so far (lengths)
    weight : fraction of all contacts, divided by the survival at birth, by which a Memory multiplies their survival
    record : their history, see Memory
    """

    stretch: Array
    largest: Array
    weight: Array
    record: Array

    def moved(self, memory: Memory, travel: float, duration: float) -> "Groups":
        """These after the slider has moved by `travel` at one speed; those that broke still have their weight."""
        stretch = self.stretch + travel
        largest = np.maximum(self.largest, np.abs(stretch))
        record = memory.advance(self.record, StraightMove(self.stretch, stretch, largest, duration))
        return Groups(stretch, largest, self.weight, record)

    def check_largest(self, end: float) -> None:
        """FaultError where a stretch is beyond the largest so far, at the time `end`: thresholds that it has met would
        hold."""
        beyond = np.abs(self.stretch) - self.largest
        group = int(beyond.argmax())
        if beyond[group] > 0.0:
            raise FaultError(
                f"at t = {end:.6g} contacts are stretched by {self.stretch[group]:.6g}, and were by at most "
                f"{self.largest[group]:.6g} so far, a fault of the program"
            )

    def and_born(
        self, memory: Memory, born: StretchNodes, fraction: float, speed: float
    ) -> "Groups":
        """These, and as the last ones those of a new cohort, on a slider of this speed |dX/dt|."""
        new = _fresh(memory, born, speed)
        new = new._replace(weight=fraction * new.weight)
        return Groups(*(np.concatenate(both) for both in zip(self, new, strict=True)))

    def survival_and_force(self, memory: Memory) -> Array:
        """See Memory; shape (2, n)."""
        return memory.survival_and_force(self.record, self.stretch, self.largest)

    def stored(self, memory: Memory) -> float:
        """Energy of the contacts that hold, per N_c<k> (length squared)."""
        _, force = self.survival_and_force(memory)
        return 0.5 * float((force * self.stretch) @ self.weight)

    def pick(self, which: slice | npt.NDArray[np.bool_]) -> "Groups":
        """Some of them."""
        return Groups(*(part[which] for part in self))

    def without_negligible_cohorts(self, first: int, count: int) -> "Groups":
        """These, with cohorts of next to no births added to the next younger ones, where these have next to none, too:
        one stays between cohorts of many births, as `unknown_force_of_births` compares neighbours. While a slider
        sticks, each step makes one. The last two are left: births of the next step come to the last one.

        first, count : index of the first group that is of a cohort, and the number of groups of each
        """
        cohorts = self.weight[first:].reshape(-1, count).copy()
        tiny = np.abs(cohorts[:-1]).sum(axis=1) < NEGLIGIBLE
        negligible = np.flatnonzero(tiny[:-1] & tiny[1:])
        for cohort in negligible:
            cohorts[cohort + 1] += cohorts[cohort]
        stays = np.ones(len(cohorts), dtype=bool)
        stays[negligible] = False
        added = self._replace(weight=np.append(self.weight[:first], cohorts))
        return added.pick(np.append(np.ones(first, dtype=bool), np.repeat(stays, count)))


class Trial(NamedTuple):
    """A step that is not taken yet, and the state it leads to; it begins at `ContactsInSteps.now`.

    travel : change of X (a length, of either sign)
    end : when it ends, a time on the path

    groups : with a new cohort that has no births yet; survival_and_force : what the memory says of them, shape (2, n)
    force, holding : see ContactsInSteps; breaks, births : B and J at its end, per contact since t = 0 or a reset
    kept : share of the contacts that held at its begin and hold at its end, too
    """

    travel: float
    end: float
    groups: Groups
    survival_and_force: Array
    force: float
    holding: float
    breaks: float
    births: float
    kept: float

    def check(self, holding: float, force: float, position: float, largest: float) -> None:
        """FaultError unless the step, which is taken and has led to this X, is what was told here, by which it was
        chosen: the number that holds and the force of all groups with the weights that they have now. largest : stretch
        (a length)."""
        most = UNACCOUNTED * (1.0 + self.births)
        if abs(holding - self.holding) > most or abs(force - self.force) > most * largest:
            raise FaultError(
                f"a step is not what its trial told: after t = {self.end:.6g}, X = {position:.6g} a share "
                f"{holding:.6g} of the contacts holds and F = {force:.6g}, in place of {self.holding:.6g} and "
                f"{self.force:.6g}, a fault of the program"
            )


def check_number(
    births: float, formed: tuple[float, float], holding: tuple[float, float], place: str
) -> None:
    """FaultError unless the weights of all cohorts are the births that have formed, and as many contacts hold as have
    formed and not broken: pairs of what is expected and what is. Both hold to 1e-15 on thousands of steps (measured on
    six motions). This sees contacts that are lost or counted twice; no wrong number of births, to which `trial` fits
    the breaks: with a delay `BreaksInSteps.check_births` does."""
    most = UNACCOUNTED * (1.0 + births)
    if abs(formed[1] - formed[0]) > most or abs(holding[1] - holding[0]) > most:
        raise FaultError(
            f"number is not conserved: {place} a share {holding[1]:.6g} of the contacts holds, {holding[0]:.6g} have "
            f"formed and not broken, and of {formed[0]:.6g} births {formed[1]:.6g} are in cohorts, a fault of the "
            "program"
        )


def steady_groups(
    memory: Memory, born: StretchNodes, velocity: float, life: float, step: float
) -> Groups:
    """All contacts in steady sliding at this velocity, all of which hold, by a cohort for each `step` of the way on
    which one holds, a `life` at most, the oldest first: the births on it belong to the cohorts at its ends, as in the
    steps of a slider."""
    longest = min(life, memory.largest_stretch)
    count = int(np.ceil(longest / step))
    way, speed = np.copysign(longest / count, velocity), abs(velocity)
    groups = _fresh(memory, born, speed)
    groups = groups._replace(weight=0.5 * groups.weight)
    for last in range(count):
        groups = groups.moved(memory, way, abs(way) / speed)
        groups = groups.and_born(memory, born, 0.5 if last == count - 1 else 1.0, speed)
    hold = groups.survival_and_force(memory)[0]
    return groups._replace(weight=groups.weight / float(hold @ groups.weight))


def _fresh(memory: Memory, born: StretchNodes, speed: float) -> Groups:
    """The groups of a new cohort, on a slider of this speed |dX/dt|."""
    x = born.stretch
    return Groups(x, np.abs(x), born.weight, memory.fresh(x, speed))


def divided_by_survival(memory: Memory, nodes: StretchNodes) -> StretchNodes:
    """The nodes with weights divided by the survival at birth, 0 where none hold: what Groups take as weights."""
    stretch, survival = nodes.stretch, survivals_at_birth(memory, nodes.stretch)
    weight = np.divide(nodes.weight, survival, out=np.zeros(survival.size), where=survival > 0.0)
    return StretchNodes(stretch, weight)


def survivals_at_birth(memory: Memory, stretch: Array) -> Array:
    """The share of contacts that hold of those that form at these stretches (n,): whose thresholds are above."""
    return memory.survival_and_force(memory.start(stretch), stretch, np.abs(stretch))[0]
