"""The nearest of many places, each that of a contact, which change one at a time: those of breaks ahead, or behind.

The places before a horizon are kept sorted, and those that come there later in a heap. A contact whose place has
changed stays in these until it is met, and is then passed over. Once the horizon is reached, or so many have come later
that the heap is full, it is only known that no place lies before a `bound`. A slider that gets there looks through
all contacts: in a long slip after every sixteenth of them has broken, and on the side that lies behind it never.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Whole
from eq_model.compiling import bare, inlined, unsigned

FAR = 1 << 62  # of a contact that does not hold; beyond all places
NUMBER_BITS = (
    31  # of a key, for the contact's number; the others are its place less that of the first
)
WIDEST = 32  # most bits of a horizon's distance
# In Nearest.at: the next sorted key and their end; the first place and the bits of the horizon's distance; how many
# came later; the bound; whether all before the horizon are known; the contact that is the nearest; and up to which key
# places are fetched, with what became of them.
NEXT, END, LOW, WIDTH, LATER, BOUND, KNOWN, WHO, FETCHED, SUM = range(10)
TOGETHER = 64  # places that are fetched together; a core waits for some ten at once


class Nearest(NamedTuple):
    """The places of n contacts, and the nearest of them."""

    places: Whole  # (n,)
    keys: npt.NDArray[np.uint64]  # (n,), sorted
    spare: npt.NDArray[np.uint64]  # scratch memory to sort them
    counts: Whole  # of the 256 values of a digit, to sort them
    heap: Whole  # places that came later
    heap_of: Whole  # and whose they are
    at: Whole  # (10,), see NEXT


def make_nearest(n: int, width: float) -> Nearest:
    """For n contacts, none of which holds; `width` : a length (units) within which a sixteenth of them break."""
    heap = n // 16 + 64
    at = np.zeros(10, np.int64)
    at[WIDTH], at[BOUND] = min(max(int(np.log2(max(width, 2.0))), 1), WIDEST), FAR
    keys = np.empty(n, np.uint64), np.empty(n, np.uint64)
    more = np.empty(256, np.int64), np.empty(heap, np.int64), np.empty(heap, np.int64), at
    return Nearest(np.full(n, FAR), *keys, *more)


@inlined
def nearest(near):  # type: ignore[no-untyped-def]
    """The nearest place if it is known, else the bound."""
    at = near.at
    if at[KNOWN] == 0:
        return at[BOUND]
    low, found = at[LOW], np.int64(FAR)
    while at[NEXT] < at[END]:
        key = near.keys[unsigned(at[NEXT])]
        i = key & unsigned((1 << NUMBER_BITS) - 1)
        place = low + np.int64(key >> unsigned(NUMBER_BITS))
        if near.places[i] == place:
            found, at[WHO] = place, np.int64(i)
            break
        at[NEXT] += 1
    while at[LATER] > 0:
        place, i = near.heap[0], unsigned(near.heap_of[0])
        if near.places[i] == place:
            if place < found:
                found, at[WHO] = place, np.int64(i)
            break
        _remove_first(near)
    if found == FAR and low != FAR:
        at[KNOWN] = 0  # the bound is the horizon
        found = at[BOUND]
    return found


@bare
def fetch(near, other):  # type: ignore[no-untyped-def]
    """Read the places of the next contacts, on both sides, so that they are in the cache when each is met: the reads of
    one break after the other would wait for memory one by one."""
    at, found = near.at, np.int64(0)
    end = min(at[NEXT] + TOGETHER, at[END])
    for k in range(unsigned(at[NEXT]), unsigned(end)):
        i = near.keys[k] & unsigned((1 << NUMBER_BITS) - 1)
        found ^= near.places[i] ^ other.places[i]
    at[FETCHED], at[SUM] = end, found  # kept, or the compiler would leave the reads out


@inlined
def set_place(near, contact, place):  # type: ignore[no-untyped-def]
    """Give a contact a new place."""
    near.places[unsigned(contact)] = place
    if place < near.at[BOUND]:
        _come_before(near, contact, place)


@bare
def _come_before(near, contact, place):  # type: ignore[no-untyped-def]
    """A contact comes to a place before the horizon, or before the bound."""
    at = near.at
    if at[KNOWN] == 0:
        at[BOUND] = place
        return
    if at[LATER] == near.heap.size:
        at[BOUND] = min(place, nearest(near))
        at[KNOWN] = 0
        return
    j = at[LATER]
    at[LATER] = j + 1
    while j > 0 and near.heap[(j - 1) >> 1] > place:
        near.heap[j], near.heap_of[j] = near.heap[(j - 1) >> 1], near.heap_of[(j - 1) >> 1]
        j = (j - 1) >> 1
    near.heap[j], near.heap_of[j] = place, contact


@bare
def _remove_first(near):  # type: ignore[no-untyped-def]
    """Remove the first of the heap."""
    last = near.at[LATER] - 1
    near.at[LATER] = last
    place, contact, j = near.heap[last], near.heap_of[last], np.int64(0)
    while 2 * j + 1 < last:
        child = 2 * j + 1
        if child + 1 < last and near.heap[child + 1] < near.heap[child]:
            child += 1
        if near.heap[child] >= place:
            break
        near.heap[j], near.heap_of[j] = near.heap[child], near.heap_of[child]
        j = child
    near.heap[j], near.heap_of[j] = place, contact


@bare
def look_through(near):  # type: ignore[no-untyped-def]
    """Look through all contacts, and sort those that are nearest."""
    at, n, width = near.at, near.places.size, near.at[WIDTH]
    low, most = np.int64(FAR), near.heap.size * np.int64(2)
    for i in range(unsigned(n)):
        low = min(low, near.places[i])
    at[LOW], at[NEXT], at[LATER], at[KNOWN], at[FETCHED] = low, 0, 0, 1, 0
    many = most + 1
    while (
        many > most
    ):  # arrays of keys take memory as they fill: at most so many, but where places are equal
        many, passes = np.int64(0), (width + 7) // 8
        at[BOUND] = min(low + (np.int64(1) << width), np.int64(FAR))
        old, new = (near.spare, near.keys) if passes % 2 else (near.keys, near.spare)
        for i in range(unsigned(n)):
            place = near.places[i]
            if place < at[BOUND]:
                old[unsigned(many)] = (unsigned(place - low) << unsigned(NUMBER_BITS)) | i
                many += 1
                if many > most and width > 1:
                    width -= 1
                    break
        else:
            break
    at[END], at[WIDTH] = many, width
    for d in range(passes):  # a digit of eight bits after the other, from the last one
        shift, begin = unsigned(NUMBER_BITS + 8 * d), np.int64(0)
        near.counts[:] = 0
        for k in range(unsigned(many)):
            near.counts[(old[k] >> shift) & unsigned(255)] += 1
        for digit in range(256):
            near.counts[digit], begin = begin, begin + near.counts[digit]
        for k in range(unsigned(many)):
            digit = (old[k] >> shift) & unsigned(255)
            new[unsigned(near.counts[digit])] = old[k]
            near.counts[digit] += 1
        old, new = new, old
    # next time a sixteenth of the contacts, or some
    if many > max(n // 12, 64) and width > 1:
        at[WIDTH] = width - 1
    elif many < max(n // 24, 16) and width < WIDEST:
        at[WIDTH] = width + 1
