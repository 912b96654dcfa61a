"""An ensemble under way: after each finished block progress is shown, a checkpoint kept, and a signal heeded."""

import signal
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from toolkit.running.checkpoint import Checkpoint, say
from toolkit.running.deferred import Deferred

if TYPE_CHECKING:
    from eq_model import CoupledEnsemble, CoupledResult, Ensemble, EnsembleResult

    AnyResult = EnsembleResult | CoupledResult


def follow(
    ensemble: "Ensemble | CoupledEnsemble",
    progress: Callable[[int, int], None] | None = None,
    checkpoint: Checkpoint | None = None,
    done_before: int = 0,
) -> "AnyResult":
    """Work through the ensemble to its result.

    SIGINT and SIGTERM wait until the block is finished and its checkpoint written, and then do what they did before:
    end the program as a rule. In an interactive session SIGINT ends this rank's share of the ensemble alone: the result
    is that of the finished blocks, with success = False, once the other ranks have come to their end; a second SIGINT
    does what it did before.

    Parameters
    ----------
    ensemble : not yet begun; all ranks of its communicator must call.
    progress : called as progress(done, expected), contacts of the whole run; other ranks count as far as this one is.
    checkpoint : where to keep what is done, None for nowhere.
    done_before : contacts that the ensemble was given as done.
    """
    ranks = 1 if ensemble.comm is None else ensemble.comm.Get_size()
    shown, interrupted = (-1, -1), False
    with Deferred() as asked:
        blocks = iter(ensemble)
        while True:
            try:
                done = next(blocks, None)
                if done is None:
                    break
                now = min(done_before + done[0] * ranks, ensemble.expected), ensemble.expected
                if progress is not None and now != shown:
                    progress(*now)
                    shown = now
            except KeyboardInterrupt:
                # raised in the middle, as some kernels do it: what is finished is whole
                if ranks > 1 or not _interactive() or not ensemble.state.done:
                    raise
                interrupted = True
                break
            if asked.signal is not None:
                if checkpoint is not None:
                    checkpoint.write(ensemble.state)
                if asked.signal == signal.SIGINT and not interrupted and _interactive():
                    asked.signal, interrupted = None, True
                    ensemble.stop()
                    continue
                asked.pass_on("nothing was written" if checkpoint is None else checkpoint.note)
            elif checkpoint is not None:
                checkpoint.keep(ensemble.state)
    result: AnyResult = ensemble.result()
    if checkpoint is not None and unfinished(ensemble, result):
        checkpoint.write(ensemble.state)
        if checkpoint.is_first and not interrupted:
            say(f"stopped by the wall time; run it again with --out {checkpoint.folder} to go on")
    if interrupted and unfinished(ensemble, result):
        result = replace(result, success=False, message=f"interrupted: {result.message}")
    return result


def unfinished(ensemble: "Ensemble | CoupledEnsemble", result: "AnyResult") -> bool:
    """Whether there is something to go on with."""
    return not result.success and result.contacts < ensemble.total


def _interactive() -> bool:
    return hasattr(sys, "ps1")
