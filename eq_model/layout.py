"""Who does which contacts: contacts of all replicas in one row, a share for each rank, blocks in each share."""

import time as clock
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from eq_model.lattice import BLOCK

_BLOCK_BREAKS = 1 << 24  # a block takes about a twentieth of a second
# the variance of so many contacts is known to a part in 700: of what comes after, a part of each row will do
_ALL_MEASURED = 4 * BLOCK
_ROW = 8 * BLOCK
_FIRST_ROUND = 1 << 14
_NAP = 0.001  # seconds


def rounds(total: int, several: bool) -> list[range]:
    """Contacts one round after the other, each as long as all before it; one for all unless `several`.

    After each it may be seen whether more are needed, and no number of ranks shows in that.
    """
    ends = [total]
    while several and ends[0] > _FIRST_ROUND:
        ends.insert(0, (ends[0] + 1) // 2)
    return [range(begin, end) for begin, end in pairwise([0, *ends])]


def left(contacts: range, done: list[range]) -> list[range]:
    """The part of `contacts` that is not done, in order."""
    out, begin = [], contacts.start
    for part in sorted(done, key=lambda part: part.start):
        if part.stop > begin and part.start < contacts.stop:
            out.append(range(begin, part.start))
            begin = part.stop
    out.append(range(begin, contacts.stop))
    return [part for part in out if len(part)]


def joined(done: list[range], block: range) -> list[range]:
    """`done` and one block more; those that follow each other are one."""
    if done and done[-1].stop == block.start:
        return [*done[:-1], range(done[-1].start, block.stop)]
    return [*done, block]


def share(contacts: list[range], rank: int, size: int) -> list[range]:
    """The contacts of one rank: shares follow one another and differ by at most one contact."""
    total = sum(map(len, contacts))
    skip, take = total * rank // size, total * (rank + 1) // size - total * rank // size
    out = []
    for part in contacts:
        mine = part[skip : skip + take]
        skip, take = max(skip - len(part), 0), take - len(mine)
        if len(mine):
            out.append(mine)
    return out


def block_size(breaks_each: float) -> int:
    """Contacts of a block, of which so many breaks of the plainest sort are expected each."""
    return int(min(max(_BLOCK_BREAKS / max(breaks_each, 1.0), 1.0), BLOCK))


def cut(contacts: range, size: int) -> tuple[range, range]:
    """A block of `size` contacts or less, and the rest.

    None reaches across a multiple of 2^16 contacts, so that all of a block is measured or none.
    """
    first = contacts.start
    last = min(first + size, contacts.stop, (first // BLOCK + 1) * BLOCK)
    return range(first, last), range(last, contacts.stop)


def is_measured(contact: int) -> bool:
    """Whether a contact counts for the variance: the first 2^18 do, and then every eighth 2^16 in turn."""
    return contact < _ALL_MEASURED or contact % _ROW < BLOCK


def measured(done: list[range]) -> int:
    """How many of these contacts are measured."""
    return sum(_measured_before(part.stop) - _measured_before(part.start) for part in done)


def _measured_before(contact: int) -> int:
    rows, rest = divmod(contact, _ROW)
    return min(contact, _ALL_MEASURED) + max(rows - 1, 0) * BLOCK + (min(rest, BLOCK) if rows else 0)


def rank_and_size(comm: Any) -> tuple[int, int]:
    """Rank and size of a communicator; None is a lone process."""
    return (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())


def in_turn(comm: Any, work: Any) -> None:
    """Call `work` on rank 0 first, then on the others together: they find on disk what rank 0 compiled."""
    rank = rank_and_size(comm)[0]
    if rank == 0:
        work()
    for _ in meeting(comm):
        pass
    if rank > 0:
        work()


def meeting(comm: Any) -> Iterator[None]:
    """Wait for all ranks, which must call; an item a millisecond, to do something else meanwhile.

    MPI's own waits keep a core busy, and hear no signal.
    """
    if rank_and_size(comm)[1] > 1:
        request = comm.Ibarrier()
        while not request.Test():
            clock.sleep(_NAP)
            yield
