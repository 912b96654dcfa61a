"""A law of thresholds in numbers, each with its error: moments, quantiles, onset, propensity, and its interface."""

import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from origins import Contacts, Thermal
from origins.errors import InputError
from origins.samples.from_samples import sampled_parts
from origins.thresholds.law import Thresholds
from origins.thresholds.mixture import ContinuousMixture
from toolkit.running.resampled import (
    RATHER_LARGE,
    RESAMPLES,
    error_by_moments,
    has_closed_form,
    kinetic_name,
    known_to,
    like,
    of_resampled,
    scatter_of,
)
from toolkit.scene.interfaces import Number, of_interface, remarks, why_infinite
from toolkit.scene.scale import (
    PREFIXED,
    SHARED,
    Scale,
    length_unit_of,
    with_error,
    with_scatter,
    written,
)

PROPENSITY = ("critical_spring", "static_to_kinetic", "decoherence_length")
# numbers in units of N_c<k>
SHARED_NUMBERS = ("kinetic_force", "critical_spring")
# CPU-s for K*, F_s and X* of one resampled law; in heat that breaks most contacts at once they take 20
LONGEST = 6.0
TOO_LONG = "sampling errors of K*, F_s/F_k and X* are missing: with these laws they take minutes"
SEEN = 1e-3  # of a number: a larger error would be seen in three digits


@dataclass(frozen=True)
class Description:
    """`numbers` by name; `notes`, which numbers are absent and why; `success`, whether all are known to a thousandth;
    `sampled`, whether errors include sampling errors; `run_time` in s."""

    numbers: dict[str, Number]
    notes: tuple[str, ...]
    success: bool
    sampled: bool
    run_time: float


def describe(
    contacts: Contacts, velocity: float = 1.0, progress: Callable[[int, int], None] | None = None
) -> Description:
    """Numbers of the contacts' thresholds, and of sliding at `velocity` (length per time; it matters only with rates or
    a delay).

    `progress` is called with the resampled laws that are done, and how many there are. The errors of F_k and of the
    propensity are the master equation's. Where the thresholds come from samples, all
    include the sampling error. Contacts with laws that the master equation does not take have no F_k and no propensity
    here, and a note says so.
    """
    began, law = time.perf_counter(), contacts.thresholds
    numbers = _of_law(law)
    notes, missed, sampled = conditions(contacts, velocity), list[str](), False
    if np.isfinite(law.moment(2)):
        try:
            notes += (missed := _slide(contacts, velocity, numbers))
        except InputError as refused:
            notes.append(f"P_c alone, without all of F_k, K*, F_s/F_k and X*: {refused}")
    else:
        notes.append("<x_s^2> is infinite: there is no kinetic force to compare K* and F_s with")
    if (spring := numbers.get("critical_spring")) is not None:
        notes += [why_infinite(contacts)] if np.isinf(spring.value) else []
        if isinstance(law, ContinuousMixture) and sampled_parts(law):
            notes.append("sampling errors are missing: its laws may all be of the same samples")
        elif sampled := bool(sampled_parts(law)):
            notes += _add_sampling_errors(contacts, velocity, numbers, progress)
    if law.interface is not None:
        numbers |= of_interface(law.interface)
        pressure, kinetic = law.interface.pressure, numbers.get("kinetic_force")
        if "friction_coefficient" not in numbers and pressure and kinetic:
            ratio = float(law.interface.per_area(1.0)) / pressure
            error = (kinetic.error or 0.0) * ratio
            numbers["friction_coefficient"] = Number(kinetic.value * ratio, error, "")
    notes += remarks(law)
    return Description(numbers, tuple(notes), not missed, sampled, time.perf_counter() - began)


def in_units_of(scale: Scale, numbers: Mapping[str, Number]) -> dict[str, Number]:
    """The numbers, and after F_k and K* of a surface the same of its nominal area in N and N/m, or per area in Pa and
    N/m³; no more in units of N_c<k>."""
    if scale.spring_unit == SHARED:
        return dict(numbers)
    of_what = "of_the_area" if scale.spring_unit == "N/m" else "per_area"
    factors = {"kinetic_force": scale.force, "critical_spring": scale.spring}
    units = {"kinetic_force": scale.force_unit, "critical_spring": scale.spring_unit}
    out = dict[str, Number]()
    for name, own in numbers.items():
        out[name] = own
        if name in factors:
            value, error = own.value * factors[name], (own.error or 0.0) * factors[name]
            out[f"{name}_{of_what}"] = Number(value, error, units[name])
    return out


