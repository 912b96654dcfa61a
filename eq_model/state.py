"""What some contacts of an ensemble did: kept after each block, written down, and gone on from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model import layout
from origins.errors import InputError

Whole = npt.NDArray[np.int64]


class Found(NamedTuple):
    """Of one block: what State holds of all."""

    sums: Whole
    counts: npt.NDArray[np.unsignedinteger[Any]]
    rows: npt.NDArray[np.float64]
    breaks: int
    steps: int


@dataclass(frozen=True)
class State:
    """What the contacts of some blocks did, so that states may be joined in any order.

    sums : shape (2, m), whole numbers; counts : of the histograms; rows : of coupled replicas, one
    after the other; contacts, breaks, steps : their numbers; done : the blocks; run_time : s.
    """

    sums: Whole
    counts: npt.NDArray[np.unsignedinteger[Any]]
    rows: npt.NDArray[np.float64]
    contacts: int
    breaks: int
    steps: int
    done: list[range]
    run_time: float

    def after(self, block: int, contacts: int, found: Found, seconds: float) -> State:
        """With one block more, of so many contacts, which took so long."""
        done = layout.joined(self.done, [range(block, block + 1)])
        one = State(*found[:3], contacts, *found[3:], done, self.run_time + seconds)
        return self._plus(one)

    def joined(self, other: State) -> State:
        """Of both."""
        if self.sums.shape != other.sums.shape or self.counts.shape != other.counts.shape:
            raise InputError(
                "earlier: was found on another path, or for other contacts; start anew"
            )
        longest = max(self.run_time, other.run_time)
        done = layout.joined(self.done, other.done)
        return self._plus(replace(other, done=done, run_time=longest))

    def _plus(self, other: State) -> State:
        """`other` with the numbers of this one added."""
        names = ("sums", "counts", "contacts", "breaks", "steps")
        added: dict[str, Any] = {name: getattr(self, name) + getattr(other, name) for name in names}
        return replace(other, rows=np.concatenate([self.rows, other.rows]), **added)

    def without_sums(self) -> State:
        """The rest alone."""
        nothing = np.zeros((0, 2, 0), np.uint32)
        return replace(self, sums=np.zeros((2, 0), np.int64), counts=nothing, rows=np.empty(0))

    def arrays(self) -> dict[str, Any]:
        """All of it, for a file."""
        done = np.array([(part.start, part.stop) for part in self.done], np.int64)
        rest = {name: value for name, value in vars(self).items() if name != "done"}
        return {name: np.asarray(value) for name, value in rest.items()} | {
            "done": done.reshape(-1, 2)
        }

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> State:
        """The state that has these arrays; KeyError, TypeError or ValueError where there is none."""
        values: dict[str, Any] = {
            name: array if array.ndim else array.item() for name, array in arrays.items()
        }
        values["done"] = [range(start, stop) for start, stop in arrays["done"].tolist()]
        return cls(**values)
