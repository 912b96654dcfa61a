"""Judges answers to the oracle's calls by those that are kept.

FALSE: both answers succeed and differ by more than twice the sum of their claims and 1e-12, or one is finite where the
other is not, or their shapes differ, or the new claim is no number where the old one is. Short: the old answer
succeeded, and the new one has success=False, is refused, fails or takes longer than 60 s; gained: the other way round.
"""

from __future__ import annotations

import signal
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oracle.calls import Array, evaluated

ANSWERS = Path(__file__).with_name("answers.npz")
LONGEST = 60  # s: what takes longer is no answer to somebody who waits for it
ROUND_OFF = 1e-12  # of values of order 1, between two codes that add in another order


@dataclass(frozen=True)
class Given:
    """An answer to a call: values and claims of one shape, or `reason` why there are none."""

    kind: str
    call: str
    values: Array
    claims: Array
    success: bool
    reason: str
    seconds: float


def load(file: str | Path = ANSWERS) -> dict[str, Given]:
    """The kept answers by name."""
    with np.load(file) as arrays:
        rows = {name: arrays[name] for name in arrays.files}
    values = np.split(rows["values"], np.cumsum(rows["sizes"])[:-1])
    claims = np.split(rows["claims"], np.cumsum(rows["claim_sizes"])[:-1])
    return {
        str(name): Given(
            str(rows["kinds"][k]),
            str(call),
            values[k],
            np.broadcast_to(claims[k], values[k].shape),
            bool(rows["success"][k]),
            bytes(rows["reasons"][k]).decode("ascii"),
            float(rows["seconds"][k]),
        )
        for k, (name, call) in enumerate(
            zip(rows["names"], str(rows["calls"]).split("\n"), strict=True)
        )
    }


def give(kind: str, call: str) -> Given:
    """Answer a call; never raises. Stops after LONGEST."""

    def stop(*_: object) -> None:
        raise TimeoutError(f"takes longer than {LONGEST} s")

    before = signal.signal(signal.SIGALRM, stop)
    own, begin = signal.alarm(LONGEST), time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = evaluated(call)
        reason = "" if found.success else "success=False"
        values = np.atleast_1d(np.asarray(found.values, float)).ravel()
        claims = np.broadcast_to(np.asarray(found.claims, float), values.shape)
    except Exception as error:
        reason, values, claims = f"{type(error).__name__}: {error}"[:100], np.empty(0), np.empty(0)
    finally:
        signal.signal(signal.SIGALRM, before)
        signal.alarm(own)
    return Given(kind, call, values, claims, not reason, reason, time.perf_counter() - begin)


def judge(old: Given, new: Given) -> tuple[str, str]:
    """One of agree, short, FALSE, gained and neither, and why."""
    if not (old.success and new.success):
        word = "short" if old.success else "gained" if new.success else "neither"
        return word, new.reason
    why = difference(old, new)
    return ("FALSE", why) if why else ("agree", "")


def difference(old: Given, new: Given) -> str:
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
