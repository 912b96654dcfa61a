"""All cases of the oracle, each with a name of its own."""

from __future__ import annotations

from collections import Counter

from oracle.case import Case
from oracle.corners import corner_cases
from oracle.families import random_cases
from oracle.functions import function_cases
from oracle.path_table import path_table_cases
from oracle.read_out import read_out_cases
from oracle.scenes import scene_cases
from oracle.warm_families import random_law_cases


def all_cases(seed: int = 1, count: int = 1) -> list[Case]:
    """Every case: `count` draws of the families with random numbers, and those that are fixed."""
    cases = [
        *random_cases(seed, count),
        *random_law_cases(seed, count),
        *path_table_cases(),
        *scene_cases(),
        *function_cases(),
        *read_out_cases(),
        *corner_cases(),
    ]
    twice = [name for name, times in Counter(case.name for case in cases).items() if times > 1]
    if twice:
        raise ValueError(f"names of cases: {twice} are given twice")
    return cases
