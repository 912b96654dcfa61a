"""Future breaks in the order of the slider's positions at which they happen: a calendar of buckets.

A future break is one 64-bit key: the high bits are its place in its bucket, the low bits its
threshold. This identifies a contact well enough, as contacts of one threshold that break at one
place are alike. The bucket that the slider has reached is open: its keys are a heap, in which two
larger keys follow each, numbers 2i and 2i + 1 after number i, so that number 1 is the next. Each
other bucket is a chain of slots. Positions and thresholds are whole multiples of a unit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined, unsigned

THRESHOLD_BITS = 41  # of a key; the other 23 are its place in the bucket


class Queue(NamedTuple):
    """Buckets as chains of slots, of which there is one for each contact; slot 0 is none."""

    shift: np.int64  # bits of a bucket's width
    first: npt.NDArray[np.int32]  # slot of each bucket's latest break
    after: npt.NDArray[np.int32]  # the next slot of the bucket, or the next free one
    keys: npt.NDArray[np.uint64]  # of the slots
    open: npt.NDArray[np.uint64]  # heap of the open bucket
    at: npt.NDArray[np.int64]  # number of open keys, number of the open bucket, first free slot


def make_queue(n: int, mean: float, furthest: int) -> Queue:
    """A queue for n contacts of `mean` threshold up to a position (units); clear it first.

    A bucket has some 128 breaks, or more where there would be above 2^25 buckets, which take 130 MB.
    """
    width = max(128.0 * mean / n, furthest * 2.0**-25)
    shift = min(max(int(np.log2(width)), 1), 64 - THRESHOLD_BITS)
    return Queue(
        shift=np.int64(shift),
        first=np.zeros((furthest >> shift) + 2, np.int32),
        after=np.empty(n + 2, np.int32),
        keys=np.empty(n + 2, np.uint64),
        open=np.empty(n + 2, np.uint64),
        at=np.zeros(3, np.int64),
    )


@bare
def clear(queue, position):  # type: ignore[no-untyped-def]
    """Remove all breaks; the slider is at `position`, and the bucket before its own is open."""
    queue.first[:] = 0
    for i in range(queue.after.size):
        queue.after[i] = i + 1
    queue.at[0], queue.at[1], queue.at[2] = 0, (position >> queue.shift) - 1, 1


@inlined
def next_break(queue):  # type: ignore[no-untyped-def]
    """Whether the open bucket has a break, and the position of the first; else that of the bucket's end."""
    low = queue.at[1] << queue.shift
    if queue.at[0]:
        return True, low + np.int64(queue.open[1] >> unsigned(THRESHOLD_BITS))
    return False, low + (np.int64(1) << queue.shift)


@inlined
def take_next(queue):  # type: ignore[no-untyped-def]
    """Remove the next break of the open bucket and return its threshold."""
    heap, i, many = queue.open, unsigned(1), unsigned(queue.at[0])
    taken, last = heap[1], heap[many]
    queue.at[0] -= 1
    while i + i < many:
        later = i + i
        later += unsigned(heap[later + unsigned(1)] < heap[later])
        if heap[later] >= last:
            break
        heap[i] = heap[later]
        i = later
    heap[i] = last
    return np.int64(taken & unsigned((1 << THRESHOLD_BITS) - 1))


@inlined
def wait(queue, b, x):  # type: ignore[no-untyped-def]
    """Add a break at position b, of threshold x; b lies in the open bucket or beyond.

    A break beyond all buckets lies beyond the drive's end and is dropped.
    """
    k = b >> queue.shift
    place = unsigned(b & ((np.int64(1) << queue.shift) - np.int64(1)))
    key = (place << unsigned(THRESHOLD_BITS)) | unsigned(x)
    if k <= queue.at[1]:
        _open(queue, key)
    elif k < queue.first.size:
        slot = queue.at[2]
        queue.at[2] = queue.after[unsigned(slot)]
        queue.keys[unsigned(slot)] = key
        queue.after[unsigned(slot)] = queue.first[unsigned(k)]
        queue.first[unsigned(k)] = slot


@inlined
def _open(queue, key):  # type: ignore[no-untyped-def]
    """Add a break to the open bucket."""
    queue.at[0] += 1
    heap, i = queue.open, unsigned(queue.at[0])
    while i > unsigned(1) and heap[i >> unsigned(1)] > key:
        heap[i] = heap[i >> unsigned(1)]
        i >>= unsigned(1)
    heap[i] = key


@inlined
def open_next(queue):  # type: ignore[no-untyped-def]
    """Open the next bucket, as the open one is empty; False if there is none."""
    k = queue.at[1] + 1
    if k == queue.first.size:
        return False
    slot = queue.first[k]
    queue.first[k], queue.at[1] = 0, k
    while slot:
        _open(queue, queue.keys[unsigned(slot)])
        after = queue.after[unsigned(slot)]
        queue.after[unsigned(slot)], queue.at[2] = queue.at[2], slot
        slot = after
    return True
