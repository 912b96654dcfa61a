"""How fast contacts forget that they started together: the slowest decay of F(X) towards the kinetic force.

F - F_k is a sum of exponentials e^{sX} over the roots s != 0 of p^(s) = 1, where p^(s) is the integral of
e^{-sx} P_c(x), and over the singularities of p^ itself, the first of which is the rate of the law's own tail.
"""

import numpy as np
import numpy.typing as npt
from scipy.fft import next_fast_len, rfft

from master._old.cycle import Cycle
from master._old.lattice import deposit_atoms, lay
from master._old.law import Law
from master._old.long_wait import LONG, Waves, slowest_wave
from origins import Contacts
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

_CANDIDATES = 8
_NOWHERE = 0.1  # over the wait: so fast a decay is no business of it
_REACH = 6.0
_TAILS = np.array([1e-50, 1e-290])
_TERMS = 5  # of the tail's logarithm
_SLOW = 1e3
_SETTLED, _ROUNDED, _MARGIN, _LITTLE = 0.2, 1e-9, 10.0, 0.2
_FAR = 10.0 ** -np.arange(20.0, 300.0, 1.5)
MOST_NODES = 2**18
_ASTRAY = 3.0  # from a guess: other guesses are nearer to what lies there
_TABLE = 1e-13  # error of a survival known by tables
_NOISE = 1e-15  # of the terms of p^
BROAD, _OF_LONGEST = 1e4, 300.0  # means, and |s| times the longest life
_RESOLVED, _TIMES = 4.0, 6.0  # |s| that the nodes resolve beside a guess, and as many times the guess if that is less


def decoherence_length(contacts: Contacts, cycle: Cycle | None = None) -> tuple[float, float]:
    """X* (a length) of the slowest term e^{-X/X*}, and its error; inf where nothing decays exponentially.

    That is so for a law of exact values alone (periodic, or as close to it as one likes) and for one whose tail falls
    slower than any exponential. Where a few live more than 10,000 times as long as the mean, and too few to tell, the
    error is inf, as where fewer than 1e-14 of growing grains hold at all. Where exact values hold a share of the
    weight, no root may be slower than those that crowd about the rate of their own.
    """
    cycle = Cycle(contacts) if cycle is None else cycle
    if cycle.release.delay > LONG and (found := _waiting(contacts, cycle)) is not None:
        return found
    law = Law(contacts, np.inf, cycle.law, cycle.unit)
    if law.atomic:  # of grains that hardly ever hold nothing is known of the few that do
        return np.inf, 0.0 if contacts.grains is None else np.inf
    rate, rate_error = tail_rate(cycle)
    rate, rate_error = rate * law.unit, rate_error * law.unit
    if (crowd := crowding_rate(law)) < rate:
        rate, rate_error = crowd, 0.0
    if rate == 0.0:
        return np.inf, 0.0
    slowest, error = _slowest_root(law, cycle, rate)
    if slowest > rate:
        # between 0.9 and 1 of the rate a root could hide from the far tail's round-off
        slowest, error = rate, rate_error + 0.1 * rate  # inf where the rate is a guess
    return law.unit / slowest, law.unit * error / slowest**2


def _waiting(contacts: Contacts, cycle: Cycle) -> tuple[float, float] | None:
    """The same where the wait is long; None where no wave decays more slowly than the law without it tells."""
    wait, unit = cycle.release.delay, cycle.unit
    law = Law(contacts, np.inf, cycle.without_wait().law, unit)
    if law.atomic:
        return None
    nodes, log_mass = wave_nodes(law, law.edges, 2.0 / min(law.narrowest, 1.0))
    slowest, error = slowest_wave(Waves(nodes, np.exp(log_mass), wait), law.narrowest)
    error += survival_error(cycle) * slowest * (float(law.edges[-1]) / min(law.narrowest, 1.0)) ** 2
    return (unit / slowest, unit * error / slowest**2) if slowest < _NOWHERE / wait else None


