"""The variance that breaks too rare to be seen add to the force.

Where a handful of contacts or none has broken, the variance between contacts says nothing of the breaks that might
have been. At T = 0 its expected value is known there: so early, breaks are first breaks. Else, and wherever breaks
begin or come to an end, one contact might have broken that has not, or not have broken that has.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

_SEEN = 100  # breaks from which their own variance is good enough
_SOME = 10  # breaks from which their size is
_SELDOM = (
    0.1  # part of the contacts up to which breaks are first breaks, and do not depend on the start
)
_NEVER = 1e-9  # breaks that need not be thought of
_PANELS = 24
_LOOKS = 300


def unseen_variance(contacts: Contacts, path: Array, n: int) -> tuple[Array, int]:
    """Variance of one contact's stretch from first breaks, at each path point (length^2, shape (n_points,)), and at how
    many points it is known.

    Given, from above, where at most a tenth and fewer than 100 of n contacts are expected to have broken; 0 elsewhere.
    """
    stretches, weights = _start(contacts)
    last = _last_rare(contacts, path, stretches, weights, n)
    variance = np.zeros(path.size)
    if last:
        # a long path is looked at here and there, from above: the variance grows
        chosen = np.unique(np.linspace(0, last - 1, _LOOKS).astype(int))
        broken = _broken(contacts, path[chosen], stretches)
        # a break at x takes x^2; at most the stretch reached at the next path point
        reached = np.maximum(stretches[:, None] + path[chosen], 0.0)
        steps = np.diff(broken, axis=1, prepend=0.0)
        square, mean = (weights @ np.cumsum(steps * reached**power, axis=1) for power in (2, 1))
        known = np.where(n * (weights @ broken) > _NEVER, np.maximum(square - mean**2, 0.0), 0.0)
        variance[:last] = known[np.searchsorted(chosen, np.arange(last))]
    return variance, last


@dataclass(frozen=True)
class Seen:
    """What broke in each bin, in the order of the clock.

    points : shape (bins,), clock at the bins' ends. breaks : their number in each bin; squares : the sum of the squared
    forces that they took.
    """

    points: Array
    breaks: Array
    squares: Array


def unseen_break(
    seen: Seen, place: Places, n: int, present: Array, reached: Array, thermal: bool
) -> Array:
    """Variance of the force between n contacts from one break more or less than there were, at each path point.

    place : the bin of each path point. present : the mean square of the force of a contact, at each path point;
    reached : the largest there may be. Squares are in the unit of `present`.

    The break takes all that a contact may bear while there were fewer than 10. Later on a contact that holds longer
    than the others bears what the larger breaks so far took, and one that breaks before the others what contacts bear
    now: the less likely, the farther it is to the nearest break in comparison with how far that is from the hundredth.
    `thermal` breaks do not come to an end.
    """
    if n == 1:
        return np.full(place.size, np.inf)
    edges = np.concatenate([[0.0], seen.points])
    # breaks count by their squares: most are of contacts that bear little
    top = seen.squares.max() if (seen.squares > 0.0).any() else 1.0
    share = seen.squares / top
    fourth = share**2 / np.maximum(seen.breaks, 1.0)
    many, taken, weighed = (
        np.concatenate([[0.0], np.cumsum(each)]) for each in (seen.breaks, share, fourth)
    )
    last = place + 1
    so_far, at = many[last], edges[last]
    large = top * np.divide(
        weighed[last], taken[last], out=np.zeros(last.size), where=taken[last] > 0.0
    )
    # from the hundredth of the last breaks to the last one, from the next one to the hundredth after
    latest = edges[np.searchsorted(many, so_far)]
    back = latest - edges[np.maximum(np.searchsorted(many, so_far - _SEEN, side="right") - 1, 0)]
    following = edges[np.searchsorted(many, so_far, side="right") - 1]
    far = np.searchsorted(many, so_far + _SEEN)
    forth = np.where(far < many.size, edges[np.minimum(far, many.size - 1)] - following, np.inf)
    late, early = large, present
    if not thermal:
        late = np.exp(-(at - latest) / np.maximum(back, 1.0)) * large
        early = np.exp(-(following - at) / np.maximum(forth, 1.0)) * present
    return np.where(so_far < _SOME, reached**2, np.maximum(late, early)) / n


def _start(contacts: Contacts) -> tuple[Array, Array]:
    """Starting stretches and the weight of each."""
    start = contacts.start
    if start.is_single:
        return np.array([start.mean()]), np.ones(1)
    low, high = start.span
    edges = np.unique(np.concatenate([np.linspace(low, high, _PANELS + 1), start.breakpoints]))
    edges = edges[(edges >= low) & (edges <= high)]
    nodes, weights = gauss(edges[:-1], edges[1:])
    nodes, weights = nodes.ravel(), weights.ravel()
    density = np.nan_to_num(start.pdf(nodes), posinf=0.0)
    held = contacts.thresholds.sf(np.abs(nodes)) > 0.0
    return nodes[held], (weights * density)[held] / (weights * density)[held].sum()


def _broken(contacts: Contacts, path: Array, stretches: Array) -> Array:
    """Probability that a contact from each stretch has broken by each path point, shape (stretches, points)."""
    law, held = contacts.thresholds, np.abs(stretches)[:, None]
    reached = np.maximum(held, stretches[:, None] + path)
    survival = law.sf(held)
    # the larger tail loses no digits as a difference
    low, high = law.cdf(reached) - law.cdf(held), survival - law.sf(reached)
    return np.maximum(np.where(law.cdf(held) < 0.5, low, high), 0.0) / survival


def _last_rare(contacts: Contacts, path: Array, stretches: Array, weights: Array, n: int) -> int:
    """How many path points come before too many of n contacts are expected to have broken."""
    low, high = 0, path.size
    while low < high:
        middle = (low + high) // 2
        broken = float(weights @ _broken(contacts, path[middle : middle + 1], stretches)[:, 0])
        low, high = (middle + 1, high) if broken < min(_SEEN / n, _SELDOM) else (low, middle)
    return low
