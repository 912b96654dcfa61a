"""Thresholds from your own values, from molecular dynamics or from an experiment."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, finite_array, positive, refuse
from origins.samples.repeats import distinct, exact
from origins.samples.smoothing import smooth
from origins.thresholds.families import identical
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import Mixture

_DOUBT = 0.05
_NARROWEST = 1e-9  # of the largest sample: samples that all lie closer together are one value
_SMALLEST, _LARGEST = 1e-100, 1e100
_LEAST_GROUP = 5  # samples of a group beyond a gap
_GAP = 10.0  # a gap's least width over those around it, to which the log of the number of samples is added
_NOTHING = 1e-6  # of one effective sample


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

    Five samples or more beyond a gap that is 10 + log(n) times as wide as those around it are a group with its own
    smooth law; fewer far samples keep their effect on the mean, though not always their place. Where a law misplaces
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
    lengths, shares = _that_count(lengths, counts)
    if lengths[-1] - lengths[0] <= _NARROWEST * lengths[-1]:
        return identical(float(shares @ lengths))
    return Sampled(lengths, shares, counts.size, float(1.0 / (shares @ shares)))


def _that_count(lengths: Array, counts: Array) -> tuple[Array, Array]:
    """Sorted lengths and their shares, without the lightest, which together weigh less than a millionth of one
    sample: by the Cauchy-Schwarz inequality they change the mean by less than a thousandth of its error."""
    order = np.argsort(lengths, kind="stable")
    lengths, shares = lengths[order], counts[order] / counts.max()
    shares /= shares.sum()
    by_share = np.sort(shares)
    light = np.searchsorted(np.cumsum(by_share), _NOTHING * float(shares @ shares))
    heavy = shares >= by_share[light]
    return lengths[heavy], shares[heavy] / shares[heavy].sum()


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


def _groups(x: Array, shares: Array) -> list[tuple[Array, Array]]:
    """Samples (distinct, sorted) and shares of each group, separated where a gap is far wider than those around it."""
    place = np.arange(_LEAST_GROUP, x.size - _LEAST_GROUP + 1)
    if not place.size:
        return [(x, shares)]
    many = max(int(np.sqrt(x.size)), _LEAST_GROUP)
    low, high = np.maximum(place - 1 - many, 0), np.minimum(place + many, x.size - 1)
    below = (x[place - 1] - x[low]) / (place - 1 - low)
    above = (x[high] - x[place]) / (high - place)
    wider = (x[place] - x[place - 1]) / np.maximum(below, above)
    if wider.max() < _GAP + np.log(x.size):
        return [(x, shares)]
    cut = int(place[wider.argmax()])
    return _groups(x[:cut], shares[:cut]) + _groups(x[cut:], shares[cut:])


class Sampled(Mixture):
    """A smooth law through samples, with their exact values as atoms.

    log P_c is m log x + a polynomial, of largest penalised likelihood (origins/samples/likelihood.py). The likelihood
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
        values, shares, counts = distinct(ordered, shares)
        atom = exact(values, counts) if known is None else np.isin(values, known)
        if (~atom).sum() == 1:  # its width cannot be estimated
            atom[:] = True
        laws: list[Thresholds] = [identical(float(value)) for value in values[atom]]
        weights = shares[atom]
        self.smooth_part: Thresholds | None = None
        if not atom.all():
            groups = _groups(values[~atom], shares[~atom])
            own = np.array([share.sum() for _, share in groups])
            found = [
                smooth(x, share / share.sum(), effective_samples * float(share.sum()))
                for x, share in groups
            ]
            self.smooth_part = found[0] if len(found) == 1 else Mixture(found, own / own.sum())
            laws += found
            weights = np.append(weights, own)
        super().__init__(laws, weights / weights.sum())
        self.samples, self.shares = values, shares
        self.onset_power_error = 0.0
        if self.smooth_part is not None and self.smooth_part.support()[0] == self.support()[0]:
            # a group above a gap reaches down to 0 as well, with negligible weight: the first one counts
            self.onset_power = found[0].onset_power
            self.onset_power_error = found[0].onset_power_error
        up_to, steps = self.cdf(values), np.cumsum(shares)
        below = up_to.copy()
        below[atom] -= self.atoms[1]
        self.cdf_misfit = float(max((steps - up_to).max(), (below - steps + shares).max()))
        self.beyond = float(below[0]), float(self.sf(values[-1]))
