"""Ranks that work together: their communicator, work that one does for all, and a common end."""

import math
import os
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable
from typing import Any, NoReturn, TypeVar

from origins.errors import InputError
from toolkit.processes.signals import Deferred, Launch, Terminated, terminable

T = TypeVar("T")

_STOP = 7117  # tag of the message by which a rank passes a signal on to the others

_PATIENCE = 5.0  # seconds to wait for the other ranks to fail in the same way
_GRACE = 10.0  # and to finish their blocks and write their checkpoints; schedulers kill some 30 s after their SIGTERM
_NOTHING_TO_KEEP = 1.0  # and where a rank is stopped outside of the ensemble


def communicator(launch: Launch) -> Any:
    """mpi4py's COMM_WORLD, or None for a lone process, which never imports mpi4py. Raises InputError where the ranks
    could not work together: N lone runs of one scene are never wanted."""
    if launch.size == 1:
        return None
    started = f"mpirun or srun: started {launch.size} ranks, but mpi4py"
    try:
        with warnings.catch_warnings():
            # that a launcher of another MPI was used is said below, in one line
            warnings.simplefilter("ignore", RuntimeWarning)
            from mpi4py import MPI
    except (ImportError, RuntimeError, OSError) as error:
        hint = "install it against the MPI that is there (docs/clusters.md), or the extra [mpi], or run one process"
        raise InputError(f"{started} cannot be imported ({error}); {hint}") from error
    if (there := MPI.COMM_WORLD.Get_size()) < launch.size:
        hint = "use the mpirun of mpi4py's MPI, srun --mpi=pmix or --mpi=pmi2, or build mpi4py against this one"
        raise InputError(f"{started}'s MPI connects {there}; {hint} (docs/clusters.md)")
    return MPI.COMM_WORLD


def on_root(comm: Any, work: Callable[[], T]) -> T:
    """What `work` returns on rank 0, on every rank; its InputError is raised on every rank too."""
    if comm is None or comm.Get_size() == 1:
        return work()
    outcome: tuple[T | None, str | None] = (None, None)
    if comm.Get_rank() == 0:
        try:
            outcome = (work(), None)
        except InputError as error:
            outcome = (None, str(error))
    _arrived(comm)
    value, refused = comm.bcast(outcome, root=0)
    if refused is not None:
        raise InputError(refused)
    return value


def cores_of(comm: Any) -> int:
    """How many of the cores of this node are this rank's share, at least 1: those on which the launcher, or `taskset`,
    lets it run, each divided among the ranks of `comm` on the node that may run there too. All ranks must call."""
    if hasattr(os, "sched_getaffinity"):
        mine = os.sched_getaffinity(0)
    else:  # not on macOS
        mine = set(range(os.cpu_count() or 1))
    if comm is None or comm.Get_size() == 1:
        return len(mine)
    from mpi4py import MPI

    node = comm.Split_type(MPI.COMM_TYPE_SHARED)
    cores_of_ranks = node.allgather(mine)
    node.Free()
    own_cores = sum(1.0 / sum(core in other for other in cores_of_ranks) for core in mine)
    return max(int(own_cores + 1e-9), 1)


class Relay:
    """A signal that one rank gets, and notes in `asked`, reaches the others: they note it too."""

    def __init__(self, comm: Any, asked: Deferred) -> None:
        self._comm, self._asked, self._agreed = comm, asked, comm is None or comm.Get_size() == 1
        self._one_at_a_time = threading.Lock()

    def listen(self) -> None:
        """Note the signal of another rank, if one came: takes 0.3 µs, from whatever thread."""
        if self._agreed or not (_in_main_thread() or _mpi_takes_threads()):
            return
        with self._one_at_a_time:
            if self._asked.signal is None and self._comm.Iprobe(tag=_STOP):
                self._asked.signal, self._agreed = self._comm.recv(tag=_STOP), True

    def pass_on(self) -> None:
        """Tell the others of the signal that this rank got, once; not of one that another has told."""
        with self._one_at_a_time:
            if self._agreed or self._asked.signal is None:
                return
            self._agreed = True
            for rank in set(range(self._comm.Get_size())) - {self._comm.Get_rank()}:
                self._comm.isend(self._asked.signal, dest=rank, tag=_STOP)


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _mpi_takes_threads() -> bool:
    """Whether MPI may be called from any thread, one at a time; where it may not, those of a rank hear nothing."""
    from mpi4py import MPI

    return bool(MPI.Query_thread() >= MPI.THREAD_SERIALIZED)


def end_together(work: Callable[[Any], int], launched: Launch) -> int:
    """Exit status of `work`, called with the communicator of all ranks launched (None: this process alone).

    Bad input is one line and status 2, SIGINT one and 130, SIGTERM and SIGHUP one and 143, each printed once. Any other
    exception of one rank ends all ranks.
    """
    ending = None
    try:
        with terminable():
            comm = communicator(launched)
            # a separate communicator, so that messages at the end are not mixed with those of the work
            ending = None if comm is None else comm.Dup()
            return work(comm)
    except InputError as error:
        return _end(ending, launched, 2, str(error), _PATIENCE)
    except (KeyboardInterrupt, Terminated) as stop:
        status, word = (143, "terminated") if isinstance(stop, Terminated) else (130, "interrupted")
        notes = getattr(stop, "__notes__", None)
        said = f"{word}; {(notes or ['nothing was written'])[0]}"
        _end(ending, launched, status, said, _GRACE if notes else _NOTHING_TO_KEEP)
        if ending is not None:
            # the launcher ends all ranks as soon as one has ended: all wait until rank 0 has printed
            _arrived(ending, _GRACE)
            sys.stdout.flush()
            os._exit(status)  # pending messages do not matter any more
        return status
    except BaseException:
        if ending is None:
            raise
        # an exception that leaves one rank only would leave the others waiting for ever
        traceback.print_exc()
        _abort(ending, 1)


def _end(comm: Any, launched: Launch, status: int, line: str, patience: float) -> int:
    """Print the reason, once if all ranks end in the same way; after `patience` seconds the others are aborted."""
    alike = comm is None or _arrived(comm, patience)
    if launched.rank == 0 or not alike:
        print(f"mesofriction: {line}", file=sys.stderr, flush=True)
    if not alike:
        _abort(comm, status)
    return status


def _abort(comm: Any, status: int) -> NoReturn:
    sys.stderr.flush()
    time.sleep(0.2)  # s, for the launcher to pass on output before it ends all ranks
    comm.Abort(status)
    os._exit(status)  # some launchers are slow


def _arrived(comm: Any, patience: float = math.inf) -> bool:
    """Whether every rank calls this within so many seconds. MPI's own waits keep a core busy, which another needs."""
    request = comm.Ibarrier()
    deadline = time.monotonic() + patience
    while not request.Test():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.001)  # s
    return True
