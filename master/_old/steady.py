"""Smooth sliding: the state that no longer depends on X (paper Eqs. Q11a-Q11d)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master._old.break_sums import summable, summed
from master._old.breaking_law import BreakingLaw
from master._old.cycle import Cycle
from master._old.effective_law import EffectiveLaw
from master._old.law import Law
from master._old.reborn_cold import integrals
from master._old.release import Release
from master._old.starting import StartSum
from master.outcome import WELL, judged
from origins import Contacts, InputError, Thresholds
from origins.contacts import LAWS, check_contacts
from origins.errors import positive, refuse
from origins.thresholds.quadrature import gauss, panel_edges

if TYPE_CHECKING:
    from master.paper.q15_steady import AgeingSteadyState

Array = npt.NDArray[np.float64]

_ROUND_OFF = 4e-16
_REACHED = 1e-9
_WELL = 1e-9  # of the force: tables are good
_MARGIN = 2.0
_TOO_SLOW = "contacts break before they have moved a length that is a number; slide faster"
TABLES = 1e-11  # relative error of what rests on tables of breaks by a rate


@dataclass(frozen=True)
class SteadyState:
    """Steady sliding, whatever the start.

    Attributes
    ----------
    force : float
        F_k/(N_c <k>), a length. Where contacts form again at once and relaxed, and all are equally stiff, it is
        <x_b^2>/(2 <x_b>); x_b is the stretch at which a contact breaks, x_s at T = 0.
    force_error : float
        Its error in units of the mean threshold: the difference from the same by integrals over what holds.
    holding : float
        Fraction of the contacts that hold, C/(C + v tau).
    mean_threshold : float
        <x_s>, a length.
    cycle_length : float
        C, how far the slider moves between a contact's birth and its break on the average: <x_b - r>.
    cycle_length_error : float
        Its error in units of the mean threshold.
    success : bool
        Whether the force is known to a thousandth of itself: no tolerance is asked for.
    message : str
        In words: what was reached.
    """

    force: float
    force_error: float
    holding: float
    mean_threshold: float
    cycle_length: float
    cycle_length_error: float
    success: bool
    message: str
    _contacts: Contacts = field(repr=False)
    _cycle: Cycle = field(repr=False)

    def distribution(self, x: npt.ArrayLike) -> Array:
        """Q_s(x) per length at stretches x (lengths), of all contacts; same shape as x."""
        x = np.asarray(x, dtype=float)
        born, cycle = self._contacts.reforming, self._cycle
        each = self.holding / self.cycle_length
        if born is None:
            return np.where(x >= 0.0, self._cycle.relaxed.sf(x) * each, 0.0)[()]
        if born.law.is_single:
            start = born.law.mean()
            held = cycle.survived(cycle.births, np.full(x.shape, start), np.maximum(x, start))
            return np.where(x >= start, held * each, 0.0)[()]
        reborn = Contacts(self._contacts.thresholds, born.law)
        spread = StartSum(reborn, Law(reborn, np.inf))
        unit = self.mean_threshold
        out = np.zeros(x.size)
        for i, at in enumerate(x.ravel() / unit):
            edges = np.append(spread.edges, [-abs(at), min(at, spread.high)])
            edges = np.unique(edges[(edges <= at) & (edges >= spread.low)])
            if edges.size > 1:
                nodes, weights = gauss(edges[:-1], edges[1:])
                held = cycle.survived(cycle.births, nodes * unit, np.full(nodes.shape, at * unit))
                out[i] = float((weights * spread.density(nodes) * held).sum()) * each
        return out.reshape(x.shape)[()]


def steady_state(contacts: Contacts, *, velocity: float = 1.0) -> SteadyState | AgeingSteadyState:
    """Kinetic force and distribution of stretches in steady sliding at `velocity` (length per time; only rates, ageing
    and delay tell).

    Raises InputError where <x_s^2>, with linked stiffness <x_s^3>, is infinite: then the force grows for ever and there
    is no steady state.
    """
    check_contacts(contacts, "master.steady_state", LAWS)
    if contacts.ageing is not None and contacts.ageing.closure == "paper":
        from master.paper.q15_steady import check_alone, paper_steady_state

        check_alone(contacts)
        return paper_steady_state(contacts.thresholds, contacts.ageing, positive("velocity", velocity))
    check_finite(contacts)
    return steady_of(contacts, Cycle(contacts, positive("velocity", velocity)))


def check_finite(contacts: Contacts) -> None:
    """InputError where the kinetic force is infinite. At a temperature as well: the stronger a contact, the less it
    breaks before its threshold. Thresholds that diffuse leave theirs, and those that grow have a strongest."""
    if contacts.ageing is not None or contacts.grains is not None:
        return
    power = 3 if contacts.stiffness == "linked" else 2
    if not np.isfinite(contacts.thresholds.moment(power)):
        raise InputError(
            f"thresholds: <x_s^{power}> is infinite, and with it the kinetic force: the force grows for ever; use a "
            f"law whose tail falls faster than x^-{power + 1}"
        )


def steady_of(contacts: Contacts, cycle: Cycle) -> SteadyState:
    """The same, of contacts whose cycle is known, after `check_finite`."""
    if contacts.reforming is not None and cycle.breaking is None:
        return _steady(contacts, cycle, _reborn_cold(contacts, cycle))
    if contacts.reforming is not None and summable(contacts):
        known = _summed(contacts, cycle)
        if not np.isfinite(known[1]):
            refuse("velocity", cycle.velocity, _TOO_SLOW)
        return _steady(contacts, cycle, known)
    length, area, again_length, again_area = _cycle_integrals(contacts, cycle)
    wait, law, far_off = cycle.wait, cycle.relaxed, np.zeros(2)
    if isinstance(law, BreakingLaw) and cycle.release.born is None and not cycle.release.stiffness:
        last, far, far_off = (part.tolist() for part in law.beyond())
        length, area = length + last[0] + far[0], area + last[1] + far[1]
        again_length, again_area = again_length + far[0], again_area + far[1]
    # contacts that form again behind x = 0 and break before they get there bear less than nothing
    if not ((area > 0.0 or cycle.release.born is not None) and length > 0.0 and again_length > 0.0):
        refuse("velocity", cycle.velocity, _TOO_SLOW)
    force = area / (length + wait)
    if not np.isfinite(again_area / again_length):
        raise InputError("thresholds: the distribution's own survival is not a number; use milder parameters")
    # where the law is a solution with an error of its own, tables are better than that
    rounding = TABLES if cycle.tabulated and cycle.error == 0.0 else _ROUND_OFF
    # of two sums over tables either may be the one that is off, and the other a little
    margin = _MARGIN if cycle.tabulated else 1.0
    off = margin * abs(force - again_area / (again_length + wait)) + rounding * abs(force)
    length_off = margin * abs(length - again_length) + rounding * length + far_off[0]
    off += (far_off[1] + abs(force) * far_off[0]) / (length + wait)
    if cycle.error > 0.0:
        # an error of the survival up to where hardly any holds
        reach = float(cycle.relaxed.isf(_REACHED))
        off = float(off + cycle.error * (0.5 * reach**2 + force * reach) / (length + wait))
        length_off += cycle.error * reach
    known = force, float(off), length, float(length_off)
    if cycle.tabulated and off > _WELL * abs(force) and contacts.reforming is None and summable(contacts):
        # tables of cold stretches at which contacts break are narrower than x is known
        known = min(known, _summed(contacts, cycle), key=lambda one: one[1])
    return _steady(contacts, cycle, known)


def _steady(contacts: Contacts, cycle: Cycle, known: tuple[float, float, float, float]) -> SteadyState:
    """From the force, C and their errors, lengths."""
    force, off, length, length_off = known
    success, message = judged("F_k", off / max(abs(force), WELL * contacts.mean_threshold), WELL)
    return SteadyState(
        force=force,
        force_error=off / contacts.mean_threshold,
        holding=length / (length + cycle.wait),
        mean_threshold=contacts.mean_threshold,
        cycle_length=length,
        cycle_length_error=length_off / contacts.mean_threshold,
        success=bool(success),
        message=message,
        _contacts=contacts,
        _cycle=cycle,
    )


def _reborn_cold(contacts: Contacts, cycle: Cycle) -> tuple[float, float, float, float]:
    """Force, C and their errors (lengths) of contacts that form again at T = 0."""
    (length, area), (length_off, area_off) = (part.tolist() for part in integrals(contacts, cycle.births))
    force = area / (length + cycle.wait)
    return force, (area_off + abs(force) * length_off) / (length + cycle.wait), length, length_off


def _summed(contacts: Contacts, cycle: Cycle) -> tuple[float, float, float, float]:
    """Force, C and their errors (lengths) by sums over contacts."""
    force, off, length, length_off = (float(row[0]) for row in summed(contacts, np.array([cycle.velocity])))
    share = length / (length + cycle.wait)
    off = off * share + abs(force) * share * (1.0 - share) * length_off / length
    return force * share, off, length, length_off


def _cycle_integrals(contacts: Contacts, cycle: Cycle) -> tuple[float, float, float, float]:
    """C and the force integrated from a birth to its break: from what breaks release, and from what holds."""
    law, release, unit = cycle.relaxed, cycle.release, cycle.unit
    if release.born is not None:
        return _born_integrals(release, unit)
    moment = law.moment(3 if release.stiffness and cycle.breaking is None else 2)
    if isinstance(law, BreakingLaw | EffectiveLaw) and not release.stiffness:
        # all hold before the law begins
        edges = np.unique(np.append(0.0, law.panels))
        nodes, weights = gauss(edges[:-1], edges[1:])
        held = weights * law.sf(nodes)
        return law.mean(), 0.5 * moment, float(held.sum()), float((held * nodes).sum())
    if not release.stiffness:
        return law.mean(), 0.5 * moment, *_survival_integrals(law)
    if cycle.breaking is None:
        edges = panel_edges(law)
        nodes, weights = gauss(edges[:-1], edges[1:])
        positions, shares = law.atoms
        again = float((weights * law.pdf(nodes) * nodes**3).sum()) + float(shares @ positions**3)
        return unit, 0.5 * moment / unit, unit, 0.5 * again / unit
    assert release.relaxed is not None
    edges = release.relaxed.edges
    edges = np.sort(np.append(edges, 0.5 * (edges[1:] + edges[:-1])))
    nodes, weights = gauss(edges[:-1], edges[1:])
    positions, shares = law.atoms
    area = float((weights * release.relaxed(nodes) * nodes**2).sum())
    area += float((shares * contacts.relative_stiffness(positions)) @ positions**2)
    rows = cycle.breaking.rows(nodes.ravel())
    held = weights.ravel() * nodes.ravel() * rows[3]
    return unit, 0.5 * area, float((weights.ravel() * rows[1]).sum()), float(held.sum())


def _born_integrals(release: Release, unit: float) -> tuple[float, float, float, float]:
    """The same after births at other stretches than 0, from the tables of their breaks."""
    born = release.born
    assert born is not None
    edges = np.unique(np.concatenate([[0.0], born.density.edges, born.atoms]))
    edges = np.sort(np.append(edges, 0.5 * (edges[1:] + edges[:-1])))
    s, weights = gauss(edges[:-1], edges[1:])
    breaks, force = weights * born.density(s), weights * born.rate(s)
    stiff = breaks if born.stiffness is None else weights * born.stiffness(s)
    at = born.atoms
    length = float((breaks * s).sum()) + float(born.atom_weights @ at)
    area = float((force * s).sum()) + float(born.atom_released @ at)
    area -= 0.5 * (float((stiff * s * s).sum()) + float(born.atom_stiffness @ at**2))
    held = release.birth_force + release.birth_stiffness * s - born.released(s) - born.softened.twice(s)
    again = float((weights * (1.0 - born.count.once(s))).sum()), float((weights * held).sum())
    return length * unit, area * unit**2, again[0] * unit, again[1] * unit**2


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
