"""Breaks at a temperature and a steady speed of contacts whose thresholds grow with age and that stood at one stretch.

Each keeps its quantile, told by the travel X_c after which it would meet its threshold were there no heat. With A the
integral over time of the rate h, the threshold being the present one,

    E(X) = integral over X_c > X of p_c(X_c) e^(-A(X; X_c)),
    p(X) = p_c(X) e^(-A(X; X)) + the integral of E with h/v beside the exponential.

A is summed up along X, on panels of sixteen nodes, for quantiles between each node and the next. Panels are halved
until p is a series on each.
"""

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master._old.effective_law import EffectiveLaw
from master._old.first_passage import FirstPassage
from master._old.grain_breaking import GrainBreaking
from master._old.piecewise import Piecewise
from origins import Contacts
from origins.grains.lifshitz_slyozov import invert_beyond

Array = npt.NDArray[np.float64]

_NODES = 16
_X, _W = legendre.leggauss(_NODES)
_T = 0.5 * (_X + 1.0)
_PROJECT = ((np.arange(_NODES) + 0.5)[:, None] * legendre.legvander(_X, _NODES - 1).T) * _W
# integrals from the beginning of a panel to each node and to its end, per width
_ENDS = np.append(_X, 1.0)
_TO = 0.5 * np.stack([legendre.legval(_ENDS, legendre.legint(row, lbnd=-1.0)) for row in np.eye(_NODES)], axis=1)
_UP_TO = _TO @ _PROJECT

