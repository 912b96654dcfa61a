"""What to tell a user of a run beside its numbers."""

import numpy as np

from origins.contacts import too_hot
from toolkit.scene.scene import Scene

_FAR = 1e6  # mean thresholds: a longer drive is hardly meant
_FEW = 1e-6  # of the thresholds


def foreseen(scene: Scene) -> list[str]:
    """What to tell before a run: drives as far as in another unit, temperatures at which contacts hold nothing,
    stretches beyond nearly all thresholds, and what the numbers of the surface leave out of the contacts."""
    contacts, law, said = scene.contacts, scene.contacts.thresholds, []
    unit = " m" if contacts.interface is not None else ""
    if scene.given_drive is not None:
        reach = float(np.abs(scene.path).max()) / contacts.mean_threshold
        if reach > _FAR:
            said.append(
                f"the drive goes as far as {reach:.1g} mean thresholds of {contacts.mean_threshold:.3g}{unit}; is it "
                "meant in that unit?"
            )
    if contacts.thermal is not None:
        said += filter(None, [too_hot(contacts.thermal.temperature, law)])
    again = [] if contacts.reforming is None else [(contacts.reforming.law, "form again")]
    for own, they in [(contacts.start, "start"), *again]:
        middle = own.mean() if own.is_single else float(own.ppf(0.5))
        exceed = float(law.sf(abs(middle)))
        if exceed < _FEW:
            said.append(
                f"contacts {they} about x = {middle:.3g}, and only {exceed:.0e} of all thresholds are beyond that: "
                "they have the thresholds of that tail, and break at once"
            )
    laws: dict[str, object] = {
        "temperature": contacts.thermal,
        "ageing": contacts.ageing,
        "delay": contacts.delay,
    }
    laws["re-forming"] = contacts.reforming
    there = ", ".join(name for name, own in laws.items() if own is not None)
    if contacts.interface is not None and there:
        said.append(
            f"F_k/load and the stress of the surface are those of its thresholds alone, without {there}"
        )
    return said


def went_on(before: int) -> list[str]:
    """What a run that goes on tells of those before it as of itself."""
    if not before:
        return []
    return [
        f"went on from a checkpoint of {before:,} contacts: the run time of eq is that of all launches together, and "
        "breaks_per_rank counts the earlier ones' on rank 0"
    ]
