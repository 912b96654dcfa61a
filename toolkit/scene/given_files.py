"""Files that a scene names, read by rank 0 for all ranks, which else might see different ones."""

import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from origins.errors import refuse
from toolkit.running.ranks import on_root

T = TypeVar("T")

_MOST = 1 << 30  # bytes


def read_file(
    key: str, file: str, folder: Path, comm: Any, read: Callable[[Path], T], what: str = "file"
) -> T:
    """What `read` makes of the file in this folder, the same on all ranks, which must all call.

    `key` is the scene's key that names it. Raises InputError for what is no plain file: a pipe or a device might never
    end.
    """
    if not isinstance(file, str):
        refuse(key, file, f'must be a name of a {what}, such as "own.txt"')

    def checked() -> T:
        path, rule = folder / file, ""
        try:
            status = path.stat()
            if stat.S_ISDIR(status.st_mode):
                rule = f"is a folder; name a {what} in it"
            elif not stat.S_ISREG(status.st_mode):
                rule = "is no plain file; name one"
            elif status.st_size > _MOST:
                rule = f"has {status.st_size:.2g} bytes; {_MOST:.2g} are the most"
        except FileNotFoundError:
            rule = f"no such file in {path.parent.resolve()}"
        except (OSError, ValueError) as error:  # a name too long for the disk, or with a NUL
            rule = f"cannot be read: {getattr(error, 'strerror', None) or error}"
        if rule:
            refuse(key, file, rule)
        return read(path)

    return on_root(comm, checked)


def read_text(
    key: str, file: str, folder: Path, comm: Any, bad: str = "cannot be read as text"
) -> str:
    """The text of such a file; `bad` is what a message says of one that holds none."""

    def read(path: Path) -> str:
        try:
            return path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            refuse(key, file, f"{bad}: {getattr(error, 'strerror', None) or error}")

    return read_file(key, file, folder, comm, read)
