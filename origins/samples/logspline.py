"""Logspline density estimation: the log of a density as a cubic spline with few knots, by maximum likelihood.

C. Kooperberg and C. J. Stone, Comput. Stat. Data Anal. 12, 327 (1991); knots are added and deleted one by one as in
C. J. Stone, M. H. Hansen, C. Kooperberg and Y. K. Truong, Ann. Stat. 25, 1371 (1997). A power may stand before the
exponential, like the logarithmic terms of C. Kooperberg, C. J. Stone and Y. K. Truong, J. Am. Stat. Assoc. 90, 78
(1995): gamma, Gaussian and Rayleigh laws are among the simplest members of y^m exp(spline(y)).
"""

from dataclasses import dataclass

import numpy as np

from origins.samples.likelihood import Ends, Likelihood, Model
from origins.samples.spline import Spline, bends, cardinals
from origins.thresholds.law import Array

_MOST_KNOTS = 40
_PATIENCE = 3  # knots added in vain before the search for more ends


@dataclass(frozen=True)
class Fit:
    """The model chosen: log-density = power * log y + spline(y), up to the constant that normalises it.

    joints : knots of the spline that may be seen in its derivatives.
    power_error is the error of the power, score the log-likelihood less what the coefficients cost, `beyond` the weight
    below the first sample and above the last.
    """

    spline: Spline
    power: float
    power_error: float
    score: float
    beyond: tuple[float, float]
    joints: Array


def cost(size: float) -> float:
    """Penalty per fitted parameter, in units of log-likelihood: log(size)/2 (Schwarz, BIC) for few samples, and 2,
    twice Akaike's, from 55 samples on. A larger one would leave biases of many standard errors in large samples."""
    return min(0.5 * float(np.log(size)), 2.0)


def fit(y: Array, shares: Array, size: float, ends: Ends) -> Fit:
    """The logspline through samples at y (distinct, sorted, at least 2) with `shares` (sum 1), worth `size` samples."""
    return _Search(Likelihood(y, shares, size, ends)).best()


class _Search:
    """The model of largest score on the way up, knot by knot, and down again."""

    def __init__(self, likelihood: Likelihood) -> None:
        self._likelihood, self._knots = likelihood, likelihood.knots
        self._most = int(min(4.0 * likelihood.size**0.25, _MOST_KNOTS, self._knots.size))
        # a kink of its own at each candidate, at the nodes and at the candidates
        self._unit = float(self._knots[-1] - self._knots[0])
        self._kinks = (np.maximum(likelihood.nodes[:, None] - self._knots, 0.0) / self._unit) ** 3
        self._at_knots = (np.maximum(self._knots[:, None] - self._knots, 0.0) / self._unit) ** 3

    def best(self) -> Fit:
        last = self._knots.size - 1
        straight = self._likelihood.straight()
        models = [] if straight is None else [straight]
        if last > 1:
            kept = np.array([0, (last + 1) // 2, last])
            models.append(self._likelihood.maximise(kept, *(self._heights(model, kept) for model in models)))
            models += self._grown(models[-1])
            while models[-1].kept.size > 3:
                models.append(self._without_least(models[-1]))
        return self._fit(max(models, key=self._score), models)

    def _grown(self, model: Model) -> list[Model]:
        """Models with one knot more each, until some in turn have gained nothing."""
        models: list[Model] = []
        best, vain = self._score(model), 0
        while model.kept.size < self._most and vain < _PATIENCE:
            place = self._most_wanted(model)
            if place is None:
                break
            kept = np.sort(np.append(model.kept, place))
            model = self._likelihood.maximise(kept, self._heights(model, kept))
            models.append(model)
            vain = 0 if self._score(model) > best else vain + 1
            best = max(best, self._score(model))
        return models

    def _score(self, model: Model) -> float:
        # the heights count but for their common constant; from the fourth knot on a place is chosen as well
        count = model.coefficients.size - 1
        size = self._likelihood.size
        return size * model.value - count * cost(size) - max(model.kept.size - 3, 0)

    def _fit(self, best: Model, models: list[Model]) -> Fit:
        spline = Spline(self._knots[best.kept], best.coefficients[: best.kept.size])
        joints = spline.knots
        inner, tail = np.split(best.density, [self._likelihood.nodes.size])
        beyond = float(inner[self._likelihood.nodes < self._knots[0]].sum()), float(tail.sum())
        if not self._likelihood.ends.power:
            return Fit(spline, 0.0, 0.0, self._score(best), beyond, joints)
        power, error = float(best.coefficients[-1]), self._power_error(best, models)
        return Fit(spline, power, error, self._score(best), beyond, joints)

    def _power_error(self, best: Model, models: list[Model]) -> float:
        """Error of the power within all models, each as likely as Akaike's criterion has it: what the spline takes on
        itself near y = 0 differs from one to the other."""
        size = self._likelihood.size
        likely = np.array([size * model.value - model.coefficients.size for model in models])
        weights = np.exp(likely - likely.max())
        squares = []
        for model in models:
            variance = model.solve(np.append(np.zeros(model.kept.size), 1.0))[-1] / size
            squares.append(variance + (model.coefficients[-1] - best.coefficients[-1]) ** 2)
        return float(np.sqrt(weights @ squares / weights.sum()))

    def _heights(self, model: Model, kept: Array) -> Array:
        """Coefficients of the same density with further knots."""
        count = model.kept.size
        heights = cardinals(self._knots[model.kept], self._knots[kept]) @ model.coefficients[:count]
        return np.append(heights, model.coefficients[count:])

    def _most_wanted(self, model: Model) -> int | None:
        """The candidate that promises the largest gain as a knot (Rao's score test)."""
        knots, last = self._knots, model.kept[-2]
        # each kink is taken back at the last inner knot: beyond that the spline is a parabola
        at_knots = self._at_knots - self._at_knots[:, last, None]
        slopes = 3.0 * ((knots[-1] - knots) ** 2 - (knots[-1] - knots[last]) ** 2) / self._unit**3
        kinked = np.concatenate([self._kinks - self._kinks[:, last, None], at_knots[-1] + np.outer(model.tail, slopes)])
        expected = model.density @ kinked
        kinked -= expected
        cross = (model.away * model.density[:, None]).T @ kinked
        kinked *= kinked
        whole = model.density @ kinked
        rest = whole - np.einsum("ij,ij->j", cross, model.solve(cross))
        new = rest > 1e-9 * whole
        new[model.kept] = new[-2:] = False
        gain = np.where(new, (self._likelihood.mean @ at_knots - expected) ** 2 / np.where(new, rest, 1.0), 0.0)
        best = int(gain.argmax())
        return best if gain[best] > 0.0 else None

    def _without_least(self, model: Model) -> Model:
        """The model without the inner knot whose kink tells least (Wald's test)."""
        knots, count = self._knots[model.kept], model.kept.size
        kinks = np.zeros((count - 2, model.coefficients.size))
        kinks[:, :count] = np.diff(np.diff(bends(knots), axis=0) / np.diff(knots)[:, None], axis=0)
        spread = model.solve(kinks.T)
        size = kinks @ model.coefficients
        variance = np.einsum("ij,ji->i", kinks, spread)
        least = int((size**2 / variance).argmin())
        straight = model.coefficients - spread[:, least] * size[least] / variance[least]
        # the straightened density may not fall at its ends; with one height left out it is close by as well
        starts = (np.delete(part, least + 1) for part in (straight, model.coefficients))
        return self._likelihood.maximise(np.delete(model.kept, least + 1), *starts)
