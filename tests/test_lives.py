"""Paths in time: turns, holds and velocity steps of contacts with laws of their own."""

from itertools import pairwise

import numpy as np
import pytest
from moving_contacts import move

import master
from master.make_lives import make_lives
from master.marching import march
from master.timed import at
from master.timeline import marks, parts, pieces, times
from origins import Contacts, Delay, Drive, Thermal, gaussian, gaussian_start

Array = np.ndarray
WIDE = gaussian(1.0, 0.2)
SOFT, STIFF = Thermal("soft", 0.1), Thermal("stiff", 0.1)
# forward, a hold, a faster step, back slowly, a short hold, back further, forward again
CORNERS = [(0.0, 0.0), (1.3, 1.5), (1.3, 8.0), (2.0, 8.5), (0.2, 11.0), (0.2, 11.5), (-1.0, 14.0), (0.5, 15.0)]


def along(corners: list[tuple[float, float]], points: int = 6) -> tuple[Array, Array]:
    """Path and times through corners (X, t), `points` to each piece."""
    legs = [np.linspace(a, b, points)[1:] for a, b in pairwise(np.array(corners))]
    return tuple(np.concatenate([[corners[0]], *legs]).T)


def test_turns_and_holds_are_those_of_discrete_contacts() -> None:
    path, time = along(CORNERS)
    contacts = Contacts(WIDE, 0.1, thermal=Thermal("soft", 0.2), delay=Delay(0.3))
    solved = master.solve(contacts, path, 1e-4, time=time)
    assert solved.success, solved.message
    count = 20_000
    force, error, holding = move(contacts, path, time, count)
    assert (np.abs(solved.force - force) < 5.0 * error + solved.force_error).all()
    spread = np.sqrt(np.maximum(holding * (1.0 - holding), 1.0 / count) / count)
    assert (np.abs(solved.holding - holding) < 5.0 * spread + 1e-4).all()


@pytest.mark.parametrize(
    "contacts",
    [
        Contacts(WIDE, gaussian_start(0.1, 0.05), thermal=SOFT),
        Contacts(WIDE, -0.3, thermal=Thermal("stiff", 0.1, closure="paper"), delay=Delay(0.3)),
    ],
)
def test_second_order_in_the_step(contacts: Contacts) -> None:
    """Against the renewal equation, on forward motion."""
    path = np.linspace(0.0, 2.0, 21)[1:]
    exact = master.solve(contacts, path, 1e-9).force
    drive, delay = Drive(path), 0.0 if contacts.delay is None else contacts.delay.time
    course = pieces(drive)
    coarse = parts(course, marks(course, [-0.3], 0.0, np.empty(0), delay), 0.1, 1.0, 1.0, 2.0)
    off = []
    for level in range(3):
        finer = [part.finer(level) for part in coarse]
        found = march(make_lives(contacts, level), finer, delay)
        off.append(np.abs(at(found, finer, "force", times(drive)) - exact).max())
    assert np.abs(np.log2(np.array(off[:-1]) / off[1:]) - 2.0).max() < 0.2
