"""Output folders, written completely or not at all, and files with a checksum: a header of 512 bytes, then the data.

HDF5 skips such a header, so that any HDF5 program reads a sealed result file.
"""

import os
import socket
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

from origins.errors import InputError, refuse, shown

_HEADER = 512  # bytes: the least that HDF5 skips
_MAGIC = b"mesofriction, sha256 of the rest: "
_HDF5 = b"\x89HDF"  # begins the files of older versions, which have no checksum


def check_folder(folder: str | os.PathLike[str]) -> None:
    """Try whether `folder` can be written. Raises InputError where it lies below a file or cannot be."""
    with _draft(folder) as draft:
        place = draft / (Path(folder).absolute().name or "root")  # a name may be too long
        place.mkdir()
        (place / "try").write_bytes(bytes(_HEADER))


@contextmanager
def only_writer(folder: str | os.PathLike[str]) -> Iterator[None]:
    """Lock `folder` against this user's other runs on this machine, which could overwrite the result. Raises InputError
    where another run holds it. The lock is a name of Linux's that no file bears, so that it ends with the process,
    however that ends; other systems have no such names, and there is no lock on them."""
    name = sha256(os.fsencode(Path(folder).resolve())).hexdigest()[:24]
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as lock:
        try:
            if sys.platform == "linux":
                lock.bind(f"\0mesofriction-{os.getuid()}-{name}")
        except OSError as error:
            hint = "another run is writing there; choose another folder, or wait"
            raise InputError(f"out = {str(folder)!r}: {hint}") from error
        yield


def write_folder(
    folder: str | os.PathLike[str],
    writers: Mapping[str, Callable[[Path], None]],
    gone: Sequence[str] = (),
) -> None:
    """Write files into `folder`, each by a function that is given its path: all of them, or none.

    They are written elsewhere on the same disk first, and flushed to it, since a checkpoint is removed once the results
    exist. Files of other names are kept, except those in `gone`, which are removed once all files are written.
    Raises InputError where writing fails.
    """
    path = Path(folder)
    with _draft(folder) as draft:
        for name, write in writers.items():
            write(draft / name)
            _flush(draft / name)
        path.mkdir(parents=True, exist_ok=True)
        for name in writers:
            os.replace(draft / name, path / name)
        with suppress(OSError):  # names of new files, where the file system can
            _flush(path)
            _flush(path.parent)
        for name in gone:
            (path / name).unlink(missing_ok=True)


def _flush(path: Path) -> None:
    """Bring a file, or the names in a folder, to the disk."""
    place = os.open(path, os.O_RDONLY)
    try:
        os.fsync(place)
    finally:
        os.close(place)


@contextmanager
def _draft(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary folder on the disk of `folder`, removed in the end. Raises InputError where writing fails."""
    path = Path(folder).absolute()
    try:
        for place in (path, *path.parents):
            if place.is_dir():
                break
            if os.path.lexists(place):
                refuse("out", str(folder), f"{place} is a file, not a folder; choose another")
        with tempfile.TemporaryDirectory(prefix=".draft-", dir=place) as draft:
            yield Path(draft)
    except InputError:
        raise
    except (OSError, ValueError) as error:  # of no name a path may have, ValueError
        why = getattr(error, "strerror", None) or error
        raise InputError(f"out = {shown(str(folder))}: cannot be written: {why}") from error


def write_sealed(path: Path, contents: bytes) -> None:
    """Replace the file by header and contents, completely or not at all, flushed to the disk. Raises OSError."""
    draft = path.with_name(f".{path.name}.part")
    try:
        draft.write_bytes(_header(contents) + contents)
        _flush(draft)
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)


def read_sealed(path: Path) -> bytes | None:
    """The contents; None where the checksum is wrong. Raises OSError."""
    data = path.read_bytes()
    contents = data[_HEADER:]
    return contents if data[:_HEADER] == _header(contents) else None


def _header(contents: bytes) -> bytes:
    return (_MAGIC + sha256(contents).hexdigest().encode() + b"\n").ljust(_HEADER, b"\0")


@contextmanager
def opened(file: Path) -> Iterator[Any]:
    """A sealed HDF5 file, open for reading. Raises InputError for a damaged file, before HDF5 reads it, which may crash
    on some bytes; and for data in other files."""
    import h5py

    try:
        with file.open("rb") as stream:
            old = stream.read(len(_HDF5)) == _HDF5
        if not old and read_sealed(file) is None:
            raise OSError("its checksum is wrong")
        with h5py.File(file, "r") as store:
            links, items = dict[str, Any](), dict[str, Any]()
            store.visititems_links(links.__setitem__)
            store.visititems(items.__setitem__)
            for name, link in links.items():
                item = items.get(name)
                away = isinstance(item, h5py.Dataset) and (item.external or item.is_virtual)
                if away or not isinstance(link, h5py.HardLink):
                    raise OSError(f"the data of {name} are in another file, or under another name")
            yield store
    except InputError:
        raise
    except Exception as error:  # h5py and numpy raise many kinds for invalid bytes
        why = " ".join(str(error).split())
        raise InputError(
            f"folder = {str(file.parent)!r}: its {file.name} is not one of mesofriction: {why}"
        ) from error
