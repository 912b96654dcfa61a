"""What an ensemble measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from eq_model.histogram import Histogram
from origins.brief import brief

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class EnsembleResult:
    """What the ensemble measured.

    path : the path asked for, shape (n,), lengths.
    force : mean force over all contacts and replicas at each X, shape (n,), a length (force per N_c <k>).
    force_standard_error : of that mean, from the variance between contacts, shape (n,), a length; inf for
        one contact. Of large ensembles it is that of the first 4 blocks of contacts, and of every eighth of
        the others. Where breaks are too rare to be seen, before the first ones and where many come to an end
        or begin together, it is at least what one break more or less would make. What happens to less than
        one contact in all of them later on is in no ensemble and not in its error: one contact's stretch
        divided by their number.
    step_error : what the inner steps of ageing may add to the force, shape (n,), a length; 0 without ageing, whose
        contacts need none. An eighth of the contacts is followed in 8 times longer steps besides to tell.
    holding : fraction of contacts that hold, shape (n,).
    holding_standard_error : of that, shape (n,); where contacts may wait, at least that of one contact.
    histograms : of stretches and thresholds, at the points asked for, each read when it is asked for.
    contacts : followed in all; breaks : breaks in all; breaks_per_rank : of each rank.
    success, message : whether the tolerance is reached, or all contacts followed, and in words.
    run_time : s, of the slowest rank, tables included, compilation not; compile_time : s, imports included.
    """

    path: Array
    force: Array
    force_standard_error: Array
    step_error: Array
    holding: Array
    holding_standard_error: Array
    histograms: Sequence[Histogram] = ()
    contacts: int
    breaks: int
    breaks_per_rank: list[int]
    run_time: float
    compile_time: float
    success: bool
    message: str

    __repr__ = brief
