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


def slowest_wave(travel: Array, mass: Array, wait: float, narrowest: float) -> tuple[float, float]:
    """-Re s of the slowest root and its error; `travel` without the wait, its weights `mass`, and the width of the
    sharpest peak among them."""
    mass = mass / mass.sum()
    mean = float(mass @ travel)
    apart = travel - mean
    # <y> = 0 but for rounding: so be it
    apart = apart - float(mass @ apart)
    whole = wait + mean

    def log_mean(s: complex) -> complex:
        """k(s)."""
        z = -s * apart
        small = np.abs(z) < _SMALL
        beyond = np.zeros(z.shape, dtype=complex)
        factor = np.ones(int(small.sum()), dtype=complex) * z[small]
        for n in range(2, _TERMS):
            factor = factor * z[small] / n
            beyond[small] += factor
        beyond[~small] = np.exp(z[~small]) - 1.0 - z[~small]
        moved = complex((mass * beyond).sum())
        size = 0.5 * np.log1p(2.0 * moved.real + abs(moved) ** 2)
        return complex(size, np.arctan2(moved.imag, 1.0 + moved.real))

    slowest, error = np.inf, 0.0
    for turn in _turns(apart, mass, whole, narrowest):
        s = last = 2j * np.pi * turn / whole
        for _ in range(_ROUNDS):
            s, last = (2j * np.pi * turn + log_mean(s)) / whole, s
            # the wave is so much faster than its decay that the latter is to settle by itself
            if abs((s - last).real) <= 1e-15 * abs(s.real):
                break
        if s.real < 0.0 and -s.real < slowest:
            slowest = -s.real
            error = _ROUND_OFF * slowest + abs((s - last).real)
    return slowest, error


def _turns(apart: Array, mass: Array, whole: float, narrowest: float) -> list[int]:
    """The first n, and those of frequencies at which |p^| is at a maximum and may be above what it is at the first."""
    near = list(range(1, _TURNS + 1))
    # so slowly a peak of that width lets |p^| fall: beyond, it is less than at the first n
    fallen = 2.0 * np.pi / whole * float(np.sqrt(mass @ apart**2)) / narrowest
    fastest, extent = _FURTHER * fallen, float(np.ptp(apart))
    frequency = np.linspace(0.0, fastest, min(int(fastest * extent / (2.0 * np.pi) * _PER_TURN) + 8, _MOST))
    size = np.array([abs((mass * np.exp(-1j * one * apart)).sum()) for one in frequency])
    for at in np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:])) + 1:
        n = round(float(frequency[at]) * whole / (2.0 * np.pi))
        near += [n + k for k in range(-_TURNS, _TURNS + 1) if n + k > 0]
    return sorted(set(near))
