"""The state of an ensemble: results of its finished blocks, which can be saved and continued."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model import layout
from origins.errors import InputError

Whole = npt.NDArray[np.int64]
Array = npt.NDArray[np.float64]

_NO_ROWS = np.zeros((0, 0))  # a single one, which messages between ranks contain once


@dataclass(frozen=True)
class State:
    """Results of the contacts of some blocks; states may be joined in any order.

    sums : shape (2, m), whole numbers; counts : of the histograms; rows, slips : a row for each coupled
    replica, and for each slip; contacts, breaks, steps : their numbers; done : the blocks; run_time : s;
    course : a checksum that identifies the drive, 0 for a single block.
    """

    sums: Whole = field(default_factory=lambda: np.zeros((2, 0), np.int64))
    counts: npt.NDArray[Any] = field(default_factory=lambda: np.zeros((0, 2, 0), np.uint32))
    rows: Array = field(default_factory=lambda: _NO_ROWS)
    slips: Array = field(default_factory=lambda: _NO_ROWS)
    contacts: int = 0
    breaks: int = 0
    steps: int = 0
    done: list[range] = field(default_factory=list)
    run_time: float = 0.0
    course: int = 0

    def joined(self, other: State) -> State:
        """The state of both together; the run time is the longer one."""
        both = self, other
        courses = {one.course for one in both} - {0}
        if len(courses) > 1 or len({(one.sums.shape, one.counts.shape) for one in both}) > 1:
            rule = "was found on another path, or for other contacts; start anew"
            raise InputError(f"earlier: {rule}")
        found: dict[str, Any] = {
            name: getattr(self, name) + getattr(other, name)
            for name in ("sums", "counts", "contacts", "breaks", "steps", "done")
        }
        found["done"] = layout.joined(found["done"])
        for name in ("rows", "slips"):  # tables without rows have no columns
            tables = [table for one in both if (table := getattr(one, name)).size]
            found[name] = np.concatenate(tables) if tables else getattr(self, name)
        longest = max(one.run_time for one in both)
        return State(**found, run_time=longest, course=max(courses, default=0))

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
        found = {name: arrays[name] for name in vars(cls())}
        values: dict[str, Any] = {
            name: one if one.ndim else one.item() for name, one in found.items()
        }
        return cls(**values | {"done": [range(*ends) for ends in arrays["done"].tolist()]})
