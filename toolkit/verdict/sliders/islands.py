"""Sliders on islands whose P_c is a smooth law through samples: their slips are those of the barriers themselves."""

import time

import numpy as np

from origins.contacts import Contacts
from origins.samples.from_samples import Sampled
from origins.thresholds.families import identical
from origins.thresholds.mixture import mixture
from toolkit.scene.of_samples import of_smoothing
from toolkit.verdict.sliders.ensemble import follow_by_contacts
from toolkit.verdict.sliders.follow import TOLERANCE_IN_TIME, follow
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.sliders.ways import loading_of

# barriers in a bin of the law of these, and most bins: more change F by less than the sampling of 20,000 barriers does
IN_A_BIN, MOST_BINS = 20, 1000
# contacts of each slider that are followed first, in a second or two; all of the area's are followed after these, in
# the time that is left
FIRST_CONTACTS = 64_000
# most different barriers, as of listed angles, that are exact values
EXACT_BARRIERS = 100


def with_barriers(contacts: Contacts) -> Contacts:
    """These contacts with thresholds drawn from the barriers of the islands, where these are many in bins of equal
    weight; they themselves where their law is no smooth one through samples.

    Barriers that stand still in the angle are many at one value. A smooth law misses how steep it is there: of a flake
    of 43 atoms slips were told from 4.5 mN, which come at 3.2 mN.
    """
    from scipy import stats

    law = contacts.thresholds
    if not of_smoothing(law) or not isinstance(law, Sampled):
        return contacts
    if law.samples.size <= EXACT_BARRIERS:
        values = [identical(value) for value in law.samples.tolist()]
        return contacts.replace(thresholds=mixture(values, law.fractions))
    bins = int(np.clip(law.samples.size // IN_A_BIN, 1, MOST_BINS))
    up_to = np.append(0.0, np.cumsum(law.fractions))
    ends = np.append(law.samples[0], law.samples)
    edges = np.unique(np.interp(np.linspace(0.0, 1.0, bins + 1), up_to, ends))
    weights = np.diff(np.interp(edges, ends[1:], up_to[1:], left=0.0))
    return contacts.replace(
        thresholds=stats.rv_histogram((weights / np.diff(edges), edges), density=True)
    )


def follow_contacts(
    machine: Machine,
    contacts: Contacts,
    rule: str,
    rigid: RigidSlider,
    wall_time: float,
    rings: bool = False,
    tolerance_in_time: float = TOLERANCE_IN_TIME,
) -> Behaviour:
    """What a slider on any contacts does, by `follow`; but on islands, whose slips hang on the smoothing of P_c under
    the rules that renew contacts after one, by the ensemble, with the barriers themselves."""
    barriers = with_barriers(contacts)
    if barriers is contacts or contacts.held_in_time or rule not in ("reset", "reform-after"):
        return follow(machine, contacts, rule, rigid, wall_time, rings, tolerance_in_time)
    loading = loading_of(machine, contacts, rigid.static)
    until = time.monotonic() + wall_time
    return follow_by_contacts(machine, barriers, rule, loading, until, rigid, FIRST_CONTACTS)
