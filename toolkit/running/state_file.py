"""The state of an ensemble in a file of its own, and its way back.

The file is numpy's .npz behind a header with its checksum.
"""

from __future__ import annotations

import json
import os
from dataclasses import fields
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from origins.errors import InputError
from toolkit.results.sealed import flush_folder, read_sealed, write_sealed

if TYPE_CHECKING:
    from eq_model.coupled.result import CoupledState
    from eq_model.state import State

BLOCKS = "eq.blocks"  # in a checkpoint's identity: how contacts are divided
_ZIP = b"PK"  # begins the files of older versions, which had no header


def write_state(file: Path, state: State | CoupledState, told: dict[str, str]) -> None:
    """Write `state`, and `told`, of which run it is: whole or not at all, and on the disk when this returns."""
    from eq_model.coupled.result import CoupledState

    coupled = isinstance(state, CoupledState)
    arrays = state.arrays() if isinstance(state, CoupledState) else _arrays(state)
    stream = BytesIO()
    np.savez(stream, told_of=json.dumps(told), is_coupled=coupled, **arrays)
    draft = file.with_name(f".{file.name}.part")
    try:
        write_sealed(draft, stream.getvalue())
        os.replace(draft, file)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
    flush_folder(file.parent)


def read_state(file: Path) -> tuple[State | CoupledState, dict[str, str]] | None:
    """State, and of which run it is; None for a file that a failing disk spoiled.

    Raises InputError for a file of an older version.
    """
    from eq_model.coupled.result import CoupledState
    from eq_model.state import State

    try:
        contents = read_sealed(file)
        if contents is None:
            with file.open("rb") as stream:
                if stream.read(len(_ZIP)) == _ZIP:
                    raise _too_old(file)
            return None
    except OSError:
        return None
    arrays = dict(np.load(BytesIO(contents), allow_pickle=False))
    told = json.loads(str(arrays.pop("told_of")))
    try:
        if arrays.pop("is_coupled"):
            return CoupledState.of_arrays(arrays), told
        values: dict[str, Any] = {
            name: array if array.ndim else array.item() for name, array in arrays.items()
        }
        values["done"] = [range(start, stop) for start, stop in arrays["done"].tolist()]
        return State(**values), told
    except (KeyError, TypeError, ValueError) as error:
        raise _too_old(file) from error


def _too_old(file: Path) -> InputError:
    return InputError(
        f"{file}: is a checkpoint of an older version, which divided contacts otherwise; remove {file.parent}, or "
        "choose another folder"
    )


def _arrays(state: State) -> dict[str, Any]:
    values = {field.name: getattr(state, field.name) for field in fields(state)}
    return values | {
        "done": np.array([(part.start, part.stop) for part in state.done], np.int64).reshape(-1, 2)
    }
