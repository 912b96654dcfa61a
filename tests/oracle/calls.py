"""What the texts of calls in the oracle mean: each function here gives an `Answer`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.stats
from phase_type import coxian  # noqa: F401 (named by texts)

import master
import origins

Array = npt.NDArray[np.float64]
VERDICTS = ("smooth", "stick-slip", "decaying transient", "undecided")
STRETCHES = np.linspace(-1.05, 1.55, 27)  # in mean thresholds, where Q(x;X) is read


class Answer(NamedTuple):
    """Numbers, the errors claimed for them (one for all, or one each), and whether it succeeded.

    Lengths are in units of the mean threshold.
    """

    values: npt.ArrayLike
    claims: npt.ArrayLike
    success: bool = True


def evaluated(call: str, **others: Any) -> Any:
    """What the text of a call gives, by the functions of this module or by others of the same names."""
    return eval(call, {**vars(origins), "stats": scipy.stats, "np": np, **globals(), **others})


def turns(corners: npt.ArrayLike, points: int) -> Array:
    """A path through the corners in turn, so many points in all, as many on each leg."""
    at = np.asarray(corners, float)
    return np.interp(np.linspace(0, at.size - 1, points), np.arange(at.size), at)


def few(values: Array, points: int = 25) -> Array:
    """At most so many of the values, evenly spaced, first and last included."""
    return values[np.unique(np.round(np.linspace(0, len(values) - 1, points)).astype(int))]


def force(contacts: origins.Contacts, *asked: Any, **drive: Any) -> Answer:
    """The force along a path."""
    found = master.solve(contacts, *asked, **drive)
    return Answer(few(found.force) / contacts.mean_threshold, found.force_error, found.success)


def holding(contacts: origins.Contacts, *asked: Any, **drive: Any) -> Answer:
    """The fraction that holds, which is known as well as the force."""
    found = master.solve(contacts, *asked, **drive)
    return Answer(few(found.holding), found.force_error, found.success)


def slips(contacts: origins.Contacts, *asked: Any, **drive: Any) -> Answer:
    """Slips and the verdict; F + K X is flat where a slip begins: X is known to a root there."""
    unit, found = contacts.mean_threshold, master.solve(contacts, *asked, **drive)
    all_slips, regime = found.slips, found.regime
    names = ("drive", "before", "after", "force_before", "force_after")
    lengths = np.concatenate([getattr(all_slips, name) for name in names])
    verdict = [VERDICTS.index(regime.verdict), regime.critical_spring]
    spread = max(1.0, 1.0 / drive["spring"]) * np.sqrt(found.force_error)
    count = all_slips.drive.size
    claims = np.repeat([all_slips.drive_error / unit, spread], [count, 4 * count])
    values = [*lengths / unit, found.balance / unit, *verdict]
    return Answer(values, [*claims, 1e-12, 0.0, regime.critical_spring_error], found.success)


def q15(contacts: origins.Contacts, *asked: Any) -> Answer:
    """(Q15) as printed, with what it does not keep."""
    found = master.solve(contacts, *asked)
    parts = [found.force / contacts.mean_threshold, found.mass_defect, found.positivity_defect]
    return Answer(np.concatenate(parts), max(found.force_error, 1e-9), found.success)


def density_claim(error: float) -> float:
    """Densities claim no error: as derivatives they lose digits of the force's."""
    return 1e3 * error + 1e-6


def distribution(contacts: origins.Contacts, *task: Any, asked: tuple, **drive: Any) -> Answer:
    """Q(x;X): the density at some stretches, and moments of the shares at single ones."""
    unit, solution = contacts.mean_threshold, master.solve(contacts, *task, **drive)
    found = solution.distribution(*asked)
    place, weight = found.delta_positions / unit, found.delta_weights
    moments = [float((weight * place**power).sum()) for power in range(3)]
    values = [*found.density(STRETCHES * unit) * unit, *moments]
    return Answer(values, density_claim(solution.force_error), solution.success)


def steady_distribution(contacts: origins.Contacts) -> Answer:
    """Q_s(x) of smooth sliding."""
    unit, state = contacts.mean_threshold, master.steady_state(contacts)
    values = state.distribution(STRETCHES * unit) * unit
    return Answer(values, density_claim(state.force_error))


