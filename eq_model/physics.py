"""The law by which a contact breaks, as the lane loop takes it: of a type that says which it is; its work."""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from eq_model.draws.tables import DEEPEST
from eq_model.lattice import Lattice
from origins import Contacts, Drive, RateLaw, Thermal
from origins.errors import InputError
from origins.laws.compiled import CompiledRates, called

# of the time in which old thresholds forget: the bridge within a step is that of free diffusion
STEP = 0.04
STEP_ELSE = 0.01  # of the squared width of another final law's middle half: a step's variance

_SPREAD = 9.0  # standard deviations beyond which no threshold of 1e17 diffuses
_MOST = 3e7  # breaks or steps of one contact, which is followed in one go: some ten seconds
_ANY = Thermal("soft", 1.0)
_CALLED: WeakKeyDictionary[object, CompiledRates] = WeakKeyDictionary()


def _compiled(rates: RateLaw) -> CompiledRates:
    """What a law brings for compiled loops; of one that brings nothing, made once, calls of its methods."""
    own = getattr(rates, "compiled", None)
    if own is not None:
        return own()
    if rates not in _CALLED:
        _CALLED[rates] = called(rates)
    return _CALLED[rates]


def law_of(contacts: Contacts, lattice: Lattice, tie: int) -> Any:
    """The settings of these contacts' law in whole units; `tie` as of breaking.Cold."""
    from eq_model.laws import breaking

    # without rates, those of some law: kernels do not ask for them then
    found, unit = _compiled((contacts.thermal or _ANY).rates), lattice.unit
    breaking.RATES.setdefault(type(found.law), found)
    heat = contacts.thermal is not None, found.law, unit
    grains = contacts.grains
    if contacts.ageing is not None:
        return _diffusing(contacts, unit, heat)
    if grains is not None and grains.age is not None:
        from eq_model.laws.growing import Growing

        first = grains.growth.first_pinning_time
        root = float(np.sqrt(grains.growth.B)) * unit
        return Growing(first, root, (grains.age - first) / first, *heat)
    if contacts.thermal is None:
        return breaking.Cold(np.int64(tie))
    # of a stand any number
    log_slow = np.log(np.maximum(lattice.course.paces / unit, 1e-300))
    return breaking.Warm(found.law, unit, log_slow)


def _diffusing(contacts: Contacts, unit: float, heat: tuple[bool, Any, float]) -> Any:
    from eq_model.laws.ageing_tables import NO_DRIFT, drift_table
    from eq_model.laws.diffusing import Ageing

    ageing = contacts.ageing
    assert ageing is not None
    normal, final, diffusion = ageing.normal, ageing.final, ageing.rate / unit**2
    if normal is not None:
        mean, width, longest = normal.mean / unit, normal.std / unit, STEP / normal.rate
        return Ageing(True, mean, width, normal.rate, diffusion, NO_DRIFT, longest, 1.0, *heat)
    table = drift_table(final, contacts.thresholds).in_units(unit)
    longest = STEP_ELSE * float(final.isf(0.25) - final.ppf(0.25)) ** 2 / (2.0 * ageing.rate)
    return Ageing(False, 0.0, 0.0, 0.0, diffusion, table, longest, 1.0, *heat)


def furthest_threshold(contacts: Contacts, drive: Drive, fresh: float) -> float:
    """The largest threshold (a length) there may come to be, of which `fresh` is that of the fresh ones."""
    grains, ageing = contacts.grains, contacts.ageing
    if grains is not None and grains.age is not None:
        # in the end, when no contact is older than those at X = 0
        lasts = float(_durations(drive).sum())
        return max(fresh, float(grains.quantile(1.0, grains.age + lasts)))
    if ageing is None or ageing.rate == 0.0:
        return fresh
    if ageing.normal is not None:
        return max(fresh, ageing.normal.mean) + _SPREAD * ageing.normal.std
    return max(fresh, float(ageing.final.isf(DEEPEST)))


def _durations(drive: Drive) -> Any:
    """Of the ways to each point, times."""
    if drive.time is not None:
        return np.diff(drive.time, prepend=0.0)
    return np.abs(np.diff(drive.path, prepend=0.0)) / drive.velocity


def seconds_of(contacts: Contacts, drive: Drive, law: Any) -> float:
    """About what a contact takes.

    Raises InputError where it breaks, pins anew or ages in steps more than 3e7 times.
    """
    lasts, moved = _durations(drive), np.abs(np.diff(drive.path, prepend=0.0))
    total, often, steps = float(lasts.sum()), 0.0, 0.0
    if contacts.ageing is not None:
        steps = total / law.longest
    if contacts.thermal is not None and total > 0.0:
        often = contacts.thermal.attempt_frequency * total
        if contacts.grains is None:
            thresholds = contacts.thresholds.ppf((np.arange(256) + 0.5) / 256.0)
            stiffness = contacts.relative_stiffness(thresholds)
            # relaxed contacts bear most: the others do not hold as long
            with np.errstate(over="ignore"):
                holds = np.exp(-contacts.thermal.log_rate(0.0, thresholds, stiffness))
            often = total / (float(np.minimum(holds, total).mean()) + contacts.waiting_time)
    if contacts.grains is not None:
        growth = contacts.grains.growth
        # a threshold is at most about alpha (time)^(1/3) / B^(1/2)
        speed = np.divide(moved, lasts, out=np.zeros(moved.size), where=lasts > 0.0)
        with np.errstate(over="ignore", divide="ignore"):
            holds = (growth.alpha / (np.sqrt(growth.B) * speed)) ** 1.5
        often = max(often, float((lasts / (growth.first_pinning_time + holds)).sum()))
    for name, number in (("breaks", often), ("ages in steps,", steps)):
        if number > _MOST:
            what = "thermal" if contacts.thermal else "ageing" if contacts.ageing else "grains"
            raise InputError(
                f"{what}: each contact {name} about {number:.0e} times on the drive, which takes {total:.1g}; "
                "take a shorter or faster drive, other units of time, or the master equation"
            )
    return 2e-8 * moved.sum() / contacts.mean_threshold + 1e-7 * often + 2e-7 * steps
