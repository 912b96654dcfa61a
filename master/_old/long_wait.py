"""The slowest decay where contacts wait for far longer than they hold: p^ turns with the wait, its size hardly changes.

With d the wait, y the rest of the travel less its mean C, and k(s) = ln <e^{-sy}>, the roots of p^(s) = 1 obey

    s (d + C) = k(s) + 2πin,                      one for each n,

which is iterated: k changes little over 1/d. As <y> = 0 nothing of k(s) ~ s² <y²>/2 is lost to rounding, small as it is
beside 1.
"""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

LONG = 30.0  # mean travels from birth to break
_TURNS = 4  # n that are tried, and about each frequency where p^ is large again
_ROUNDS = 60
_SMALL = 0.5
_TERMS = 18
_PER_TURN = 16
_MOST = 4096  # frequencies looked at
_FURTHER = 4.0
_ROUND_OFF = 1e-14


class Waves:
    """The roots where `travel`, without the wait, has the weights `mass`; `whole` is d + C."""

    def __init__(self, travel: Array, mass: Array, wait: float) -> None:
        self.mass = mass = mass / mass.sum()
        mean = float(mass @ travel)
        apart = travel - mean
        # <y> = 0 but for rounding: so be it
        self.apart = apart - float(mass @ apart)
        self.whole = wait + mean

    def log_mean(self, s: complex) -> complex:
        """k(s)."""
        z = -s * self.apart
        small = np.abs(z) < _SMALL
        beyond = np.zeros(z.shape, dtype=complex)
        factor = np.ones(int(small.sum()), dtype=complex) * z[small]
        for n in range(2, _TERMS):
            factor = factor * z[small] / n
            beyond[small] += factor
        beyond[~small] = np.exp(z[~small]) - 1.0 - z[~small]
        moved = complex((self.mass * beyond).sum())
        size = 0.5 * np.log1p(2.0 * moved.real + abs(moved) ** 2)
        return complex(size, np.arctan2(moved.imag, 1.0 + moved.real))

    def root(self, turn: int) -> tuple[complex, float]:
        """s_n, and the error of its real part."""
        s = last = 2j * np.pi * turn / self.whole
        for _ in range(_ROUNDS):
            s, last = (2j * np.pi * turn + self.log_mean(s)) / self.whole, s
            # the wave is so much faster than its decay that the latter is to settle by itself
            if abs((s - last).real) <= 1e-15 * abs(s.real):
                break
        return s, _ROUND_OFF * abs(s.real) + abs((s - last).real)


def slowest_wave(waves: Waves, narrowest: float) -> tuple[float, float]:
    """-Re s of the slowest root and its error; `narrowest` is the width of the sharpest peak of the travel."""
    slowest, error = np.inf, 0.0
    for turn in _turns(waves, narrowest, _TURNS):
        s, off = waves.root(turn)
        if s.real < 0.0 and -s.real < slowest:
            slowest, error = -s.real, off
    return slowest, error


def slowest_waves(waves: Waves, narrowest: float, count: int) -> list[tuple[complex, float]]:
    """The `count` slowest roots with Im > 0, slowest first, each with the error of its real part."""
    found = [waves.root(turn) for turn in _turns(waves, narrowest, count)]
    return sorted((pair for pair in found if pair[0].real < 0.0), key=lambda pair: -pair[0].real)[:count]


def _turns(waves: Waves, narrowest: float, count: int) -> list[int]:
    """The first `count` n, and as many to either side of frequencies at which |p^| is at a maximum and may be above
    what it is at those."""
    apart, mass, whole = waves.apart, waves.mass, waves.whole
    near = list(range(1, count + 1))
    # so slowly a peak of that width lets |p^| fall: beyond, it is less than at the first of them
    fallen = 2.0 * np.pi / whole * float(np.sqrt(mass @ apart**2)) / narrowest * (count / _TURNS)
    fastest, extent = _FURTHER * fallen, float(np.ptp(apart))
    frequency = np.linspace(0.0, fastest, min(int(fastest * extent / (2.0 * np.pi) * _PER_TURN) + 8, _MOST))
    size = np.array([abs((mass * np.exp(-1j * one * apart)).sum()) for one in frequency])
    for at in np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:])) + 1:
        n = round(float(frequency[at]) * whole / (2.0 * np.pi))
        near += [n + k for k in range(-count, count + 1) if n + k > 0]
    return sorted(set(near))
