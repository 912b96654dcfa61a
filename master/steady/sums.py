"""C and the kinetic force of contacts that break by heat, at many speeds at once.

A relaxed contact of threshold x_s that breaks by its own rate does so at min(x_s, x), where the rate integrated from 0
to x is J(x) = v ξ, with ξ drawn from the exponential law of mean 1. As a function of u = ln J the stretch x is smooth
at any temperature, and the speed only shifts the weight of u, so that the same stretches serve all speeds:

    C = <x_b>,    integral of the force = <k x_b^2>/2.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from master.numerics.table import Table
from master.steady.cycle import check_finite, thresholds_beyond
from master.survival.life import ALL_ATOMS
from origins import Contacts
from origins.thresholds.law import Array
from origins.thresholds.quadrature import NODES, finite_density, gauss, panel_edges

# Range of ln ξ: the shares of contacts that break below and above it are negligible.
LEAST_LOG, MOST_LOG = -32.0, 3.65
# ln ξ beyond which e^-ξ counts as 0; larger ln ξ are cut here to avoid overflow.
OVER = 7.0
# Panels of 8 nodes in u: of one width above ln ξ = EVEN, wider and wider ones below, where the weight is an
# exponential. The relative error of sums is then ROUND_OFF (measured).
EVEN, WIDTH, ROUND_OFF = -1.0, 0.6, 2e-12
# Panels next to the threshold, where the rate may vanish as a square root, as parts of the cube root of the distance
# in u: the stretch is smooth in this root. Where they are cut is measured.
CUTS = np.array([1.0, 0.8, 0.58, 0.33, 0.0])
# Last two Legendre coefficients on a panel of thresholds, in units of typical values, below which it is
# not halved (the error of its integral is about their square); and its least width, in mean thresholds.
ACCURACY, NARROWEST_PANEL = 1e-7, 1e-13
# Relative error of the force below which sums are taken as they are: better than the tables' usual accuracy.
SURE = 1e-9
# Thresholds are summed up to this survival.
TAIL = 1e-80


def is_summed(contacts: Contacts) -> bool:
    """Whether C and the integral of the force are sums over single contacts: they break at their thresholds or by heat
    alone, each at its own rate, and form again relaxed.

    Such sums serve all speeds at once, and resolve the strongest contacts, which bear F_k where the others hardly
    hold. `steady_state` takes them where they are more accurate than the integrals of a table of E (`Cycle`), which it
    needs for Q(x) anyhow; `kinetic_curve` makes no table where the sums are SURE.
    """
    by_itself = contacts.thermal is not None and contacts.thermal.closure == "exact"
    return by_itself and contacts.changing is None and contacts.reforming is None


class CycleSums(NamedTuple):
    """C (lengths), and the integral of the force over a cycle (lengths squared), at speeds; arrays of shape (n,)."""

    length: Array
    length_error: Array
    area: Array
    area_error: Array


def summed(contacts: Contacts, speeds: Array) -> CycleSums:
    """C and the integral of the force of contacts with heat (closure "exact"), born relaxed, at speeds of shape (n,).

    Their moments, <x_b> and <k x_b^2>, are summed together: arrays of shape (2, n), or with thresholds in between.
    """
    check_finite(contacts)
    law, unit = contacts.thresholds, contacts.mean_threshold
    moments = _break_moments(contacts, speeds)
    positions, weights = law.atoms
    total, off = np.zeros((2, 2, speeds.size))
    if positions.size:
        total += np.einsum("a,kas->ks", weights, moments(positions))
    if float(weights.sum()) < ALL_ATOMS:
        edges = panel_edges(law, tail=TAIL)
        at_edges = moments(np.maximum(edges, NARROWEST_PANEL * unit))
        parts = -np.diff(law.sf(edges))[:, None] * np.maximum(at_edges[:, 1:], at_edges[:, :-1])
        about = total + parts.sum(axis=1)
        scale = np.maximum(about, np.finfo(float).tiny) / unit
        # low speeds need the farthest thresholds, others take long there for nothing
        few = (parts < 1e-16 * about[:, None]).all(axis=(0, 2))
        first, last = np.flatnonzero(~few)[[0, -1]]
        off += parts[:, few].sum(axis=1)

        def integrand(xi: Array) -> Array:
            found = moments(xi.ravel()).transpose(0, 2, 1) / scale[..., None]
            return found.reshape(-1, *xi.shape) * finite_density(law, xi)

        table = Table(integrand, edges[first : last + 2], ACCURACY, NARROWEST_PANEL * unit)
        total += table.integrals().reshape(2, -1) * scale
        off += table.missed().reshape(2, -1) * scale
        off += thresholds_beyond(contacts, float(edges[-1]))[:, None]
    off += ROUND_OFF * total
    return CycleSums(total[0], off[0], 0.5 * total[1], 0.5 * off[1])


def _break_moments(contacts: Contacts, speeds: Array) -> Callable[[Array], Array]:
    """Mean x_b and k x_b^2 of relaxed contacts as a function of thresholds, at all speeds."""
    assert contacts.thermal is not None
    rates, log_speeds = contacts.thermal.rates, np.log(speeds)
    bottom, top = float(log_speeds.min()) + EVEN, float(log_speeds.max()) + MOST_LOG
    even = np.linspace(bottom, top, 2 + int((top - bottom) / WIDTH))
    wider = np.linspace(1.0, 0.0, 13)[:-1] ** 1.5  # the next to the even ones is 0.75 wide
    edges = np.append(bottom - (EVEN - LEAST_LOG) * wider, even)
    every_u, gauss_weights = (part.ravel() for part in gauss(edges[:-1], edges[1:]))
    at_speeds = gauss_weights[:, None] * _weight(every_u[:, None] - log_speeds)
    # the rate may vanish at the threshold: a panel must be at least its width away from it
    usable_from = edges[1:] + np.diff(edges)

    def moments(thresholds: Array) -> Array:
        """Shape (2, thresholds, speeds): sums over whole panels in u, and over the rest up to the threshold."""
        stiffness = np.asarray(contacts.relative_stiffness(thresholds))
        given = 0.0, thresholds[:, None], stiffness[:, None]
        ends = rates.log_passed(0.0, thresholds, thresholds, stiffness)
        whole = np.searchsorted(usable_from, ends, side="right")
        count = NODES * int(whole.max(initial=0))
        x = rates.reached(every_u[:count], *given)
        x = np.where(np.arange(count) < NODES * whole[:, None], x, 0.0)
        rest = np.exp(-np.exp(np.minimum(ends[:, None] - log_speeds, OVER)))
        limit, weights = thresholds[:, None], at_speeds[:count]
        out = np.stack([x @ weights + rest * limit, (x * x) @ weights + rest * limit**2])
        # from the last whole panel to the threshold
        end = np.clip(ends, edges[0], edges[-1])
        roots = np.cbrt(end - edges[whole])[:, None] * CUTS
        nodes, weights = (part.reshape(end.size, -1) for part in gauss(roots[:, 1:], roots[:, :-1]))
        u = end[:, None] - nodes**3
        x = 3.0 * nodes * nodes * weights * rates.reached(u, *given) ** [[[1.0]], [[2.0]]]
        for i, log_speed in enumerate(log_speeds):
            out[:, :, i] += np.einsum("nj,knj->kn", _weight(u - log_speed), x)
        out[1] *= stiffness[:, None]
        return out

    return moments


def _weight(log_xi: Array) -> Array:
    """Density of ln ξ."""
    power = np.minimum(log_xi, OVER)
    return np.asarray(np.exp(power - np.exp(power)))
