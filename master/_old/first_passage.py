"""Contacts that age, each by itself: how far they get before their stretch meets their threshold.

In steady forward motion a contact born at x = 0 breaks where its stretch x = v t first meets its threshold, which
diffuses towards the final law meanwhile. The survival E(x) is all that the renewal equation needs: as a law of
thresholds it makes contacts that age into contacts that do not.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master._old.diffusion_passage import DiffusionPassage, Hazard, diffusion_passage
from master._old.effective_law import EffectiveLaw
from master._old.ornstein_passage import OrnsteinPassage
from master._old.piecewise import Piecewise
from origins import Ageing, InputError, Thresholds
from origins.errors import finite, positive
from origins.laws.breaking_rate import BreakingRate
from origins.thresholds.scipy_laws import as_thresholds

Array = npt.NDArray[np.float64]

_ROUND_OFF = 1e-14
_SPENT = 1e-12
_NO_THRESHOLD = 1e-300
_AT_REST = 1e-28
_FINEST = 1e-10  # of the diffusion equation: beyond, steps grow in number and rounding comes through
_PER_PANEL = 1e-2  # of the accuracy, for each panel of the integral equation
_PANELS = 1e-13, 1e-10
_NODES = 16
_X, _W = legendre.leggauss(_NODES)
_T = 0.5 * (_X + 1.0)
_PROJECT = ((np.arange(_NODES) + 0.5)[:, None] * legendre.legvander(_X, _NODES - 1).T) * _W
_LEAST = 4  # ends of steps in a fit
_TERMS = 8  # of ln E between steps: values and slopes at four ends


@dataclass(frozen=True)
class FirstPassage:
    """Breaks of contacts that age while they are stretched at one speed.

    Attributes
    ----------
    law : Thresholds
        Of the advance s at which a contact breaks: survival E(s), density p(s) = -E'(s). From start = 0 the advance is
        the stretch.
    error : float
        Estimate of the error of the survival, at any s.
    """

    law: Thresholds
    error: float

    def kinetic_force(self) -> tuple[float, float]:
        """F_k/(N_c <k>) = integral of s E over that of E, for contacts born at 0, and its error (lengths)."""
        mean, square = self.law.mean(), self.law.moment(2)
        if not np.isfinite(square):
            raise InputError("thresholds: <x_s^2> is infinite, and the kinetic force; use a law with a shorter tail")
        force = 0.5 * square / mean
        reach = float(self.law.isf(1e-9))
        return force, (self.error * (0.5 * reach**2 + force * reach) + _ROUND_OFF * square) / mean


def first_passage(
    fresh: object,
    ageing: Ageing,
    velocity: float = 1.0,
    start: float = 0.0,
    accuracy: float = 1e-8,
    thermal: BreakingRate | None = None,
) -> FirstPassage:
    """First meeting of the stretch start + v t with a threshold that is fresh at t = 0 and above |start|.

    Parameters
    ----------
    fresh : Thresholds or frozen scipy.stats distribution on x >= 0
        P_ci, of the thresholds at t = 0, conditional on |start|.
    ageing : Ageing
        P_cf and D. For a Gaussian final law by an integral equation, at any D; for any other by the diffusion
        equation.
    velocity : float
        v > 0, a length per time.
    start : float
        Stretch at t = 0; from below 0 it comes to 0 first.
    accuracy : float
        Error of the survival that is aimed at; corners of either law may not allow it.
    thermal : BreakingRate, optional
        Rate of breaking before they meet, of the contact's threshold as it is then; by the diffusion equation.

    Raises InputError for thresholds that the final law does not cover, for a start beyond every threshold, and for
    exact single values in `fresh` unless the final law is Gaussian; and for a start below -a where the final law begins
    at a > 0.
    """
    law = as_thresholds(fresh)
    ageing.check_fresh(law)
    diffusion = ageing.rate / positive("velocity", velocity)
    start = finite("start", start)
    held = float(law.sf(abs(start)))
    if not held > 0.0:
        raise InputError(f"start = {start:g}: lies beyond every threshold; contacts there hold nothing")
    if 0.0 < ageing.final.support()[0] < -start:
        raise InputError(
            f"start = {start:g}: stretches come back across {ageing.final.support()[0]:g} from 0, where the final law "
            "begins, so that thresholds are met, left and met again: not solved here; begin above, or use the ensemble"
        )
    unit = law.mean()
    if start == 0.0 and diffusion <= _AT_REST * unit and thermal is None:
        return FirstPassage(law, 0.0)
    diffusion = max(diffusion, _AT_REST * unit)
    power = _onset_power(law, ageing.final) if start == 0.0 else np.inf
    if ageing.normal is None or thermal is not None:
        finest, hazard = max(0.3 * accuracy, _FINEST), None if thermal is None else _hazard(thermal, velocity)
        passage = diffusion_passage(law, ageing.final, diffusion, start, _SPENT, finest, hazard)
        found, lost = _from_steps(passage, power if thermal is None else min(power, 0.0))
        return FirstPassage(found, passage.error + lost)
    # all generations rest on the law from 0 on
    finest = float(np.clip(_PER_PANEL * accuracy, *_PANELS)) if start != 0.0 else _PANELS[0]
    normal = OrnsteinPassage(law, ageing.normal.mean, ageing.normal.std, diffusion, start, _SPENT, finest)
    series = normal.series()
    if not series.total > 0.0:
        raise InputError(
            f"ageing: contacts that hold at x = {start:g} have fresh thresholds far from the final law, mean "
            f"{ageing.normal.mean:g}, std {ageing.normal.std:g}, and their breaks are beyond floating point"
        )
    effective = EffectiveLaw(series, 0.0, True, normal.survival, normal.hazard, normal.slope, power)
    return FirstPassage(effective, normal.error + _ROUND_OFF)


def _hazard(thermal: BreakingRate, velocity: float) -> Hazard:
    """h/v."""

    def hazard(stretch: float, threshold: Array) -> Array:
        # none stand at the level itself
        return thermal.rate(stretch, np.maximum(threshold, max(stretch, _NO_THRESHOLD))) / velocity

    return hazard


def _onset_power(fresh: Thresholds, final: Thresholds) -> float:
    """Where P_ci ~ x^m from 0 on, a layer of width (D_X x)^(1/2) has broken by x: p ~ x^((m - 1)/2). Where P_cf begins
    as such a power above 0 thresholds have come to that end, as the same power, before they are met."""
    if final.support()[0] > 0.0:
        return 0.5 * (final.onset_power - 1.0)
    return 0.5 * (fresh.onset_power - 1.0) if fresh.support()[0] == 0.0 else np.inf


def _from_steps(passage: DiffusionPassage, onset_power: float) -> tuple[EffectiveLaw, float]:
    """The law from E and p at the steps' ends, ln E over s = t^(1/2) from four ends at a time, then a series; and what
    seems left at the last of them but does not break any more, which is rounding."""
    # past the first survival that rounding took below 0 there is nothing to tell
    spent = np.flatnonzero(~(passage.survival > 0.0))
    size = int(spent[0]) if spent.size else passage.survival.size
    t, survival, rate = passage.advance[:size], passage.survival[:size], passage.rate[:size]
    root = np.sqrt(t)
    density = []
    ends = [*(k for k in passage.roots if k < size - _LEAST), size - 1]
    for begin, end in pairwise(ends):
        part = slice(begin, end + 1)
        s, logarithm = np.sqrt(t[part] - t[begin]), np.log(survival[part])
        slope = -2.0 * s * rate[part] / survival[part]
        first = np.clip(np.arange(s.size - 1) - 1, 0, s.size - 4)
        around = first[:, None] + np.arange(4)
        left, right = s[around[:, :1]], s[around[:, -1:]]
        half = 0.5 * (right - left)
        at = (s[around] - left) / half - 1.0
        rows = np.concatenate([_powers(at), _slopes(at) / half[:, :, None]], axis=1)
        values = np.concatenate([logarithm[around], slope[around]], axis=1)
        local = np.linalg.solve(rows, values[:, :, None])[:, :, 0]
        nodes = root[part][:-1, None] + np.diff(root[part])[:, None] * _T
        own = nodes if begin == 0 else np.sqrt(np.maximum(nodes**2 - t[begin], _NO_THRESHOLD))
        at = (own - left) / half - 1.0
        inside = np.exp((_powers(at) * local[:, None]).sum(axis=-1))
        density.append(-inside * (_slopes(at) * local[:, None]).sum(axis=-1) / half * (nodes / own))
    far = np.ones((1, 1))
    fall = float((_slopes(far) @ local[-1]).item() / half[-1, 0])
    bend = float((_bends(far) @ local[-1]).item() / half[-1, 0] ** 2)
    # from derivatives over s to those over t = s^2
    hazard = -fall / (2.0 * s[-1])
    steeper = -(bend / (2.0 * s[-1]) - fall / (2.0 * s[-1] ** 2)) / (2.0 * s[-1])
    series = Piecewise(root, _PROJECT @ np.concatenate(density).T)
    rest = float(survival[-1])
    poles = t[ends[1:-1]]
    if hazard <= 0.0:
        return EffectiveLaw(series, passage.begins, onset_power=onset_power, poles=poles), rest
    return EffectiveLaw(series, passage.begins, True, rest, float(hazard), float(steeper), onset_power, poles), 0.0


def _powers(x: Array) -> Array:
    """Legendre polynomials at x, one axis more."""
    return np.asarray(legendre.legvander(x, _TERMS - 1), dtype=float)


def _slopes(x: Array) -> Array:
    """Their derivatives."""
    return _derivatives(x, 1)


def _bends(x: Array) -> Array:
    """Their second derivatives."""
    return _derivatives(x, 2)


def _derivatives(x: Array, order: int) -> Array:
    derived = legendre.legder(np.eye(_TERMS), order, axis=0)
    return np.asarray(legendre.legvander(x, derived.shape[0] - 1) @ derived, dtype=float)
