"""A file that HDF5 writes, on a disk that may be full: told of that, HDF5 would take the process down with it."""

from io import FileIO
from pathlib import Path
from typing import Any


class Untold(FileIO):
    """A new file for h5py: once the disk refuses, what is written is dropped, and `check` says so."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self._error: OSError | None = None

    def check(self) -> None:
        """Raises OSError where the disk refused."""
        if self._error is not None:
            raise self._error

    def write(self, data: Any) -> int:
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            while left and self._error is None:
                left = left[super().write(left) or 0 :]
        except OSError as error:
            self._error = error
        return size

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as error:
            self._error = self._error or error
            return 0
