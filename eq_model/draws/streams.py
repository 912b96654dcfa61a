"""Random words by counter: one Philox stream for each block of contacts (Salmon et al., SC11, 2011).

A word depends only on the seed, the block, its purpose, the lane and the round, so that blocks may be
run by any rank or thread, and in any order. Seven rounds of Philox4x32 pass all of BigCrush
(same paper, Table 2).
"""

from typing import NamedTuple

import numpy as np

from eq_model.compiling import bare, inlined, unsigned
from origins.errors import check_seed

LANES = 256  # contacts that are followed side by side: their scratch rows stay in the L1 cache
ROW = LANES + 24  # a word for each lane; rows of one array then do not share a cache set

# Purposes of words, no word for two: contacts that form take thresholds, +16 stretches, +24 others in place of rejected
# ones, +32 the threshold beyond a stretch; +4 further bits of any of these, and of exposures, but not of STEPS. They
# have a numpy type, since numba would compile a function again for each Python number.
THRESHOLDS, STARTS, EXPOSURES, STEPS, WATCHED = np.array([0, 48, 96, 112, 128])


class Stream(NamedTuple):
    """The stream of one block: the two words of the seed, and the block's number; of uint64."""

    low: np.uint64
    high: np.uint64
    block: np.uint64


def make_stream(seed: object, block: int) -> Stream:
    """The stream of a block; InputError unless the seed is a whole number from 0 to 2^64 - 1."""
    number = check_seed(seed)
    return Stream(unsigned(number & 0xFFFFFFFF), unsigned(number >> 32), unsigned(block))


@inlined
def philox(c0, c1, c2, c3, k0, k1):  # type: ignore[no-untyped-def]
    """Philox4x32-7 of one counter and key, as four words; all of uint64."""
    mask, half = unsigned(0xFFFFFFFF), unsigned(32)
    for _ in range(7):
        p0, p1 = unsigned(0xD2511F53) * c0, unsigned(0xCD9E8D57) * c2
        c0, c1, c2, c3 = (p1 >> half) ^ c1 ^ k0, p1 & mask, (p0 >> half) ^ c3 ^ k1, p0 & mask
        k0, k1 = (k0 + unsigned(0x9E3779B9)) & mask, (k1 + unsigned(0xBB67AE85)) & mask
    return c0, c1, c2, c3


@inlined
def words_at(lane, turn, stream, purpose):  # type: ignore[no-untyped-def]
    """Four words of one lane in one round, `turn`, which may exceed 32 bits."""
    turn, half = unsigned(turn), unsigned(32)
    second, third = turn & unsigned(0xFFFFFFFF), unsigned(purpose) | (turn >> half << unsigned(8))
    return philox(unsigned(lane), second, stream.block, third, stream.low, stream.high)


@inlined
def uniform(high, low):  # type: ignore[no-untyped-def]
    """A number between 0 and 1, exclusive, from two words."""
    return (np.float64(((high << unsigned(32)) | low) >> unsigned(11)) + 0.5) * 2.0**-53


@bare
def draw(n, turn, stream, purpose, words):  # type: ignore[no-untyped-def]
    """The words of n lanes in one round: four rows of ROW."""
    for i in range(unsigned(n)):
        a, b, c, d = words_at(i, turn, stream, purpose)
        words[i] = np.uint32(a)
        words[i + unsigned(ROW)] = np.uint32(b)
        words[i + unsigned(2 * ROW)] = np.uint32(c)
        words[i + unsigned(3 * ROW)] = np.uint32(d)
