"""The four rooms put to work: scene files, runs, result files, pictures, the command line.

    result = toolkit.run("gaussian")         # a shipped scene, a scene file or a dict
    toolkit.save(result, "gaussian-output")  # result.h5, summary.json, picture.png
    toolkit.run("gaussian", folder="gaussian-output")  # both, and a long run goes on where it was cut short
    result = toolkit.load("gaussian-output")
    toolkit.plot(result)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from toolkit.pictures.run import plot
    from toolkit.results.files import load, save
    from toolkit.running.runner import run
    from toolkit.scene.scene import load_scene

__version__ = "0.1.0"

__all__ = ["__version__", "load", "load_scene", "plot", "run", "save"]

_HOMES = {
    "load": "toolkit.results.files",
    "save": "toolkit.results.files",
    "plot": "toolkit.pictures.run",
    "run": "toolkit.running.runner",
    "load_scene": "toolkit.scene.scene",
}


def __getattr__(name: str) -> Any:
    # imported when first asked for: the command's --help needs none of it
    if name not in _HOMES:
        raise AttributeError(f"module 'toolkit' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
