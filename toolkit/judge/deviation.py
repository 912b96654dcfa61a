"""The two solvers' difference over a path, in standard errors, where enough contacts have broken to tell."""

import numpy as np
import numpy.typing as npt

from toolkit.results.records import Result, is_coupled

Array = npt.NDArray[np.float64]

_FEWEST = 30  # broken contacts: before, standard errors mean little


def deviation(result: Result) -> tuple[Array, Array]:
    """Path points (lengths) that tell, and there ensemble less master equation in standard errors; both shape (m,).

    The master equation's own error and that of the ensemble's steps count too.

    Raises ValueError for a result that lacks one of the two.
    """
    solved, eq = result.master, result.eq
    if solved is None or eq is None:
        raise ValueError("a result of both solvers is needed")
    tell = np.flatnonzero(telling(result))
    own = solved.force_error * result.mean_threshold
    allowed = eq.force_standard_error[tell] + eq.step_error[tell] + own
    return eq.path[tell], (eq.force[tell] - solved.force[tell]) / allowed


def telling(result: Result) -> npt.NDArray[np.bool_]:
    """Which points of the path tell; none without an ensemble."""
    eq = result.eq
    if eq is None or is_coupled(eq):
        # a slip comes at another X_T in each replica: in between their mean force is that of none of them
        return np.zeros(0 if eq is None else eq.path.size, dtype=bool)
    of_one_contact = np.minimum(np.abs(eq.path), result.mean_threshold) / eq.contacts
    enough = eq.force_standard_error > np.sqrt(_FEWEST) * of_one_contact
    if result.master is not None:
        # the paper's closure of ageing may end before the path does
        enough[result.master.path.size :] = False
    return np.isfinite(eq.force_standard_error) & enough


def worst_deviation(result: Result) -> float | None:
    """The largest of them in size; None where no point tells."""
    off = np.abs(deviation(result)[1])
    return float(off.max()) if off.size else None


def why_not_compared(result: Result) -> str | None:
    """Why no point of the path tells, in words; None where one does."""
    if result.eq is None or telling(result).any():
        return None
    if result.eq.breaks == 0:
        return "no contact breaks on this path"
    if is_coupled(result.eq):
        return "slips are compared one by one, not the force between them"
    return f"too few contacts or breaks, or all break at once: below some {_FEWEST} standard errors mean little"
