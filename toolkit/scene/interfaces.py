"""Information on a scene beside its solvers' answers: a rough surface in SI units, and warnings on laws and runs."""

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from origins import Contacts, bootstrap
from origins.contacts import too_hot
from origins.roughness.interface import Interface
from origins.samples.bootstrap import sampled_parts
from origins.samples.from_samples import OFTEN, Sampled
from origins.thresholds.gaussian import CutGaussian
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import ContinuousMixture
from toolkit.scene.scene import Scene

_HEIGHT_INTEGRALS = 1e-8  # relative error of numbers from a surface's heights, checked by tests
_FAR = 1e6  # mean thresholds: a longer drive is probably a mistake
_RARE = 1e-6  # share of the thresholds
_SPRINGS = (1.0, 10.0, 100.0)  # K/(N<k>) whose slips are reported
_NEAREST, _PLACES = 1e-14, 6000  # of a peak's place; places on either side of a peak
_UNITS = dict.fromkeys(("pressure", "kinetic_stress"), "Pa")
_UNITS |= dict.fromkeys(("separation", "mean_radius", "mean_plane_separation"), "m")
_UNITS |= dict.fromkeys(("patch_area", "mean_area"), "m2")
_UNITS |= dict.fromkeys(("mean_load", "mean_force_threshold"), "N")
_UNITS |= {"contact_density": "1/m2", "mean_stiffness": "N/m"}
FEW = 30  # effective samples
RESAMPLES = 20  # the relative error of the sampling error is then a sixth
_TOLERANCE = 1e-4  # far below any sampling error
NAMES = (
    *("mean", "standard_deviation", "second_moment", "third_moment"),
    *("one_in_a_hundred_below", "median", "one_in_a_hundred_above"),
    *("kinetic_force", "critical_spring", "static_to_kinetic", "decoherence_length"),
)


@dataclass(frozen=True)
class Number:
    """A value, its error (same unit; None where the value has none) and its unit: "" for a pure number."""

    value: float
    error: float | None
    unit: str


def with_error(value: float, error: float, digits: int) -> str:
    """Value and error as text, the value to `digits` or to the first digit of the error; without an error that is 0 or
    not finite."""
    if not np.isfinite(value) or not np.isfinite(error) or error == 0.0:
        return f"{value:.{digits}g}"
    told = f"{error:.1g}"
    decades = (int(f"{number:e}".partition("e")[2]) for number in (value, float(told)))
    known = next(decades) - next(decades) + 1
    if value == 0.0 or known >= digits:
        return f"{value:.{digits}g} ± {told}"
    # with its last zeros
    return f"{value:#.{max(known, 1)}g}".removesuffix(".").replace(".e", "e") + f" ± {told}"


def of_interface(interface: Interface) -> dict[str, Number]:
    """The numbers of the interface in SI units, its fields and properties, without the law's mean."""
    names = [field.name for field in fields(interface)]
    names += [name for name, value in vars(type(interface)).items() if isinstance(value, property)]
    numbers = {}
    for name in names:
        value = getattr(interface, name)
        if isinstance(value, float) and name != "mean_threshold":
            given = name in ("pressure", "patch_area")
            error = None if given else abs(value) * _HEIGHT_INTEGRALS
            numbers[name] = Number(value, error, _UNITS.get(name, ""))
    return numbers


def in_a_line(numbers: Mapping[str, Number]) -> str:
    """The most important of them as a line of text."""
    value = {name: number.value for name, number in numbers.items()}
    return (
        f"{value['contact_density']:.3g} contacts/m², <k> = {value['mean_stiffness']:.3g} N/m, area of contact "
        f"{value['area_fraction']:.2%}; F_k/load = {value['friction_coefficient']:.3g}, "
        f"{value['kinetic_stress']:.3g} Pa under {value['pressure']:.3g} Pa"
    )


def remarks(law: Thresholds) -> list[str]:
    """Warnings where samples, surface, load or a mean below 0 are at the limits of the law, and about errors that are
    not included; may be empty."""
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
                "errors are numerical only, not those of the surface: what another patch would give is not in them"
            )
        if gaps := law.interface.moments.missing_fraction:
            said.append(
                f"{gaps:.1%} of the scan's points are missing: a slope counts where the point and its next neighbours "
                "along x and along y are all there, a curvature where both neighbours on each axis are; other rules, "
                "such as filling gaps, give other slopes, up to several times as large where gaps are many"
            )
    return said


