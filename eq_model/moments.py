"""What the sums of blocks say of the force: its mean, its variance between contacts, the error of steps."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.lattice import Lattice
from eq_model.layout import Blocks
from origins import Contacts

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

STIFFNESS_UNIT = 2.0**36  # stiffnesses are summed in parts of this, squares of them too
_LIMB = 32  # bits of the low one of the two numbers that hold a sum of all blocks
# one in EACH contacts of a block is followed once more in steps COARSER times longer, whose force tells
# the error of the steps
COARSER, EACH = 8, 8
_RARE = (
    0.01  # breaks expected: a threshold so rare is the largest that n contacts are thought to meet
)
_NEVER = 1e-9  # breaks expected that need not be thought of


class Moments(NamedTuple):
    """At the points of the path: fraction that holds, mean force (a length), its variance between contacts."""

    holding: Array
    force: Array
    variance: Array


def split(sums: Whole) -> Whole:
    """Whole sums as two limbs, shape (2, ...), high and low; limbs of many blocks and ranks may be added up."""
    return np.stack([sums >> _LIMB, sums & ((1 << _LIMB) - 1)])


@dataclass(frozen=True)
class Readout:
    """How to read the sums of contacts on a lattice.

    told : shape (n,), the slider at the path's points (lengths), what the rounding of a single start
    leaves added. columns : sums of each bin, of all and more of measured blocks. parts : sizes of the
    sums of all, of measured blocks, and of those in coarser steps. furthest : the largest stretch at
    which contacts begin; low, high : shape (n,), the slider's lowest and highest position until the
    points (lengths); stretch : the largest stretch there.
    """

    contacts: Contacts
    lattice: Lattice
    told: Array
    columns: tuple[int, int]
    parts: Whole
    furthest: float
    low: Array
    high: Array
    stretch: Array

    def _moments(self, n: int, limbs: Whole) -> Moments:
        """Of n contacts, from limbs of all sums, with some or without; whole numbers, so nothing cancels.

        y is minus a contact's stretch when its bin ends, at `places`; k y sums are whole lengths, k sums
        parts of STIFFNESS_UNIT.
        """
        lattice, part, linked = self.lattice, int(STIFFNESS_UNIT), self.columns[0] == 3
        whole = limbs[0].astype(object) * (1 << _LIMB) + limbs[1].astype(object)
        rows = whole.reshape(lattice.bins.points.size, -1).T
        (count, ky), some = rows[:2], rows[self.columns[0] :]
        k = rows[2] if linked else count * part
        square = some[0] if len(some) else 0 * count
        kky, kk = (some[1], some[2]) if len(some) > 1 else (ky, k)
        places, per_square = lattice.bins.places.astype(object), round(1.0 / lattice.bins.square)
        holds, held, born, squares, squares_born, squares_far = (
            np.cumsum(change)[lattice.place]
            for change in (
                count,
                k,
                ky * part + k * places,
                kk,
                kky * part + kk * places,
                square * (per_square * part) + places * (2 * part * kky + kk * places),
            )
        )
        at = np.rint(self.told / lattice.unit).astype(np.int64)
        beside, x = self.told - at * lattice.unit, at.astype(object)
        force = held * x - born
        spread = ((squares * x - 2 * squares_born) * x + squares_far) * (part * n) - force * force
        mean = (force.astype(float) * lattice.unit + held.astype(float) * beside) / (part * n)
        variance = np.full(mean.size, np.inf)
        if n > 1:
            variance = spread.astype(float) * (lattice.unit / part) ** 2 / n / (n - 1)
        return Moments(holds.astype(float) / n, mean, np.maximum(variance, 0.0))

    def moments(self, blocks: Blocks, done: list[range], sums: Whole) -> Moments:
        """Of these blocks; the variance is no less than what could not be seen."""
        n, measured = blocks.contacts(done), blocks.measured(done)
        first, second, _ = self.parts
        mean = self._moments(n, sums[:, :first])
        if measured < 2:
            return mean._replace(variance=np.full(mean.force.size, np.inf))
        seen = self._moments(measured, sums[:, first : first + second]).variance
        return mean._replace(variance=self._no_less(seen, mean.force, n))

    def _no_less(self, seen: Array, force: Array, n: int) -> Array:
        """At least what one break more or less makes of the mean of n contacts."""
        contacts, unit = self.contacts, self.lattice.unit
        law, again, cold = contacts.thresholds, contacts.reforming, contacts.thermal is None
        constant = contacts.ageing is None and contacts.grains is None
        alike = contacts.start.is_single and not np.diff(law.support())[0]
        if cold and constant and alike and (again is None or again.law.is_single):
            return np.zeros(force.size)  # but for rounding
        stretch, mean, differ = self.stretch, contacts.mean_threshold, 0.0
        if constant:
            stretch = np.minimum(stretch, max(float(law.isf(_RARE / n)), self.furthest))
        reached = stretch
        if contacts.stiffness == "linked":
            # what breaks first is weak; but no contact is weaker than it is stretched
            usual = float(np.sqrt(law.moment(2))) / mean
            reached = stretch * np.maximum(
                stretch / mean, min(usual, float(law.isf(_RARE / n)) / mean)
            )
            differ = min(usual**2, float(law.isf(_RARE / n)) / mean) - 1.0
        # of so many contacts one break has been seen; first ones may be rarer
        share = self._broken() if cold and constant else np.ones(force.size)
        share = np.where(n * share > _NEVER, np.minimum(share, 1.0 / n), 0.0)
        least = np.maximum(reached**2 * share, differ * force**2)
        rounded = unit**2 / self.lattice.bins.square  # squares of stretches are
        if contacts.start.is_single:
            return np.maximum(np.where(seen < rounded, 0.0, seen), least)
        return np.maximum(seen, np.maximum(least, rounded))

    def _broken(self) -> Array:
        """At the points the share of contacts that have broken at T = 0, but for a factor of some 2; from above."""
        start, law = self.contacts.start, self.contacts.thresholds
        x, weights = np.array([start.mean()]), np.ones(1)
        if not start.is_single:  # octaves of probability, each by its outer end
            weights = np.repeat(2.0 ** -np.arange(2.0, 42.0), 2)
            x = np.stack([start.ppf(weights[::2]), start.isf(weights[::2])], axis=1).ravel()
        x = x[:, None]
        held = np.abs(x)
        reached = np.maximum(held, np.maximum(x + self.high, -x - self.low))
        before = law.sf(held)
        broken = law.cdf(reached) - law.cdf(held), before - law.sf(reached)
        share = np.where(
            law.cdf(held) < 0.5, *broken
        )  # the larger tail loses digits as a difference
        return weights @ np.divide(share, before, out=np.zeros(share.shape), where=before > 0.0)

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
