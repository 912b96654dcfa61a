"""result.h5, open for reading, once it is known to be whole."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from origins.errors import InputError
from toolkit.results.sealed import read_sealed

if TYPE_CHECKING:
    import h5py

RESULT = "result.h5"
_HDF5 = b"\x89HDF"  # begins the files of older versions, which have no checksum


@contextmanager
def opened(file: Path, checked: bool = False) -> Iterator["h5py.File"]:
    """A result file, open for reading; `checked` says that these bytes were read before.

    What is damaged is refused before HDF5 sees it, which would crash on some bytes. Files of older versions begin as
    HDF5 does, and have no checksum. Raises InputError.
    """
    import h5py

    try:
        with file.open("rb") as stream:
            old = stream.read(len(_HDF5)) == _HDF5
        if not old and not checked and read_sealed(file) is None:
            raise OSError("its checksum is wrong")
        with h5py.File(file, "r") as store:
            _check_links(store)
            yield store
    except InputError:
        raise
    except Exception as error:  # whatever h5py and numpy make of bytes that nobody wrote so
        why = " ".join(str(error).split())
        raise InputError(
            f"folder = {str(file.parent)!r}: its {RESULT} is not one of mesofriction: {why}"
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
