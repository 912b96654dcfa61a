"""Start and end of a process: the launcher's environment, and signals, raised as exceptions or deferred."""

import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from types import FrameType
from typing import Any, NamedTuple, NoReturn

# modules that compile kernels: none of their frames is left while a kernel runs
_COMPILERS = ("numba.core.", "llvmlite.")
_REPEATED_AFTER = 0.05  # s after which a signal comes again whose exception was lost
_ENDING = (signal.SIGTERM, signal.SIGHUP)
# (number of ranks, own rank) as each launcher's processes see them. SLURM_NTASKS is not among them: a batch script
# sees it too, alone. PMI: mpich, Intel MPI, srun --mpi=pmi2; MV2: mvapich; the step's variables: any srun.
_VARIABLES = (
    ("PMI_SIZE", "PMI_RANK"),
    ("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"),
    ("MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"),
    ("SLURM_STEP_NUM_TASKS", "SLURM_PROCID"),
)


class Launch(NamedTuple):
    """Number of ranks and own rank by the launcher's environment."""

    size: int = 1
    rank: int = 0


def read_environment(environment: Mapping[str, str] = os.environ) -> Launch:
    """The largest launch named; inner launchers inherit the variables of outer ones."""
    found = Launch()
    for size, rank in _VARIABLES:
        numbers = [environment.get(size, ""), environment.get(rank, "")]
        if all(map(str.isdecimal, numbers)) and int(numbers[0]) > found.size:
            found = Launch(int(numbers[0]), int(numbers[1]))
    return found


class Terminated(BaseException):
    """SIGTERM or SIGHUP: a scheduler ends the job, or the terminal is gone."""


class TimeIsUp(BaseException):
    """The time given to `no_longer_than` is over."""

    timer, number = signal.ITIMER_REAL, signal.SIGALRM


class TooMuchWork(TimeIsUp):
    """The CPU time given to `no_longer_than` is over."""

    timer, number = signal.ITIMER_PROF, signal.SIGPROF


@contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM and SIGHUP raise Terminated, in the main thread, which alone receives signals.

    A signal that is ignored, as SIGHUP under nohup, stays ignored.
    """
    said = []

    def terminate(number: int, frame: Any) -> NoReturn:
        said.append(number)
        raise Terminated

    with _handled(terminate, *_ENDING), _insisting(said):
        try:
            yield
        except Exception as error:
            if said:  # a compiled module that is being imported raises its own exception instead
                raise Terminated from error
            raise


@contextmanager
def _insisting(said: list[int]) -> Iterator[None]:
    """A signal whose exception is lost comes again, the last of those `said`, or SIGINT.

    An exception that a handler raises while compiled code calls back into Python, as LLVM does when numba compiles, or
    within a destructor, cannot propagate: Python reports it as unraisable, and the program would go on as if nothing
    had come.
    """
    before = sys.unraisablehook

    def repeat(lost: Any) -> None:
        if not issubclass(lost.exc_type, KeyboardInterrupt | Terminated | TimeIsUp):
            return before(lost)
        number = said[-1] if said and issubclass(lost.exc_type, Terminated) else signal.SIGINT
        if issubclass(lost.exc_type, TimeIsUp):
            number = lost.exc_type.number
        # from another thread and a moment later, when the callback has returned
        main = threading.main_thread().ident or 0
        timer = threading.Timer(_REPEATED_AFTER, signal.pthread_kill, [main, number])
        timer.daemon = True
        timer.start()

    sys.unraisablehook = repeat
    try:
        yield
    finally:
        sys.unraisablehook = before


@contextmanager
def no_longer_than(
    seconds: float | None,
    over: type[TimeIsUp] = TimeIsUp,
    remaining_time: Callable[[], float] | None = None,
) -> Iterator[None]:
    """Raise `over` within once so many seconds are over, of TooMuchWork CPU time, which does not hang on what else the
    machine does; in the main thread only, None for no limit. `remaining_time`, if given, says then how
    many more there are. A limit within which this one is set holds again afterwards.

    A module that is being imported is imported first, as one that is half there is broken for good, as numba is; and a
    kernel that is being compiled is compiled first: LLVM drops what is raised in its callbacks, and the half-made
    kernel ends in a RuntimeError.
    """
    begun = _half_done_in(sys._getframe())

    def ring(number: int, frame: Any) -> None:
        if _half_done_in(frame) > begun:
            signal.setitimer(over.timer, _REPEATED_AFTER)
            return
        if remaining_time is None or (more := remaining_time()) <= 0.0:
            raise over
        signal.setitimer(over.timer, max(more, 0.1))

    clock = time.monotonic if over.timer == signal.ITIMER_REAL else time.process_time
    began, outer = clock(), 0.0
    try:
        with _handled(ring, *([] if seconds is None else [over.number])) as before:
            try:
                if before:
                    outer = signal.getitimer(over.timer)[0]
                    most = min(seconds or 0.0, outer or math.inf)
                    signal.setitimer(over.timer, max(most, 1e-6))
                yield
            finally:
                if before:
                    signal.setitimer(over.timer, 0.0)
    finally:
        if outer:
            # not at once, where who set this limit may still catch what is raised
            signal.setitimer(over.timer, max(outer - (clock() - began), _REPEATED_AFTER))


def _half_done_in(frame: FrameType | None) -> int:
    """How many frames of Python's import, and of a compiler of kernels, are among this one and its callers."""
    count = 0
    while frame is not None:
        count += frame.f_code.co_filename.startswith("<frozen importlib")
        count += frame.f_globals.get("__name__", "").startswith(_COMPILERS)
        frame = frame.f_back
    return count


class Deferred:
    """The result of `deferred`: the `signal` that came, and `pass_on` to act on it."""

    signal: int | None = None
    before: Mapping[int, Any] = {}

    def pass_on(self, note: str) -> None:
        """Call the former handler of the noted signal; an exception that it raises gets `note`."""
        if (number := self.signal) is not None:
            self.signal = None
            repeat = signal.signal(number, self.before.get(number, signal.SIG_DFL))
            try:
                signal.raise_signal(number)
            except BaseException as stop:
                stop.add_note(note)
                raise
            finally:
                signal.signal(number, repeat)


@contextmanager
def deferred() -> Iterator[Deferred]:
    """SIGINT, SIGTERM and SIGHUP are noted and take effect later; in the main thread only."""
    asked = Deferred()

    def note(number: int, frame: Any) -> None:
        asked.signal = number

    with _handled(note, signal.SIGINT, *_ENDING) as asked.before:
        yield asked
    if asked.signal is not None:
        signal.raise_signal(asked.signal)  # it came after the last block


@contextmanager
def finishing(note: str, at_once: bool) -> Iterator[None]:
    """SIGINT, SIGTERM and SIGHUP wait for the end of the block, and their exception says `note`; not if they are to end
    it `at_once`."""
    try:
        with nullcontext() if at_once else deferred():
            yield
    except (KeyboardInterrupt, Terminated) as stop:
        if not at_once:
            stop.add_note(note)
        raise


@contextmanager
def _handled(handler: Any, *numbers: int) -> Iterator[dict[int, Any]]:
    """These signals go to `handler`, except ignored ones; yields their former handlers."""
    before: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for number in numbers:
            if signal.getsignal(number) not in (None, signal.SIG_IGN):
                before[number] = signal.signal(number, handler)
    try:
        yield before
    finally:
        for number, own in before.items():
            signal.signal(number, own)