def _of_law(law: Thresholds) -> dict[str, Number]:
    """Moments, ends, quantiles and the onset of P_c."""
    unit, spread = length_unit_of(law), law.std()
    # relative error of moments and quantiles: 6e-11 is the largest seen, of a tail as x^-4.5
    numerical = 1e-10
    values = {"mean": law.mean(), "standard_deviation": spread}
    values |= {"second_moment": law.moment(2), "third_moment": law.moment(3)}
    values |= {"one_in_a_hundred_below": float(law.ppf(0.01)), "median": float(law.ppf(0.5))}
    values |= {"one_in_a_hundred_above": float(law.isf(0.01))}
    units = {"second_moment": f"{unit}^2", "third_moment": f"{unit}^3"}
    numbers = {k: Number(v, numerical * v, units.get(k, unit)) for k, v in values.items()}
    if 0.0 < spread < np.inf:
        # of <x^2> is rounded, of which the variance of a narrow law is a small part
        error = numerical * spread + 4.0 * np.finfo(float).eps * law.moment(2) / spread
        numbers["standard_deviation"] = Number(spread, error, unit)
    for name, end in zip(("lower_end", "upper_end"), law.support(), strict=True):
        numbers[name] = Number(end, None, unit)
    return numbers | {"onset_power": Number(law.onset_power, law.onset_power_error, "")}


def _add_sampling_errors(
    contacts: Contacts,
    velocity: float,
    numbers: dict[str, Number],
    progress: Callable[[int, int], None] | None,
) -> list[str]:
    """Add to the errors one standard error of what other samples would have given, bias of the smoothing included, in
    closed form where moments tell it; returns notes on how they are found, and where those of the propensity take too
    long.

    inf where a resampled law has an infinite value; for K* and F_s/F_k, too, where all of them have the least possible
    value: then the error cannot be estimated.
    """
    began, law, quick = time.process_time(), contacts.thresholds, True

    def numbers_of(law: Thresholds) -> dict[str, Number]:
        found = _of_law(law)
        _slide(like(contacts, law), velocity, found, tolerance=1e-4 if quick else None)
        return found

    resampled = [numbers_of(law)]
    quick = time.process_time() - began < LONGEST
    resampled += of_resampled(law, RESAMPLES, numbers_of, progress)
    closed_kinetic = kinetic_name(contacts)
    for name in {*numbers} - {"lower_end", "upper_end", "onset_power"}:
        if name in PROPENSITY and not quick:
            numbers[name] = replace(numbers[name], error=np.inf)
            continue
        value, *others = (one[name].value for one in resampled)
        closed = closed_kinetic if name == "kinetic_force" else name
        if closed is not None and has_closed_form(closed):
            scatter = error_by_moments(law, closed, value)
        else:
            scatter = scatter_of(value, others)
        unknown = name in PROPENSITY and scatter == 0.0
        error = float(np.hypot(numbers[name].error or 0.0, scatter))
        finite = np.isfinite(error) and not unknown
        numbers[name] = replace(numbers[name], error=error if finite else np.inf)
    moments = "moments and F_k" if closed_kinetic else "moments"
    how = f"by {RESAMPLES} resamplings, known to ± {known_to(RESAMPLES):.0%}"
    notes = [
        f"sampling errors are one standard error: of {moments} in closed form, of all else {how}; "
        f"{RATHER_LARGE}"
    ]
    return notes if quick else [*notes, TOO_LONG]


def _slide(
    contacts: Contacts, velocity: float, numbers: dict[str, Number], tolerance: float | None = 1e-8
) -> list[str]:
    """Add F_k and the propensity, F_k alone without a tolerance, to `numbers`; returns a note where one misses its
    tolerance and is not known to a thousandth either."""
    import master

    unit = numbers["mean"].unit
    steady = master.steady_state(contacts, velocity=velocity)
    error = steady.force_error * contacts.mean_threshold
    numbers["kinetic_force"] = Number(steady.force, error, f"{SHARED}·{unit}")
    if tolerance is None:
        return []
    found = master.propensity(contacts, velocity=velocity, tolerance=tolerance)
    for name, own in zip(PROPENSITY, ("N_c<k>", "", unit), strict=True):
        numbers[name] = Number(getattr(found, name), getattr(found, f"{name}_error"), own)
    spring_precise = found.critical_spring_error <= 1e-3 * found.critical_spring
    both_precise = spring_precise and found.static_to_kinetic_error <= 1e-3
    if steady.success and (found.success or both_precise):
        return []
    return [f"not as asked: {steady.message}; {found.message}"]


