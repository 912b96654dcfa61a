"""The choice of the ends of a smooth law through samples: the most likely of a few forms."""

from dataclasses import replace

import numpy as np

from origins.errors import InputError
from origins.samples.likelihood import Likelihood, cost
from origins.samples.log_polynomial import Form, LogPolynomial
from origins.thresholds.law import Array

_EDGE = 3.0  # gain in log-likelihood that an edge, or a density diverging at 0, needs beyond a parameter's cost
_SUSPECT = 1.5  # samples expected beyond the extreme one, above which an edge is tried there
_FAR = 8.0  # medians: with samples beyond it a law over decades is tried too
_NEAR_ZERO = 1.0 / 3.0  # of the median: a power x^m is tried only with samples below it
# Allowed errors of a law: of its mean, in standard errors, and of its cdf, beyond the sampling error (1.36/n^(1/2)).
_MEAN, _MISPLACED = 0.1, 0.1


def smooth(x: Array, shares: Array, size: float) -> LogPolynomial:
    """The law of largest score among a few forms of its two ends.

    x : samples (lengths), distinct and sorted, at least 2; shares : weight of each, of sum 1; size : the effective
    number. Raises InputError where none of the laws follows the samples.
    """
    unit, piled_up = float(x[np.searchsorted(np.cumsum(shares), 0.5)]), _piled_up(x, shares)

    def fitted(form: Form) -> LogPolynomial:
        with np.errstate(all="ignore"):  # coefficients that overflow are rejected
            found = Likelihood(x, shares, size, unit, form).best()
        edges = int(not form.from_zero) + int(not form.open_above)
        found.score -= edges * (cost(size) + _EDGE)
        if found.onset_power < 0.0:
            found.score -= _EDGE if piled_up else np.inf
        return found

    forms = [
        Form(power=power, decades=decades)
        for decades in ((False, True) if x[-1] > _FAR * unit else (False,))
        for power in ((False, True) if x[0] < _NEAR_ZERO * unit else (False,))
    ]
    # two values: a straight line from one to the other
    between = [Form(from_zero=False, open_above=False)]
    tried = [fitted(form) for form in (forms if x.size > 2 else between)]
    best = max(tried, key=lambda one: one.score)
    if best.beyond[0] * size > _SUSPECT:
        tried.append(fitted(replace(best.form, from_zero=False, power=False)))
        best = max(tried, key=lambda one: one.score)
    if best.beyond[1] * size > _SUSPECT:
        tried.append(fitted(replace(best.form, open_above=False)))
    # where no power is fitted, the error of m is the size of the one that would be, plus its error
    rivals = [abs(one.onset_power) + one.onset_power_error for one in tried if one.form.power]
    for law in sorted(tried, key=lambda one: -one.score):
        if _follows(law, x, shares, size):
            if law.form.from_zero and not law.form.power:
                law.onset_power_error = min(rivals, default=np.inf)
            return law
    rule = (
        "are groups or peaks that one smooth density does not follow; give each apart, in a mixture"
    )
    raise InputError(f"from_samples: among the samples from {x[0]:g} to {x[-1]:g} {rule}")


def _follows(law: LogPolynomial, x: Array, shares: Array, size: float) -> bool:
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


def _piled_up(x: Array, shares: Array) -> bool:
    """Whether the lowest tenth of the samples (at least ten) accumulates at 0: half of it is below half of its
    reach."""
    below = np.cumsum(shares)
    share = max(0.1, 10.0 * float(shares.mean()))
    middle, reach = x[np.minimum(np.searchsorted(below, [0.5 * share, share]), x.size - 1)]
    return bool(2.0 * middle < reach)
