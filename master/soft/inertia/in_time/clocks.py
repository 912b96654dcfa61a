"""Clocks: when sliders with mass are read whose slips come at other times on halved steps, and what is not known then.

A slip takes far less time than it is shifted by halved steps. An example: 0.15 s, at 1664, 1685 and 1689 s, so that at
1687 s the force is that before the slip in one slider, and far below in others; and all contacts are back 10 s later,
at 1674, 1695 and 1699 s. So each slider is read by its own slip's clock; and what force and holding change by in the
time by which the slip's own is not known counts as their error.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from master.soft.in_time.answer.reading import read
from master.soft.inertia.in_time.node import HeavyNode
from master.soft.inertia.in_time.ringing import with_rings
from master.soft.inertia.in_time.slider import HeavySlider
from origins.thresholds.law import Array

# Part of a period of ringing: a time that is not known to this leaves the phase of the swing unknown.
OF_PERIOD = 0.25
# Times the error of X_T at which a slip begins within which one may come after the path's end.
MORE_ROOM = 2.0
# Columns of a node that are read: all behind its size and its time.
COLUMNS = HeavyNode._fields[2:]
FORCE, HOLDING, PLACE = (COLUMNS.index(of) for of in ("force", "holding", "position"))


class Clocks:
    """When each slider is read for an answer at times (n,).

    last : of the sliders
    when : array of shape (sliders, n): at these times, or behind a slip as long after its own as they are after that at
        step 0; just before a slip, where some have slipped and others have not, as long before
    """

    def __init__(self, sliders: Sequence[HeavySlider], times: Array) -> None:
        """Each at the times themselves."""
        self._sliders, self._times, self.last = sliders, times, sliders[-1]
        self.when = np.tile(times, (len(sliders), 1))
        self._begins, self._apart = np.empty(0), np.empty(0)

    def set_by_slips(self, begins: Array, limit: Array) -> None:
        """Each by its own slips, which begin at these times (sliders, slips), at step 0 at the times `limit`. Only on a
        drive of one speed, on which sliders are at the same place then."""
        motion, count = self._sliders[-1].motion, limit.size
        if motion is None or not count:
            return
        shifts, times = begins - limit, self._times
        behind = np.searchsorted(limit, times, side="right") - 1
        shift = np.where(behind >= 0, shifts[:, np.maximum(behind, 0)], 0.0)
        ahead = np.minimum(behind + 1, count - 1)
        self._begins, self._apart = limit, np.ptp(np.vstack([begins, limit]), axis=0)
        is_near = (behind < count - 1) & (times > limit[ahead] - 2.0 * self._apart[ahead])
        shift = np.where(is_near, shifts[:, ahead], shift)
        self.when = np.clip(times + shift, 0.0, motion.times[-1])

    def read(self, which: int) -> Array:
        """The columns of a slider for an answer at these times, X as far behind its drive; shape (columns, n)."""
        slider, when = self._sliders[which], self.when[which]
        columns = _columns(slider, when)
        if slider.motion is not None:
            columns[PLACE] += slider.motion.at(self._times) - slider.motion.at(when)
        return columns

    def far(self, drive_error: float, lasts: Array) -> npt.NDArray[np.bool_]:
        """Which of these times are far from slips that last so long (slips,), and from when contacts that broke in them
        form again, although slips begin at an X_T that is known to `drive_error` (a length) only."""
        far, motion = np.ones(self._times.size, dtype=bool), self.last.motion
        if motion is None or not self._begins.size:
            return far
        off = drive_error / float(np.abs(motion.speeds[0]))
        for begin, apart, length in zip(self._begins, self._apart, lasts, strict=False):
            for later in (0.0, self.last.contacts.delay):
                behind, room = self._times - begin - later, off + 2.0 * apart
                far &= (behind < -room) | (behind > length + room)
        return far

    def holding_ahead(self, drive_error: float) -> Array:
        """By how much the share that holds changes at these times (n,), on a drive of one speed, while the drive moves
        by `drive_error` (a length): as much is not known of it where the force is known as if X_T were off by that."""
        motion, when = self.last.motion, self.when[-1]
        if motion is None:
            return np.zeros(when.size)
        off = drive_error / float(np.abs(motion.speeds[0]))
        at, *beside = (
            read(self.last.sections, np.clip(when + shift, 0.0, motion.times[-1]), len(COLUMNS))
            for shift in (0.0, -off, off)
        )
        return np.asarray(np.abs(np.stack(beside) - at)[:, HOLDING].max(axis=0))

    def spread(self, count: int, drive_error: float) -> Array:
        """What is not known of the forces of spring and contacts (lengths) and the share that holds at the first
        `count` times, shape (3, count), as slips begin at an X_T that is known to `drive_error` (a length): all that
        the last slider changes by in the time in which the drive moves by that, before and behind. None before the
        first slip may begin."""
        out, motion = np.zeros((3, count)), self.last.motion
        if motion is None or not self._begins.size:
            return out
        off = min(drive_error / float(np.abs(motion.speeds[0])), float(motion.times[-1]))
        when, end = self.when[-1, :count], motion.times[-1]
        at, early, late = (
            self._read_forces(np.clip(when + shift, 0.0, end)) for shift in (0.0, -off, off)
        )
        first = self._begins[0] - 2.0 * (off + self._apart[0])
        nodes = np.array([node[1:] for nodes in self.last.sections for node in nodes])
        times, passed = nodes[:, 0], self._forces(nodes[:, 0], nodes[:, 1:].T)
        for k in np.flatnonzero(self._times[:count] > first).tolist():
            low, high = np.searchsorted(times, [when[k] - off, when[k] + off])
            seen = np.column_stack([passed[:, low:high], early[:, k], late[:, k]])
            out[:, k] = np.abs(seen - at[:, k : k + 1]).max(axis=1)
            out[:2, k] = np.maximum(out[:2, k], self.unknown_of_ringing(float(when[k]), off))
        return out

    def unknown_of_ringing(self, when: float, off: float) -> Array:
        """What is not known of the forces of spring and contacts (lengths) at a time in which the last slider rings on
        its contacts and which is known to `off`: where its phase is not known, the whole swing."""
        most = np.zeros(2)
        for ring in self.last.rings:
            since = max(when - off - ring.begin.time, 0.0)
            begun = when + off > ring.begin.time and since < ring.lasts
            if begun and off > OF_PERIOD * ring.motion.period:
                swing = 2.0 * ring.motion.bound(since)
                most = np.maximum(most, swing * np.array([self.last.spring, ring.held.holding]))
        return most

    def may_slip(self, drive_error: float) -> bool:
        """Whether the last slider gets faster so soon before the path ends that a slip may begin there, which is known
        to an error in X_T (a length). Towards a slip its speed grows as the time left to the power -1/2, or faster."""
        motion = self.last.motion
        nodes = [node for nodes in self.last.sections[-2:] for node in nodes]
        if motion is None or len(nodes) < 2:
            return False
        last = nodes[-1]
        before = next((one for one in nodes[::-1] if one.time < last.time), last)
        ahead = np.sign(motion.speeds[0])
        if not last.speed * ahead > before.speed * ahead > 0.0:
            return False
        left = (last.time - before.time) / ((last.speed / before.speed) ** 2 - 1.0)
        return bool(left * abs(motion.speeds[0]) < MORE_ROOM * drive_error)

    def pull(self, times: Array, places: Array) -> Array:
        """The spring's force (lengths) on the last slider at these places at these times, on a drive that moves."""
        assert self.last.motion is not None
        return self.last.spring * (self.last.motion.at(times) - places)

    def near(self, off: Array) -> str:
        """Where, in words, the first of these times is at which so much is not known most."""
        t = self._times[int(off.argmax())]
        assert self.last.motion is not None
        return f", near t = {t:.6g}, X_T = {float(self.last.motion.at(np.array(t))):.6g}"

    def _read_forces(self, when: Array) -> Array:
        """See _forces, at these times."""
        return self._forces(when, _columns(self.last, when))

    def _forces(self, times: Array, columns: Array) -> Array:
        """The forces of spring and contacts and the share that holds of the last slider, shape (3, n)."""
        pull = self.pull(times, columns[PLACE])
        return np.stack([pull, columns[FORCE], columns[HOLDING]])


def _columns(slider: HeavySlider, when: Array) -> Array:
    """The columns of a slider at these times, shape (columns, n)."""
    return with_rings(read(slider.sections, when, len(COLUMNS)), slider.rings, when)
