"""Files with a checksum: a header of 512 bytes, then the contents.

HDF5 skips such a header, so that any HDF5 program reads a sealed result file.
"""

import os
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

_HEADER = 512  # bytes: the least that HDF5 skips
_MAGIC = b"mesofriction, sha256 of the rest: "


def write_sealed(path: Path, contents: bytes) -> None:
    """Write header and contents. They are on the disk when this returns. Raises OSError."""
    with path.open("wb") as stream:
        stream.write(_header(contents))
        stream.write(contents)
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


def _header(contents: bytes) -> bytes:
    return (_MAGIC + sha256(contents).hexdigest().encode() + b"\n").ljust(_HEADER, b"\0")
