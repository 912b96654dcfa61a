"""Blocks of contacts of fixed sizes, and their distribution over ranks.

The blocks of all replicas are numbered in one sequence. Their sizes follow from the number of contacts
and an estimate of the work, never from measured times, so that the same blocks with the same streams
are run on any number of ranks and threads, and after a restart.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, islice, pairwise
from typing import Any

BLOCK = 1 << 14  # most contacts of a block: also short runs have blocks for several threads


@dataclass(frozen=True)
class Blocks:
    """The division into blocks: n_replicas, each of n_contacts in `per_replica` blocks."""

    n_contacts: int
    n_replicas: int
    per_replica: int

    def size(self, block: int) -> int:
        """Number of contacts of a block; within a replica they differ by one at most."""
        return self.before(block + 1) - self.before(block)

    def before(self, block: int) -> int:
        """Contacts of all blocks before this one."""
        replica, inside = divmod(block, self.per_replica)
        least, larger = divmod(self.n_contacts, self.per_replica)
        return replica * self.n_contacts + inside * least + min(inside, larger)

    def contacts(self, done: list[range]) -> int:
        """Contacts of these blocks."""
        return sum(self.before(part.stop) - self.before(part.start) for part in done)

    def measured(self, done: list[range]) -> int:
        """Contacts in those of these blocks that are measured for the variance."""
        return sum(self.size(block) for part in done for block in part if is_measured(block))

    def rounds(self, several: bool) -> list[range]:
        """Rounds of blocks, each as many as all before it; a single round of all unless `several`."""
        ends = [self.per_replica * self.n_replicas]
        while several and ends[0] > 1:
            ends.insert(0, (ends[0] + 1) // 2)
        return [range(begin, end) for begin, end in pairwise([0, *ends])]


def make_blocks(n_contacts: int, n_replicas: int, seconds: float = 0.0) -> Blocks:
    """Blocks for contacts that take about `seconds` each: of at most 0.25 s, after which a run can be stopped."""
    most = int(min(max(0.25 / max(seconds, 1e-12), 1.0), BLOCK))
    return Blocks(n_contacts, n_replicas, -(-n_contacts // most))


def is_measured(block: int) -> bool:
    """Whether a block's contacts are measured for the variance: the first 4, and every eighth."""
    return block < 4 or block % 8 == 0


def remaining(blocks: range, done: list[range]) -> list[range]:
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


def share(blocks: list[range], rank: int, ranks: int) -> list[int]:
    """The blocks of one rank: shares follow one another and differ by at most one block."""
    total = sum(map(len, blocks))
    begin, end = (-(-total * one // ranks) for one in (rank, rank + 1))
    return list(islice(chain(*blocks), begin, end))


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
            time.sleep(0.001)
            yield
