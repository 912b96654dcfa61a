"""Calls of master beside the answers from before it was rebuilt (tests/oracle)."""

import pytest
from oracle.judge import give, judge, load

# the older version was wrong: contacts of the start counted as fresh; test_decoherence.py has the right terms
WRONG_BEFORE = "spectrum grains"
ALL = load()
FAST = 0.1  # s that a kept answer took: the calls asked by `make test` are of these
PER_KIND = 3
# rows of docs/given-up.md: may be short, never FALSE
GIVEN_UP = {
    "hard law forward: arcsine",
    "hard law forward: beta(0.3, 0.3)",
    "hard law forward: gamma(0.5)",
    "hard law forward: lubricated, power -0.5",
}
# refused by design on a rigid slider, and answered by the ensemble (master/survival/make.py): ageing with heat or
# towards a law that is not normal; growing grains with heat on paths that turn, rest or change their speed
PATHS = ("turns:", "turns in time:", "velocity steps:", "hold:")
REFUSED = {
    *(f"heat and ageing 0 {what}" for what in ("forward", "turning", "steady")),
    *(
        f"table {what} ageing {other}"
        for what in ("steady", "forward", "propensity", *PATHS)
        for other in ("and heat", "to a law that is not Gaussian")
    ),
    *(f"table {what} grains, {law}" for what in PATHS for law in ("soft", "stiff")),
}
KEPT = {name: given for name, given in ALL.items() if name not in {WRONG_BEFORE, *REFUSED}}
KINDS = sorted({given.kind for given in KEPT.values()})
QUICK = sorted({given.kind for given in KEPT.values() if given.seconds < FAST})


def fast(kind: str) -> list[str]:
    """A few quick calls of a kind, spread evenly over it."""
    own = {name: one for name, one in KEPT.items() if one.kind == kind and one.success}
    quick = [name for name, one in own.items() if one.seconds < FAST]
    return quick[:: -(-len(quick) // PER_KIND)]


def disagreements(names: list[str]) -> list[str]:
    """One line for each call that is FALSE, or short without being given up; time alone fails none."""
    told = [(name, *judge(KEPT[name], give("", KEPT[name].call))) for name in names]
    return [
        f"{word} {name}: {why}"
        for name, word, why in told
        if word == "FALSE"
        or (word == "short" and name not in GIVEN_UP and "TimeoutError" not in why)
    ]


@pytest.mark.parametrize("kind", QUICK)
def test_some_answers_agree(kind: str) -> None:
    assert disagreements(fast(kind)) == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_all_answers_agree(kind: str) -> None:
    assert disagreements([name for name, given in KEPT.items() if given.kind == kind]) == []


def test_what_is_refused_by_design_names_the_law_at_once() -> None:
    reasons = {name: give("", ALL[name].call).reason for name in sorted(REFUSED)}
    told = ("InputError: contacts.thermal: ", "InputError: contacts.ageing: ")
    assert [name for name, reason in reasons.items() if not reason.startswith(told)] == []
