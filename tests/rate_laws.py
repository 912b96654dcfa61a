"""A rate law of a test's own, broken ones, and the check that every RateLaw must pass."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from origins import RateLaw

NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)
# panels of a way, halved towards both of its ends: roots at an end and steep rates there are seen
HALVED = 0.5 ** np.arange(1, 50)
EDGES = np.unique(np.concatenate([[0.0, 1.0], HALVED, 1.0 - HALVED[:30]]))
SHARES = np.array([0.0, 1e-6, 0.2, 0.5, 0.9, 0.999, 1.0])  # of the threshold
THRESHOLDS = np.array([0.3, 1.0, 4.0])
STIFFNESSES = np.array([0.5, 1.0, 3.0])


@dataclass(frozen=True)
class Tilted(RateLaw):
    """h = ω exp[-(1 - x/x_s)/α]: F_k falls by α F_k(∞) for each e-fold of a low speed."""

    alpha: float = 0.1
    omega: float = 1.0
    name = "tilted"

    @property
    def scale(self) -> float:
        return self.omega

    def log_rate(self, x, threshold, stiffness):
        return np.log(self.omega) - (1.0 - x / threshold) / self.alpha

    def log_passed(self, near, far, threshold, stiffness):
        length = self.alpha * threshold
        with np.errstate(divide="ignore"):
            rise = np.log(length * -np.expm1((near - far) / length))
        return self.log_rate(far, threshold, stiffness) + rise

    def reached(self, log_amount, near, threshold, stiffness):
        length = self.alpha * threshold
        log_share = log_amount - np.log(length) - self.log_rate(near, threshold, stiffness)
        return np.minimum(near + length * np.logaddexp(0.0, log_share), threshold)


class Loose:
    """The same without RateLaw as a base, and with all that it would inherit."""

    name, scale, vanishes_at_threshold, separable = "loose", 1.0, False, False

    def __init__(self) -> None:
        law = Tilted()
        self.log_rate, self.log_passed, self.reached = law.log_rate, law.log_passed, law.reached
        self.rate = law.rate


def log_integral(
    law: RateLaw, near: float, far: float, threshold: float, stiffness: float
) -> float:
    """ln of the integral of exp(log_rate), by Gauss-Legendre on halved panels."""
    width = np.diff(EDGES)[:, None]
    shares = (EDGES[:-1, None] + 0.5 * width * (NODES + 1.0)).ravel()
    weights = (0.5 * width * WEIGHTS).ravel() * (far - near)
    logs = law.log_rate(far - shares * (far - near), threshold, stiffness)
    most = float(np.max(logs))
    return most + float(np.log(weights @ np.exp(logs - most)))


def faults(law: Any) -> Iterator[str]:
    """All in which an object is no RateLaw; nothing for one that conforms."""
    if not isinstance(law, RateLaw):
        yield "is no RateLaw"
        return
    if not (isinstance(law.name, str) and law.name):
        yield "name"
    if not law.scale > 0.0:
        yield "scale"
    for threshold in THRESHOLDS:
        for stiffness in STIFFNESSES:
            yield from _faults_of_rates(law, threshold, stiffness)
            yield from _faults_of_integrals(law, threshold, stiffness)
            yield from _faults_of_inverses(law, threshold, stiffness)
    yield from _faults_of_shapes(law)


def _faults_of_rates(law: RateLaw, threshold: float, stiffness: float) -> Iterator[str]:
    x = threshold * SHARES
    log_rate = law.log_rate(x, threshold, stiffness)
    inside = x < threshold
    if np.isnan(log_rate).any() or not np.isfinite(log_rate[inside]).all():
        yield "log_rate is not finite below the threshold"
    if (log_rate > np.log(law.scale) + 1e-12).any():
        yield "a rate exceeds scale"
    if law.vanishes_at_threshold != np.isneginf(log_rate[-1]):
        yield "vanishes_at_threshold"
    with np.errstate(under="ignore"):
        rate = np.exp(log_rate)
    if not np.allclose(law.rate(x, threshold, stiffness), rate, rtol=1e-12, atol=0.0):
        yield "rate is not exp(log_rate)"


def _faults_of_integrals(law: RateLaw, threshold: float, stiffness: float) -> Iterator[str]:
    ways = [(near, far) for near in SHARES for far in SHARES if near < far]
    ways += [(share * (1.0 - 1e-7), share) for share in SHARES[1:-2]]
    for near, far in threshold * np.array(ways):
        told = float(law.log_passed(near, far, threshold, stiffness))
        exact = log_integral(law, near, far, threshold, stiffness)
        # a share of 1e-11, or the rounding of large logarithms
        if not abs(told - exact) < max(1e-11, 1e-14 * abs(exact)):
            yield f"log_passed from {near:g} to {far:g} of {threshold:g}"
    x = threshold * SHARES
    if not np.isneginf(law.log_passed(x, x, threshold, stiffness)).all():
        yield "log_passed of no way is not -inf"
    growing = law.log_passed(0.0, threshold * np.linspace(0.0, 1.0, 200), threshold, stiffness)
    if not (np.diff(growing) > 0.0).all():
        yield "log_passed does not grow"


def _faults_of_inverses(law: RateLaw, threshold: float, stiffness: float) -> Iterator[str]:
    for near in threshold * SHARES[:-1]:
        far = threshold * SHARES[threshold * SHARES > near]
        amount = law.log_passed(near, far, threshold, stiffness)
        found = law.reached(amount, near, threshold, stiffness)
        again = law.log_passed(near, found, threshold, stiffness)
        off = np.minimum(np.abs(found - far) / threshold, np.abs(again - amount))
        if not (off < 1e-12 * np.maximum(1.0, np.abs(amount))).all():
            yield f"reached from {near:g} of {threshold:g}"
        whole = amount[-1]
        many = whole + np.linspace(-20.0, 5.0, 251)
        found = law.reached(many, near, threshold, stiffness)
        if (found < near).any() or (found > threshold).any() or (np.diff(found) < 0.0).any():
            yield "reached does not grow from near to the threshold"
        if not (found[many > whole + 1e-9] == threshold).all():
            yield "reached is not the threshold where the amount is never spent"
        if not abs(law.reached(-np.inf, near, threshold, stiffness) - near) < 1e-12 * threshold:
            yield "reached is not near for nothing"


def _faults_of_shapes(law: RateLaw) -> Iterator[str]:
    """Columns of stretches with rows of thresholds and stiffnesses, against numbers one by one."""
    near, far = np.array([[0.0], [0.05], [0.1]]), np.array([[0.1], [0.2], [0.3]])
    calls = {
        "log_rate": (law.log_rate, (far,)),
        "rate": (law.rate, (far,)),
        "log_passed": (law.log_passed, (near, far)),
        "reached": (law.reached, (-2.0 - far, near)),
    }
    for name, (call, given) in calls.items():
        found = np.asarray(call(*given, THRESHOLDS, STIFFNESSES))
        if found.shape != (3, 3):
            yield f"{name}: shape {found.shape}"
            continue
        for i in range(3):
            for j in range(3):
                one = [float(array[i, 0]) for array in given]
                alone = call(*one, float(THRESHOLDS[j]), float(STIFFNESSES[j]))
                if np.ndim(alone) or not np.isclose(alone, found[i, j], rtol=1e-13, atol=0.0):
                    yield f"{name}: numbers and arrays differ"
