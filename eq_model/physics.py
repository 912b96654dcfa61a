"""The law by which contacts break, as settings for the lane loop; their largest stretches; the time they take."""

from typing import Any

import numpy as np

from eq_model.draws.tables import DEEPEST
from eq_model.lattice import WholeDrive, durations
from origins import Contacts, Drive, Thermal
from origins.errors import InputError
from origins.laws.compiled import CompiledRates, called


def law_of(contacts: Contacts, way: WholeDrive, tie: int) -> Any:
    """The settings of these contacts' law in whole units; `tie` as in contact.Cold."""
    from eq_model import contact

    # without a thermal law, the rates of any law stand in: kernels do not use them then
    rates: Any = (contacts.thermal or Thermal("soft", 1.0)).rates
    found: CompiledRates = getattr(rates, "compiled", lambda: called(rates))()
    contact.RATES.setdefault(type(found.law), found)
    heat = contacts.thermal is not None, found.law, way.unit
    grains, ageing = contacts.grains, contacts.ageing
    if ageing is not None:
        from eq_model.laws.diffusing import make_diffusing

        return make_diffusing(ageing, contacts.thresholds, *heat)
    if grains is not None and grains.age is not None:
        from eq_model.laws.growing import Growing

        first = grains.growth.first_pinning_time
        root = float(np.sqrt(grains.growth.B)) * way.unit
        return Growing(first, root, (grains.age - first) / first, *heat)
    if contacts.thermal is None:
        return contact.Cold(np.int64(tie))
    # in holds, where the value is not used, only the logarithm of 0 is avoided
    return contact.Warm(*heat[1:], np.log(np.maximum(way.paces / way.unit, 1e-300)))


class Reach:
    """How far contacts may be stretched on a drive, lengths.

    furthest : the largest stretch at which contacts form; largest : the largest threshold at any time; longest : the
    largest stretch; span : shape (n,), the range of slider positions up to each point of the path; begun : shape (n,),
    the largest stretch up to there of contacts of the start that have not broken.
    """

    def __init__(self, contacts: Contacts, drive: Drive) -> None:
        """Compute the limits from the supports of the laws and from the path."""
        from eq_model.draws.births import laws_of, tables_of

        path, ends = np.append(0.0, drive.path), contacts.start.span
        high, low = np.maximum.accumulate(path)[1:], np.minimum.accumulate(path)[1:]
        self.span = high - low
        self.begun = np.maximum(np.maximum(ends[1] + high, -ends[0] - low), max(np.abs(ends)))
        self.largest = tables_of(contacts)["thresholds"].largest
        born = max(abs(end) for law in laws_of(contacts).values() for end in law.span)
        self.furthest = min(born, self.largest)
        if (grains := contacts.grains) is not None and grains.age is not None:
            # at the end of the drive, for contacts of the start, the oldest
            oldest = grains.age + float(durations(drive).sum())
            self.largest = max(self.largest, float(grains.quantile(1.0, oldest)))
        if (ageing := contacts.ageing) is not None:
            # less than one threshold in 1e17 diffuses by more than 9 standard deviations
            self.largest = max(self.largest, float(ageing.final.isf(DEEPEST)))
            self.largest += 9.0 * ageing.normal.std if ageing.normal is not None else 0.0
        self.longest = min(self.largest, float(self.span[-1]) + self.furthest)


def seconds_of(contacts: Contacts, drive: Drive, law: Any) -> float:
    """Estimated seconds for one contact.

    Raises InputError where it breaks, pins again or takes steps of ageing more than 3e7 times.
    """
    lasts, moved = durations(drive), np.abs(np.diff(drive.path, prepend=0.0))
    total, travel = float(lasts.sum()), float(moved.sum())
    thermal, again, grains = contacts.thermal, contacts.reforming, contacts.grains
    often = {"ageing": 0.0 if contacts.ageing is None else total / law.longest}
    if again is not None and again.law.is_single:
        # half of the contacts break again within this distance
        stretch, thresholds = abs(again.law.mean()), contacts.thresholds
        distance = float(thresholds.isf(0.5 * thresholds.sf(stretch))) - stretch
        often["reforming"] = travel / max(distance, 1e-300)
    if thermal is not None and grains is None and total > 0.0:
        fresh = contacts.thresholds.ppf((np.arange(256) + 0.5) / 256.0)
        # contacts hold longest while they are relaxed, so the number of breaks may be underestimated
        with np.errstate(over="ignore"):
            holds = np.exp(-thermal.log_rate(0.0, fresh, contacts.relative_stiffness(fresh)))
        often["thermal"] = total / (np.minimum(holds, total).mean() + contacts.waiting_time)
    elif thermal is not None:
        often["thermal"] = thermal.rates.scale * total
    if grains is not None:
        # a threshold is at most about alpha (time)^(1/3) / B^(1/2)
        with np.errstate(all="ignore"):
            holds = (grains.growth.alpha * lasts / (np.sqrt(grains.growth.B) * moved)) ** 1.5
        pinned = grains.growth.first_pinning_time + np.nan_to_num(holds)
        often["grains"] = float((lasts / pinned).sum())
    key = max(often, key=lambda each: often[each])
    if often[key] > 3e7:  # which take some ten seconds without interruption
        name = "ages in steps," if key == "ageing" else "breaks"
        raise InputError(
            f"{key}: each contact {name} about {often[key]:.0e} times on the drive, which takes {total:.1g}; "
            "take a shorter or faster drive, other units of time, or the master equation"
        )
    # seconds of a cold break, and of one under other laws or of a step of ageing
    return 2e-8 * travel / contacts.mean_threshold + 1e-7 * sum(often.values())
