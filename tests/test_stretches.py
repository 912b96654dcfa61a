"""Q(x;X) at twenty points of every kind of path: what holds, and the force, to the error claimed.

The integral of Q over x is the share that holds and that of x Q is F/(N_c <k>), both read off the solution in another
way. Integrals are halved until they no longer change, and so need not know where Q jumps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.stats
from conftest import slow

import master
import origins

WIDE, BOX = origins.gaussian(1.0, 0.2), origins.rectangular(0.5, 1.5)
START = origins.gaussian_start(0.05, 0.05)
WARM, PAPER = (origins.Thermal("soft", 0.05, 0.3, closure) for closure in ("exact", "paper"))


def contacts(law: origins.Thresholds = WIDE, start: object = None, **laws: object):
    return origins.Contacts(law, start, **laws)


@dataclass(frozen=True)
class Kind:
    """Contacts, turning points, the times of these or None, and the tolerance."""

    contacts: origins.Contacts
    turns: list[float]
    times: list[float] | None = None
    tolerance: float = 1e-7


LOOP, HELD = [0.0, 1.6, -0.7, 1.2], ([0.0, 1.3, 1.3, 0.2, 0.9], [0.0, 1.3, 9.0, 10.0, 13.0])
OLD = origins.Ageing(origins.gaussian(1.0, 0.05), 1e-3)
YOUNG = contacts(origins.gaussian(0.6, 0.08), START, ageing=OLD)
GRAINS = contacts(origins.growing_grains(1.0, 1.0, age=4.0))
KINDS = {
    "forward": Kind(contacts(), [0.0, 4.0]),
    "forward, from a width": Kind(contacts(BOX, START), [0.0, 4.0]),
    "forward, re-forming behind": Kind(contacts(reforming=-0.2), [0.0, 4.0]),
    "forward, delay": Kind(contacts(delay=origins.Delay(0.4)), [0.0, 4.0]),
    "forward, heat": Kind(contacts(start=START, thermal=WARM), [0.0, 4.0]),
    "forward, ageing": Kind(YOUNG, [0.0, 3.0], tolerance=1e-6),
    "forward, grains": Kind(GRAINS, [0.0, 3.0]),
    "turning": Kind(contacts(), LOOP),
    "turning, jumps": Kind(contacts(BOX), LOOP),
    "turning, from a width": Kind(contacts(BOX, START), LOOP),
    "turning, re-forming": Kind(contacts(reforming=0.1), LOOP),
    "turning, delay": Kind(contacts(BOX, delay=origins.Delay(0.4)), LOOP),
    "turning, heat": Kind(contacts(thermal=WARM), LOOP, tolerance=1e-5),
    "holds, delay": Kind(contacts(start=START, delay=origins.Delay(0.4)), *HELD),
    "holds, heat": Kind(contacts(start=START, thermal=WARM), *HELD, tolerance=1e-5),
    "holds, heat, paper's closure": Kind(contacts(thermal=PAPER), *HELD, tolerance=1e-5),
    "holds, re-forming, heat": Kind(contacts(thermal=WARM, reforming=0.1), *HELD, tolerance=1e-5),
}
# nodes at both ends of a panel: no jump within it stays unseen
NODES = -np.cos(np.pi * np.arange(13) / 12.0)
WEIGHTS = np.linalg.solve(np.polynomial.legendre.legvander(NODES, 12).T, 2.0 * np.eye(13)[0])


def integrals(density, low: float, high: float, leave: float) -> np.ndarray:
    """Of Q and of x Q, on panels that are halved where both halves tell more than the whole."""

    def sums(begin: np.ndarray, end: np.ndarray) -> np.ndarray:
        half = 0.5 * (end - begin)[:, None]
        x = 0.5 * (begin + end)[:, None] + half * NODES
        parts = half * WEIGHTS * density(x)
        return np.stack([parts.sum(axis=1), (parts * x).sum(axis=1)])

    edges = np.linspace(low, high, 82)
    begin, end, total = edges[:-1], edges[1:], np.zeros(2)
    whole = sums(begin, end)
    for _ in range(40):
        middle = 0.5 * (begin + end)
        # both in one call, which takes longer than its few panels where Q jumps
        halves = sums(np.append(begin, middle), np.append(middle, end))
        left, right = halves[:, : begin.size], halves[:, begin.size :]
        done = np.abs(left + right - whole).max(axis=0) < 1e-2 * leave
        total += (left + right)[:, done].sum(axis=1)
        begin, end = np.append(begin[~done], middle[~done]), np.append(middle[~done], end[~done])
        whole = np.concatenate([left[:, ~done], right[:, ~done]], axis=1)
        if not begin.size:
            break
    return total + whole.sum(axis=1)


POINTS = 12
QUADRATURE = 2e-9  # what the halved integrals may leave, or a thirtieth of the error claimed
SLOW = {
    "holds, delay",
    "turning, re-forming",
    "turning, delay",
    "forward, heat",
    "forward, ageing",
    "turning, from a width",
    "turning, heat",
}
SLOW |= {
    "turning, jumps",
    "holds, heat",
    "holds, heat, paper's closure",
    "holds, re-forming, heat",
}


@pytest.mark.parametrize("name", [slow(name, when=name in SLOW) for name in KINDS])
def test_stretches_add_up_to_what_holds_and_to_the_force(name: str) -> None:
    kind = KINDS[name]
    forward = min(np.diff(kind.turns)) > 0.0
    corners = np.arange(len(kind.turns))
    points = np.unique(np.append(np.linspace(0.03, corners[-1] - 0.03, POINTS), corners))
    path = np.interp(points, corners, kind.turns)
    time = None if kind.times is None else np.interp(points, corners, kind.times)
    solution = master.solve(kind.contacts, path, kind.tolerance, time=time)
    assert solution.success
    by_index = time is not None or (not forward and bool(kind.contacts.laws))
    low, high = min(kind.turns) - max(kind.turns) - 0.5, max(kind.turns) - min(kind.turns) + 0.5
    leave = max(QUADRATURE, 0.03 * solution.force_error)
    for index in range(points.size):
        if points[index] in corners:
            continue
        leg = int(points[index])
        place = [index] if by_index else [float(path[index])]
        found = solution.distribution(*place, **({} if by_index or forward else {"leg": leg}))
        share, force = integrals(found.density, low, high, leave)
        share += found.delta_weights.sum()
        force += found.delta_weights @ found.delta_positions
        allowed = solution.force_error + leave
        assert abs(share - solution.holding[index]) <= allowed
        assert abs(force - solution.force[index]) <= allowed * kind.contacts.mean_threshold


PATH = np.linspace(0.0, 3.0, 31)


def test_contacts_from_one_stretch_stay_one_until_they_break():
    solution = master.solve(origins.Contacts(origins.gaussian(1.0, 0.1), 0.2), PATH, 1e-8)
    q = solution.distribution(0.75)
    assert q.delta_positions == pytest.approx([0.95], rel=1e-14)
    assert q.delta_weights == pytest.approx([scipy.stats.norm(1.0, 0.1).sf(0.95)], rel=1e-11)
    q = solution.distribution(0.0)
    assert q.delta_positions == pytest.approx([0.2])
    assert q.delta_weights == pytest.approx([1.0])
    assert (q.density(np.linspace(-1.0, 2.0, 32)) == 0.0).all()


def test_exact_values_are_told_apart():
    # all break at X = 1, form again in the hold at 1.2, and are pulled back
    waiting = origins.Contacts(origins.identical(1.0), delay=origins.Delay(0.3))
    path, time = [0.5, 1.2, 1.2, 0.9], [0.5, 1.2, 2.0, 2.3]
    solution = master.solve(waiting, path, 1e-8, time=time)
    for point, stretches in enumerate([[0.5], [], [0.0], [-0.3]]):
        found = solution.distribution(point)
        assert found.delta_positions == pytest.approx(stretches, abs=1e-9)
        assert found.delta_weights == pytest.approx(np.ones(len(stretches)), abs=1e-8)
        assert (found.density([-0.3, 0.0, 0.4]) < 1e-12).all()


PEAK = origins.mixture([origins.identical(0.8), WIDE], [0.4, 0.6])
STEADY = {
    "value and peak": contacts(PEAK, delay=origins.Delay(0.2)),
    "onset": contacts(origins.gw_elastic(1.588)),
    "heat": contacts(thermal=origins.Thermal("stiff", 0.05), delay=origins.Delay(0.2)),
    "many births": contacts(BOX, reforming=origins.gaussian_start(0.05, 0.1)),
}


@pytest.mark.parametrize("name", STEADY)
def test_steady_stretches_add_up_to_what_holds_and_to_the_force(name: str) -> None:
    state = master.steady_state(STEADY[name])
    share, force = integrals(state.distribution, -0.8, 8.0, 1e-10)
    assert share == pytest.approx(state.holding, abs=1e-8)
    assert force == pytest.approx(state.force, abs=1e-8)
