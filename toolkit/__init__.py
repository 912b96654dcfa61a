"""origins, master and eq_model put to work: scene files, runs, result files, pictures, the command line.

result = toolkit.run("gaussian")         # a shipped scene, a scene file or a dict
toolkit.save(result, "gaussian-output")  # result.h5, summary.json, picture.png
toolkit.run("gaussian", folder="gaussian-output")  # both; a long run continues where it was interrupted
result = toolkit.load("gaussian-output")
toolkit.plot(result)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from toolkit.version import __version__

if TYPE_CHECKING:
    from toolkit.pictures.run import plot
    from toolkit.results.files import load
    from toolkit.running.runner import run
    from toolkit.saving import save
    from toolkit.scene.scene import load_scene

__all__ = ["__version__", "load", "load_scene", "plot", "run", "save"]

_HOMES = {"load": "results.files", "save": "saving", "plot": "pictures.run"}
_HOMES |= {"run": "running.runner", "load_scene": "scene.scene"}


def __getattr__(name: str) -> Any:
    # imported on first use: the command's --help needs none of it
    if name not in _HOMES:
        raise AttributeError(f"module 'toolkit' has no attribute {name!r}")
    return getattr(import_module(f"toolkit.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    # for completion, which does not ask __getattr__
    return sorted(__all__)