def foreseen(scene: Scene) -> list[str]:
    """Warnings before a run: a drive so long that its unit may be wrong, temperatures at which no contact holds,
    stretches beyond nearly all thresholds, numbers of contacts other than that of the nominal area, and laws that the
    numbers of the surface do not include."""
    contacts, law, said = scene.contacts, scene.contacts.thresholds, list[str]()
    surface, mean = contacts.interface, contacts.mean_threshold
    reach = 0.0 if scene.given_drive is None else float(np.abs(scene.path).max()) / mean
    if reach > _FAR:
        unit = "" if surface is None else " m"
        far = f"the drive goes as far as {reach:.1g} mean thresholds of {mean:.3g}{unit}"
        said.append(f"{far}; is it meant in that unit?")
    if contacts.thermal is not None:
        said += filter(None, [too_hot(contacts.thermal.temperature, law)])
    again = [] if contacts.reforming is None else [(contacts.reforming.law, "form again")]
    for own, they in [(contacts.start, "start"), *again]:
        middle = own.mean() if own.is_single else float(own.ppf(0.5))
        exceed = float(law.sf(abs(middle)))
        if exceed < _RARE:
            said.append(
                f"contacts {they} about x = {middle:.3g}, and only {exceed:.0e} of all thresholds are beyond that: "
                "they have the thresholds of that tail, and break at once"
            )
    if surface is not None and scene.eq is not None and scene.area is not None:
        held = surface.contact_density * scene.area
        if not 0.5 < scene.eq.contacts / held < 2.0:
            said.append(
                f"drive.area holds {held:.3g} contacts, and [eq] follows {scene.eq.contacts:,} in each replica: the "
                "spring is that of the area, but slips scatter and come late as those of so many contacts"
            )
    named = {"grains": "growth", "thermal": "temperature", "reforming": "re-forming"}
    there = ", ".join(named.get(name, name) for name in contacts.laws if name != "stiffness")
    if surface is not None and there:
        load = "F_k/load and the stress of the surface are those of its thresholds alone"
        said.append(f"{load}, without {there}")
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
    many = "all" if share > 1.0 - 1e-12 else f"{100.0 * share:.3g} % of the"
    unit = " m" if contacts.interface is not None else ""
    return f"K* is infinite: {many} contacts break at one value, x = {x:.4g}{unit}, where F drops by {drop:.2g} F_k"


def of_islands(law: Thresholds) -> list[str]:
    """Notes on thresholds from islands: K* is infinite, with the slips of some springs, or depends on smoothing."""
    if law.domains is None or law.atoms[0].size:
        return []
    if isinstance(law, Sampled):
        if np.unique(law.domains.angles).size < law.domains.angles.size / 2:
            return []  # few angles, in turn
        return [
            "P_c of islands at all angles peaks where a barrier stands still in the angle, and samples smooth "
            "that away: K* hangs on the smoothing, and is no number of the islands"
        ]
    with np.errstate(divide="ignore"):
        peaks = law.breakpoints[np.isinf(law.pdf(law.breakpoints))]
    if not peaks.size:
        return []
    slips = {spring: longest_slip(law, peaks, spring) / law.mean() for spring in _SPRINGS}
    told = ", ".join(
        f"{spring * slip:.2g} <x_s> in a slip of {slip:.2g} <x_s> at K = {spring:g} N<k>"
        for spring, slip in slips.items()
    )
    return [
        "K* is infinite: P_c peaks as an inverse square root where a barrier stands still in the angle; as relaxed "
        f"contacts break for the first time, F/(N<k>) drops at most by about {told}"
    ]


