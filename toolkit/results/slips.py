"""Which slips of an ensemble's sliders are main ones, and how these differ from one to the next."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from origins.drive import main_drops
from origins.thresholds.law import Array

# fewest values of which quartiles are told; of a slider, fewest slips of which the later half is told, else the last
QUARTERED, HALVED = 8, 4
# of a mean drop: slips that shrink by less from one third of the way to the next are not called fading, nor by less
# than so many standard errors
FADED, FADING = 0.05, 4.0
# of a drop: less than this from one slip to the next is not told of FEW_SLIPS late slips, of more as much less
STILL, FEW_SLIPS = 2e-3, 2
# Means of two blocks of slips agree up to so many standard errors of their difference, and up to this part of a drop.
AGREE, SAME = 2.0, 1e-3
# Slips of each slider that tell of a limit cycle; where they differ by more than this part of a drop MANY, as one may
# hang on some ten before it.
ENOUGH, MANY, ALIKE = 8, 32, 0.05
# fewest slips in turn long and short of which means are told, where there are so many: two pairs have a scatter
PAIRED = 4
# times the drive's way on which the spring regains what a slip took, after which, without another, slips are over
WITHOUT = 1.5
# of the largest drop: those that tell whether slips shrink
LARGE = 0.5
# standard errors of a trend, by the scatter about it, from which on it is told
TRENDED = 2.0


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


def spread_of(values: Array) -> Spread:
    """The spread of two values or more."""
    ends = (0.25, 0.75) if values.size >= QUARTERED else (0.0, 1.0)
    low, high = np.quantile(values, ends)
    std = float(values.std(ddof=1))
    return Spread(float(values.mean()), std, float(low), float(high), values.size)


@dataclass(frozen=True)
class LateSlips:
    """Slips of all sliders of an ensemble once these have slipped for a while: `slips`, numbered as they were, and for
    each the way of the drive since the one before, `gaps` (lengths; none before a slider's first slip), of the sliders
    `gaps_of`. Two `blocks` of them, one after the other, differ where the slips are still those of a transient; each
    slider has had `common` slips or more."""

    slips: Any
    gaps: Array
    gaps_of: npt.NDArray[np.int_]
    common: int
    blocks: tuple["LateSlips", ...] = ()

    def mean(self, name: str) -> tuple[float, float]:
        """Mean of a field over the sliders, each of its own slips, and the error of that: its standard error, no less
        than if all slips were independent, inf for one slider. Where the slips are not `settled`, with what is left:
        by how much the blocks differ, and few slips among each other."""
        mean, error = _mean_of(getattr(self.slips, name), self.slips.replica)
        each = [_mean_of(getattr(one.slips, name), one.slips.replica) for one in self.blocks]
        return mean, float(np.hypot(error, self._left(getattr(self.slips, name), each)))

    def period(self) -> tuple[float, float]:
        """Mean gap and its error, as `mean`."""
        mean, error = _mean_of(self.gaps, self.gaps_of)
        each = [_mean_of(one.gaps, one.gaps_of) for one in self.blocks if one.gaps.size]
        return mean, float(np.hypot(error, self._left(self.gaps, each)))

    @property
    def settled(self) -> bool:
        """Whether these are the slips of a limit cycle: both blocks agree, and slips are many, or alike."""
        names = "force_before", "drop"
        each = [
            [_mean_of(getattr(one.slips, of), one.slips.replica) for one in self.blocks]
            for of in names
        ]
        return not self._few and not any(self._drift(one) for one in each)

    @property
    def alike(self) -> bool:
        """Whether one takes as much of the force as another."""
        drop = self.slips.drop
        return drop.size < 2 or bool(drop.std(ddof=1) <= ALIKE * drop.mean())

    @property
    def _few(self) -> bool:
        """Whether each slider has had too few slips to tell of a limit cycle."""
        return self.common < (ENOUGH if self.alike else MANY)

    def _left(self, values: Array, each: list[tuple[float, float]]) -> float:
        """What a transient leaves unknown in the mean of these values, with the means and errors of the blocks."""
        scatter = float(values.std(ddof=1)) if self._few and values.size > 1 else 0.0
        return max(self._drift(each), scatter)

    def _drift(self, each: list[tuple[float, float]]) -> float:
        """By how much the means of both blocks differ where that is no chance, else 0."""
        if len(each) < 2:
            return 0.0
        (earlier, off), (later, more_off) = each
        drift = abs(later - earlier)
        least = SAME * abs(float(self.slips.drop.mean()))
        return drift if drift > max(AGREE * float(np.hypot(off, more_off)), least) else 0.0


def _mean_of(values: Array, replica: npt.NDArray[np.int_]) -> tuple[float, float]:
    """Mean of values of these sliders, and its standard error: see `LateSlips.mean`."""
    each = np.array([values[replica == one].mean() for one in np.unique(replica)])
    if each.size < 2:
        return float(each.mean()) if each.size else np.nan, np.inf
    least = values.std(ddof=1) / values.size**0.5
    return float(each.mean()), float(max(each.std(ddof=1) / each.size**0.5, least))


def late_slips(slips: Any, sliders: int) -> LateSlips:
    """The later half of the slips that all of so many sliders have had, and those after; of fewer than HALVED the last
    one of these alone, held against the one before it, or all where some sliders have had none."""
    common = int(np.bincount(slips.replica, minlength=sliders).min())
    gaps = np.diff(slips.drive, prepend=np.nan)

    def those(kept: npt.NDArray[np.bool_], *blocks: LateSlips) -> LateSlips:
        follow_one = kept & (slips.number > 0)
        return LateSlips(
            _only(slips, kept), gaps[follow_one], slips.replica[follow_one], common, blocks
        )

    if not common:
        return those(np.ones(slips.number.size, bool))
    last = common - 1
    if common < HALVED:
        one_before = [those(slips.number == one) for one in (last - 1, last) if last]
        return those(slips.number == last, *one_before)
    first, late = common // 2, slips.number >= common // 2
    later = slips.number >= (first + common + 1) // 2
    return those(late, those(late & ~later), those(later))


def still_changing(slips: Any, sliders: int) -> tuple[float, ...]:
    """The force before a slip, in order, its mean over so many sliders, where these have had fewer than ENOUGH slips
    and the last ones grow, or shrink, from slip to slip by more than chance; else none."""
    if not 2 < (common := int(np.bincount(slips.replica, minlength=sliders).min())) < ENOUGH:
        return ()
    each = np.array([slips.force_before[slips.replica == one][:common] for one in range(sliders)])
    steps = np.diff(each)[:, -2:]
    means, off = steps.mean(axis=0), steps.std(axis=0, ddof=1) / sliders**0.5
    clear = np.abs(means) > np.maximum(AGREE * off, STILL * np.abs(each[:, -1].mean()))
    on = bool(clear.all()) and means[0] * means[1] > 0.0
    return tuple(each.mean(axis=0).tolist()) if on else ()


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
    """By which part of itself a large drop is smaller than the one before it, over the later half of these, on average
    over so many sliders. 0 where that is below STILL (of FEW_SLIPS late slips, of more as much less), below FADING
    standard errors of theirs or TRENDED by the scatter about the trend, and of fewer slips than HALVED. Contacts that
    have drawn apart slip in groups in between: drops below LARGE of a slider's largest of late do not count."""
    each = [slips.drop[slips.replica == one] for one in range(sliders)]
    each = [drops[drops >= LARGE * drops[drops.size // 2 :].max(initial=0.0)] for drops in each]
    common = min(drops.size for drops in each)
    if common < HALVED:
        return 0.0
    # three at least, of which a scatter is known
    late = np.log([drops[min(common // 2, common - 3) : common] for drops in each])
    steps = np.arange(late.shape[1]) - 0.5 * (late.shape[1] - 1)
    slopes = np.polyfit(steps, late.T, 1)[0]
    # drops that settle by turns larger and smaller, alike for all sliders, do not shrink
    off = late.mean(axis=0) - late.mean() - slopes.mean() * steps
    own = (off @ off / (steps.size - 2) / (steps @ steps)) ** 0.5
    still = STILL * FEW_SLIPS / steps.size
    least = max(still, FADING * float(slopes.std(ddof=1)) / sliders**0.5, TRENDED * own)
    part = -float(np.expm1(slopes.mean()))
    return part if part > least else 0.0


def regained_at(slips: Any, spring: float, times: float) -> float:
    """The drive's place at which this spring has regained `times` what each slip took."""
    return float((slips.drive + times * slips.drop / spring).max())


def left_of_slips(found: Any, slips: Any, shrinks: float) -> float:
    """The drop that slips of these sliders have at the path's end if each goes on to be smaller than the one before by
    so large a part of itself (a length); 0 where none does."""
    if not shrinks:
        return 0.0
    last = slips.number == slips.number.max()
    own = slips.replica == slips.replica[last][0]
    period = float(np.diff(slips.drive[own][-2:])[0])
    silent = float(found.path[-1] - slips.drive[own][-1])
    return float(slips.drop[own][-1] * (1.0 - shrinks) ** (silent / period))


def are_lasting(slips: Any, sliders: int) -> bool:
    """Whether the slips of so many sliders are those of a limit cycle, and do not shrink."""
    return late_slips(slips, sliders).settled and not shrinks_by(slips, sliders)


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


def slips_to_tell(slips: Any, lasts: bool) -> npt.NDArray[np.int_]:
    """Indices of a solution's slips whose means tell of all: the last main one, as others may be of a few contacts
    alone; where they go on for ever, and differ in size or in the gap before them, those of the later half, PAIRED at
    least where there are so many with a gap before them: an even number, as a short slip may follow each long one."""
    main = slips.main
    half = (main.size + 1) // 4 * 2
    later = main[main.size - half :]
    each = slips.drop[later], np.diff(slips.drive[main])[main.size - 1 - half :]
    several = any(np.ptp(one) > ALIKE * abs(one.mean()) for one in each if one.size > 1)
    if not (lasts and several):
        return np.asarray(main[-1:])
    shown = max(half, min(PAIRED, (main.size - 1) // 2 * 2))
    return np.asarray(main[main.size - shown :])


def main_slips(slips: Any) -> Any:
    """The main slips of an ensemble, numbered anew, see origins.drive.main_drops."""
    kept = np.zeros(slips.drop.size, bool)
    for replica in np.unique(slips.replica):
        own = slips.replica == replica
        kept[own] = main_drops(slips.drop[own])
    return _of(slips, kept)


def with_main_slips(found: Any) -> Any:
    """An ensemble's result with its main slips alone: what is asked of it then is asked of these."""
    return replace(found, slips=main_slips(found.slips))


def large_slips(slips: Any, least: float) -> Any:
    """The slips of an ensemble, numbered anew, that lower the force by `least` (a length, F/(N_c <k>)) or more: the
    jerks of few contacts that slide are smaller."""
    return _of(slips, np.asarray(slips.drop >= least))


def slips_beyond(slips: Any, drive: float) -> Any:
    """The slips of an ensemble, numbered anew, that begin beyond this place of the drive."""
    return _of(slips, np.asarray(slips.drive > drive))


def slips_after(slips: Any, first: int) -> Any:
    """The slips of an ensemble, numbered anew, but the first ones of each slider, so many."""
    return _of(slips, np.asarray(slips.number >= first))


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
