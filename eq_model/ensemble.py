"""The discrete ensemble: contacts independent of one another, followed along the path of a rigid slider."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.beginning import redraw, tables
from eq_model.lattice import Whole, force, joined, make_lattice, split, variance
from eq_model.rare import unseen_variance
from origins import Contacts, Drive
from origins.contacts import check_contacts
from origins.errors import refuse, whole
from origins.hot_cells import HOT_MISSING, MOST_PIECES, WHOLE, HotCells
from origins.quantile import FINE_BITS, QuantileTable
from origins.streams import MOST_REPLICAS, key_of

Array = npt.NDArray[np.float64]

_MOST_CONTACTS = 1 << 37


@dataclass(frozen=True)
class EnsembleResult:
    """What the ensemble measured.

    path : the path asked for, shape (n,), lengths.
    force : mean stretch over all contacts and replicas at each X, shape (n,), a length (force per N_c <k>).
    force_standard_error : of that mean, from the variance between contacts, shape (n,), a length; inf for one contact.
        The variance is that of the first 2^18 contacts and of every eighth 2^16 of the others.
        Where fewer than 100 first breaks are expected, it is at least what they add to the variance, seen or not. What
        happens to less than one contact in all of them later on is in no ensemble and not in its error: one contact's
        stretch divided by their number.
    holding : fraction of contacts that hold, shape (n,): all.
    breaks : breaks in all; breaks_per_rank : of each rank.
    run_time : s, of the slowest rank, tables included, compilation not; compile_time : s, imports included.
    """

    path: Array
    force: Array
    force_standard_error: Array
    holding: Array
    breaks: int
    breaks_per_rank: list[int]
    run_time: float
    compile_time: float


class Ensemble:
    """An ensemble under way: iterate to work through it block by block, then ask for the result.

        ensemble = Ensemble(contacts, path, n_contacts=100_000)
        for done, total in ensemble:
            ...                       # contacts this rank has done, of its share
        result = ensemble.result()    # all ranks together

    Parameters and errors as for `simulate`.
    """

    def __init__(
        self,
        contacts: Contacts,
        path: npt.ArrayLike,
        *,
        n_contacts: int = 100_000,
        n_replicas: int = 1,
        seed: int = 0,
        comm: Any = None,
    ) -> None:
        check_contacts(contacts, "eq_model.simulate")
        started = time.perf_counter()
        self.contacts, self.comm = contacts, comm
        self.n_contacts, replicas = whole("n_contacts", n_contacts, 1), whole("n_replicas", n_replicas, 1)
        if replicas >= MOST_REPLICAS:
            refuse("n_replicas", n_replicas, f"must be below {MOST_REPLICAS}; take more contacts instead")
        self.total = self.n_contacts * replicas
        if self.total > _MOST_CONTACTS:
            refuse("n_contacts", n_contacts, f"times n_replicas must be at most {_MOST_CONTACTS}")
        self.key = key_of(seed)
        positions = Drive(path).only_forward("eq_model.simulate").path
        self._table, self._start_table = tables(contacts)
        start = contacts.start
        self._single, self._stretch = start.is_single, start.mean()
        origin = -self._stretch if self._single else 0.0
        furthest = max(abs(start.span[0]), abs(start.span[1]))
        longest = min(float(self._table.upper(0.0)) * self._table.scale, float(positions[-1]) + furthest)
        self.lattice = make_lattice(
            positions, origin, self._table.scale, longest + furthest, exact=contacts.thresholds.atoms[0].size > 0
        )
        bins = self.lattice.bin_cell.size
        self.breaks = 0
        # limbs of all births and of each bin's thresholds; of those measured also squared births and second moments
        self._sums, self._measured = np.zeros((2, 1 + bins), np.int64), np.zeros((2, 2 + 2 * bins), np.int64)
        self._block_sums = np.zeros(2 * (bins + 1), np.int64)
        self._run_time = time.perf_counter() - started
        started = time.perf_counter()
        layout.in_turn(comm, self._compile)
        self.compile_time = time.perf_counter() - started

    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Do this rank's share, once; after each block (contacts done, contacts in the share)."""
        mine = layout.share(self.total, *layout.rank_and_size(self.comm))
        each = float(self.lattice.path[-1]) / self.contacts.mean_threshold
        for block in layout.blocks(mine, each):
            started = time.perf_counter()
            self._follow(block)
            self._run_time += time.perf_counter() - started
            yield block.stop - mine.start, len(mine)

    def result(self) -> EnsembleResult:
        """What all ranks found; every rank must call, and gets the same bits."""
        started = time.perf_counter()
        sums = np.concatenate([self._sums, self._measured], axis=1)
        breaks_per_rank = [self.breaks]
        if self.comm is not None:
            mine, sums = sums, np.empty_like(sums)
            self.comm.Allreduce(mine, sums)  # whole numbers: the order does not matter
            breaks_per_rank = self.comm.allgather(self.breaks)
        bins = self.lattice.bin_cell.size
        total, part = sums[:, : bins + 1], sums[:, bins + 1 :]
        births, squares, n = part[:, 0], part[:, 1], layout.measured(self.total)
        # squared distances were taken from the expected mean: this brings them to the mean found
        from_expected = joined(births) - n * self._expected_birth()
        square_births = float(joined(squares) / self.lattice.square - from_expected**2 / n)
        unseen = unseen_variance(self.contacts, self.lattice.path, n)
        spread = variance(self.lattice, n, births, square_births, part[:, 2::2], part[:, 3::2], unseen)
        run_time = self._run_time + time.perf_counter() - started
        if self.comm is not None:
            run_time = max(self.comm.allgather(run_time))
        return EnsembleResult(
            path=self.lattice.path,
            force=force(self.lattice, self.total, total[:, 0], total[:, 1:]),
            force_standard_error=np.sqrt(spread / self.total),
            holding=np.ones(self.lattice.path.size),
            breaks=sum(breaks_per_rank),
            breaks_per_rank=breaks_per_rank,
            run_time=run_time,
            compile_time=self.compile_time,
        )

    def _expected_birth(self) -> int:
        return 0 if self._single else round(-self._stretch / self.lattice.unit)

    def _follow(self, block: range) -> None:
        from eq_model import kernel

        births, firsts = self._begin(block)
        total, squares = kernel.spread(births, self._expected_birth(), self.lattice.square)
        self._block_sums[:] = 0
        path, measured, sums = self.lattice.for_kernel, layout.is_measured(block.start), self._block_sums
        self.breaks += kernel.run(
            block.start, len(block), self.n_contacts, self._key, self._main, births, firsts, path, measured, sums
        )
        bins = split(sums[:-2])
        self._sums += np.concatenate([split(np.array([total])), bins[:, ::2]], axis=1)
        if measured:
            self._measured += np.concatenate([split(np.array([total, squares])), bins], axis=1)

    def _begin(self, block: range) -> tuple[Whole, Whole]:
        """Starting positions and first thresholds of a block; empty where all start relaxed."""
        from eq_model import kernel

        unit = self.lattice.unit
        relaxed = self._single and self._stretch == 0.0
        size = 0 if relaxed else len(block)
        births, firsts = np.full(size, round(-self._stretch / unit), np.int64), np.empty(size, np.int64)
        kernel.begin(block.start, self.n_contacts, self._key, self._main, self._start, self._single, births, firsts)
        again = np.flatnonzero(firsts < 0)
        if again.size:
            replica, contact = np.divmod((again + block.start).astype(np.uint64), np.uint64(self.n_contacts))
            stretches = (births[again] * -unit).astype(float)
            stretches, thresholds = redraw(
                stretches, replica, contact, self.key, self.contacts, self._table, self._start_table
            )
            births[again] = np.rint(-stretches / unit).astype(np.int64)
            # beyond the path it does not matter how far
            firsts[again] = np.minimum(np.rint(thresholds / unit), float(kernel.FAR)).astype(np.int64)
            np.maximum(firsts, np.abs(births), out=firsts)
        if self._single:
            births[:] = 0  # positions are counted from where all contacts were born
        return births, firsts

    def _compile(self) -> None:
        """Compile the kernel, or load it, by following no contacts."""
        unit = self.lattice.unit
        self._key = tuple(np.uint64(word) for word in self.key)
        self._main = kernel_table(self._table, unit)
        self._start = self._main if self._start_table is None else kernel_table(self._start_table, unit)
        self._follow(range(0))


