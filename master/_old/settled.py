"""Far paths: what is left of them once contacts have forgotten that they started together.

Breaks at X are averages of what broke before, b(X) = integral of p(s) b(X - s): where b has come within d of its steady
value over the longest life, it never leaves that again, and F stays within d times the integral of the force that one
birth brings. From there on F is the kinetic force.
"""

import numpy as np
import numpy.typing as npt

from master._old.cycle import Cycle
from master._old.decoherence import decoherence_length
from master._old.forward import BROAD
from master._old.problem import Problem
from master._old.renewal import LaterReleased
from master._old.steady import SteadyState
from origins import Contacts

Array = npt.NDArray[np.float64]

_SHARE = 1e-3  # of the tolerance: what lives longer than the longest life, or breaks first after that long
_PER_WIDTH = 8.0
_MOST = 20_000
_LIVES = 3.0


def longest_life(cycle: Cycle, tolerance: float) -> float:
    """Travel from one break to the next (in the cycle's units) that few enough contacts exceed, and its square times
    them."""
    life = 1.0
    for _ in range(4):
        life = float(cycle.law.isf(_SHARE * min(tolerance, 0.1) / max(life, 1.0) ** 2)) / cycle.unit
    return life


def forgotten(contacts: Contacts, cycle: Cycle, tolerance: float) -> float:
    """Where (in the cycle's units) contacts should have forgotten their start; inf where they never do."""
    life = longest_life(cycle, tolerance)
    if life > BROAD:
        # lives of all lengths: the longest tell, and no wave has to be looked for among the shortest
        return _LIVES * life
    length = decoherence_length(contacts, cycle)[0] / cycle.unit
    if not np.isfinite(length):
        return np.inf
    return 2.0 * life + 1.1 * length * np.log(10.0 / min(tolerance, 0.1))


def left_to_settle(
    problem: Problem, later: LaterReleased | None, steady: SteadyState, at: float, tolerance: float
) -> float:
    """Bound on |F - F_k| at all X >= `at` and on the fraction that holds, in the cycle's units."""
    unit, life = problem.unit, longest_life(problem.cycle, tolerance)
    begin = at - life
    if begin <= 0.0 or later is None:
        return np.inf
    rest = 1.0 - float(problem.first.count.once(np.array([begin]))[0])
    rest += float(problem.chain.weights[problem.chain.births > begin].sum())
    count = int(min(max(_PER_WIDTH * life / problem.law.narrowest, 200.0), _MOST))
    births = later.births(np.linspace(begin, at, count))
    steadily = steady.holding * unit / steady.cycle_length
    off = float(np.abs(births - steadily).max()) + abs(rest)
    each = (abs(steady.force) / unit + 2.0 * problem.release.widest + 1.0) / steadily
    return off * each + 2.0 * _SHARE * tolerance
