"""Which slips of an ensemble's sliders are those of all contacts."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from origins.drive import SLIP_SHARE


def main_slips(slips: Any) -> Any:
    """The slips of an ensemble, numbered anew, but those that lower the force by less than SLIP_SHARE of their slider's
    largest of late: a narrow peak of P_c may slip alone between slips of all contacts."""
    kept, number = np.zeros(slips.drop.size, bool), np.zeros(slips.drop.size, int)
    for replica in np.unique(slips.replica):
        own = np.flatnonzero(slips.replica == replica)
        drops = slips.drop[own]
        late = drops[drops.size // 2 if drops.size > 2 else 0 :]
        kept[own] = drops >= SLIP_SHARE * late.max()
        number[own] = np.cumsum(kept[own]) - 1
    columns = {each.name: getattr(slips, each.name)[kept] for each in fields(slips)}
    return replace(slips, **columns | {"number": number[kept]})
