"""Contacts that hold all the time, alike in stiffness, on a path that moves forward at one speed.

The stretches at which each of them breaks, its thresholds or at a temperature less, add up to where it stands: nothing
else is needed of it.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.beginning import Beginning
from eq_model.histogram import BINS, Histogram
from eq_model.lattice import SUM_BITS, Whole, carried, force, joined, make_lattice, split, variance
from eq_model.rare import unseen_break, unseen_variance
from eq_model.tally import Counts, Tally
from eq_model.thermal_tables import steady_for_kernel
from origins import Contacts, Drive

Array = npt.NDArray[np.float64]


def takes(contacts: Contacts, drive: Drive) -> bool:
    """Whether contacts on a drive are such."""
    return set(contacts.laws) <= {"thermal"} and drive.forward and drive.time is None


class Forward:
    """The sums of such contacts, and what they say of the force.

    size : of the sums, 3 + 3 bins: all births and each bin's thresholds; then, of those contacts that are measured,
    births, squared births, and each bin's thresholds and second moments in turn. weight : of a break, to go by;
    steps : none.
    """

    weight, steps = 1.0, 0.0

    def __init__(self, drive: Drive, beginning: Beginning) -> None:
        self._beginning, table = beginning, beginning.table
        contacts, start = beginning.contacts, beginning.contacts.start
        self._thermal = contacts.thermal
        self._single = start.is_single and (self._thermal is None or start.mean() == 0.0)
        self._stretch = start.mean()
        origin = -self._stretch if self._single else 0.0
        furthest = max(abs(start.span[0]), abs(start.span[1]))
        longest = min(float(table.upper(0.0)) * table.scale, float(drive.path[-1]) + furthest)
        self.lattice = make_lattice(
            drive.path, origin, table.scale, longest + furthest, exact=contacts.thresholds.atoms[0].size > 0
        )
        self._reached, self._longest = np.minimum(drive.path + furthest, longest), longest
        self._bins = self.lattice.bin_cell.size
        self.size = 3 + 3 * self._bins
        self._block_sums = np.zeros(2 * (self._bins + 1), np.int64)
        # squares of a block add up, however narrow the start
        apart = 1.0 + max(abs(edge - self._stretch) for edge in start.span) / self.lattice.unit
        self._birth_square = 2.0 ** (SUM_BITS - 17 - 2 * int(np.ceil(np.log2(apart))))
        beginning.compile(self.lattice.unit)
        self._steady = steady_for_kernel(self._thermal, drive.velocity, self.lattice.unit)
        self._pace = self.lattice.unit / drive.velocity

    def follow(self, block: range) -> tuple[npt.NDArray[np.int64], Counts, int, int]:
        """Follow a block of contacts to the path's end: sums as two limbs, shape (2, size), no counts, breaks, and no
        steps."""
        from eq_model import kernel, life_kernel

        relaxed = self._single and self._stretch == 0.0
        births, firsts = self._beginning.draw(block, none=relaxed)
        many, key = self._beginning.n_contacts, self._beginning.words
        if self._thermal is not None:
            law, tables = self._steady[5:7]
            life_kernel.first_breaks(block.start, many, key, births, firsts, law, tables, self._pace)
        if self._single:
            births[:] = 0  # positions are counted from where all contacts were born
        total, squares = kernel.spread(births, self._expected_birth(), self._birth_square)
        self._block_sums[:] = 0
        path, measured, sums = self.lattice.for_kernel, layout.is_measured(block.start), self._block_sums
        table, thermal = self._beginning.compiled, self._steady
        breaks = kernel.run(block.start, len(block), many, key, table, thermal, births, firsts, path, measured, sums)
        bins, split_at = split(sums[:-2]), self._bins + 1
        out = np.zeros((2, self.size), np.int64)
        out[:, :split_at] = np.concatenate([split(np.array([total])), bins[:, ::2]], axis=1)
        if measured:
            out[:, split_at:] = np.concatenate([split(np.array([total, squares])), bins], axis=1)
        return out, np.zeros((0, 2, BINS), np.uint32), int(breaks), 0

    def moments(self, done: list[range], sums: npt.NDArray[np.int64]) -> tuple[Array, Array, Array]:
        """Fraction that holds, mean stretch (a length) of these contacts and its variance between them, at points."""
        n = sum(map(len, done))
        total, part = sums[:, : self._bins + 1], sums[:, self._bins + 1 :]
        births, squares, measured = part[:, 0], part[:, 1], layout.measured(done)
        # squared distances were taken from the expected mean: this brings them to the mean found
        from_expected = joined(births) - measured * self._expected_birth()
        square_births = float(joined(squares) / self._birth_square - from_expected**2 / measured)
        contacts, unseen, reached = self._beginning.contacts, np.zeros(self._reached.size), self._reached.copy()
        if self._thermal is None:
            # so early the first breaks are known better than that one might have been
            unseen, known = unseen_variance(contacts, self.lattice.path, measured)
            reached[:known] = 0.0
        spread = variance(self.lattice, measured, births, square_births, part[:, 2::2], part[:, 3::2], unseen)
        mean = force(self.lattice, n, total[:, 0], total[:, 1:])
        thermal = self._thermal is not None
        if thermal or np.diff(contacts.thresholds.support())[0] > 0.0:
            breaks, taken = self._breaks(n / measured, part[:, 2::2], part[:, 3::2])
            rare = unseen_break(self.lattice, breaks, taken, n, spread + mean**2, reached, thermal)
            spread = np.maximum(spread, rare)
        return np.ones(mean.size), mean, spread

    def _breaks(self, scale: float, moved: Whole, moments: Whole) -> tuple[Array, Array]:
        """Of `scale` times as many contacts as these: breaks in each bin, not more than there are, and the sum of their
        squared stretches (lengths^2), not less."""
        unit = self.lattice.unit
        stretches, squares = np.maximum(joined(moved), 0.0) * unit, joined(carried(moments)) * unit**2
        # more than the squares by up to the width of a cell for each stretch
        squares = np.clip(-squares / self.lattice.square, 0.0, self._longest * stretches)
        largest = squares.sum() / max(stretches.sum(), unit)
        return stretches * (scale / largest) if largest > 0.0 else np.zeros(stretches.size), squares * scale

    def step_error(self, done: list[range], sums: npt.NDArray[np.int64]) -> Array:
        """None: there are no steps."""
        return np.zeros(self._reached.size)

    def histograms(self, n: int, counts: Tally) -> Sequence[Histogram]:
        """None."""
        return []

    def _expected_birth(self) -> int:
        return 0 if self._single else round(-self._stretch / self.lattice.unit)
