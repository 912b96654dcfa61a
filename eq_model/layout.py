"""Who does which contacts: contacts of all replicas in one row, a share for each rank, blocks in each share."""

from collections.abc import Iterator
from typing import Any

from eq_model.lattice import BLOCK

_BLOCK_BREAKS = 1 << 24  # a block takes about a twentieth of a second


def share(total: int, rank: int, size: int) -> range:
    """The contacts of one rank: shares follow one another and differ by at most one contact."""
    return range(total * rank // size, total * (rank + 1) // size)


def blocks(contacts: range, breaks_each: float) -> Iterator[range]:
    """`contacts` cut into blocks of about 2^24 breaks and at most 2^16 contacts, `breaks_each` expected of each."""
    size = int(min(max(_BLOCK_BREAKS / max(breaks_each, 1.0), 1.0), BLOCK))
    for first in range(contacts.start, contacts.stop, size):
        yield range(first, min(first + size, contacts.stop))


def rank_and_size(comm: Any) -> tuple[int, int]:
    """Rank and size of a communicator; None is a lone process."""
    return (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())


def in_turn(comm: Any, work: Any) -> None:
    """Call `work` on rank 0 first, then on the others together: they find on disk what rank 0 compiled."""
    rank, size = rank_and_size(comm)
    if rank == 0:
        work()
    if size > 1:
        comm.Barrier()
    if rank > 0:
        work()