def steady(contacts: origins.Contacts, velocity: float = 1.0) -> Answer:
    """The kinetic force, the cycle length and the fraction that holds; of (Q15) the force alone."""
    unit, state = contacts.mean_threshold, master.steady_state(contacts, velocity=velocity)
    if not hasattr(state, "cycle_length"):
        return Answer(state.force / unit, state.force_error)
    unit = state.mean_threshold
    lost = (1 - state.holding) * state.cycle_length_error * unit / state.cycle_length
    claims = [state.force_error, state.cycle_length_error, lost + 1e-12]
    return Answer(
        [state.force / unit, state.cycle_length / unit, state.holding], claims, state.success
    )


def propensity(contacts: origins.Contacts, *asked: Any, **more: Any) -> Answer:
    """K*, F_s/F_k, X* and the onset power of P_c."""
    found = master.propensity(contacts, *asked, **more)
    names = ("critical_spring", "static_to_kinetic", "decoherence_length", "onset_power")
    scales = np.array([1.0, 1.0, contacts.mean_threshold, 1.0])
    values, claims = (
        np.array([getattr(found, name + end) for name in names]) / scales for end in ("", "_error")
    )
    return Answer(values, claims, found.success)


def kinetic_curve(contacts: origins.Contacts, *asked: Any, **more: Any) -> Answer:
    """F_k and the fraction that holds along speeds and the rest."""
    found = master.kinetic_curve(contacts, *asked, **more)
    values = [*(found.force / contacts.mean_threshold).ravel(), *found.holding.ravel()]
    claims = [*found.force_error.ravel(), *found.holding_error.ravel()]
    return Answer(values, claims, bool(np.all(found.success)))


def phase_line(contacts: origins.Contacts, *asked: Any, **more: Any) -> Answer:
    """K* along speeds and the rest."""
    found = master.phase_line(contacts, *asked, **more)
    errors = found.critical_spring_error.ravel()
    return Answer(found.critical_spring.ravel(), errors, bool(np.all(found.success)))


def decoherence_spectrum(contacts: origins.Contacts, **asked: Any) -> Answer:
    """Roots, amplitudes and the sum of the terms."""
    unit, found = contacts.mean_threshold, master.decoherence_spectrum(contacts, **asked)
    roots, amplitudes = found.roots * unit, found.amplitude / unit
    place = np.linspace(0.0, 12.0, 9) * unit
    lengths = [found.period / unit, found.decay_length / unit, found.force(place) / unit]
    values = [roots.real, roots.imag, amplitudes.real, amplitudes.imag, *lengths]
    root, amplitude = found.roots_error * unit, found.amplitude_error / unit
    lengths = [found.period_error / unit, found.decay_length_error / unit]
    claims = [root, root, amplitude, amplitude, *lengths, found.force_error(place)]
    return Answer(np.concatenate(values), np.concatenate(claims) + 1e-12)


def critical_velocity(contacts: origins.Contacts, *asked: Any) -> Answer:
    """v_c; where the drop is steepest it is flat, so that X there is known to a root."""
    found = master.critical_velocity(contacts, *asked)
    claims = [found.velocity_error, np.sqrt(found.velocity_error)]
    return Answer([found.velocity, found.position], claims)


def scene(name: str) -> Answer:
    """The force of a shipped scene; with a spring also where the drive stands at each slip."""
    import toolkit

    asked = toolkit.load_scene(name)
    drive, contacts = asked.drive, asked.contacts
    more = {} if drive.spring is None else {"spring": drive.spring, "slip": drive.slip}
    more |= {"velocity": drive.velocity, "time": drive.time}
    found = master.solve(contacts, asked.path, asked.master.tolerance, **more)
    values = few(found.force) / contacts.mean_threshold
    claims = np.full(values.size, found.force_error)
    if drive.spring is not None:
        unit, own = contacts.mean_threshold, found.slips
        values = np.append(values, own.drive / unit)
        claims = np.append(claims, np.full(own.drive.size, own.drive_error / unit))
    return Answer(values, claims, found.success)
