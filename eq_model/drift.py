"""How a threshold diffuses in one step, and where a bridge between two of them meets the stretch.

Lengths are in units of the lattice.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare
from eq_model.streams import uniform

_F = np.float64
_FAR = 8.0  # standard deviations that a threshold does not diffuse in a step
_OF_THE_GAP = 0.15  # between stretch and upper end of the final law, a step's standard deviation
_FELT = 0.25  # standard deviations of a step closer to an end than which no drift is felt


class Ageing(NamedTuple):
    """Diffusion of thresholds, towards a normal law or one whose drift is tabled (ageing_tables)."""

    normal: bool
    mean: float
    width: float
    relaxing: float  # per time
    diffusion: float  # squared units per time
    first: float  # of the table's places
    step: float
    values: npt.NDArray[np.float64]
    slopes: npt.NDArray[np.float64]
    shares: npt.NDArray[np.float64]  # of the longest step, squared standard deviations
    low: float  # ends of the final law, and of the table
    high: float
    near: float
    far: float
    longest: float  # time of a step near the stretch that a threshold must not meet
    coarse: float  # how much coarser than need be other steps are
    warm: bool  # whether contacts break at rates besides
    rates: Any
    unit: float  # a length

    def coarser(self, times: float) -> "Ageing":
        """With steps so many times longer."""
        # the integral of a rate is of fourth order in the change of its logarithm
        return self._replace(longest=times * self.longest, coarse=times**0.25)


@bare
def normal(a, b, c):  # type: ignore[no-untyped-def]
    """A draw of the standard normal law from three words."""
    return np.sqrt(-2.0 * np.log(uniform(a, b))) * np.cos(2.0 * np.pi * (_F(c) + 0.5) * 2.0**-32)


@bare
def _hermite(place, values, slopes, step):  # type: ignore[no-untyped-def]
    """A tabled function between its nodes, from its values and slopes there."""
    k = min(max(int(place), 0), values.size - 2)
    t = place - k
    rise = values[k + 1] - values[k]
    p, q = slopes[k] * step - rise, slopes[k + 1] * step - rise
    return values[k] + t * (rise + (1.0 - t) * (p - t * (p + q)))


@bare
def _over(below, above):  # type: ignore[no-untyped-def]
    """Where a threshold is in the tables, by its distance from the law's ends."""
    return np.log(below / above) if above < np.inf else np.log(below)


@bare
def drift(y, ageing):  # type: ignore[no-untyped-def]
    """Mean change of a threshold per time, over D, towards a law that is not normal."""
    y = min(max(y, ageing.near), ageing.far)
    below, above = y - ageing.low, ageing.high - y
    place = (_over(below, above) - ageing.first) / ageing.step
    slope = _hermite(place, ageing.values, ageing.slopes, ageing.step)
    return slope * (1.0 / below + 1.0 / above)


@bare
def local_step(y, here, speed, ageing):  # type: ignore[no-untyped-def]
    """The time of a step from a threshold y; the stretch |x| = here grows with `speed`."""
    low, high, shares = ageing.low, ageing.high, ageing.shares
    y = min(max(y, ageing.near), ageing.far)
    place = (_over(y - low, high - y) - ageing.first) / ageing.step
    k = min(max(int(place), 0), shares.size - 2)
    part = min(max(place - k, 0.0), 1.0)
    time = ageing.longest * (shares[k] + part * (shares[k + 1] - shares[k]))
    if high < np.inf and here >= low:
        # a threshold meets the stretch or the wall in one step, not both
        gap = max(high - here, 1.0)
        time = min(time, (_OF_THE_GAP * gap) ** 2 / (2.0 * ageing.diffusion))
        if speed > 0.0:
            time = min(time, 0.5 * gap / speed)
    return time


@bare
def moved(y, time, normal, uniform, walled, ageing):  # type: ignore[no-untyped-def]
    """A threshold a time later, towards a law that is not normal: by Heun's step, of second order in the mean.

    A step that comes to the final law's upper end, or to its lower one where that is above the stretch (walled), is
    reflected by how far it went beyond, exact but for the change of the drift; how far a Brownian bridge tells.
    """
    diffusion, low, high = ageing.diffusion, ageing.low, ageing.high
    spread = np.sqrt(2.0 * diffusion * time)
    # closer to an end than this no drift is felt through a step
    least, most = low + _FELT * spread, high - _FELT * spread
    slope = drift(min(max(y, least), most), ageing)
    guess = low + abs(y + diffusion * time * slope + spread * normal - low)
    if high < np.inf:
        guess = high - abs(high - guess)
    there = drift(min(max(guess, least), most), ageing)
    later = y + 0.5 * diffusion * time * (slope + there) + spread * normal
    if walled and y - low <= high - y:
        lowest = 0.5 * (
            y + later - np.sqrt((later - y) ** 2 - 2.0 * spread * spread * np.log(uniform))
        )
        later += max(low - lowest, 0.0)
    elif high < np.inf:
        highest = 0.5 * (
            y + later + np.sqrt((later - y) ** 2 - 2.0 * spread * spread * np.log(uniform))
        )
        later -= max(highest - high, 0.0)
    return min(max(later, low), high) if walled else min(later, high)


@bare
def safe_step(gap, y, x, speed, ageing):  # type: ignore[no-untyped-def]
    """A time within which a threshold y does not come down to a stretch |x| that grows with `speed`."""
    if not ageing.normal:
        return 0.0
    # what is above the mean may come down to it
    gap = min(y, max(ageing.mean, 0.0)) - x
    if gap <= 0.0:
        return 0.0
    spread = _FAR * np.sqrt(2.0 * ageing.diffusion)
    root = 2.0 * gap / (spread + np.sqrt(spread * spread + 4.0 * speed * gap))
    return root * root


@bare
def first_meeting(above, below, spread, normal, uniform):  # type: ignore[no-untyped-def]
    """Part of a step after which a Brownian bridge from `above` zero first meets it, when it does.

    I/(1 + I), I of the inverse Gaussian law of mean above/|below| and shape above²/spread², spread² the variance of
    the step without ends.
    """
    if above <= 0.0:
        return 0.0
    if below == 0.0:
        return 1.0
    mean, shape = above / abs(below), (above / spread) ** 2
    w = 0.5 * mean * normal * normal / shape
    first = mean / (1.0 + w + np.sqrt(w * (2.0 + w)))
    if uniform * (mean + first) > mean:
        first = mean * (mean / first)
    return first / (1.0 + first)
