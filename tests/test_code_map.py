"""docs/code-map.md names the one place of each equation, as the docstrings say."""

from collections import Counter

from code_map import LABELS, NOWHERE, PAGE, SEVERAL, page, places


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
