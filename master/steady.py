"""Smooth sliding: the state that no longer depends on X (paper Eqs. Q11a-Q11d)."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from origins import Contacts, InputError, Thresholds
from origins.contacts import check_contacts
from origins.quadrature import gauss, panel_edges

if TYPE_CHECKING:
    from master.ageing_paper import AgeingSteadyState

Array = npt.NDArray[np.float64]

_ROUND_OFF = 4e-16


@dataclass(frozen=True)
class SteadyState:
    """Steady sliding at T = 0, whatever the start; for contacts that age x_s is the stretch at which they break.

    Attributes
    ----------
    force : float
        F_k/(N_c <k>) = <x_s^2>/(2 <x_s>), a length.
    force_error : float
        Its error in units of the mean threshold: the difference from the integral of x S(x) over that of S(x).
    mean_threshold : float
        C = <x_s>, a length.
    """

    force: float
    force_error: float
    mean_threshold: float
    _thresholds: Thresholds = field(repr=False)

    def distribution(self, x: npt.ArrayLike) -> Array:
        """Q_s(x) = S(x)/C per length for x >= 0 (a length), 0 below; same shape as x."""
        x = np.asarray(x, dtype=float)
        return np.where(x >= 0.0, self._thresholds.sf(x) / self.mean_threshold, 0.0)[()]


def steady_state(contacts: Contacts, *, velocity: float = 1.0) -> "SteadyState | AgeingSteadyState":
    """Kinetic force and distribution of stretches in steady sliding at `velocity` (length per time), which only ageing
    tells.

    Raises InputError where <x_s^2> is infinite: then the force grows for ever and there is no steady state.
    """
    if isinstance(contacts, Contacts) and contacts.ageing is not None:
        from master.ageing import steady_ageing

        return steady_ageing(contacts, velocity)
    check_contacts(contacts, "master.steady_state")
    thresholds = contacts.thresholds
    mean, square = contacts.mean_threshold, thresholds.moment(2)
    if not np.isfinite(square):
        raise InputError(
            "thresholds: <x_s^2> is infinite, and with it the kinetic force <x_s^2>/(2 <x_s>): the force grows for "
            "ever; use a law whose tail falls faster than x^-3"
        )
    force = 0.5 * square / mean
    length, area = _survival_integrals(thresholds)
    if not (np.isfinite(length) and np.isfinite(area)):
        raise InputError("thresholds: the distribution's own survival is not a number; use milder parameters")
    error = abs(force - area / length) / mean + _ROUND_OFF * force / mean
    return SteadyState(force=force, force_error=error, mean_threshold=mean, _thresholds=thresholds)


def _survival_integrals(thresholds: Thresholds) -> tuple[float, float]:
    """Integrals of S(x) and of x S(x) over x >= 0."""
    lower, upper = thresholds.support()
    edges = np.unique(np.concatenate([panel_edges(thresholds), thresholds.atoms[0], [lower]]))
    if not np.isfinite(upper):
        # a tail that falls as a power is resolved by panels that grow with x
        far = edges[-1] * 2.0 ** np.arange(1.0, 400.0)
        far = far[far < 1e150]
        reached = np.flatnonzero(~(thresholds.sf(far) > 0.0))
        edges = np.concatenate([edges, far[: reached[0]] if reached.size else far])
    if edges.size < 2:
        return lower, 0.5 * lower**2
    nodes, weights = gauss(edges[:-1], edges[1:])
    mass = weights * thresholds.sf(nodes)
    return lower + float(mass.sum()), 0.5 * lower**2 + float((mass * nodes).sum())
