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
COLUMNS = 6  # of each bin, see contact.count_event
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
    leaves added. furthest : the largest stretch at which contacts begin; longest : the largest of all;
    span : shape (n,), how far the slider's places until the points lie apart (lengths); begun : the
    largest stretch until there of contacts that have not broken.
    """

    contacts: Contacts
    lattice: Lattice
    told: Array
    furthest: float
    longest: float
    span: Array
    begun: Array

    def _moments(self, n: int, limbs: Whole) -> Moments:
        """Of n contacts, from limbs of their sums; whole numbers, so nothing cancels.

        y is minus a contact's stretch when its bin ends, at `places`; k y sums are whole lengths, k sums
        parts of STIFFNESS_UNIT.
        """
        lattice, part = self.lattice, int(STIFFNESS_UNIT)
        whole = limbs[0].astype(object) * (1 << _LIMB) + limbs[1].astype(object)
        count, ky, k, square, kky, kk = whole.reshape(-1, COLUMNS).T
        if self.contacts.stiffness != "linked":
            k, kky, kk = count * part, ky, count * part
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
        """Of these blocks, sums of all and of measured ones; the variance is no less than what could not be seen."""
        n, measured = blocks.contacts(done), blocks.measured(done)
        mean = self._moments(n, sums[:, 0])
        if measured < 2:
            return mean._replace(variance=np.full(mean.force.size, np.inf))
        seen = self._moments(measured, sums[:, 1]).variance
        return mean._replace(variance=self._no_less(seen, mean.force, n))

    def _no_less(self, seen: Array, force: Array, n: int) -> Array:
        """At least what one break more or less makes of the mean of n contacts."""
        contacts, unit = self.contacts, self.lattice.unit
        stretch = np.minimum(self.span + self.furthest, self.longest)
        law, again, mean = contacts.thresholds, contacts.reforming, contacts.mean_threshold
        constant = contacts.ageing is None and contacts.grains is None
        cold = constant and contacts.thermal is None
        alike = contacts.start.is_single and not np.diff(law.support())[0]
        if cold and alike and (again is None or again.law.is_single):
            return np.zeros(force.size)  # but for rounding
        # of so many contacts one break has been seen, where any can have been
        share = np.full(force.size, 1.0 / n)
        if cold:
            least = abs(contacts.start.mean()) if contacts.start.is_single else 0.0
            held = law.sf(least)
            share *= (n * (held - law.sf(self.begun)) > _NEVER * held) & (self.span > 0.0)
        if constant:
            stretch = np.minimum(stretch, max(float(law.isf(_RARE / n)), self.furthest))
        reached, differ = stretch, 0.0
        if contacts.stiffness == "linked":
            # what breaks first is weak; but no contact is weaker than it is stretched
            usual, rare = float(np.sqrt(law.moment(2))) / mean, float(law.isf(_RARE / n)) / mean
            reached = stretch * np.maximum(stretch / mean, min(usual, rare))
            differ = min(usual**2, rare) - 1.0
        least = np.maximum(reached**2 * share, differ * force**2)
        rounded = unit**2 / self.lattice.bins.square  # squares of stretches are
        if contacts.start.is_single:
            return np.maximum(np.where(seen < rounded, 0.0, seen), least)
        return np.maximum(seen, np.maximum(least, rounded))

    def step_error(self, blocks: Blocks, done: list[range], sums: Whole) -> Array:
        """What the inner steps of ageing may add to the force at the points (a length); 0 without ageing.

        The error grows faster than in proportion to the step, so this is more than it is.
        """
        if sums.shape[1] == 2:
            return np.zeros(self.lattice.path.size)
        n = blocks.measured(done)
        some = sum(-(-blocks.size(block) // EACH) for part in done for block in part)
        if not some or not n:
            return np.full(self.lattice.path.size, np.inf)
        fine, other = self._moments(n, sums[:, 1]), self._moments(some, sums[:, 2])
        doubt = np.sqrt(fine.variance / n + other.variance / some)
        return (np.abs(other.force - fine.force) + doubt) / (COARSER - 1.0)
