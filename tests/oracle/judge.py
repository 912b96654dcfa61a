"""Writes answers to the cases, and judges one set of answers by another.

Run it with this folder's parent on the path, beside the tree that is to answer:

    PYTHONPATH=.:tests python -m oracle.judge write FILE.npz [seed] [count] [kind ...]
    PYTHONPATH=.:tests python -m oracle.judge compare OLD.npz NEW.npz
    PYTHONPATH=.:tests python -m oracle.judge check OLD.npz [kind ...]

`write` keeps answers and times of the tree that runs it, `compare` tells how two sets agree and
how long they took, by kind, and `check` does both: it answers the cases of OLD.npz and compares.
For the answers of another commit make a `git worktree` of it, and run `write` there with the
`tests` of this tree on the path: PYTHONPATH=.:THIS/tests. Exit status 1 where any case is FALSE.

A case is FALSE where both answers succeed and differ by more than twice the sum of their claims
and 1e-12, or one is finite where the other is not, or their shapes differ, or the new claim is no
number where the old one is. It is short where the old answer succeeded and the new one has
success=False, is refused, fails or takes longer than 60 s; it is gained where that is the other way
round. Times are the best of three after a warm-up, of answers that take longer than 1 s the first
alone; below 2 ms they count as 2 ms. For times write both files one right after the other on one
machine.
"""

from __future__ import annotations

import signal
import sys
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oracle.case import Array, Case
from oracle.cases import all_cases

LONGEST = 60  # s: what takes longer is no answer to somebody who waits for it
UNREACHED = "success=False"
TOO_LATE = f"takes longer than {LONGEST} s"
SHORT_RUN = 1.0  # s: answers up to here are timed four times, of which the first warms up
LEAST_TIME = 2e-3  # s: below, times say more of the machine than of the method
ROUND_OFF = 1e-12  # of values of order 1, between two codes that add in another order
SHORT_TIME_RATIO = 10.0  # that a case counts with which is short, as if it were so much slower


@dataclass(frozen=True)
class Given:
    """What a case gave: values and claims of one shape, or `reason` why there are none."""

    kind: str
    values: Array
    claims: Array
    success: bool
    reason: str
    seconds: float


@dataclass(frozen=True)
class Verdict:
    """One case judged: "agree", "FALSE", "short", "gained" or "neither", and why."""

    name: str
    kind: str
    word: str
    why: str
    time_ratio: float


class TooLateError(Exception):
    """Raised in an answer that takes too long."""


def give(case: Case, runs: int = 1, longest: int | None = None) -> Given:
    """Answer the case, `runs` times for its time, each at most `longest` seconds; never raises."""
    seconds = np.inf
    try:
        with warnings.catch_warnings(), _at_most(longest):
            warnings.simplefilter("ignore")
            for run in range(runs):
                begin = time.perf_counter()
                answer = case.answer()
                took = time.perf_counter() - begin
                # the first run may have compiled and imported what it needed
                seconds = took if run <= 1 else min(seconds, took)
                if took > SHORT_RUN:
                    break
        if not answer.success:
            return Given(case.kind, np.empty(0), np.empty(0), False, UNREACHED, seconds)
        values = np.atleast_1d(np.asarray(answer.values, float)).ravel()
        claims = np.broadcast_to(np.asarray(answer.claims, float), values.shape)
        return Given(case.kind, values, claims, True, "", seconds)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"[:100]
        reason = TOO_LATE if isinstance(error, TooLateError) else reason
        return Given(case.kind, np.empty(0), np.empty(0), False, reason, np.inf)


@contextmanager
def _at_most(seconds: int | None) -> Iterator[None]:
    if seconds is None:
        yield
        return

    def stop(*_: object) -> None:
        raise TooLateError

    signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)


# Cases whose thresholds are another smooth law through the same samples than when answers were kept.
OTHER_LAWS = {
    "scene samples",
    "scene rotated-domains",
    "extreme: a far sample",
    "hard law soft: samples",
    "hard law steady: samples",
}


def judge(name: str, old: Given, new: Given) -> Verdict:
    """How a new answer does beside an old one."""
    ratio = max(new.seconds, LEAST_TIME) / max(old.seconds, LEAST_TIME) if old.success else np.nan
    if not old.success:
        word, why = ("gained" if new.success else "neither"), old.reason
    elif not new.success:
        word, why, ratio = "short", new.reason, SHORT_TIME_RATIO
    else:
        why = _difference(old, new)
        word = "FALSE" if why else "agree"
    return Verdict(name, old.kind, word, why, ratio)


def _difference(old: Given, new: Given) -> str:
    """In words why both answers cannot be right; empty where they can."""
    if old.values.shape != new.values.shape:
        return f"{new.values.size} numbers where there were {old.values.size}"
    finite = np.isfinite(old.values)
    if (finite != np.isfinite(new.values)).any():
        return "one is finite where the other is not"
    if (finite & np.isfinite(old.claims) & ~np.isfinite(new.claims)).any():
        return "claims an error that is no number"
    apart = np.abs(old.values[finite] - new.values[finite])
    claimed = [np.nan_to_num(given.claims[finite], posinf=0.0) for given in (old, new)]
    allowed = 2.0 * (claimed[0] + claimed[1]) + ROUND_OFF
    if not (apart > allowed).any():
        return ""
    worst = int(np.argmax(apart / allowed))
    return f"apart by {apart[worst]:.2e} where {allowed[worst]:.2e} is allowed"


