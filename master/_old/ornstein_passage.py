"""First passage of a threshold that ages towards a normal law, by an integral equation of the second kind.

The threshold ξ diffuses in a parabola from its fresh value; the contact advances by t, its stretch being S(t) =
start + t, and breaks where |S| meets ξ. With f(x, t | y, τ) the known transition density, 2ψ its flux through the
moving level less half of what makes it singular there, the breaks g per unit of advance obey

    g(t) = 2ψ(t | fresh, 0) - integral_0^t g(τ) 2ψ(t | S(τ), τ) dτ

(Buonocore, Nobile and Ricciardi, Adv. Appl. Prob. 19, 784, 1987). For a threshold at rest, or one that diffuses
without drift, the integral vanishes; it never needs more than g is wide. Marched in panels, each a Legendre series of
2 s g over s = t^(1/2), in which g is smooth from the first contact on.
"""

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master._old.piecewise import Piecewise, tabulate
from origins import InputError, Thresholds
from origins.thresholds.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]

_NODES = 16
_X, _W = legendre.leggauss(_NODES)
_T = 0.5 * (_X + 1.0)
_SERIES = legendre.legvander(_X, _NODES - 1)
_INNER = 12
_Y, _V = legendre.leggauss(_INNER)
_Y, _V = 0.5 * (_Y + 1.0), 0.5 * _V

_SPREAD = np.arange(-9.0, 9.5)  # standard deviations of a transition, panel by panel
_FAINT = 10.0  # standard deviations
_FORGOTTEN = 1e-150
_NOISE = 2e-14  # of the largest coefficient: rounded exponents
_DOUBLINGS = 40
_MOST_PANELS = 4000
_NEARLY_NOTHING = 1e-16
_BEYOND_ALL = 12.0  # standard deviations
_QUANTILES = np.array([1e-12, 1e-6, 1e-3, 0.03, 0.25, 0.5])
_BESIDE = np.array([-9.0, -4.0, -1.5, 1.5, 4.0, 9.0])
_TOWARDS = np.array([12.0, 8.0, 4.0, 0.0])


