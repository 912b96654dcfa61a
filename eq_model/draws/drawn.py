"""What contacts draw: the cells of their thresholds and stretches, and of what they bear."""

from functools import cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from eq_model.draws.tables import DEEPEST, FAR, Cells, make_cells
from origins import Contacts
from origins.errors import InputError
from origins.start import Start

Array = npt.NDArray[np.float64]

_FAINTEST, _LEAST = 1e-290, 1e-300  # survival that contacts may begin at, and that a table reaches

# many seeds ask the same
_KNOWN: WeakKeyDictionary[Contacts, dict[str, Cells]] = WeakKeyDictionary()


def cells_of(contacts: Contacts) -> dict[str, Cells]:
    """Cells of "thresholds" and, unless these are single values, "start" and "reforming"; made once.

    Raises InputError where they cannot be certified, and where stretches reach so far beyond the
    thresholds that their survival is below 1e-290.
    """
    if contacts not in _KNOWN:
        laws: dict[str, Start] = {"start": contacts.start}
        if contacts.reforming is not None:
            laws["reforming"] = contacts.reforming.law
        rare = min(_survival(name, law, contacts) for name, law in laws.items())
        found = {"thresholds": make_cells(contacts.thresholds, max(DEEPEST * rare, _LEAST))}
        spread = ((name, law) for name, law in laws.items() if not law.is_single)
        _KNOWN[contacts] = found | {name: make_cells(law, name=name) for name, law in spread}
    return _KNOWN[contacts]


def births_of(contacts: Contacts, unit: float) -> tuple[Any, Any]:
    """Births at X = 0 and later on, as kernels take them, in units of a length."""
    from eq_model.draws.births import Births
    from eq_model.draws.streams import STARTS, THRESHOLDS

    cells, again = cells_of(contacts), contacts.reforming
    tables = {name: one.table(unit) for name, one in cells.items()}
    top = np.int64(min(contacts.thresholds.support()[1] / unit, float(FAR)))
    laws = ("start", contacts.start, STARTS), ("reforming", again and again.law, THRESHOLDS)
    first, later = (
        Births(
            tables["thresholds"],
            tables.get(name, tables["thresholds"]),
            np.int64(round(law.mean() / unit) if law else 0),
            name in tables,
            top,
            purpose,
        )
        for name, law, purpose in laws
    )
    return first, later


class _LogExposure:
    """ln e, e of the exponential law of mean 1: contacts break where the integral of their rate is e."""

    def cdf(self, x: npt.ArrayLike) -> Array:
        return -np.expm1(-np.exp(x))

    def sf(self, x: npt.ArrayLike) -> Array:
        return np.exp(-np.exp(x))

    def ppf(self, q: npt.ArrayLike) -> Array:
        return np.log(-np.log1p(-np.asarray(q, dtype=float)))

    def isf(self, q: npt.ArrayLike) -> Array:
        return np.log(-np.log(q))


@cache
def exposure_cells() -> Cells:
    """Of the logarithm of what contacts bear."""
    return make_cells(_LogExposure(), name="what contacts bear")


def _survival(name: str, law: Start, contacts: Contacts) -> float:
    """Survival of the thresholds where the stretches of `law` reach furthest."""
    thresholds, furthest = contacts.thresholds, max(abs(law.span[0]), abs(law.span[1]))
    upper = thresholds.support()[1]
    if furthest < upper:
        survival = float(thresholds.sf(furthest))
    else:
        # what lies beyond is cut off, but what is left comes close to the last of the thresholds
        survival = max(float(thresholds.sf(np.nextafter(upper, 0.0))), _FAINTEST)
    if survival < _FAINTEST:
        deepest = float(thresholds.isf(_FAINTEST))
        raise InputError(
            f"{name}: reaches |x| = {furthest:g}, where the survival of the thresholds is below 1e-290; "
            f"use stretches that contacts can have reached, below {deepest:.6g}"
        )
    return survival
