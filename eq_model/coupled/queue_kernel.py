"""Future breaks in the order of the slider's positions at which they happen: a calendar of buckets.

A future break is one 64-bit key: the high bits are its place in its bucket, the low bits its
threshold. This identifies a contact well enough, as contacts of one threshold that break at one
place are alike. A bucket is sorted by place when the slider reaches it, in the order of arrival
where places are equal. Positions and thresholds are whole multiples of a unit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined, unsigned

THRESHOLD_BITS = 41  # of a key; the other 23 are its place in the bucket
CHUNK = 128  # keys in one piece of memory
PER_BUCKET = 16384  # most breaks of a bucket, on average: they fit a core's L2 cache
FEW = 64  # most keys, on average, that are moved to insert one into the open bucket
DIGIT = 8  # bits of a place that are sorted in one pass
WIDEST = 5  # buckets of at most 2^-5 mean thresholds: few contacts break in that of their birth

_THRESHOLD, _DIGIT = unsigned((1 << THRESHOLD_BITS) - 1), unsigned((1 << DIGIT) - 1)


class Queue(NamedTuple):
    """Buckets as chains of chunks of keys."""

    shift: np.int64  # bits of a bucket's width
    many: npt.NDArray[np.int32]  # number of breaks of each bucket
    last: npt.NDArray[np.int32]  # the chunk of each bucket that is being filled
    before: npt.NDArray[np.int32]  # the chunk before each chunk in its chain
    free: npt.NDArray[np.int32]  # free[0] is the number of free chunks, which follow it
    keys: npt.NDArray[np.uint64]  # (chunks, CHUNK)
    open: npt.NDArray[np.uint64]  # sorted keys of the open bucket, that of the slider
    spare: npt.NDArray[np.uint64]  # scratch memory to sort them
    digits: npt.NDArray[np.int64]  # counts of each digit, to sort them
    at: npt.NDArray[np.int64]  # index of the next open key, their end, and the bucket's number


def bucket_bits(n: int, mean: float, share_below: Callable[[float], float]) -> int:
    """Bits of a bucket's width for n contacts of `mean` threshold (units).

    share_below : share of the thresholds below a number of means; contacts that break in the bucket of
        their birth are inserted one by one, which is slow.
    """
    width = min(PER_BUCKET / n, 2.0**-WIDEST)
    while width * n * min(share_below(width), 1.0) > FEW and width * n > FEW:
        width *= 0.5
    return min(max(int(np.floor(np.log2(mean * width))), 1), 64 - THRESHOLD_BITS)


def make_queue(n: int, shift: int, buckets: int) -> Queue:
    """A queue for n contacts, with this many buckets; clear it first. Memory is used as it fills."""
    chunks = n // CHUNK + min(buckets, n) + 1
    return Queue(
        shift=np.int64(shift),
        many=np.zeros(buckets, np.int32),
        last=np.zeros(buckets, np.int32),
        before=np.empty(chunks, np.int32),
        free=np.empty(chunks + 1, np.int32),
        keys=np.empty((chunks, CHUNK), np.uint64),
        open=np.empty(n + 1, np.uint64),
        spare=np.empty(n + 1, np.uint64),
        digits=np.empty((-(-shift // DIGIT), 1 << DIGIT), np.int64),
        at=np.zeros(3, np.int64),
    )


@bare
def clear(queue, position):  # type: ignore[no-untyped-def]
    """Remove all breaks; the slider is at `position`, and the bucket before its own is open."""
    queue.many[:] = 0
    queue.free[0] = queue.free.size - 1
    for i in range(1, queue.free.size):
        queue.free[i] = queue.free.size - 1 - i
    queue.at[0], queue.at[1], queue.at[2] = 0, 0, (position >> queue.shift) - 1


@inlined
def next_break(queue):  # type: ignore[no-untyped-def]
    """Whether the open bucket has a break, and the position of the first; else that of the bucket's end."""
    low = queue.at[2] << queue.shift
    if queue.at[0] < queue.at[1]:
        return True, low + np.int64(queue.open[unsigned(queue.at[0])] >> unsigned(THRESHOLD_BITS))
    return False, low + (np.int64(1) << queue.shift)


