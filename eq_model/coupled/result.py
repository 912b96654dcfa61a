"""What replicas of coupled contacts did, and the state of those that are finished."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.coupled.replica import Followed
from origins.brief import brief
from origins.errors import InputError

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

    def joined(self, other: CoupledState) -> CoupledState:
        """Of both."""
        sizes = {row.force.size for row in (*self.here.values(), *other.here.values())}
        if self.n != other.n or len(sizes) > 1:
            raise InputError(
                "earlier: was found on another path, or for other contacts; start anew"
            )
        found = {**self.found, **other.found, **self.here}
        return CoupledState(self.n, found, max(self.run_time, other.run_time))

    @property
    def done(self) -> list[range]:
        """The contacts of these replicas, all replicas' contacts counted in one row."""
        done: list[range] = []
        for replica in sorted(self.found):
            done = layout.joined(done, range(replica * self.n, (replica + 1) * self.n))
        return done

    @property
    def contacts(self) -> int:
        """How many."""
        return self.n * len(self.found)

    @property
    def breaks(self) -> int:
        """Of the replicas whose results are here."""
        return sum(row.breaks for row in self.here.values())

    def without_sums(self) -> CoupledState:
        """The replicas' numbers alone."""
        return CoupledState(self.n, dict.fromkeys(self.found), self.run_time)

    def arrays(self) -> dict[str, npt.NDArray[np.generic]]:
        """All of it as arrays, for a file."""
        found = self.here
        order = sorted(found)
        rows = [found[replica] for replica in order]
        points = rows[0].force.size if rows else 0
        stacked = {
            name: np.reshape([getattr(row, name) for row in rows], (len(rows), -1 if rows else 0))
            for name in ("position", "force", "holding", "avalanches")
        }
        slips = np.concatenate([np.empty((0, 6)), *(row.slips for row in rows)])
        counts = np.array(
            [(r, row.breaks, len(row.slips)) for r, row in zip(order, rows, strict=True)]
        )
        balances = np.array([row.balance for row in rows])
        return {
            **stacked,
            "slips": slips,
            "counts": counts.reshape(-1, 3).astype(np.int64),
            "balance": balances,
            "shape": np.array([self.n, points]),
            "run_time": np.array(self.run_time),
        }

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, npt.NDArray[np.generic]]) -> CoupledState:
        """The state that has these arrays; KeyError and ValueError where there is none."""
        counts = np.asarray(arrays["counts"], np.int64)
        slips = (
            np.split(np.asarray(arrays["slips"], float), np.cumsum(counts[:, 2])[:-1])
            if len(counts)
            else []
        )
        found: dict[int, Followed | None] = {
            int(replica): Followed(
                position=np.asarray(arrays["position"][i], float),
                force=np.asarray(arrays["force"][i], float),
                holding=np.asarray(arrays["holding"][i], float),
                slips=slips[i],
                avalanches=np.asarray(arrays["avalanches"][i], np.int64),
                breaks=int(breaks),
                balance=float(arrays["balance"][i]),
            )
            for i, (replica, breaks, _) in enumerate(counts)
        }
        return cls(int(arrays["shape"][0]), found, float(arrays["run_time"]))


def slips_of(rows: Mapping[int, Followed]) -> CoupledSlips:
    """Slips of these replicas."""
    order = sorted(rows)
    lengths = [len(rows[replica].slips) for replica in order]
    table = np.concatenate([np.empty((0, 6)), *(rows[replica].slips for replica in order)])
    number = np.concatenate([np.empty(0, np.int64), *(np.arange(n) for n in lengths)])
    drive, before, after, force_before, force_after, breaks = table.T
    return CoupledSlips(
        replica=np.repeat(np.array(order, np.int64), lengths),
        number=number,
        drive=drive,
        before=before,
        after=after,
        force_before=force_before,
        force_after=force_after,
        breaks=breaks.astype(np.int64),
    )


def mean_of(rows: Iterable[Array]) -> tuple[Array, Array]:
    """Mean of some replicas' arrays, and its standard error."""
    table = np.array(list(rows))
    if len(table) < 2:
        return table.mean(axis=0), np.full(table.shape[1], np.inf)
    return table.mean(axis=0), table.std(axis=0, ddof=1) / np.sqrt(len(table))
