"""Output folders: written whole or not at all."""

import fcntl
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

from origins.errors import InputError, refuse, shown
from toolkit.results.sealed import flush_folder

_TRIED = bytes(512)


def check_folder(folder: str | os.PathLike[str]) -> Path:
    """`folder` as a path that can be written, which is tried. Raises InputError where it lies below a file or cannot
    be written."""
    path = Path(folder)
    try:
        for place in (path, *path.absolute().parents):
            if place.is_dir():
                break
            if os.path.lexists(place):
                refuse("out", str(folder), f"{place} is a file, not a folder; choose another")
        with _beside(path, keep=False) as draft:
            (draft / "try").write_bytes(_TRIED)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise _unwritable(folder, error) from error
    return path


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


def _flush(path: Path) -> None:
    """Bring what a file holds to the disk: a checkpoint is removed once the results are there."""
    if path.is_file():
        with path.open("rb") as stream:
            os.fsync(stream.fileno())


def _unwritable(folder: str | os.PathLike[str], error: Exception) -> InputError:
    why = getattr(error, "strerror", None) or error
    return InputError(f"out = {shown(str(folder))}: cannot be written: {why}")


def write_folder(
    folder: str | os.PathLike[str],
    writers: Mapping[str, Callable[[Path], None]],
    gone: Sequence[str] = (),
) -> None:
    """Write files into `folder`, each by a function that is given its path: all of them, or none.

    They are written elsewhere on the same disk first; files of other names in the folder are left alone but those
    in `gone`, which are removed once all are written. Raises InputError where the disk refuses.
    """
    path = check_folder(folder)
    try:
        with _beside(path) as draft:
            for name, write in writers.items():
                write(draft / name)
                _flush(draft / name)
            if path.is_dir():
                for name in writers:
                    os.replace(draft / name, path / name)
                flush_folder(path)
                for name in gone:
                    (path / name).unlink(missing_ok=True)
    except OSError as error:
        raise _unwritable(folder, error) from error


@contextmanager
def _beside(path: Path, keep: bool = True) -> Iterator[Path]:
    """A draft folder that becomes `path`, missing parents included, in one rename; inside `path` where that exists.
    Without `keep` it becomes nothing."""
    path = path.absolute()
    if path.is_dir():
        top = None
        home = Path(tempfile.mkdtemp(prefix=".draft-", dir=path))
        draft = home
    else:
        top = next(place for place in (path, *path.parents) if place.parent.is_dir())
        home = Path(tempfile.mkdtemp(prefix=f".{top.name}-", dir=top.parent))
        draft = home / path.relative_to(top.parent)
        draft.mkdir(parents=True)
    try:
        yield draft
        if top is not None and keep:
            os.rename(home / top.name, top)
            flush_folder(top.parent)
    finally:
        shutil.rmtree(home, ignore_errors=True)