class OrnsteinPassage:
    """Breaks of contacts that stand at `start` at t = 0 with fresh thresholds above |start|, per unit of advance.

    Parameters
    ----------
    fresh : Thresholds
        P_ci; atoms allowed.
    mean, std : float
        Of the normal law P_cf, uncut (lengths).
    diffusion : float
        D_X = D/v > 0, a length.
    start : float
        Stretch at t = 0; below 0 the level first comes down to 0.
    spent : float
        Survival at which to stop.
    accuracy : float
        Weight that a panel may miss.

    Attributes
    ----------
    advance : float
        t at the end of the table.
    survival : float
        What still holds there.
    hazard, slope : float
        g/E there, and its derivative.
    error : float
        Estimate of the error of the survival anywhere.
    """

    def __init__(
        self,
        fresh: Thresholds,
        mean: float,
        std: float,
        diffusion: float,
        start: float = 0.0,
        spent: float = 1e-12,
        accuracy: float = 1e-13,
    ) -> None:
        self._fresh, self._mean, self._std, self._start = fresh, mean, std, start
        self._diffusion, self._rate = diffusion, diffusion / std**2
        self._accuracy = accuracy
        least = abs(start)
        self._held = float(fresh.sf(least))
        atoms, weights = fresh.atoms
        self._atoms, self._atom_weights = atoms[atoms > least], weights[atoms > least]
        edges = panel_edges(fresh)
        if edges.size:
            edges = np.unique(np.append(edges[edges > least], max(least, float(edges[0]))))
        self._edges = edges
        # an edge of the law's own where the rest of the phase begins
        self._phases: list[_Phase] = []
        self.survival, self.error = 1.0, 0.0
        if start < 0.0:
            self._march(_Phase(0.0, -start, -1.0), -start, spent)
        if self.survival > 1.001 * spent:
            level = max(start, 0.0)
            furthest = max(float(fresh.isf(_NEARLY_NOTHING)), mean) + _BEYOND_ALL * std
            self._march(_Phase(max(-start, 0.0), level, 1.0), furthest - level, spent)
        self._end()
        if self.survival > 1.001 * spent or self.survival <= 0.0 or self.hazard <= 0.0:
            # all have broken: what seems left was lost to rounding
            self.error += abs(self.survival)
            self.survival = 0.0

    # -- what it is asked --------------------------------------------------------------------------------------
    def series(self) -> Piecewise:
        """2 s g over s = t^(1/2)."""
        if len(self._phases) == 1:
            return self._phases[0].table()
        # above 0 panels are even in the time since the level turned; in s they need cutting up
        edges = [np.sqrt(phase.begin + np.square(phase.edges)) for phase in self._phases]
        return tabulate(lambda s: (2.0 * s * self.density(s * s))[None], np.unique(np.concatenate(edges)))[0]

    def density(self, t: Array) -> Array:
        """g at advances t > 0, 0 beyond the table."""
        out = np.zeros(t.shape)
        for phase in self._phases:
            here = (t > phase.begin) & (t <= phase.begin + phase.edges[-1] ** 2 * (1.0 + 1e-14))
            s = np.sqrt(t[here] - phase.begin)
            out[here] = phase.table()(np.minimum(s, phase.edges[-1])) / (2.0 * s)
        return out

    # -- the march ---------------------------------------------------------------------------------------------
    def _march(self, phase: "_Phase", length: float, spent: float) -> None:
        self._phases.append(phase)
        last = np.sqrt(length)
        marks = self._marks(phase)
        width = 0.1 * np.sqrt(min(self._diffusion, 1.0 / self._rate, 0.1 * self._std))
        left = 0.0
        while left < last and self.survival > 1.001 * spent:
            ahead = marks[marks > left * (1.0 + 1e-12)]
            room = min(last, float(ahead[0]) if ahead.size else np.inf) - left
            step = room if width > 0.9 * room else min(width, 0.5 * room)
            series = self._panel(phase, left, step)
            tail = float(np.abs(series[-2:]).max()) * step
            noise = _NOISE * float(np.abs(series).max()) * step
            if tail > max(self._accuracy, noise) and step > 1e-9 * (left + step):
                width = 0.5 * step
                continue
            right = left + step if step < room else left + room
            if self.survival - float(series[0]) * step < spent:
                right, series = _cut(left, right, series, self.survival - spent)
            phase.add(right, series)
            self.survival -= float(series[0]) * (right - left)
            self.error += tail
            left = phase.edges[-1]
            early = float(np.abs(series[-6:]).max()) * step
            aim = max(self._accuracy, noise)
            width = step * (2.0 if early < aim else 1.3 if tail < 0.1 * aim else 1.0)
            if phase.count > _MOST_PANELS:
                raise InputError("ageing: first passage needs too many panels; use a smoother law of fresh thresholds")

    def _marks(self, phase: "_Phase") -> Array:
        """s at which g may rise within less than the panels so far: where thresholds meet the level if nothing is
        random."""
        quantiles = np.concatenate([self._fresh.ppf(_QUANTILES), self._fresh.isf(_QUANTILES)])
        goal = self._mean - _TOWARDS * self._std - phase.level
        if phase.sign < 0.0:
            return np.empty(0)
        t = self._meets(quantiles, phase)
        corners = self._fresh.breakpoints
        at = self._meets(np.concatenate([self._atoms, corners[corners > phase.level]]), phase)
        spread = self._std * np.sqrt(-np.expm1(-2.0 * self._rate * (at + phase.begin)))
        beside = (at[:, None] + spread[:, None] * _BESIDE).ravel()
        marks = np.concatenate([t, at, beside, goal])
        marks = np.unique(np.sqrt(marks[marks > 0.0]))
        # marks closer than rounding tell nothing
        return marks[np.diff(marks, prepend=-1.0) > 1e-9 * marks]

    def _meets(self, values: Array, phase: "_Phase") -> Array:
        """Advance in the phase at which thresholds that start from `values` and follow the mean meet the level."""
        low, high = np.zeros(values.size), np.maximum(values, self._mean) - phase.level
        for _ in range(60):
            t = 0.5 * (low + high)
            above = self._mean + (values - self._mean) * np.exp(-self._rate * (t + phase.begin)) > phase.level + t
            low, high = np.where(above, t, low), np.where(above, high, t)
        return high[high > 0.0]

    def _panel(self, phase: "_Phase", left: float, width: float) -> Array:
        """Legendre coefficients of 2 s g on the panel, from all that came before."""
        s = left + width * _T
        t = s * s
        level = phase.level + phase.sign * t
        known = self._fresh_flux(t + phase.begin, level, phase.sign)
        for earlier in self._phases[:-1]:
            known -= self._return_of(earlier, phase, t, level)
        kernel = np.zeros((_NODES, _NODES))
        row, sigma, below, factors = self._graded(s, phase.edges_so_far, s)
        elapsed = below * (s[row, None] + sigma)
        seen = self._seen(level[row], phase.sign * elapsed, elapsed)
        row, sigma, elapsed, factors = row[seen], sigma[seen], elapsed[seen], factors[seen]
        factors *= self._flux(level[row, None], phase.sign, phase.sign * elapsed, elapsed)
        own = sigma[:, 0] > left
        if not own.all():
            old = phase.value(sigma[~own])
            known -= np.bincount(row[~own], weights=(factors[~own] * old).sum(axis=-1), minlength=_NODES)
        basis = legendre.legvander((2.0 * (sigma[own] - left)) / width - 1.0, _NODES - 1)
        np.add.at(kernel, row[own], np.einsum("nq,nqk->nk", factors[own], basis))
        return np.asarray(np.linalg.solve(_SERIES + 2.0 * s[:, None] * kernel, 2.0 * s * known), dtype=float)

    def _return_of(self, earlier: "_Phase", phase: "_Phase", t: Array, level: Array) -> Array:
        """What contacts that broke in an earlier phase would add to the flux."""
        top = np.full(t.size, earlier.edges[-1])
        row, sigma, below, factors = self._graded(top, earlier.edges_so_far, np.sqrt(t))
        back = below * (top[row, None] + sigma)
        # the level came down by `back` and went up by t
        seen = self._seen(level[row], t[row, None] - back, t[row, None] + back)
        row, sigma, back, factors = row[seen], sigma[seen], back[seen], factors[seen]
        elapsed, rise = t[row, None] + back, t[row, None] - back
        factors *= self._flux(level[row, None], phase.sign, rise, elapsed) * earlier.value(sigma)
        return np.asarray(np.bincount(row, weights=factors.sum(axis=-1), minlength=t.size), dtype=float)

    def _graded(self, top: Array, edges: Array, scale: Array) -> tuple[npt.NDArray[np.intp], Array, Array, Array]:
        """Rows of `top`, nodes σ, top - σ and weights for integrals over 0 < σ < top, refined towards the top.

        Panels are cut at `edges`; nodes are even in w = (top - σ)^(1/2), in which what is singular there is smooth.
        """
        finest = 0.5 * min(4.0 * self._diffusion, 1.0 / self._rate)
        first = np.sqrt(np.minimum(finest / (2.0 * scale), top))
        w = first[:, None] * 2.0 ** np.arange(_DOUBLINGS)
        cut = np.maximum(top[:, None] - w * w, 0.0)
        cut = cut[:, : int((cut > 0.0).any(axis=0).sum()) + 1]
        fixed = np.minimum(np.broadcast_to(edges, (top.size, edges.size)), top[:, None])
        ends = np.sort(np.concatenate([fixed, cut, top[:, None]], axis=1), axis=1)
        row, column = np.nonzero(ends[:, 1:] > ends[:, :-1])
        far = np.sqrt(top[row] - ends[row, column])
        near = np.sqrt(np.maximum(top[row] - ends[row, column + 1], 0.0))
        w = near[:, None] + (far - near)[:, None] * _Y
        return row, top[row, None] - w * w, w * w, (far - near)[:, None] * _V * 2.0 * w

    def _seen(self, level: Array, rise: Array, elapsed: Array) -> npt.NDArray[np.bool_]:
        """Rows in which the transition counts at the first node, at the last, or between them."""
        ends = [0, -1]
        decay = np.exp(-self._rate * elapsed[:, ends])
        lost = -np.expm1(-self._rate * elapsed[:, ends])
        distance = (level[:, None] - self._mean) * lost + rise[:, ends] * decay
        z = distance / (self._std * np.sqrt(lost * (1.0 + decay)))
        faint = (np.abs(z) > _FAINT).all(axis=1) & ((z[:, 0] > 0.0) == (z[:, 1] > 0.0))
        return ~faint

    # -- the flux ----------------------------------------------------------------------------------------------
    def _flux(self, level: Array, sign: float, rise: Array, elapsed: Array) -> Array:
        """2ψ from where the level was `elapsed` ago, `rise` below now: with c = level - mean and a = λ elapsed,
        f [sign - (rise/elapsed) a/sinh a - λ c tanh(a/2)]."""
        a = self._rate * elapsed
        decay = np.exp(-a)
        lost = -np.expm1(-a)
        c = level - self._mean
        distance = c * lost + rise * decay
        variance = self._std**2 * lost * (1.0 + decay)
        density = np.exp(-0.5 * distance * distance / variance) / np.sqrt(2.0 * np.pi * variance)
        speed = rise / elapsed
        bracket = sign - speed + speed * _less_than_sinh(a, decay, lost) - self._rate * c * lost / (1.0 + decay)
        return density * bracket

    def _fresh_flux(self, time: Array, level: Array, sign: float) -> Array:
        """2ψ from the fresh thresholds above |start|, at time after t = 0 and level S; shape as time."""
        a = self._rate * time
        decay, lost = np.exp(-a), -np.expm1(-a)
        spread = lost * (1.0 + decay)
        c = level - self._mean
        out = np.zeros(time.size)
        if self._edges.size > 1:
            low, high = float(self._edges[0]), float(self._edges[-1])
            # where a threshold that comes down to the level with the mean begins, and how widely the others do
            kept = np.maximum(decay, _FORGOTTEN)
            centre, width = self._mean + c / kept, self._std * np.sqrt(spread) / kept
            base = np.clip(centre, low, high)
            away = (centre - base) / width
            # in units of the width from `base`: differences stay exact however narrow it is
            fixed = (self._edges - base[:, None]) / width[:, None]
            ends = np.concatenate([fixed, np.clip(away[:, None] + _SPREAD, fixed[:, :1], fixed[:, -1:])], axis=1)
            ends.sort(axis=1)
            seen = np.clip(ends, (away + _SPREAD[0])[:, None], (away + _SPREAD[-1])[:, None])
            row, column = np.nonzero(seen[:, 1:] > seen[:, :-1])
            z, weights = gauss(ends[row, column], ends[row, column + 1])
            nodes = np.clip(base[row, None] + width[row, None] * z, low, high)
            weights = weights * width[row, None] * self._fresh.pdf(nodes)
            weights = np.where(np.isfinite(weights), weights, 0.0)
            at = c[row, None], decay[row, None], spread[row, None]
            value = weights * self._from(nodes, z - away[row, None], *at, sign)
            out += np.bincount(row, weights=value.sum(axis=-1), minlength=time.size)
        if self._atoms.size:
            z = ((self._atoms - self._mean) * decay[:, None] - c[:, None]) / (self._std * np.sqrt(spread[:, None]))
            value = self._from(self._atoms, z, c[:, None], decay[:, None], spread[:, None], sign)
            out += (self._atom_weights * value).sum(axis=-1)
        return out / self._held

    def _from(self, fresh: Array, z: Array, c: Array, decay: Array, spread: Array, sign: float) -> Array:
        """2ψ from one fresh threshold, its mean z standard deviations above the level: with d = fresh - mean,
        f [sign + λ (d/sinh a - c coth a)]."""
        density = np.exp(-0.5 * z * z) / (self._std * np.sqrt(2.0 * np.pi * spread))
        d = fresh - self._mean
        return density * (sign + self._rate * (2.0 * decay * d - (1.0 + decay * decay) * c) / spread)

    def _end(self) -> None:
        """Hazard and its slope where the table ends."""
        phase = self._phases[-1]
        s = float(phase.edges[-1])
        self.advance = phase.begin + s * s
        series, width = phase.coefficients[-1], s - float(phase.edges[-2])
        value = float(legendre.legval(1.0, series))
        slope = float(legendre.legval(1.0, legendre.legder(series))) * 2.0 / width
        density = value / (2.0 * s)
        change = (slope / (2.0 * s) - value / (2.0 * s * s)) / (2.0 * s)
        self.hazard = density / self.survival
        self.slope = change / self.survival + self.hazard**2


