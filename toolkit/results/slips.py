"""Which slips of an ensemble's sliders are those of all contacts, and how these differ from one to the next."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from origins.drive import SLIP_FRACTION

# fewest values of which quartiles are told; of a slider, fewest slips of which the later half is told, else the last
QUARTERED, HALVED = 8, 4
# of a mean drop: slips that shrink by less from one third of the way to the next are not called fading, nor by less
# than so many standard errors
FADED, FADING = 0.05, 4.0
# of a drop: less than this from one slip to the next is not told
STILL = 2e-3


@dataclass(frozen=True)
class Spread:
    """How a number differs from slip to slip, in its own unit.

    mean, std : over `number` slips; low, high : quartiles, of fewer than QUARTERED the smallest and the largest
    """

    mean: float
    std: float
    low: float
    high: float
    number: int

    def times(self, factor: float) -> "Spread":
        """The same in another unit."""
        mean, std, low, high = (factor * one for one in (self.mean, self.std, self.low, self.high))
        return Spread(mean, std, low, high, self.number)


def spread_of(values: npt.NDArray[np.float64]) -> Spread:
    """The spread of two values or more."""
    ends = (0.25, 0.75) if values.size >= QUARTERED else (0.0, 1.0)
    low, high = np.quantile(values, ends)
    std = float(values.std(ddof=1))
    return Spread(float(values.mean()), std, float(low), float(high), values.size)


@dataclass(frozen=True)
class LateSlips:
    """Slips of all sliders of an ensemble once these have slipped for a while: `slips`, numbered as they were, and for
    each the way of the drive since the one before, `gaps` (lengths; none before a slider's first slip), of the sliders
    `gaps_of`."""

    slips: Any
    gaps: npt.NDArray[np.float64]
    gaps_of: npt.NDArray[np.int_]

    def mean(self, name: str) -> tuple[float, float]:
        """Mean of a field over the sliders, each of its own slips, and the standard error of that, no less than if all
        slips were independent; inf for one slider."""
        return _mean_of(getattr(self.slips, name), self.slips.replica)

    def period(self) -> tuple[float, float]:
        """Mean gap and its standard error, as `mean`."""
        return _mean_of(self.gaps, self.gaps_of)


def _mean_of(values: npt.NDArray[np.float64], replica: npt.NDArray[np.int_]) -> tuple[float, float]:
    """Mean of values of these sliders, and its standard error: see `LateSlips.mean`."""
    each = np.array([values[replica == one].mean() for one in np.unique(replica)])
    if each.size < 2:
        return float(each.mean()) if each.size else np.nan, np.inf
    least = values.std(ddof=1) / values.size**0.5
    return float(each.mean()), float(max(each.std(ddof=1) / each.size**0.5, least))


def late_slips(slips: Any, sliders: int) -> LateSlips:
    """The later half of the slips that all of so many sliders have had, and those after; of fewer than HALVED the last
    one of these alone, or the first where some have had none."""
    common = int(np.bincount(slips.replica, minlength=sliders).min())
    kept = slips.number >= common // 2 if common >= HALVED else slips.number == max(common - 1, 0)
    gaps = np.diff(slips.drive, prepend=np.nan)
    follow_one = kept & (slips.number > 0)
    return LateSlips(_only(slips, kept), gaps[follow_one], slips.replica[follow_one])


def are_fading(slips: Any) -> bool:
    """Whether the slips of sliders shrink along their way: the mean drop of each slider's last third is below that of
    the third before it by FADED of it, and by FADING standard errors. Of fewer than three a third nobody knows."""
    gone = list[float]()
    off = 0.0
    for replica in np.unique(slips.replica):
        drops = slips.drop[slips.replica == replica]
        third = drops.size // 3
        if third < 3:
            return False
        before, last = drops[-2 * third : -third], drops[-third:]
        gone.append(float(before.mean() - last.mean()) / float(before.mean()))
        off += float(before.var(ddof=1) + last.var(ddof=1)) / third / float(before.mean()) ** 2
    least = max(FADED, FADING * off**0.5 / max(len(gone), 1))
    return bool(gone) and float(np.mean(gone)) > least


def shrinks_by(slips: Any, sliders: int) -> float:
    """By which part of itself a drop is smaller than the one before it, over the later half of the slips, on average
    over so many sliders; 0 where that is below STILL or below FADING standard errors of theirs, and of fewer slips than
    HALVED."""
    common = int(np.bincount(slips.replica, minlength=sliders).min())
    if common < HALVED:
        return 0.0
    each = [slips.drop[slips.replica == one][common // 2 : common] for one in range(sliders)]
    slopes = np.polyfit(np.arange(common - common // 2), np.log(each).T, 1)[0]
    least = max(STILL, FADING * float(slopes.std(ddof=1)) / sliders**0.5)
    part = -float(np.expm1(slopes.mean()))
    return part if part > least else 0.0


def swing_beyond_slips(found: Any, least: float) -> float:
    """By how much the force of each slider of an ensemble swings on the later half of its path, where it rises there by
    `least` or more above that before any slip (lengths): it falls in many steps of few contacts each, and the slips are
    not those of the force. 0 where it does not."""
    late = np.s_[:, found.path.size // 2 :]
    own = found.slips.drive >= found.path[late[1]][0]
    highest = float(found.slips.force_before[own].max(initial=-np.inf))
    if float(found.forces[late].max()) < highest + least:
        return 0.0
    return float(np.ptp(found.forces[late], axis=1).min())


def main_slips(slips: Any) -> Any:
    """The slips of an ensemble, numbered anew, but those that lower the force by less than SLIP_FRACTION of their
    slider's largest of late: a narrow peak of P_c may slip alone between slips of all contacts."""
    kept = np.zeros(slips.drop.size, bool)
    for replica in np.unique(slips.replica):
        own = np.flatnonzero(slips.replica == replica)
        drops = slips.drop[own]
        late = drops[drops.size // 2 if drops.size > 2 else 0 :]
        kept[own] = drops >= SLIP_FRACTION * late.max()
    return _of(slips, kept)


def large_slips(slips: Any, least: float) -> Any:
    """The slips of an ensemble, numbered anew, that lower the force by `least` (a length, F/(N_c <k>)) or more: the
    jerks of few contacts that slide are smaller."""
    return _of(slips, np.asarray(slips.drop >= least))


def _of(slips: Any, kept: npt.NDArray[np.bool_]) -> Any:
    """The slips that are kept, numbered anew along each slider."""
    number = np.zeros(kept.size, int)
    for replica in np.unique(slips.replica):
        own = slips.replica == replica
        number[own] = np.cumsum(kept[own]) - 1
    return replace(_only(slips, kept), number=number[kept])


def _only(slips: Any, kept: npt.NDArray[np.bool_]) -> Any:
    """The slips that are kept, with the numbers that they have."""
    return replace(slips, **{each.name: getattr(slips, each.name)[kept] for each in fields(slips)})
