"""How many contacts are born, on any motion: number conservation, step by step.

With J(t) the births per contact since t = 0, B(t) the breaks, and E(t, s) what is left of the births at s,

    G_0(t) + integral of E(t, s) dJ(s) + [B(t) - J(t)] = 1,        J(t) = B(t - τ),

the terms being contacts that hold since t = 0, others that hold, and those that wait. Within a step births are even:
the integral is that of the trapezoid, good to the square of the step, and no law is known here but by its `Lives`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.lives import Lives
from master._old.timeline import Part

Array = npt.NDArray[np.float64]

_STENCIL = 4
_SLACK = 1e-13
_MOST_GONE = 0.5


@dataclass(frozen=True)
class March:
    """What was found at the ends of all steps, shapes (n,): times, force, what holds, births J and breaks B.

    unresolved : force (a length) of contacts of which it is not known how many hold; see `unknown`.
    """

    clock: Array
    force: Array
    holding: Array
    births: Array
    breaks: Array
    unresolved: float


def march(lives: Lives, steps: list[Part], delay: float) -> March:
    """Births, force and holding along the steps; `lives` are moved to the end of them."""
    clock = np.concatenate([[0.0], *[part.clock(np.arange(1, part.steps + 1) / part.steps) for part in steps]])
    firsts = np.concatenate([[0], np.cumsum([part.steps for part in steps])])
    n = clock.size
    force, holding, breaks, births = np.empty(n), np.empty(n), np.zeros(n), np.zeros(n)
    even = np.zeros(n)  # births of each step
    unresolved = 0.0
    lives.born()
    force[0], holding[0] = lives.pull[0], lives.held[0]
    memory = Memory(clock, firsts, delay)
    k = 0
    for part in steps:
        travel = (part.after - part.before) / part.steps
        for _ in range(part.steps):
            k += 1
            lives.advance(travel, clock[k] - clock[k - 1])
            lives.born()
            held, pull = lives.spread()
            old = slice(0, k - 1)
            known = lives.held[0] + float(held[old] @ even[1:k])
            slope, rest = memory.births(k, breaks)
            # known + held[-1] (J - J_before) + B - J = 1, J = slope B + rest
            last = float(held[k - 1])
            breaks[k] = (1.0 - known + last * births[k - 1] + (1.0 - last) * rest) / (1.0 - (1.0 - last) * slope)
            births[k] = slope * breaks[k] + rest
            even[k] = births[k] - births[k - 1]
            holding[k] = known + last * even[k]
            force[k] = lives.pull[0] + float(pull[:k] @ even[1 : k + 1])
            unresolved = max(unresolved, unknown(lives, even[1 : k + 1]))
    return March(clock, force, holding, births, breaks, unresolved)


def unknown(lives: Lives, even: Array) -> float:
    """Force (a length) of contacts, born evenly within each step, of which it is not known how many hold: most of those
    born first in the step are gone, where most of those born last are not. Relaxed ones bear nothing."""
    early, late, pull = lives.held[1:-1], lives.held[2:], lives.pull
    apart = np.where(early < _MOST_GONE * late, 0.5 * np.abs(pull[2:] - pull[1:-1]), 0.0)
    return float(apart @ np.abs(even))


class Memory:
    """J(t) = B(t - τ) read from the steps done: at step k it is slope B_k + rest."""

    def __init__(self, clock: Array, firsts: Array, delay: float) -> None:
        self._clock, self._firsts, self._delay = clock, firsts, delay
        # what is born at once a delay later is not born before
        self._slack = _SLACK * float(clock[-1] - clock[0])

    def births(self, k: int, breaks: Array) -> tuple[float, float]:
        if self._delay == 0.0:
            return 1.0, 0.0
        clock = self._clock
        at = clock[k] - self._delay - self._slack
        if at <= clock[0]:
            return 0.0, 0.0
        cell = int(np.searchsorted(clock[: k + 1], at, side="left"))
        # breaks bend where the motion changes: a stencil stays on one side
        part = int(np.searchsorted(self._firsts, cell, side="left"))
        low, high = int(self._firsts[part - 1]), min(int(self._firsts[part]), k)
        begin = min(max(cell - _STENCIL // 2, low), max(high - _STENCIL + 1, low))
        nodes = np.arange(begin, min(begin + _STENCIL - 1, high) + 1)
        # births at once are two with nothing between
        nodes = nodes[np.append(np.diff(clock[nodes]) > 0.0, True)]
        weights = lagrange(clock[nodes], at)
        if nodes[-1] == k:
            return float(weights[-1]), float(weights[:-1] @ breaks[nodes[:-1]])
        return 0.0, float(weights @ breaks[nodes])


def lagrange(nodes: Array, at: float) -> Array:
    """Weights of values at the nodes in the polynomial through them, at one point."""
    apart = nodes[:, None] - nodes
    np.fill_diagonal(apart, 1.0)
    ways = np.where(np.eye(nodes.size, dtype=bool), 1.0, at - nodes)
    return (ways / apart).prod(axis=1)
