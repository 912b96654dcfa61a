"""Contacts without laws of their own on a path that moves forward: thresholds add up, and nothing else is needed."""

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.beginning import Beginning
from eq_model.lattice import force, joined, make_lattice, split, variance
from eq_model.rare import unseen_variance
from origins import Drive

Array = npt.NDArray[np.float64]


class Forward:
    """The sums of such contacts, and what they say of the force.

    sums : shape (2, 3 + 3 bins), limbs of all births and of each bin's thresholds; then, of those contacts that are
    measured, of births, squared births, and each bin's thresholds and second moments in turn. breaks : so far.
    """

    def __init__(self, drive: Drive, beginning: Beginning) -> None:
        self._beginning, table = beginning, beginning.table
        contacts, start = beginning.contacts, beginning.contacts.start
        self._single, self._stretch = start.is_single, start.mean()
        origin = -self._stretch if self._single else 0.0
        furthest = max(abs(start.span[0]), abs(start.span[1]))
        longest = min(float(table.upper(0.0)) * table.scale, float(drive.path[-1]) + furthest)
        self.lattice = make_lattice(
            drive.path, origin, table.scale, longest + furthest, exact=contacts.thresholds.atoms[0].size > 0
        )
        self._bins = self.lattice.bin_cell.size
        self.breaks = 0
        self.sums = np.zeros((2, 3 + 3 * self._bins), np.int64)
        self._block_sums = np.zeros(2 * (self._bins + 1), np.int64)
        beginning.compile(self.lattice.unit)

    def follow(self, block: range) -> None:
        """Follow a block of contacts to the path's end."""
        from eq_model import kernel

        relaxed = self._single and self._stretch == 0.0
        births, firsts = self._beginning.draw(block, none=relaxed)
        if self._single:
            births[:] = 0  # positions are counted from where all contacts were born
        total, squares = kernel.spread(births, self._expected_birth(), self.lattice.square)
        self._block_sums[:] = 0
        path, measured, sums = self.lattice.for_kernel, layout.is_measured(block.start), self._block_sums
        many, key, table = self._beginning.n_contacts, self._beginning.words, self._beginning.compiled
        breaks = kernel.run(block.start, len(block), many, key, table, births, firsts, path, measured, sums)
        bins, split_at = split(sums[:-2]), self._bins + 1
        self.sums[:, :split_at] += np.concatenate([split(np.array([total])), bins[:, ::2]], axis=1)
        if measured:
            self.sums[:, split_at:] += np.concatenate([split(np.array([total, squares])), bins], axis=1)
        self.breaks += int(breaks)

    def moments(self, n: int, sums: npt.NDArray[np.int64]) -> tuple[Array, Array, Array]:
        """Fraction that holds, mean stretch (a length) of n contacts and its variance between them, at the points."""
        total, part = sums[:, : self._bins + 1], sums[:, self._bins + 1 :]
        births, squares, measured = part[:, 0], part[:, 1], layout.measured(n)
        # squared distances were taken from the expected mean: this brings them to the mean found
        from_expected = joined(births) - measured * self._expected_birth()
        square_births = float(joined(squares) / self.lattice.square - from_expected**2 / measured)
        unseen = unseen_variance(self._beginning.contacts, self.lattice.path, measured)
        spread = variance(self.lattice, measured, births, square_births, part[:, 2::2], part[:, 3::2], unseen)
        mean = force(self.lattice, n, total[:, 0], total[:, 1:])
        return np.ones(mean.size), mean, spread

    def _expected_birth(self) -> int:
        return 0 if self._single else round(-self._stretch / self.lattice.unit)
