"""The random streams against the published vectors of Random123, and their independence."""

import pytest

from origins import InputError
from origins.streams import START, THRESHOLDS, key_of, philox, words

KNOWN_ANSWERS = [
    (
        "00000000 00000000 00000000 00000000",
        "00000000 00000000",
        "6627e8d5 e169c58d bc57ac4c 9b00dbd8",
    ),
    (
        "ffffffff ffffffff ffffffff ffffffff",
        "ffffffff ffffffff",
        "408f276d 41c83b0e a20bc7c6 6d5451fd",
    ),
    (
        "243f6a88 85a308d3 13198a2e 03707344",
        "a4093822 299f31d0",
        "d16cfe09 94fdcceb 5001e420 24126ea1",
    ),
]


def _hex(text: str) -> list[int]:
    return [int(word, 16) for word in text.split()]


@pytest.mark.parametrize("counter, key, answer", KNOWN_ANSWERS)
def test_known_answers(counter: str, key: str, answer: str) -> None:
    first, second = _hex(key)
    assert philox(_hex(counter), (first, second)).tolist() == _hex(answer)


def test_every_part_of_the_address_changes_the_words() -> None:
    base = (key_of(1), THRESHOLDS, 0, 0, 0)
    others = [
        (key_of(1 << 32), THRESHOLDS, 0, 0, 0),
        (key_of(1), START, 0, 0, 0),
        (key_of(1), THRESHOLDS, 1, 0, 0),
        (key_of(1), THRESHOLDS, 0, 1, 0),
        (key_of(1), THRESHOLDS, 0, 1 << 32, 0),
        (key_of(1), THRESHOLDS, 0, 0, 1),
    ]
    seen = {tuple(words(*address).tolist()) for address in [base, *others]}  # type: ignore[arg-type]
    assert len(seen) == 7


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, True, None])
def test_bad_seeds_are_refused_by_name(seed: object) -> None:
    with pytest.raises(InputError, match="seed"):
        key_of(seed)
