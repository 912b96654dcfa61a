"""Makes the oracle's answers anew, from any checkout of the project:

    python tests/oracle/write.py CHECKOUT KEPT.npz NEW.npz

answers the calls of KEPT.npz (`tests/oracle/answers.npz`) by the packages `master` and `origins` of that checkout, and
keeps them in NEW.npz in the same form. With a checkout of commit ee6a1b9 these are the answers that are kept here, but
for times and last digits. New calls: put them into the dict that `write` takes, a kind and a text each.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from oracle.judge import Given


def write(answers: Mapping[str, Given], file: str | Path) -> None:
    """Keep answers by name, as `oracle.judge.load` reads them; claims that are all alike as one number."""
    given = list(answers.values())
    claims = [
        one.claims[:1] if np.ptp(one.claims) == 0.0 else one.claims for one in map(_plain, given)
    ]
    rows: dict[str, Any] = {
        "names": list(answers),
        "kinds": [one.kind for one in given],
        "calls": "\n".join(one.call for one in given),
        "values": np.concatenate([one.values for one in given]),
        "sizes": [one.values.size for one in given],
        "claims": np.concatenate(claims),
        "claim_sizes": [claim.size for claim in claims],
        "success": [one.success for one in given],
        "reasons": [one.reason.encode("ascii", "replace") for one in given],
        "seconds": [one.seconds for one in given],
    }
    np.savez_compressed(file, **{name: np.asarray(row) for name, row in rows.items()})


def _plain(given: Given) -> Any:
    """The answer, with a claim where it has none, as its shape is that of the values."""
    return given if given.claims.size else type(given)(**{**vars(given), "claims": np.zeros(1)})


def main(checkout: str, kept: str, new: str) -> None:
    """Answer the kept calls by the checkout's packages. Raises SystemExit where others would answer."""
    here = Path(__file__).resolve().parents[1]
    sys.path[:0] = [str(Path(checkout).resolve()), str(here)]
    import master
    from oracle.judge import give, load

    if not Path(master.__file__).is_relative_to(Path(checkout).resolve()):
        raise SystemExit(f"master is that of {master.__file__}, not of {checkout}")
    answers = {}
    for name, old in load(kept).items():
        answers[name] = found = give(old.kind, old.call)
        print(f"{found.seconds:8.3f} s  {name}  {found.reason or 'ok'}", flush=True)
    write(answers, new)


if __name__ == "__main__":
    main(*sys.argv[1:])
