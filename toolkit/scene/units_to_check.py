"""Which units and keys to check where lengths, forces or a machine are none of contacts and laboratories."""

from origins.contacts import Contacts
from origins.roughness.interface import Interface
from origins.samples.from_samples import sampled_parts
from origins.thresholds.law import Thresholds
from toolkit.scene.scale import Scale, length_unit_of, of_contacts

# F_k/load of nearly parallel lattices and of glued contacts; <x_s> in m, from a nucleus to a fault's; m by which a
# spring is stretched at most: beyond these a unit is wrong
_COEFFICIENTS, _LENGTHS, _LONGEST = (1e-6, 10.0), (1e-15, 1e-2), 0.1
# contacts of which forces scatter by half of themselves; kg, far above sliders of laboratories
_FEWEST, _HEAVIEST = 10.0, 1e6


def of_units(law: Thresholds) -> list[str]:
    """Which units to check where lengths or F_k/load are none of contacts."""
    surface, mean, cautions = law.interface, law.mean(), list[str]()
    if length_unit_of(law) == "m" and not _LENGTHS[0] < mean < _LENGTHS[1]:
        cautions.append(f"<x_s> is {mean:.2g} m")
    if surface is not None and surface.contact_density and surface.pressure:
        stress = float(surface.per_area(law.moment(2) / (2.0 * mean)))
        if not _COEFFICIENTS[0] < (mu := stress / surface.pressure) < _COEFFICIENTS[1]:
            cautions.append(f"F_k/load is {mu:.2g}")
    if not cautions:
        return []
    if law.domains is not None:
        keys = "the substrate's amplitude in J and period in m, the island's unit, stiffness in N/m"
    elif sampled_parts(law):
        keys = "unit of the samples (m where none is given)"
    elif isinstance(surface, Interface):
        keys = "the surface's unit, pressure and moduli in Pa, and local_friction"
    else:
        keys = "lengths in m"
    if surface is not None and not isinstance(surface, Interface):
        keys += ", [contacts.interface] in N/m, 1/m² and Pa"
    return [f"{' and '.join(cautions)}: are all units right? check {keys}"]


def of_stretch(contacts: Contacts, spring: float) -> list[str]:
    """Which keys to check where contacts in metres stretch a spring K/(N_c <k>) by more than any machine's, and
    `of_units` has nothing to ask."""
    law = contacts.thresholds
    stretch = law.moment(2) / (2.0 * law.mean()) / spring
    if length_unit_of(law) != "m" or stretch < _LONGEST or of_units(law):
        return []
    asked = "are drive.area (m²) and drive.spring right?"
    if sampled_parts(law):
        asked = f"is the unit of the samples right, as <x_s> is {law.mean():.2g} m, and {asked}"
    return [f"F_k stretches the spring by {stretch:.2g} m: {asked}"]


def of_machine(scale: Scale, mass: float | None) -> list[str]:
    """Which keys to check where the area holds so few contacts that no distribution tells of them, or a mass M/(N_c
    <k>) (time²; None: none) is beyond any slider's."""
    cautions, number = list[str](), scale.contacts
    if number is not None and number < _FEWEST:
        cautions.append(f"drive.area holds {of_contacts(number, '.2g')}: is it right, in m²?")
    if (
        mass is not None
        and scale.spring_unit == "N/m"
        and (heavy := mass * scale.spring) > _HEAVIEST
    ):
        cautions.append(f"the slider's mass is {heavy:.2g} kg: is drive.mass right?")
    return cautions
