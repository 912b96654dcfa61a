"""Blocks of contacts of fixed sizes, and their distribution over ranks.

The blocks of all replicas are numbered in one sequence. Their sizes follow from the number of contacts
and an estimate of the work, never from measured times, so that the same blocks with the same streams
are run on any number of ranks and threads, and after a restart.
"""

import time as clock
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

BLOCK = 1 << 14  # most contacts of a block: their rows and sums stay in the cache
_LONGEST = 0.25  # s, longest estimated time of a block
_ALL_MEASURED, _EACH = 4, 8  # blocks measured for the variance: the first 4, then every eighth
_NAP = 0.001  # s between two looks at whether all ranks have arrived


@dataclass(frozen=True)
class Blocks:
    """The division into blocks: n_replicas, each of n_contacts in `each` blocks."""

    n_contacts: int
    n_replicas: int
    each: int

    @property
    def total(self) -> int:
        """Blocks of all replicas."""
        return self.each * self.n_replicas

    def size(self, block: int) -> int:
        """Number of contacts of a block; within a replica they differ by one at most."""
        whole, rest = divmod(self.n_contacts, self.each)
        return whole + (block % self.each < rest)

    def before(self, block: int) -> int:
        """Contacts of all blocks before this one."""
        replica, own = divmod(block, self.each)
        whole, rest = divmod(self.n_contacts, self.each)
        return replica * self.n_contacts + own * whole + min(own, rest)

    def contacts(self, done: list[range]) -> int:
        """Contacts of these blocks."""
        return sum(self.before(part.stop) - self.before(part.start) for part in done)

    def measured(self, done: list[range]) -> int:
        """Contacts in those of these blocks that are measured for the variance."""
        return sum(self.size(block) for part in done for block in part if is_measured(block))

    def rounds(self, several: bool) -> list[range]:
        """Rounds of blocks, each as many as all before it; a single round of all unless `several`."""
        ends = [self.total]
        while several and ends[0] > 1:
            ends.insert(0, (ends[0] + 1) // 2)
        return [range(begin, end) for begin, end in pairwise([0, *ends])]


def make_blocks(n_contacts: int, n_replicas: int, seconds: float = 0.0) -> Blocks:
    """Blocks for contacts that take about `seconds` each."""
    most = int(min(max(_LONGEST / max(seconds, 1e-12), 1.0), BLOCK))
    return Blocks(n_contacts, n_replicas, -(-n_contacts // most))


def is_measured(block: int) -> bool:
    """Whether a block's contacts are measured for the variance."""
    return block < _ALL_MEASURED or block % _EACH == 0


def left(blocks: range, done: list[range]) -> list[range]:
    """The part of `blocks` that is not done, in order."""
    inner = joined([part for part in done if part.stop > blocks.start and part.start < blocks.stop])
    begins = [blocks.start, *(part.stop for part in inner)]
    ends = [*(part.start for part in inner), blocks.stop]
    return [range(*both) for both in zip(begins, ends, strict=True) if both[0] < both[1]]


def joined(done: list[range]) -> list[range]:
    """These ranges of blocks in order, adjacent ones merged."""
    out: list[range] = []
    for part in sorted(done, key=lambda part: part.start):
        if out and out[-1].stop == part.start:
            part = range(out.pop().start, part.stop)
        out.append(part)
    return out


def share(blocks: list[range], rank: int, size: int) -> list[range]:
    """The blocks of one rank: shares follow one another and differ by at most one block."""
    total = sum(map(len, blocks))
    begin, end = (-(-total * one // size) for one in (rank, rank + 1))
    out = []
    for part in blocks:
        out.append(part[max(begin, 0) : max(end, 0)])
        begin, end = begin - len(part), end - len(part)
    return [part for part in out if len(part)]


def rank_and_size(comm: Any) -> tuple[int, int]:
    """Rank and size of a communicator; None is a lone process."""
    return (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())


def in_turn(comm: Any, work: Any) -> None:
    """Call `work` on rank 0 first, then on the others together: they find on disk what rank 0 compiled."""
    first = rank_and_size(comm)[0] == 0
    if first:
        work()
    list(meeting(comm))
    if not first:
        work()


def meeting(comm: Any) -> Iterator[None]:
    """Wait until all ranks have called this; yields every millisecond, so that the caller can do other work.

    MPI's own waits keep a core busy and block signals.
    """
    if rank_and_size(comm)[1] > 1:
        request = comm.Ibarrier()
        while not request.Test():
            clock.sleep(_NAP)
            yield
