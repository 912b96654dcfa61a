"""Random numbers by counter: Philox4x32-10 (Salmon, Moraes, Dror and Shaw, SC11, 2011; Random123).

A number depends only on the seed and on which one it is, not on the rank or the order in which it is drawn: ranks,
blocks and batches may be cut in any way.
"""

import numpy as np
import numpy.typing as npt

from origins.errors import refuse, whole

_MASK, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
_DOMAINS = np.uint64(4 << 28)  # second word of the counter


def key_of(seed: object) -> tuple[int, int]:
    """The two key words of a seed; InputError unless it is a whole number of at least 0 and below 2^64."""
    number = whole("seed", seed, 0)
    if number >= 1 << 64:
        refuse("seed", seed, "must be below 2^64")
    return number & 0xFFFFFFFF, number >> 32


def words(key: tuple[int, int], sample: npt.ArrayLike, block: int) -> npt.NDArray[np.uint64]:
    """Four random numbers of 32 bits for each whole number `sample`, shape (4, ...); another `block` gives others."""
    c2 = np.asarray(sample, dtype=np.uint64)
    c0, c1, c2, c3 = np.full_like(c2, block), np.full_like(c2, _DOMAINS), c2 & _MASK, c2 >> _HALF
    k0, k1 = (np.uint64(word) for word in key)
    for _ in range(10):
        first, second = np.uint64(0xD2511F53) * c0, np.uint64(0xCD9E8D57) * c2
        c0, c1 = (second >> _HALF) ^ c1 ^ k0, second & _MASK
        c2, c3 = (first >> _HALF) ^ c3 ^ k1, first & _MASK
        k0, k1 = (k0 + np.uint64(0x9E3779B9)) & _MASK, (k1 + np.uint64(0xBB67AE85)) & _MASK
    return np.stack([c0, c1, c2, c3])
