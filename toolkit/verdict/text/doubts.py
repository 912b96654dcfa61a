"""What makes a verdict doubtful as a whole, before its answer."""

from toolkit.scene.interfaces import doubts
from toolkit.scene.units_to_check import of_machine, of_stretch
from toolkit.verdict.answers import Verdict


def warnings(verdict: Verdict) -> list[str]:
    """Why no number of the verdict can be trusted, before all else; empty as a rule."""
    own, found = verdict.own, doubts(verdict.own.contacts)
    if own.machine is not None:
        found += of_stretch(own.contacts, own.machine.spring)
        found += of_machine(own.scale, own.machine.mass)
    return [f"do not trust this: {doubt}" for doubt in found]
