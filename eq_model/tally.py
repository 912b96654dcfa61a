"""Counts of the histograms of finished blocks: kept in a file without a name, and worked on part by part."""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model.histogram import BINS
from origins.errors import InputError

Counts = npt.NDArray[np.unsignedinteger[Any]]

PART = 1 << 20  # bytes worked on at once
_ASIDE = 1 << 24  # bytes that are held in memory: a few histograms need no file
_SLOTS = 2  # counts that are added up are written beside those there were


class Tally:
    """Counts of shape (points, 2, BINS), of stretches and of thresholds at each point; they never change.

    What is added makes another tally in a free place of the same file: whatever interrupts that, this one is whole. A
    place is free once nothing refers to its tally any more. A pickle holds the counts themselves.
    """

    def __init__(self, room: _Room, points: int, dtype: npt.DTypeLike) -> None:
        """Of what a free place of the room holds; `begin` is where that is."""
        self.points, self.dtype = points, np.dtype(dtype)
        self._room, self.begin = room, room.free()
        room.taken.add(self)

    @classmethod
    def zeros(cls, points: int, most: int) -> Tally:
        """None yet, of `most` contacts in the end, with room to add to them: a disk that is too small says so here."""
        dtype = _dtype(most)
        return cls(_Room(_size(points, dtype), _SLOTS), points, dtype)

    @classmethod
    def of(cls, points: int, dtype: npt.DTypeLike, parts: Iterable[Counts]) -> Tally:
        """In a file of its own, as `parts` give them."""
        return cls(_Room(_size(points, np.dtype(dtype))), points, dtype)._filled(parts)

    def parts(self) -> Iterator[Counts]:
        """All counts one after the other, in parts of at most PART bytes."""
        size = _size(self.points, self.dtype)
        for begin in range(0, size, PART):
            yield self._read(begin, min(PART, size - begin))

    def at(self, point: int) -> Counts:
        """Of one point, shape (2, BINS)."""
        size = _size(1, self.dtype)
        return self._read(point * size, size).reshape(2, BINS)

    def plus(self, block: Counts) -> Tally:
        """With those of one block more."""
        flat, each = block.reshape(-1), PART // self.dtype.itemsize
        others = (flat[begin : begin + each] for begin in range(0, flat.size, each))
        return self._beside(one + other for one, other in zip(self.parts(), others, strict=True))

    def joined(self, other: Tally) -> Tally:
        """Of both. Raises InputError where one counts other histograms."""
        if (self.points, self.dtype) != (other.points, other.dtype):
            raise InputError("earlier: was found with other histograms, or of more contacts; start anew")
        return self._beside(one + two for one, two in zip(self.parts(), other.parts(), strict=True))

    def of_all(self, comm: Any) -> Tally:
        """Of all ranks together, which must call."""
        if comm is None:
            return self

        def summed() -> Iterator[Counts]:
            for part in self.parts():
                whole = np.empty_like(part)
                comm.Allreduce(part, whole)  # whole numbers: the order does not matter
                yield whole

        return self._beside(summed())

    def __reduce__(self) -> tuple[Any, ...]:
        return Tally.of, (self.points, self.dtype, list(self.parts()))

    def _beside(self, parts: Iterable[Counts]) -> Tally:
        return Tally(self._room, self.points, self.dtype)._filled(parts)

    def _filled(self, parts: Iterable[Counts]) -> Tally:
        begin = self.begin
        for part in parts:
            self._room.write(begin, part.data.cast("B"))
            begin += part.nbytes
        return self

    def _read(self, begin: int, size: int) -> Counts:
        found = bytearray(size)
        self._room.read(self.begin + begin, memoryview(found))
        return np.frombuffer(found, self.dtype)


def sizes(points: int, most: int) -> tuple[int, int]:
    """Bytes of a tally of `most` contacts in the end, and of its file; 0 for that where it is held in memory."""
    size = _size(points, _dtype(most))
    return size, _SLOTS * size if _SLOTS * size > _ASIDE else 0


def _dtype(most: int) -> np.dtype[Any]:
    return np.dtype(np.uint32 if most < 1 << 32 else np.uint64)


def _size(points: int, dtype: np.dtype[Any]) -> int:
    return points * 2 * BINS * dtype.itemsize


class _Room:
    """Places of `size` bytes one after the other, as many as there are tallies at once; `ready` of them from the start.

    taken : the tallies that are there.
    """

    def __init__(self, size: int, ready: int = 0) -> None:
        self._size, self._held, self._file = size, bytearray(), -1
        self.taken = weakref.WeakSet[Tally]()
        with self._told():
            if _SLOTS * size > _ASIDE:
                from tempfile import TemporaryFile

                # no buffer of Python's, whose writing might fail later on; nor a map of it, where a full disk is fatal
                file = TemporaryFile(buffering=0)  # noqa: SIM115
                weakref.finalize(self, file.close)
                self._file = file.fileno()
        for begin in range(0, ready * size, PART):
            self.write(begin, memoryview(bytes(min(PART, ready * size - begin))))

    def free(self) -> int:
        """Where the first free place begins."""
        taken = {tally.begin for tally in self.taken}
        return next(begin for begin in count(0, max(self._size, 1)) if begin not in taken)

    def read(self, begin: int, into: memoryview) -> None:
        if self._file < 0:
            into[:] = self._held[begin : begin + len(into)]
            return
        with self._told():
            while into:
                done = os.preadv(self._file, [into], begin)
                if not done:
                    raise OSError("is shorter than it was")
                begin, into = begin + done, into[done:]

    def write(self, begin: int, data: memoryview) -> None:
        if self._file < 0:
            self._held[begin : begin + len(data)] = data
            return
        with self._told():
            while data:
                done = os.pwrite(self._file, data, begin)
                begin, data = begin + done, data[done:]

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Where the disk refuses, one line that says what for."""
        import tempfile

        try:
            yield
        except OSError as error:
            where = f" in {tempfile.tempdir}" if tempfile.tempdir else ""
            raise InputError(
                f"histograms: their counts take {_SLOTS * self._size / 1e6:.0f} MB in a temporary file{where}: "
                f"{error.strerror or error}; let TMPDIR name a folder with room, or ask for fewer histograms"
            ) from error
