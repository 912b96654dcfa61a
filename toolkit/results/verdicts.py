"""The verdict of a run on a soft slider: that of infinitely many contacts beside that of as many as the run follows."""

from typing import Any

import numpy as np

from origins.roughness.interface import Interface
from origins.samples.from_samples import sampled_parts
from toolkit.results.kinds import is_coupled, is_heavy, is_precise
from toolkit.results.records import Result
from toolkit.scene.scale import SHARED, of_contacts, told_contacts, written
from toolkit.scene.scene import Scene

# breaks of a slider that take some minutes, with a mass half an hour; the shortest way of a slider, in mean thresholds,
# that shows whether it slides
FOLLOWED, LEAST_DISTANCE = 1e10, 100.0
# of the force before it: a slip that takes more is one of all contacts, whoever counts it; times as many of these as
# the other solver has slips at all, and one more, are a contradiction; standard errors of a mean over sliders
_LARGE, _TIMES, _CLEARLY = 0.5, 2.0, 4.0
# how the message on a contradiction begins
DISAGREE = "disagree"
# contacts of a slider with mass of which chance makes no large slip: falls of 6 N^(-1/2) mean thresholds at most
_TOLD = 1000


def contradiction(result: Result) -> str:
    """As `disagreement`, of both solvers of a run."""
    return disagreement(result.master, result.eq)


def disagreement(solved: Any, eq: Any) -> str:
    """How the ensemble `eq` contradicts the verdict of the master equation's answer, in words that begin with
    "disagree"; "" where it does not, or where one of them is missing.

    Smooth sliding is contradicted by any slip of the ensemble. Stick-slip is where no slider slips on a path on which
    the master equation has two slips or more: a single one may come later than the path's end, as N contacts slip late.
    Any verdict is by slips of all contacts that are far more than the other solver has, as of a reset by a few of them.
    With a mass, sliders of fewer than _TOLD contacts each say nothing of that: smaller slips are not told from chance.
    """
    if solved is None or solved.regime is None or eq is None or not is_coupled(eq):
        return ""
    number, slipped = len(eq.forces), np.unique(eq.slips.replica).size
    many, verdict = of_contacts(eq.contacts // number), solved.regime.verdict
    said = f'{DISAGREE}: infinitely many contacts are "{verdict}" (master equation), but'
    if verdict == "smooth" and slipped:
        return (
            f"{said} {slipped} of {number} sliders of {many} slip: for so many contacts believe these; "
            "smooth sliding needs a stiffer spring, or more contacts"
        )
    heavy, part = is_heavy(eq), f"{eq.slip_fraction:.0%} of them"
    if heavy and eq.contacts < _TOLD * number:
        return ""
    if verdict == "stick-slip" and solved.slips.drive.size > 1 and not slipped:
        why = (
            f"no avalanche breaks {part}, so that nothing is reset; these events are no stick-slip"
        )
        why = "their force falls by no more than chance makes it" if heavy else why
        return f"{said} none of {number} sliders of {many} slips: {why}"
    if solved.path.size < eq.path.size or not is_precise(solved):
        return ""
    each = np.bincount(eq.slips.replica, minlength=number)
    own, mean = solved.slips.drive.size, each.mean()
    # of one slider the error is that of a count
    error = _CLEARLY * float(each.std(ddof=1) if number > 1 else mean**0.5) / number**0.5
    told = (
        f"disagree: infinitely many contacts slip {own} times (master equation), and sliders of {many} "
        f"{mean:.2g} times on average"
    )
    if _large(solved.slips) > _TIMES * (mean + error) + 1.0:
        why = (
            f", as an avalanche of fewer than {part} resets nothing; these events are no stick-slip"
        )
        return told + why * (not heavy)
    if _large(eq.slips) / number - error > _TIMES * own + 1.0:
        return f"{told}: for so many contacts believe these"
    return ""


def _large(slips: Any) -> int:
    """How many slips take more than _LARGE of the force."""
    return int((np.abs(slips.drop) > _LARGE * np.abs(slips.force_before)).sum())


def with_units(scene: Scene, regime: Any) -> str:
    """The reason of a soft slider's regime, with the machine's spring and K* in N/m where the surface knows them; K* of
    a rough surface or of samples has two digits."""
    reason, scale = f"{regime.reason}{_of_so_many(scene, regime)}", scene.scale
    machine, law = float(f"{scene.drive.spring or 0.0:.6g}"), scene.contacts.thresholds
    vague = isinstance(law.interface, Interface) or bool(sampled_parts(law))
    error = regime.critical_spring_error * scale.spring
    value = regime.critical_spring * scale.spring
    critical = f"K* = {written(value, scale.spring_unit, error, 2 if vague else 4)}"
    shared, told = f"K = {machine:.6g} {SHARED}", f"K* = {regime.critical_spring:.6g}"
    if scale.spring_unit == SHARED:
        return reason.replace(told, critical.removesuffix(f" {SHARED}")) if vague else reason
    spring = f"K = {written(machine * scale.spring, scale.spring_unit, digits=4)}"
    if shared in reason:
        return reason.replace(shared, spring).replace(told, critical)
    return f"{spring}, {critical}; {reason}"


def of_infinitely_many(scene: Scene, regime: Any) -> bool:
    """Whether sliding is smooth for infinitely many contacts only, as the nominal area holds too few: N K³, K in
    N_c<k>, is below some 50 (docs/sliders.md)."""
    scale, spring = scene.scale, scene.drive.spring or 0.0
    few = scale.contacts is not None and scale.contacts * spring**3 < 50.0
    return few and scale.spring_unit != SHARED and regime.verdict == "smooth"


def _of_so_many(scene: Scene, regime: Any) -> str:
    """What to add to the reason of a soft slider's regime: that the nominal area holds too few contacts for smooth
    sliding, or that the spring may be meant in N/m."""
    spring, scale = scene.drive.spring or 0.0, scene.scale
    critical, smooth = regime.critical_spring, regime.verdict == "smooth"
    if scene.contacts.interface is None and smooth and spring > 10.0 * max(critical, 1.0):
        return "; spring is in units of N_c<k>; in N/m of a surface, or with [contacts.interface]"
    number = scale.contacts
    if number is None or not of_infinitely_many(scene, regime):
        return ""
    if scene.eq is not None and abs(scene.eq.contacts - number) < 0.1 * number:
        return ""  # as [eq] tells what so many do
    said = f"; smooth only for infinitely many contacts: the area holds {told_contacts(number)}"
    return said if scene.contacts.held_in_time else said + _how_to_follow(scene, number)


def _how_to_follow(scene: Scene, number: float) -> str:
    """What to run for sliders of as many contacts as the area holds. From the first loading on each breaks about once a
    mean threshold; where these are too many breaks the path is to end sooner, which must leave it a way to slide."""
    mean, spring = scene.contacts.mean_threshold, scene.drive.spring or 0.0
    loading, distance = mean / spring, float(np.abs(np.diff(scene.path, prepend=0.0)).sum())
    advice, further = f"run [eq] contacts = {number:.0f}", FOLLOWED / number
    if distance - loading < further * mean:
        return f"; {advice}"
    said = (
        f", and [eq] would take over {FOLLOWED:.0e} breaks of each slider of so many on this path"
    )
    if further < LEAST_DISTANCE:
        return f"{said}, or on any on which it slides"
    end = written(loading + further * mean, "m", digits=6)
    return f"{said}: end it at {end}, {further:.2g} <x_s> after the spring is loaded, and {advice}"
