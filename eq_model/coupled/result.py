"""What replicas of coupled contacts did, and the state of those that are finished."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.coupled.replica import Followed
from origins.brief import brief

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]


@dataclass(frozen=True)
class CoupledSlips:
    """Slips of all replicas, replica by replica in the order in which they come; arrays of shape (m,).

    Attributes
    ----------
    replica, number : whole numbers, from 0: whose slip it is, and which of its slips
    drive : X_T (lengths)
    before, after : X at the beginning and at the end (lengths)
    force_before, force_after : F/(N_c <k>) (lengths)
    breaks : how many contacts broke; of a reset, until all were drawn anew
    """

    replica: Whole
    number: Whole
    drive: Array
    before: Array
    after: Array
    force_before: Array
    force_after: Array
    breaks: Whole

    __repr__ = brief

    @property
    def drop(self) -> Array:
        """How far the force falls (lengths), which is K times the slip."""
        return self.force_before - self.force_after

    def mean(self, name: str, number: int) -> tuple[float, float]:
        """Mean of a field or of `drop` over the replicas that have slip `number`, and its standard error."""
        values = np.asarray(getattr(self, name), float)[self.number == number]
        if values.size < 2:
            return float(values.mean()) if values.size else np.nan, np.inf
        return float(values.mean()), float(values.std(ddof=1) / np.sqrt(values.size))


@dataclass(frozen=True)
class CoupledResult:
    """Contacts on a soft slider as the drive moves.

    Attributes
    ----------
    path : array of shape (n,)
        Positions X_T of the drive (lengths).
    position, force : arrays of shape (n,)
        X and F/(N_c <k>), means over the replicas (lengths); at a slip, after it.
    position_standard_error, force_standard_error : arrays of shape (n,)
        Of these means, from the replicas (lengths); inf for one replica. Near a slip F is not normal:
        replicas have slipped or not. Compare `slips`, not the mean force across a drop.
    positions, forces : arrays of shape (replicas, n)
        Of each replica (lengths).
    holding, holding_standard_error : arrays of shape (n,)
        Fraction of the contacts that hold.
    slips : CoupledSlips
        Avalanches that broke at least `slip_fraction` of a replica's contacts.
    avalanches : array of shape (replicas, 40)
        How many smaller ones broke 1, 2 to 3, 4 to 7, 8 to 15, ... contacts.
    slip_fraction : float
    balance : float
        X_T = F(0)/K, where the drive stands at t = 0, mean over the replicas (a length).
    contacts, breaks : int
        Of all finished replicas.
    breaks_per_rank : list of int
    success : bool
        Whether all replicas are finished.
    message : str
    run_time, compile_time : float
        Seconds: of the slowest rank, without compilation; of compilation.
    step_error, histograms
        Of other ensembles: zeros, and nothing.
    """

    path: Array
    position: Array
    force: Array
    position_standard_error: Array
    force_standard_error: Array
    positions: Array
    forces: Array
    holding: Array
    holding_standard_error: Array
    slips: CoupledSlips
    avalanches: Whole
    slip_fraction: float
    balance: float
    contacts: int
    breaks: int
    breaks_per_rank: list[int]
    run_time: float
    compile_time: float
    success: bool
    message: str
    step_error: Array
    histograms: tuple[()] = ()

    __repr__ = brief


@dataclass
class CoupledState:
    """Replicas of `n` contacts that are finished: kept after each, written down, and gone on from.

    found : what they did, by their numbers; None where another rank has it. run_time : s.
    """

    n: int
    found: dict[int, Followed | None] = field(default_factory=dict)
    run_time: float = 0.0

    @property
    def here(self) -> dict[int, Followed]:
        """Those that this rank has."""
        return {replica: row for replica, row in self.found.items() if row is not None}

    @property
    def contacts(self) -> int:
        """How many, of all."""
        return self.n * len(self.found)

    @property
    def done(self) -> list[range]:
        """The numbers of all."""
        parts = (range(replica, replica + 1) for replica in sorted(self.found))
        return reduce(layout.joined, parts, [])

    def joined(self, other: CoupledState) -> CoupledState:
        """Of both."""
        found = {**self.found, **other.found, **self.here}
        return CoupledState(self.n, found, max(self.run_time, other.run_time))

    def without_sums(self) -> CoupledState:
        """The numbers alone."""
        return CoupledState(self.n, dict.fromkeys(self.found), self.run_time)

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """All that is here, for a file: a row of numbers for each replica, one after the other."""
        rows = [row.packed() for row in self.here.values()]
        return {
            "told": np.array([self.n, self.run_time]),
            "replicas": np.array(list(self.here), np.int64),
            "lengths": np.array([row.size for row in rows], np.int64),
            "slips": np.array([len(row.slips) for row in self.here.values()], np.int64),
            "rows": np.concatenate([np.empty(0), *rows]),
        }

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> CoupledState:
        """The state that has these arrays; KeyError or ValueError where there is none."""
        n, run_time = arrays["told"].tolist()
        rows = np.split(arrays["rows"], np.cumsum(arrays["lengths"])[:-1])
        found: dict[int, Followed | None] = {}
        for replica, row, slips in zip(
            arrays["replicas"].tolist(), rows, arrays["slips"].tolist(), strict=False
        ):
            found[replica] = Followed.unpacked(row, slips)
        return cls(int(n), found, run_time)


def result_of(rows: list[Followed], replicas: list[int], **others: Any) -> CoupledResult:
    """The result of these replicas, in order; `others` are the fields that they do not tell."""
    told: dict[str, Any] = {}
    for name in ("position", "force", "holding"):
        table = np.array([getattr(row, name) for row in rows])
        scatter = table.std(axis=0, ddof=1) if len(rows) > 1 else np.full(table.shape[1], np.inf)
        told |= {name: table.mean(axis=0), f"{name}s": table}
        told[f"{name}_standard_error"] = scatter / np.sqrt(len(rows))
    del told["holdings"]
    lengths = [len(row.slips) for row in rows]
    table = np.concatenate([row.slips for row in rows]).T
    return CoupledResult(
        **told,
        slips=CoupledSlips(
            replica=np.repeat(np.array(replicas, np.int64), lengths),
            number=np.concatenate([np.arange(n) for n in lengths]),
            drive=table[0],
            before=table[1],
            after=table[2],
            force_before=table[3],
            force_after=table[4],
            breaks=table[5].astype(np.int64),
        ),
        avalanches=np.array([row.avalanches for row in rows]),
        balance=float(np.mean([row.balance for row in rows])),
        breaks=sum(int(row.breaks) for row in rows),
        step_error=np.zeros(rows[0].force.size),
        **others,
    )
