"""Output folders: written whole or not at all."""

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from origins.errors import InputError, refuse


def check_folder(folder: str | os.PathLike[str]) -> Path:
    """`folder` as a path that can be written. Raises InputError where it lies below a file or may not be written."""
    path = Path(folder)
    for place in (path, *path.absolute().parents):
        if place.is_dir():
            if not os.access(place, os.W_OK | os.X_OK):
                refuse("out", str(folder), f"{place} may not be written; choose another folder")
            return path
        if os.path.lexists(place):
            refuse("out", str(folder), f"{place} is a file, not a folder; choose another folder")
    return path


def write_folder(
    folder: str | os.PathLike[str], writers: Mapping[str, Callable[[Path], None]], gone: Sequence[str] = ()
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
            if path.is_dir():
                for name in writers:
                    os.replace(draft / name, path / name)
                for name in gone:
                    (path / name).unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"out = {str(folder)!r}: cannot be written: {error.strerror or error}") from error


@contextmanager
def _beside(path: Path) -> Iterator[Path]:
    """A draft folder that becomes `path`, missing parents included, in one rename; inside `path` where that exists."""
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
        if top is not None:
            os.rename(home / top.name, top)
    finally:
        shutil.rmtree(home, ignore_errors=True)