def tail_rate(cycle: Cycle) -> tuple[float, float]:
    """Rate (per length) at which log S falls far out, and its error: inf above, 0 below every exponential."""
    thresholds = cycle.law
    if np.isfinite(thresholds.support()[1]):
        return np.inf, 0.0
    # survival is looked at on the way out: far quantiles are beyond many a distribution
    x = cycle.unit * 2.0 ** np.arange(0.0, 400.0, 0.25)
    log_survival = thresholds.logsf(x)
    known = np.isfinite(log_survival)
    x, log_survival = x[known], log_survival[known]
    # beyond the smallest numbers there are, a part of a mixture may be all that is left
    first, last = np.searchsorted(-log_survival, -np.log(_TAILS)) - [0, 1]
    if first >= last:
        return np.inf, 0.0  # from hardly any decay to underflow within half an octave
    if x[last] > _SLOW * x[first]:
        return 0.0, 0.0
    x = np.geomspace(x[first], x[last], _TERMS)
    log_survival = thresholds.logsf(x)
    # log S = a - rate x + power log x + b/x + ...: with a term more each the rate settles, or it is no exponential
    u = x / x[-1]
    terms = np.stack([np.ones(u.size), -u, np.log(u), 1.0 / u, 1.0 / u**2])
    rates = [float(np.linalg.solve(terms[:n, -n:].T, log_survival[-n:])[1] / x[-1]) for n in (3, 4, _TERMS)]
    rounding = _ROUNDED * float(-log_survival[-1] / x[-1])
    change, rest = abs(rates[1] - rates[0]), abs(rates[2] - rates[1])
    if rates[2] > 0.0 and rest <= max(_SETTLED * change, rounding):
        return rates[2], rest + rounding
    slopes = -np.diff(log_survival) / np.diff(x)
    fall = -np.diff(slopes)
    if slopes[-1] > slopes[0]:
        return np.inf, 0.0
    if fall.sum() > _LITTLE * slopes[-1]:
        return 0.0, 0.0
    # exponentials whose rates are nearly the same, or something slower than any that looks like one as far as seen
    settles = (fall > 0.0).all() and fall[-1] < 0.5 * fall[0]
    return float(slopes[-1]), _MARGIN * float(fall[-1]) if settles else np.inf


def crowding_rate(law: Law) -> float:
    """Rate, in units of the law, at which its exact values alone let infinitely many roots crowd, ever faster waves;
    inf without any."""
    if not law.atoms.size:
        return np.inf

    shares = np.log(np.maximum(law.atom_weights, np.finfo(float).tiny))

    def held(rate: float) -> float:
        """Its logarithm: weights may be as small as heat leaves them."""
        return float(np.logaddexp.reduce(rate * law.atoms + shares))

    low, high = 0.0, 1.0 / float(law.atoms.max())
    while held(high) < 0.0:
        high *= 2.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if held(middle) < 0.0 else (low, middle)
    return low


def _slowest_root(law: Law, cycle: Cycle, rate: float) -> tuple[float, float]:
    """-Re s of the root s != 0 of p^(s) = 1 nearest the imaginary axis, and its error.

    Where none lies right of -rate and of -6 (in units of the mean threshold), inf, or the middle of what is left.
    """
    reach = min(0.9 * rate, _REACH)
    edges = tail_edges(law, cycle, reach)
    best = complex(-reach)
    broad = float(law.edges[-1]) > BROAD
    for start in _slow(law) if broad else _dips(law) + _slow(law) + _own_waves(law):
        best = _better(best, newton(law, edges, start, 1))
    if best.real < -0.3 and not broad:  # roots this far from the axis leave no dip on it
        for start in _grid(law, edges, -best.real):
            if start.real < best.real - 0.5:
                break
            best = _better(best, newton(law, edges, start, 1))
    if best == -reach and broad:
        return 1.0 / float(law.edges[-1]), np.inf  # so few live for so long that tables do not tell them from none
    if best == -reach:
        return (2.0 * _REACH, _REACH) if rate > _REACH else (np.inf, 0.0)
    fine = newton(law, edges, best, 2)
    error = abs(fine - best) + 2e-15 * (1.0 + abs(fine))
    noise = survival_error(cycle)
    if noise > 0.0:
        edges = known_edges(edges, cycle, noise)
        nodes, log_mass = wave_nodes(law, edges, 2.0 * abs(fine))
        error += transform_error(fine, noise, edges) / abs((np.exp(log_mass - fine * nodes) * nodes).sum())
    return -fine.real, error


