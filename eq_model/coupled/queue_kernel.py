"""Future breaks in the order of the slider's positions at which they happen: a calendar of buckets.

A future break is one 64-bit key: the high bits are its place in its bucket, the low bits its
threshold. This identifies a contact well enough, as contacts of one threshold that break at one
place are alike. A bucket is sorted by place when the slider reaches it, in the order of arrival
where places are equal. Positions and thresholds are whole multiples of a unit.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined, unsigned

THRESHOLD_BITS = 41  # of a key; the other 23 are its place in the bucket
CHUNK = 128  # keys in one piece of memory
NEXT, END, BUCKET = range(3)  # in Queue.at: the next open key, their end, and the bucket


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
    counts: npt.NDArray[np.int64]  # of the 256 values of a digit, to sort them
    at: npt.NDArray[np.int64]  # (3,), see NEXT


def bucket_bits(n: int, mean: float, share_below: Callable[[float], float]) -> int:
    """Bits of a bucket's width for n contacts of `mean` threshold (units).

    share_below : share of the thresholds below a number of means; contacts that break in the bucket of
        their birth are inserted one by one, which is slow.
    """
    # a bucket's breaks, 16384 on average, fit a core's L2 cache; few contacts break in that of their birth
    width = min(16384 / n, 2.0**-5)
    while width * n * min(share_below(width), 1.0) > 64.0:  # keys that are moved to insert one
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
        counts=np.empty(256, np.int64),
        at=np.zeros(3, np.int64),
    )


@bare
def clear(queue, position):  # type: ignore[no-untyped-def]
    """Remove all breaks; the slider is at `position`, and the bucket before its own is open."""
    queue.many[:] = 0
    queue.free[0] = queue.free.size - 1
    for i in range(1, queue.free.size):
        queue.free[i] = queue.free.size - 1 - i
    queue.at[NEXT], queue.at[END], queue.at[BUCKET] = 0, 0, (position >> queue.shift) - 1


@inlined
def next_break(queue):  # type: ignore[no-untyped-def]
    """Whether the open bucket has a break, and the position of the first; else that of the bucket's end."""
    low = queue.at[BUCKET] << queue.shift
    if queue.at[NEXT] < queue.at[END]:
        key = queue.open[unsigned(queue.at[NEXT])]
        return True, low + np.int64(key >> unsigned(THRESHOLD_BITS))
    return False, low + (np.int64(1) << queue.shift)


@inlined
def take_next(queue):  # type: ignore[no-untyped-def]
    """Remove the next break of the open bucket and return its threshold."""
    queue.at[NEXT] += 1
    return np.int64(queue.open[unsigned(queue.at[NEXT] - 1)] & unsigned((1 << THRESHOLD_BITS) - 1))


@inlined
def add_break(queue, b, x):  # type: ignore[no-untyped-def]
    """Add a break at position b, of threshold x; b lies in the open bucket or beyond.

    A break beyond all buckets lies beyond the drive's end and is dropped.
    """
    k = b >> queue.shift
    place = unsigned(b & ((np.int64(1) << queue.shift) - np.int64(1)))
    key = (place << unsigned(THRESHOLD_BITS)) | unsigned(x)
    if k <= queue.at[BUCKET]:
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
    if queue.at[END] == queue.open.size:  # use the room of keys that have been removed
        gone = queue.at[NEXT]
        for j in range(gone, queue.at[END]):
            queue.open[j - gone] = queue.open[j]
        queue.at[NEXT] = 0
        queue.at[END] -= gone
    j = queue.at[END]
    while j > queue.at[NEXT] and queue.open[j - 1] > key:
        queue.open[j] = queue.open[j - 1]
        j -= 1
    queue.open[j] = key
    queue.at[END] += 1


@bare
def open_next(queue):  # type: ignore[no-untyped-def]
    """Open the next bucket and sort its breaks by place, then by arrival; False if there is none."""
    k = queue.at[BUCKET] + 1
    if k == queue.many.size:
        return False
    n, m, chunk = np.int64(queue.many[k]), np.int64(0), np.int64(queue.last[k])
    passes = (queue.shift + 7) // 8
    old, new = (queue.spare, queue.open) if passes % 2 else (queue.open, queue.spare)
    while m < n:  # the last chunk is filled in part
        fill = (n - m - 1) % CHUNK + 1
        for j in range(fill):
            old[m + j] = queue.keys[chunk, j]
        m += fill
        queue.free[0] += 1
        queue.free[queue.free[0]] = chunk
        chunk = np.int64(queue.before[chunk])
    for d in range(passes):  # a digit of eight bits after the other, from the last one
        shift, at, counts = unsigned(THRESHOLD_BITS + 8 * d), np.int64(0), queue.counts
        counts[:] = 0
        for i in range(n):
            counts[(old[i] >> shift) & unsigned(255)] += 1
        for digit in range(counts.size):
            counts[digit], at = at, at + counts[digit]
        for i in range(n):
            digit = (old[i] >> shift) & unsigned(255)
            new[unsigned(counts[digit])] = old[i]
            counts[digit] += 1
        old, new = new, old
    queue.many[k], queue.at[NEXT], queue.at[END], queue.at[BUCKET] = 0, 0, n, k
    return True