class _Phase:
    """One stretch of time in which the level moves by `sign` per unit, from `level` at t = `begin`; its panels."""

    def __init__(self, begin: float, level: float, sign: float) -> None:
        self.begin, self.level, self.sign = begin, level, sign
        self.edges: list[float] = [0.0]
        self.coefficients: list[Array] = []

    @property
    def count(self) -> int:
        return len(self.coefficients)

    @property
    def edges_so_far(self) -> Array:
        return np.array(self.edges)

    def add(self, right: float, series: Array) -> None:
        self.edges.append(right)
        self.coefficients.append(series)

    def value(self, sigma: Array) -> Array:
        """2 σ g at points on finished panels, each row on one panel."""
        edges = self.edges_so_far
        panel = np.clip(np.searchsorted(edges, sigma[:, 0], side="right") - 1, 0, self.count - 1)
        left, right = edges[panel, None], edges[panel + 1, None]
        x = (2.0 * sigma - left - right) / (right - left)
        series = np.array(self.coefficients)[panel]
        return np.asarray(legendre.legval(x, np.moveaxis(series, 1, 0)[:, :, None], tensor=False), dtype=float)

    def table(self) -> Piecewise:
        return Piecewise(self.edges_so_far, np.array(self.coefficients).T)


def _cut(left: float, right: float, series: Array, weight: float) -> tuple[float, Array]:
    """Where a panel's integral from the left reaches `weight`, and the series up to there."""
    integral = legendre.legint(series, lbnd=-1.0) * 0.5 * (right - left)
    low, high = -1.0, 1.0
    for _ in range(60):
        x = 0.5 * (low + high)
        low, high = (x, high) if legendre.legval(x, integral) < weight else (low, x)
    nodes = -1.0 + 0.5 * (high + 1.0) * (_X + 1.0)
    values = legendre.legval(nodes, series)
    return left + 0.5 * (right - left) * (high + 1.0), np.asarray(np.linalg.solve(_SERIES, values), dtype=float)


def _less_than_sinh(a: Array, decay: Array, lost: Array) -> Array:
    """1 - a/sinh a."""
    square = a * a
    series = 1.0 - 31.0 * square / 294.0 * (1.0 - 127.0 * square / 1240.0)
    series = square / 6.0 * (1.0 - 7.0 * square / 60.0 * series)
    with np.errstate(divide="ignore", invalid="ignore"):
        direct = 1.0 - 2.0 * a * decay / (lost * (1.0 + decay))
    return np.where(a < 0.05, series, direct)
