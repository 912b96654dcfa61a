"""Sliding that a delay makes unstable: how fast swings of a slider with mass grow, and how large they get.

At the speed V a share τ V/(<x_s> + τ V) of the contacts waits, so that friction falls with the speed, first by
g = F_k τ/<x_s>. Under a damping γ < g swings about steady sliding at the drive's speed v grow, in half a period by the
factor G, until the slider stops in each; contacts hold it then until the spring bears F_k again, from where it sets out
with (g - γ) v more than balances that speed. With s = (g - γ)/(2 M) and w² = K/M

    G = e^(π s/(w² - s²)^½),    the spring's force falls by (g - γ) v (1 + G) in each swing,

as long as it passes many thresholds, and the fall is small beside F_k; for s >= w it is a slip.
"""

from typing import NamedTuple

import numpy as np

from master.soft.inertia.body import QUIET
from master.soft.inertia.short_delay import SOFT, UNSTEADY
from origins import Contacts
from origins.drive import RISE, Drive

# Growth in half a swing above which errors of panels decide what is seen: each swing begins with one of them, and ends
# that much larger.
FAST_GROWTH = 3.0
# Least tolerance, in mean thresholds, that is asked for on their account: finer panels end in volleys of breaks.
FINEST = 1e-4


class GrowingSwings(NamedTuple):
    """Of sliding at the drive's last speed, which is unstable.

    falls : g, by which friction falls with the speed, above the damping; damping : γ (times, per N_c<k>)
    excess : (g - γ) v, with which a swing begins (a length); growth : G, inf where it does not turn
    steady : whether a swing passes so many thresholds that friction is that of steady sliding all along
    unit : mean threshold (a length)
    """

    falls: float
    damping: float
    excess: float
    growth: float
    steady: bool
    unit: float

    @property
    def fall(self) -> float:
        """Of the spring's force in a swing, about (a length)."""
        return self.excess * (1.0 + self.growth)

    def coarsest(self, tolerance: float) -> float:
        """The largest tolerance (mean thresholds) up to this one at which panels miss less than what swings begin with.

        At larger ones swings are those of errors, ten times too large and none like the next, and must be followed to
        the path's end. True ones below a slip are alike, and soon told by their middle (`delayed/small_swings.py`).
        """
        fine = self.excess / self.unit / QUIET
        known = self.steady and self.growth >= FAST_GROWTH and self.fall <= RISE * self.unit
        return min(tolerance, fine) if known and fine >= FINEST else tolerance

    @property
    def message(self) -> str:
        """What is said of a run that was stopped; "" where sliding does not swing, but sticks and slips."""
        if not np.isfinite(self.growth):
            return ""
        large = (
            f" by some {self.fall / self.unit:.1e} mean thresholds of force" if self.steady else ""
        )
        return (
            f"sliding swings{large}, as contacts that wait out their "
            f"delay do not hold: friction falls with the speed by {self.falls:.4g}, and the damping is "
            f"{self.damping:.4g}; with a larger one it would not, if the machine has that; else end the path sooner"
        )


def growing_swings(contacts: Contacts, drive: Drive) -> GrowingSwings | None:
    """None where swings do not grow."""
    spring, mass = float(drive.spring or 0.0), float(drive.mass or 0.0)
    unit, delay, speed = contacts.mean_threshold, contacts.waiting_time, _last_speed(drive)
    falls = delay * 0.5 * contacts.thresholds.moment(2) / (unit + delay * speed) ** 2
    if falls <= drive.damping or not speed:
        return None
    grows, swings = 0.5 * (falls - drive.damping) / mass, np.sqrt(spring / mass)
    growth = np.inf
    if grows < swings:
        with np.errstate(over="ignore"):
            growth = float(np.exp(np.pi * grows / np.sqrt(swings**2 - grows**2)))
    excess = (falls - drive.damping) * speed
    steady = spring <= SOFT and bool(excess * (1.0 + growth) >= UNSTEADY * unit * spring)
    return GrowingSwings(falls, drive.damping, excess, growth, steady, unit)


def _last_speed(drive: Drive) -> float:
    """At which the drive ends, 0 if it rests."""
    times = drive.arrival_times(0.0)[-2:]
    distance = abs(float(np.diff(drive.path, prepend=0.0)[-1]))
    lasts = float(np.diff(times, prepend=0.0)[-1])
    return distance / lasts if lasts > 0.0 else 0.0
