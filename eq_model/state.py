"""What some contacts of an ensemble did: kept after each block, written down, and gone on from."""

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
    """The rows of all tables in one, which without any has no columns."""
    return np.concatenate([table for table in tables if table.size] or [NO_ROWS])


@dataclass(frozen=True)
class State:
    """What the contacts of some blocks did, so that states may be joined in any order.

    sums : shape (2, m), whole numbers; counts : of the histograms; rows, slips : of coupled replicas,
    a row for each; contacts, breaks, steps : their numbers; done : the blocks; run_time : s;
    course : a number that tells drives apart, 0 of a block, which does not say.
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
        """Of both; the run time is the longer one."""
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
        """The rest alone."""
        rest = {name: getattr(self, name) for name in (*NUMBERS, "done", "run_time")}
        return State(**rest)

    def arrays(self) -> dict[str, Any]:
        """All of it, for a file."""
        done = np.array([(part.start, part.stop) for part in self.done], np.int64)
        told = {name: np.asarray(value) for name, value in vars(self).items() if name != "done"}
        return told | {"done": done.reshape(-1, 2)}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> State:
        """The state that has these arrays; KeyError, TypeError or ValueError where there is none."""
        found = {name: arrays[name] for name in vars(cls())}
        values: dict[str, Any] = {
            name: one if one.ndim else one.item() for name, one in found.items()
        }
        values["done"] = [range(start, stop) for start, stop in arrays["done"].tolist()]
        return cls(**values)
