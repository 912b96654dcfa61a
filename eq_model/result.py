"""Results of an ensemble, of independent contacts or of replicas of coupled ones, and its histograms."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Whole
from origins.brief import brief
from origins.energy import Energy
from origins.errors import refuse
from origins.thresholds.law import Array

BINS = 4096  # of a histogram
SIZES = 40  # classes of avalanches: up to 2^40 breaks


@dataclass(frozen=True)
class Histogram:
    """Contacts that hold at one point of the path; arrays of shape (4096,), edges of shape (4097,).

    The bins of stretches extend to the largest |x| that path, start and re-forming allow, those of thresholds to 2^-64
    of the law's weight. They have equal widths, except for laws with wide tails: beyond 64 times the mean threshold (or
    the mean stretch of the start, or the mean of the final thresholds) all contacts are counted in the wide
    outermost bins. A density is the mean over its bin, so that the sum of density times width is that of all contacts.

    point : index into the path; position : X there, a length.
    stretch_edges, threshold_edges : lengths, increasing.
    stretches : Q(x; X), fraction of all contacts per length in each bin of stretches; stretch_error : its standard
    error. thresholds : P_xs(x), density of the thresholds of those contacts that hold, per length; threshold_error.
    count : contacts that hold there.
    """

    point: int
    position: float
    stretch_edges: Array
    stretches: Array
    stretch_error: Array
    threshold_edges: Array
    thresholds: Array
    threshold_error: Array
    count: int


@dataclass(frozen=True, kw_only=True)
class EnsembleResult:
    """Results of the ensemble.

    path : the path, shape (n,), lengths.
    force : mean force over all contacts and replicas at each X, shape (n,), a length (force per N_c <k>).
    force_standard_error : of that mean, from the variance between contacts, shape (n,), a length; inf for one contact.
        In large ensembles the variance is that of the first 32,768, and of every eighth block. Where breaks
        are too rare to be seen, as before the first ones, it is at least what one break more or less would make.
        It does not include events expected far less than once in the whole ensemble; one such event would change
        the force by one contact's stretch divided by the number of contacts.
    step_error : bound on the error by the inner steps of ageing, shape (n,), a length; 0 without ageing, which alone
        needs steps. It is estimated by following an eighth of the contacts in 8 times longer steps.
    force_error : force_standard_error + step_error, shape (n,), a length: the one for intervals and comparisons. The
        scatter alone is too small an error where contacts age: in large ensembles the steps' error exceeds it. The
        true force is within 2 force_error of `force` at some 95 % of the points.
    holding : fraction of contacts that hold, shape (n,).
    holding_standard_error : of that fraction, shape (n,); with delay or grains at least that of one contact.
    histograms : of stretches and thresholds, at the points requested, in their order.
    contacts : number followed; breaks : number of all breaks; breaks_per_rank : of each rank.
    success, message : whether the tolerance is reached, or else all contacts followed, and a sentence about it.
    run_time : s, of the slowest rank, with tables but without compilation; compile_time : s, with imports.
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

    @property
    def force_error(self) -> Array:
        """Error of the force for intervals, shape (n,), a length: that by chance and that by steps of ageing."""
        return self.force_standard_error + self.step_error


@dataclass(frozen=True)
class CoupledSlips:
    """Slips of all replicas, replica by replica in the order of time; arrays of shape (m,).

    replica, number : whole numbers from 0, of the replica and of the slip in it.
    drive : X_T, lengths; before, after : X at the beginning and at the end, lengths.
    force_before, force_after : F/(N_c <k>), lengths.
    breaks : number of contacts that broke; with "reset", until all contacts were replaced.
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
        """Drop of the force (lengths), which is K times the slip of X."""
        return self.force_before - self.force_after

    def mean(self, name: str, number: int) -> tuple[float, float]:
        """Mean of a field or of `drop` over the replicas that have slip `number`, and its standard error."""
        values = np.asarray(getattr(self, name), float)[self.number == number]
        if values.size < 2:
            return float(values.mean()) if values.size else np.nan, np.inf
        return float(values.mean()), float(values.std(ddof=1) / np.sqrt(values.size))


@dataclass(frozen=True, kw_only=True)
class CoupledResult(EnsembleResult):
    """Results for contacts on a soft slider; `path` is X_T.

    Other fields as in EnsembleResult, but standard errors are those between replicas, inf for one. Near a slip F is not
    normally distributed, as some replicas have slipped: compare `slips`, not the mean force across a drop.

    position, position_standard_error : X, mean over the replicas, shape (n,), lengths; at a slip, after it.
    positions, forces : X and F/(N_c <k>) of each replica, shape (replicas, n), lengths.
    slips : avalanches that broke at least `slip_fraction` of a replica's contacts.
    avalanches : numbers of smaller ones that broke 1, 2 to 3, 4 to 7, 8 to 15, ... contacts, shape (replicas, 40).
    balance : X_T = F(0)/K, the drive's position at t = 0, mean over the replicas, a length.
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


