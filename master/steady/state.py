"""What is known of steady sliding at one speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from origins import Thresholds

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class SteadyState:
    """Steady sliding, whatever the start.

    Attributes
    ----------
    force : float
        F_k/(N_c <k>), a length. Where contacts form again at once and relaxed, and all are equally
        stiff, it is <x_b^2>/(2 <x_b>); x_b is the stretch at which a contact breaks, x_s at T = 0.
    force_error : float
        Its error in units of the mean threshold.
    holding : float
        Fraction of the contacts that hold, C/(C + v tau).
    thresholds : Thresholds
        P_c: of new contacts, or with the paper's closure of ageing of all, from a table of weights.
    mean_threshold : float
        Its mean <x_s>, a length.
    cycle_length : float
        C, the mean travel of the slider between a contact's birth and its break.
    cycle_length_error : float
        Its error in units of the mean threshold.
    success : bool
        Whether the relative error of the force is at most 1e-3.
    message : str
        The accuracy reached.
    positivity_defect : float
        With the paper's closure of ageing the sum of the negative weights of the table of P_c,
        without the sign, which the density leaves out.
    """

    force: float
    force_error: float
    holding: float
    thresholds: Thresholds = field(repr=False)
    mean_threshold: float
    cycle_length: float
    cycle_length_error: float
    success: bool
    message: str
    _held: Callable[[Array], Array] = field(repr=False)
    positivity_defect: float = 0.0

    def distribution(self, x: npt.ArrayLike) -> Array:
        """Q_s(x) per length at stretches x (paper, Eq. Q11a), of all contacts; same shape as x."""
        x = np.asarray(x, dtype=float)
        held = self._held(x.ravel()) * self.holding / self.cycle_length
        return held.reshape(x.shape)[()]
