"""What heat does to a slider on a spring: breaks are proposed on its way, and one that pushes it takes it back."""

import numpy as np

from eq_model.compiling import bare, entry, inlined
from eq_model.coupled.ages import threshold_of
from eq_model.coupled.forming import break_numbered
from eq_model.coupled.heat import NOWHERE, by_heat, draw_budget, lower, proposed, queue_position
from eq_model.coupled.moves import balance, move, rebase
from eq_model.coupled.queue_kernel import (
    BEYOND,
    BUCKET,
    END,
    NEXT,
    NOTHING,
    WAITING,
    add_break,
    clear,
    go_back_to,
    settle,
)
from eq_model.coupled.slider import F_BEFORE, X_BEFORE


@bare
def new_windows(s, queue, ages):  # type: ignore[no-untyped-def]
    """Give all contacts that hold new windows, with heat."""
    clear(queue, s.at)
    s.back = NOWHERE
    for contact in range(ages.fresh.size):
        if ages.heat.level[contact] > 0:
            add_break(queue, queue_position(ages.heat, ages, contact, s), contact)


@entry
def begin_with_heat(slider, queue, ages):  # type: ignore[no-untyped-def]
    """Give all contacts windows at the slider's X, which is not where they formed, and draw the first proposal."""
    draw_budget(ages.heat, slider[0])
    new_windows(slider[0], queue, ages)


@inlined
def _propose(s, queue, supply, ages, pull, ahead):  # type: ignore[no-untyped-def]
    """Move the slider to where the drive has it now, and break the contact that heat proposes, or not; the first one
    begins an avalanche."""
    at = balance(s, pull, ahead, s.drive)
    x = max(s.base + np.int64(np.rint(at)), s.at)
    move(s, x if ahead.event == NOTHING else min(x, ahead.x))
    settle(queue, s.at)
    pull.avalanche[X_BEFORE] = np.float64(s.base) + at
    pull.avalanche[F_BEFORE] = s.drive - pull.spring * at
    rebase(s, pull)
    contact, accepted, rare = proposed(ages.heat, ages, s)
    if accepted:
        break_numbered(s, queue, supply, ages, pull, contact)
    elif rare:
        add_break(queue, lower(ages.heat, ages, contact, s), contact)
    # keys of contacts that have gone take room, too
    if queue.at[WAITING] + queue.at[BEYOND] + queue.at[END] - queue.at[NEXT] > 3 * pull.n:
        new_windows(s, queue, ages)


@bare
def _go_back(s, queue, supply, ages, pull, ahead):  # type: ignore[no-untyped-def]
    """Whether a slider that goes back to its balance meets the end of a window. There contacts whose thresholds are
    reached break, and all others have new windows."""
    x = s.base + np.int64(np.rint(balance(s, pull, ahead, s.drive)))
    if x >= max(s.back, queue.at[BUCKET] << queue.shift):
        return False
    if x >= s.back and go_back_to(queue, x):
        return False
    move(s, min(max(x, s.back), s.at))
    for contact in range(ages.fresh.size):
        break_stretch = -np.int64(np.rint(threshold_of(ages, contact, s.now)))
        if ages.heat.level[contact] > 0 and s.at - ages.zero[contact] <= break_stretch:
            break_numbered(s, queue, supply, ages, pull, contact)
    new_windows(s, queue, ages)
    return True


propose = by_heat(
    lambda heat, *rest: _propose(*rest),
    lambda heat, *rest: None,
)
go_back = by_heat(lambda heat, *rest: _go_back(*rest), lambda heat, *rest: False)
# without heat the slider goes forward alone, but for rounding
furthest_back = by_heat(lambda heat, s: NOWHERE, lambda heat, s: s.at)
