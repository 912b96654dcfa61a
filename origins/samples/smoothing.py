"""From samples to smooth laws: how the density begins and ends, and where it has gaps."""

from dataclasses import dataclass, replace

import numpy as np

from origins.samples.gaps import DOUBTFUL, FEW, SURE, cut_off, widest_gap
from origins.samples.likelihood import Ends
from origins.samples.logspline import Fit, cost, fit
from origins.samples.smoothed import Smoothed, Variable
from origins.samples.spline import Spline
from origins.samples.tilting import with_mean
from origins.thresholds.gaussian import gaussian
from origins.thresholds.law import Array, Thresholds

# penalty of an edge, a gap or a density that diverges at 0, in log-likelihood, beyond that of a parameter
_EDGE = 3.0
_SUSPECT = 1.5  # expected number of samples beyond the extreme one, above which an edge is tried there
_FAR, _FARTHEST = 8.0, 1000.0  # times the median: samples beyond may be, or are, thresholds of many decades
_STANDS_OUT, _OBVIOUS = 10.0, 100.0  # width of a gap beyond the log of the number of samples, and for sure
_DEEPEST = 12
_FAR_OFF = 2.0  # sampling errors of <x^2>/2<x>, from where on a law has not the shape of its samples
# largest standard deviation of the Gaussian of a value beyond a gap, relative to that value and to the gap
_OF_VALUE, _OF_GAP = 0.125, 0.15


@dataclass(frozen=True)
class Piece:
    """A law, the share of the weight that is its own, and the score of all pieces together."""

    law: Thresholds
    share: float
    score: float


@dataclass(frozen=True)
class _Choice:
    variable: Variable
    ends: Ends
    fit: Fit
    score: float


def smooth(x: Array, shares: Array, counts: Array, size: float, depth: int = 0) -> list[Piece]:
    """Smooth laws, one for each side of every gap, sorted by place.

    x : samples, distinct and sorted, at least 2; shares : weight of each, of sum 1; counts : how often each value
    occurs; size : the effective number of samples. Fewer than five values beyond a gap get a narrow Gaussian each.
    """
    place, beyond = cut_off(x, counts, FEW - 1) if depth < _DEEPEST else (0, 0)
    if place:
        return _with_strays(x, shares, counts, size, depth, place, above=place == x.size - beyond)
    gap, width = widest_gap(x) if depth < _DEEPEST else (0, 0.0)
    whole: list[Piece] = []
    if width < _OBVIOUS:
        whole = [_one_piece(x, shares, size)]
        bent = depth < _DEEPEST and _off(whole[0].law, x, shares, size) > _FAR_OFF
        if bent or width < _STANDS_OUT + np.log(x.size):
            # a group as wide as the gap before it
            most, chance = int(np.sqrt(counts.sum() / counts.min())), DOUBTFUL if bent else SURE
            gap, beyond = cut_off(x, counts, most, chance) if depth < _DEEPEST else (0, 0)
            if not gap:
                return whole
            if beyond < FEW:
                return _with_strays(x, shares, counts, size, depth, gap, above=gap == x.size - beyond)
            whole = [] if bent else whole
    pieces: list[Piece] = []
    score = -cost(size) - _EDGE
    for side in (slice(None, gap), slice(gap, None)):
        share = float(shares[side].sum())
        found = smooth(x[side], shares[side] / share, counts[side], size * share, depth + 1)
        score += size * share * float(np.log(share)) + found[0].score
        pieces += [replace(piece, share=share * piece.share) for piece in found]
    if whole and whole[0].score >= score:
        return whole
    return [replace(piece, score=score) for piece in pieces]


def _off(law: Thresholds, x: Array, shares: Array, size: float) -> float:
    """Difference between the kinetic force <x²>/2<x> of the law and of the samples, in standard errors."""
    mean = float(shares @ x)
    each = x * (x / (2.0 * mean))
    force = float(shares @ each)
    error = float(np.sqrt(shares @ (each - force * x / mean) ** 2 / size))
    return abs(law.moment(2) / (2.0 * law.mean()) - force) / error


def _with_strays(
    x: Array, shares: Array, counts: Array, size: float, depth: int, place: int, above: bool
) -> list[Piece]:
    """Laws through the samples before a gap, and a Gaussian for each of the few values beyond it.

    Each Gaussian has the coefficient of variation of the group next to it: there is no other information on its width.
    """
    main, strays = (slice(None, place), slice(place, None)) if above else (slice(place, None), slice(None, place))
    share = float(shares[main].sum())
    found = smooth(x[main], shares[main] / share, counts[main], size * share, depth + 1)
    score = found[0].score + size * share * float(np.log(share))
    found = [replace(piece, share=share * piece.share) for piece in found]
    beside = found[-1 if above else 0].law
    relative = min(beside.std() / beside.mean(), _OF_VALUE)
    gap = float(x[place] - x[place - 1])
    kernels = []
    for value, own in zip(x[strays].tolist(), shares[strays].tolist(), strict=True):
        law = gaussian(value, min(relative * value, _OF_GAP * gap))
        score += size * own * float(np.log(own) + law.logpdf(value)) - cost(size)
        kernels.append(Piece(law, own, 0.0))
    return [replace(piece, score=score) for piece in (found + kernels if above else kernels + found)]


