"""Future breaks in the order of the slider's positions at which they happen: a calendar of buckets in a ring.

A future break is one 64-bit key: the high bits are its place in its bucket, the low bits its
threshold. This identifies a contact well enough, as contacts of one threshold that break at one
place are alike. A bucket is sorted by place when the slider reaches it, in the order of arrival
where places are equal. Positions and thresholds are whole multiples of a unit.

All breaks lie ahead of the slider, most of them within a few mean thresholds. So buckets stand in a ring, and one that
the slider has left is used again for positions one turn of the ring ahead: their number does not depend on the
path. Breaks beyond the ring, of the few very large thresholds, wait in a list, which is looked through every half turn.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined, unsigned

THRESHOLD_BITS = 41  # of a key; the other 23 are its place in the bucket
CHUNK = 128  # keys in one piece of memory
BUCKET_SIZE = 16384  # keys of a bucket, on average, which fit a core's L2 cache
# In mean thresholds; few contacts break in the bucket of their birth.
WIDEST_BUCKET = 2.0**-5
MOST_MOVED = 64  # keys of the open bucket that are moved to insert one: 0.5 KB, some 20 ns
# In Queue.at: the next open key and their end; the number of the open bucket; how many breaks wait in the ring, and
# beyond it; the bucket of the nearest of these; the bucket at which the list of these is looked through next; and the
# farthest bucket of the ring that has been filled.
NEXT, END, BUCKET, WAITING, BEYOND, NEAREST, LOOK, FARTHEST = range(8)
NOTHING, BUCKET_END, BREAK = range(3)  # what the slider meets next; see `next_event`


class Queue(NamedTuple):
    """Buckets as chains of chunks of keys. Bucket k begins at the position k << shift; its slot is k & (slots - 1)."""

    shift: np.int64  # bits of a bucket's width
    many: npt.NDArray[np.int32]  # number of breaks of each slot
    last: npt.NDArray[np.int32]  # the chunk of each slot that is being filled
    before: npt.NDArray[np.int32]  # the chunk before each chunk in its chain
    free: npt.NDArray[np.int32]  # free[0] is the number of free chunks, which follow it
    keys: npt.NDArray[np.uint64]  # (chunks, CHUNK)
    open: npt.NDArray[np.uint64]  # sorted keys of the open bucket, that of the slider
    spare: npt.NDArray[np.uint64]  # scratch memory to sort them
    counts: npt.NDArray[np.int64]  # of the 256 values of a digit, to sort them
    far: npt.NDArray[np.int64]  # positions of the breaks beyond the ring
    far_threshold: npt.NDArray[np.int64]
    at: npt.NDArray[np.int64]  # (8,), see NEXT


def bucket_bits(
    n: int, mean: float, fraction_below: Callable[[float], float], returns: bool = False
) -> int:
    """Bits of a bucket's width for n contacts of `mean` threshold (units).

    fraction_below : fraction of the thresholds below a number of means; contacts that break in the bucket of
        their birth are inserted one by one, which is slow.
    returns : whether all contacts are put back into the bucket where they are taken, before they break
    """
    width = min((MOST_MOVED if returns else BUCKET_SIZE) / n, WIDEST_BUCKET)
    while width * n * min(fraction_below(width), 1.0) > MOST_MOVED:
        width *= 0.5
    return min(max(int(np.floor(np.log2(mean * width))), 1), 64 - THRESHOLD_BITS)


def ring_bits(n: int, shift: int, mean: float, span: float) -> int:
    """Bits of the number of buckets of width 2^shift for n contacts of `mean` threshold (units).

    span : (units) most contacts break within it from their birth.
    """
    # With four means a contact that waits in the list is looked at less often than contacts break; more buckets than
    # contacts would take more memory than these.
    width = max(min(span, n * 2.0**shift), 4.0 * mean)
    return max(int(np.ceil(np.log2(width))) + 1 - shift, 6)


def make_queue(n: int, shift: int, bits: int) -> Queue:
    """A queue for n contacts, with 2^bits buckets; clear it first. Memory is used as it fills."""
    slots = 1 << bits
    chunks = n // CHUNK + min(slots, n) + 1
    return Queue(
        shift=np.int64(shift),
        many=np.zeros(slots, np.int32),
        last=np.zeros(slots, np.int32),
        before=np.empty(chunks, np.int32),
        free=np.empty(chunks + 1, np.int32),
        keys=np.empty((chunks, CHUNK), np.uint64),
        open=np.empty(n + 1, np.uint64),
        spare=np.empty(n + 1, np.uint64),
        counts=np.empty(256, np.int64),
        far=np.empty(n, np.int64),
        far_threshold=np.empty(n, np.int64),
        at=np.zeros(8, np.int64),
    )


@bare
def clear(queue, position):  # type: ignore[no-untyped-def]
    """Remove all breaks; the slider is at `position`, and the bucket before its own is open."""
    queue.many[:] = 0
    queue.free[0] = queue.free.size - 1
    for i in range(1, queue.free.size):
        queue.free[i] = queue.free.size - 1 - i
    queue.at[:] = 0
    queue.at[BUCKET] = (position >> queue.shift) - 1
    queue.at[LOOK] = queue.at[BUCKET] + queue.many.size // 2
    queue.at[FARTHEST] = queue.at[BUCKET]


@inlined
def next_event(queue):  # type: ignore[no-untyped-def]
    """What the slider meets next as it moves on, and where: a break, the end of buckets in which no more wait, or,
    where no contact holds, nothing."""
    low, width = queue.at[BUCKET] << queue.shift, np.int64(1) << queue.shift
    if queue.at[NEXT] < queue.at[END]:
        key = queue.open[unsigned(queue.at[NEXT])]
        return BREAK, low + np.int64(key >> unsigned(THRESHOLD_BITS))
    if queue.at[WAITING] > 0:
        return BUCKET_END, low + width
    if queue.at[BEYOND] > 0:
        return BUCKET_END, queue.at[NEAREST] << queue.shift
    return NOTHING, low + width


@inlined
def take_next(queue):  # type: ignore[no-untyped-def]
    """Remove the next break of the open bucket and return its threshold."""
    queue.at[NEXT] += 1
    return np.int64(queue.open[unsigned(queue.at[NEXT] - 1)] & unsigned((1 << THRESHOLD_BITS) - 1))


@inlined
def add_break(queue, b, x):  # type: ignore[no-untyped-def]
    """Add a break at position b, of threshold x; b lies in the open bucket or beyond."""
    ahead = (b >> queue.shift) - queue.at[BUCKET]
    if ahead <= 0:
        _insert(queue, _key(queue, b, x))
    elif ahead <= queue.many.size:  # the open bucket's slot is free again
        _wait_in_ring(queue, b, x)
    else:
        _wait_beyond(queue, b, x)


@inlined
def _key(queue, b, x):  # type: ignore[no-untyped-def]
    place = unsigned(b & ((np.int64(1) << queue.shift) - np.int64(1)))
    return (place << unsigned(THRESHOLD_BITS)) | unsigned(x)


@inlined
def _wait_in_ring(queue, b, x):  # type: ignore[no-untyped-def]
    """Append a break to the chain of its bucket."""
    _append(queue, b >> queue.shift, _key(queue, b, x))


@inlined
def _append(queue, k, key):  # type: ignore[no-untyped-def]
    slot = unsigned(k & np.int64(queue.many.size - 1))
    place = unsigned(queue.many[slot]) & unsigned(CHUNK - 1)
    if place == unsigned(0):
        chunk = queue.free[queue.free[0]]
        queue.free[0] -= 1
        queue.before[chunk] = queue.last[slot]
        queue.last[slot] = chunk
    queue.keys[unsigned(queue.last[slot]), place] = key
    queue.many[slot] += 1
    queue.at[WAITING] += 1
    queue.at[FARTHEST] = max(queue.at[FARTHEST], k)


@bare
def _wait_beyond(queue, b, x):  # type: ignore[no-untyped-def]
    """Append a break to the list of those beyond the ring."""
    k, many = b >> queue.shift, queue.at[BEYOND]
    queue.far[many], queue.far_threshold[many] = b, x
    queue.at[NEAREST] = k if many == 0 else min(k, queue.at[NEAREST])
    queue.at[BEYOND] = many + 1


@bare
def _look_beyond(queue, k):  # type: ignore[no-untyped-def]
    """Move breaks of the list that lie within the ring from bucket k on to their buckets."""
    many = queue.at[BEYOND]
    queue.at[BEYOND], queue.at[LOOK] = 0, k + queue.many.size // 2
    for i in range(many):
        b, x = queue.far[i], queue.far_threshold[i]
        if (b >> queue.shift) - k < queue.many.size:
            _wait_in_ring(queue, b, x)
        else:
            _wait_beyond(queue, b, x)


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


@inlined
def settle(queue, position):  # type: ignore[no-untyped-def]
    """The slider stops at `position`: if it has passed buckets in which no break waits, that before its own is open."""
    queue.at[BUCKET] = max(queue.at[BUCKET], (position >> queue.shift) - 1)


@bare
def go_back_to(queue, position):  # type: ignore[no-untyped-def]
    """Whether the bucket before that of a position behind the slider can be open, with no break in between; it is."""
    bucket = (position >> queue.shift) - 1
    if queue.at[FARTHEST] > bucket + queue.many.size:
        return False
    while queue.at[NEXT] < queue.at[END]:
        _append(queue, queue.at[BUCKET], queue.open[queue.at[NEXT]])
        queue.at[NEXT] += 1
    queue.at[BUCKET] = bucket
    return True


@bare
def open_bucket(queue, position):  # type: ignore[no-untyped-def]
    """Open the bucket that begins at `position`, as `next_event` gives it, and sort its breaks by place, then by
    arrival."""
    k = position >> queue.shift
    if k >= queue.at[LOOK]:
        _look_beyond(queue, k)
    slot = unsigned(k & np.int64(queue.many.size - 1))
    n, m, chunk = np.int64(queue.many[slot]), np.int64(0), np.int64(queue.last[slot])
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
    queue.many[slot], queue.at[WAITING] = 0, queue.at[WAITING] - n
    queue.at[NEXT], queue.at[END], queue.at[BUCKET] = 0, n, k
