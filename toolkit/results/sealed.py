"""Files with a checksum: a header of 512 bytes, then the contents.

HDF5 skips such a header, so that any HDF5 program reads a sealed result file.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from origins.errors import InputError

if TYPE_CHECKING:
    import h5py

_HEADER = 512  # bytes: the least that HDF5 skips
_MAGIC = b"mesofriction, sha256 of the rest: "
_HDF5 = b"\x89HDF"  # begins the files of older versions, which have no checksum


def write_sealed(path: Path, contents: bytes) -> None:
    """Write header and contents. They are on the disk when this returns. Raises OSError."""
    with path.open("wb") as stream:
        stream.write(_header(contents) + contents)
        stream.flush()
        os.fsync(stream.fileno())


def read_sealed(path: Path) -> bytes | None:
    """The contents; None where they are not what was written. Raises OSError."""
    data = path.read_bytes()
    contents = data[_HEADER:]
    return contents if data[:_HEADER] == _header(contents) else None


def flush_folder(path: Path) -> None:
    """Bring the names of new files in `path` to the disk, where the file system can."""
    with suppress(OSError):
        place = os.open(path, os.O_RDONLY)
        try:
            os.fsync(place)
        finally:
            os.close(place)


@contextmanager
def opened(file: Path) -> Iterator["h5py.File"]:
    """A sealed HDF5 file, open for reading.

    What is damaged is refused before HDF5 sees it, which would crash on some bytes; so are data that are elsewhere.
    Files of older versions begin as HDF5 does, and have no checksum. Raises InputError.
    """
    import h5py

    try:
        with file.open("rb") as stream:
            old = stream.read(len(_HDF5)) == _HDF5
        if not old and read_sealed(file) is None:
            raise OSError("its checksum is wrong")
        with h5py.File(file, "r") as store:
            _check_links(store)
            yield store
    except InputError:
        raise
    except Exception as error:  # whatever h5py and numpy make of bytes that nobody wrote so
        why = " ".join(str(error).split())
        raise InputError(
            f"folder = {str(file.parent)!r}: its {file.name} is not one of mesofriction: {why}"
        ) from error


def _check_links(group: "h5py.Group") -> None:
    """Raise OSError for data that are elsewhere: in another file, or under another name."""
    import h5py

    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise OSError(f"{name} is a link")
        item = group[name]
        if isinstance(item, h5py.Group):
            _check_links(item)
        elif item.external or item.is_virtual:
            raise OSError(f"the data of {name} are in another file")


def _header(contents: bytes) -> bytes:
    return (_MAGIC + sha256(contents).hexdigest().encode() + b"\n").ljust(_HEADER, b"\0")
