"""The drive: the path of the slider, or of the spring that pulls it; checked once for both solvers."""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from origins.errors import between, finite_array, non_negative, one_of, refuse

Array = npt.NDArray[np.float64]
SlipRule = Literal["reset", "reform-after", "instant"]

# A slip of a slider with mass, of both solvers, is a swing down of the spring's force that ends a stick: from a maximum
# to a minimum, where rises and falls below RISE, or below what chance does to few contacts
# (`eq_model.coupled.mass.chance`), do not count.
# The slider sticks where the force rises by RISE while it stays within ROOM, or on any way on which no contact breaks
# or forms, enough contacts hold it, and at most SLIP_FRACTION of these break. From where it last stuck to the end of
# the swing at least SLIP_FRACTION of those break, and of those that hold in steady sliding at the drive's speed, and
# the slider gets FASTER times as fast as the drive.
# Enough are RISE of all contacts, as fewer cannot raise the force by as much (each holds a mean threshold), and of
# those that held it before SLIP_FRACTION.
# Of the force, in mean thresholds; and the least share of the contacts that can raise it by as much.
RISE = 0.02
# In mean thresholds: contacts that hold are stretched from -1 to 1 of them at most.
ROOM = 2.0
# A slider that stuck and swings freely beyond the drive gets twice as fast as this.
FASTER = 1.5
# Share of a swing below which a second minimum does not count as lower: a slider that no contact holds comes close to
# the force of its damping again and again, and the swing has ended where it first does. In the master equation also the
# share of a fall that is left where one ends that only comes close to its end.
LOWER = 1e-3
# Fewest breaks in a slip, per contact that held before: below it some weak contacts break, and the others hold.
SLIP_FRACTION = 0.2


def main_drops(drops: Array) -> npt.NDArray[np.bool_]:
    """Which of a slider's slips are main ones, by their drops of the force in order, shape (n,): those that drop by
    SLIP_FRACTION of the largest of the later half, as many small ones may precede it as follow it, or more. Between
    slips of all contacts a few may slip alone, such as those of a narrow peak of P_c."""
    sizes = np.abs(drops)
    late = sizes[sizes.size // 2 if sizes.size > 2 else 0 :]
    return np.asarray(sizes >= SLIP_FRACTION * late.max(initial=0.0))


class Drive:
    """A path, the speed along it, and the spring that pulls a slider, with a mass or without; straight between points.

    path : positions (lengths), shape (n,), n >= 1, which may turn round: X of a rigid slider, which moves from
        X = 0 straight to the first of them; X_T, the position of the drive, of a soft one.
    velocity : constant speed along the path (length per time); it matters only with rates, ageing, grains or delay.
    time : when each point is reached, shape (n,), from 0 on and in order, instead of the velocity.
    spring : K/(N_c <k>); None: the slider is rigid.
    slip : "reset", "reform-after" or "instant", the slip rule of a soft slider without mass, left out "reset"; a rigid
        one takes the default only. With a mass None: its motion in a slip follows from mass, damping and delay.
    mass : M/(N_c <k>) of a soft slider (time squared), M X'' + γ X' = K (X_T - X) - F; None: it has none.
    damping : γ/(N_c <k>) of a slider with mass (time), at least 0.
    forward : whether the path begins at 0 or above and never turns back.

    Raises InputError for values that are not finite, out of range or not in order, for an unknown slip rule, and for
    keywords that do not go together: mass and damping need a spring, damping a mass, and beside a mass no slip rule.
    """

    def __init__(
        self,
        path: npt.ArrayLike,
        velocity: float = 1.0,
        time: npt.ArrayLike | None = None,
        spring: float | None = None,
        slip: SlipRule | None = None,
        mass: float | None = None,
        damping: float = 0.0,
    ) -> None:
        """Check the arguments, which are those above."""
        self.path = finite_array("path", path)
        self.velocity = between("velocity", velocity, 1e-100, 1e100)
        self.time = None if time is None else _check_time(time, self.path, velocity)
        self.spring = None if spring is None else between("spring", spring, 1e-100, 1e100)
        self.mass = None if mass is None else between("mass", mass, 1e-100, 1e100)
        self.damping = non_negative("damping", damping)
        self.slip = self._rule_of(slip)
        self._back = np.flatnonzero(np.diff(self.path, prepend=0.0) < 0.0)
        self.forward = not self._back.size

    def _rule_of(self, slip: SlipRule | None) -> SlipRule | None:
        """The slip rule: the default where it is left out, None with a mass. Raises InputError for keywords that do not
        go together."""
        if slip is not None:
            one_of("slip", slip, get_args(SlipRule))
        if self.mass is None:
            if self.damping:
                refuse("damping", self.damping, "is of a slider with mass; give a mass, too")
            if self.spring is None and slip not in (None, "reset"):
                hint = "is what a slip of a soft slider does; without spring it is rigid"
                refuse("slip", slip, hint)
            return slip or "reset"
        if self.spring is None:
            refuse("mass", self.mass, "is of a soft slider; give its spring, too")
        if slip is not None:
            refuse(
                "slip",
                slip,
                "mass, damping and the contacts' delay decide; leave it out beside mass",
            )
        return None

    def keywords(self) -> dict[str, Any]:
        """What a solver is given of this drive beside its path, by the names of its keywords."""
        return {
            "velocity": self.velocity,
            "time": self.time,
            "spring": self.spring,
            "slip": self.slip,
            "mass": self.mass,
            "damping": self.damping,
        }

    def arrival_times(self, begin: float = 0.0) -> Array:
        """When the points are reached, shape (n,), from the position `begin` at t = 0 on."""
        if self.time is not None:
            return self.time
        return np.asarray(np.abs(np.diff(self.path, prepend=begin)).cumsum() / self.velocity)

    def only_forward(self, solver: str) -> Drive:
        """`self` for a rigid slider that moves forward; else InputError, which says that `solver` takes only that."""
        if self.spring is not None:
            refuse("spring", self.spring, f"{solver} takes a rigid slider; leave it out")
        for at in self._back.tolist():
            ahead = f"path[{at - 1}] = {self.path[at - 1]:g}" if at else "X = 0"
            hint = f"lies behind {ahead}; {solver} takes a path that does not turn round"
            refuse(f"path[{at}]", self.path[at], hint)
        return self


def _check_time(time: npt.ArrayLike, path: Array, velocity: float) -> Array:
    """The times of the path's points, in order, with time to move wherever the path moves."""
    if velocity != 1.0:
        refuse("velocity", velocity, "the times of the points say how fast; give one of the two")
    times = finite_array("time", time)
    if times.shape != path.shape:
        refuse("time", times, f"must have the shape of the path, {path.shape}")
    if times[0] < 0.0:
        refuse("time[0]", times[0], "must be at least 0, when the slider is at X = 0")
    lasts, moves = np.diff(times, prepend=0.0), np.abs(np.diff(path, prepend=0.0))
    for at in np.flatnonzero((lasts < 0.0) | ((lasts <= 1e-100 * moves) & (moves > 0.0))).tolist():
        hint = f"is before time[{at - 1}] = {times[at - 1]:g}; times must be in order"
        if lasts[at] >= 0.0:  # or so little that the speed is beyond 1e100
            hint = "leaves no time to get there; the path moves, so must the time"
        refuse(f"time[{at}]", times[at], hint)
    return times
