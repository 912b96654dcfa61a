"""Cycle: survival and force of contacts that move steadily forward, over the distance since birth.

In steady sliding contacts are born at a constant rate, so that force and density follow from
integrals over the distance, the slider's travel since a contact's birth (paper, Eqs. Q11a-Q11d):

    C = integral of E,      F_k/(N_c <k>) = (integral of K) / (C + v tau).
"""

import numpy as np

from master.renewal.births import reforming_law
from master.renewal.straight import Straight
from master.survival.life import Life
from origins import Contacts, InputError
from origins.start import Start
from origins.thresholds.law import Array

# Accuracy of tables of which only integrals are needed; and the coarsest, where E itself is known to no better.
ACCURACY, COARSEST = 1e-9, 1e-7
# Share of contacts below which numbers underflow.
UNDERFLOW = 1e-290
# Relative rounding of a moment of P_c in closed form, that of two operations; and of an integral of the survival, a sum
# of some hundred.
OF_MOMENT, OF_INTEGRAL = 4e-16, 1e-13


class Cycle(Straight):
    """E and K of contacts born at some stretches, tabulated over the distance, and their integrals (paper, Eq. Q11c).

    `born` is the law of the stretches at birth (None: that of re-forming). A panel of the table is halved until the
    last two Legendre coefficients of E, and of K over `scale`, are below `accuracy`: the error of integrals is about
    its square.

    Beside the attributes of Straight, where lags are distances (lengths, areas lengths squared):
    atoms : array of shape (n,), distances after which contacts reach exact thresholds together
    resolution_length : about the length over which E falls: mean width of the table's panels, weighted by the
        fall of E there
    most : the largest value of |K|
    wait : v tau, the travel during which a broken contact is out
    length, area : C, the integral of E, and that of K; `length_error`, `area_error` their errors
    """

    def __init__(
        self,
        contacts: Contacts,
        life: Life,
        velocity: float,
        accuracy: float = ACCURACY,
        born: Start | None = None,
    ) -> None:
        """Tabulate E and K over the distance since a birth, and integrate them."""
        check_finite(contacts)
        self.contacts, self.velocity, self.accuracy = contacts, velocity, accuracy
        self.wait = velocity * contacts.waiting_time
        born = born or reforming_law(contacts)
        longest = life.largest_stretch + max(-2.0 * float(born.span[0]), 0.0)
        # panels that follow E more closely than it is known would follow its rounding
        finest = max(accuracy, min(life.error, COARSEST))
        super().__init__(life, born, velocity, longest, finest, steady=True)
        self.atoms: Array = life.atoms - born.mean() if born.is_single else np.empty(0)
        table = self.table
        survival, borne = table(table.edges)
        self.most = float(np.abs(borne).max()) * self.scale
        lost = np.maximum(-np.diff(survival), 0.0)
        self.resolution_length = float(table.widths @ lost / lost.sum())
        units = np.array([1.0, self.scale])
        self.length, self.area = (table.integrals() * units).tolist()
        if not contacts.held_in_time and contacts.reforming is None:
            # at T = 0 both are moments of P_c; the difference from the integrals counts as their error
            law, power = contacts.thresholds, power_of(contacts)
            length, area = self.length, self.area
            self.length = law.mean()
            self.area = 0.5 * law.moment(power) / self.length ** (power - 2)
            self.length_error = abs(self.length - length) + OF_MOMENT * self.length
            self.area_error = abs(self.area - area) + OF_MOMENT * self.area
            return
        # of E on each panel, the mean of those at its ends; of K at most as many, at the stretch there
        errors = life.error_at(survival, self.survival_error)
        # Where a contact has moved beyond the largest stretch none holds, and no error can come in.
        edges = np.minimum(table.edges, life.largest_stretch - float(born.span[0]))
        missed = 0.5 * (errors[1:] + errors[:-1]) * np.diff(edges)
        own = np.array([missed.sum(), missed @ edges[1:] / self.scale])
        off = table.missed() + own
        if contacts.thermal is not None and contacts.changing is None:
            off += life.rounded_away(velocity) / units
        elif contacts.stiffness == "linked":  # farther thresholds are missing in the table of <k x>
            off += thresholds_beyond(contacts, life.largest_stretch) / units
        self.length_error = float(off[0]) + OF_INTEGRAL * self.length
        self.area_error = float(off[1]) * self.scale + OF_INTEGRAL * abs(self.area)

    @property
    def birth_to_birth(self) -> float:
        """The mean distance from a birth to the next one, a length."""
        return self.length + self.wait

    def force(self) -> tuple[float, float]:
        """F_k/(N_c <k>) and its error (paper, Eq. Q11d), lengths."""
        force = self.area / self.birth_to_birth
        return force, (self.area_error + abs(force) * self.length_error) / self.birth_to_birth


def thresholds_beyond(contacts: Contacts, far: float) -> Array:
    """Bounds on the contributions of thresholds beyond `far` (a length), whose tail is taken as a
    power, to <x_b> and <k x_b^2>, lengths to the powers 1 and 2; shape (2,)."""
    law, stiff = contacts.thresholds, float(contacts.relative_stiffness(far))
    survival, twice, power = float(law.sf(far)), float(law.sf(2.0 * far)), power_of(contacts)
    # a tail steeper than the power 1000 ends, or nearly so
    steep = min(float(np.log2(survival / twice)), 1e3) if twice > 0.0 else 1e3
    if survival > 0.0 and not steep > power:
        return np.full(2, np.inf)
    return survival * far * np.array([1.0, stiff * far]) * steep / (steep - power)


def power_of(contacts: Contacts) -> int:
    """The order of the moment of the thresholds in the kinetic force."""
    return 3 if contacts.stiffness == "linked" else 2


def check_finite(contacts: Contacts) -> None:
    """Raise InputError where the kinetic force is infinite. Heat does not help, as strong contacts hardly break before
    their threshold. Some thresholds that change are exempt: their tail does not last, or they have a largest."""
    power, changing = power_of(contacts), contacts.changing
    stays = changing is None or changing.keeps_tail
    if stays and not np.isfinite(contacts.thresholds.moment(power)):
        fault = f"<x_s^{power}> is infinite, and with it the kinetic force: it grows for ever"
        hint = f"use a law whose tail falls faster than x^-{power + 1}"
        raise InputError(f"thresholds: {fault}; {hint}")
