"""The lint of master's shape sees what it is to see."""

import ast

import pytest
from shape import ALL_LINES, ALLOWED, CONSTANTS, CONSTANTS_TODAY, FILES, LINES, LINES_TODAY, faults

MOST = max(CONSTANTS, CONSTANTS_TODAY)
MOST_LINES = max(ALL_LINES, LINES_TODAY)
SOUND = {"master/a.py": "import master.b\nA = 1\n", "master/b.py": "B = 2\n"}


def found(texts: dict[str, str]) -> list[str]:
    """The faults of these files, beside those that are listed as longer."""
    listed = dict.fromkeys(ALLOWED, "\n" * (LINES + 1))
    return list(faults({file: (text, ast.parse(text)) for file, text in (listed | texts).items()}))


def test_sound_files_have_no_faults() -> None:
    assert found(SOUND) == []


@pytest.mark.parametrize(
    ("planted", "told"),
    [
        ({"master/b.py": "\n" * (LINES + 1)}, f"master/b.py: {LINES + 1} lines, at most {LINES}"),
        ({f"master/c{k}.py": "" for k in range(FILES)}, f"master: {FILES + 2} files, at most "),
        (
            {"master/b.py": "if TYPE_CHECKING:\n    from master.a import A\n"},
            "import one another: master.a, master.b",
        ),
        (
            {
                "master/__init__.py": "from master.a import A\n",
                "master/b.py": "from master import A\n",
            },
            "import one another: master, master.a, master.b",
        ),
        (
            {"master/b.py": "; ".join(f"B{k}: int = 1" for k in range(MOST))},
            f"{MOST + 1} constants, at most {MOST}",
        ),
        (
            {f"master/{k // 10}/c{k}.py": "\n" * LINES for k in range(MOST_LINES // LINES + 1)},
            f"{(MOST_LINES // LINES + 1) * LINES + 3} lines, at most {MOST_LINES}",
        ),
    ],
)
def test_a_planted_fault_is_seen(planted: dict[str, str], told: str) -> None:
    (fault,) = found(SOUND | planted)
    assert fault.startswith(told)


def test_a_file_that_has_shrunk_goes_from_the_list() -> None:
    for file in ALLOWED:
        (fault,) = found(SOUND | {file: ""})
        assert "take it from the list" in fault
