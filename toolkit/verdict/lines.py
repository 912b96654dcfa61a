"""Lines of what a verdict hangs on, each with how much it may change the answer, by which they are sorted."""

from collections.abc import Iterable
from dataclasses import dataclass

# what turns the answer or leaves it open; what changes the forces nobody knows how much, which is taken for half of
# them; what is said of all verdicts alike; what changes nothing
TURNS, UNSIZED, GENERAL, NOTHING = float("inf"), 0.5, 0.0, -1.0


@dataclass(frozen=True)
class Line:
    """A sentence, and by how much what it names changes the forces that are told, relative to these."""

    change: float
    text: str


def sorted_texts(lines: Iterable[Line]) -> list[str]:
    """The sentences, that which changes the answer most first; those alike in their order."""
    return [line.text for line in sorted(lines, key=lambda line: -line.change)]


def by_reason(reasons: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Names by the reason that they share, each once."""
    groups = dict[str, list[str]]()
    for why, name in reasons:
        if name not in groups.setdefault(why, []):
            groups[why].append(name)
    return groups