def conditions(contacts: Contacts, velocity: float) -> list[str]:
    """The speed and the laws of contacts on which F_k and the propensity depend, in words."""
    timed = contacts.delay, contacts.changing
    laws = [_of_heat(contacts), *(str(own) for own in timed if own is not None)]
    laws = [own for own in laws if own]
    if contacts.stiffness == "linked":
        laws.append("linked stiffness")
    unit = "m/s" if length_unit_of(contacts.thresholds) == "m" else "length per time"
    where = ", ".join([f"v = {velocity:.4g} {unit}", *laws])
    return [f"with laws: F_k, K*, F_s/F_k and X* at {where}; all else is P_c alone"] if laws else []


def _of_heat(contacts: Contacts) -> str:
    """The heat of contacts in words, in kelvins where <k> is known; "" without any."""
    thermal, surface = contacts.thermal, contacts.interface
    if not isinstance(thermal, Thermal):
        return str(thermal or "")
    per = "/s" if length_unit_of(contacts.thresholds) == "m" else " per time"
    said = f"{thermal.law} heat"
    if thermal.temperature is not None and surface is not None:
        said += f" at {thermal.temperature / surface.temperature(kelvin=1.0):.4g} K"
    elif thermal.temperature is not None:
        said += f" of k_BT/<k> = {thermal.temperature:.4g}"
    said += "".join(f", {name} {value:.4g}" for name, value in thermal.own)
    said += f" (attempt frequency {thermal.attempt_frequency:.3g}{per})"
    return said + " in the paper's closure" * (thermal.closure == "paper")


def onset_in_words(number: Number, digits: int) -> str:
    """The onset power m, to so many digits; of few samples, which leave more than one power open, from where to where
    it may lie."""
    value, error = number.value, number.error or 0.0
    if value == np.inf:
        return "infinite"
    if np.isfinite(value) and error == np.inf:
        return f"{value:g}, error not known"
    if not (np.isfinite(value) and error >= 1.0):
        return with_error(value, error, digits)
    # samples are fitted with a finite density at 0, m = 0, or with a power above it
    return f"{max(value - error, min(value, 0.0)):.2g} to {value + error:.2g}"


def table_of(
    found: Description,
    laws: tuple[str, ...],
    hidden: tuple[str, ...],
    surface: bool = False,
    smoothed: bool = False,
) -> list[str]:
    """The table as lines of text without the numbers `hidden`, which are there in SI units, too; where contacts have
    `laws`, the numbers of sliding say whether these are in them. Those of a `surface` have three digits, K* two, as
    other models and resolutions of it change them by far more than their numerical errors; K* of islands whose P_c is
    `smoothed` is no number of theirs."""
    sliding = [name for name in found.numbers if name.startswith((*PROPENSITY, "kinetic_force"))]
    labels = dict.fromkeys(sliding, "with laws")
    labels |= dict.fromkeys(("friction_coefficient", "kinetic_stress"), "P_c alone")
    width, out = max(map(len, found.numbers)) + 2, list[str]()
    for name, number in found.numbers.items():
        if name in hidden:
            continue
        unit = re.sub(r"\^?([23])$", lambda power: "²³"[int(power[1]) - 2], number.unit)
        if name == "onset_power":
            value = onset_in_words(number, 3 if surface else 8)
        elif name.startswith("critical_spring") and smoothed:
            value, unit = "not known: it hangs on the smoothing of P_c", ""
        elif name.startswith("critical_spring") and not found.sampled and number.lost:
            value, unit = "not known", ""
        elif np.isinf(number.value):
            value, unit = "infinite", ""
        elif surface and (number.error or 0.0) <= SEEN * abs(number.value):
            # F_s - F_k is a small part of F_s; K* changes by orders of magnitude
            digits = 2 if name.startswith("critical_spring") else 3
            digits = 5 if name == "static_to_kinetic" else digits
            value, unit = written(number.value, unit, digits=digits), ""
        elif unit in PREFIXED and 0.0 < (number.error or 0.0) < np.inf:
            value, unit = with_scatter(number.value, number.error or 0.0, unit, digits=8), ""
        elif unit in PREFIXED and np.isfinite(number.value) and number.value:
            value, unit = written(number.value, unit), ""
        else:
            value = with_error(number.value, number.error or 0.0, 8)
            if " ± inf" in value:
                value, unit = value.replace(" ± inf", f" {unit}".rstrip() + ", error not known"), ""
        row = f"  {name.replace('_', ' '):{width}}{value} {unit}".rstrip()
        out.append(f"{row}  ({labels[name]})" if laws and name in labels else row)
    out += [f"  {note}" for note in found.notes]
    return [*out, f"  {'run time':{width}}{found.run_time:.2g} s"]
