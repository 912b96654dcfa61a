"""An ensemble under way: after each finished block progress is shown, a checkpoint kept, and a signal heeded."""

import signal
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from toolkit.running.checkpoint import Checkpoint, say
from toolkit.running.signals import Deferred

if TYPE_CHECKING:
    from eq_model import CoupledResult, Ensemble, EnsembleResult

    AnyResult = EnsembleResult | CoupledResult

_STOP = 7117  # tag of the message by which a rank passes a signal on to the others
_WORTH_KEEPING = 1.0  # seconds of work: a shorter ensemble is followed again as fast as it is read


def follow(
    ensemble: "Ensemble",
    progress: Callable[[int, int], None] | None = None,
    checkpoint: Checkpoint | None = None,
    done_before: int = 0,
    deadline: float | None = None,
) -> "AnyResult":
    """Work through the ensemble to its result.

    SIGINT, SIGTERM and SIGHUP wait until the block is finished and its checkpoint written, and then do what they did
    before: end the program as a rule. A rank that gets one tells the other ranks, which end likewise. In an interactive
    session SIGINT ends this rank's share of the ensemble alone: the result is that of the finished blocks, with
    success = False, once the other ranks have come to their end; a second SIGINT does what it did before.

    Parameters
    ----------
    ensemble : not yet begun; all ranks of its communicator must call.
    progress : called as progress(done, expected), contacts of the whole run; other ranks count as far as this one is.
    checkpoint : where to keep what is done, None for nowhere.
    done_before : contacts that the ensemble was given as done.
    deadline : s of the monotonic clock after which no block begins; None for none.
    """
    comm = ensemble.comm
    ranks, rank = (1, 0) if comm is None else (comm.Get_size(), comm.Get_rank())
    shown, interrupted, begun = (-1, -1), False, time.monotonic()
    with Deferred() as asked:
        for done, _ in ensemble:
            now = min(done_before + done * ranks, ensemble.expected), ensemble.expected
            if progress is not None and now != shown:
                progress(*now)
                shown = now
            if deadline is not None and time.monotonic() > deadline:
                ensemble.stop()
            if ranks > 1:
                _tell_or_hear(comm, asked)
            if asked.signal is None:
                if checkpoint is not None:
                    checkpoint.keep(ensemble.state)
                continue
            if checkpoint is not None:
                checkpoint.write(ensemble.state)
            if asked.signal == signal.SIGINT and not interrupted and _interactive():
                asked.signal, interrupted = None, True
                ensemble.stop()
                continue
            asked.pass_on("nothing was written" if checkpoint is None else checkpoint.note)
    result: AnyResult = ensemble.result()
    left = unfinished(ensemble, result)
    # a finished one too: the disk may refuse the result
    if checkpoint is not None and (left or time.monotonic() - begun > _WORTH_KEEPING):
        checkpoint.write(ensemble.state)
        if left and rank == 0 and not interrupted:
            say(f"stopped by the wall time; run it again with --out {checkpoint.folder} to go on")
    if interrupted and left:
        result = replace(result, success=False, message=f"interrupted: {result.message}")
    return result


def _tell_or_hear(comm: Any, asked: Deferred) -> None:
    """Tell the other ranks of a signal that this one has got, or hear of theirs."""
    if asked.signal is None:
        if comm.Iprobe(tag=_STOP):
            asked.signal = comm.recv(tag=_STOP)
    elif not _interactive():
        for rank in set(range(comm.Get_size())) - {comm.Get_rank()}:
            comm.isend(asked.signal, dest=rank, tag=_STOP)


def unfinished(ensemble: "Ensemble", result: "AnyResult") -> bool:
    """Whether there is something to go on with."""
    return not result.success and result.contacts < ensemble.total


def _interactive() -> bool:
    return hasattr(sys, "ps1")
