"""The nearest of many positions, which change one at a time: a tree of minima, eight below each."""

from typing import NamedTuple

import numpy as np

from eq_model.blocks import Whole
from eq_model.compiling import bare, inlined, unsigned

FAR = 1 << 62  # of a contact that does not hold; beyond all positions


class Nearest(NamedTuple):
    """The positions of n contacts, and above them the least of every eight, up to the least of all."""

    places: Whole  # of all levels, one behind the other
    begins: Whole  # where each level begins
    levels: np.int64


def make_nearest(n: int) -> Nearest:
    """The tree for n contacts, none of which holds."""
    sizes = [-(-n // 8) * 8]
    while sizes[-1] > 1:
        groups = sizes[-1] // 8
        sizes.append(1 if groups == 1 else -(-groups // 8) * 8)
    begins = np.cumsum([0, *sizes[:-1]])
    return Nearest(np.full(sum(sizes), FAR), begins, np.int64(len(sizes) - 1))


@inlined
def least(tree):  # type: ignore[no-untyped-def]
    """The least position of all."""
    return tree.places[unsigned(tree.begins[unsigned(tree.levels)])]


@bare
def set_place(tree, contact, place):  # type: ignore[no-untyped-def]
    """Give a contact its new position."""
    p, i = tree.places, unsigned(contact)
    p[i] = place
    begin = unsigned(0)
    for level in range(unsigned(tree.levels)):
        i >>= unsigned(3)
        j = begin + (i << unsigned(3))
        a = min(p[j], p[j + unsigned(1)])
        b = min(p[j + unsigned(2)], p[j + unsigned(3)])
        c = min(p[j + unsigned(4)], p[j + unsigned(5)])
        d = min(p[j + unsigned(6)], p[j + unsigned(7)])
        found = min(min(a, b), min(c, d))
        begin = unsigned(tree.begins[level + unsigned(1)])
        if p[begin + i] == found:
            return
        p[begin + i] = found


@bare
def who_is_least(tree):  # type: ignore[no-untyped-def]
    """The contact with the least position; of several the first."""
    found, i = least(tree), unsigned(0)
    for down in range(unsigned(1), unsigned(tree.levels) + unsigned(1)):
        begin = unsigned(tree.begins[unsigned(tree.levels) - down])
        i <<= unsigned(3)
        while tree.places[begin + i] != found:
            i += unsigned(1)
    return np.int64(i)
