"""What ensembles of independent and of coupled contacts share: units of work, done one by one or in threads."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter
from typing import Any, NamedTuple

from origins.errors import positive, refuse, whole

_AT_ONCE = 8  # units that each thread is given before all are waited for


class Done(NamedTuple):
    """A unit of work, what it found, and the seconds since the one before."""

    unit: int
    found: Any
    seconds: float


class UnderWay:
    """An ensemble that is worked through; `clock` returns seconds: wall time and run time go by it."""

    clock: Callable[[], float] = staticmethod(perf_counter)

    def _set_up(
        self,
        most: tuple[int, int],
        contacts: int,
        replicas: int,
        threads: int,
        comm: Any,
        wall: Any,
    ) -> None:
        """Check what all ensembles are given; contacts and replicas must be below `most`."""
        if comm is not None and not hasattr(comm, "Get_rank"):
            rule = (
                "must be a communicator of mpi4py, such as MPI.COMM_WORLD, or None for this process"
            )
            refuse("comm", comm, rule)
        self.comm, self._threads = comm, whole("threads", threads, 1)
        self.n_contacts = whole("n_contacts", contacts, 1)
        self.n_replicas = whole("n_replicas", replicas, 1)
        for name, value, largest in zip(
            ("n_contacts", "n_replicas"), (self.n_contacts, self.n_replicas), most, strict=True
        ):
            if value >= largest:
                refuse(name, value, f"must be below {largest}")
        self.total = self.expected = self.n_contacts * self.n_replicas
        self._wall_time = None if wall is None else positive("wall_time", wall)
        self._stopped = False

    def stop(self) -> None:
        """Begin no further unit of this rank's share: the result will be that of what is finished."""
        self._stopped = True

    def _late(self, begun: float) -> bool:
        past = self._wall_time is not None and self.clock() - begun > self._wall_time
        return self._stopped or past

    def _each(self, follow: Callable[[int], Any], units: Sequence[int]) -> Iterator[Done]:
        """The units in order, each followed; in threads several at once."""
        started = self.clock()
        if self._threads == 1:
            for unit in units:
                yield Done(unit, follow(unit), self.clock() - started)
                started = self.clock()
            return
        with ThreadPoolExecutor(self._threads) as pool:
            for at in range(0, len(units), _AT_ONCE * self._threads):
                some = units[at : at + _AT_ONCE * self._threads]
                for unit, found in zip(some, pool.map(follow, some), strict=True):
                    yield Done(unit, found, self.clock() - started)
                    started = self.clock()
