"""What a verdict is compared over: readings of one surface, by contact model, threshold law and resolution; and slip
rules."""

import tomllib
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from origins.contacts import Contacts
from origins.errors import InputError, refuse
from origins.roughness.interface import Interface
from toolkit.scene.interfaces import why_infinite
from toolkit.scene.of_samples import of_listed_angles
from toolkit.scene.scene import Scene, make_contacts
from toolkit.scene.tables import DriveTable, read_table
from toolkit.verdict.sliders.budget import MORE_TIME
from toolkit.verdict.sliders.machine import RULES, machine_of

# contact model / threshold law; a third word names the regime of the summits, as in "gw/amontons/mixed"
READINGS = ("gw/amontons", "gw/strength", "gw/paper", "persson/amontons", "persson/paper")
# also compared where the material has a hardness
PLASTIC_TOO = ("gw/amontons/mixed", "gw/strength/mixed", "gw/paper/mixed")
LAWS, REGIMES = ("amontons", "strength", "paper"), ("elastic", "plastic", "mixed")
# of the contacts; where fewer are plastic the jump of P_c between regimes is in its tail
FEW_PLASTIC = 0.1
SLOW = (
    f"K* takes seconds where fewer than {FEW_PLASTIC:.0%} of the contacts are plastic, and may be larger by orders of "
    "magnitude; list them in verdict.readings"
)
STRETCHED = 'contacts that re-form stretched would be out in a slip by "reform-after", or by "instant" with a delay'
STEPS = (1, 2)  # of the scan's points: twice the distance shows what the resolution decides


@dataclass(frozen=True)
class Reading:
    """One set of assumptions about the surface, and the contacts that follow from it.

    name : such as "gw/amontons, step 2"; own : whether it is what the scene itself says
    contacts : None where these assumptions cannot be made; refused : why
    """

    name: str
    own: bool
    contacts: Contacts | None
    refused: str = ""


def readings_of(scene: Scene, quick: bool = False) -> list[Reading]:
    """The scene's own reading first, then those of its [verdict] table, or the usual ones of a surface, if
    `quick` without contacts of mixed ones where few are plastic, as K* takes seconds then.

    Thresholds that are no surface's have one reading. A reading for which the material lacks a constant, or that is
    left out as too slow, is kept with the reason. Raises InputError for readings that are none.
    """
    given = tomllib.loads(scene.text)
    asked, table = scene.verdict, given["contacts"]["thresholds"]
    if table.get("kind") != "from-topography":
        for name in ("readings", "steps"):
            if asked is not None and (given_here := getattr(asked, name)):
                refuse(f"verdict.{name}", given_here, "are of a surface; leave them out")
        return [Reading(str(table.get("kind")), True, scene.contacts)]
    # a surface given by its moments has no points, so no distance of points
    has_heights = table["surface"].get("kind") in ("scan", "self-affine")
    own_step = table.get("step", 1) if has_heights else 1
    words = [table["model"], table["law"], table.get("regime", "elastic")]
    own = ("/".join(words).removesuffix("/elastic"), own_step)
    usual = READINGS + PLASTIC_TOO * ("hardness" in table["material"])
    listed = None if asked is None else asked.readings
    names = list(usual) if listed is None else listed
    slow = PLASTIC_TOO if quick and listed is None and _few_are_plastic(scene) else ()
    steps = sorted({own_step * k for k in STEPS}) if has_heights else [1]
    steps = steps if asked is None or asked.steps is None else asked.steps
    for name in names:
        dict(_parts(name))  # refuses what is no reading before any work
    each = [(name.removesuffix("/elastic"), step) for step in steps for name in names]
    found = [Reading(_title(*own, steps), True, scene.contacts)]
    for name, step in dict.fromkeys(each):
        if (name, step) != own and name in slow:
            found.append(Reading(_title(name, step, steps), False, None, SLOW))
        elif (name, step) != own:
            found.append(_read(scene, given, name, step, _title(name, step, steps)))
    return found


def acting(rules: Sequence[str], contacts: Contacts) -> tuple[str, ...]:
    """These slip rules, each once; with a delay contacts that break in a slip wait for it under all of them but
    "reset", so that "instant" is "reform-after". That is left out where contacts form again stretched (`STRETCHED`)."""
    late = bool(contacts.waiting_time)
    act = ["reform-after" if late and rule == "instant" else rule for rule in rules]
    stretched = contacts.reforming is not None
    return tuple(rule for rule in dict.fromkeys(act) if not (stretched and rule == "reform-after"))