def _one_piece(x: Array, shares: Array, size: float) -> Piece:
    """The law of largest score among those that begin and end one way or another."""
    extremes = float(x[0]), float(x[-1])
    reach = extremes[1] - extremes[0]
    if x.size == 2:
        return _between_two(extremes, float(shares[1]), size)
    median = float(x[np.searchsorted(np.cumsum(shares), 0.5)])
    plain, bent = Variable(0.0, reach, False), Variable(0.0, median, True)
    variables = [plain] if x[-1] < _FAR * median else [plain, bent] if x[-1] < _FARTHEST * median else [bent]
    # samples far from 0 tell nothing of a power there
    tried = [
        _try(x, shares, size, variable, Ends(from_zero=True, power=power, open_above=True, bent=float(variable.bent)))
        for variable in variables
        for power in ((False, True) if x[0] < reach else (False,))
    ]
    best = max(tried, key=_score)
    if best.fit.beyond[0] * size > _SUSPECT:
        variable = replace(best.variable, origin=extremes[0])
        tried.append(_try(x, shares, size, variable, replace(best.ends, from_zero=False, power=False)))
        best = max(tried, key=_score)
    if best.fit.beyond[1] * size > _SUSPECT:
        best = max(best, _try(x, shares, size, best.variable, replace(best.ends, open_above=False)), key=_score)
    piece = _piece(x, shares, size, best, _onset_error(best, tried))
    straight = [choice for choice in tried if not choice.variable.bent]
    if best.variable.bent and straight and piece.score < (best := max(straight, key=_score)).score:
        return _piece(x, shares, size, best, _onset_error(best, straight))
    return piece


def _piece(x: Array, shares: Array, size: float, choice: _Choice, onset_error: float) -> Piece:
    """The law of a choice, with the samples' mean."""
    law = Smoothed(choice.fit, choice.variable, choice.ends, (float(x[0]), float(x[-1])), onset_error)
    found = with_mean(float(shares @ x), law, choice.fit, choice.variable, choice.ends)
    if found is law:
        return Piece(law, 1.0, choice.score)
    return Piece(found, 1.0, choice.score + size * float(shares @ (found.logpdf(x) - law.logpdf(x))))


def _between_two(ends: tuple[float, float], upper: float, size: float) -> Piece:
    """An exponential density from one value to the other, the upper of which has the share `upper`: of all densities
    there with that mean the one that says least."""
    share = min(upper, 1.0 - upper)
    # 1/slope - 1/(e^slope - 1), the mean of e^(-slope y) over (0, 1), falls in the slope from 1/2 to 0
    low, high = 0.0, 2.0 / share
    for _ in range(100):
        slope = 0.5 * (low + high)
        mean = 1.0 / slope - np.exp(-slope) / -np.expm1(-slope) if slope > 1e-4 else 0.5 - slope / 12.0
        low, high = (slope, high) if mean > share else (low, slope)
    slope = -slope if upper < 0.5 else slope
    height = max(slope, 0.0) + float(np.log(-np.expm1(-abs(slope)) / abs(slope))) if slope else 0.0
    spline = Spline(np.array([0.0, 1.0]), np.array([0.0, slope]) - height)
    variable = Variable(ends[0], ends[1] - ends[0], False)
    between = Ends(from_zero=False, power=False, open_above=False, bent=0.0)
    score = size * (slope * upper - height - float(np.log(variable.scale))) - 3.0 * cost(size) - 2.0 * _EDGE
    found = Fit(spline, 0.0, 0.0, score, (0.0, 0.0), spline.knots)
    return Piece(Smoothed(found, variable, between, ends, np.inf), 1.0, score)


def _onset_error(best: _Choice, tried: list[_Choice]) -> float:
    """How well the power at x = 0 is known: by how much it would differ, were one fitted, and the error of that."""
    if best.ends.power:
        return best.fit.power_error
    rivals = [choice for choice in tried if choice.ends.power] if best.ends.from_zero else []
    rival = max(rivals, key=_score, default=None)
    return np.inf if rival is None else abs(rival.fit.power) + rival.fit.power_error


def _try(x: Array, shares: Array, size: float, variable: Variable, ends: Ends) -> _Choice:
    found = fit(variable(x), shares, size, ends)
    edges = int(not ends.from_zero) + int(not ends.open_above)
    asked = edges * (cost(size) + _EDGE)
    if found.power < 0.0:
        asked += _EDGE if _piled_up(x, shares) else np.inf
    score = found.score + size * float(shares @ variable.log_slope(x)) - asked
    return _Choice(variable, ends, found, score)


def _piled_up(x: Array, shares: Array) -> bool:
    """Whether the lowest tenth of the samples, ten at least, lies closer to 0 than evenly: half of it in the lower half
    of its reach."""
    below = np.cumsum(shares)
    share = max(0.1, 10.0 * float(shares.mean()))
    middle, reach = x[np.minimum(np.searchsorted(below, [0.5 * share, share]), x.size - 1)]
    return bool(2.0 * middle < reach)


def _score(choice: _Choice) -> float:
    return choice.score

