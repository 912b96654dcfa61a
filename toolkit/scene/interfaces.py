"""Information on a scene beside its solvers' answers: a rough surface in SI units, and warnings on laws and runs."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, cast

import numpy as np

from origins.contacts import Contacts, Thermal
from origins.laws.temperature import too_hot
from origins.roughness.interface import Interface
from origins.roughness.moments import SpectralMoments
from origins.roughness.stated import InSI
from origins.thresholds.gaussian import CutGaussian
from origins.thresholds.law import Thresholds
from toolkit.scene.barriers import of_barriers, of_other_barriers
from toolkit.scene.of_samples import of_islands, of_samples
from toolkit.scene.scale import length_unit_of, of_contacts, written
from toolkit.scene.scene import Scene
from toolkit.scene.units_to_check import of_stretch, of_units

_UNITS = {"pressure": "Pa", "kinetic_stress": "Pa", "separation": "m", "mean_radius": "m"}
_UNITS |= {"mean_plane_separation": "m", "patch_area": "m2", "mean_area": "m2", "mean_load": "N"}
_UNITS |= {"rms_height": "m", "summit_radius": "m", "summit_density": "1/m2"}
_OF_SURFACE = "rms_height", "rms_slope", "summit_radius", "summit_density"
_UNITS |= {"mean_force_threshold": "N", "contact_density": "1/m2", "mean_stiffness": "N/m"}

# of a scan, what its errors do not count
NUMERICAL_ONLY = (
    "errors are numerical only, not those of the surface, its resolution (step) or the threshold law: what another "
    "patch or step would give is not in them, and may change K* by orders of magnitude"
)
# of the load: where plastic contacts bear more the elastic theory says nothing
_MOSTLY = 0.5
# numbers that are temperatures of a room in °C, and no usual ones in K; 0 °C in K
_ROOM, _ZERO_CELSIUS = (10.0, 40.0), 273.15
# K, between which a temperature is one that was given as such
_KELVINS = 0.1, 1e4
# of the distances of a scan's points along both axes, by which they are uneven, and as good as even
_UNEVEN, _EVEN = 0.1, 0.02
# of F_k: what linked stiffness adds below it is no news
_NO_NEWS = 0.01


@dataclass(frozen=True)
class Number:
    """A value, its error (same unit; None where the value has none) and its unit: "" for a pure number."""

    value: float
    error: float | None
    unit: str

    @property
    def lost(self) -> bool:
        """Whether its error is as large as itself; where that is numerical it says nothing. 0 and infinity do."""
        return 0.0 < abs(self.value) < np.inf and (self.error or 0.0) >= abs(self.value)


def of_interface(interface: InSI) -> dict[str, Number]:
    """Numbers of the interface in SI units, without the law's mean; of a rough one those of its surface, too."""
    names: list[str] = [
        field.name for field in fields(cast(Any, interface)) if field.name != "mean_threshold"
    ]
    names += [name for name, value in vars(type(interface)).items() if isinstance(value, property)]
    numbers = {}
    for name in names:
        if isinstance(value := getattr(interface, name), float):
            # height integrals are good to 1e-8, as tests check; what is stated has no error
            stated = name in ("pressure", "patch_area") or not isinstance(interface, Interface)
            error = None if stated else abs(value) * 1e-8
            numbers[name] = Number(value, error, _UNITS.get(name, ""))
    if isinstance(interface, Interface):
        for name in _OF_SURFACE:
            numbers[name] = Number(getattr(interface.moments, name), None, _UNITS.get(name, ""))
    return numbers


def in_a_line(numbers: Mapping[str, Number]) -> str:
    """The most important of them as a line of text."""
    value = {name: number.value for name, number in numbers.items()}
    if "area_fraction" not in value:
        density = f"{value['contact_density']:.3g} contacts/m², " * ("contact_density" in value)
        return f"{density}<k> = {value['mean_stiffness']:.3g} N/m, as stated"
    share = f"{value['area_fraction']:.2%}"
    if share == f"{0.0:.2%}":
        share = f"{100.0 * value['area_fraction']:.1e}%"
    return (
        f"{value['contact_density']:.3g} contacts/m², <k> = {value['mean_stiffness']:.3g} N/m, area of contact "
        f"{share}; thresholds alone give F_k/load = {value['friction_coefficient']:.3g}, "
        f"{written(value['kinetic_stress'], 'Pa')} under {written(value['pressure'], 'Pa')}"
    )


