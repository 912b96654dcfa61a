"""Files that a scene names, read by rank 0 for all ranks, which else might see different ones."""

import stat
from pathlib import Path
from typing import Any

from origins.errors import InputError, shown
from toolkit.running.ranks import on_root

_MOST = 1 << 30  # bytes


def read_text(
    key: str, file: Path, comm: Any, shown_as: object, bad: str = "cannot be read as text"
) -> str:
    """The text of a file, the same on all ranks, which must all call.

    `key` is the scene's key that names it, `shown_as` its value there, and `bad` what a message says of it.
    Raises InputError for what is no readable file of text.
    """

    def read() -> str:
        check_regular(key, file, str(shown_as))
        try:
            return file.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            why = getattr(error, "strerror", None) or error
            raise InputError(f"{key} = {shown(str(shown_as))}: {bad}: {why}") from error

    return on_root(comm, read)


def check_regular(key: str, file: Path, shown_as: str, what: str = "file") -> None:
    """Raise InputError unless there is a plain file of this name: a pipe or a device might never end."""
    rule = ""
    try:
        status = file.stat()
        if stat.S_ISDIR(status.st_mode):
            rule = f"is a folder; name a {what} in it"
        elif not stat.S_ISREG(status.st_mode):
            rule = "is no plain file; name one"
        elif status.st_size > _MOST:
            rule = f"has {status.st_size:.2g} bytes; {_MOST:.2g} are the most"
    except FileNotFoundError:
        rule = f"no such file in {file.parent.resolve()}"
    except (OSError, ValueError) as error:  # a name too long for the disk, or with a NUL
        rule = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    if rule:
        raise InputError(f"{key} = {shown(shown_as)}: {rule}")
