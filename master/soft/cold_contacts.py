"""Contacts at T = 0 under a spring: their life, how exactly they are followed, and what they tend to."""

from functools import cached_property

import numpy as np

from master.motion import Motion
from master.renewal.births import reforming_law
from master.steady.cycle import Cycle
from master.stick_slip.roots import decoherence_length
from master.stick_slip.spectrum import DecoherenceSpectrum, leading_terms
from master.survival.life import ColdLife
from origins import Contacts, InputError
from origins.start import Start

# Part of the tolerance, and of K, that a panel may miss, and most, in mean thresholds: the begin of a slip depends on
# F', and the error of a polynomial's slope is some hundred times that of its values. The least, a share of the
# contacts, is round-off.
OF_PANELS, MOST_OF_PANELS, LEAST_OF_PANELS = 1e-4, 1e-6, 1e-13
# Where F falls nowhere no slip begins, and a panel may miss this part of the tolerance: asked of laws that hold longer
# than so many mean thresholds, of which as many panels are followed.
OF_RISING, LONG_LIFE = 1e-2, 100.0
# Thresholds at which the rate of breaking is compared, at equal shares of the contacts and along the tail to FAR; and
# the rounding of its log.
QUANTILES, FAR, RATE_ROUNDED = 2000, 1e-12, 1e-9
# Breaks are steady where their rates agree to this share over the longest life, or to this part of the tolerance and of
# K; rates of steady breaks differ by up to 5e-12, the rounding of slopes (measured on panels of half a mean threshold).
STEADY_RATES, OF_STEADY = 1e-10, 1e-2
# Number of slips, whose errors add up, beyond which each is found finer in proportion.
FEW_SLIPS = 100.0


class ColdContacts:
    """Contacts at T = 0 under a spring, with the tolerance and limits of their solution.

    start, reforming : stretches at t = 0, and at which broken contacts form again
    unit, spring : mean threshold (a length), and K/(N_c <k>)
    tolerance : of the force, in mean thresholds; of_panels : that of the number of breaks on a panel
    until : reading of time.monotonic() at which to stop
    largest_stiffness : of a contact, in <k>
    steady_stiffness : mean over contacts on a slider that has moved far, in <k>: where stiffness is linked to
        thresholds, above 1, as they are met in proportion to these
    break_length : the force of contacts born together changes no faster than by the largest one over this length
    unknown : bound on what laws that are left out change in the force at a given X (a length)
    nodes : instants at which number conservation was solved
    """

    def __init__(
        self,
        contacts: Contacts,
        spring: float,
        tolerance: float,
        until: float,
        drive_distance: float = 0.0,
    ) -> None:
        """`drive_distance`: that on which errors of slips add up (a length)."""
        self._contacts = contacts
        self.life, self.unit = ColdLife(contacts), contacts.mean_threshold
        self.start = contacts.start
        self.reforming = reforming_law(contacts)
        self.largest_stiffness = float(contacts.relative_stiffness(self.life.largest_stretch))
        # from slip to slip of all contacts these and the spring are loaded by about a mean threshold
        slips = drive_distance * spring / ((1.0 + spring) * self.unit)
        finer = min(1.0, FEW_SLIPS / max(slips, 1.0))
        of_panels = OF_PANELS * finer * min(tolerance, MOST_OF_PANELS, spring)
        if self.life.largest_stretch > LONG_LIFE * self.unit and never_falls(contacts):
            of_panels = OF_RISING * finer * tolerance
        # a panel's error is a share of the contacts, each of which bears the largest stretch at most
        self.of_panels = max(of_panels * self.unit / self.life.largest_stretch, LEAST_OF_PANELS)
        law, linked = contacts.thresholds, contacts.stiffness == "linked"
        self.steady_stiffness = float(law.moment(2) / law.mean() ** 2) if linked else 1.0
        # of contacts born at 0, K(x) = x sf(x), so that |K'| is at most 1 + x p(x)
        edges = self.life.panels
        broken, width = -np.diff(contacts.thresholds.sf(edges)), np.diff(edges)
        density = np.divide(broken, width, out=np.zeros(width.size), where=width > 0.0)
        steepest = 1.0 + float((edges[1:] * density).max(initial=0.0))
        self.break_length = self.life.largest_stretch / steepest
        self.steady_rates = max(STEADY_RATES, OF_STEADY * min(tolerance, spring))
        self.spring, self.tolerance, self.until = spring, tolerance, until
        self.unknown, self.nodes = 0.0, 0

    @property
    def all_alike(self) -> bool:
        """Whether all contacts have one exact threshold."""
        low, high = self._contacts.thresholds.support()
        return bool(low == high)

    @cached_property
    def _cycle(self) -> Cycle:
        return Cycle(self._contacts, self.life, 1.0)

    @property
    def steady_force(self) -> tuple[float, float]:
        """F_k/(N_c <k>) of a slider that moves forward, and its error (lengths)."""
        return self._cycle.force()

    @cached_property
    def spectrum(self) -> DecoherenceSpectrum | None:
        """The waves of F on a slider that goes forward from the start; None where they are not told, as of exact
        thresholds or heavy tails."""
        try:
            return leading_terms(self._cycle)
        except InputError:
            return None

    @cached_property
    def decoherence_length(self) -> float:
        """X*, not too short by its error (a length); inf where F does not tend to F_k as an exponential."""
        if self.spectrum is not None and self.spectrum.roots.size:
            return float(self.spectrum.decay_length[0] + self.spectrum.decay_length_error[0])
        length, error = decoherence_length(self._cycle)
        return length + error

    def force_of(self, start: Start, travel: float = 0.0) -> float:
        """F/(N_c <k>) of contacts with these stretches (a length), after a travel of either sign on which none forms
        again."""
        motion = Motion.along(np.array([0.0, travel + np.copysign(self.unit, travel)]))
        birth = np.zeros((1, 3))
        history = motion.history(birth + abs(travel), birth)
        return float(self.life.survival_and_force(start, history).force[0, 0])


def never_falls(contacts: Contacts) -> bool:
    """Whether F only rises on a slider that goes forward: where the rate p/S at which contacts break, per length, falls
    with their stretch all along. Then a contact's stretch grows at random with X (Brown, Ann. Probab. 8, 1980)."""
    law = contacts.thresholds
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.reforming is None
    alike = contacts.stiffness == "independent" and not law.atoms[0].size
    if not (relaxed and alike and law.support()[0] == 0.0):
        return False
    shares = (np.arange(QUANTILES) + 0.5) / QUANTILES
    x = law.isf(np.append(shares[::-1], np.geomspace(shares[0], FAR, QUANTILES)[1:]))
    return bool(np.diff(law.logpdf(x) - law.logsf(x)).max() <= RATE_ROUNDED)
