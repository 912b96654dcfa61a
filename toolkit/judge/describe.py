"""A law of thresholds in numbers, each with its error: moments, quantiles, onset, propensity, and its interface."""

import time
from dataclasses import dataclass, replace

import numpy as np

from origins import Contacts
from origins.domains.domain_samples import DomainSamples
from origins.errors import InputError
from origins.thresholds.law import Thresholds
from origins.thresholds.quadrature import gauss, panel_edges
from toolkit.scene.interfaces import Number, of_interface, remarks, why_infinite
from toolkit.scene.sampling import sampling_errors, unseen

_EPSILON = float(np.finfo(float).eps)
PROPENSITY = ("critical_spring", "static_to_kinetic", "decoherence_length")
_NEGLIGIBLE = 1e-18
_DOUBLINGS = 2000


@dataclass(frozen=True)
class Description:
    """`numbers` by name; `notes`, what has no answer and why; `sampled`, whether errors are those of samples, too;
    `run_time` in s."""

    numbers: dict[str, Number]
    notes: tuple[str, ...]
    sampled: bool
    run_time: float


def describe(contacts: Contacts, velocity: float = 1.0, chosen: str = "") -> Description:
    """Numbers of the contacts' thresholds, and of sliding at `velocity` (length per time; only rates and delay tell),
    which is the one `chosen` in words.

    The errors of moments are distances of two roads, the family's own and a quadrature of the survival; those of
    quantiles come from the survival at them; those of F_k and of the propensity are the master equation's. Where the
    thresholds come from samples, all count the sampling error too. Contacts with laws that the master equation does not
    take have no F_k and no propensity here, and a note says so.
    """
    import master

    began = time.perf_counter()
    law = contacts.thresholds
    unit = "m" if law.interface is not None else "length"
    mean = Number(law.mean(), _off(law, 1), unit)
    numbers = {"mean": mean, "standard_deviation": _spread(law, unit)}
    for n, name in ((2, "second_moment"), (3, "third_moment")):
        numbers[name] = Number(law.moment(n), _off(law, n), f"{unit}^{n}")
    lower, upper = law.support()
    numbers |= {"lower_end": Number(lower, None, unit), "upper_end": Number(upper, None, unit)}
    numbers["one_in_a_hundred_below"] = _quantile(law, 0.01, False, unit)
    numbers["median"] = _quantile(law, 0.5, False, unit)
    numbers["one_in_a_hundred_above"] = _quantile(law, 0.01, True, unit)
    numbers["onset_power"] = Number(law.onset_power, law.onset_power_error, "")
    notes = conditions(contacts, velocity, chosen)
    if np.isfinite(law.moment(2)):
        try:
            steady = master.steady_state(contacts, velocity=velocity)
        except InputError as refused:
            notes.append(f"P_c alone, without F_k, K*, F_s/F_k and X*: {refused}")
        else:
            numbers["kinetic_force"] = Number(steady.force, steady.force_error * mean.value, unit)
            try:
                found = master.propensity(contacts, velocity=velocity)
                for name, own in zip(PROPENSITY, ("", "", unit), strict=True):
                    error = getattr(found, f"{name}_error")
                    numbers[name] = Number(getattr(found, name), error, own)
                if not (steady.success and found.success):
                    notes.append(f"not as asked: {steady.message}; {found.message}")
            except InputError as refused:
                notes.append(str(refused))
    else:
        notes.append(
            "<x_s^2> is infinite: there is no kinetic force, and nothing to compare K* and F_s with"
        )
    sampled = sampling_errors(contacts) if "critical_spring" in numbers else {}
    if "critical_spring" in numbers and np.isinf(numbers["critical_spring"].value):
        notes.append(why_infinite(contacts))
    if sampled:
        notes += unseen(sampled, numbers["critical_spring"].value)
    for name, scatter in sampled.items():
        both = float(np.hypot(numbers[name].error or 0.0, scatter))
        numbers[name] = replace(numbers[name], error=both)
    if law.interface is not None:
        numbers |= of_interface(law.interface)
    if law.domains is not None:
        numbers |= _of_domains(law.domains)
    notes += remarks(law)
    return Description(numbers, tuple(notes), bool(sampled), time.perf_counter() - began)


