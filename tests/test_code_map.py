"""docs/code-map.md names the one place of each equation, as the docstrings say."""

from collections import Counter

from code_map import LABELS, NOWHERE, PAGE, labels_of, page, places


def test_docstrings_name_equations_by_their_first_lines() -> None:
    assert labels_of("One (paper, Eq. Q5a; App. C)\nand (paper, Eqs. L and\nB).") == [
        "Q5a",
        "L",
        "B",
    ]
    assert labels_of("One (Q15).\n\nMore (paper, Eq. Q6).") == []


def test_each_equation_stands_in_one_place() -> None:
    claimed = Counter(label for place in places() for label in place.labels)
    several = {
        label: [place.name for place in places() if label in place.labels]
        for label, times in claimed.items()
        if times > 1
    }
    assert several == {}
    assert set(claimed) | set(NOWHERE) == set(LABELS.values())
    assert not set(claimed) & set(NOWHERE)


def test_the_page_is_what_the_docstrings_say() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run python tests/code_map.py"
