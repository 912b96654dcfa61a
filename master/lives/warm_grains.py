"""Contacts with growing grains at a temperature: each keeps its quantile, and may break early.

A contact whose quantile has the hazard η has the threshold x_s(η; age) at each age. Of the contacts
born together the share

    integral over η > H_worst of e^{-(η - H_0)} e^{-A(η)},      A(η) = integral of h(|x|; x_s) dt,

still holds, with H_worst and H_0 as in master.lives.grains. h is largest at the ends of legs: right
after the birth, when thresholds are small, and where the stretch comes near the threshold.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, RectBivariateSpline
from scipy.sparse import csr_array

from master.lives.averages import Pieces, integrals
from master.lives.grains import GONE, GrainLife
from master.motion.motion import History, Legs
from origins import Contacts, GrainContact
from origins.grains.lifshitz_slyozov import invert_beyond
from origins.start import Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Sums over quantiles have the variable (η - H_worst)^(1/2): edges of their first pieces, and last
# coefficients below which pieces are not halved.
ROOTS, RESOLVED = np.array([0.0, 0.5, 2.0, GONE**0.5]), 1e-8
# Numbers of moments on a leg, tried in this order until the share changes by no more than the
# accuracy: colder contacts break within ever shorter parts of a leg.
MOMENTS = (51, 101, 201, 401)
# Factor on the measured change, as not all ages are measured.
MARGIN = 4.0
# Lower ends of the table of thresholds, in the logarithms of the hazard and of the time since pinning
# over tau_m (below them thresholds are powers of both), and its spacing, at which splines of degree
# DEGREE are accurate to 1e-11.
LEAST_HAZARD, LEAST_TIME, SPACING, DEGREE = -20.0, -16.0, 0.08, 5


class WarmGrainLife(GrainLife):
    """Life (see master.lives.life) of contacts with growing grains and heat.

    Parameters
    ----------
    contacts : Contacts
        With `grains` and `thermal`.
    longest : float
        See GrainLife.
    accuracy : float
        Change of the share that holds below which no finer nodes are tried.

    Attributes
    ----------
    error : float
        Measured: the first, middle and last rows and columns are computed with two numbers of moments.
    """

    # with this `resolved` normal laws are summed to 1e-8
    pair_work, pieces, resolved = 1000, 4, 1e-5

    def __init__(self, contacts: Contacts, longest: float, accuracy: float) -> None:
        super().__init__(contacts, longest)
        assert contacts.thermal is not None
        self._accuracy = accuracy
        self.thermal, self._fineness = contacts.thermal, 0
        self.error = 3e-11  # of the table
        self.thresholds = GrowingThresholds(self.grains, self.start_since + longest)

    def left(self, born: Start | Array, history: History) -> Array:
        """Share of contacts that hold, and their force per contact born; see Life.left."""
        legs = history.legs()
        rows, columns = (np.unique([0, n // 2, n - 1]) for n in legs.displacement.shape[:2])
        looked = np.ix_(rows, columns)
        some = Legs(legs.displacement[looked], legs.duration[looked], legs.speed)
        coarse = self._told(born, some)
        for fineness in range(self._fineness + 1, len(MOMENTS)):
            self._fineness = fineness
            fine = self._told(born, some)
            off, coarse = float(np.abs(fine[0] - coarse[0]).max(initial=0.0)), fine
            if off <= self._accuracy:
                break
        self._fineness -= 1  # the coarser of two that agree
        self.error = max(self.error, MARGIN * off)
        return self._told(born, legs)

    def _share(self, moves: Legs, since: float, worst: Array, before: Array) -> Array:
        """See GrainLife."""
        out, alive = np.zeros(worst.size), np.flatnonzero(worst - before < GONE)
        if not alive.size:
            return out
        moments = MOMENTS[self._fineness]

        def held(row: Rows, roots: Array) -> Array:
            some = alive[row]
            own = Legs(moves.displacement[some], moves.duration[some], moves.speed)
            spent = self._spent(own, since, worst[some], roots, moments)
            share = 2.0 * np.exp(-roots * roots - spent)
            # the weight is 0 at H_worst; halving is decided by the integrand without it
            return np.stack([share * roots.max(axis=1, keepdims=True), share * roots])

        row, piece = np.divmod(np.arange(alive.size * (ROOTS.size - 1)), ROOTS.size - 1)
        pieces = Pieces(row, ROOTS[piece], ROOTS[piece + 1])
        found = integrals(held, pieces, alive.size, RESOLVED)
        self.error = max(self.error, MARGIN * float(found.missed[1]))
        out[alive] = found.value[1] * np.exp(before[alive] - worst[alive])
        return out

    def _spent(self, legs: Legs, since: float, worst: Array, roots: Array, moments: int) -> Array:
        """A of quantiles with the hazards worst + roots², shape of `roots` (n, m); each leg is cut where
        the stretch passes 0."""
        out, hazards = np.zeros(roots.shape), worst[:, None] + roots * roots
        # the double exponential rule, dense towards both ends of a leg
        t = np.linspace(-3.0, 3.0, moments)
        place = 1.0 / (1.0 + np.exp(-np.pi * np.sinh(t)))
        weight = np.cosh(t) * place * (1.0 - place)
        weight /= weight.sum()
        for leg, duration in enumerate(legs.duration.T):
            begin, end = legs.displacement[:, leg], legs.displacement[:, leg + 1]
            turns = begin * end < 0.0
            share = np.where(turns, begin / np.where(turns, begin - end, 1.0), 1.0)
            zero = np.where(turns, 0.0, end)
            first, rest = share * duration, np.where(turns, 1.0 - share, 0.0) * duration
            start = since + legs.duration[:, :leg].sum(axis=1)
            for near, far, at, lasts in (
                (begin, zero, start, first),
                (zero, end, start + first, rest),
            ):
                rows = np.flatnonzero(lasts > 0.0)
                if not rows.size:
                    continue
                near, far, at, lasts = (part[rows, None] for part in (near, far, at, lasts))
                limit = self.thresholds.each(hazards[rows], at + lasts * place)
                stretch = np.abs(near + (far - near) * place)[:, :, None]
                rate = self.thermal.plain_rate(np.minimum(stretch, limit), limit)
                out[rows] += (weight @ rate) * lasts
        return np.minimum(out, 700.0)  # e^-700 counts as 0


class GrowingThresholds:
    """Table of the thresholds x_s(η; time since pinning) of growing grains.

    Parameters
    ----------
    grains : GrainContact
    longest : float
        Largest time since pinning.
    """

    def __init__(self, grains: GrainContact, longest: float) -> None:
        growth = grains.growth
        self._pinning_time, self._root_b = growth.first_pinning_time, float(np.sqrt(growth.B))
        latest = max(np.log(longest / self._pinning_time), 0.0) + SPACING
        hazard = np.arange(LEAST_HAZARD, np.log(2.0 * GONE) + SPACING, SPACING)
        time = np.arange(LEAST_TIME, latest + SPACING, SPACING)
        excess = np.expm1(np.log1p(np.exp(time)) / 3.0)
        largest = 1.0 + excess
        hazards = np.broadcast_to(np.exp(hazard)[:, None], (hazard.size, time.size))
        q = invert_beyond(hazards, 1.0 / largest, excess / largest)
        gap = excess * (q * excess / (largest + q * excess))
        logs = 0.5 * np.log(gap * (gap + 2.0)) - 0.5 * hazard[:, None] - time
        self._ends = (hazard[0], hazard[-1]), (time[0], time[-1])
        self._table = RectBivariateSpline(hazard, time, logs, kx=DEGREE, ky=DEGREE)

    def at(self, hazard: Array, since: Array) -> Array:
        """x_s (lengths) at hazards and times since pinning > 0 that broadcast."""
        time = np.maximum(since / self._pinning_time, 1e-300)
        hazard = np.maximum(hazard, 1e-300)
        a, b = np.broadcast_arrays(np.log(hazard), np.log(time))
        ends = self._ends
        logs = self._table.ev(np.clip(a, *ends[0]), np.clip(b, *ends[1]))
        return np.asarray(np.sqrt(hazard) * time * np.exp(logs) / self._root_b)

    def each(self, hazard: Array, since: Array) -> Array:
        """x_s of each hazard of a row at each time since pinning of that row, shape (n, k, m).

        hazard : array (n, m); since : array (n, k). B-splines of both are evaluated once per row and
        multiplied as sparse matrices: ten times as fast as point by point.
        """
        time = np.maximum(since / self._pinning_time, 1e-300)
        hazard = np.maximum(hazard, 1e-300)
        (count, some), many = hazard.shape, time.shape[1]
        parts = []
        for value, knots, ends in zip(
            (hazard, time), self._table.get_knots(), self._ends, strict=True
        ):
            at = np.clip(np.log(value), *ends).ravel()
            parts.append(BSpline.design_matrix(at, knots, DEGREE))
        of_hazard = parts[0] @ self._table.get_coeffs().reshape(parts[0].shape[1], -1)
        columns = of_hazard.shape[1]
        of_hazard = of_hazard.reshape(count, some, columns).transpose(0, 2, 1).reshape(-1, some)
        # shift columns so that each row's times use the coefficients of its own hazards
        own = parts[1].indices.reshape(count, -1) + columns * np.arange(count)[:, None]
        entries = parts[1].data, own.ravel(), parts[1].indptr
        of_time = csr_array(entries, shape=(count * many, count * columns))
        logs = (of_time @ of_hazard).reshape(count, many, some)
        scale = np.sqrt(hazard)[:, None, :] * (time / self._root_b)[:, :, None]
        return np.asarray(scale * np.exp(logs))