def conditions(contacts: Contacts, velocity: float, chosen: str = "") -> list[str]:
    """At what F_k and the propensity hold, where that tells: speed, temperature, and the laws of contacts."""
    surface, thermal, said = contacts.interface, contacts.thermal, list[str]()
    length, square, clock = (" m", " m²", " s") if surface is not None else ("", "", "")
    per_time = f" 1/{clock.strip()}" if clock else ""
    if thermal is not None:
        said.append(f"T = {thermal.temperature:.4g}{square}")
        if surface is not None:
            said[-1] += f" ({thermal.temperature / surface.temperature(kelvin=1.0):.4g} K)"
        said.append(f"attempt frequency {thermal.attempt_frequency:.4g}{per_time}")
    if contacts.ageing is not None:
        said.append(f"D = {contacts.ageing.rate:.4g}{square}{'/s' if clock else ''}")
    if contacts.delay is not None:
        said.append(f"delay {contacts.delay.time:.4g}{clock}")
    if contacts.grains is not None and contacts.grains.age is not None:
        said.append(f"thresholds that grow from the age {contacts.grains.age:.4g} on")
    if not said:
        return []
    speed = f"v = {velocity:.4g}{length}{'/s' if clock else ''}{f' ({chosen})' if chosen else ''}"
    return [f"F_k, K*, F_s/F_k and X* at {', '.join([speed, *said])}; all else is P_c alone"]


def _off(law: Thresholds, n: int) -> float | None:
    """Distance of <x_s^n> from n times the integral of x^(n-1) times the survival, and the rounding of both."""
    value = law.moment(n)
    if not np.isfinite(value):
        return None
    lower, upper = law.support()
    edges = [np.array([lower]), panel_edges(law), law.breakpoints, law.atoms[0]]
    if np.isfinite(upper):
        edges.append(np.array([upper]))
    else:
        # twice as far each time, until the rest adds nothing
        reach = float(law.isf(1e-3))
        for _ in range(_DOUBLINGS):
            if not float(law.sf(reach)) > _NEGLIGIBLE * value / reach**n:
                break
            reach *= 2.0
            edges.append(np.array([reach]))
    ends = np.unique(np.concatenate(edges))
    nodes, weights = gauss(ends[:-1], ends[1:])
    other = lower**n + n * float((weights * nodes ** (n - 1) * law.sf(nodes)).sum())
    return abs(other - value) + 4.0 * _EPSILON * value


def _spread(law: Thresholds, unit: str) -> Number:
    spread, second, off = law.std(), law.moment(2), _off(law, 2)
    if off is None or spread == 0.0:
        return Number(spread, None if off is None else 0.0, unit)
    # the variance of a narrow law is a small difference in the second road only
    error = min(off, 4.0 * _EPSILON * second) / spread
    return Number(spread, error + 4.0 * _EPSILON * spread, unit)


def _quantile(law: Thresholds, q: float, above: bool, unit: str) -> Number:
    x = float(law.isf(q) if above else law.ppf(q))
    tail, density = float(law.sf(x) if above else law.cdf(x)), float(law.pdf(x))
    smooth = density > 0.0 and np.isfinite(density) and not law.atoms[0].size
    return Number(x, (abs(tail - q) / density if smooth else 0.0) + 4.0 * _EPSILON * x, unit)


def _of_domains(domains: DomainSamples) -> dict[str, Number]:
    """What the sampled islands say beside their thresholds, with one standard error of the sampling."""
    islands = domains.barriers.size
    free, forces = domains.superlubric_weight, domains.forces
    root = np.sqrt(forces.size)
    return {
        "superlubric_weight": Number(free, float(np.sqrt(free * (1.0 - free) / islands)), ""),
        "mean_force": Number(domains.mean_force, float(forces.std() / root), "force"),
        "distance_from_exponential": Number(domains.exponential_distance, float(0.5 / root), ""),
    }
