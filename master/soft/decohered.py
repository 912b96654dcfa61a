"""F far ahead in an instant slip, on a drive that goes forward, without the births in between.

Such a slider passes along the F(X) of a rigid one. Once none of the contacts of the start, and of those born before, is
left, F is a mean of its values over the longest life (renewal equation), and stays within them. So the load, F + K y,
stays below that of the slip's begin up to a travel that K and the largest of these values tell, and none of the births
up to there can end the slip. Behind it F is known, too:

- it is F_k where F - F_k, which falls as e^(-y/X*), is nothing any more (`LastLife.steady`);
- else it is F_k and a sum of waves that fade (`Waves`; master/stick_slip/spectrum.py). Thresholds of 1 +- 0.002 keep
  their step for 1e4 lives, which on K = 1e-6 ended a slip after 7 s; their waves are known after six lives.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from master.numerics import polynomials
from master.outcome import stop_after
from master.renewal.births import panel_at
from master.renewal.march import March
from master.soft.cold_contacts import ColdContacts
from master.soft.curve import LoadCurve, SteadyForce
from master.stick_slip.spectrum import DecoherenceSpectrum
from origins.thresholds.law import Array

# Travels along which F is looked at, in longest stretches: one life and two, and a tenth for panels at the ends.
ONE_LIFE, TWO_LIVES = 1.1, 2.2
# Contacts that decohere more slowly than within this many spans of two lives are not followed until they have where X*
# tells how much is left; modes of longer X* may be hidden by this factor in the range of the force.
DECOHERES, HIDDEN = 2.0, 100.0
# Chebyshev points in multiples of a polynomial's degree, between which it passes beyond the middle of the range of its
# values there by at most BEYOND (Ehlich and Zeller), here by a part of 3e-4: on K = 1e-6 a force that is known to 1e-3
# alone leaves a thousand lives to be followed.
FINELY = 64
BETWEEN = polynomials.values(
    0.5
    - 0.5
    * np.cos(np.pi * np.arange(FINELY * polynomials.DEGREE + 1) / (FINELY * polynomials.DEGREE))
)
BEYOND = 1.0 / np.cos(0.5 * np.pi / FINELY)
# A wave along ON_PANEL radians is met by polynomials to MISSED of its size: 2 (radians/4)^17/17! with as many nodes as
# theirs. Panels meet waves to this part of what those of a march may miss.
ON_PANEL, MISSED, OF_PANELS = 4.0, 2.0 / math.factorial(polynomials.DEGREE + 1), 1e-2
# Radians of the shortest wave between places at which F is looked at for its largest value: between them it may rise by
# 5e-4 of the waves' size, which is added.
LOOKED_AT = 0.0625
# Waves and errors below this part of a mean threshold are rounding.
ROUNDED = 1e-15
# How many lives are laid out at once, as fewer take longer by their calls, and most panels: some 5 MB of values.
AT_ONCE, MOST_PANELS = 16.0, 2000


class LastLife:
    """F on the last life of a march along a move. It is `renewed` once none of the contacts of the move's begin, and of
    those born before, was left a life ago: F is a mean of these values from there on."""

    def __init__(self, contacts: ColdContacts, march: March, begin: float, direction: int) -> None:
        """`begin` : t at which the move begins; `march.solved` is to reach beyond it."""
        largest, solved = contacts.life.largest_stretch, march.solved
        self._contacts, self.travel = contacts, solved.end - begin
        undisturbed = solved.end - max(begin, march.lumps[-1].birth)
        # contacts that begin stretched backward hold for longer
        self.renewed = undisturbed >= TWO_LIVES * largest + max(-contacts.start.span[0], 0.0)
        self._may_be_slow = undisturbed < DECOHERES * TWO_LIVES * largest
        self._panels = solved.pick(
            slice(panel_at(solved.begin, solved.end - ONE_LIFE * largest), None)
        )
        self.force = direction * self._panels.force
        self._begin, self._error = begin, largest * float(self._panels.error.max())

    @cached_property
    def _highest(self) -> float:
        """Bound on F from the march's end on (a length)."""
        values = self.force @ BETWEEN.T
        low, high = values.min(axis=1), values.max(axis=1)
        return float((0.5 * (low + high) + BEYOND * 0.5 * (high - low)).max()) + self._error

    def ahead(self, load: float) -> float:
        """How far beyond the march the load, F + K y, stays below this one (a length)."""
        return (load - self._highest) / self._contacts.spring - self.travel

    def steady(self, load: float) -> SteadyForce | None:
        """F_k, where F is that to the tolerance before the load can be at this one again; F - F_k falls as e^(-y/X*),
        and is at most the range of F to begin with."""
        contacts, ahead = self._contacts, self.ahead(load)
        if self._may_be_slow or ahead <= 0.0 or not np.isfinite(contacts.decoherence_length):
            return None
        remaining = (
            HIDDEN * float(np.ptp(self.force)) * np.exp(-ahead / contacts.decoherence_length)
        )
        if remaining > contacts.steady_rates * contacts.unit:
            return None
        kinetic, error = contacts.steady_force
        return SteadyForce(kinetic, error + remaining)

    def places(self) -> Array:
        """Travels at which `force` has its values, of its shape (lengths)."""
        begin, places = self._panels.begin - self._begin, np.append(0.0, polynomials.NODES)
        return begin[:, None] + self._panels.width[:, None] * places


