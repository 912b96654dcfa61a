"""The lint of the rooms' shape sees what it is to see."""

import ast

import pytest
from shape import FILES, LINES, Room, faults

LIMITS = Room(lines=600, lines_today=1200, constants=2, constants_today=4)
SOUND = {"master/a.py": "import master.b\nA = 1\n", "master/b.py": "B = 2\n"}


def found(texts: dict[str, str]) -> list[str]:
    """The faults of these files."""
    return list(faults({file: (text, ast.parse(text)) for file, text in texts.items()}, LIMITS))


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
        ({"master/b.py": "B = C = 1\nD: int = 1; E, F = 1, 2"}, "6 constants, at most 4"),
        ({f"master/c{k}.py": "\n" * LINES for k in range(4)}, "1203 lines, at most 1200"),
    ],
)
def test_a_planted_fault_is_seen(planted: dict[str, str], told: str) -> None:
    (fault,) = found(SOUND | planted)
    assert fault.startswith(told)
