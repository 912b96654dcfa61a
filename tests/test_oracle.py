"""Calls of master beside the answers from before it was rebuilt (tests/oracle)."""

from dataclasses import replace

import numpy as np
import pytest
from oracle.judge import Given, give, judge, load

KEPT = load()
FAST = 0.1  # s that a kept answer took: the calls asked by `make test` are of these
PER_KIND = 3
KINDS = sorted({given.kind for given in KEPT.values()})
QUICK = sorted({given.kind for given in KEPT.values() if given.seconds < FAST})
GIVEN_UP = {"hard law forward: arcsine"}  # rows of docs/given-up.md: may be short, never FALSE


def fast(kind: str) -> list[str]:
    """A few quick calls of a kind, spread evenly over it."""
    own = {name: one for name, one in KEPT.items() if one.kind == kind and one.success}
    quick = [name for name, one in own.items() if one.seconds < FAST]
    return quick[:: -(-len(quick) // PER_KIND)]


def disagreements(names: list[str]) -> list[str]:
    """One line for each call that is FALSE, or short without being given up."""
    told = [(name, *judge(KEPT[name], give("", KEPT[name].call))) for name in names]
    return [
        f"{word} {name}: {why}"
        for name, word, why in told
        if word == "FALSE" or (word == "short" and name not in GIVEN_UP)
    ]


@pytest.mark.parametrize(
    ("values", "claims", "word"),
    [
        ([1.0, 2.0 + 3.9e-6], [1e-6, 1e-6], "agree"),
        ([1.0, 2.0 + 4.1e-6], [1e-6, 1e-6], "FALSE"),
        ([1.0, 2.0 + 4.1e-6], [1e-6, 2e-6], "agree"),
        ([1.0, np.inf], [1e-6, 1e-6], "FALSE"),
        ([1.0, 2.0], [1e-6, np.nan], "FALSE"),
        ([1.0], [1e-6], "FALSE"),
    ],
)
def test_the_judge_tells_false_from_true(values: list, claims: list, word: str) -> None:
    old = Given("kind", "", np.array([1.0, 2.0]), np.array([1e-6, 1e-6]), True, "", 1.0)
    new = replace(old, values=np.array(values), claims=np.array(claims))
    assert judge(old, new)[0] == word
    assert judge(old, replace(new, success=False))[0] == "short"
    assert judge(replace(old, success=False), new)[0] == "gained"


@pytest.mark.parametrize("kind", QUICK)
def test_some_answers_agree(kind: str) -> None:
    assert disagreements(fast(kind)) == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_all_answers_agree(kind: str) -> None:
    assert disagreements([name for name, given in KEPT.items() if given.kind == kind]) == []