def survival_error(cycle: Cycle) -> float:
    """Error of the survival of the cycle's law where that is known by tables or solutions; else 0."""
    tables = cycle.tabulated or cycle.release.born is not None
    return max(cycle.error, _TABLE) if tables else 0.0


def known_edges(edges: Array, cycle: Cycle, noise: float) -> Array:
    """`edges` up to where no more than `noise` survives: what lies beyond is not known."""
    last = float(cycle.law.isf(noise)) / cycle.unit
    return np.append(edges[edges < last], last)


def transform_error(s: complex, noise: float, edges: Array) -> float:
    """Error of p^(s) from a survival off by `noise` up to edges[-1]."""
    return noise * (1.0 + abs(s) / max(-s.real, 1e-3)) * float(np.exp(-s.real * edges[-1]))


def _better(best: complex, root: complex) -> complex:
    """The one nearer to the imaginary axis; s = 0 and what did not settle do not count."""
    counts = bool(np.isfinite(root)) and abs(root) > 1e-6 and best.real < root.real < -1e-14
    return root if counts else best


def tail_edges(law: Law, cycle: Cycle, reach: float) -> Array:
    """Panels out to where e^{reach x} P_c(x) is nothing: left of the imaginary axis the far tail counts."""
    if np.isfinite(law.support[1]):
        return law.edges
    far = cycle.law.isf(_FAR) / law.unit
    known = np.isfinite(far) & (far > 0.0)
    far, weight = far[known], np.log(_FAR[known]) + reach * far[known]
    if not far.size:
        return law.edges
    enough = np.flatnonzero((weight < -40.0) & (far > far[weight.argmax()]))
    return np.unique(np.concatenate([law.edges, far[: enough[0] + 1] if enough.size else far]))


def _slow(law: Law) -> list[complex]:
    """Guesses around s = 0 on the scale of rare thresholds far beyond the mean, whose roots leave no dip either."""
    longest = float(law.edges[-1])
    if longest < 6.0:
        return []
    # lives of all lengths, as of hot contacts: what decays slowly has to do with the longest
    fastest = _OF_LONGEST / longest if longest > BROAD else 1.5
    radius, angle = np.meshgrid(np.geomspace(0.5 / longest, fastest, 8), np.array([1.7, 2.1, 2.5, 2.9]))
    return [complex(guess) for guess in (radius * np.exp(1j * angle)).ravel()]


def _own_waves(law: Law) -> list[complex]:
    """The first roots of the heaviest exact value alone: those of the whole law beside them may leave no dip."""
    if not law.atoms.size:
        return []
    heaviest = int(law.atom_weights.argmax())
    if not (law.atom_weights[heaviest] > 0.0 and law.atoms[heaviest] > 0.0):
        return []  # heat leaves none of it
    turns = 2.0 * np.pi * np.arange(1.0, _CANDIDATES + 1.0)
    return [complex(s) for s in (np.log(law.atom_weights[heaviest]) + 1j * turns) / law.atoms[heaviest]]


