"""Answers beside those of the solvers as they were before they were rebuilt (tests/oracle)."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from oracle.case import Case
from oracle.cases import all_cases
from oracle.judge import Given, give, judge, load

KEPT = load(Path(__file__).parent / "oracle" / "answers.npz")
KINDS = sorted({given.kind for given in KEPT.answers.values()})
FAST = 0.3  # s that the kept answer took: the fast subset is of these
PER_KIND = 8  # cases in the fast subset, spread evenly over the kind


@cache
def cases() -> dict[str, Case]:
    """The cases that have a kept answer, by name."""
    return {
        case.name: case for case in all_cases(KEPT.seed, KEPT.count) if case.name in KEPT.answers
    }


def fast_subset(kind: str) -> list[str]:
    """Names of the cases of a kind that `make test` asks: quick ones, or else the quickest."""
    given = {name: one for name, one in KEPT.answers.items() if one.kind == kind and one.success}
    quick = [name for name, one in given.items() if one.seconds < FAST]
    quick = quick or [min(given, key=lambda name: given[name].seconds)]
    return quick[:: -(-len(quick) // PER_KIND)]


# Rows of docs/given-up.md: these may be short, never FALSE.
GIVEN_UP = {"hard law forward: arcsine"}


def disagreements(names: list[str]) -> list[str]:
    """One line for each case that is FALSE, or short without being given up."""
    verdicts = [judge(name, KEPT.answers[name], give(cases()[name])) for name in names]
    return [
        f"{verdict.word} {verdict.name}: {verdict.why}"
        for verdict in verdicts
        if verdict.word == "FALSE" or (verdict.word == "short" and verdict.name not in GIVEN_UP)
    ]


@pytest.mark.parametrize(
    ("values", "claims", "word"),
    [
        ([1.0, 2.0], [1e-6, 1e-6], "agree"),
        ([1.0, 2.0 + 3.9e-6], [1e-6, 1e-6], "agree"),
        ([1.0, 2.0 + 4.1e-6], [1e-6, 1e-6], "FALSE"),
        ([1.0, 2.0 + 4.1e-6], [1e-6, 2e-6], "agree"),
        ([1.0, np.inf], [1e-6, 1e-6], "FALSE"),
        ([1.0, 2.0], [1e-6, np.nan], "FALSE"),
        ([1.0], [1e-6], "FALSE"),
    ],
)
def test_the_judge_tells_false_from_true(
    values: list[float], claims: list[float], word: str
) -> None:
    old = Given("kind", np.array([1.0, 2.0]), np.array([1e-6, 1e-6]), True, "", 1.0)
    new = Given("kind", np.array(values), np.array(claims), True, "", 1.0)
    assert judge("name", old, new).word == word
    assert judge("name", old, replace(new, success=False)).word == "short"
    assert judge("name", replace(old, success=False), new).word == "gained"


def test_every_kept_answer_has_its_case() -> None:
    assert not set(KEPT.answers) - set(cases())


@pytest.mark.parametrize("kind", KINDS)
def test_some_cases_agree(kind: str) -> None:
    assert disagreements(fast_subset(kind)) == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_all_cases_agree(kind: str) -> None:
    names = [name for name, given in KEPT.answers.items() if given.kind == kind]
    assert disagreements(names) == []
