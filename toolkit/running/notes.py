"""What to tell a user of a run beside its numbers."""

import numpy as np

from origins.contacts import Contacts, too_hot
from toolkit.results.records import SimulatedRecord, SolvedRecord
from toolkit.scene.scene import Scene

_FAR = 1e6  # mean thresholds: a longer drive is hardly meant
_FEW = 1e-6  # of the thresholds
_EPSILON = 8.0 * float(np.finfo(float).eps)


def foreseen(scene: Scene) -> list[str]:
    """What to tell before a run: drives as far as in another unit, temperatures at which contacts hold nothing,
    stretches beyond nearly all thresholds, and what the numbers of the surface leave out of the contacts."""
    contacts = scene.contacts
    return [*_too_far_driven(scene), *_too_hot(contacts), *_too_far(contacts), *_left_out(contacts)]


def _too_far_driven(scene: Scene) -> list[str]:
    """A drive that seems to be in another unit than the thresholds."""
    if scene.given_drive is None:
        return []
    mean = scene.contacts.mean_threshold
    reach = float(np.abs(scene.path).max()) / mean
    unit = " m" if scene.contacts.interface is not None else ""
    far = f"the drive goes as far as {reach:.1g} mean thresholds of {mean:.3g}{unit}; is it meant in that unit?"
    return [far] if reach > _FAR else []


def all_hold(scene: Scene, master: SolvedRecord | None, eq: SimulatedRecord | None) -> list[str]:
    """A note where nothing breaks, which beside both solvers the comparison says."""
    if (master is None) == (eq is None):
        return []
    contacts, to_within = scene.contacts, ""
    if eq is not None:
        broken = eq.breaks > 0
    elif master is not None:
        error = master.force_error * contacts.mean_threshold
        moved = getattr(master, "position", master.path)
        if not moved.size:  # the path is cut at its first point
            return []
        lost = moved - moved[0] - (master.force - master.force[0])
        broken = not master.success or float(np.abs(lost).max()) > error + _EPSILON * float(
            np.abs(moved).max()
        )
        to_within = ", as far as the error tells"
    if broken:
        return []
    reach = float(np.abs(scene.path).max()) / contacts.mean_threshold
    return [
        f"no contact breaks on this path{to_within}: it reaches {reach:.2g} <x_s>, and sliding takes several"
    ]


def _too_hot(contacts: Contacts) -> list[str]:
    thermal = contacts.thermal
    told = "" if thermal is None else too_hot(thermal.temperature, contacts.thresholds)
    return [told] if told else []


def _too_far(contacts: Contacts) -> list[str]:
    """Starts and re-forming where hardly any contact can hold."""
    said = []
    again = [] if contacts.reforming is None else [(contacts.reforming.law, "form again")]
    for law, they in [(contacts.start, "start"), *again]:
        middle = law.mean() if law.is_single else float(law.ppf(0.5))
        exceed = float(contacts.thresholds.sf(abs(middle)))
        if exceed < _FEW:
            said.append(
                f"contacts {they} about x = {middle:.3g}, and only {exceed:.0e} of all thresholds are beyond that: "
                "they have the thresholds of that tail, and break at once"
            )
    return said


def _left_out(contacts: Contacts) -> list[str]:
    laws_of = {"temperature": contacts.thermal, "ageing": contacts.ageing, "delay": contacts.delay}
    there = [
        name
        for name, law in {**laws_of, "re-forming": contacts.reforming}.items()
        if law is not None
    ]
    if contacts.interface is None or not there:
        return []
    return [
        f"F_k/load and the stress of the surface are those of its thresholds alone, without {', '.join(there)}"
    ]


def went_on(before: int) -> list[str]:
    """What a run that goes on tells of those before it as of itself."""
    if not before:
        return []
    return [
        f"went on from a checkpoint of {before:,} contacts: the run time of eq is that of all launches together, and "
        "breaks_per_rank counts the earlier ones' on rank 0"
    ]
