"""Smooth laws that keep the mean of their samples."""

from dataclasses import replace

import numpy as np

from origins.samples.likelihood import Ends
from origins.samples.logspline import Fit
from origins.samples.smoothed import Smoothed, Variable
from origins.samples.spline import Spline

_STEP = 0.25  # of the knots that follow e^y
_TRIALS = 60
_MEAN = 1e-9


def with_mean(mean: float, law: Smoothed, fit: Fit, variable: Variable, ends: Ends) -> Smoothed:
    """`law`, which `fit` stands for, if it has that mean to 1e-9, else the law nearest to it that has (Kullback and
    Leibler): its density times e^{tilt x}.

    The likeliest law has the samples' mean of y, which is not x where it is bent, and not even that where it has the
    longest tail that it may have, or where samples next to 0 do not count for the power.
    """
    miss = law.mean() / mean - 1.0
    if abs(miss) < _MEAN:
        return law
    extremes, onset_error = law.extremes, law.onset_power_error
    fine = knots = fit.spline.knots
    if variable.bent:
        parts = np.maximum(np.ceil(np.diff(knots) / _STEP), 1.0).astype(int)
        pairs = zip(knots[:-1], knots[1:], parts, strict=True)
        fine = np.append(np.concatenate([np.linspace(a, b, part, endpoint=False) for a, b, part in pairs]), knots[-1])
    shape = variable.inverse(fine) - variable.origin
    heights, shape = fit.spline(fine), shape / shape[-1]
    steepest = Spline(fine, shape).slopes[1]
    fall = ends.bent - fit.spline.slopes[1] - (fit.power / knots[-1] if fit.power else 0.0)

    def off(tilt: float) -> float:
        nonlocal law
        spline = Spline(fine, heights + tilt * shape)
        law = Smoothed(replace(fit, spline=spline), variable, ends, extremes, onset_error)
        return law.mean() / mean - 1.0

    # the tail must fall; how far the tilt may have to go down nobody knows
    low, high = 0.0, 0.0
    below = above = miss
    for _ in range(_TRIALS):
        if below <= 0.0 <= above:
            break
        if above < 0.0:
            low, below = high, above
            high = 0.5 * (high + fall / steepest) if ends.open_above else 2.0 * high + 0.1
            above = off(high)
        else:
            high, above = low, below
            low = 2.0 * low - 0.1
            below = off(low)
    for step in range(_TRIALS):
        if abs(miss) < _MEAN or not below <= 0.0 <= above or low == high:
            break
        # regula falsi, Illinois' rule
        tilt = (low * above - high * below) / (above - below)
        last, miss = miss, off(tilt)
        if miss < 0.0:
            low, below = tilt, miss
            above *= 0.5 if last < 0.0 and step else 1.0
        else:
            high, above = tilt, miss
            below *= 0.5 if last > 0.0 and step else 1.0
    return law
