"""What an ensemble measured: of independent contacts, and of replicas of coupled ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model.histogram import Histogram
from origins.brief import brief

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

SIZES = 40  # classes of avalanches: up to 2^40 breaks
# of a replica's row: its number, breaks, X_T = F(0)/K and avalanches by class, then X, F and the share that holds
CURVES = 3 + SIZES


@dataclass(frozen=True, kw_only=True)
class EnsembleResult:
    """What the ensemble measured.

    path : the path asked for, shape (n,), lengths.
    force : mean force over all contacts and replicas at each X, shape (n,), a length (force per N_c <k>).
    force_standard_error : of that mean, from the variance between contacts, shape (n,), a length; inf for
        one contact. Of large ensembles it is that of the first 4 blocks of contacts, and of every eighth of
        the others. Where breaks are too rare to be seen, before the first ones and where many come to an end
        or begin together, it is at least what one break more or less would make. What happens to less than
        one contact in all of them later on is in no ensemble and not in its error: one contact's stretch
        divided by their number.
    step_error : what the inner steps of ageing may add to the force, shape (n,), a length; 0 without ageing, whose
        contacts need none. An eighth of the contacts is followed in 8 times longer steps besides to tell.
    holding : fraction of contacts that hold, shape (n,).
    holding_standard_error : of that, shape (n,); where contacts may wait, at least that of one contact.
    histograms : of stretches and thresholds, at the points asked for, in their order.
    contacts : followed in all; breaks : breaks in all; breaks_per_rank : of each rank.
    success, message : whether the tolerance is reached, or all contacts followed, and in words.
    run_time : s, of the slowest rank, tables included, compilation not; compile_time : s, imports included.
    """

    path: Array
    force: Array
    force_standard_error: Array
    step_error: Array
    holding: Array
    holding_standard_error: Array
    histograms: Sequence[Histogram] = ()
    contacts: int
    breaks: int
    breaks_per_rank: list[int]
    run_time: float
    compile_time: float
    success: bool
    message: str

    __repr__ = brief


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


def fields_of(rows: Array, slips: Array) -> dict[str, Any]:
    """The fields of a CoupledResult that these rows tell, one of each replica, with those of all slips."""
    slips = slips.reshape(-1, 8)
    rows, slips = (table[np.argsort(table[:, 0], kind="stable")] for table in (rows, slips))
    curves = rows[:, CURVES:].reshape(len(rows), 3, -1)
    told: dict[str, Any] = {"positions": curves[:, 0], "forces": curves[:, 1]}
    for k, name in enumerate(("position", "force", "holding")):
        table = curves[:, k]
        scatter = table.std(axis=0, ddof=1) if len(rows) > 1 else np.full(table.shape[1], np.inf)
        told |= {name: table.mean(axis=0), f"{name}_standard_error": scatter / np.sqrt(len(rows))}
    columns: list[Any] = list(slips.T)
    for whole in (0, 1, 7):
        columns[whole] = columns[whole].astype(np.int64)
    return told | {
        "slips": CoupledSlips(*columns),
        "avalanches": rows[:, 3:CURVES].astype(np.int64),
        "balance": float(rows[:, 2].mean()),
        "step_error": np.zeros(curves.shape[2]),
    }
