"""Contacts whose thresholds grow with their age, as coalescing grains do (paper, Sec. VI).

Each contact keeps its quantile for life. It breaks where the cumulative hazard H(|x|; age) of the law
of thresholds at its age reaches that of its quantile, so that of the contacts that pinned together

    share that holds = exp(-(H_worst - H_0)),      H_worst = the largest H since the birth,

H_0 being H at t = 0 of contacts that are stretched then. On a straight leg H first falls, while the
contact relaxes or its threshold outgrows the stretch, and then rises: it is largest at an end.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.averages import Pieces, integrals
from master.lives.life import Life
from master.motion.motion import History, Legs
from origins import Contacts, GrainContact
from origins.grains.lifshitz_slyozov import hazard_beyond
from origins.start import Start
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# H above which the survival e^-H, below 1e-17, counts as 0.
GONE = 39.2


class GrainLife(Life):
    """Life (see master.lives.life) of contacts with growing grains, without heat.

    Parameters
    ----------
    contacts : Contacts
        With `grains`.
    longest : float
        The latest time > 0 at which `left` is called.

    Contacts born with the law `contacts.start`, the same object, are those of t = 0 and have the
    grains' starting age; all others pin at birth, at the stretch 0 and the age tau_m.
    """

    error = 5e-14  # the share's error by that of the hazards
    # first number of pieces of a start, and last coefficients below which they are not halved
    pieces, resolved = 8, 1e-12

    def __init__(self, contacts: Contacts, longest: float) -> None:
        grains = contacts.grains
        assert grains is not None and grains.age is not None
        self.grains: GrainContact = grains
        self.start = contacts.start
        self.start_since = grains.age - grains.growth.first_pinning_time
        self.reach = float(grains.quantile(-np.expm1(-GONE), grains.age + longest))
        # no contact of the start is stretched beyond the largest threshold at t = 0
        self.start_reach = grains.at_start.support()[1]
        self.grain = 0.25 * grains.at_start.std()

    def left(self, born: Start | Array, history: History) -> Array:
        """Share of contacts that hold, and their force per contact born; see Life.left."""
        return self._told(born, history.legs())

    def _told(self, born: Start | Array, legs: Legs) -> Array:
        """Share and force, shape (2, rows, columns)."""
        shape, knots = legs.displacement.shape[:-1], legs.displacement.shape[-1]
        moves = Legs(
            legs.displacement.reshape(-1, knots), legs.duration.reshape(-1, knots - 1), legs.speed
        )
        every = np.arange(moves.displacement.shape[0])
        if isinstance(born, Start) and born is self.start and not born.is_single:
            return self._of_spread(moves).reshape(2, *shape)
        since, lost, nodes = self.start_since, np.zeros(1), np.zeros((every.size, 1))
        if not isinstance(born, Start) and np.any(born):
            nodes = np.broadcast_to(born, shape).reshape(-1, 1)
        elif born is not self.start:  # births are at 0
            since, lost = 0.0, np.broadcast_to(self._lost(legs), shape).ravel()
        else:
            nodes = np.full(nodes.shape, self.start.mean())
        return self._holding(every, nodes, moves, since, lost).reshape(2, *shape)

    def _of_spread(self, moves: Legs) -> Array:
        """Share and force of the start; the share has a kink where another moment has the largest H."""
        start, count = self.start, moves.displacement.shape[0]
        edges = np.concatenate(
            [np.linspace(*start.span, self.pieces + 1), start.breakpoints, [0.0]]
        )
        edges = np.clip(edges, *np.clip(start.span, -self.start_reach, self.start_reach))
        edges = np.unique(edges)
        row, low = np.divmod(np.arange(count * (edges.size - 1)), edges.size - 1)

        def weighed(row: Rows, nodes: Array) -> Array:
            density = finite_density(start, nodes)
            found = self._holding(row, nodes, moves, self.start_since, np.zeros(1))
            return np.concatenate([density * found, density[None]])

        found = integrals(weighed, Pieces(row, edges[low], edges[low + 1]), count, self.resolved)
        # only some of the sums are measured
        self.error = max(self.error, 2.0 * float(found.missed[0]))
        return found.value[:2] / found.value[2]

    def _holding(self, row: Rows, nodes: Array, moves: Legs, since: float, lost: Array) -> Array:
        """Share and force of contacts born at `nodes` (n, k), with the moves of the rows (n,).

        since : time between pinning and the moves; lost : lower bound of H_worst, from birth
        """
        stretch = nodes[..., None] + moves.displacement[row][:, None]
        stretch = stretch.reshape(-1, stretch.shape[-1])
        own = Legs(stretch, np.repeat(moves.duration[row], nodes.shape[1], axis=0), moves.speed)
        elapsed = np.cumsum(own.duration, axis=-1)
        times = since + np.concatenate([np.zeros((elapsed.shape[0], 1)), elapsed], axis=-1)
        hazards = pinned_hazard(self.grains, stretch, times)
        # contacts with |x| above the largest threshold at t = 0 never hold
        met = ~np.isfinite(hazards[:, 0])
        before = np.where(met, 0.0, hazards[:, 0])
        worst = np.where(met, np.inf, np.maximum(hazards.max(axis=-1), lost))
        hold = self._share(own, since, worst, before)
        return np.stack([hold, hold * stretch[:, -1]]).reshape(2, *nodes.shape)

    def _share(self, moves: Legs, since: float, worst: Array, before: Array) -> Array:
        """Share that holds of contacts with these moves (their stretches), array (n,).

        since : time between pinning and the first of them
        worst, before : arrays (n,), H_worst and H_0
        """
        return np.exp(before - worst)

    def _lost(self, legs: Legs) -> Array:
        """H_worst right after pinning: some contacts are stretched faster than their thresholds grow.

        Array of shape (rows, 1): all births of a row lie on one leg.
        """
        rows, columns = legs.duration.shape[:2]
        lived = legs.duration[:, columns // 2] > 0.0
        birth = np.where(lived.any(axis=-1), np.argmax(lived, axis=-1), legs.speed.size - 1)
        hazard = [self.grains.lost_hazard(abs(float(speed))) for speed in legs.speed]
        return np.array(hazard)[birth].reshape(rows, 1)


def pinned_hazard(grains: GrainContact, stretch: Array, since: Array) -> Array:
    """-ln of the fraction of contacts with thresholds above |stretch|, `since` after they pinned.

    GrainContact.hazard as a function of the time since pinning, so that no digits are lost right after
    it. Stretches (lengths) and times broadcast; infinite where no threshold is as large.
    """
    stretch, since = np.broadcast_arrays(stretch, since)
    excess = np.expm1(np.log1p(since / grains.growth.first_pinning_time) / 3.0)
    scaled = np.sqrt(grains.growth.B) * np.abs(stretch)
    over = scaled * (scaled / (1.0 + np.hypot(1.0, scaled)))  # of the grain that breaks
    room = excess - over
    out = np.where(over > 0.0, np.inf, 0.0)
    held = (room > 0.0) & (over > 0.0)
    largest = 1.0 + excess[held]
    q = over[held] / excess[held] * (largest / room[held])
    out[held] = hazard_beyond(q, 1.0 / largest, excess[held] / largest)
    return out