@inlined
def take_next(queue):  # type: ignore[no-untyped-def]
    """Remove the next break of the open bucket and return its threshold."""
    queue.at[0] += 1
    return np.int64(queue.open[unsigned(queue.at[0] - 1)] & _THRESHOLD)


@inlined
def wait(queue, b, x):  # type: ignore[no-untyped-def]
    """Add a break at position b, of threshold x; b lies in the open bucket or beyond.

    A break beyond all buckets lies beyond the drive's end and is dropped.
    """
    k = b >> queue.shift
    key = (
        unsigned(b & ((np.int64(1) << queue.shift) - np.int64(1))) << unsigned(THRESHOLD_BITS)
    ) | unsigned(x)
    if k <= queue.at[2]:
        _insert(queue, key)
    elif k < queue.many.size:
        slot = unsigned(queue.many[unsigned(k)]) & unsigned(CHUNK - 1)
        if slot == unsigned(0):
            chunk = queue.free[queue.free[0]]
            queue.free[0] -= 1
            queue.before[chunk] = queue.last[unsigned(k)]
            queue.last[unsigned(k)] = chunk
        queue.keys[unsigned(queue.last[unsigned(k)]), slot] = key
        queue.many[unsigned(k)] += 1


@bare
def _insert(queue, key):  # type: ignore[no-untyped-def]
    """Put a break in its place among those of the open bucket."""
    if queue.at[1] == queue.open.size:  # use the room of keys that have been removed
        gone = queue.at[0]
        for j in range(gone, queue.at[1]):
            queue.open[j - gone] = queue.open[j]
        queue.at[0] = 0
        queue.at[1] -= gone
    j = queue.at[1]
    while j > queue.at[0] and queue.open[j - 1] > key:
        queue.open[j] = queue.open[j - 1]
        j -= 1
    queue.open[j] = key
    queue.at[1] += 1


@bare
def _take(queue, into):  # type: ignore[no-untyped-def]
    """Move the open bucket's keys to `into`; returns their number, and counts their digits."""
    k = queue.at[2]
    n, m = np.int64(queue.many[k]), np.int64(0)
    chunk = np.int64(queue.last[k])
    fill = n - (n - 1) // CHUNK * CHUNK
    queue.digits[:] = 0
    while m < n:
        for j in range(fill):
            key = queue.keys[chunk, j]
            into[m + j] = key
            for d in range(queue.digits.shape[0]):
                queue.digits[d, (key >> unsigned(THRESHOLD_BITS + d * DIGIT)) & _DIGIT] += 1
        m += fill
        fill = np.int64(CHUNK)
        queue.free[0] += 1
        queue.free[queue.free[0]] = chunk
        chunk = np.int64(queue.before[chunk])
    queue.many[k] = 0
    return n


@bare
def open_next(queue):  # type: ignore[no-untyped-def]
    """Open the next bucket and sort its breaks by place, then by arrival; False if there is none."""
    if queue.at[2] + 1 == queue.many.size:
        return False
    queue.at[2] += 1
    many = queue.digits.shape[0]
    old, new = (queue.spare, queue.open) if many % 2 else (queue.open, queue.spare)
    n = _take(queue, old)
    for d in range(many):
        at, places = np.int64(0), queue.digits[d]
        for k in range(places.size):
            places[k], at = at, at + places[k]
        for i in range(n):
            digit = (old[i] >> unsigned(THRESHOLD_BITS + d * DIGIT)) & _DIGIT
            new[unsigned(places[digit])] = old[i]
            places[digit] += 1
        old, new = new, old
    queue.at[0], queue.at[1] = 0, n
    return True
