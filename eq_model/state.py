"""What some contacts of an ensemble did: kept after each block, written down, and gone on from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.engine import Found
from eq_model.histogram import Counts, no_counts
from origins.errors import InputError


@dataclass(frozen=True)
class State:
    """What the contacts of some blocks did: whole numbers, so that states may be joined in any order.

    sums : shape (2, m), of the engine; counts : of the histograms; contacts, breaks, steps : their numbers; done : the
    blocks; run_time : s.
    """

    sums: npt.NDArray[np.int64]
    counts: Counts
    contacts: int
    breaks: int
    steps: int
    done: list[range]
    run_time: float

    def after(self, block: int, contacts: int, found: Found, seconds: float) -> State:
        """With one block more, of so many contacts, which took so long."""
        done = layout.joined(self.done, range(block, block + 1))
        return self._plus(State(*found[:2], contacts, *found[2:], done, self.run_time + seconds))

    def joined(self, other: State) -> State:
        """Of both."""
        if self.sums.shape != other.sums.shape or self.counts.shape != other.counts.shape:
            raise InputError(
                "earlier: was found on another path, or for other contacts; start anew"
            )
        longest = max(self.run_time, other.run_time)
        return self._plus(replace(other, done=self.done + other.done, run_time=longest))

    def _plus(self, other: State) -> State:
        """`other` with the numbers of this one added."""
        names = ("sums", "counts", "contacts", "breaks", "steps")
        return replace(
            other, **{name: getattr(self, name) + getattr(other, name) for name in names}
        )

    def without_sums(self) -> State:
        """The rest alone."""
        return replace(self, sums=np.zeros((2, 0), np.int64), counts=no_counts(0, 0))
