"""What other samples would have given: work on resampled laws, several at once."""

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from origins.contacts import Contacts
from origins.errors import refuse
from origins.laws.proportional import ProportionalGrowth
from origins.samples.from_samples import bootstrap_law
from origins.thresholds.law import Thresholds
from toolkit.processes.ranks import cores_of

T = TypeVar("T")


def like(contacts: Contacts, law: Thresholds) -> Contacts:
    """These contacts with a resampled law in place of their own, and all other laws as they are: in strong heat, where
    F_k is a small part of that without, other samples change it by that much less, too. Raises InputError for
    thresholds that change by a law which would be lost."""
    growth = contacts.changing
    if growth is None or contacts.ageing is not None:
        return contacts.replace(thresholds=law)
    if not isinstance(growth, ProportionalGrowth):
        hint = "has no other samples, which are those of thresholds that stay, age or grow by one factor"
        hint += "; give a law that is not from samples, or an origins.ProportionalGrowth"
        refuse("contacts.thresholds", growth, hint)
    return contacts.replace(thresholds=growth.over(law))


def of_resampled(
    law: Thresholds,
    count: int,
    work: Callable[[Thresholds], T],
    progress: Callable[[int, int], None] | None = None,
    until: float = math.inf,
) -> list[T]:
    """The results of `work` on so many laws that other samples would have given, in their order.

    Smoothing and `work` spend their time in products of matrices, which release Python's lock: one thread a core.
    `progress` is called as progress(done, count). An exception ends the work after the laws that are begun, as does the
    time `until`, in s of the monotonic clock: the results are then those of fewer laws.
    """
    found = list[T]()
    pool = ThreadPoolExecutor(min(cores_of(None), count))
    try:
        for one in pool.map(lambda replica: work(bootstrap_law(law, replica)), range(count)):
            found.append(one)
            if progress is not None:
                progress(len(found), count)
            if time.monotonic() > until:
                break
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return found
