"""Life: what the master equation uses of the laws of contacts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.motion.motion import History
from origins.start import Start

Array = npt.NDArray[np.float64]


class Life:
    """Survival and force, after any motion of the slider, of contacts that were born together.

    The method `left` gives the survival E(t, s) and the force kernel K(t, s) of number conservation for
    contacts born at the stretches at which broken contacts re-form, and G_0(t) and M_0(t) for contacts
    born at t = 0 at the stretches of the start. Each law of contacts is a subclass; the attributes are
    those of contacts that depend on time and whose survival has no bends.

    Attributes
    ----------
    reach : float
        Length: a contact whose |x| has been beyond it no longer holds (its survival is below 1e-17).
    quiet : float
        Length: a contact whose |x| has never been beyond it still holds (its survival is 1 to rounding);
        0 where there is no such length.
    atoms : array of shape (n,)
        Exact thresholds (lengths), at which finite shares of contacts break together.
    bends : array of shape (n,)
        Lengths, sorted: the largest |x| at which the survival of a contact is not smooth, such as
        jumps of P_c and exact thresholds.
    marks : array of shape (n,)
        Where `quick`: |x| between which the survival is nearly a polynomial.
    grain : float
        Length over which the survival has to be resolved.
    quick : bool
        Whether `left`, for births at one stretch, takes no longer than a look-up in a table.
    pair_work : int
        Work of `left` for one birth at one moment, in look-ups in a table.
    timeless : bool
        Whether the survival depends only on the way, and not on the time that it took.
    error : float
        Bound on the error of the share that `left` returns, which finer panels do not reduce.
    has_strands : bool
        Whether births of earlier legs have to be followed, since `left` does not know them.
    """

    reach: float
    grain: float
    quiet, quick, timeless, has_strands = 0.0, False, False, False
    pair_work, error = 1, 0.0
    atoms: Array = np.empty(0)
    bends: Array = np.empty(0)
    marks: Array = np.empty(0)

    def atom_share(self, atom: float, stretch: float) -> float:
        """Upper bound of the share of contacts born at a stretch that have the exact threshold `atom`."""
        return 0.0

    def left(self, born: Start | Array, history: History) -> Array:
        """Share of contacts that still hold, and their mean force per contact born.

        born : the law of the stretches at birth, or an array of single stretches that broadcasts
            with the history; thresholds follow P_c conditional on x_s > |stretch|
        history : of shape (rows, columns); each row lies within one smooth piece, and its middle
            column decides on which side of an exact threshold it is

        Returns an array of shape (2, rows, columns): the share, between 0 and 1, and the force in
        units of <k>, a length.
        """
        raise NotImplementedError
