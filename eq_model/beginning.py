"""How contacts begin: starting stretches, and first thresholds that exceed them."""

from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from origins import Contacts, streams
from origins.errors import InputError
from origins.quantile import DEEPEST, QuantileTable, quantile_table

Array = npt.NDArray[np.float64]

_FAINTEST = 1e-290

Tables = tuple[QuantileTable, QuantileTable | None]
# many seeds ask the same
_KNOWN: WeakKeyDictionary[Contacts, Tables] = WeakKeyDictionary()


def tables(contacts: Contacts) -> Tables:
    """Quantile tables of the thresholds and, unless all contacts start from one stretch, of the start, made once.

    Raises InputError where they cannot be certified, or where the start reaches so far beyond the thresholds
    that their survival is below 1e-290.
    """
    if contacts not in _KNOWN:
        _KNOWN[contacts] = _tabulated(contacts)
    return _KNOWN[contacts]


def _tabulated(contacts: Contacts) -> Tables:
    thresholds, start = contacts.thresholds, contacts.start
    furthest = max(abs(start.span[0]), abs(start.span[1]))
    upper = thresholds.support()[1]
    if furthest < upper:
        survival = float(thresholds.sf(furthest))
    else:
        # the start beyond every threshold is cut off, but what is left comes close to the last of them
        survival = max(float(thresholds.sf(np.nextafter(upper, 0.0))), _FAINTEST)
    if survival < _FAINTEST:
        raise InputError(
            f"start: reaches |x| = {furthest:g}, where the survival of the thresholds is below 1e-290; start from "
            "stretches that contacts can have reached"
        )
    table = quantile_table(thresholds, deepest=max(DEEPEST * survival, 1e-300))
    return table, None if start.is_single else quantile_table(start, name="start")


def redraw(
    stretches: Array,
    replica: npt.NDArray[np.uint64],
    contact: npt.NDArray[np.uint64],
    key: tuple[int, int],
    contacts: Contacts,
    table: QuantileTable,
    start_table: QuantileTable | None,
) -> tuple[Array, Array]:
    """Starting stretches and first thresholds (lengths) of contacts whose free threshold was below their stretch.

    A free draw, kept where it exceeds |x|, and else this one, from P_c conditional on x_s > |x|, together follow that
    conditional law. A stretch beyond every threshold is drawn again too.
    """
    upper = contacts.thresholds.support()[1]
    stretches = stretches.copy()
    attempt = 2
    beyond = np.flatnonzero(np.abs(stretches) >= upper)
    while beyond.size and start_table is not None:
        found = streams.words(key, streams.START, replica[beyond], contact[beyond], attempt).astype(np.uint64)
        word, more = found[0], found[1]
        v = (((word & np.uint64(0x7FFFFFFF)) << np.uint64(32) | more).astype(float) + 0.5) * 2.0**-64
        stretches[beyond] = start_table.value(v, word >> np.uint64(31) == 1)
        beyond = beyond[np.abs(stretches[beyond]) >= upper]
        attempt += 1
    _, _, word, more = streams.words(key, streams.START, replica, contact, 1).astype(np.uint64)
    w = ((word << np.uint64(32) | more).astype(float) + 0.5) * 2.0**-64
    x = np.abs(stretches)
    survival = contacts.thresholds.sf(x)
    above = survival * w
    below = contacts.thresholds.cdf(x) + survival * (1.0 - w)
    rare = above <= 0.5
    return stretches, np.maximum(table.value(np.where(rare, above, below), rare), x)
