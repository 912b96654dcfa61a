"""How contacts begin: starting stretches, and first thresholds that exceed them."""

from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from eq_model.compiled_table import kernel_table
from origins import Contacts, streams
from origins.errors import InputError
from origins.quantile import DEEPEST, QuantileTable, quantile_table
from origins.start import Start
from origins.thresholds import Thresholds

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

_FAINTEST, _LEAST = 1e-290, 1e-300
_DEEP = 2.0**-24  # survival from which on what the thresholds' own table lacks, 2^-54, is missed
_SELDOM = 1e-9  # weight of re-forming that may miss it

Tables = tuple[QuantileTable, QuantileTable | None]
# many seeds ask the same
_KNOWN: WeakKeyDictionary[Contacts, Tables] = WeakKeyDictionary()


class Beginning:
    """Starting positions and first thresholds of contacts of `n_contacts` in each replica, in random numbers of `key`.

    table, start_table : as of `tables`; words : the key as kernels take it; compiled : the table of thresholds as they
    take it, from `compile` on.
    """

    def __init__(self, contacts: Contacts, n_contacts: int, key: tuple[int, int]) -> None:
        self.contacts, self.n_contacts, self.key = contacts, n_contacts, key
        self.words = tuple(np.uint64(word) for word in key)
        self.table, self.start_table = tables(contacts)

    def compile(self, unit: float) -> None:
        """Choose the unit (a length)."""
        self._unit, self.compiled = unit, kernel_table(self.table, unit)
        self._start = self.compiled if self.start_table is None else kernel_table(self.start_table, unit)

    def draw(self, block: range, none: bool = False) -> tuple[Whole, Whole]:
        """Negative starting stretches and first thresholds of a block, in whole units; empty if `none`."""
        from eq_model import kernel

        start, size, unit = self.contacts.start, 0 if none else len(block), self._unit
        births, firsts = np.full(size, round(-start.mean() / unit), np.int64), np.empty(size, np.int64)
        begun, single = self._start, start.is_single
        kernel.begin(block.start, self.n_contacts, self.words, self.compiled, begun, single, births, firsts)
        again = np.flatnonzero(firsts < 0)
        if again.size:
            replica, contact = np.divmod((again + block.start).astype(np.uint64), np.uint64(self.n_contacts))
            stretches = (births[again] * -unit).astype(float)
            stretches, thresholds = redraw(
                stretches, replica, contact, self.key, self.contacts, self.table, self.start_table
            )
            births[again] = np.rint(-stretches / unit).astype(np.int64)
            # beyond the path it does not matter how far
            firsts[again] = np.minimum(np.rint(thresholds / unit), float(kernel.FAR)).astype(np.int64)
            np.maximum(firsts, np.abs(births), out=firsts)
        return births, firsts


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
    survival = _survival("start", start, thresholds)
    table = quantile_table(thresholds, deepest=max(DEEPEST * survival, _LEAST))
    return table, None if start.is_single else quantile_table(start, name="start")


def reforming_table(contacts: Contacts) -> QuantileTable:
    """Quantile table of the stretches at which contacts form again; InputError where it cannot be certified."""
    assert contacts.reforming is not None
    return quantile_table(contacts.reforming.law, name="reforming")


def deep_table(contacts: Contacts) -> tuple[QuantileTable, float] | None:
    """A table of the thresholds for those contacts that form again where next to none is left, and the stretch (a
    length) from which on; None where too few do to show.

    Raises InputError where the survival is below 1e-290 there.
    """
    reforming, thresholds = contacts.reforming, contacts.thresholds
    if reforming is None:
        return None
    law, limit = reforming.law, float(thresholds.isf(_DEEP))
    survival = _survival("reforming", law, thresholds)
    further = float(abs(law.mean()) > limit) if law.is_single else float(law.cdf(-limit) + law.sf(limit))
    if further <= _SELDOM:
        return None
    return quantile_table(thresholds, deepest=max(DEEPEST * survival, _LEAST)), limit


def _survival(name: str, law: Start, thresholds: Thresholds) -> float:
    """Survival of the thresholds where the stretches of `law` reach furthest."""
    furthest = max(abs(law.span[0]), abs(law.span[1]))
    upper = thresholds.support()[1]
    if furthest < upper:
        survival = float(thresholds.sf(furthest))
    else:
        # what lies beyond every threshold is cut off, but what is left comes close to the last of them
        survival = max(float(thresholds.sf(np.nextafter(upper, 0.0))), _FAINTEST)
    if survival < _FAINTEST:
        deepest = float(thresholds.isf(_FAINTEST))
        raise InputError(
            f"{name}: reaches |x| = {furthest:g}, where the survival of the thresholds is below 1e-290; use stretches "
            f"that contacts can have reached, below {deepest:.6g}"
        )
    return survival


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
