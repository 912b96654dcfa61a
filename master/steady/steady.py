"""Smooth sliding: the state that no longer depends on X (paper Eqs. Q11a-Q11d)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.lives.make import steady_life
from master.motion.motion import Motion
from master.outcome import WELL, judged
from master.renewal.births import births_of
from master.steady.travel import NONE, Travel
from origins import Contacts, InputError
from origins.contacts import LAWS, check_contacts
from origins.errors import positive
from origins.start import Start
from origins.thresholds.quadrature import gauss

if TYPE_CHECKING:
    from master.paper.q15_steady import AgeingSteadyState

Array = npt.NDArray[np.float64]

# Relative round-off of closed moments, and of integrals of the survival.
MOMENTS, SUMS = 4e-16, 1e-13
# Lives with heat leave out the strongest thresholds, those of a smaller survival than this.
RAREST = 1e-30
# Panels on which the density of stretches is averaged over the stretches of re-forming.
PANELS = 12


class Cycle(NamedTuple):
    """Averages over the life of a contact, from its birth to its break.

    length, length_error : C, the travel of the slider in between (a length)
    area, area_error : the integral of the force over that travel (a length squared)
    """

    length: float
    length_error: float
    area: float
    area_error: float

    def force(self, wait: float) -> tuple[float, float]:
        """F_k/(N_c <k>) and its error, lengths, where contacts are out for the travel `wait`."""
        whole = self.length + wait
        force = self.area / whole
        return force, (self.area_error + abs(force) * self.length_error) / whole


@dataclass(frozen=True)
class SteadyState:
    """Steady sliding, whatever the start.

    Attributes
    ----------
    force : float
        F_k/(N_c <k>), a length. Where contacts form again at once and relaxed, and all are equally
        stiff, it is <x_b^2>/(2 <x_b>); x_b is the stretch at which a contact breaks, x_s at T = 0.
    force_error : float
        Its error in units of the mean threshold.
    holding : float
        Fraction of the contacts that hold, C/(C + v tau).
    mean_threshold : float
        <x_s>, a length.
    cycle_length : float
        C, the mean travel of the slider between a contact's birth and its break.
    cycle_length_error : float
        Its error in units of the mean threshold.
    success : bool
        Whether the relative error of the force is at most 1e-3.
    message : str
        The accuracy reached.
    """

    force: float
    force_error: float
    holding: float
    mean_threshold: float
    cycle_length: float
    cycle_length_error: float
    success: bool
    message: str
    _life: Life = field(repr=False)
    _births: Start = field(repr=False)
    _velocity: float = field(repr=False)

    def distribution(self, x: npt.ArrayLike) -> Array:
        """Q_s(x) per length at stretches x (paper, Eq. Q11a), of all contacts; same shape as x."""
        x = np.asarray(x, dtype=float)
        at, births, reach = x.ravel(), self._births, self._life.reach
        out = np.zeros(at.size)
        if births.is_single:
            reached = np.flatnonzero(at >= births.mean())
            if reached.size:
                out[reached] = self._held(np.full((1, 1), births.mean()), at[reached, None])[:, 0]
        else:
            low, high = (float(np.clip(end, -reach, reach)) for end in births.span)
            reached = np.flatnonzero(at > low)
            if reached.size:
                out[reached] = self._averaged(at[reached], low, high)
                out[reached] /= births.cdf(high) - births.cdf(low)
        return (out * self.holding / self.cycle_length).reshape(x.shape)[()]

    def _averaged(self, x: Array, low: float, high: float) -> Array:
        """Share that holds at x, shape (n,), of contacts born at stretches from low to high."""
        bends = self._life.bends
        fixed = np.concatenate([self._births.breakpoints, [0.0], bends, -bends])
        fixed = np.append(np.linspace(low, high, PANELS + 1), fixed)
        cuts = np.append(np.tile(fixed, (x.size, 1)), -np.abs(x)[:, None], axis=1)
        cuts = np.sort(np.clip(cuts, low, np.minimum(x, high)[:, None]), axis=1)
        born, weights = gauss(cuts[:, :-1], cuts[:, 1:])
        at = np.broadcast_to(x[:, None, None], born.shape)
        rows = -1, born.shape[-1]
        held = self._held(born.reshape(rows), at.reshape(rows)).reshape(born.shape)
        return np.asarray((weights * self._births.pdf(born) * held).sum(axis=(1, 2)))

    def _held(self, born: Array, x: Array) -> Array:
        """Share of contacts born at stretches that hold at x >= these; shape (rows, columns)."""
        way = x - born
        far = max(float(way.max()), self.mean_threshold)
        motion = Motion(np.array([0.0, far / self._velocity]), np.array([0.0, far]))
        history = motion.history(way / self._velocity, np.zeros((1, 1)))
        return np.asarray(self._life.left(born, history)[0])


def steady_state(contacts: Contacts, *, velocity: float = 1.0) -> SteadyState | AgeingSteadyState:
    """Kinetic force and stretches in steady sliding (paper, Eqs. Q10, Q11c and Q11d).

    Parameters
    ----------
    contacts : Contacts
        With any laws; the start does not matter. The paper's closure of ageing is solved only
        without other laws.
    velocity : float
        v > 0, length per time; it matters only with rates of breaking, ageing, grains or delay.

    Raises InputError where <x_s^2>, with linked stiffness <x_s^3>, is infinite: then the force
    grows for ever and there is no steady state; and where contacts break at once.
    """
    check_contacts(contacts, "master.steady_state", LAWS, own_rates=True)
    velocity = positive("velocity", velocity)
    if contacts.ageing is not None and contacts.ageing.closure == "paper":
        from master.paper.q15_steady import check_alone, paper_steady_state

        check_alone(contacts)
        return paper_steady_state(contacts.thresholds, contacts.ageing, velocity)
    check_finite(contacts)
    life = steady_life(contacts, velocity)
    cycle = cycle_of(contacts, Travel(life, births_of(contacts), velocity))
    wait, unit = velocity * contacts.waiting_time, contacts.mean_threshold
    force, off = cycle.force(wait)
    success, message = judged("F_k", off / max(abs(force), WELL * unit), WELL)
    return SteadyState(
        force=force,
        force_error=off / unit,
        holding=cycle.length / (cycle.length + wait),
        mean_threshold=unit,
        cycle_length=cycle.length,
        cycle_length_error=cycle.length_error / unit,
        success=bool(success),
        message=message,
        _life=life,
        _births=births_of(contacts),
        _velocity=velocity,
    )


def check_finite(contacts: Contacts) -> None:
    """Raise InputError where the kinetic force is infinite.

    Heat does not help, as strong contacts hardly break before their threshold. Thresholds that
    diffuse or grow are exempt: the tail of the initial ones does not last, or they have a largest.
    """
    if contacts.ageing is not None or contacts.grains is not None:
        return
    power = _power(contacts)
    if not np.isfinite(contacts.thresholds.moment(power)):
        raise InputError(
            f"thresholds: <x_s^{power}> is infinite, and with it the kinetic force: the force "
            f"grows for ever; use a law whose tail falls faster than x^-{power + 1}"
        )


def cycle_of(contacts: Contacts, travel: Travel) -> Cycle:
    """Averages over a life: at T = 0 closed moments of the thresholds, else integrals of E and K."""
    far_length, far_area = _beyond(contacts, travel)
    length, area = travel.length, travel.area
    if not {"grains", "thermal", "ageing", "reforming"}.intersection(contacts.laws):
        # the difference between the closed moments and the integrals counts as an error
        law, power = contacts.thresholds, _power(contacts)
        length = law.mean()
        area = 0.5 * law.moment(power) / length ** (power - 2)
        length_off = abs(length - travel.length) + MOMENTS * length
        return Cycle(length, length_off, area, abs(area - travel.area) + MOMENTS * area)
    length_off = travel.length_error + far_length + SUMS * length
    return Cycle(length, length_off, area, travel.area_error + far_area + SUMS * abs(area))


def _power(contacts: Contacts) -> int:
    """The order of the moment of the thresholds in the kinetic force."""
    return 3 if contacts.stiffness == "linked" else 2


def _beyond(contacts: Contacts, travel: Travel) -> tuple[float, float]:
    """Bounds on the contributions of stretches beyond the table to C and to the area (heavy tails).

    No contact holds beyond its threshold; the tail is taken as a power, fitted at the table's end.
    """
    if contacts.ageing is not None or contacts.grains is not None:
        return 0.0, 0.0  # the errors of the tables include contacts that hold at their ends
    law, power, far = contacts.thresholds, _power(contacts), travel.far
    if contacts.thermal is not None:  # E itself leaves out stronger thresholds
        far = max(far, float(law.isf(RAREST)))
    held, twice = float(law.sf(far)), float(law.sf(2.0 * far))
    weight = (far / contacts.mean_threshold) ** (power - 2)
    if not held * weight * (far / travel.typical) ** 2 > NONE:
        return 0.0, 0.0
    steep = float(np.log2(held / twice)) if twice > 0.0 else np.inf
    if not steep > power:
        return np.inf, np.inf
    return held * far / (steep - 1.0), held * weight * far**2 / (steep - power)