def remarks(law: Thresholds, machine: bool = False) -> list[str]:
    """Warnings where samples, surface, load or a mean below 0 are at the limits of the law, and about errors that are
    not included; may be empty. Beside a `machine` of its own spring slips are told of none other."""
    said = of_samples(law) + of_islands(law, machine) + of_units(law)
    if isinstance(law, CutGaussian) and law.parent_mean <= 0.0:
        said.append(
            f"the normal law has its mean at {law.parent_mean:g} and is cut at 0, with half or more of its weight: "
            f"what is left has <x_s> = {law.mean():.3g}"
        )
    if isinstance(law.interface, Interface):
        said += law.interface.cautions
        if of_a_scan(law):
            said.append(NUMERICAL_ONLY)
        if law.interface.plastic_fraction is None:
            said.append("plastic contacts were not looked for: give the material a hardness")
        if zeros := law.interface.moments.zero_fraction:
            said.append(
                f"{zeros:.1%} of the scan's heights are exactly 0: gaps filled with 0? They make slopes and curvatures "
                "that the surface does not have; give missing points as NaN"
            )
        said += _of_sizes(law.interface.moments)
        if gaps := law.interface.moments.missing_fraction:
            said.append(
                f"{gaps:.1%} of the scan's points are missing: a slope counts where the point and its next neighbours "
                "on both axes are there; filling gaps gives other slopes, several times as large where gaps are many"
            )
    return sorted(said, key=lambda one: "?" not in one)  # whether the input is meant comes first


def _of_sizes(moments: SpectralMoments) -> list[str]:
    """A question where points of a scan that lie apart unevenly would be even with its two sizes the other way round;
    else none. Square pixels tell nothing of a square scan."""
    if moments.size is None or moments.pixel_size is None:
        return []
    uneven = moments.pixel_size[0] / moments.pixel_size[1]
    swapped = uneven * (moments.size[1] / moments.size[0]) ** 2
    if abs(uneven - 1.0) < _UNEVEN or abs(swapped - 1.0) > _EVEN:
        return []
    along, across = (written(one, "m") for one in moments.pixel_size)
    return [
        f"points of the scan are {along} apart along x and {across} along y, and evenly with its sizes the other way "
        "round: is physical_sizes right, along a row of the matrix first?"
    ]


def of_a_scan(law: Thresholds) -> bool:
    """Whether these are thresholds of a surface that is a scan, of one patch and of steps of some size."""
    return isinstance(law.interface, Interface) and law.interface.moments.size is not None


def doubts(contacts: Contacts) -> list[str]:
    """Remarks after which no number of these contacts can be trusted before they are settled: those that ask whether
    the input is meant, a temperature at which nothing holds, contacts taken as elastic where those that would be
    plastic bear most of the load."""
    law = contacts.thresholds
    surface, said = law.interface, [one for one in remarks(law) if "?" in one]
    caution = surface.plastic_caution if isinstance(surface, Interface) else ""
    asked = (
        isinstance(surface, Interface) and surface.hardness_question
    )  # whose answer may change it
    if caution and not asked and (surface.plastic_load_fraction or 0.0) > _MOSTLY:
        said.append(f'{caution}: take regime = "mixed", or "plastic"')
    said += of_other_barriers(contacts)
    if isinstance(contacts.thermal, Thermal) and contacts.thermal.temperature is not None:
        said += filter(None, [too_hot_for(contacts, contacts.thermal.temperature)])
    return said


def too_hot_for(contacts: Contacts, temperature: float) -> str:
    """That nothing holds at this temperature, k_BT/<k> (a length squared), in kelvins where it is plausible as such; ""
    of a lower one."""
    law, surface = contacts.thresholds, contacts.interface
    said = too_hot(temperature, law)
    kelvin = temperature / surface.temperature(kelvin=1.0) if surface is not None else 0.0
    if not said or not _KELVINS[0] < kelvin < _KELVINS[1]:
        return said  # probably none in kelvins
    barrier = law.moment(2) / (2.0 * temperature)
    return (
        f"at {kelvin:.4g} K the barriers k x_s²/2 are {barrier:.1g} k_BT, so that contacts break as often as they "
        f"attempt, whatever their stretch and threshold: is <x_s> = {written(law.mean(), 'm')} right?"
    )


def of_linked(contacts: Contacts) -> list[str]:
    """A note on how far linked stiffness raises F_k above that with every k as <k>; none where that is no news."""
    law = contacts.thresholds
    if contacts.stiffness != "linked":
        return []
    factor = law.moment(3) / law.mean() / law.moment(2)
    if not factor > 1.0 + _NO_NEWS:
        return []
    said = f'the stiffness, "linked": with every k as <k> ("independent") F_k is 1/{factor:.3g} of this'
    said += ", laws in time left out" * bool(contacts.in_time)
    if isinstance(law.interface, Interface):
        said += (
            "; sliding, linked contacts carry more than the load, so that F may exceed mu times it"
        )
    return [said]


def of_laws(contacts: Contacts) -> list[str]:
    """Notes on the temperature and the stiffness of these contacts; else none."""
    return of_temperature(contacts) + of_linked(contacts)


