"""Thresholds from your own values, from molecular dynamics or from an experiment."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, finite_array, positive, refuse
from origins.samples.log_polynomial import smooth
from origins.thresholds.families import identical
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import Mixture

_DOUBT = 0.05
_NARROWEST = 1e-9  # of the largest sample: samples that all lie closer together are one value
_SMALLEST, _LARGEST = 1e-100, 1e100
_NOTHING = 1e-6  # of one effective sample
_OFTEN = 10  # times that a value occurs which is exact
_STANDS_OUT = 5  # least ratio of an exact value's count to that of its neighbours
_SAME = 1e-12  # relative distance at which samples count as equal
_SURELY_EXACT, _FEW = 3, 8  # numbers of different values
_EVEN = 1e-3  # deviation from equal spacing, over the step of a grid


def from_samples(
    x_s: npt.ArrayLike | None = None,
    *,
    f_s: npt.ArrayLike | None = None,
    coefficient: float | None = None,
    stiffness: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
) -> Thresholds:
    """A smooth P_c through threshold values of your own; one value, or all equal to within 1e-9, gives identical().

    Values that repeat are exact, atoms of the law, where rounding does not explain it: where one occurs at least 10
    times more often than 5 times the second largest count among the two values on either side of it; and where there
    are at most 8 values in all, each 10 times or more, that are not equally spaced, or at most 3. Equal means to within
    1e-12. Samples rounded to a grid, whose neighbours repeat equally often, stay smooth.

    Few samples far from all others keep their effect on the mean, though not always their place. Where a law misplaces
    a tenth of the samples more than sampling explains, they are refused: give each narrow peak or group separately, in
    a mixture. P_c diverges at 0 only where the samples accumulate there: half of the lowest tenth below half of its
    reach.

    x_s : array of shape (n,), lengths from 1e-100 to 1e100; or instead of it
    f_s : array of shape (n,), forces above zero, turned into lengths in one of two ways:
    coefficient : c of the paper's quadratic law f_s = c x_s^2 (Eq. PxPf), so x_s = (f_s/c)^(1/2); force per length^2.
    stiffness : k of x_s = f_s/k, one for all contacts or an array of shape (n,), force per length, above zero.
    weights : array of shape (n,), above zero, on any scale: weight of each sample; equal when left out. The lightest,
        which together weigh less than a millionth of one effective sample, are left out. A heavy sample is not an exact
        value: only repeats are.

    The result has its sampling error as `n_samples`, `effective_samples`, `cdf_error`, `cdf_misfit`, `beyond` (see
    Sampled), and `origins.bootstrap` gives that of any number derived from it.
    Raises InputError for values that are missing, not finite or not above zero, for arrays of different lengths,
    unless exactly one of x_s and f_s, and for f_s exactly one of coefficient and stiffness, is given, and for samples
    that no smooth density follows.
    """
    if (x_s is None) == (f_s is None):
        rule = "give either x_s, the thresholds as lengths, or f_s, as forces, and not both"
        raise InputError(f"from_samples: {rule}")
    if x_s is None:
        name, given = "f_s", _above_zero("f_s", f_s)
        lengths = _lengths(given, coefficient, stiffness)
    else:
        for name, value in (("coefficient", coefficient), ("stiffness", stiffness)):
            if value is not None:
                refuse(name, value, "turns forces f_s into lengths; leave it out with x_s")
        name, lengths = "x_s", _above_zero("x_s", x_s)
        given = lengths
    bad = np.flatnonzero((lengths < _SMALLEST) | (lengths > _LARGEST))
    if bad.size:
        rule = f"must lie between {_SMALLEST:g} and {_LARGEST:g}; choose another unit of length"
        if name == "f_s":
            rule = f"makes a length of {lengths[bad[0]]:g}, which {rule}"
        refuse(f"{name}[{bad[0]}]", given[bad[0]], rule)
    counts = np.ones(lengths.size)
    if weights is not None:
        counts = _above_zero("weights", weights, lengths.size)
    order = np.argsort(lengths, kind="stable")
    lengths, shares = lengths[order], counts[order] / counts.max()
    shares /= shares.sum()
    # by the Cauchy-Schwarz inequality those left out change the mean by less than a thousandth of its error
    by_share = np.sort(shares)
    light = np.searchsorted(np.cumsum(by_share), _NOTHING * float(shares @ shares))
    heavy = shares >= by_share[light]
    lengths, shares = lengths[heavy], shares[heavy] / shares[heavy].sum()
    if lengths[-1] - lengths[0] <= _NARROWEST * lengths[-1]:
        return identical(float(shares @ lengths))
    return Sampled(lengths, shares, counts.size, float(1.0 / (shares @ shares)))


def _lengths(forces: Array, coefficient: object, stiffness: npt.ArrayLike | None) -> Array:
    """Forces as lengths, by the paper's quadratic law or by a stiffness."""
    if (coefficient is None) == (stiffness is None):
        rule = "coefficient, for f_s = coefficient * x_s^2, or stiffness, for x_s = f_s / stiffness"
        raise InputError(f"from_samples: with f_s give either {rule}, and not both")
    if stiffness is None:
        return np.sqrt(forces / positive("coefficient", coefficient))
    if np.ndim(stiffness) == 0:
        return forces / positive("stiffness", stiffness)
    return forces / _above_zero("stiffness", stiffness, forces.size)


