"""F on a forward path by the renewal equation of breaks, on even steps that are halved and extrapolated.

A second road to the master equation's answers, with which it shares the laws of contacts alone: here densities of
breaks and the trapezoidal rule, there survivals, number conservation and panels of polynomials.
"""

from functools import partial

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError
from origins.laws.thermal import Thermal
from origins.thresholds.law import Array
from toolkit.stability.case import Truth
from toolkit.stability.diffusing import aged_lives

COARSEST = 256  # steps of a path; delays are whole numbers of them
_HALVINGS = 4
_NODES = 48  # of thresholds on the coarsest steps, and as many again on each finer ones
_RATES = "soft", "stiff", "eyring"  # whose equations are written out in `rate_of` and `_passed`
_FORGOTTEN = 1e-18  # share of thresholds on either side that is left out


def by_renewal(contacts: Contacts, path: Array, velocity: float = 1.0) -> Truth:
    """F of relaxed contacts, or of contacts from one stretch >= 0, in mean thresholds.

    Laws: a delay, and soft, stiff or eyring heat in the exact closure, linked stiffness, or ageing of relaxed contacts
    towards a Gaussian. The path has even steps from 0, whose number divides COARSEST. With p the density of breaks, w
    the delay, and b breaks per contact and length,

        b(X) = b_0(X) + ∫ p(s) b(X - w - s) ds,    F(X) = M_0(X) + ∫ x E(s) b(X - w - s) ds.

    The error is bounded by the last step of an extrapolation that assumes less than the values do. Raises InputError
    for a spread start, for one below 0, and for other laws.
    """
    others = contacts.changing is not None and contacts.ageing is None
    if others or contacts.reforming is not None or not isinstance(contacts.thermal, Thermal | None):
        raise InputError("contacts: here only with a delay, heat, linked stiffness or ageing")
    if contacts.thermal is not None and contacts.thermal.law not in _RATES:
        raise InputError(f"contacts.thermal: {contacts.thermal.law!r} is not written out here")
    if not contacts.start.is_single or contacts.start.mean() < 0.0:
        raise InputError("start: here only of one stretch, which is 0 or more")
    every = COARSEST // (path.size - 1)
    found = [
        _force(contacts, float(path[-1]), velocity, fine)[:: every * 2**fine]
        for fine in range(_HALVINGS + 1)
    ]
    rows = np.array(found) / contacts.mean_threshold
    # errors of trapezoids are of even orders
    for order in (4.0, 16.0):
        rows = (order * rows[1:] - rows[:-1]) / (order - 1.0)
    error = float(np.abs(rows[-1] - rows[-2]).max()) + 1e-13
    return Truth(rows[-1], error, "the renewal equation on even steps, extrapolated")


def _force(contacts: Contacts, length: float, velocity: float, halvings: int) -> Array:
    """F at all steps of a path, COARSEST of them with so many halvings; a length."""
    steps = COARSEST * 2**halvings
    h, travel = length / steps, length * np.arange(steps + 1) / steps
    first = contacts.start.mean()
    if contacts.ageing is None:
        lives = partial(_lives, contacts, velocity, travel=travel, nodes=_NODES * (1 + halvings))
        density, borne = lives(first=0.0)
        density_of_start, force = (density, borne.copy()) if first == 0.0 else lives(first=first)
    else:
        density, borne = aged_lives(contacts, velocity, travel, halvings)
        density_of_start, force = density, borne.copy()
    delay = 0.0 if contacts.delay is None else contacts.delay.time * velocity
    lag, breaks = round(delay / h), density_of_start.copy()

    def sums(kernel: Array, place: int) -> float:
        """The integral up to a place, without the share of the last births."""
        until = place - lag
        inner = kernel[until - 1 : 0 : -1] @ breaks[1:until] if until > 1 else 0.0
        return h * (inner + 0.5 * kernel[until] * breaks[0])

    for place in range(lag + 1, steps + 1):
        breaks[place] += sums(density, place)
        if lag:
            breaks[place] += 0.5 * h * density[0] * breaks[place - lag]
        else:
            breaks[place] /= 1.0 - 0.5 * h * density[0]
    # the last births bear nothing yet
    force[lag + 1 :] += [sums(borne, place) for place in range(lag + 1, steps + 1)]
    return force