def of_temperature(contacts: Contacts) -> list[str]:
    """Notes on a temperature in kelvins that is one of a room in degrees Celsius, and on the barriers of islands; else
    none."""
    surface, thermal = contacts.interface, contacts.thermal
    if not isinstance(thermal, Thermal) or thermal.temperature is None or surface is None:
        return of_barriers(contacts)
    kelvin, said = thermal.temperature / surface.temperature(kelvin=1.0), list[str]()
    if _ROOM[0] <= kelvin <= _ROOM[1]:
        hint = f"if {kelvin:.4g} °C is meant, write kelvin = {kelvin + _ZERO_CELSIUS:.5g}"
        said.append(
            f"the temperature is {kelvin:.4g} K, which is {kelvin - _ZERO_CELSIUS:.0f} °C: {hint}"
        )
    return of_barriers(contacts) + said


def foreseen(scene: Scene) -> list[str]:
    """Notes before a run: a drive so long or short that its unit may be wrong, temperatures at which no contact holds,
    stretches beyond nearly all thresholds, N_c<k> of the nominal area in N/m, numbers of contacts other than its own,
    and laws that the numbers of the surface do not include."""
    contacts, law, said = scene.contacts, scene.contacts.thresholds, list[str]()
    surface, mean = contacts.interface, contacts.mean_threshold
    distance = 0.0 if scene.given_drive is None else float(np.abs(scene.path).max()) / mean
    if (
        distance and scene.drive.spring is not None
    ):  # a soft spring is stretched by some <x_s>/K before its slider moves
        distance /= 1.0 + 1.0 / scene.drive.spring
    if distance > 1e6 or 0.0 < distance < 1e-2:  # probably a mistake
        unit = " m" if length_unit_of(law) == "m" else ""
        said.append(f"the drive goes {distance:.1g} times <x_s> = {mean:.3g}{unit}: in that unit?")
    if scene.given_drive is not None and scene.drive.spring is not None:
        said += of_stretch(contacts, scene.drive.spring)
    if isinstance(contacts.thermal, Thermal) and contacts.thermal.temperature is not None:
        swept = {} if scene.sweep is None else scene.sweep.at
        hottest = np.max(swept.get("temperature", contacts.thermal.temperature))
        said += filter(None, [too_hot_for(contacts, float(hottest))])
        said += of_temperature(contacts)
    reforming = [] if contacts.reforming is None else [(contacts.reforming.law, "form again")]
    for own, they in [(contacts.start, "start"), *reforming]:
        middle = own.mean() if own.is_single else float(own.ppf(0.5))
        exceed = float(law.sf(abs(middle)))
        if exceed < 1e-6:
            said.append(
                f"contacts {they} about x = {middle:.3g}, and only {exceed:.0e} of all thresholds are beyond that: "
                "they have the thresholds of that tail, and break at once"
            )
    if surface is not None and surface.contact_density is not None and scene.area is not None:
        number = surface.contact_density * scene.area
        together = f"N_c<k> = {number * surface.mean_stiffness:.4g} N/m"
        load = None if surface.pressure is None else surface.pressure * scene.area
        under = "" if load is None else f", under {written(load, 'N')},"
        few = ": so few scatter, add [eq] with as many" * (number < 1e4 and scene.eq is None)
        said.append(
            f"N_c = {of_contacts(number, '.4g')} and {together}{under} on drive.area = {scene.area:.3g} m²{few}"
        )
        soft = scene.given_drive is not None and scene.drive.spring is not None
        if soft and scene.eq is not None and not 0.5 < scene.eq.contacts / number < 2.0:
            said.append(
                f"[eq] follows {scene.eq.contacts:,} contacts in each replica: the spring is that of the area, but "
                "slips scatter and come late as those of so many contacts"
            )
    named = {"thermal": "temperature", "reforming": "re-forming", "stiffness": "linked stiffness"}
    there = ", ".join(named.get(name, name) for name in contacts.laws)
    if isinstance(surface, Interface) and there:
        load = "F_k/load and the stress of the surface are those of its thresholds alone"
        more = "; sliding, linked contacts carry more than the load, and F may exceed mu times it"
        said.append(f"{load}, without {there}{more * (contacts.stiffness == 'linked')}")
    return said


def why_infinite(contacts: Contacts) -> str:
    """Why K* is infinite: the exact value at which F drops the most, or a density that diverges."""
    law, start = contacts.thresholds, contacts.start
    furthest = abs(start.mean()) if start.is_single else float("inf")
    values = [(w * x, w, x) for x, w in zip(*law.atoms, strict=True) if x > furthest]
    if not values:
        return "K* is infinite: the density of thresholds diverges at one value, where F falls ever more steeply"
    _, weight, x = max(values)
    fraction = weight / float(law.sf(furthest)) if furthest > 0.0 else weight
    drop = fraction * x / (law.moment(2) / (2.0 * law.mean()))
    many = "all" if fraction > 1.0 - 1e-12 else f"{100.0 * fraction:.3g} % of the"
    return f"K* is infinite: {many} contacts break at one value, x = {x:.4g}, where F drops by {drop:.2g} F_k"
