"""What mkdocs adds to the pages of this folder: the README in front, the API from docstrings, the gallery."""

import inspect
import json
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from toolkit.scene.scene import load_scene, shipped_scenes

ROOT = Path(__file__).resolve().parents[1]
GALLERY = ROOT / "build" / "gallery"  # made by docs/gallery.py
# Code that is fenced, indented, or between backticks; CODE.split puts it at the odd places
CODE = re.compile(r"(^```.*?^```|^    .*?$|`[^`\n]*`)", re.DOTALL | re.MULTILINE)
ROOMS = ("origins", "master", "eq_model", "toolkit")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """All pages and pictures of the site."""
    readme = (
        (ROOT / "README.md")
        .read_text(encoding="utf-8")
        .replace("](docs/", "](")
        .replace(".ipynb)", ".md)")
    )
    pages = {"index.md": readme, "gallery.md": gallery()}
    for notebook in (ROOT / "docs").glob("*.ipynb"):
        pages[f"{notebook.stem}.md"] = of_notebook(notebook)
    pages |= {f"api/{room}.md": api(room) for room in ROOMS}
    for address, text in pages.items():
        files.append(File.generated(config, address, content=text))
    for picture in GALLERY.glob("*/picture.png"):
        address = f"gallery/{picture.parent.name}.png"
        files.append(File.generated(config, address, abs_src_path=str(picture)))
    return files


def on_page_markdown(markdown: str, **_: object) -> str:
    """Escape, outside code, <x_s> (no tag of HTML) and the asterisk of K* (no italics)."""
    parts = CODE.split(markdown)
    for i in range(0, len(parts), 2):
        parts[i] = re.sub(r"(?<=[KX])\*", r"\*", re.sub(r"<(?=[A-Za-z])", "&lt;", parts[i]))
    return "".join(parts)


def of_notebook(file: Path) -> str:
    """The cells of a notebook as a page: text, code, and what the code prints."""
    parts = []
    for cell in json.loads(file.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        parts.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
        for output in cell.get("outputs", []):
            parts.append(f"```text\n{''.join(output['text'])}```")
    return "\n\n".join(parts) + "\n"


def gallery() -> str:
    """The shipped scenes, each with its title, its picture and its text."""
    parts = [
        "# Gallery\n\nThe scenes that come with the package, and what `mesofriction run` draws of them.\n"
    ]
    for name in shipped_scenes():
        scene = load_scene(name)
        parts.append(f"## {name}\n\n{scene.title}\n\n![{scene.title}](gallery/{name}.png)\n")
        parts.append(f"```toml\n{scene.text.strip()}\n```\n")
    return "\n".join(parts)


def api(room: str) -> str:
    """Every public name of a room, with its signature and its docstring."""
    module = import_module(room)
    parts = [f"# {room}\n\n```text\n{inspect.getdoc(module)}\n```\n"]
    for name in sorted(module.__all__, key=str.lower):
        thing = getattr(module, name)
        if callable(thing):
            parts.append(entry(f"## {room}.{name}", name, thing))
            parts += methods(name, thing) if inspect.isclass(thing) else []
    return "\n".join(parts)


def methods(name: str, owner: type) -> Iterator[str]:
    """Public methods and properties that a class itself documents."""
    for key, value in vars(owner).items():
        found = value.fget if isinstance(value, property) else value
        if not key.startswith("_") and inspect.isfunction(found) and found.__doc__:
            yield entry(f"### {name}.{key}", key, found)


def entry(heading: str, name: str, thing: object) -> str:
    """One name: heading, signature, docstring."""
    try:
        signature = f"{name}{inspect.signature(thing)}"  # type: ignore[arg-type]
    except (TypeError, ValueError):
        signature = name
    docstring = inspect.getdoc(thing) or ""
    return f"{heading}\n\n```python\n{signature}\n```\n\n```text\n{docstring}\n```\n"