def longest_slip(law: Thresholds, peaks: np.ndarray, spring: float) -> float:
    """The longest slip (a length) of relaxed contacts under a spring of K/(N<k>), at T = 0.

    F(X) = X - int_0^X x P_c dx until contacts break for the second time; a slip leads from where F + K X stops
    rising to where it is as high again.
    """
    lower, upper = law.support()
    away = np.geomspace(_NEAREST, 1.0, _PLACES)
    x = np.concatenate([peaks, *(peak * (1.0 + s * away) for peak in peaks for s in (-1, 1))])
    x = np.unique(np.append(x[(x > lower) & (x < 2.0 * upper)], [lower, upper]))
    below, above = law.cdf(x), law.sf(x)
    share = np.where(below[1:] < 0.5, np.diff(below), -np.diff(above))
    rise = np.diff(x) * (1.0 + spring) - 0.5 * (x[1:] + x[:-1]) * share
    height = np.concatenate([[0.0], np.cumsum(rise)])
    top = np.maximum.accumulate(height)
    last = np.maximum.accumulate(np.where(height >= top, np.arange(x.size), 0))
    return float((x - x[last]).max())


def sampling_errors(contacts: Contacts) -> dict[str, float]:
    """One standard error of each of NAMES, bias of the smoothing included; lengths in the unit of the thresholds.

    inf for K* and F_s/F_k where all resampled laws have the least possible value, 0 and 1: then the error cannot be
    estimated. Empty where the thresholds do not come from samples.
    """
    if not sampled_parts(contacts.thresholds) or isinstance(contacts.thresholds, ContinuousMixture):
        return {}

    def statistic(law: Thresholds) -> Array:
        import master

        found = master.propensity(Contacts(law, start=contacts.start), tolerance=_TOLERANCE)
        numbers = [law.mean(), law.std(), law.moment(2), law.moment(3)]
        numbers += [float(law.ppf(0.01)), float(law.ppf(0.5)), float(law.isf(0.01))]
        # K* and X* may be infinite: their inverses are not
        numbers += [law.moment(2) / (2.0 * law.mean()), 1.0 / (1.0 + found.critical_spring)]
        return np.array([*numbers, found.static_to_kinetic, 1.0 / found.decoherence_length])

    spread = bootstrap(contacts.thresholds, statistic, resamples=RESAMPLES)
    errors = {}
    for name, value, error in zip(NAMES, spread.value, np.array(spread.error), strict=True):
        if name in ("critical_spring", "decoherence_length") and error > 0.0:
            error = error / value**2 if value > 0.0 else np.inf
        if name in ("critical_spring", "static_to_kinetic") and value == 1.0 and error == 0.0:
            error = np.inf
        errors[name] = float(error)
    return errors


def numerical_only(law: Thresholds) -> list[str]:
    """A note that errors of a run do not include sampling errors, for thresholds from samples."""
    told = (
        "errors are numerical only, not those of the samples: what others would give is not in them; `mesofriction "
        "thresholds`, `mesofriction compare` and origins.bootstrap tell sampling errors"
    )
    return [told] if sampled_parts(law) else []


def misfit(law: Thresholds) -> list[str]:
    """A note for each law of few samples, or that lies further from its samples than these can be from their own law,
    and one where sampling errors are missing; else nothing."""
    notes = []
    for part in sampled_parts(law):
        few, misses = round(part.effective_samples) < FEW, part.cdf_misfit > part.cdf_error
        alike = part.effective_samples > 0.99 * part.n_samples
        count = "" if alike else f", which their weights make {part.effective_samples:.2g}"
        told = f"few thresholds, {part.n_samples} samples{count}: " if few else ""
        told += f"the smooth law's cdf lies {part.cdf_misfit:.2g} from that of the samples, sampling allows "
        told += f"{min(part.cdf_error, 1.0):.2g}{'; take more samples' if few else ''}"
        if misses:
            told += "; they are rounded coarsely, or hold structure that it misses; give that apart, in a mixture"
        if alike and part.smooth_part is not None and part.samples.size < part.n_samples:
            told += f"; values that repeat are exact from {OFTEN} times on; those you know to be exact are `identical`"
        notes += [told] if few or misses else []
    if sampled_parts(law) and isinstance(law, ContinuousMixture):
        missing = "the laws of this continuous mixture may all be of the same samples"
        notes.append(f"sampling errors are missing: {missing}")
    return notes
