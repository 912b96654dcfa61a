"""A force to measure errors against: the closed form where there is one, else the master equation as far as it goes."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

from origins.contacts import Contacts
from origins.start import GaussianStart
from origins.thresholds.gaussian import CutGaussian

Array = npt.NDArray[np.float64]

_TOLERANCES = (1e-9, 1e-10, 1e-11, 1e-12)
_NEGLIGIBLE = 1e-16
_ROUND_OFF = 2.0**-53
_ROOT_TWO_PI = np.sqrt(2.0 * np.pi)


@dataclass(frozen=True)
class Reference:
    """F(X) on a path, to be compared with.

    force : F/(N_c <k>), shape (n,), a length.
    error : its own largest error, in units of the mean threshold; a bound for the closed form, else the solver's claim.
    source : where it comes from, in words.
    """

    force: Array
    error: float
    source: str


def reference(contacts: Contacts, path: npt.ArrayLike) -> Reference:
    """The best force there is, at positions `path` (lengths, shape (n,)); InputError where there is none."""
    positions = np.asarray(path, dtype=float)
    exact = closed_form(contacts, positions)
    if exact is not None:
        return exact
    import master

    best = None
    for at in _TOLERANCES:
        solved = master.solve(contacts, positions, tolerance=at)
        if best is None or solved.force_error < best.error:
            source = f"the master equation itself at tolerance {at:.0e}"
            best = Reference(solved.force, float(solved.force_error), source)
        if not solved.success:
            break  # beyond what round-off allows, asking for more gives less
    assert best is not None
    return best


def closed_form(contacts: Contacts, path: Array) -> Reference | None:
    """Gaussian thresholds from one stretch or a Gaussian of them; None for others, and where weight is cut at 0.

    With thresholds of mean m and width s, and starts of mean x_0 and width s_0, the n-th break of a contact comes at
    X_n, normal with mean n m - x_0 and variance n s^2 + s_0^2, and then the n-th threshold is released, so that
    F = x_0 + X - sum over n of E[threshold n; X_n < X].
    """
    thresholds, start = contacts.thresholds, contacts.start
    if not isinstance(thresholds, CutGaussian):
        return None
    if not (start.is_single or isinstance(start, GaussianStart)):
        return None
    mean, width, first = thresholds.parent_mean, thresholds.parent_std, start.mean()
    spread = 0.0 if start.is_single else 1.0 / (_ROOT_TWO_PI * float(start.pdf(first)))
    narrowest = float(np.hypot(width, spread))
    reach = float(path[-1]) + abs(first) + mean
    cut = float(ndtr(-mean / width))
    cut_at_start = float(ndtr((first - mean) / narrowest) + ndtr((-first - mean) / narrowest))
    # a contact that the cut concerns, in any generation, is off by at most the way it went
    if mean <= 0.0 or (cut_at_start + (reach / mean + 1.0) * cut) * reach > _NEGLIGIBLE * mean:
        return None
    force, count = first + path, 0
    while True:
        count += 1
        scatter = np.sqrt(count * width**2 + spread**2)
        z = (path - count * mean + first) / scatter
        force -= mean * ndtr(z) - width**2 / scatter * np.exp(-0.5 * z * z) / _ROOT_TWO_PI
        if z[-1] < -10.0:
            break
    # each term is rounded, and its argument is, which tells more the narrower the laws
    error = float(_ROUND_OFF * (count + 4.0 + mean / narrowest) * reach / mean)
    return Reference(force, error, "the closed form for Gaussian thresholds")
