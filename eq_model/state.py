"""The state of an ensemble: results of its finished blocks, which can be saved and continued."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model import layout
from origins.errors import InputError

Whole = npt.NDArray[np.int64]
Array = npt.NDArray[np.float64]

NO_ROWS = np.empty((0, 0))
TABLES, NUMBERS = ("rows", "slips"), ("contacts", "breaks", "steps")  # of a State


def stacked(tables: list[Array]) -> Array:
    """The rows of all tables in one table, which has no columns if there are no rows."""
    return np.concatenate([table for table in tables if table.size] or [NO_ROWS])


@dataclass(frozen=True)
class State:
    """Results of the contacts of some blocks; states may be joined in any order.

    sums : shape (2, m), whole numbers; counts : of the histograms; rows, slips : a row for each coupled
    replica, and for each slip; contacts, breaks, steps : their numbers; done : the blocks; run_time : s;
    course : a checksum that identifies the drive, 0 for a single block.
    """

    sums: Whole = field(default_factory=lambda: np.zeros((2, 0), np.int64))
    counts: npt.NDArray[Any] = field(default_factory=lambda: np.zeros((0, 2, 0), np.uint32))
    rows: Array = field(default_factory=lambda: NO_ROWS)
    slips: Array = field(default_factory=lambda: NO_ROWS)
    contacts: int = 0
    breaks: int = 0
    steps: int = 0
    done: list[range] = field(default_factory=list)
    run_time: float = 0.0
    course: int = 0

    def joined(self, other: State) -> State:
        """The state of both together; the run time is the longer one."""
        courses = {self.course, other.course} - {0}
        shapes = [(one.sums.shape, one.counts.shape) for one in (self, other)]
        if len(courses) > 1 or shapes[0] != shapes[1]:
            rule = "was found on another path, or for other contacts; start anew"
            raise InputError(f"earlier: {rule}")
        told: dict[str, Any] = {"course": max(courses, default=0)}
        for name in ("sums", "counts", *NUMBERS):
            told[name] = getattr(self, name) + getattr(other, name)
        for name in TABLES:
            told[name] = stacked([getattr(self, name), getattr(other, name)])
        longest = max(self.run_time, other.run_time)
        return State(**told, done=layout.joined(self.done + other.done), run_time=longest)

    def without_sums(self) -> State:
        """This state with the numbers, blocks and run time only."""
        rest = {name: getattr(self, name) for name in (*NUMBERS, "done", "run_time")}
        return State(**rest)

    def arrays(self) -> dict[str, Any]:
        """All fields as arrays, for a file."""
        done = np.array([(part.start, part.stop) for part in self.done], np.int64)
        told = {name: np.asarray(value) for name, value in vars(self).items() if name != "done"}
        return told | {"done": done.reshape(-1, 2)}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> State:
        """The state with these arrays; raises KeyError, TypeError or ValueError if they do not make one."""
        found = {name: arrays[name] for name in vars(cls())}
        values: dict[str, Any] = {
            name: one if one.ndim else one.item() for name, one in found.items()
        }
        values["done"] = [range(start, stop) for start, stop in arrays["done"].tolist()]
        return cls(**values)
