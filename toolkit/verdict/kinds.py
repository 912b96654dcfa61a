"""Which readings and slip rules say something else than the scene's own, and which say nothing."""

from collections.abc import Sequence

from toolkit.verdict.answers import Answer, Verdict

# how the slip rules are named where a user reads of them
NAMED = {
    "reset": "a slip renews all contacts",
    "reform-after": "contacts re-form after the slip",
    "instant": "contacts re-form at once",
    "mass": "mass, damping and delay decide",
}


def named(rules: Sequence[str]) -> str:
    return " or ".join(NAMED[rule] for rule in rules)


def others(verdict: Verdict) -> dict[str, list[str]]:
    """The readings that say something else than the scene's own under any rule, by what they say."""
    own = {behaviour.rule: behaviour.kind for behaviour in verdict.own.behaviours}
    differ: dict[str, list[str]] = {}
    for answer in verdict.answers[1:]:
        for one in answer.behaviours:
            if one.kind not in ("undecided", own.get(one.rule, one.kind)):
                names = differ.setdefault(one.kind, [])
                names += [answer.name] if answer.name not in names else []
    return differ


def not_decided(verdict: Verdict) -> list[Answer]:
    """The other readings of which nothing is known under any rule that the scene's own reading is decided under."""
    known = {one.rule for one in verdict.own.behaviours if one.kind != "undecided"}
    if not known:
        return []
    return [
        answer
        for answer in verdict.answers[1:]
        if all(one.kind == "undecided" for one in answer.behaviours if one.rule in known)
    ]


def out_of_time(answer: Answer) -> bool:
    """Whether it is for want of time alone that a reading is not decided."""
    return all("wall_time" in one.message for one in answer.behaviours if one.kind == "undecided")


def delay_decides(verdict: Verdict) -> bool:
    """Whether a slider with mass is known to do something else with the other extreme of the contacts' delay."""
    kinds = {one.kind for one in verdict.own.behaviours}
    other = verdict.turned
    return other is not None and "undecided" not in kinds | {other.kind} and other.kind not in kinds