def _grid(law: Law, edges: Array, reach: float) -> list[complex]:
    """Guesses within `reach` of the imaginary axis, nearest first: where a Newton step from a grid stays near."""
    real, imaginary = -np.arange(0.25, reach + 0.25, 0.25), np.arange(0.0, 10.1, 0.4)
    s = real + 1j * imaginary[:, None]
    nodes, log_mass = wave_nodes(law, edges, 12.0)
    with np.errstate(over="ignore", invalid="ignore"):
        # e^{-sx} is a growth times a wave: few of either make the whole grid
        growth, waves = np.exp(log_mass - real[:, None] * nodes).T, np.exp(-1j * imaginary[:, None] * nodes)
        step = (waves @ growth - 1.0) / ((waves * nodes) @ growth)
    guesses = (s + step)[np.abs(step) < 0.3]
    _, distinct = np.unique(np.round(guesses / 0.2), return_index=True)
    guesses = guesses[distinct]
    return [complex(guess) for guess in guesses[np.argsort(-guesses.real)] if abs(guess) > 0.3 and guess.imag > -0.2]


def _dips(law: Law) -> list[complex]:
    """Guesses left of the deepest dips of |1 - p^| along the imaginary axis, as a lattice transform shows them."""
    top = float(law.edges[-1])
    step = max(law.narrowest / 8.0, top / MOST_NODES)
    size = int(np.ceil(top / step)) + 16
    kernel = lay(lambda x: [law.pdf(x)], 1, law.edges, step, size)[0]
    kernel += deposit_atoms(law.atoms, law.atom_weights, step, size)
    length = next_fast_len(8 * size, real=True)
    transform = rfft(kernel, length)
    slope = rfft(kernel * step * np.arange(size), length)
    depth = np.abs(1.0 - transform)
    dips = np.flatnonzero((depth[1:-1] < depth[:-2]) & (depth[1:-1] <= depth[2:]) & (depth[1:-1] < 0.9)) + 1
    guesses = 2j * np.pi * dips / (length * step) + np.log(transform[dips]) * transform[dips] / slope[dips]
    return [complex(guess) for guess in guesses[np.argsort(-guesses.real)][:_CANDIDATES]]


def wave_nodes(law: Law, edges: Array, fastest: float) -> tuple[Array, Array]:
    """Nodes and log weights of P_c, close enough for waves e^{-sx} with |s| up to `fastest`."""
    left, right = edges[:-1], edges[1:]
    pieces = np.minimum(np.maximum(np.ceil((right - left) * fastest / 1.5), 1), 20_000).astype(int)
    share = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    width = np.repeat((right - left) / pieces, pieces)
    start = np.repeat(left, pieces) + share * width
    nodes, weights = gauss(start, start + width)
    nodes, mass = np.append(nodes, law.atoms), np.append(weights * law.pdf(nodes), law.atom_weights)
    keep = mass > 1e-300
    return nodes[keep], np.log(mass[keep] / mass.sum())


def newton(law: Law, edges: Array, s: complex, finer: int) -> complex:
    """Newton's method for p^(s) = 1; NaN where it does not settle. `finer` multiplies the nodes per wave."""
    start, fastest = s, max(abs(s), min(_RESOLVED, _TIMES * abs(s)))
    # slow guesses belong to long tails: nodes for waves that they never get to would be most of the work
    nodes, log_mass = wave_nodes(law, edges, finer * fastest)
    for _ in range(40):
        with np.errstate(over="ignore", invalid="ignore"):
            # one exponential of the sum: e^{-sx} alone overflows where P_c underflows
            wave = np.exp(log_mass - s * nodes)
            slope = (wave * nodes).sum()  # no @: threads cost more than so short a sum
            step = (wave.sum() - 1.0) / slope
        if not np.isfinite(step) or abs(s - start) > min(_ASTRAY, fastest):
            break
        s += step / max(1.0, 2.0 * abs(step))
        if abs(step) < 1e-13 * (1.0 + abs(s)) or abs(step * slope) < _NOISE * np.abs(wave).sum():
            return complex(s)
    return complex(np.nan, np.nan)
