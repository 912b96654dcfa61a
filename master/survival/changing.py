"""ChangingLife: what a law by which thresholds change offers the master equation beside its survival."""

from __future__ import annotations

from typing import NoReturn, Self

import numpy as np

from master.motion import Motion
from master.survival.life import Life, Survivors
from origins import Contacts, InputError
from origins.errors import refuse

# Share of the contacts that holds no more: below the rounding of 1.
NEGLECTED = 1e-17
# Of the spread of thresholds, or their mean: the length over which a survival is resolved at first.
FIRST_GUESS = 0.25
# Factor between times at which all may be broken, and the last one, in mean thresholds divided by the speed.
LATER, LATEST = 1.5, 1e130


class ChangingLife(Life):
    """A Life of contacts whose thresholds change while they hold; LIVES of master.survival.make has it by their law.

    A law has to write `survivors` alone, see Life. Where contacts of the start are older than those born later, it has
    to tell them apart in `survival_and_force`, as GrowingLife does.
    """

    error = 1e-13  # of the survival, by rounding
    neglected = NEGLECTED
    peaks_at_bends = False

    def __init__(self, contacts: Contacts, longest: float) -> None:
        """Find how far contacts may be stretched up to the time `longest`, and how finely their survival varies."""
        law, fresh = contacts.changing, contacts.thresholds
        assert law is not None
        self.contacts, self.start_as_births = contacts, not law.older_at_start
        # a contact that starts in the far tail has a threshold even farther out
        survival = float(fresh.sf(max(abs(end) for end in contacts.start.span)))
        fraction = NEGLECTED * max(survival, 1e-280)  # less underflows
        furthest = min(float(fresh.isf(fraction)), fresh.support()[1])
        self.largest_stretch = law.largest_threshold(furthest, fraction, longest)
        if np.shape(self.largest_stretch) or not np.isfinite(self.largest_stretch):
            self._refuse(
                f"largest_threshold must return a finite number, not {self.largest_stretch!r}"
            )
        # no contact of the start is stretched beyond the largest threshold at t = 0
        self.largest_birth_stretch = fresh.support()[1]
        self.resolution_length = FIRST_GUESS * min(fresh.std(), fresh.mean())
        unknown = "is not known yet along paths of several legs where thresholds change"
        self.no_density = f"contacts.{law.law}: Q(x;X) {unknown}"

    @classmethod
    def made(cls, contacts: Contacts, tolerance: float, motion: Motion, until: float) -> Self:
        """The life on a motion; arguments as those of make.life_of."""
        life = cls(contacts, float(motion.times[-1]))
        life.check_survivors(motion)
        return life

    def check_survivors(self, motion: Motion) -> None:
        """InputError where what holds of contacts born relaxed at t = 0 cannot be, at instants of the first leg."""
        instants = motion.times[1] * np.array([[0.0, 1e-3, 1.0]])
        history = motion.history(instants, np.zeros((1, 1))).pick(slice(None))
        born = np.zeros(instants.size)
        found = self.survivors(born, history.largest(born), history)
        if not isinstance(found, Survivors):
            self._refuse(f"survivors must return Survivors(survival, force, error), not {found!r}")
        for name in ("survival", "force"):
            if (shape := np.shape(getattr(found, name))) != born.shape:
                self._refuse(
                    f"survivors must return a {name} of the shape {born.shape}, not {shape}"
                )
        holds = (found.survival >= 0.0) & (found.survival <= 1.0 + self.error)
        if not (holds & np.isfinite(found.force)).all() or np.ndim(found.error):
            said = f"survival {found.survival}, force {found.force}, error {found.error}"
            self._refuse(
                f"survivors must return shares from 0 to 1, finite forces and one error: {said}"
            )

    def _refuse(self, fault: str) -> NoReturn:
        """InputError for a law of one's own."""
        named = f"contacts.{', '.join(self.contacts.in_time)}"
        raise InputError(f"{named}: {type(self).__name__}: {fault}; see docs/extending.md")

    @classmethod
    def why_not(cls, contacts: Contacts, one_leg: bool = True) -> str:
        """Why these contacts have no such life on a rigid slider that keeps its speed (`one_leg`), or on one that turns
        or rests, and what to do instead; "" where they have one. Here: exact values would break together, which no
        panel resolves."""
        if not contacts.thresholds.atoms[0].size:
            return ""
        fault = "holds exact values, which the master equation does not follow while they change"
        return f"contacts.thresholds: {fault}; give them a width, as in gaussian(mean, std)"

    @classmethod
    def longest(cls, contacts: Contacts, velocity: float) -> float:
        """A time after which no contact holds on a slider of this speed v > 0, until even the strongest of the start
        are broken; InputError where none ever does."""
        law, strongest = contacts.changing, float(contacts.thresholds.isf(NEGLECTED))
        assert law is not None
        to_0 = max(-contacts.start.span[0], 0.0)  # distance that the start has to go to x = 0
        unit = contacts.mean_threshold / velocity
        longest = unit
        while law.largest_threshold(strongest, NEGLECTED, longest) > velocity * longest - to_0:
            longest *= LATER
            if longest > LATEST * unit:
                slowest = law.largest_threshold(strongest, NEGLECTED, longest) / longest
                hint = f"the strongest contacts never break below v = {slowest:.3g}, as fast as they grow; slide faster"
                refuse("velocity", velocity, hint)
        return longest
