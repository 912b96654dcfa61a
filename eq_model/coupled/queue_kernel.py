"""Future breaks in the order of the slider's positions at which they happen: a calendar of buckets.

A future break is one 64-bit key: the high bits are its place in its bucket, the low bits its
threshold. This identifies a contact well enough, as contacts of one threshold that break at one
place are alike. The bucket that the slider has reached is open: its keys are a heap, in which two
larger keys follow each, numbers 2i and 2i + 1 after number i, so that number 1 is the next. Each
other bucket is a chain of chunks of keys, since its breaks are met together and shall lie together.
Positions and thresholds are whole multiples of a unit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined, unsigned

THRESHOLD_BITS = 41  # of a key; the other 23 are its place in the bucket
CHUNK = 16  # keys in a chunk


class Queue(NamedTuple):
    """Buckets as chains of chunks of keys."""

    shift: np.int64  # bits of a bucket's width
    many: npt.NDArray[np.int32]  # number of breaks of each bucket
    last: npt.NDArray[np.int32]  # the chunk of each bucket that is being filled
    chunks: npt.NDArray[
        np.uint64
    ]  # (chunks, CHUNK + 1): keys, and the chunk before or the next free
    open: npt.NDArray[np.uint64]  # heap of the open bucket
    at: npt.NDArray[np.int64]  # number of open keys, number of the open bucket, first free chunk


def make_queue(n: int, mean: float, furthest: int) -> Queue:
    """A queue for n contacts of `mean` threshold up to a position (units); clear it first.

    A bucket has some 128 breaks, or more where there would be above 2^25 buckets, which take 270 MB.
    """
    width = max(128.0 * mean / n, 2.0**-25 * furthest)
    shift = min(max(int(np.ceil(np.log2(width))), 1), 64 - THRESHOLD_BITS)
    buckets = (furthest >> shift) + 2
    return Queue(
        shift=np.int64(shift),
        many=np.zeros(buckets, np.int32),
        last=np.zeros(buckets, np.int32),
        chunks=np.empty((n // CHUNK + min(buckets, n) + 1, CHUNK + 1), np.uint64),
        open=np.empty(n + 2, np.uint64),
        at=np.zeros(3, np.int64),
    )


@bare
def clear(queue, position):  # type: ignore[no-untyped-def]
    """Remove all breaks; the slider is at `position`, and the bucket before its own is open."""
    queue.many[:] = 0
    for i in range(queue.chunks.shape[0]):
        queue.chunks[i, CHUNK] = i + 1
    queue.at[0], queue.at[1], queue.at[2] = 0, (position >> queue.shift) - 1, 0


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
    elif k < queue.many.size:
        k, place = unsigned(k), unsigned(queue.many[unsigned(k)]) % unsigned(CHUNK)
        if place == unsigned(0):
            chunk = unsigned(queue.at[2])
            queue.at[2] = queue.chunks[chunk, CHUNK]
            queue.chunks[chunk, CHUNK], queue.last[k] = queue.last[k], chunk
        queue.chunks[unsigned(queue.last[k]), place] = key
        queue.many[k] += 1


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
    if k == queue.many.size:
        return False
    chunk = unsigned(queue.last[k])
    for i in range(queue.many[k] - 1, -1, -1):
        place = unsigned(i) % unsigned(CHUNK)
        _open(queue, queue.chunks[chunk, place])
        if place == unsigned(0):
            before = queue.chunks[chunk, CHUNK]
            queue.chunks[chunk, CHUNK], queue.at[2] = queue.at[2], chunk
            chunk = before
    queue.many[k], queue.at[1] = 0, k
    return True