def rules_of(scene: Scene, table: DriveTable) -> tuple[str, ...]:
    """The slip rules to compare, as they act: those of [verdict], else all, that of [drive] first; with a mass
    none of them, but "mass". Raises InputError also for a machine that is none, before any work."""
    machine_of(table, scene.contacts)
    if table.mass is not None:
        if table.slip is not None:
            hint = "mass, damping and the contacts' delay decide; leave it out, or the mass"
            refuse("drive.slip", table.slip, hint)
        if scene.verdict is not None and scene.verdict.rules is not None:
            hint = "are for a slider without mass; leave them out, or the mass"
            refuse("verdict.rules", scene.verdict.rules, hint)
        return ("mass",)
    named = scene.verdict.rules if scene.verdict is not None else None
    own = [table.slip or RULES[0]]
    where = "drive.slip" if named is None else "verdict.rules"
    for rule in named or own:
        if rule not in RULES:
            refuse(where, rule, f"must be among {', '.join(RULES)}")
        if not acting([rule], scene.contacts):
            refuse(where, rule, f'{STRETCHED}, which no solver takes; use "reset"')
    return acting(named or [*own, *RULES], scene.contacts)


def _few_are_plastic(scene: Scene) -> bool:
    """Whether fewer contacts than FEW_PLASTIC are, or would be, plastic in the scene's own reading."""
    surface = scene.contacts.interface
    return isinstance(surface, Interface) and (surface.plastic_fraction or 0.0) < FEW_PLASTIC


def why_late(contacts: Contacts) -> list[str]:
    """Why a reading of these contacts may not be solved in time, and what is known of it all the same; else none."""
    law = contacts.thresholds
    if contacts.thermal is not None and contacts.growing is not None:
        hint = f"{MORE_TIME}, or run the scene with [eq], which needs neither"
        return [f"F_s and K* of contacts that grow and break by heat may take minutes: {hint}"]
    if not law.atoms[0].size or contacts.in_time:
        few = of_listed_angles(law)
        hint = f"F_s of islands may take minutes of the processor: {MORE_TIME}, or run the scene with [eq]"
        return few or [hint] * (law.domains is not None)
    hint = f"F_s of exact values may take a minute of the processor: {MORE_TIME}"
    return [why_infinite(contacts), hint]


def _title(name: str, step: int, steps: list[int]) -> str:
    return f"{name}, step {step}" if len(steps) > 1 else name


def _read(scene: Scene, given: dict[str, Any], name: str, step: int, title: str) -> Reading:
    """The contacts of the scene with another model, law and step of its surface."""
    tables = deepcopy(given)
    own = tables["contacts"]["thresholds"]
    own |= dict(_parts(name))
    if own["surface"].get("kind") in ("scan", "self-affine"):
        own["step"] = step
    elif step != 1:
        refuse("verdict.steps", step, "is of a surface with heights; leave it out")
    if own["model"] == "persson":
        own.pop("regime", None)
    try:
        if own["model"] == "persson" and "patch_area" not in own:
            # patches as large as the contacts that Greenwood and Williamson's summits make
            own["patch_area"] = _mean_contact_area(scene, tables)
        elif own["model"] == "gw":
            own.pop("patch_area", None)
        return Reading(title, False, _made(scene, tables))
    except InputError as error:
        return Reading(title, False, None, str(error))


def _parts(name: str) -> Iterator[tuple[str, str]]:
    """Model, law and regime of a reading's name; InputError for a name of another form."""
    words = name.split("/")
    valid = words[0] in ("gw", "persson") and len(words) in (2, 3) and words[1] in LAWS
    if not valid or (len(words) == 3 and (words[0] != "gw" or words[2] not in REGIMES)):
        hint = (
            'must be a model and a law, as "gw/amontons", or those and a regime, as "gw/paper/mixed": models are gw '
            f"and persson, laws {', '.join(LAWS)}, regimes of gw {', '.join(REGIMES)}"
        )
        refuse("verdict.readings", name, hint)
    if words[:2] == ["persson", "strength"]:
        hint = "patches of one area would all break at one threshold; take gw/strength"
        refuse("verdict.readings", name, hint)
    yield from zip(("model", "law", "regime"), words, strict=False)
    if len(words) == 2:
        yield "regime", "elastic"


def _mean_contact_area(scene: Scene, tables: dict[str, Any]) -> float:
    """Mean area (m²) of a contact by Greenwood and Williamson, at the same pressure and resolution."""
    other = deepcopy(tables)
    other["contacts"]["thresholds"] |= {"model": "gw", "regime": "elastic"}
    surface = _made(scene, other).interface
    return float(surface.mean_area) if surface is not None else 0.0


def _made(scene: Scene, tables: dict[str, Any]) -> Contacts:
    return make_contacts(read_table(tables).contacts, scene.folder, None)
