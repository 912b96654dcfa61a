"""The four rooms under one name: ``import mesofriction as mf``, then ``mf.origins.gaussian(1.0, 0.05)``.

origins states the problem, master and eq_model solve it, toolkit puts them to work; each is imported on first use, and
``import origins`` is the same module.
"""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from toolkit.version import __version__

if TYPE_CHECKING:
    import eq_model
    import master
    import origins
    import toolkit

__all__ = ["__version__", "eq_model", "master", "origins", "toolkit"]


def __getattr__(name: str) -> ModuleType:
    # numba and scipy are not imported by those who do not need them
    if name not in __all__:
        raise AttributeError(f"module 'mesofriction' has no attribute {name!r}")
    return import_module(name)


def __dir__() -> list[str]:
    return sorted(__all__)


if __name__ == "__main__":  # python -m mesofriction
    import sys

    from toolkit.command import main

    sys.exit(main())
