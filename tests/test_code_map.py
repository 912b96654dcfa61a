"""docs/code-map.md names the one place of each equation, as the docstrings say."""

import re
import sys
from collections import Counter
from pathlib import Path
from types import FrameType

import numpy as np
from code_map import LABELS, NOWHERE, PAGE, ROOMS, ROOT, SEVERAL, page, places

import master
import origins


def test_each_equation_stands_in_one_place() -> None:
    claimed = Counter(label for place in places() for label in place.labels)
    several = {
        label: [place.name for place in places() if label in place.labels]
        for label, times in claimed.items()
        if times > 1 and label not in SEVERAL
    }
    assert several == {}
    assert set(claimed) | set(NOWHERE) == set(LABELS.values())
    assert not set(claimed) & set(NOWHERE)


def test_the_page_is_what_the_docstrings_say() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run python tests/code_map.py"


def test_the_tests_that_the_page_names_are_there() -> None:
    texts = {
        file.name: file.read_text(encoding="utf-8") for file in Path(__file__).parent.glob("*.py")
    }
    there = {*texts, *re.findall(r"^def (test_\w+)", "\n".join(texts.values()), re.MULTILINE)}
    named = set(re.findall(r"test_\w+(?:\.py)?", page()))
    assert len(named) > 10 and named - there == set()


def test_the_rows_on_wrong_numbers_name_files_that_are_there() -> None:
    """Of master, those to open first; and plain twins."""
    section = (
        page().split("## Where to look when a number is wrong")[1].split("Which tests hold")[0]
    )
    files = re.findall(r"`([\w/]+\.py)`", section)
    missing = [f for f in files if not any((ROOT / up / f).is_file() for up in ("", "master"))]
    assert len(files) > 20 and missing == []


def test_a_reading_order_names_each_file_of_its_folder() -> None:
    """Where a folder says in which order to read, a file that is left out is one that nobody finds."""
    orders = {
        init: text
        for room in ROOMS
        for init in (ROOT / room).rglob("__init__.py")
        if "In reading order" in (text := init.read_text(encoding="utf-8"))
    }
    missing = [
        file.relative_to(ROOT).as_posix()
        for init, text in orders.items()
        for file in init.parent.glob("*.py")
        if file != init and file.name not in text
    ]
    assert len(orders) > 5 and missing == []


def test_hardly_a_word_of_the_code_means_several_things() -> None:
    """Five words do, all of them terms of the field; another that comes to is renamed, and gets no row."""
    text = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
    table = text.split("## Words of the code that mean several things")[1].split("\n## ")[0]
    words = re.findall(r"^\| ([^|]+) \|", table, re.MULTILINE)[1:]
    assert words == ["law", "hold", "K, spring", "load", "rate"]


def test_the_files_that_run_are_named() -> None:
    """master.solve lists the files of master in which a function runs for the README's scene, in the order in which
    they begin, and no others."""
    room, ran = Path(master.__file__).parent, dict[str, None]()

    def note(frame: FrameType, event: str, _: object) -> None:
        path = Path(frame.f_code.co_filename)
        if event == "call" and frame.f_code.co_name != "<module>" and room in path.parents:
            ran.setdefault(".".join(path.relative_to(room).with_suffix("").parts))

    start = origins.gaussian_start(0.0, 0.025)
    contacts = origins.Contacts(origins.gaussian(1.0, 0.05), start)
    sys.setprofile(note)
    try:
        master.solve(contacts, np.linspace(0.0, 5.0, 501))
    finally:
        sys.setprofile(None)
    told = re.search(r"in which they begin, are (.*?);", master.solve.__doc__ or "", re.DOTALL)
    assert told is not None and re.findall(r"`([\w.]+)`", told[1]) == list(ran)
