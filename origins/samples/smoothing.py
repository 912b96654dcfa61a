"""The choice of the ends of a smooth law through samples: the most likely of a few forms."""

from dataclasses import replace

import numpy as np

from origins.errors import InputError
from origins.samples.likelihood import Fit, Likelihood, cost
from origins.samples.log_polynomial import Form, LogPolynomial
from origins.thresholds.law import Array, Thresholds

_EDGE = 3.0  # gain in log-likelihood that an edge, or a density diverging at 0, needs beyond a parameter's cost
_SUSPECT = 1.5  # samples expected beyond the extreme one, above which an edge is tried there
_FAR = 8.0  # medians: with samples beyond it a law over decades is tried too
_NEAR_ZERO = 1.0 / 3.0  # of the median: a power x^m is tried only with samples below it
# Allowed errors of a law: of its mean, in standard errors, and of its cdf, beyond the sampling error (1.36/n^(1/2)).
_MEAN, _MISPLACED = 0.1, 0.1


def smooth(x: Array, shares: Array, size: float) -> LogPolynomial:
    """The law of largest score among a few forms of its two ends.

    x : samples, distinct and sorted, at least 2; shares : weight of each, of sum 1; size : the effective number.
    Raises InputError where none of the laws follows the samples.
    """
    samples, unit = x, float(x[np.searchsorted(np.cumsum(shares), 0.5)])
    extremes = float(x[0]), float(x[-1])
    x = x / unit
    piled_up = _piled_up(x, shares)

    def fitted(form: Form) -> Fit:
        with np.errstate(all="ignore"):  # coefficients that overflow are rejected
            found = Likelihood(x, shares, size, form).best()
        edges = int(not form.from_zero) + int(not form.open_above)
        asked = edges * (cost(size) + _EDGE)
        if found.power < 0.0:
            asked += _EDGE if piled_up else np.inf
        return replace(found, score=found.score - asked)

    forms = [
        Form(power=power, decades=decades)
        for decades in ((False, True) if x[-1] > _FAR else (False,))
        for power in ((False, True) if x[0] < _NEAR_ZERO else (False,))
    ]
    # two values: a straight line from one to the other
    between = [Form(from_zero=False, open_above=False)]
    tried = [fitted(form) for form in (forms if x.size > 2 else between)]
    best = max(tried, key=lambda one: one.score)
    if best.beyond[0] * size > _SUSPECT:
        tried.append(fitted(replace(best.columns.form, from_zero=False, power=False)))
        best = max(tried, key=lambda one: one.score)
    if best.beyond[1] * size > _SUSPECT:
        tried.append(fitted(replace(best.columns.form, open_above=False)))
    for one in sorted(tried, key=lambda one: -one.score):
        error = _onset_error(one, tried)
        law = LogPolynomial(one.columns, one.coefficients, unit, extremes, error)
        if _follows(law, samples, shares, size):
            return law
    ends = f"{extremes[0]:g} to {extremes[1]:g}"
    rule = (
        "are groups or peaks that one smooth density does not follow; give each apart, in a mixture"
    )
    raise InputError(f"from_samples: among the samples from {ends} {rule}")


def _follows(law: Thresholds, x: Array, shares: Array, size: float) -> bool:
    """Whether the law has the samples' mean and cdf, the latter up to a tenth beyond the sampling error.

    It may not: the integrals of the likelihood may miss a peak between far samples, or no polynomial follows a peak.
    """
    mean = float(shares @ x)
    error = float(np.sqrt(shares @ (x - mean) ** 2 / size))
    halfway = np.cumsum(shares) - 0.5 * shares
    try:
        misplaced = float(np.abs(law.cdf(x) - halfway).max())
    except InputError:  # too rough for any use
        return False
    return abs(law.mean() - mean) < _MEAN * error and misplaced < _MISPLACED + 1.36 / np.sqrt(size)


def _onset_error(best: Fit, tried: list[Fit]) -> float:
    """Error of m; where no power is fitted, the size of the one that would be, plus its error."""
    if best.columns.form.power or not best.columns.form.from_zero:
        return best.power_error
    rivals = [abs(one.power) + one.power_error for one in tried if one.columns.form.power]
    return min(rivals, default=np.inf)


def _piled_up(x: Array, shares: Array) -> bool:
    """Whether the lowest tenth of the samples (at least ten) accumulates at 0: half of it is below half of its
    reach."""
    below = np.cumsum(shares)
    share = max(0.1, 10.0 * float(shares.mean()))
    middle, reach = x[np.minimum(np.searchsorted(below, [0.5 * share, share]), x.size - 1)]
    return bool(2.0 * middle < reach)
