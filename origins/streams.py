"""Random streams by counter: Philox4x32-10 (Salmon, Moraes, Dror and Shaw, SC11, 2011; Random123).

A number depends only on the seed and on its use, not on the rank or the order in which it is drawn: ranks, blocks
and batches may be cut in any way. The key is the seed; the counter is (draw block, purpose and replica, contact).
"""

import numpy as np
import numpy.typing as npt

from origins.errors import refuse, whole

Words = npt.NDArray[np.uint32]

MULTIPLIERS = (0xD2511F53, 0xCD9E8D57)
KEY_STEPS = (0x9E3779B9, 0xBB67AE85)
ROUNDS = 10

# purposes of streams: the top four bits of the counter's second word; the replica is in the lower bits
THRESHOLDS, START, THRESHOLD_TAILS, START_TAILS, DOMAINS, LIVES, LIFE_TAILS, LIFE_STEPS = range(8)
PURPOSE_SHIFT = 28

_MASK = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)


def philox(counter: npt.ArrayLike, key: tuple[int, int]) -> Words:
    """Four random 32-bit words for each counter; counter and result have shape (4, ...)."""
    c0, c1, c2, c3 = np.asarray(counter, dtype=np.uint64)
    k0, k1 = (np.uint64(word) for word in key)
    for _ in range(ROUNDS):
        first, second = np.uint64(MULTIPLIERS[0]) * c0, np.uint64(MULTIPLIERS[1]) * c2
        c0, c1, c2, c3 = (
            (second >> _HALF) ^ c1 ^ k0,
            second & _MASK,
            (first >> _HALF) ^ c3 ^ k1,
            first & _MASK,
        )
        k0, k1 = (k0 + np.uint64(KEY_STEPS[0])) & _MASK, (k1 + np.uint64(KEY_STEPS[1])) & _MASK
    return np.stack([c0, c1, c2, c3]).astype(np.uint32)


def key_of(seed: object) -> tuple[int, int]:
    """The two key words of a seed; InputError unless it is a whole number of at least 0 and below 2^64."""
    number = whole("seed", seed, 0)
    if number >= 1 << 64:
        refuse("seed", seed, "must be below 2^64")
    return number & 0xFFFFFFFF, number >> 32


def words(
    key: tuple[int, int],
    purpose: int,
    replica: npt.ArrayLike,
    contact: npt.ArrayLike,
    block: npt.ArrayLike,
) -> Words:
    """The four words of one draw block of one contact; replica, contact, block broadcast, result (4, ...)."""
    contact = np.asarray(contact, dtype=np.uint64)
    second = np.uint64(purpose << PURPOSE_SHIFT) | np.asarray(replica, dtype=np.uint64)
    parts = np.broadcast_arrays(
        np.asarray(block, dtype=np.uint64), second, contact & _MASK, contact >> _HALF
    )
    return philox(np.stack(parts), key)
