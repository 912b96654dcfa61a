"""Ways of a soft slider at T = 0 that take too long to follow, and are refused: of a drive that goes forward."""

import numpy as np

from master.motion import Motion
from master.renewal.births import Births
from master.renewal.edges import edges
from master.soft.cold_contacts import ColdContacts
from origins import Contacts
from origins.drive import Drive
from origins.errors import refuse

# Most instants at which exact thresholds break on the way of a slider that slips from one to the next; as many take
# some 5 s for one value, 30 s for two values.
MOST_TOGETHER = 2000
# Most slips along a path: as many take some 20 s.
MOST_SLIPS = 20_000
# Way on which they are counted first, in mean thresholds.
FIRST_DISTANCE = 50.0
# Longest life of contacts, in mean thresholds, up to which breaks are followed until they are steady: some 25 s.
LONGEST_LIFE = 500.0
# Thresholds at which the first breaks are looked at.
QUANTILES = 2000


def refuse_endless_slips(
    contacts: Contacts, cold: ColdContacts, drive: Drive, all_together: bool
) -> None:
    """InputError where exact thresholds, which re-form at once, break together too often on the path. `all_together`:
    all contacts at each instant.

    The slider has moved at least to where the largest possible force balances the drive, and breaks at each instant
    up to there follow from those before, without any march.
    """
    if drive.slip != "instant" or not cold.life.atoms.size:
        return
    largest = cold.life.largest_stretch
    stretched = float(contacts.relative_stiffness(largest)) * largest / cold.spring
    distance = float(drive.path[-1]) - stretched
    ahead, breaks, most = FIRST_DISTANCE * cold.unit, 0, MOST_TOGETHER
    if all_together:
        breaks, most = int(min(distance / cold.unit, 2.0 * MOST_SLIPS)), MOST_SLIPS
    # way after way, as to count all instants would take long where there are millions
    while not all_together and breaks <= most and ahead < 2.0 * distance:
        motion = Motion.along(np.array([0.0, min(ahead, distance)]))
        plan = edges(Births(cold.life, cold.reforming, motion), contacts.start, cold.of_panels)
        ahead, breaks = 2.0 * ahead, plan.times.size
    if breaks > most:
        fault = f"the slider goes on by {distance:.3g}, and contacts of exact thresholds break"
        what = f"together more than {most:,} times on the way"
        hint = 'give the values a width, end the path sooner, or take "reset" or "reform-after"'
        refuse("path[-1]", drive.path[-1], f"{fault} {what}; {hint}")


def refuse_long_lives(contacts: Contacts, cold: ColdContacts, drive: Drive) -> None:
    """InputError where the slider goes with its drive for longer than contacts of a heavy tail can be followed.

    From relaxed contacts F is at most <x_s^2>/<x_s>, by Lorden's inequality of renewal theory. A slip that leaves
    no contact as it was ends this way; up to second breaks F' is 1 - X P_c(X), and tells whether there is one.
    """
    law, unit, longest = contacts.thresholds, cold.unit, cold.life.largest_stretch
    if longest <= LONGEST_LIFE * unit:
        return
    latest = law.moment(2) / law.mean() / cold.spring
    distance = float(drive.path[-1]) - latest
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.reforming is None
    if not (relaxed and contacts.stiffness == "independent" and distance > LONGEST_LIFE * unit):
        return
    x = law.isf((np.arange(QUANTILES) + 0.5) / QUANTILES)
    slips = float((x * law.pdf(x)).max()) > 1.0 + cold.spring
    if drive.slip == "instant" or not slips:
        fault = f"contacts of a heavy tail, that hold for up to {longest / unit:.3g} mean thresholds, are followed"
        most = f"for {LONGEST_LIFE:g}, and the slider goes on by {distance / unit:.3g}"
        hint = f"end the path before {latest + LONGEST_LIFE * unit:.4g}, or cut the tail"
        refuse("path[-1]", drive.path[-1], f"{fault} {most}; {hint}")
