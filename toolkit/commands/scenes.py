"""mesofriction scenes: the shipped scenes with their titles."""

import argparse
import tomllib
from typing import Any

ALL_RANKS = False


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """None."""


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Print a line per scene."""
    from toolkit.scene import SHIPPED, shipped_scenes

    for name in shipped_scenes():
        title = tomllib.loads((SHIPPED / f"{name}.toml").read_text(encoding="utf-8"))["title"]
        print(f"{name:16} {title}")
    return 0
