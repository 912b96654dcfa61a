"""mesofriction scenes: the shipped scenes with their titles."""

import argparse
import textwrap
import tomllib
from typing import Any

ALL_RANKS = False
_COLUMNS = 100


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print the names in one column and the titles in another, 100 columns in all; long titles go on below."""
    from toolkit.scene.scene import SHIPPED, shipped_scenes

    names = shipped_scenes()
    width = max(map(len, names)) + 2
    for name in names:
        title = tomllib.loads((SHIPPED / f"{name}.toml").read_text(encoding="utf-8"))["title"]
        print(textwrap.fill(f"{name:{width}}{title}", _COLUMNS, subsequent_indent=" " * width))
    return 0
