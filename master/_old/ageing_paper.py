"""Steady sliding of contacts that age, in the paper's closure: one P_c for all contacts (Eq. Q15).

P_c is the law of new thresholds and the histogram of those present at once. In the steady state it diffuses towards
P_cf and is reset to P_ci at the rate 1/C,

    D_X ∂/∂x (U' + ∂/∂x) P_c = (P_c - P_ci)/C,     C = <x>,     F_k/(N_c <k>) = <x²>/(2 C),

between a wall at the lower end of P_cf, which is 0 but for special laws, and one where nothing is left. Solved by
spectral elements of degree 15, and a second time by elements of degree 11 for the error.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_banded
from scipy.optimize import brentq

from master._old.effective_law import EffectiveLaw
from master._old.piecewise import Piecewise
from master._old.potential import Potential
from master._old.spectral_elements import SpectralElements
from master.outcome import WELL, judged
from origins import Ageing, Contacts, InputError, Thresholds
from origins.errors import positive
from origins.frozen import as_thresholds
from origins.quadrature import panel_edges

Array = npt.NDArray[np.float64]

_DEGREE, _LOWER_DEGREE = 15, 11
_TAIL = 1e-18
_ROUND_OFF = 1e-13
_FINEST = 0.02  # of the width of the narrower law
_DOUBLINGS = 2.0 ** np.arange(12.0)


@dataclass(frozen=True)
class AgeingSteadyState:
    """Steady sliding with one P_c for all contacts.

    Attributes
    ----------
    force : float
        F_k/(N_c <k>), a length.
    force_error : float
        Its error in units of the mean fresh threshold.
    mean_threshold : float
        C, the mean of P_c (a length): contacts break at the rate 1/C per unit of advance.
    holding : float
        Fraction of the contacts that hold: 1.
    thresholds : Thresholds
        P_c. Its density is cut at 0 where the series falls below, by the weight `positivity_defect`.
    positivity_defect : float
        Weight below zero.
    cycle_length_error : float
        Error of C in units of the mean fresh threshold.
    success : bool
        Whether the force is known to a thousandth of itself: no tolerance is asked for.
    message : str
        In words: what was reached.
    """

    force: float
    force_error: float
    mean_threshold: float
    thresholds: Thresholds = field(repr=False)
    positivity_defect: float
    cycle_length_error: float
    success: bool
    message: str
    holding: float = 1.0

    @property
    def cycle_length(self) -> float:
        """C (a length)."""
        return self.mean_threshold

    def distribution(self, x: npt.ArrayLike) -> Array:
        """Q_s(x) = S(x)/C per length for x >= 0 (a length), S the survival of P_c; 0 below; same shape as x."""
        x = np.asarray(x, dtype=float)
        return np.where(x >= 0.0, self.thresholds.sf(x) / self.mean_threshold, 0.0)[()]


def check_alone(contacts: Contacts) -> None:
    """Raise InputError for what (Q15) does not have."""
    for name in contacts.laws:
        if name != "ageing":
            raise InputError(
                f"contacts.{name}: (Q15), the paper's closure of ageing, does not have it; leave {name} out of the "
                'contacts, or use closure = "exact"'
            )


def paper_steady_state(fresh: object, ageing: Ageing, velocity: float = 1.0) -> AgeingSteadyState:
    """Steady state of (Q15) at the speed v = `velocity`, any final law, any D_X = D/v.

    fresh is P_ci, Thresholds or a frozen scipy.stats distribution on x >= 0; exact single values are allowed where
    only C and the force are asked for. Raises InputError for thresholds that the final law does not cover.
    """
    law = as_thresholds(fresh)
    ageing.check_fresh(law)
    diffusion = ageing.rate / positive("velocity", velocity)
    unit = law.mean()
    if diffusion == 0.0:
        force = 0.5 * law.moment(2) / unit
        message = judged("F_k", _ROUND_OFF, WELL)[1]
        return AgeingSteadyState(force, _ROUND_OFF * force / unit, unit, law, 0.0, _ROUND_OFF, True, message)
    end = ageing.final.support()[1]
    potential = Potential(ageing.final, min(end, max(float(law.isf(_TAIL)), float(ageing.final.isf(_TAIL)))))
    edges = _edges(law, ageing.final, potential, diffusion * unit)
    better = _Histogram(law, ageing.final, potential, diffusion, SpectralElements(edges, _DEGREE))
    worse = _Histogram(law, ageing.final, potential, diffusion, SpectralElements(edges, _LOWER_DEGREE))
    error = abs(better.force - worse.force) / unit + _ROUND_OFF * better.force / unit
    mean_error = abs(better.mean - worse.mean) / unit + _ROUND_OFF * better.mean / unit
    thresholds, defect = better.thresholds()
    success, message = judged("F_k", error * unit / better.force, WELL)
    return AgeingSteadyState(
        better.force, error, better.mean, thresholds, defect, mean_error, bool(success), message
    )


def gaussian_force(
    fresh_mean: float, fresh_square: float, mean: float, std: float, diffusion: npt.ArrayLike
) -> tuple[Array, Array]:
    """C and F_k/(N_c <k>) (lengths) in closed form for a normal final law of `mean` and `std`.

    fresh_mean and fresh_square are <x> and <x²> of P_ci, `diffusion` any D_X >= 0 (lengths), an array; both results
    have its shape. The normal law is not cut at 0 and there is no wall: exact where nothing comes near 0.
    """
    rate = np.asarray(diffusion, dtype=float) / std**2
    # λ C² + (1 - λ mean) C - fresh mean = 0, the root that stays for λ = 0, without cancellation
    half = 0.5 * (1.0 - rate * mean)
    root = np.sqrt(half * half + rate * fresh_mean)
    with np.errstate(divide="ignore", invalid="ignore"):
        c = np.where(half > 0.0, fresh_mean / (half + root), (root - half) / rate)
    first, second = 1.0 / (1.0 + rate * c), 1.0 / (1.0 + 2.0 * rate * c)
    off = fresh_mean - mean
    # of <(x - mean)²> and of 2 mean <x - mean>
    square = std**2 + (fresh_square - 2.0 * mean * fresh_mean + mean**2 - std**2) * second
    square = square + mean**2 + 2.0 * mean * off * first
    return c, 0.5 * square / c


def _edges(fresh: Thresholds, final: Thresholds, potential: Potential, blur: float) -> Array:
    """Ends of elements that follow both laws, and what diffusion leaves of corners: blur is D_X C, a length squared."""
    lower, upper = float(potential.edges[0]), float(potential.edges[-1])
    own = np.concatenate([panel_edges(fresh), panel_edges(final), potential.edges])
    centres = np.array([float(law.ppf(0.5)) for law in (fresh, final)])
    widths = np.array([float(law.isf(0.1) - law.ppf(0.1)) for law in (fresh, final)])
    corners = np.concatenate([fresh.breakpoints, fresh.atoms[0]])
    layer = np.full(corners.size, 0.5 * np.sqrt(blur))
    around = np.concatenate([widths, layer])[:, None] * np.concatenate([-_DOUBLINGS, [0.0], _DOUBLINGS])
    points = np.concatenate([own, (np.concatenate([centres, corners])[:, None] + around).ravel(), final.breakpoints])
    points = np.unique(np.append(points[(points > lower) & (points < upper)], [lower, upper]))
    # narrower elements would show nothing but rounded differences
    apart = max(min(_FINEST * float(widths.min()), 0.4 * np.sqrt(blur)), 1e-9 * (upper - lower))
    kept = [lower]
    for point in points:
        if point - kept[-1] >= apart and upper - point >= apart:
            kept.append(float(point))
    return np.array([*kept, upper])


class _Histogram:
    """P_c on given elements: its mean is the C that it was reset with."""

    def __init__(
        self, fresh: Thresholds, final: Thresholds, potential: Potential, diffusion: float, elements: SpectralElements
    ) -> None:
        self._elements = elements
        size, degree = elements.nodes.size, elements.degree
        row = np.broadcast_to(elements.index[:, :, None], (elements.index.shape[0], degree + 1, degree + 1))
        column = np.broadcast_to(elements.index[:, None, :], row.shape)
        slope = potential.slope(elements.nodes)
        flow = elements.flow(diffusion * slope, diffusion)
        place = ((degree + row - column) * size + column).ravel()
        self._flow = np.bincount(place, flow.ravel(), minlength=(2 * degree + 1) * size).reshape(-1, size)
        self._source = elements.weights * elements.project(fresh.pdf, panel_edges(fresh))
        for atom, weight in zip(*fresh.atoms, strict=True):
            self._source += weight * elements.weights * elements.point(float(atom))
        self._source /= self._source.sum()
        # C lies between the means of the two laws
        low, high = sorted([fresh.mean(), final.mean()])
        c = brentq(lambda mean: self._mean(mean) - mean, 0.5 * low, 2.0 * high, xtol=1e-300, rtol=1e-14)
        self.values = self._solve(c)
        mass = elements.weights * self.values
        self.mean = float(mass @ elements.nodes)
        self.force = 0.5 * float(mass @ elements.nodes**2) / self.mean

    def _mean(self, c: float) -> float:
        return float((self._elements.weights * self._solve(c)) @ self._elements.nodes)

    def _solve(self, c: float) -> Array:
        """P_c at the nodes, reset at the rate 1/c."""
        degree, weights = self._elements.degree, self._elements.weights
        band = -c * self._flow
        band[degree] += weights
        found = solve_banded((degree, degree), band, self._source, overwrite_ab=True, check_finite=False)
        return found / float(weights @ found)

    def thresholds(self) -> tuple[EffectiveLaw, float]:
        """P_c as a law, and its weight below 0."""
        elements = self._elements
        mass = elements.weights * self.values
        series = Piecewise(elements.edges - elements.edges[0], elements.series(self.values))
        law = EffectiveLaw(series, float(elements.edges[0]), root=False, onset_power=0.0)
        return law, abs(float(mass[mass < 0.0].sum()))
