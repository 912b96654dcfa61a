"""What a rough surface's interface says beside its thresholds, in SI units, and what to keep in mind of a law."""

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from origins import Contacts
from origins.roughness.interface import Interface
from origins.thresholds.gaussian import CutGaussian
from origins.thresholds.law import Thresholds
from toolkit.scene.peaks import of_islands
from toolkit.scene.sampling import misfit

HEIGHT_INTEGRALS = 1e-8  # relative error of what comes from a surface's heights, as tests hold it

_UNITS = {
    **dict.fromkeys(("pressure", "kinetic_stress"), "Pa"),
    **dict.fromkeys(("separation", "mean_radius", "mean_plane_separation"), "m"),
    **dict.fromkeys(("patch_area", "mean_area"), "m2"),
    **dict.fromkeys(("mean_load", "mean_force_threshold"), "N"),
    "contact_density": "1/m2",
    "mean_stiffness": "N/m",
}
_GIVEN = ("pressure", "patch_area")
_SAID_BEFORE = ("mean_threshold",)  # the mean of the law itself


@dataclass(frozen=True)
class Number:
    """A value, its error (same unit; None where the value has none) and its unit: "" for a pure number."""

    value: float
    error: float | None
    unit: str


def with_error(value: float, error: float, digits: int) -> str:
    """Both in words, the value to `digits` and no further than the error's first; alone where its error is 0 or not
    known."""
    if not np.isfinite(value) or not np.isfinite(error) or error == 0.0:
        return f"{value:.{digits}g}"
    told = f"{error:.1g}"
    known = _decade(value) - _decade(float(told)) + 1
    if value == 0.0 or known >= digits:
        return f"{value:.{digits}g} ± {told}"
    # with its last zeros
    return f"{value:#.{max(known, 1)}g}".removesuffix(".").replace(".e", "e") + f" ± {told}"


def _decade(value: float) -> int:
    return int(f"{value:e}".partition("e")[2])


def of_interface(interface: Interface) -> dict[str, Number]:
    """What the interface knows in SI units, its own and derived."""
    names = [field.name for field in fields(interface)]
    names += [name for name, value in vars(type(interface)).items() if isinstance(value, property)]
    numbers = {}
    for name in names:
        value = getattr(interface, name)
        if isinstance(value, float) and name not in _SAID_BEFORE:
            error = None if name in _GIVEN else abs(value) * HEIGHT_INTEGRALS
            numbers[name] = Number(value, error, _UNITS.get(name, ""))
    return numbers


def in_a_line(numbers: Mapping[str, Number]) -> str:
    """The most asked of them as a line of text."""
    value = {name: number.value for name, number in numbers.items()}
    return (
        f"{value['contact_density']:.3g} contacts/m², <k> = {value['mean_stiffness']:.3g} N/m, area of contact "
        f"{value['area_fraction']:.2%}; F_k/load = {value['friction_coefficient']:.3g}, "
        f"{value['kinetic_stress']:.3g} Pa under {value['pressure']:.3g} Pa"
    )


def remarks(law: Thresholds) -> list[str]:
    """Where samples, surface, load or a mean below 0 strain the law, and what its errors leave out; empty where nothing
    does."""
    said = misfit(law) + of_islands(law)
    if isinstance(law, CutGaussian) and law.parent_mean <= 0.0:
        said.append(
            f"the normal law has its mean at {law.parent_mean:g} and is cut at 0, with half or more of its weight: "
            f"what is left has <x_s> = {law.mean():.3g}"
        )
    if law.interface is not None:
        said += law.interface.cautions
        if law.interface.moments.size is not None:
            said.append(
                "errors are numerical only, not those of the scan: what another scan would give is not in them"
            )
        if gaps := law.interface.moments.missing_fraction:
            said.append(
                f"{gaps:.1%} of the scan's points are missing: a slope counts where the point and its next neighbours "
                "along x and along y are all there, a curvature where both neighbours on each axis are; other rules, "
                "such as filling gaps, give other slopes, up to several times as large where gaps are many"
            )
    return said


def why_infinite(contacts: Contacts) -> str:
    """Why K* is infinite: the exact value at which F drops the most, or a density that diverges."""
    law, start = contacts.thresholds, contacts.start
    furthest = abs(start.mean()) if start.is_single else float("inf")
    values = [(w * x, w, x) for x, w in zip(*law.atoms, strict=True) if x > furthest]
    if not values:
        return "K* is infinite: the density of thresholds diverges at one value, where F falls ever more steeply"
    _, weight, x = max(values)
    share = weight / float(law.sf(furthest)) if furthest > 0.0 else weight
    drop = share * x / (law.moment(2) / (2.0 * law.mean()))
    many = f"{share:.2g}" if share < 1e-3 else f"{100.0 * share:.3g} %"
    many = "all" if share > 1.0 - 1e-12 else f"{many} of the"
    unit = " m" if contacts.interface is not None else ""
    return f"K* is infinite: {many} contacts break at one value, x = {x:.4g}{unit}, where F drops by {drop:.2g} F_k"