@dataclass(frozen=True)
class HeavySlips(CoupledSlips):
    """Slips of a slider with mass; arrays of shape (m,).

    A slip is a swing down of the spring's force from where the slider last stuck: origins/drive.py says what counts as
    one, for both solvers, and docs/sliders-with-mass.md. Contacts that break while a heavy slider still gathers speed
    count, and swings that follow before it sticks again, as when it swings back, belong to the same slip. A slider
    that sticks may ring, and no contact breaks. Smaller falls, where the force of few contacts varies by chance, are
    not told as slips.

    Fields as in CoupledSlips, `drive`, X_T, as the slip begins, `force_before` and `force_after` of the spring, and

    breaks : from where the slider last stuck to the end of the swing. duration : of the swing, times.
    top_speed : largest speed of the slider in it, lengths per time.
    """

    duration: Array
    top_speed: Array

    __repr__ = brief


@dataclass(frozen=True, kw_only=True)
class HeavyResult(CoupledResult):
    """Results for contacts on a soft slider with mass; fields as in CoupledResult, and more.

    force : of the spring, K (X_T - X)/(N_c <k>); in motion it differs from that of the contacts.
    contact_force, contact_force_standard_error : F/(N_c <k>), mean over the replicas, shape (n,), lengths.
    velocity, velocity_standard_error : of the slider, mean over the replicas, shape (n,), lengths per time.
    contact_forces, velocities : of each replica, shape (replicas, n).
    slips : from one stick to the next, see HeavySlips; avalanches : numbers of other falls of the spring's force,
        however small, while the slider is faster than the drive, in which contacts broke, by size as in CoupledResult.
    energy : by parts, at the path's points, see origins.energy.Energy.
    """

    contact_force: Array
    contact_force_standard_error: Array
    velocity: Array
    velocity_standard_error: Array
    contact_forces: Array
    velocities: Array
    slips: HeavySlips
    energy: Energy

    __repr__ = brief


def means(table: Array) -> tuple[Array, Array]:
    """Means over replicas, the rows, and their standard errors, inf for one."""
    scatter = table.std(axis=0, ddof=1) if len(table) > 1 else np.full_like(table[0], np.inf)
    return table.mean(axis=0), scatter / np.sqrt(len(table))


def chosen_points(histograms: npt.ArrayLike, size: int) -> npt.NDArray[np.intp]:
    """Indices of points of a path of this size, checked; raises InputError, named histograms."""
    points = np.atleast_1d(np.asarray(histograms, None if np.size(histograms) else np.intp))
    whole = points.ndim == 1 and points.dtype.kind in "iu"
    if not whole or (points < -size).any() or (points >= size).any():
        hint = f"must be indices of points of the path, such as [0, {size - 1}]"
        refuse("histograms", histograms, hint)
    if points.size > 2000:
        refuse("histograms", f"{points.size} points", "must be at most 2000, which take 65 MB")
    return np.asarray(points % size, dtype=np.intp)


def make_edges(furthest: float, largest: float, typical: float) -> tuple[Array, Array]:
    """Edges of bins for stretches that cannot exceed `furthest` and thresholds that cannot exceed `largest`; `typical`:
    what most of them are about (lengths)."""
    # 1 % more, so that stretches of exactly `furthest` lie within a bin, not at its edge
    # equal bins extend over 64 typical lengths, so that each is at most 1/32 of one wide
    furthest, wide = min(1.01 * furthest, largest) or largest, 64.0 * typical
    stretch = np.linspace(-min(furthest, wide), min(furthest, wide), BINS + 1)
    threshold = np.linspace(0.0, min(largest, wide), BINS + 1)
    stretch[0], stretch[-1], threshold[-1] = -furthest, furthest, largest
    return stretch, threshold


def histogram(
    point: int, position: float, edges: tuple[Array, Array], counts: npt.NDArray[Any], n: int
) -> Histogram:
    """The histogram with counts (2, bins) of n contacts."""
    holding = int(counts[0].sum())
    fields: list[Any] = [point, position]
    for own, seen, total in zip(edges, counts, (n, max(holding, 1)), strict=True):
        fraction, width = seen / total, np.diff(own)
        fields += [own, fraction / width, np.sqrt(fraction * (1.0 - fraction) / total) / width]
    fields.append(holding)
    return Histogram(*fields)
