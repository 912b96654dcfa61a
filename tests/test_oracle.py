"""Calls of master beside the answers from before it was rebuilt (tests/oracle)."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import slow
from oracle.calls import VERDICTS
from oracle.judge import give, judge, load
from oracle.write import write

# the older version was wrong: contacts of the start counted as fresh; test_decoherence.py has the right terms
WRONG_BEFORE = "spectrum grains"
ALL = load()
FAST = 0.1  # s that a kept answer took: the calls asked by `make test` are of these
PER_KIND = 2
# hard laws (docs/limits.md): may be short, never FALSE
HARD = {
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
# the older version left it undecided after two slips; the first leaves all contacts as at the start, and decides, as a
# longer path with slips that are all alike confirms (test_soft_laws.py)
DECIDED = "slips reform-after, delay"
KEPT[DECIDED] = replace(KEPT[DECIDED], values=KEPT[DECIDED].values.copy())
KEPT[DECIDED].values[-2] = VERDICTS.index("stick-slip")
KINDS = sorted({given.kind for given in KEPT.values()})
QUICK = sorted({given.kind for given in KEPT.values() if given.seconds < FAST})


def fast(kind: str) -> list[str]:
    """A few quick calls of a kind, spread evenly over it."""
    own = {name: one for name, one in KEPT.items() if one.kind == kind and one.success}
    quick = [name for name, one in own.items() if one.seconds < FAST]
    return quick[:: -(-len(quick) // PER_KIND)]


def disagreements(names: list[str]) -> list[str]:
    """One line for each call that is FALSE, or short without being hard; time alone fails none."""
    told = [(name, *judge(KEPT[name], give("", KEPT[name].call))) for name in names]
    return [
        f"{word} {name}: {why}"
        for name, word, why in told
        if word == "FALSE" or (word == "short" and name not in HARD and "TimeoutError" not in why)
    ]


@pytest.mark.parametrize("kind", [slow(kind, when=kind == "hard laws") for kind in QUICK])
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


def test_answers_are_written_as_they_are_read(tmp_path: Path) -> None:
    """Of two calls."""
    names = fast(QUICK[0])[:2]
    write({name: ALL[name] for name in names}, tmp_path / "kept.npz")
    for name, again in load(tmp_path / "kept.npz").items():
        for field in ("kind", "call", "success", "reason", "seconds"):
            assert getattr(again, field) == getattr(ALL[name], field)
        for field in ("values", "claims"):
            np.testing.assert_array_equal(getattr(again, field), getattr(ALL[name], field))


@pytest.mark.slow  # quick: what the script writes, above, and its answers, by the same calls
def test_the_script_that_makes_answers_anew_finds_the_same(tmp_path: Path) -> None:
    names = fast(QUICK[0])[:2]
    write({name: ALL[name] for name in names}, tmp_path / "kept.npz")
    script = Path(__file__).parent / "oracle" / "write.py"
    words = [str(script.parents[2]), "kept.npz", "new.npz"]
    done = subprocess.run([sys.executable, script, *words], cwd=tmp_path, check=False)
    assert done.returncode == 0
    new = load(tmp_path / "new.npz")
    assert list(new) == names
    assert [judge(ALL[name], new[name])[0] for name in names] == ["agree"] * len(names)
