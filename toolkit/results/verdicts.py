"""The verdict of a run on a soft slider: that of infinitely many contacts beside that of as many as the run follows."""

import numpy as np

from toolkit.results.kinds import is_coupled
from toolkit.results.records import Result


def contradiction(result: Result) -> str:
    """How the ensemble contradicts the master equation's verdict, in words that begin with "disagree"; "" where it does
    not, or where one of them is missing.

    Smooth sliding is contradicted by any slip of the ensemble. Stick-slip is where no slider slips on a path on which
    the master equation has two slips or more: a single one may come later than the path's end, as N contacts slip late.
    """
    solved, eq = result.master, result.eq
    if solved is None or solved.regime is None or eq is None or not is_coupled(eq):
        return ""
    number, slipped = len(eq.forces), np.unique(eq.slips.replica).size
    each = f"{eq.contacts // number:,} contacts"
    said = (
        f'disagree: infinitely many contacts are "{solved.regime.verdict}" (master equation), but'
    )
    if solved.regime.verdict == "smooth" and slipped:
        return (
            f"{said} {slipped} of {number} sliders of {each} slip: for so many contacts believe these; "
            "smooth sliding needs a stiffer spring, or more contacts"
        )
    if solved.regime.verdict == "stick-slip" and solved.slips.drive.size > 1 and not slipped:
        return (
            f"{said} none of {number} sliders of {each} slips: no avalanche breaks {eq.slip_fraction:.0%} of "
            "them, so that nothing is reset; these events are no stick-slip"
        )
    return ""
