"""A soft slider along its whole path, K (X_T - X) = F, step by step and slip after slip."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.optimize import brentq
from scipy.optimize.elementwise import find_root

from master.motion import Motion
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.steps import Steps
from origins.drive import Drive
from origins.thresholds.law import Array


class Node(NamedTuple):
    """The end of a step: the sizes of its section's steps so far, summed up (see Steps), and the state."""

    size: float
    time: float
    force: float
    holding: float


class Slider:
    """The solution along the whole path, with steps of 2^-level of the coarsest.

    motion : of the drive; None where it does not move
    sections : nodes of each smooth section
    slips : time, K X_T, F before and after (lengths) of each slip
    """

    def __init__(self, contacts: Cohorts, drive: Drive, motion: Motion | None) -> None:
        self.contacts, self._rule, self._spring = contacts, drive.slip, float(drive.spring or 0.0)
        self._motion, self._size = motion, 0.5**contacts.level  # of a step
        self.sections, self.slips = list[list[Node]](), list[Array]()

    def run(self) -> None:
        """Follow the drive to its end."""
        contacts, motion = self.contacts, self._motion
        if motion is None:
            self.sections.append([self._node(0.0)])
            return
        self._steps = Steps(contacts, self._spring, motion)
        for leg, last in enumerate(motion.times[1:].tolist()):
            contacts.repeat_later(float(motion.times[leg]))
            while True:
                end = min([*contacts.pending, last])
                self._steps.begin(leg, end)
                if self._slide(end):
                    self._slip(float(motion.at(np.array(contacts.now))))
                elif end < last:
                    contacts.born_now()
                else:
                    break

    def _slide(self, end: float) -> bool:
        """Take steps until `end`, or until a slip begins; returns whether one does."""
        contacts, steps, nodes = self.contacts, self._steps, [self._node(0.0)]
        self.sections.append(nodes)
        contacts.begin_section()
        slips = False
        while not slips and contacts.now < end:
            size = min(self._size * steps.shrink, max(steps.longest(), 1e-6 * self._size))
            trial, slips = steps.up_to_slip(*steps.step(size), size)
            if trial.travel or trial.now > contacts.now:
                done = nodes[-1].size + max(steps.size(trial), 0.0)
                contacts.take(trial)
                nodes.append(self._node(done))
        return slips

    def _node(self, size: float) -> Node:
        state = self.contacts
        return Node(size, state.now, state.force, state.holding)

    def _slip(self, drive: float) -> None:
        """Let the slider slip while the drive holds at this place."""
        contacts, force = self.contacts, self.contacts.force
        if self._rule == "reset":
            contacts.relax()
            contacts.place = drive - contacts.force / self._spring
        else:
            self._slip_to_balance(self._rule == "reform-after" or contacts.delay > 0.0)
        self.slips.append(np.array([contacts.now, self._spring * drive, force, contacts.force]))

    def _slip_to_balance(self, without_births: bool) -> None:
        """Move the slider to the first balance; `without_births`, broken contacts stay out until then."""
        contacts, steps, scales = self.contacts, self._steps, self.contacts.memory.scales
        # with heat F may rise at first, as the weakest have broken: six small ways are tried up to this one
        least = 0.5 * scales.length
        # without births only the end has to be found, in small steps so that none is missed
        step = steps.sign * (0.06 * scales.length if without_births else self._size * steps.length)
        contacts.begin_section()
        begin, broken, travel = contacts.place, contacts.breaks, 0.0

        def imbalance(way: float) -> float:
            return steps.imbalance(contacts.trial(way, contacts.now, without_births))

        ways = [steps.sign * share * least for share in (0.003, 0.01, 0.03, 0.1, 0.4, 1.0)]
        slipped = next((way for way in ways if imbalance(way) > 0.0), 0.0)
        slips, away = bool(slipped), 0.0 < abs(slipped) < abs(step)
        low = slipped or 1e-4 * step  # where no way slips, one of next to no length
        while slips and ((missing := imbalance(travel + step)) > 0.0 or not away):
            away |= missing > 0.0 or abs(contacts.place + travel - begin) > least
            if without_births:
                travel += step
            else:
                contacts.take(contacts.trial(step, contacts.now))
            low = travel
        if slips and imbalance(low) > 0.0:
            # accuracy of a slip's end, in mean thresholds
            low = float(brentq(imbalance, low, travel + step, xtol=1e-15 * contacts.unit))
        contacts.take(contacts.trial(low, contacts.now, without_births))
        contacts.begin_section()
        if without_births:
            contacts.repeat_later(contacts.now, contacts.breaks - broken)
            contacts.born_now()


def read(sections: list[list[Node]], asked: Array) -> Array:
    """Force (lengths) and holding share at times (n,), shape (2, n); at a slip, after it. By splines in the size of all
    steps, in which the time, too, is smooth."""
    ends = np.array([section[-1].time for section in sections])
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(sections) - 1)
    out = np.empty((2, asked.size))
    for k in np.unique(which):
        at, nodes = asked[which == k], np.array(sections[k])
        nodes = nodes[np.unique(nodes[:, 0], return_index=True)[1]]
        step, times = nodes[:, 0], nodes[:, 1]
        if step.size == 1:
            out[:, which == k] = nodes[0, 2:, None]
            continue
        # splines are best at odd degrees
        values = make_interp_spline(step, nodes[:, 1:], k=min(5, 2 * ((step.size - 2) // 2) + 1))
        cell = np.clip(np.searchsorted(times, at, side="left"), 1, step.size - 1)
        found = find_root(
            lambda x, time, values=values: values(x)[..., 0] - time,
            (step[cell - 1], step[cell]),
            args=(np.clip(at, times[cell - 1], times[cell]),),
        )
        # at the end of a cell rounding may take the root out of it
        place = np.where(found.success, found.x, np.interp(at, times, step))
        out[:, which == k] = values(place)[:, 1:].T
    return out
