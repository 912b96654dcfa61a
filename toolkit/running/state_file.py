"""A state of an ensemble in a file of its own, and its way back.

The file is numpy's .npz.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
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
    from eq_model.coupled.result import CoupledState
    from eq_model.state import State

_COUPLED = "coupled_"  # begins the names of arrays of replicas on soft sliders
BLOCKS = "eq.blocks"  # in a checkpoint's identity: how contacts are divided
# what zipfile and numpy say of bytes that are not what was written
_SPOILED = (OSError, EOFError, KeyError, ValueError, TypeError, RuntimeError, BadZipFile, TokenError, ZlibError)


def write_state(file: Path, state: State | CoupledState, told: dict[str, str]) -> None:
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


def read_state(file: Path) -> tuple[State | CoupledState, dict[str, str]] | None:
    """State, and of which run it is; None for a file that a failing disk spoiled.

    Raises InputError for a file of an older version.
    """
    from eq_model.coupled.result import CoupledState
    from eq_model.state import State

    try:
        with ZipFile(file) as members:
            names = [name.removesuffix(".npy") for name in members.namelist()]
            if coupled := [name for name in names if name.startswith(_COUPLED)]:
                arrays = {name.removeprefix(_COUPLED): _read(members, name) for name in coupled}
                return CoupledState.of_arrays(arrays), json.loads(str(_read(members, "identity")))
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


def _write(stream: IO[bytes], state: State | CoupledState, told: dict[str, str]) -> None:
    from eq_model.coupled.result import CoupledState

    if isinstance(state, CoupledState):
        own = {f"{_COUPLED}{name}": array for name, array in state.arrays().items()}
        _write_arrays(stream, own | {"identity": json.dumps(told)})
        return
    arrays: dict[str, npt.ArrayLike] = {
        "sums": state.sums,
        "counts": np.array([state.contacts, state.breaks, state.steps], np.int64),
        "done": np.array([(part.start, part.stop) for part in state.done], np.int64).reshape(-1, 2),
        "run_time": state.run_time,
        "identity": json.dumps(told),
        "histograms": state.counts,
    }
    _write_arrays(stream, arrays)


def _write_arrays(stream: IO[bytes], arrays: Mapping[str, npt.ArrayLike]) -> None:
    with ZipFile(stream, "w") as members:
        for name, array in arrays.items():
            with members.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(array))


def _read(members: ZipFile, name: str) -> npt.NDArray[Any]:
    """One array. Its member is read to the end: only there is its checksum looked at, which covers the header too."""
    return np.asarray(np.lib.format.read_array(BytesIO(members.read(f"{name}.npy")), allow_pickle=False))
