"""Who does which contacts: contacts of all replicas in one row, a share for each rank, blocks in each share."""

import time
from collections.abc import Iterator
from typing import Any

from eq_model.lattice import BLOCK

_BLOCK_BREAKS = 1 << 24  # a block takes about a twentieth of a second
# the variance of so many contacts is known to a part in 700: of what comes after, a part of each row will do
_ALL_MEASURED = 4 * BLOCK
_ROW = 8 * BLOCK


def share(total: int, rank: int, size: int) -> range:
    """The contacts of one rank: shares follow one another and differ by at most one contact."""
    return range(total * rank // size, total * (rank + 1) // size)


def blocks(contacts: range, breaks_each: float) -> Iterator[range]:
    """`contacts` cut into blocks of about 2^24 breaks, `breaks_each` expected of each contact.

    None reaches across a multiple of 2^16 contacts, so that all of a block is measured or none.
    """
    size = int(min(max(_BLOCK_BREAKS / max(breaks_each, 1.0), 1.0), BLOCK))
    first = contacts.start
    while first < contacts.stop:
        last = min(first + size, contacts.stop, (first // BLOCK + 1) * BLOCK)
        yield range(first, last)
        first = last


def is_measured(contact: int) -> bool:
    """Whether a contact counts for the variance: the first 2^18 do, and then every eighth 2^16 in turn."""
    return contact < _ALL_MEASURED or contact % _ROW < BLOCK


def measured(total: int) -> int:
    """How many of `total` contacts are measured."""
    rows, rest = divmod(total, _ROW)
    return min(total, _ALL_MEASURED) + max(rows - 1, 0) * BLOCK + (min(rest, BLOCK) if rows else 0)


def rank_and_size(comm: Any) -> tuple[int, int]:
    """Rank and size of a communicator; None is a lone process."""
    return (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())


def in_turn(comm: Any, work: Any) -> None:
    """Call `work` on rank 0 first, then on the others together: they find on disk what rank 0 compiled."""
    rank, size = rank_and_size(comm)
    if rank == 0:
        work()
    if size > 1:
        compiled = comm.Ibarrier()
        # MPI's own waits keep a core busy, which rank 0 may need
        while not compiled.Test():
            time.sleep(0.001)
    if rank > 0:
        work()