def _lives(
    contacts: Contacts, velocity: float, first: float, travel: Array, nodes: int
) -> tuple[Array, Array]:
    """Density of breaks per length, and force, of contacts that formed at the stretch `first`, by the way since."""
    law, x, linked = contacts.thresholds, first + travel, contacts.stiffness == "linked"
    all_of_them = float(law.sf(first))
    if contacts.thermal is None and not linked:
        return law.pdf(x) / all_of_them, x * law.sf(x) / all_of_them
    heat = contacts.thermal
    assert isinstance(heat, Thermal | None)
    place, weight = np.polynomial.legendre.leggauss(nodes)
    place, weight = 0.5 * (place + 1.0), 0.5 * weight
    end = float(law.isf(_FORGOTTEN))
    x = np.minimum(x, end)  # beyond, no contact is left
    begin = np.maximum(x, float(law.ppf(_FORGOTTEN)))[:, None]
    # squares of the nodes, as the rate of stiff contacts has a root at their threshold
    limit = begin + (end - begin) * place**2
    fraction = 2.0 * weight * place * (end - begin) * law.pdf(limit) / all_of_them
    stretch = x[:, None]
    alive, at_limit, rate = fraction, np.ones_like(x), np.zeros_like(fraction)
    if heat is not None:
        passed = _passed(heat, stretch, limit) - _passed(heat, first, limit)
        alive = fraction * np.exp(-passed / velocity)
        at_limit = np.exp(-(_passed(heat, x, x) - _passed(heat, first, x)) / velocity)
        rate = rate_of(heat, stretch, limit) / velocity
    breaks = law.pdf(first + travel) / all_of_them * at_limit + (alive * rate).sum(axis=1)
    borne = alive * (limit / contacts.mean_threshold if linked else 1.0)
    return breaks, x * borne.sum(axis=1)


def rate_of(heat: Thermal, x: Array, limit: Array) -> Array:
    """h of contacts with <k>, by the formulas of origins.Thermal."""
    s = np.maximum(1.0 - x / limit, 0.0)
    if heat.law not in _RATES:
        raise InputError(f"contacts.thermal: {heat.law!r} is not written out here")
    if heat.law == "eyring":
        return heat.attempt_frequency * np.exp(-s / dict(heat.own)["width"])
    warmth = 2.0 * float(heat.temperature or 0.0)
    if heat.law == "soft":
        return heat.attempt_frequency * np.exp(-(limit**2) * s * (2.0 - s) / warmth)
    return heat.attempt_frequency * np.sqrt(s) * np.exp(-(limit**2) * s**1.5 / warmth)


def _passed(heat: Thermal, x: Array | float, limit: Array) -> Array:
    """The integral of h from the stretch 0 to x, a length per time."""
    from scipy.special import dawsn

    s = np.maximum(1.0 - x / np.where(limit > 0.0, limit, 1.0), 0.0)
    if heat.law == "eyring":
        width = dict(heat.own)["width"]
        whole = width * limit * (np.exp(-s / width) - np.exp(-1.0 / width))
    elif heat.law == "soft":
        root = np.sqrt(2.0 * float(heat.temperature or 0.0))
        # exp((x² - limit²)/root²) times Dawson's integral
        whole = root * np.exp((x**2 - limit**2) / root**2) * dawsn(x / root)
    else:
        barrier = limit**2 / (2.0 * float(heat.temperature or 0.0))
        slope = np.exp(-barrier * s**1.5) - np.exp(-barrier)
        whole = 2.0 * limit / 3.0 * slope / np.where(barrier > 0.0, barrier, 1.0)
    return heat.attempt_frequency * whole