def answer_all(cases: Sequence[Case], kinds: Sequence[str] = ()) -> dict[str, Given]:
    """Answers and times of the tree that runs this, by name; prints one line for each."""
    answers = {}
    for case in cases:
        if kinds and case.kind not in kinds:
            continue
        given = answers[case.name] = give(case, runs=4, longest=LONGEST)
        told = "ok" if given.success else given.reason
        print(f"{given.seconds:8.3f} s  {case.kind:16s} {case.name}  {told}", flush=True)
    return answers


def save(file: str | Path, answers: Mapping[str, Given], seed: int, count: int) -> None:
    """Write answers to a compressed file of a few long arrays, without those that came too late."""
    kept = {name: given for name, given in answers.items() if given.reason != TOO_LATE}
    given = list(kept.values())
    # claims are mostly one number for all values, which is then written once
    claims = [
        one.claims[:1]
        if np.array_equal(one.claims, np.resize(one.claims[:1], one.claims.shape))
        else one.claims
        for one in given
    ]
    np.savez_compressed(
        file,
        seed=np.array(seed),
        count=np.array(count),
        names=np.array(list(kept)),
        kinds=np.array([one.kind for one in given]),
        sizes=np.array([one.values.size for one in given]),
        values=np.concatenate([one.values for one in given]),
        claim_sizes=np.array([claim.size for claim in claims]),
        claims=np.concatenate(claims),
        success=np.array([one.success for one in given]),
        reasons=np.array([one.reason.encode("ascii", "replace") for one in given]),
        seconds=np.array([one.seconds for one in given]).astype(np.float32),
    )


@dataclass(frozen=True)
class Kept:
    """A file of answers: by name, and the seed and count of the random cases among them."""

    answers: dict[str, Given]
    seed: int
    count: int


def load(file: str | Path) -> Kept:
    """Read what `save` wrote, but for OTHER_LAWS."""
    with np.load(file) as arrays:
        rows = {name: arrays[name] for name in arrays.files}
    values = np.split(rows["values"], np.cumsum(rows["sizes"])[:-1])
    claims = np.split(rows["claims"], np.cumsum(rows["claim_sizes"])[:-1])
    answers = {
        str(name): Given(
            str(rows["kinds"][k]),
            values[k],
            np.broadcast_to(claims[k], values[k].shape),
            bool(rows["success"][k]),
            bytes(rows["reasons"][k]).decode("ascii"),
            float(rows["seconds"][k]),
        )
        for k, name in enumerate(rows["names"])
        if str(name) not in OTHER_LAWS
    }
    return Kept(answers, int(rows["seed"]), int(rows["count"]))


def report(old: Mapping[str, Given], new: Mapping[str, Given]) -> int:
    """Print each case that is FALSE or short, and a line for each kind; how many are FALSE."""
    verdicts = [judge(name, old[name], new[name]) for name in old if name in new]
    for verdict in verdicts:
        if verdict.word in ("FALSE", "short"):
            print(f"{verdict.word:6s} {verdict.name}: {verdict.why}")
    words = ("agree", "short", "FALSE", "gained")
    for kind in dict.fromkeys(verdict.kind for verdict in verdicts):
        own = [verdict for verdict in verdicts if verdict.kind == kind]
        counts = [sum(verdict.word == word for verdict in own) for word in words]
        ratios = [verdict.time_ratio for verdict in own if not np.isnan(verdict.time_ratio)]
        told = " ".join(f"{n:4d} {word}" for n, word in zip(counts, words, strict=True))
        times = f"time {np.median(ratios):5.2f} median {max(ratios):6.2f} worst" if ratios else ""
        print(f"{kind:16s} {len(own):4d} cases {told}  {times}")
    counts = [sum(verdict.word == word for verdict in verdicts) for word in words]
    totals = ", ".join(f"{n} {word}" for n, word in zip(counts, words, strict=True))
    print(f"all: {len(verdicts)} cases, {totals}; {len(set(old) ^ set(new))} in one file alone")
    return counts[words.index("FALSE")]


def main(words: Sequence[str]) -> int:
    """Do what the command line says; the exit status."""
    verb, file, *rest = words
    numbers = [int(word) for word in rest if word.isdigit()]
    if verb == "compare":
        return int(report(load(file).answers, load(rest[0]).answers) > 0)
    if verb == "write":
        seed, count = [*numbers, 1, 1][:2] if len(numbers) != 1 else (numbers[0], 1)
        kinds = [word for word in rest if not word.isdigit()]
        save(file, answer_all(all_cases(seed, count), kinds), seed, count)
        return 0
    if verb != "check":
        raise SystemExit(f"{verb}: must be write, compare or check")
    old = load(file)
    asked = {name: one for name, one in old.answers.items() if not rest or one.kind in rest}
    cases = [case for case in all_cases(old.seed, old.count) if case.name in asked]
    return int(report(asked, answer_all(cases)) > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
