"""Output folders: written whole or not at all."""

import fcntl
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

from origins.errors import InputError, refuse, shown
from toolkit.results.sealed import flush_folder

_TRIED = bytes(512)


def check_folder(folder: str | os.PathLike[str]) -> None:
    """Try whether `folder` can be written. Raises InputError where it lies below a file or cannot be."""
    with _draft(folder) as draft:
        place = draft / (Path(folder).absolute().name or "root")  # a name may be too long
        place.mkdir()
        (place / "try").write_bytes(_TRIED)


@contextmanager
def only_writer(folder: str | os.PathLike[str]) -> Iterator[None]:
    """Hold `folder` against other runs on this machine, which would replace one result by another.

    Raises InputError where another run holds it. The lock is a file in the system's folder for temporary files, since
    the output folder need not exist yet; it ends with the process, however that ends.
    """
    name = sha256(str(Path(folder).resolve()).encode("utf-8", "surrogateescape")).hexdigest()[:24]
    try:
        file = Path(tempfile.gettempdir()) / f"mesofriction-{name}.lock"
        lock = os.open(file, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError:  # no room for locks, or another user's
        yield
        return
    try:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            rule = "another run is writing there; choose another folder, or wait until it has ended"
            raise InputError(f"out = {str(folder)!r}: {rule}") from error
        yield
    finally:
        os.close(lock)


def write_folder(
    folder: str | os.PathLike[str],
    writers: Mapping[str, Callable[[Path], None]],
    gone: Sequence[str] = (),
) -> None:
    """Write files into `folder`, each by a function that is given its path: all of them, or none.

    They are written elsewhere on the same disk first, and flushed to it: a checkpoint is removed once the results are
    there. Files of other names are left alone but those in `gone`, which are removed once all are written.
    Raises InputError where the disk refuses.
    """
    path = Path(folder)
    with _draft(folder) as draft:
        for name, write in writers.items():
            write(draft / name)
            with (draft / name).open("rb") as stream:
                os.fsync(stream.fileno())
        path.mkdir(parents=True, exist_ok=True)
        for name in writers:
            os.replace(draft / name, path / name)
        flush_folder(path)
        flush_folder(path.parent)
        for name in gone:
            (path / name).unlink(missing_ok=True)


@contextmanager
def _draft(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """A folder for drafts on the disk of `folder`, taken away in the end. Raises InputError where the disk refuses."""
    path = Path(folder).absolute()
    if "\0" in str(folder):
        refuse("out", str(folder), "holds a letter that no name may have; choose another")
    try:
        for place in (path, *path.parents):
            if place.is_dir():
                break
            if os.path.lexists(place):
                refuse("out", str(folder), f"{place} is a file, not a folder; choose another")
        with tempfile.TemporaryDirectory(prefix=".draft-", dir=place) as draft:
            yield Path(draft)
    except OSError as error:
        why = error.strerror or error
        raise InputError(f"out = {shown(str(folder))}: cannot be written: {why}") from error
