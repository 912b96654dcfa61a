"""What the sums of blocks say of the force: means, variances between contacts, and the error of steps."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from eq_model.lattice import Lattice
from eq_model.layout import Blocks
from eq_model.rare import Seen, unseen_break, unseen_variance
from origins import Contacts

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

STIFFNESS_UNIT = 2.0**36  # stiffnesses are summed in parts of this, squares of them too
_LIMB = 32  # bits of the low one of the two numbers that hold a sum of all blocks
# one in EACH contacts of a block is followed once more in steps COARSER times longer, whose force tells
# the error of the steps
COARSER, EACH = 8, 8


@dataclass(frozen=True)
class Moments:
    """At the points of the path: fraction that holds, mean force (a length), its variance between contacts."""

    holding: Array
    force: Array
    variance: Array


def split(sums: Whole) -> Whole:
    """Whole sums as two limbs, shape (2, ...), high and low; limbs of many blocks and ranks may be added up."""
    return np.stack([sums >> _LIMB, sums & ((1 << _LIMB) - 1)])


def _rows(limbs: Whole, columns: int) -> npt.NDArray[np.object_]:
    """Limbs as whole numbers of any size, a row for each bin, and one for the start."""
    return (limbs[0].astype(object) * (1 << _LIMB) + limbs[1].astype(object)).reshape(-1, columns)


@dataclass(frozen=True)
class Readout:
    """How to read the sums of contacts on a lattice.

    plain : whether they are forward's. begun, start_square : as of forward.Plain. told : shape (n,),
    the slider at the path's points (lengths), what the rounding of a single start leaves added.
    columns : sums of each bin, of all and more of measured blocks; parts : sizes of the sums of all,
    of measured blocks, and of those in coarser steps. reached : shape (n,), the largest stretch there
    may be, times the stiffness; differ : variance of stiffness over its mean squared; longest : the
    largest stretch in all.
    """

    contacts: Contacts
    lattice: Lattice
    plain: bool
    begun: int
    start_square: float
    told: Array
    columns: tuple[int, int]
    parts: Whole
    reached: Array
    differ: float
    longest: float

    @property
    def _linked(self) -> bool:
        return self.contacts.stiffness == "linked"

    def _moments(self, n: int, limbs: Whole) -> Moments:
        """Of n contacts, from limbs of all and some sums side by side; whole numbers, so nothing cancels."""
        lattice, part, columns = self.lattice, int(STIFFNESS_UNIT), sum(self.columns)
        rows, reference = _rows(limbs, columns), lattice.bins.places.astype(object)
        start, rows = rows[-1], rows[:-1]
        some = rows[:, self.columns[0] :]
        number, back = 1.0 / lattice.bins.square, some[:, 0]
        # columns of stretches are whole lengths, those of stiffnesses parts of STIFFNESS_UNIT
        weight, first = (
            (rows[:, 1], rows[:, 2]) if self._linked else (rows[:, 0] * part, rows[:, 1])
        )
        squared, first_squared = (some[:, 3], some[:, 4]) if self._linked else (weight, first)
        count, held, born, squares, squares_born, squares_far = (
            np.cumsum(change)[lattice.place]
            for change in (
                rows[:, 0],
                weight,
                first * part + weight * reference,
                squared,
                first_squared * part + squared * reference,
                back * (round(number) * part)
                + reference * (2 * part * first_squared + squared * reference),
            )
        )
        if not self._linked:
            # contacts are relaxed where the slider is at minus their stretch at X = 0
            begun, many = self.begun, start[0]
            births = -part * (start[1] + many * begun)
            far = round(1.0 / self.start_square) * start[2] + begun * (2 * start[1] + many * begun)
            count, held, born = count + many, held + many * part, born + births
            squares, squares_born = squares + many * part, squares_born + births
            squares_far = squares_far + far * part
        at = np.rint(self.told / lattice.unit).astype(np.int64)
        beside, x = self.told - at * lattice.unit, at.astype(object)
        force = held * x - born
        spread = (squares * x - 2 * squares_born) * x + squares_far
        variance = (
            (spread * (part * n) - force * force).astype(float) * (lattice.unit / part) ** 2 / n
        )
        mean = (force.astype(float) * lattice.unit + held.astype(float) * beside) / (part * n)
        variance = np.maximum(variance, 0.0) / (n - 1) if n > 1 else np.full(mean.size, np.inf)
        return Moments(count.astype(float) / n, mean, variance)

    def _mean(self, n: int, limbs: Whole) -> Moments:
        """Without the variance, from limbs of all contacts' sums."""
        wide = np.zeros((2, limbs.shape[1] // self.columns[0], sum(self.columns)), np.int64)
        wide[:, :, : self.columns[0]] = limbs.reshape(2, -1, self.columns[0])
        return self._moments(n, wide.reshape(2, -1))

    def moments(self, blocks: Blocks, done: list[range], sums: Whole) -> Moments:
        """Of these blocks, with the variance that breaks too rare to be seen add."""
        n, measured = blocks.contacts(done), blocks.measured(done)
        first, second, _ = self.parts
        mean = self._mean(n, sums[:, :first])
        if not measured:
            return Moments(mean.holding, mean.force, np.full(mean.force.size, np.inf))
        limbs = sums[:, first : first + second]
        spread = self._moments(measured, limbs).variance
        seen = self._seen(n / measured, limbs)
        contacts, reached = self.contacts, self.reached.copy()
        if self.plain and contacts.thermal is None:
            # so early the first breaks are known better than that one might have been
            unseen, known = unseen_variance(contacts, self.lattice.path, measured)
            spread = np.maximum(spread, unseen)
            reached[:known] = 0.0
        warm = contacts.thermal is not None
        alike = contacts.start.is_single and not np.diff(contacts.thresholds.support())[0]
        if self.plain and alike and not warm:
            spread = np.zeros(spread.size)  # but for rounding: contacts are all alike
        else:
            present = spread + mean.force**2
            rare = unseen_break(seen, self.lattice.place, n, present, reached, warm)
            # the stiffest contacts may be in none of few
            spread = np.maximum(spread, np.maximum(rare, self.differ * mean.force**2))
        return Moments(mean.holding, mean.force, spread)

    def _seen(self, scale: float, limbs: Whole) -> Seen:
        """Breaks of `scale` times as many contacts as are measured."""
        unit, bins, held = self.lattice.unit, self.lattice.bins, self.columns[0]
        rows = _rows(limbs, sum(self.columns))[:-1].astype(float)
        points, area = bins.points.astype(float), unit**2 / bins.square
        if not self.plain:
            return Seen(points, rows[:, held + 1] * scale, rows[:, held + 2] * area * scale)
        # each break releases x at b, and x² + 2x (end - b) of the second moments about the bin's end
        stretches = np.maximum(rows[:, 1], 0.0) * unit
        squares = np.clip(-rows[:, held] * area, 0.0, self.longest * stretches)
        largest = squares.sum() / max(stretches.sum(), unit)
        breaks = stretches * (scale / largest) if largest > 0.0 else np.zeros(stretches.size)
        return Seen(points, breaks, squares * scale)

    def step_error(self, blocks: Blocks, done: list[range], sums: Whole) -> Array:
        """What the inner steps of ageing may add to the force at the points (a length); 0 without ageing.

        The error grows faster than in proportion to the step, so this is more than it is.
        """
        first, second, third = self.parts
        if not third:
            return np.zeros(self.lattice.path.size)
        n = blocks.measured(done)
        some = sum(-(-blocks.size(block) // EACH) for part in done for block in part)
        if not some or not n:
            return np.full(self.lattice.path.size, np.inf)
        fine = self._moments(n, sums[:, first : first + second])
        other = self._moments(some, sums[:, first + second :])
        doubt = np.sqrt(fine.variance / n + other.variance / some)
        return (np.abs(other.force - fine.force) + doubt) / (COARSER - 1.0)
