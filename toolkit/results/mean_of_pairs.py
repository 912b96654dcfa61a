"""The mean of numbers that may go up and down in turn, as short slips follow long ones."""

from typing import NamedTuple

import scipy  # imports its parts when they are first used

from origins.thresholds.law import Array

# Probability that a normal number is below its mean and one standard deviation.
ONE_SIGMA = 0.8413


class Mean(NamedTuple):
    """A mean, and its standard error."""

    value: float
    error: float


def mean_of_pairs(values: Array) -> Mean:
    """Mean of an even number of values in order, with an error by how the means of pairs differ: that of values that go
    up and down in turn is exact. Of one pair the two values tell. Few differ by chance by little: the error is as much
    larger than theirs as Student's t of ONE_SIGMA."""
    pairs = values.reshape(-1, 2).mean(axis=1) if values.size > 2 else values
    student = float(scipy.special.stdtrit(pairs.size - 1, ONE_SIGMA))
    return Mean(float(values.mean()), student * float(pairs.std(ddof=1)) / pairs.size**0.5)