class Waves:
    """F_k and the waves of F on a slider that goes forward from the path's begin, laid out on panels as far as asked.

    contacts : at T = 0, with the waves of their start
    laid_from, laid_to : travels between which it is (lengths)
    steady : F_k with its error, once the waves have faded
    """

    def __init__(
        self, contacts: ColdContacts, spectrum: DecoherenceSpectrum, travel: float
    ) -> None:
        """Lay out nothing before this travel, from which on the waves are F."""
        self._contacts, self._all = contacts, spectrum
        self._memory = ONE_LIFE * contacts.life.largest_stretch
        self._at_once = AT_ONCE * self._memory
        self.steady: SteadyForce | None = None
        self._begin_at(travel)

    @classmethod
    def behind(cls, contacts: ColdContacts, last: LastLife, load: float) -> "Waves | None":
        """The waves where they are F before the load can be at this one again; None where they are not known so soon.
        What they leave out is found from F on the last lives, and fades at a rate that is known."""
        spectrum = contacts.spectrum
        if spectrum is None or contacts.unknown or not np.isfinite(spectrum.beyond):
            return None
        spectrum = spectrum.compared_with(last.places(), last.force)
        least = contacts.of_panels * contacts.life.largest_stretch
        known = spectrum.complete_from(last.travel, least)
        if known > last.travel + max(last.ahead(load), 0.0):
            return None
        return cls(contacts, spectrum, known)

    def _begin_at(self, travel: float) -> None:
        """Drop all panels, and begin anew at this travel."""
        self._laid, self.laid_from, self.laid_to = list[LoadCurve](), travel, travel
        self._lay(travel + self._memory)
        while self.laid_to < travel + self._memory and self.steady is None:
            self._lay(travel + self._memory)

    def _lay(self, travel: float) -> None:
        """Lay panels up to this travel, or as many as are made at once."""
        contacts, begin, places = self._contacts, self.laid_to, np.append(0.0, polynomials.NODES)
        stop_after(contacts.until)
        here, sizes = self._from(begin)
        steepest = float(np.abs(here.roots).max(initial=0.0))
        off = contacts.unit * float(here.force_error([begin, travel]).max())
        # rounded places turn waves
        off += np.finfo(float).eps * begin * float(sizes @ np.abs(here.roots))
        if sizes.sum() <= contacts.steady_rates * contacts.unit:
            self.steady = SteadyForce(here.kinetic_force, off + float(sizes.sum()))
        fine = OF_PANELS * contacts.of_panels * contacts.life.largest_stretch
        widths = (
            ON_PANEL
            / np.abs(here.roots)
            * (fine / (MISSED * sizes)) ** (1.0 / (polynomials.DEGREE + 1))
        )
        width = float(widths.min(initial=self._memory))
        count = int(min(np.ceil((travel - begin) / width), MOST_PANELS))
        edges: Array = begin + width * np.arange(count + 1, dtype=np.float64)
        force = here.force_beside(edges[:-1], width * places)
        # what is off are waves, and no steeper than those on the panel, where LoadCurve expects noise
        own = off * steepest * width / (2.0 * polynomials.DEGREE**2) + fine
        panels = LoadCurve(
            from_travel=edges[:-1],
            width=np.diff(edges),
            series=force @ polynomials.TO_LEGENDRE.T,
            error=np.full(count, off),
            own_error=np.full(count, own),
            drops=np.empty(0),
            spring=contacts.spring,
            break_length=contacts.break_length,
        )
        self._laid.append(panels)
        self.laid_to = float(edges[-1])
        contacts.nodes += force.size

    def curve_to(self, y: float) -> LoadCurve:
        """The load on the panels that are kept, up to the travel y at least."""
        while self.laid_to < y and self.steady is None:
            self._lay(max(y, self.laid_to + self._at_once))
        curve = _joined(self._laid)
        largest = self._contacts.life.largest_stretch
        return curve if self.steady is None else self.steady.extend(curve, y, largest)

    def skip(self, load: float, y: float) -> float:
        """A travel >= y that the slider passes before the load, F + K y, is at this one again; panels more than a life
        before it are dropped."""
        begin = y = max(y, self.laid_from)
        if self.steady is None:
            # where the load all but reaches it, lives are followed instead
            while (
                farther := (load - self._highest(y)) / self._contacts.spring
            ) > y + self._at_once:
                y = farther
        if y > begin:
            self._begin_at(y)
        self._laid = [one for one in self._laid if one.to_travel > y - self._memory] or self._laid[
            -1:
        ]
        return y

    def _from(self, y: float) -> tuple[DecoherenceSpectrum, Array]:
        """The waves from the travel y on, and their sizes there (lengths)."""
        here = self._all.from_place(y, ROUNDED * self._contacts.unit)
        return here, np.abs(here.amplitude) * np.exp(y * here.roots.real)

    def _highest(self, y: float) -> float:
        """A bound on F from the travel y on (a length): F is a mean of its values over the life before."""
        here, sizes = self._from(y)
        if not sizes.size:
            return here.kinetic_force
        fastest = np.abs(here.roots)
        step = LOOKED_AT / float(fastest.max())
        count = int(np.sqrt(self._memory / step)) + 2
        further = step * np.arange(count, dtype=np.float64)
        force = here.force_beside(y + count * further, further)
        between = 0.125 * step**2 * float(sizes @ fastest**2)
        off = self._contacts.unit * float(here.force_error(y))
        return float(force.max()) + between + off


def _joined(curves: Sequence[LoadCurve]) -> LoadCurve:
    """Panels without drops that follow one another, as one curve."""
    return replace(
        curves[0],
        from_travel=np.concatenate([one.from_travel for one in curves]),
        width=np.concatenate([one.width for one in curves]),
        series=np.concatenate([one.series for one in curves]),
        error=np.concatenate([one.error for one in curves]),
        own_error=np.concatenate([one.own_error for one in curves]),
    )
