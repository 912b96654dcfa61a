"""A state of an ensemble in a file of its own, and its way back.

The file is numpy's .npz.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from tokenize import TokenError
from typing import IO, TYPE_CHECKING, Any
from zipfile import BadZipFile, ZipFile
from zlib import error as ZlibError

import numpy as np
import numpy.typing as npt

from origins.errors import InputError

if TYPE_CHECKING:
    from eq_model.state import State

BLOCKS = "eq.blocks"  # in a checkpoint's identity: how contacts are divided
# what zipfile and numpy say of bytes that are not what was written
_SPOILED = (OSError, EOFError, KeyError, ValueError, TypeError, RuntimeError, BadZipFile, TokenError, ZlibError)


def write_state(file: Path, state: State, told: dict[str, str]) -> None:
    """Write `state`, and of which run it is: whole or not at all, and on the disk when this returns."""
    draft = file.with_name(f".{file.name}.part")
    try:
        with draft.open("wb") as stream:
            _write(stream, state, told)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(draft, file)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
    with suppress(OSError):  # not every file system lets a folder be flushed
        place = os.open(file.parent, os.O_RDONLY)
        try:
            os.fsync(place)
        finally:
            os.close(place)


def read_state(file: Path) -> tuple[State, dict[str, str]] | None:
    """State, and of which run it is; None for a file that a failing disk spoiled.

    Raises InputError for a file of an older version.
    """
    from eq_model.state import State

    try:
        with ZipFile(file) as members:
            told, run_time = json.loads(str(_read(members, "identity"))), float(_read(members, "run_time"))
            if BLOCKS not in told:
                raise InputError(
                    f"{file}: is a checkpoint of an older version, which divided contacts otherwise; remove "
                    f"{file.parent}, or choose another folder"
                )
            contacts, breaks, steps = (int(count) for count in _read(members, "counts"))
            done = [range(int(start), int(stop)) for start, stop in _read(members, "done")]
            sums, counts = _read(members, "sums"), _read(members, "histograms")
            return State(sums, counts, contacts, breaks, steps, done, run_time), told
    except InputError:
        raise
    except _SPOILED:
        return None


def _write(stream: IO[bytes], state: State, told: dict[str, str]) -> None:
    arrays: dict[str, npt.ArrayLike] = {
        "sums": state.sums,
        "counts": np.array([state.contacts, state.breaks, state.steps], np.int64),
        "done": np.array([(part.start, part.stop) for part in state.done], np.int64).reshape(-1, 2),
        "run_time": state.run_time,
        "identity": json.dumps(told),
        "histograms": state.counts,
    }
    with ZipFile(stream, "w") as members:
        for name, array in arrays.items():
            with members.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(array))


def _read(members: ZipFile, name: str) -> npt.NDArray[Any]:
    """One array. Its member is read to the end: only there is its checksum looked at, which covers the header too."""
    return np.asarray(np.lib.format.read_array(BytesIO(members.read(f"{name}.npy")), allow_pickle=False))
