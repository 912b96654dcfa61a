"""Which `Lives` the contacts' laws ask for."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigh_tridiagonal

from master._old.law import Law
from master._old.lives import Lives
from master._old.starting import StartSum
from origins import Contacts

if TYPE_CHECKING:
    from master._old.ageing_generations import AgeingGenerations
    from master._old.generations import Generations
    from master._old.timeline import Piece
    from master._old.wear import Wear

Array = npt.NDArray[np.float64]
Nodes = tuple[Array, Array]

_NARROW = 1e-9  # of the mean threshold: below, all stand at one stretch
_BIRTHS = 8
_STARTS = 24
_TAIL = 1e-19
_MOST_LIMITS = 12
_NEAR = 0.3  # of the width of the law: births so close to its broken power feel it


def make_lives(contacts: Contacts, level: int = 0) -> Lives:
    """Cohorts of contacts whose thresholds grow, none born yet; inner meshes halved `level` times."""
    assert contacts.grains is not None and contacts.grains.age is not None
    return _growing(contacts, _nodes(contacts, Law(contacts, np.inf)), contacts.grains.age, level)


def _growing(contacts: Contacts, start: Nodes, age: float, level: int) -> Lives:
    """Cohorts of contacts whose thresholds grow with age."""
    if contacts.thermal is None:
        from master._old.grain_lives import GrainLives

        return GrainLives(contacts, start, age)
    from master._old.warm_grain_lives import WarmGrainLives

    return WarmGrainLives(contacts, gathered(*start, _STARTS + 8 * level), age, level)


def make_generations(contacts: Contacts, course: "list[Piece]", level: int = 0) -> "Generations | AgeingGenerations":
    """The same contacts, none born yet, on panels; but for those whose thresholds grow."""
    from master._old.generations import Generations
    from master._old.layer_spent_wear import LayerSpentWear
    from master._old.layer_wear import LayerWear, reaches

    if contacts.ageing is not None:
        from master._old.ageing_generations import AgeingGenerations

        return AgeingGenerations(contacts, level, *_ageing_nodes(contacts, level))
    law = contacts.thresholds
    limits = np.append(law.breakpoints, law.atoms[0]) if law.breakpoints.size <= _MOST_LIMITS else law.atoms[0]
    places = np.array([0.0, *(piece.after for piece in course)])
    again = 0.0 if contacts.reforming is None else float(np.abs(contacts.reforming.law.span).max())
    furthest = float(np.ptp(places)) + max(float(np.abs(contacts.start.span).max()), again)
    longest = course[-1].end if course else 1.0
    wear, start, births = _ingredients(contacts, level, furthest, longest)
    rough = law.support()[0] == 0.0 and not float(law.onset_power).is_integer()
    rough &= bool(np.abs(births[0]).min() < _NEAR * wear.length)
    limits = limits[limits > 0.0]
    if isinstance(wear, LayerWear | LayerSpentWear) and limits.size:
        limits = np.append(limits, reaches(contacts, limits, course))
    return Generations(wear, start, births, course, limits, rough, level)


def _ingredients(
    contacts: Contacts, level: int, furthest: float = np.inf, longest: float = np.inf
) -> "tuple[Wear, Nodes, Nodes]":
    """What single contacts keep of the past; stretches of the start and of births, and with each its weight over
    S(|r|). None is stretched further, in size, or watched for longer."""
    from master._old.wear import ColdWear

    law = Law(contacts, np.inf)
    length = law.narrowest * contacts.mean_threshold
    wear: Wear
    if contacts.thermal is None:
        wear = ColdWear(contacts, length)
    else:
        wear = _warm(contacts, length, furthest, longest)
    again = (np.zeros(1), np.ones(1))
    if contacts.reforming is not None:
        again = gathered(*_nodes(Contacts(contacts.thresholds, contacts.reforming.law), law), _BIRTHS + 4 * level)
        again = again[0], again[1] / contacts.thresholds.sf(np.abs(again[0]))
    start = _nodes(contacts, law)
    return wear, (start[0], start[1] / contacts.thresholds.sf(np.abs(start[0]))), again


def _ageing_nodes(contacts: Contacts, level: int) -> tuple[Nodes, Nodes]:
    """Stretches of the start and of births, and weights of sum 1."""
    law, again = Law(contacts, np.inf), (np.zeros(1), np.ones(1))
    start = gathered(*_nodes(contacts, law), _STARTS + 8 * level)
    if contacts.reforming is not None:
        again = gathered(*_nodes(Contacts(contacts.thresholds, contacts.reforming.law), law), _BIRTHS + 4 * level)
    return start, again


def _warm(contacts: Contacts, length: float, furthest: float, longest: float) -> "Wear":
    """The wear that temperature causes."""
    thermal = contacts.thermal
    assert thermal is not None
    if thermal.closure == "paper":
        from master._old.paper_wear import PaperWear

        return PaperWear(contacts, length)
    from master._old.cut_law import CutLaw
    from master._old.layer_wear import LayerWear
    from master._old.thermal_wear import SoftWear, resolved

    cut = CutLaw(contacts, resolved(contacts, furthest, longest), _TAIL, rooted=thermal.rates.vanishes_at_threshold)
    if not thermal.rates.vanishes_at_threshold and contacts.stiffness == "independent":
        if cut.spread > 1.0:
            return LayerWear(contacts, length)
        return SoftWear(contacts, cut, length)
    if cut.spread > 1.0:
        from master._old.layer_spent_wear import LayerSpentWear

        return LayerSpentWear(contacts, length, longest)
    from master._old.spent_wear import SpentWear

    return SpentWear(contacts, cut, length)


def _nodes(contacts: Contacts, law: Law) -> tuple[Array, Array]:
    """Stretches of the start, and weights of sum 1."""
    low, high = contacts.start.span
    if high - low < _NARROW * contacts.mean_threshold:
        return np.array([contacts.start.mean()]), np.ones(1)
    nodes, shares = StartSum(contacts, Law(contacts, np.inf)).sample
    x = nodes.ravel() * law.unit
    return x, shares.ravel() * contacts.thresholds.sf(np.abs(x))


def gathered(nodes: Array, weights: Array, number: int) -> tuple[Array, Array]:
    """The Gauss rule of `number` nodes for a law given by many, by Lanczos' steps."""
    kept = weights > 0.0
    nodes, weights = nodes[kept], weights[kept] / weights[kept].sum()
    if nodes.size <= number:
        return nodes, weights
    now, before = np.sqrt(weights), np.zeros(nodes.size)
    basis: list[Array] = []
    diagonal: list[float] = []
    beside: list[float] = []
    for _ in range(number):
        basis.append(now)
        diagonal.append(float(now @ (nodes * now)))
        rest = nodes * now - diagonal[-1] * now - (beside[-1] * before if beside else 0.0)
        for old in basis:  # else round-off brings them back
            rest = rest - (old @ rest) * old
        beside.append(float(np.linalg.norm(rest)))
        before, now = now, rest / beside[-1]
    values, vectors = eigh_tridiagonal(np.array(diagonal), np.array(beside[:-1]))
    return values, vectors[0] ** 2


def prepare(contacts: Contacts) -> None:
    """Compile what the lives of these contacts need, which takes its time once."""
    thermal = contacts.thermal
    if contacts.ageing is not None:
        from master._old.threshold_cells import Cells

        cells, at = Cells(contacts, 0), np.zeros(1)
        cells.move(cells.fresh(at), at, at, 1.0)
        return
    if thermal is None or thermal.closure == "paper" or contacts.grains is not None:
        return
    if thermal.rates.vanishes_at_threshold or contacts.stiffness == "linked":
        wear, at = _ingredients(contacts, 0)[0], np.zeros(1)
        worn = wear.fresh(at)
        wear.advance(worn, at, at, at, 1.0)
        wear.left(worn, at, at)
        wear.settle(worn, at, at)
