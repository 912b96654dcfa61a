"""Files that a scene names: read once, on one rank, or refused by the scene's key."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from origins.errors import InputError, refuse
from toolkit.processes.ranks import on_root

T = TypeVar("T")


def read_file(
    key: str, file: str, folder: Path, comm: Any, read: Callable[[Path], T], what: str = "file"
) -> T:
    """The result of `read` for the file in this folder, the same on all ranks, which must all call. `key` is the
    scene's key that names it. Raises InputError unless it is a plain file: a pipe or a device might never end."""
    if not isinstance(file, str):
        refuse(key, file, f'must be a name of a {what}, such as "own.txt"')

    def checked() -> T:
        """What `read` gives, on the one rank that has the file; InputError by the scene's key for all that fails."""
        path = folder / file
        try:
            if path.is_dir():
                refuse(key, file, f"is a folder; name a {what} in it")
            if path.is_file() and path.stat().st_size <= 1 << 30:
                return read(path)
        except InputError:
            raise
        except UnicodeDecodeError:
            refuse(key, file, "is no text in UTF-8; name another file, or save it as UTF-8")
        except (OSError, ValueError) as error:  # a name too long for the disk
            refuse(key, file, f"cannot be read: {getattr(error, 'strerror', None) or error}")
        whole = path.parent.resolve() / path.name
        hint = f"{whole} is no plain {what} of at most a gigabyte"
        if not path.exists():
            hint = f"no such file: {whole}; write its path from the folder of the scene, or an absolute one"
        refuse(key, file, hint)

    return on_root(comm, checked)


def read_text(path: Path) -> str:
    """The text of a file, without the byte order mark that some programs put first."""
    return path.read_text(encoding="utf-8-sig")