def _rule(nodes: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on (0, 1)."""
    x, w = legendre.leggauss(nodes)
    return 0.5 * (x + 1.0), 0.5 * w


# quantiles between two nodes, in the root of their distance where rates have a root; and the way between two nodes
_SUB, _SUB_W = _rule(4)
_ROOT, _ROOT_W = _rule(7)
_WAY, _WAY_W = _rule(6)
# panels of the coarse table: hazards of quantiles above the least, and times, of tau_m
_HAZARDS = np.array([0.0, 1e-5, 1e-4, 1e-3, 1e-2, 0.05, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 28.0, 42.0])
_TIMES = np.concatenate([[0.0], 0.02 * 2.2 ** np.arange(60.0)])
_FAINT = 42.0  # hazard: e to its negative is nothing
_LEAST, _MOST = 1e-13, 1e-10
_HALVINGS, _MANY_PANELS, _MOST_PANELS = 45, 250, 600
_MARGIN = 3.0
_NOISE = 4e-15
_SPENT = 700.0
_FEWEST = 9
_SOON = 4.0 ** np.arange(-1.0, 24.0)  # of 1/attempt_frequency: what breaks at once
_NOTHING = 1e-17
_STEEP = 10.0


class _Line:
    """Contacts that stand at one stretch and are of one age at X = 0: what they do without heat.

    `begins` is the travel after which the first meet their thresholds, `ends` the one that next to none reaches, and
    `least` the hazard of the weakest quantile that holds at X = 0.
    """

    def __init__(self, contacts: Contacts, velocity: float, origin: float | None) -> None:
        grains = contacts.grains
        assert grains is not None and grains.age is not None
        self.grains, self.velocity, self.origin = grains, velocity, origin or 0.0
        self.first = grains.growth.first_pinning_time
        self.pinned = grains.breaking(velocity) if origin is None else None
        self.age, self.begins = self.first, 0.0
        if self.pinned is not None:
            self.least = self.pinned.lost_hazard
            self.ends = float(self.pinned.isf(np.exp(-_FAINT)))
            return
        self.age, self.least = grains.age, float(grains.hazard(abs(self.origin), grains.age))
        cold = GrainBreaking(contacts, velocity)
        self.begins = float(cold.begins(np.array([self.origin]))[0])
        low, high = self.begins, cold.top - self.origin
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if float(self.meets(np.array([middle]))[0][0]) > _FAINT else (middle, high)
        self.ends = low

    def meets(self, travel: Array) -> tuple[Array, Array]:
        """Of the quantile that meets its threshold after such a travel: its hazard above `least`; and p_c."""
        if self.pinned is not None:
            return -np.asarray(self.pinned.logsf(travel)), np.asarray(self.pinned.pdf(travel))
        x, age = np.abs(self.origin + travel), self.age + travel / self.velocity
        hazard = np.maximum(np.asarray(self.grains.hazard(x, age)) - self.least, 0.0)
        held = np.exp(-hazard)
        rise = np.where(held > 0.0, np.maximum(self.grains.rise(x, age, self.velocity), 0.0), 0.0)
        return hazard, rise * held


class _Quantiles:
    """Thresholds of given quantiles (hazards above the least, shape (n,), increasing) along a line: x_s² over the
    hazard, and for fresh contacts over the square of the time as well, is read from a coarse table."""

    def __init__(self, line: _Line, above: Array) -> None:
        self._line, self._own = line, line.least + above
        edges = line.least + _HAZARDS
        self._ranks = edges[:-1, None] + np.diff(edges)[:, None] * _T
        self._bounds = np.searchsorted(above, _HAZARDS[1:-1])
        self._to_own = []
        for part, left, right in zip(np.split(self._own, self._bounds), edges[:-1], edges[1:], strict=True):
            at = 2.0 * (part - left) / (right - left) - 1.0
            self._to_own.append(_PROJECT.T @ legendre.legvander(at, _NODES - 1).T)
        self._now = -1

    def within(self, number: int, travel: Array, which: slice) -> Array:
        """x_s² of quantiles `which` at travels on panel `number` of the times; shape (travels, quantiles)."""
        line = self._line
        if number != self._now:
            begin, end = _TIMES[number] * line.first, _TIMES[number + 1] * line.first
            self._begin, self._width, self._now = begin, end - begin, number
            time = begin + self._width * _T
            coarse = self._read(time)
            parts = [coarse[:, k] @ to for k, to in enumerate(self._to_own)]
            self._series = _PROJECT @ np.concatenate(parts, axis=1)
        time = travel / line.velocity
        at = 2.0 * (time - self._begin) / self._width - 1.0
        found = legendre.legvander(at, _NODES - 1) @ self._series[:, which]
        if line.pinned is not None:
            found *= np.square(time)[:, None]
        return found * self._own[which]

    def at(self, number: int, travel: Array, which: npt.NDArray[np.intp]) -> Array:
        """The same where each row of travels, shape (n, k), is of one quantile; `number` as asked for last."""
        line = self._line
        time = travel / line.velocity
        powers = legendre.legvander(2.0 * (time - self._begin) / self._width - 1.0, _NODES - 1)
        found = np.einsum("ijk,ki->ij", powers, self._series[:, which])
        if line.pinned is not None:
            found *= np.square(time)
        return np.asarray(found * self._own[which, None])

    def _read(self, time: Array) -> Array:
        """The same at all ranks, shape (times, parts, ranks)."""
        line, growth = self._line, self._line.grains.growth
        since = (line.age - line.first + time) / line.first
        excess = np.expm1(np.log1p(since) / 3.0)[:, None]
        largest = 1.0 + excess
        ranks = np.broadcast_to(self._ranks.ravel(), (time.size, self._ranks.size))
        q = invert_beyond(ranks, 1.0 / largest, excess / largest)
        gap = excess * (q * excess / (largest + q * excess))
        found = gap * (gap + 2.0) / (growth.B * ranks)
        if line.pinned is not None:
            found /= np.square(time)[:, None]
        return found.reshape(time.size, *self._ranks.shape)


def warmed(contacts: Contacts, velocity: float, origin: float | None, accuracy: float) -> FirstPassage:
    """Breaks of contacts with `grains` and `thermal` from the stretch `origin` (a length) at X = 0, where they are as
    old as they are said to be; None: of those that pin while they slide and hold at all."""
    line = _Line(contacts, velocity, origin)
    assert contacts.thermal is not None
    tight = float(np.clip(1e-3 * accuracy, _LEAST, _MOST))
    cuts, soon = velocity * line.first * _TIMES, velocity / contacts.thermal.attempt_frequency * _SOON
    turn = [-line.origin] if line.origin < 0.0 else []
    seeds = np.concatenate([[0.0], cuts, soon, turn, np.linspace(line.begins, line.ends, _FEWEST)])
    edges = np.unique(seeds[(seeds >= 0.0) & (seeds <= line.ends)])
    edges = edges[np.append(np.diff(edges) > 1e-14 * line.ends, True)]
    for _ in range(_HALVINGS):
        density = _march(contacts, line, edges)
        coefficients = density @ _PROJECT.T
        width = np.diff(edges)
        size, tail = np.abs(coefficients).max(axis=1), np.abs(coefficients[:, -2:]).max(axis=1)
        noise = _NOISE + 1e-15 * (edges[1:] + edges[:-1]) / width
        open_ = (tail * width > tight) & (tail > noise * size)
        series = Piecewise(edges, coefficients.T)
        # each breaks once: what the sum of all breaks lacks is what rates that change within a step are off by
        error = _MARGIN * abs(1.0 - series.total) + float((tail * width).sum())
        if not open_.any() and error > accuracy and width.size < _MANY_PANELS:
            open_ = np.ones(width.size, dtype=bool)
        if not open_.any() or width.size + open_.sum() > _MOST_PANELS:
            break
        edges = np.sort(np.concatenate([edges, (0.5 * (edges[1:] + edges[:-1]))[open_]]))
    return FirstPassage(EffectiveLaw(series, 0.0, False, onset_power=0.0), error)


def _march(contacts: Contacts, line: _Line, edges: Array) -> Array:
    """p at the nodes of each panel, shape (panels, 16)."""
    assert contacts.thermal is not None
    rooted = contacts.thermal.rates.vanishes_at_threshold
    width = np.diff(edges)
    nodes = edges[:-1, None] + width[:, None] * _T
    steps = np.concatenate([edges[:-1, None], nodes, edges[1:, None]], axis=1)
    met = edges[:-1] >= line.begins
    # quantiles that meet their thresholds between a node and the next, and those that do right at one
    low, high = steps[met, :-1, None], steps[met, 1:, None]
    part, share = (_ROOT**2, 2.0 * _ROOT * _ROOT_W) if rooted else (_SUB, _SUB_W)
    columns = np.concatenate([low + (high - low) * part, high], axis=2)
    weights = np.concatenate([(high - low) * share, np.zeros(high.shape)], axis=2)
    shape, columns = columns.shape[1:], columns.ravel()
    above, density = line.meets(columns)
    weights = weights.ravel() * density
    quantiles = _Quantiles(line, above)
    spent = np.zeros(columns.size)
    out = np.zeros(nodes.shape)
    per, before = shape[0] * shape[1], int((~met).sum())
    ends_of_times = line.velocity * line.first * _TIMES
    for k in range(width.size):
        first = max(k - before, 0) * per
        number = int(np.searchsorted(ends_of_times, 0.5 * (edges[k] + edges[k + 1])) - 1)
        last = _felt(contacts, line, quantiles, number, steps[k], first, columns.size)
        if k >= before:
            last = max(last, first + per)  # what is met on this panel, felt or not
        here = slice(first, last)
        squared = quantiles.within(number, nodes[k], here)
        rate = _rate(contacts, line, nodes[k][:, None], squared) / line.velocity
        passed = width[k] * (_UP_TO @ rate)
        # what is met on this panel does not go on: for soft contacts that matters where rates would rise without end
        if k >= before and (rooted or float(rate[-1, 0]) > _STEEP * contacts.thermal.attempt_frequency / line.velocity):
            near = slice(first, min(first + (2 * per if rooted else per), last))
            passed[:, : near.stop - first] = _beside(contacts, line, quantiles, number, steps[k], columns, near)
        gone = np.clip(spent[here] + passed, 0.0, _SPENT)
        holds = columns[here] > nodes[k][:, None] * (1.0 + 1e-15)
        kept = np.exp(-gone[:-1])
        out[k] = np.where(holds, rate * kept, 0.0) @ weights[here]
        if k >= before:
            at = first + np.arange(_NODES) * shape[1] + shape[1] - 1
            out[k] += density[at] * np.exp(-gone[np.arange(_NODES), at - first])
        spent[here] = gone[-1]
    return out


def _beside(
    contacts: Contacts,
    line: _Line,
    quantiles: _Quantiles,
    number: int,
    steps: Array,
    columns: Array,
    near: slice,
) -> Array:
    """A/v from the beginning of a panel to its nodes and its end for quantiles that meet their thresholds on it or soon
    after: the rate of stiff contacts has a root there, in which it is a series. Shape (17, quantiles)."""
    met = columns[near]
    apart = np.sqrt(np.maximum(met - steps[:, None], 0.0))
    far, close = apart[:-1], apart[1:]
    out = np.zeros(far.shape)
    row, column = np.nonzero(far > 0.0)
    length = (far - close)[row, column]
    roots = close[row, column, None] + length[:, None] * _WAY
    travel = met[column, None] - roots * roots
    squared = quantiles.at(number, travel, near.start + column)
    rate = _rate(contacts, line, travel, squared) / line.velocity
    out[row, column] = (rate * roots) @ _WAY_W * (2.0 * length)
    return out.cumsum(axis=0)


def _felt(
    contacts: Contacts, line: _Line, quantiles: _Quantiles, number: int, steps: Array, first: int, size: int
) -> int:
    """The last quantile that may break on the way, others being too strong."""
    thermal = contacts.thermal
    assert thermal is not None
    ends = steps[[1, -2]]
    squared = quantiles.within(number, ends, slice(first, size))
    log_rate = np.log(np.maximum(_rate(contacts, line, ends[:, None], squared), 1e-300)).max(axis=0)
    felt = np.flatnonzero(log_rate > np.log(_NOTHING * line.velocity / (steps[-1] - steps[0])))
    return first + (int(felt[-1]) + 1 if felt.size else min(size - first, 1))


def _rate(contacts: Contacts, line: _Line, travel: Array, squared: Array) -> Array:
    """h, per time, where thresholds have these squares; as it goes on beyond a threshold that is met."""
    thermal = contacts.thermal
    assert thermal is not None
    return thermal.plain_rate(line.origin + travel, np.sqrt(squared))
