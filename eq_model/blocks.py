"""Blocks of contacts of a fixed size, the results of finished ones, and their distribution over ranks.

Their size follows from the number of contacts and an estimate of the work, never from measured times, so
that the same blocks with the same streams are run on any number of ranks and threads, and after a restart.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from origins.errors import InputError
from origins.thresholds.law import Array

Whole = npt.NDArray[np.int64]

# most contacts of a block: enough that its beginning and end take little time, and few for its sums to fit 63 bits
BLOCK = 1 << 15
_NO_ROWS = np.zeros((0, 0))  # a single one, which messages between ranks contain once


class Blocks(NamedTuple):
    """`total` contacts, of all replicas, in blocks of `each`; the last block has what is left."""

    total: int
    each: int

    def before(self, block: int) -> int:
        """Contacts of all blocks before this one."""
        return min(max(block, 0) * self.each, self.total)

    def size(self, block: int) -> int:
        """Number of contacts of a block; 0 for block -1."""
        return self.before(block + 1) - self.before(block)

    def is_measured(self, block: int) -> bool:
        """Whether a block is measured for the variance: those of the first 2^15 contacts, and every eighth."""
        return self.before(block) < BLOCK or block % 8 == 0

    def measured(self, done: list[range]) -> int:
        """Contacts in those of these blocks that are measured for the variance."""
        return sum(self.size(block) for part in done for block in part if self.is_measured(block))

    def rounds(self, several: bool) -> list[range]:
        """Rounds of blocks, each as many as all before it; a single round of all unless `several`."""
        ends = [-(-self.total // self.each)]
        while several and ends[0] > 1:
            ends.insert(0, (ends[0] + 1) // 2)
        return [range(begin, end) for begin, end in pairwise([0, *ends])]


class DroppedError(Exception):
    """A block that was not followed to its end, as nobody waits for it any more."""


def check_dropped(dropped: Callable[[], bool] | None) -> None:
    """Raise DroppedError where a block is to be dropped; None: never."""
    if dropped is not None and dropped():
        raise DroppedError


def joined(done: list[range]) -> list[range]:
    """These ranges of blocks in order, adjacent ones merged."""
    out: list[range] = []
    for part in sorted(done, key=lambda part: part.start):
        if out and out[-1].stop == part.start:
            part = range(out.pop().start, part.stop)
        out.append(part)
    return out


def blocks_of_rank(blocks: range, done: list[range], rank: int, ranks: int) -> list[int]:
    """The blocks of one rank, of those that are not done: shares follow one another and differ by at most one block."""
    remaining = np.arange(blocks.start, blocks.stop)
    for part in done:
        remaining = remaining[(remaining < part.start) | (remaining >= part.stop)]
    begin, end = (-(-remaining.size * one // ranks) for one in (rank, rank + 1))
    return [int(block) for block in remaining[begin:end]]


@dataclass(frozen=True)
class State:
    """Results of the contacts of some blocks; states may be joined in any order.

    sums : whole numbers, see contact.count_event; counts : of the histograms; rows, slips : a row for each coupled
    replica, and for each slip; contacts, breaks : their numbers; done : the blocks; run_time : s;
    course : a checksum that identifies the drive, 0 for a single block.
    """

    sums: Whole = field(default_factory=lambda: np.zeros((2, 0), np.int64))
    counts: npt.NDArray[Any] = field(default_factory=lambda: np.zeros((0, 2, 0), np.uint32))
    rows: Array = field(default_factory=lambda: _NO_ROWS)
    slips: Array = field(default_factory=lambda: _NO_ROWS)
    contacts: int = 0
    breaks: int = 0
    done: list[range] = field(default_factory=list)
    run_time: float = 0.0
    course: int = 0

    def joined(self, other: State) -> State:
        """The state of both together; the run time is the longer one."""
        courses = {self.course, other.course} - {0}
        shapes = {(one.sums.shape, one.counts.shape) for one in (self, other)}
        if len(courses) > 1 or len(shapes) > 1:
            raise InputError("earlier: was found on another path or for other contacts; start anew")
        return State(
            sums=self.sums + other.sums,
            counts=self.counts + other.counts,
            rows=_stacked(self.rows, other.rows),
            slips=_stacked(self.slips, other.slips),
            contacts=self.contacts + other.contacts,
            breaks=self.breaks + other.breaks,
            done=joined(self.done + other.done),
            run_time=max(self.run_time, other.run_time),
            course=max(courses, default=0),
        )

    def without_sums(self) -> State:
        """This state without its arrays of sums and counts."""
        return replace(self, sums=State().sums, counts=State().counts)

    def arrays(self) -> dict[str, Any]:
        """All fields as arrays, for a file."""
        done = [(part.start, part.stop) for part in self.done]
        fields = {name: np.asarray(value) for name, value in vars(self).items() if name != "done"}
        return fields | {"done": np.array(done, np.int64).reshape(-1, 2)}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> State:
        """The state with these arrays; raises KeyError, TypeError or ValueError if they do not make one."""
        values: dict[str, Any] = {name: arrays[name] for name in vars(cls())}
        values |= {name: one.item() for name, one in values.items() if not one.ndim}
        return cls(**values | {"done": [range(*ends) for ends in arrays["done"].tolist()]})


def _stacked(*tables: Array) -> Array:
    """The rows of all tables; those without rows have no columns."""
    filled = [table for table in tables if table.size]
    return np.concatenate(filled) if filled else _NO_ROWS


def rank_and_size(comm: Any) -> tuple[int, int]:
    """Rank and size of a communicator; None is a lone process."""
    return (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())


def meeting(comm: Any) -> Iterator[None]:
    """Wait until all ranks have called this; yields every millisecond, so that the caller can do other work.

    MPI's own waits keep a core busy and block signals.
    """
    if rank_and_size(comm)[1] > 1:
        request = comm.Ibarrier()
        while not request.Test():
            time.sleep(0.001)
            yield