def kernel_table(table: QuantileTable, unit: float) -> tuple[Any, ...]:
    """A quantile table as the kernel takes it: hot cells packed in sixteen bytes each, in units of the lattice."""
    from eq_model.kernel import FAR, MISSING

    factor = table.scale / unit
    # above MISSING after rounding, and four of them beyond a position still below 2^63
    missed = 1.25 * MISSING
    hot = table.hot
    missing = hot.c0 >= HOT_MISSING
    far = ~missing & (np.abs(hot.c0) * factor > FAR)
    packed = np.zeros((hot.c0.size, 2))
    packed[:, 0] = np.where(missing, missed / factor, np.where(far, FAR / factor, hot.c0))
    slopes = np.stack([hot.c1, hot.c2], axis=-1)
    packed.view(np.float32)[:, 2:] = np.where((missing | far)[:, None], 0.0, slopes)
    sides, firsts, edges, cubics = [], [], [], []
    place, cells = 0, 0
    for side in (table.lower, table.upper):
        # where each regular cell begins among the cells, and the number of the first, as the bits of v have it
        numbers = side.edges[:-1].view(np.int64) >> (52 - FINE_BITS)
        first = np.searchsorted(numbers, np.arange(numbers[0], numbers[-1] + 1)) + cells
        sides.append((place, first.size, numbers[0], cells + len(side.cubics) - 1))
        firsts.append(first)
        edges.append(side.edges)
        cubics += [side.cubics, np.zeros((1, 6))]  # one cell less than edges: kept in step
        place, cells = place + first.size, cells + side.edges.size
    fine = np.array(sides, dtype=np.int64), np.concatenate(firsts), np.concatenate(edges), np.concatenate(cubics)
    return packed.view(np.int64).ravel(), np.int64(52 - hot.bits), _pieces(hot), factor, *fine


