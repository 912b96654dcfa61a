"""What some contacts of an ensemble did: kept after each block, written down, and gone on from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.tally import Counts, Tally
from origins.errors import InputError


@dataclass(frozen=True)
class State:
    """What the contacts of some blocks did: whole numbers, so that states may be joined in any order.

    sums : shape (2, m), of the engine; counts : of the histograms; breaks, steps : of these contacts; done : the
    contacts; run_time : s.
    """

    sums: npt.NDArray[np.int64]
    counts: Tally
    breaks: int
    steps: int
    done: list[range]
    run_time: float

    def after(self, block: range, sums: npt.NDArray[np.int64], counts: Counts, breaks: int, steps: int) -> State:
        """With one block more; how long it took is for the caller to add."""
        done, added = layout.joined(self.done, block), self.counts.plus(counts)
        return State(self.sums + sums, added, self.breaks + breaks, self.steps + steps, done, self.run_time)

    def joined(self, other: State) -> State:
        """Of both."""
        if self.sums.shape != other.sums.shape:
            raise InputError("earlier: was found on another path, or for other contacts; start anew")
        run_time, steps = max(self.run_time, other.run_time), self.steps + other.steps
        sums, counts, breaks = self.sums + other.sums, self.counts.joined(other.counts), self.breaks + other.breaks
        return State(sums, counts, breaks, steps, self.done + other.done, run_time)

    @property
    def contacts(self) -> int:
        """How many."""
        return sum(map(len, self.done))

    def without_sums(self) -> State:
        """The rest alone."""
        sums, counts = np.zeros((2, 0), np.int64), Tally.zeros(0, 0)
        return State(sums, counts, self.breaks, self.steps, self.done, self.run_time)
