"""What replicas of coupled contacts did."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model.ensemble_result import EnsembleResult
from origins.brief import brief

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

SIZES = 40  # classes of avalanches: up to 2^40 breaks


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


@dataclass(frozen=True, kw_only=True)
class CoupledResult(EnsembleResult):
    """Contacts on a soft slider as the drive moves; `path` is X_T.

    Other fields as of EnsembleResult, but that standard errors are those between replicas, inf for one. Near a slip F
    is not normal: replicas have slipped or not. Compare `slips`, not the mean force across a drop.

    Attributes
    ----------
    position, position_standard_error : arrays of shape (n,)
        X, mean over the replicas (lengths); at a slip, after it.
    positions, forces : arrays of shape (replicas, n)
        X and F/(N_c <k>) of each replica (lengths).
    slips : CoupledSlips
        Avalanches that broke at least `slip_fraction` of a replica's contacts.
    avalanches : array of shape (replicas, 40)
        How many smaller ones broke 1, 2 to 3, 4 to 7, 8 to 15, ... contacts.
    slip_fraction : float
    balance : float
        X_T = F(0)/K, where the drive stands at t = 0, mean over the replicas (a length).
    """

    position: Array
    position_standard_error: Array
    positions: Array
    forces: Array
    slips: CoupledSlips
    avalanches: Whole
    slip_fraction: float
    balance: float

    __repr__ = brief


@dataclass(frozen=True)
class Followed:
    """What a replica did.

    position, force, holding : shape (n,), X and F/(N_c <k>) (lengths), and the fraction that holds, at
        the path's points; at a slip, after it.
    slips : shape (m, 6), X_T, X before and after, F before and after (lengths), contacts that broke.
    avalanches : shape (SIZES,), how many that were no slips broke 1, 2 to 3, 4 to 7, ... contacts.
    breaks : all of them; balance : X_T = F(0)/K, where the drive stands at t = 0 (a length).
    """

    position: Array
    force: Array
    holding: Array
    slips: Array
    avalanches: Whole
    breaks: int
    balance: float

    def row(self, replica: int) -> Array:
        """All of it as numbers, behind the replica's number and that of its slips."""
        first = replica, len(self.slips), *self.avalanches, self.breaks, self.balance
        curves = self.position, self.force, self.holding
        return np.concatenate([first, *curves, self.slips.ravel()])


def read_rows(rows: Array, points: int) -> dict[int, Followed]:
    """Replicas in order, from their rows one after the other."""
    found, at = dict[int, Followed](), 0
    while at < rows.size:
        replica, slips = int(rows[at]), int(rows[at + 1])
        parts = np.cumsum([2, SIZES, 2, points, points, points, 6 * slips])
        _, sizes, last, x, force, holding, table, _ = np.split(rows[at:], parts)
        counts, table = sizes.astype(np.int64), table.reshape(-1, 6)
        told = int(last[0]), float(last[1])
        found[replica] = Followed(x, force, holding, table, counts, *told)
        at += int(parts[-1])
    return dict(sorted(found.items()))


def fields_of(found: dict[int, Followed]) -> dict[str, Any]:
    """The fields of a CoupledResult that these replicas tell."""
    told, rows = dict[str, Any](), list(found.values())
    for name in ("position", "force", "holding"):
        table = np.array([getattr(row, name) for row in rows])
        scatter = table.std(axis=0, ddof=1) if len(rows) > 1 else np.full(table.shape[1], np.inf)
        told |= {name: table.mean(axis=0), f"{name}s": table}
        told[f"{name}_standard_error"] = scatter / np.sqrt(len(rows))
    del told["holdings"]
    lengths = [len(row.slips) for row in rows]
    table = np.concatenate([row.slips for row in rows])
    replicas = np.repeat(np.array(list(found), np.int64), lengths)
    number = np.concatenate([np.arange(n) for n in lengths])
    drive, before, after, loaded, left, broken = table.T
    breaks = broken.astype(np.int64)
    slips = CoupledSlips(replicas, number, drive, before, after, loaded, left, breaks)
    return told | {
        "slips": slips,
        "avalanches": np.array([row.avalanches for row in rows]),
        "balance": float(np.mean([row.balance for row in rows])),
        "step_error": np.zeros(rows[0].force.size),
    }
