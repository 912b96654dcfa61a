"""Breaks that wait, in the order of the slider's positions at which they come: a calendar of buckets.

A waiting break is one 64-bit key, its place in its bucket above its threshold: 8 bytes a contact,
which needs no other name, as contacts of one threshold that break at one place are alike. A bucket
is sorted by place when the slider comes to it, in the order of arrival where places are equal.
Positions and thresholds are whole numbers of a unit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined

THRESHOLD_BITS = 41  # of a key; the other 23 are its place in the bucket
CHUNK = 128  # keys that are kept together
PER_BUCKET = 16384  # breaks: what a core's L2 cache holds
FEW = 64  # keys that are moved, on average, to put one more among those of a bucket
DIGIT = 8  # bits by which breaks are sorted at a time
WIDEST = 5  # buckets of at most 2^-5 mean thresholds: few breaks come in the bucket of their birth

_U = np.uint64
_THRESHOLD, _DIGIT = _U((1 << THRESHOLD_BITS) - 1), _U((1 << DIGIT) - 1)


class Queue(NamedTuple):
    """Buckets as chains of chunks of keys."""

    shift: np.int64  # bits of a bucket's width
    many: npt.NDArray[np.int32]  # breaks of each bucket
    last: npt.NDArray[np.int32]  # its chunk that fills
    before: npt.NDArray[np.int32]  # the chunk before a chunk
    free: npt.NDArray[np.int32]  # free[0] chunks are free, and lie behind it
    keys: npt.NDArray[np.uint64]  # (chunks, CHUNK)
    open: npt.NDArray[np.uint64]  # sorted keys of the bucket in which the slider is
    spare: npt.NDArray[np.uint64]  # to sort them
    digits: npt.NDArray[np.int64]  # how many there are of each
    at: npt.NDArray[np.int64]  # next of the open keys, their end, and the bucket's number


def bucket_bits(n: int, mean: float, share_below: Callable[[float], float]) -> int:
    """Bits of a bucket's width for n contacts of `mean` threshold (units).

    share_below : share of the thresholds below so many means; breaks that come in the bucket of
        their birth are put in their place one by one.
    """
    width = min(PER_BUCKET / n, 2.0**-WIDEST)
    while width * n * min(share_below(width), 1.0) > FEW and width * n > FEW:
        width *= 0.5
    return min(max(int(np.floor(np.log2(mean * width))), 1), 64 - THRESHOLD_BITS)


def make_queue(n: int, shift: int, buckets: int) -> Queue:
    """A queue for n contacts, of so many buckets, to be cleared first; memory is used as it fills."""
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
    """Forget all breaks; the slider is at `position`, and the bucket before its own is open."""
    queue.many[:] = 0
    queue.free[0] = queue.free.size - 1
    for i in range(1, queue.free.size):
        queue.free[i] = queue.free.size - 1 - i
    queue.at[0], queue.at[1], queue.at[2] = 0, 0, (position >> queue.shift) - 1


@inlined
def next_break(queue):  # type: ignore[no-untyped-def]
    """Whether there is a break in the open bucket, and where; else where the bucket ends."""
    low = queue.at[2] << queue.shift
    if queue.at[0] < queue.at[1]:
        return True, low + np.int64(queue.open[_U(queue.at[0])] >> _U(THRESHOLD_BITS))
    return False, low + (np.int64(1) << queue.shift)


@inlined
def take_next(queue):  # type: ignore[no-untyped-def]
    """Remove the next break of the open bucket: its threshold."""
    queue.at[0] += 1
    return np.int64(queue.open[_U(queue.at[0] - 1)] & _THRESHOLD)


@inlined
def wait(queue, b, x):  # type: ignore[no-untyped-def]
    """A break at b, of threshold x, waits; b lies in the open bucket or beyond.

    One beyond all buckets lies beyond the drive's end and never comes.
    """
    k = b >> queue.shift
    key = (_U(b & ((np.int64(1) << queue.shift) - np.int64(1))) << _U(THRESHOLD_BITS)) | _U(x)
    if k <= queue.at[2]:
        _insert(queue, key)
    elif k < queue.many.size:
        slot = _U(queue.many[_U(k)]) & _U(CHUNK - 1)
        if slot == _U(0):
            chunk = queue.free[queue.free[0]]
            queue.free[0] -= 1
            queue.before[chunk] = queue.last[_U(k)]
            queue.last[_U(k)] = chunk
        queue.keys[_U(queue.last[_U(k)]), slot] = key
        queue.many[_U(k)] += 1


@bare
def _insert(queue, key):  # type: ignore[no-untyped-def]
    """Put a break in its place among those of the open bucket."""
    if queue.at[1] == queue.open.size:  # room is left by those that broke
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
    """Empty the open bucket's chunks; how many breaks there were, and how many of each digit."""
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
                queue.digits[d, (key >> _U(THRESHOLD_BITS + d * DIGIT)) & _DIGIT] += 1
        m += fill
        fill = np.int64(CHUNK)
        queue.free[0] += 1
        queue.free[queue.free[0]] = chunk
        chunk = np.int64(queue.before[chunk])
    queue.many[k] = 0
    return n


@bare
def open_next(queue):  # type: ignore[no-untyped-def]
    """Open the next bucket: its breaks in order of place, of arrival at the same one; whether there is one."""
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
            digit = (old[i] >> _U(THRESHOLD_BITS + d * DIGIT)) & _DIGIT
            new[_U(places[digit])] = old[i]
            places[digit] += 1
        old, new = new, old
    queue.at[0], queue.at[1] = 0, n
    return True
