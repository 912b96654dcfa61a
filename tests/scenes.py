"""What tests of scenes share: a small scene's tables, a file of them, the command in this process, and a scan."""

from pathlib import Path
from typing import Any

import numpy as np

from toolkit.command import main
from toolkit.scene.tables import to_toml

GAUSSIAN = {"kind": "gaussian", "mean": 1.0, "std": 0.05}
SUMMITS = {"kind": "summits", "radius": 1e-6, "std": 5e-8, "density": 1e12}
CONSTANTS = {"contact_modulus": 1.75e9, "shear_modulus": 1.1e9, "local_friction": 0.4}
ROUGH: dict[str, Any] = {"kind": "from-topography", "model": "gw", "law": "amontons"}
ROUGH |= {"pressure": 1e6, "surface": SUMMITS, "material": CONSTANTS}


def scene(thresholds: dict[str, Any] = GAUSSIAN, **tables: Any) -> dict[str, Any]:
    """Gaussian contacts on a short drive, the master equation alone, but for what is given; None leaves out."""
    own = {"contacts": {"thresholds": thresholds}, "drive": {"to": 2.0, "points": 21}, "master": {}}
    return {name: table for name, table in (own | tables).items() if table is not None}


def write(name: str = "mine", **tables: Any) -> str:
    """The file name.toml of that scene, in the current folder."""
    Path(f"{name}.toml").write_text(to_toml(scene(**tables)), encoding="utf-8")
    return f"{name}.toml"


def said(capsys: Any, *words: str) -> tuple[int, list[str], list[str]]:
    """Status of the command, and the lines of what it prints and of what it says on the side."""
    capsys.readouterr()
    try:
        status = main(list(words))
    except SystemExit as end:
        status = int(end.code or 0)
    out, err = capsys.readouterr()
    return status, out.splitlines(), err.splitlines()


def refused(capsys: Any, *words: str) -> str:
    """The one line in which the command refuses these words."""
    status, out, err = said(capsys, *words)
    assert status == 2 and out == [] and len(err) == 1 and len(err[0]) < 500, (status, out, err)
    return err[0].removeprefix("mesofriction: ")


class Scan:
    """What a topography object must offer."""

    def __init__(self, heights: np.ndarray, pixel_size: tuple, unit: object) -> None:
        self._heights, self.pixel_size, self.unit = heights, pixel_size, unit

    def heights(self) -> np.ndarray:
        return self._heights
