"""From samples to smooth laws: how the density begins and ends, and where it has gaps."""

from dataclasses import dataclass, replace

import numpy as np

from origins.likelihood import Ends
from origins.logspline import Fit, cost, fit
from origins.smoothed import Smoothed, Variable
from origins.thresholds import Array

# an edge, a gap and a density that diverges at 0 must be worth this much more of the log-likelihood than a number
_EDGE = 3.0
_SUSPECT = 1.5  # samples that the law expects beyond the extreme one, from where on an edge there is tried
_FAR, _FARTHEST = 8.0, 1000.0  # times the median: samples beyond may be, or are, thresholds of many decades
_FEWEST = 5  # distinct samples to either side of a gap
_STANDS_OUT, _OBVIOUS = 10.0, 100.0  # width of a gap beyond the log of the number of samples, and for sure
_DEEPEST = 12


@dataclass(frozen=True)
class Piece:
    """A law, the share of the weight that is its own, and the score of all pieces together."""

    law: Smoothed
    share: float
    score: float


@dataclass(frozen=True)
class _Choice:
    variable: Variable
    ends: Ends
    fit: Fit
    score: float


def smooth(x: Array, shares: Array, size: float, depth: int = 0) -> list[Piece]:
    """Smooth laws, one for each side of every gap, through samples x (distinct, sorted, at least 2) that count by
    `shares` (sum 1) and are worth `size` samples."""
    gap, width = _widest_gap(x) if depth < _DEEPEST else (0, 0.0)
    whole: list[Piece] = []
    if width < _OBVIOUS:
        whole = [_one_piece(x, shares, size)]
        if width < _STANDS_OUT + np.log(x.size):
            return whole
    pieces: list[Piece] = []
    score = -cost(size) - _EDGE
    for side in (slice(None, gap), slice(gap, None)):
        share = float(shares[side].sum())
        found = smooth(x[side], shares[side] / share, size * share, depth + 1)
        score += size * share * float(np.log(share)) + found[0].score
        pieces += [replace(piece, share=share * piece.share) for piece in found]
    if whole and whole[0].score >= score:
        return whole
    return [replace(piece, score=score) for piece in pieces]


def _one_piece(x: Array, shares: Array, size: float) -> Piece:
    """The law of largest score among those that begin and end one way or another."""
    extremes = float(x[0]), float(x[-1])
    reach = extremes[1] - extremes[0]
    if x.size == 2:
        edges = Ends(from_zero=False, power=False, open_above=False, bent=0.0)
        choice = _try(x, shares, size, Variable(extremes[0], reach, False), edges)
        return Piece(Smoothed(choice.fit, choice.variable, choice.ends, extremes, np.inf), 1.0, choice.score)
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
    return Piece(Smoothed(best.fit, best.variable, best.ends, extremes, _onset_error(best, tried)), 1.0, best.score)


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
    asked = edges * (cost(size) + _EDGE) + (_EDGE if found.power < 0.0 else 0.0)
    score = found.score + size * float(shares @ variable.log_slope(x)) - asked
    return _Choice(variable, ends, found, score)


def _score(choice: _Choice) -> float:
    return choice.score


def _widest_gap(x: Array) -> tuple[int, float]:
    """The gap that is widest beside the samples to either side of it: the place of the first sample above it, and its
    width in units of their mean distance."""
    if x.size < 2 * _FEWEST:
        return 0, 0.0
    place = np.arange(_FEWEST, x.size - _FEWEST + 1)
    many = max(int(np.sqrt(x.size)), _FEWEST)
    low, high = np.maximum(place - 1 - many, 0), np.minimum(place + many, x.size - 1)
    beside = np.maximum((x[place - 1] - x[low]) / (place - 1 - low), (x[high] - x[place]) / (high - place))
    ratio = (x[place] - x[place - 1]) / beside
    best = int(ratio.argmax())
    return int(place[best]), float(ratio[best])
