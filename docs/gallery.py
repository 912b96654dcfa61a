"""Runs every shipped scene and keeps its picture for the gallery of the site: python docs/gallery.py build/gallery"""

import sys
from pathlib import Path

import toolkit
from toolkit.scene.scene import shipped_scenes


def main(folder: Path) -> None:
    """Results of each scene into a folder of its name; scenes whose picture is there are left out."""
    for name in shipped_scenes():
        if not (folder / name / "picture.png").exists():
            print(f"docs: running the scene {name}", flush=True)
            toolkit.run(name, folder=folder / name)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