def _pieces(hot: HotCells) -> npt.NDArray[np.uint32]:
    """Rows of the pieces as the kernel takes them: two, or with some that no number reaches MOST_PIECES."""
    n = hot.ends.size - 1
    ends = np.where(np.arange(n) % 2 == 1, hot.ends[1:], hot.ends[:-1])
    rows = np.stack([hot.ends[:-1] - 1, ends, np.arange(n) * hot.per_piece], axis=-1)
    unreached = np.tile([WHOLE - 1, 0, 0], (0 if n == 2 else MOST_PIECES - n, 1))
    return (np.concatenate([rows, unreached]) % WHOLE).astype(np.uint32)


def simulate(
    contacts: Contacts,
    path: npt.ArrayLike,
    *,
    n_contacts: int = 100_000,
    n_replicas: int = 1,
    seed: int = 0,
    comm: Any = None,
) -> EnsembleResult:
    """Follow n_contacts * n_replicas discrete contacts along the path of a rigid slider.

    A contact breaks where its stretch reaches its threshold and starts again at x = 0 with a fresh one (paper,
    Sec. II). The contacts are independent, so the mean is unbiased at every number of them.

    Parameters
    ----------
    contacts : origins.Contacts
    path : array of shape (n,)
        Positions X (lengths, in the unit of the thresholds), forward from 0; see origins.Drive.
    n_contacts, n_replicas : int
        Replicas differ in their random numbers only.
    seed : int
        0 <= seed < 2^64. The result depends on these arguments alone, bit by bit, not on the number of ranks.
    comm : mpi4py communicator, optional
        Its ranks share the work, and all must call; None: this process alone, mpi4py not needed.

    Raises InputError for arguments that cannot be used, and for thresholds that cannot be tabulated.
    """
    ensemble = Ensemble(contacts, path, n_contacts=n_contacts, n_replicas=n_replicas, seed=seed, comm=comm)
    for _ in ensemble:
        pass
    return ensemble.result()