def _above_zero(name: str, value: object, size: int | None = None) -> Array:
    """`value` as an array above zero, of one value for each of `size` samples where that is given."""
    array = finite_array(name, value)
    if size is not None and array.size != size:
        refuse(name, array, f"must hold one value for each of the {size} samples")
    bad = np.flatnonzero(array <= 0.0)
    if bad.size:
        refuse(f"{name}[{bad[0]}]", array[bad[0]], "must be above zero")
    return array


def _distinct(ordered: Array, shares: Array) -> tuple[Array, Array, Array]:
    """Sorted values that differ, their shares, and their counts, from sorted samples and their shares."""
    first = np.append(0, np.flatnonzero(np.diff(ordered) > _SAME * ordered[1:]) + 1)
    counts = np.diff(np.append(first, ordered.size)).astype(float)
    return ordered[first], np.add.reduceat(shares, first), counts


def _exact(values: Array, counts: Array) -> npt.NDArray[np.bool_]:
    """Which of the values (sorted, each occurring `counts` times) are exact, by the rule that from_samples states."""
    if 1 < values.size <= _FEW and counts.min() >= _OFTEN:
        return np.full(values.size, values.size <= _SURELY_EXACT or not _on_a_grid(values))
    around = np.pad(counts, 2)
    beside = np.sort([np.roll(around, shift)[2:-2] for shift in (-2, -1, 1, 2)], axis=0)
    # the second largest: another exact value may be next to it, and a rounded density may be steep
    return counts >= _OFTEN + _STANDS_OUT * beside[-2]


def _on_a_grid(values: Array) -> bool:
    """Whether values, or their squares (lengths from rounded forces), are equally spaced."""
    for y in (values, values * values):
        steps = np.diff(y) / np.diff(y).min()
        if (np.abs(steps - np.round(steps)) < _EVEN).all() and np.median(steps) < 1.5:
            return True
    return False


class Sampled(Mixture):
    """A smooth law through samples, with their exact values as atoms.

    log P_c is m log x + a polynomial, of largest penalised likelihood (origins/samples/smoothing.py). The likelihood
    also determines whether it begins as a power x^m, at a finite value at 0 or with an edge at the smallest sample, and
    whether it ends as an exponential or with an edge at the largest; for thresholds over decades the polynomial's
    variable is log(1 + x/median). Beyond the extreme samples there is about one sample's weight. <x_s> is that of the
    samples. Time grows as n log n with the number of samples, memory is a few copies of them.

    Attributes
    ----------
    n_samples : int
    effective_samples : float
        (sum of the weights)^2 / sum of their squares, used in the errors; n_samples without weights.
    cdf_error : float
        The cdf of the law the samples came from lies within this of their empirical cdf, everywhere at once, with
        95 % confidence (Dvoretzky, Kiefer, Wolfowitz), by the effective samples.
    cdf_misfit : float
        Largest distance of this smooth cdf from the empirical one.
    beyond : (float, float)
        Weight below the smallest sample and above the largest.
    samples, shares : arrays of shape (n,)
        The different values, sorted, and their weights, of sum 1.
    smooth_part : Thresholds or None
        The law without its atoms.
    onset_power, onset_power_error : float
        m and its error. Where P_c begins at a finite value, m = 0, and the error is the size of a fitted power plus its
        own error; inf where the samples are too far from 0, or begin too sharply, to determine m.
    """

    def __init__(
        self,
        ordered: Array,
        shares: Array,
        n_samples: int,
        effective_samples: float,
        known: Array | None = None,
    ) -> None:
        """ordered : values, sorted, at least two of them different; shares : their weights, of sum 1; known : the exact
        values, if they are given."""
        self.n_samples, self.effective_samples = n_samples, effective_samples
        self.cdf_error = float(np.sqrt(np.log(2.0 / _DOUBT) / (2.0 * effective_samples)))
        values, shares, counts = _distinct(ordered, shares)
        atom = _exact(values, counts) if known is None else np.isin(values, known)
        if (~atom).sum() == 1:  # its width cannot be estimated
            atom[:] = True
        laws: list[Thresholds] = [identical(float(value)) for value in values[atom]]
        weights = shares[atom]
        self.smooth_part: Thresholds | None = None
        if not atom.all():
            own = float(shares[~atom].sum())
            part = smooth(values[~atom], shares[~atom] / own, effective_samples * own)
            laws, weights, self.smooth_part = [*laws, part], np.append(weights, own), part
        super().__init__(laws, weights / weights.sum())
        self.samples, self.shares = values, shares
        if self.smooth_part is not None and self.smooth_part.support()[0] == self.support()[0]:
            self.onset_power_error = self.smooth_part.onset_power_error
        up_to, steps = self.cdf(values), np.cumsum(shares)
        below = up_to.copy()
        below[atom] -= self.atoms[1]
        self.cdf_misfit = float(max((steps - up_to).max(), (below - steps + shares).max()))
        self.beyond = float(below[0]), float(self.sf(values[-1]))
        error = float(np.sqrt(shares @ (values - shares @ values) ** 2 / effective_samples))
        if (
            self.cdf_misfit > self.cdf_error + 0.1
            or abs(self.mean() - shares @ values) > 0.1 * error
        ):
            rule = "are groups or peaks that one smooth density does not follow; give each apart, in a mixture"
            raise InputError(
                f"from_samples: among the samples from {values[0]:g} to {values[-1]:g} {rule}"
            )
