"""The two solvers' difference over a path, in standard errors, where enough contacts have broken to tell."""

import numpy as np
import numpy.typing as npt

from toolkit.results import Result

Array = npt.NDArray[np.float64]


def deviation(result: Result) -> tuple[Array, Array]:
    """Path points (lengths) that tell, and there ensemble less master equation in standard errors; both shape (m,).

    The master equation's own error counts too. Raises ValueError for a result that lacks one of the two.
    """
    solved, eq, asked = result.master, result.eq, result.asked.eq
    if solved is None or eq is None or asked is None:
        raise ValueError("a result of both solvers is needed")
    # some 30 contacts have broken: before, standard errors mean little
    lone = np.minimum(eq.path, result.mean_threshold) / (asked.contacts * asked.replicas)
    telling = eq.force_standard_error > 5.5 * lone
    allowed = eq.force_standard_error + solved.force_error * result.mean_threshold
    return eq.path[telling], ((eq.force - solved.force) / allowed)[telling]


def worst_deviation(result: Result) -> float:
    """The largest of them in size; 0 where no point tells."""
    return float(np.abs(deviation(result)[1]).max(initial=0.0))
