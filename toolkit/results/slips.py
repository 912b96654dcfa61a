"""Which slips of an ensemble's sliders are those of all contacts."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from origins.drive import SLIP_SHARE


def main_slips(slips: Any) -> Any:
    """The slips of an ensemble, numbered anew, but those that lower the force by less than SLIP_SHARE of their slider's
    largest of late: a narrow peak of P_c may slip alone between slips of all contacts."""
    kept = np.zeros(slips.drop.size, bool)
    for replica in np.unique(slips.replica):
        own = np.flatnonzero(slips.replica == replica)
        drops = slips.drop[own]
        late = drops[drops.size // 2 if drops.size > 2 else 0 :]
        kept[own] = drops >= SLIP_SHARE * late.max()
    return _of(slips, kept)


def large_slips(slips: Any, least: float) -> Any:
    """The slips of an ensemble, numbered anew, that lower the force by `least` (a length, F/(N_c <k>)) or more: the
    jerks of few contacts that slide are smaller."""
    return _of(slips, np.asarray(slips.drop >= least))


def _of(slips: Any, kept: npt.NDArray[np.bool_]) -> Any:
    """The slips that are kept, numbered anew along each slider."""
    number = np.zeros(kept.size, int)
    for replica in np.unique(slips.replica):
        own = slips.replica == replica
        number[own] = np.cumsum(kept[own]) - 1
    columns = {each.name: getattr(slips, each.name)[kept] for each in fields(slips)}
    return replace(slips, **columns | {"number": number[kept]})
