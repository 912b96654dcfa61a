"""What ranks say to each other: calls and bytes of one rank, by the number of ranks and of contacts."""

import pickle
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import toolkit
from toolkit.running.runner import make_ensemble

TABLES: dict[str, Any] = {
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}},
    "drive": {"to": 5.0, "points": 51},
}


class Arrived:
    def Test(self) -> bool:
        return True


class Counted:
    """Rank 0 among `size` that did all the same: counts its calls, and the bytes it gives or gets in each."""

    def __init__(self, size: int) -> None:
        self.size, self.calls, self.bytes = size, Counter[str](), Counter[str]()
        self.reduced = list[int]()

    def Get_rank(self) -> int:
        return 0

    def Get_size(self) -> int:
        return self.size

    def _count(self, name: str, many: int) -> None:
        self.calls[name] += 1
        self.bytes[name] += many

    def Iprobe(self, tag: int) -> bool:
        """Whether another rank was told to stop: no message leaves this rank."""
        return False

    def Ibarrier(self) -> Arrived:
        self._count("Ibarrier", 0)
        return Arrived()

    def Allreduce(self, own: Any, out: Any) -> None:
        self._count("Allreduce", own.nbytes)
        self.reduced.append(own.nbytes)
        out[:] = own * self.size

    def allgather(self, own: Any) -> list[Any]:
        self._count("allgather", len(pickle.dumps(own)) * self.size)
        return [own] * self.size

    def bcast(self, own: Any, root: int) -> Any:
        self._count("bcast", len(pickle.dumps(own)))
        return own


def count(ranks: int, contacts: int, folder: Path, **eq: Any) -> Counted:
    comm = Counted(ranks)
    toolkit.run(TABLES | {"eq": {"contacts": contacts, "replicas": 1, **eq}}, comm=comm, folder=folder)
    return comm


@pytest.mark.parametrize("ranks", [2, 100, 10_000])
def test_calls_and_bytes_are_as_documented(ranks: int, tmp_path: Path) -> None:
    scene = toolkit.load_scene(TABLES | {"eq": {}})
    assert scene.eq is not None
    sums = make_ensemble(scene, scene.eq, None).state.sums
    few, many = (count(ranks, each * ranks << 14, tmp_path) for each in (1, 10))
    for told in (few, many):
        assert told.calls == {"Ibarrier": 5, "bcast": 3, "Allreduce": 1, "allgather": 2}
        assert told.bytes["Allreduce"] == sums.nbytes == 16 * sums.shape[1]
        assert told.bytes["bcast"] < 200 and told.bytes["allgather"] < 500 * ranks
    # ten times the contacts: the same
    assert few.bytes["Allreduce"] == many.bytes["Allreduce"]
    assert abs(few.bytes["allgather"] - many.bytes["allgather"]) <= 8 * ranks


def test_a_tolerance_takes_a_meeting_for_each_doubling(tmp_path: Path) -> None:
    told = count(2, 1 << 20, tmp_path, tolerance=1e-9)
    rounds = 1 + int(np.log2((1 << 20) / 16_384))
    assert told.calls == {"Ibarrier": 4 + rounds, "bcast": 3, "Allreduce": 1 + rounds, "allgather": 2 + 3 * rounds}
