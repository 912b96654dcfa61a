"""The decay towards smooth sliding: roots, what they carry, and the rate of a law's own tail."""

import sys

import mpmath as mp
import numpy as np
import pytest
import scipy.stats as stats
from scipy.special import gammaln

import master
from origins import (
    Ageing,
    Contacts,
    Delay,
    InputError,
    Thermal,
    gaussian,
    gaussian_start,
    growing_grains,
    identical,
    lubricated,
    mixture,
    rectangular,
)
from tests.phase_type import gaussian_force

WIDE, WAIT = gaussian(1.0, 0.2), Delay(0.3)


def gaussian_roots(std: float, count: int) -> np.ndarray:
    """4πin/[x̄ + sqrt(x̄² - 4πin σ²)], the closed form without its cancellation."""
    turns = 4j * np.pi * np.arange(1, count + 1)
    return turns / (1.0 + np.sqrt(1.0 - turns * std**2))


@pytest.mark.parametrize("std", [1e-3, 0.05, 0.1])
def test_gaussian_roots_and_amplitudes_in_closed_form(std: float) -> None:
    mean, width = 0.1, 0.025
    found = master.decoherence_spectrum(Contacts(gaussian(1.0, std), gaussian_start(mean, width)), n_roots=6)
    exact = gaussian_roots(std, 6)
    assert (np.abs(found.roots - exact) <= found.roots_error + 4e-16).all()
    np.testing.assert_allclose(found.roots, exact, rtol=1e-11)
    np.testing.assert_allclose(found.period, 2.0 * np.pi / exact.imag, rtol=1e-11)
    # real parts of the narrow law are a millionth of the root
    assert (np.abs(found.decay_length + 1.0 / exact.real) <= found.decay_length_error + 1e-10).all()
    amplitude = -2.0 / exact * np.exp(exact * mean + 0.5 * (exact * width) ** 2)
    assert (np.abs(found.amplitude - amplitude) <= found.amplitude_error + 1e-13).all()
    np.testing.assert_allclose(found.amplitude, amplitude, rtol=1e-9)


LATE = {
    "start": lambda: Contacts(WIDE, gaussian_start(0.1, 0.05)),
    "behind, linked, delay": lambda: Contacts(WIDE, -0.6, stiffness="linked", delay=WAIT),
    "reborn": lambda: Contacts(WIDE, 0.1, reforming=gaussian_start(0.05, 0.05), delay=WAIT),
    "jumps": lambda: Contacts(rectangular(0.5, 1.5), gaussian_start(0.0, 0.1)),
    "wide": lambda: Contacts(lubricated(1.0)),
    "tail": lambda: Contacts(stats.gamma(20.0)),
    "tail alone": lambda: Contacts(stats.gamma(3.0)),
    "exact value and width": lambda: Contacts(mixture([gaussian(1.0, 0.1), identical(0.8)], [0.7, 0.3])),
    "warm": lambda: Contacts(gaussian(1.0, 0.1), thermal=Thermal("stiff", 0.1)),
    "warm, linked": lambda: Contacts(WIDE, thermal=Thermal("soft", 0.1), stiffness="linked", delay=WAIT),
    "warm, paper's": lambda: Contacts(gaussian(1.0, 0.1), thermal=Thermal("soft", 0.1, closure="paper")),
    "ageing": lambda: Contacts(gaussian(0.5, 0.1), ageing=Ageing(gaussian(1.0, 0.02), 5e-4)),
}


@pytest.mark.parametrize("name", LATE)
def test_the_sum_of_terms_is_the_late_force(name: str) -> None:
    contacts = LATE[name]()
    found = master.decoherence_spectrum(contacts, n_roots=6)
    x = contacts.mean_threshold * np.array([1.3, 2.1, 3.7, 6.2, 11.4, 21.3])
    solved = master.solve(contacts, x, 1e-10)
    off = np.abs(found.force(x) - solved.force) / contacts.mean_threshold
    error = found.force_error(x)
    assert (off <= error + solved.force_error).all()
    assert error[-1] < 3e-4
    assert found.roots.size == 0 or error[0] > error[-1]


def test_two_narrow_peaks_are_the_sum_of_their_terms_at_once() -> None:
    # Fig. delta12, right column: eighty terms give F where four fifths of its path are over
    peaks = mixture([gaussian(0.95, 1e-3), gaussian(1.05, 1e-3)], [0.5, 0.5])
    contacts = Contacts(peaks, gaussian_start(0.1, 0.025))
    found = master.decoherence_spectrum(contacts, n_roots=80)
    x = np.linspace(40.0, 50.0, 101)
    solved = master.solve(contacts, x, 1e-10)
    assert np.abs(found.force(x) - solved.force).max() <= found.force_error(40.0) + solved.force_error < 2e-11
    # the slowest of all repeats in the divisor 0.05 that both values share, not in their mean
    assert found.period[0] == pytest.approx(0.05, rel=1e-3)
    # where both peaks are in phase what is left of the damping is their width's
    assert found.decay_length[0] == pytest.approx(2.0 / (2.0 * np.pi * 20.0 * 1e-3) ** 2, rel=1e-3)


def test_two_peaks_decay_at_the_rate_of_their_leading_root() -> None:
    contacts = Contacts(mixture([gaussian(0.95, 0.02), gaussian(1.05, 0.02)], [0.5, 0.5]), gaussian_start(0.1, 0.025))
    found = master.decoherence_spectrum(contacts, n_roots=1)
    x = np.linspace(60.0, 90.0, 3001)
    off = master.solve(contacts, x, 1e-11).force - found.kinetic_force
    # largest swing in each period
    swing = np.array([np.abs(part).max() for part in np.array_split(off[:-1], 30)])
    rate = -np.polyfit(np.arange(30.0), np.log(swing), 1)[0]
    assert 1.0 / rate == pytest.approx(found.decay_length[0], rel=1e-3)


def test_exact_values_without_a_common_divisor_decay() -> None:
    """Those with one keep a sawtooth for ever: test_solve follows it value by value."""
    apart = Contacts(mixture([identical(0.95), identical(1.05 + 0.01 * np.sqrt(2.0))], [0.5, 0.5]))
    window = np.linspace(0.0, 2.0, 401)
    swings = [np.ptp(master.solve(apart, begin + window, 1e-6).force) for begin in (5.0, 15.0, 45.0)]
    # 10 thresholds further a third is gone at least, 30 further half of the rest
    assert swings[1] < swings[0] / 1.5 and swings[2] < 0.5 * swings[1]


def test_narrow_thresholds_keep_the_damping_of_their_own() -> None:
    contacts = Contacts(gaussian(1.0, 1e-3), gaussian_start(0.1, 0.025))
    x = np.linspace(49.0, 50.0, 401)
    solved = master.solve(contacts, x, 1e-9)
    exact = gaussian_force(x, 1.0, 1e-3, 0.1, 0.025)
    assert np.abs(solved.force - exact).max() <= solved.force_error <= 1e-9
    # the first harmonic of fifty periods falls as the root says, by a thousandth in all
    found = master.decoherence_spectrum(contacts, n_roots=1)
    root, size = found.roots[0], float(np.abs(found.amplitude[0] * np.exp(found.roots[0] * 49.5)))
    harmonic = 2.0 * np.abs(np.trapezoid((solved.force - found.kinetic_force) * np.exp(-1j * root.imag * x), x))
    assert harmonic == pytest.approx(size, rel=1e-5)
    assert 49.5 / found.decay_length[0] == pytest.approx(2.0 * np.pi**2 * 49.5e-6, rel=1e-3)


@pytest.mark.parametrize(
    ("width", "shape", "scale", "weight"),
    [(0.19, 1.43, 3.81, 0.49), (0.15, 2.62, 1.32, 0.13)],
)
def test_a_peak_with_a_wide_gamma_law(width: float, shape: float, scale: float, weight: float) -> None:
    law = mixture([gaussian(1.0, width), stats.gamma(shape, scale=scale)], [1.0 - weight, weight])
    length, error = master._old.decoherence.decoherence_length(Contacts(law))

    def excess(s: complex) -> complex:
        return (1.0 - weight) * np.exp(-s + 0.5 * (s * width) ** 2) + weight * (1.0 + scale * s) ** -shape - 1.0

    # either the tail's own rate, or a root of the closed transform beside what was found
    assert error <= 0.101 * length
    if error > 1e-6:
        assert length == pytest.approx(scale, rel=1e-7)
    else:
        line = -1.0 / length + 1j * np.linspace(0.5, 12.0, 20001)
        assert np.abs([excess(s) for s in line]).min() < 1e-3


def test_rates_of_tails() -> None:
    for shape in (0.1, 1.0, 3.5, 20.0):
        rate, error = master._old.decoherence.tail_rate(master._old.cycle.Cycle(Contacts(stats.gamma(shape))))
        assert abs(rate - 1.0) <= error < 1e-5
    for law, rate in ((stats.weibull_min(1.1), np.inf), (stats.weibull_min(0.8), 0.0), (stats.lognorm(1.0), 0.0)):
        assert master._old.decoherence.tail_rate(master._old.cycle.Cycle(Contacts(law))) == (rate, 0.0)


TWO_WITNESSES = {
    # identical contacts, hot: an exact value of less weight beside a density that ends in a root
    "soft, cold": Contacts(identical(1.0), thermal=Thermal("soft", 0.05)),
    "soft, hot": Contacts(identical(1.0), thermal=Thermal("soft", 0.3)),
    "stiff, cold": Contacts(identical(1.0), thermal=Thermal("stiff", 0.05)),
    "stiff, hot": Contacts(identical(1.0), thermal=Thermal("stiff", 0.3)),
    "stiff, linked": Contacts(
        mixture([identical(0.85), gaussian(1.2, 0.1)], [0.87, 0.13]),
        thermal=Thermal("stiff", 0.01, 0.19),
        stiffness="linked",
    ),
    "paper's closure": Contacts(identical(1.0), thermal=Thermal("soft", 0.1, closure="paper"), delay=WAIT),
    "no temperature": LATE["exact value and width"](),
    "rectangular": Contacts(rectangular(0.5, 1.5), thermal=Thermal("soft", 0.1), delay=WAIT),
    "wide": LATE["wide"](),
}


@pytest.mark.parametrize("name", TWO_WITNESSES)
def test_the_slowest_root_is_the_decoherence_length(name: str) -> None:
    """One is searched for along dips, the others are counted: two roads to one number, or to the rate of a crowd."""
    contacts = TWO_WITNESSES[name]
    length, error = master._old.decoherence.decoherence_length(contacts, master._old.cycle.Cycle(contacts))
    found = master.decoherence_spectrum(contacts, n_roots=1)
    if found.roots.size:
        assert abs(length - found.decay_length[0]) <= error + found.decay_length_error[0] < 1e-5 * length
    else:  # all roots crowd about the rate of the exact value
        assert error == pytest.approx(0.1 * length) and length - error < found.beyond


def test_what_has_no_spectrum_is_said() -> None:
    with pytest.raises(InputError, match="exact values alone: their roots come as near to Re s = 0 as one likes"):
        master.decoherence_spectrum(Contacts(mixture([identical(0.95), identical(1.05)], [0.5, 0.5])))
    with pytest.raises(InputError, match="no root can be told from those at Re s = 0"):
        master.decoherence_spectrum(Contacts(identical(1.0), thermal=Thermal("soft", 1e-3)))
    with pytest.raises(InputError, match="tail falls slower than any exponential"):
        master.decoherence_spectrum(Contacts(stats.lognorm(1.0)))
    aged = Contacts(gaussian(0.5, 0.1), ageing=Ageing(WIDE, 1e-4, closure="paper"))
    with pytest.raises(InputError, match="single contacts have no law of their own"):
        master.decoherence_spectrum(aged)
    with pytest.raises(InputError, match="fewer than 1e-14 of new grains hold at all"):
        master.decoherence_spectrum(Contacts(growing_grains(1.0, 1.0, age=4.0)), velocity=10.0)
    with pytest.raises(InputError, match="among so many no leading oscillating wave"):
        master.decoherence_spectrum(Contacts(gaussian(1.0, 0.1), thermal=Thermal("soft", 0.1, 1e12)))
    with pytest.raises(InputError, match="n_roots"):
        master.decoherence_spectrum(Contacts(WIDE), n_roots=0)
    with pytest.raises(InputError, match=r"contacts wait for 1e\+13 times as long as they hold"):
        master.decoherence_spectrum(Contacts(gaussian(1.0, 0.05), delay=Delay(1e13)))


@pytest.mark.parametrize("wait", [401.0, 1e6, 1e12])
def test_long_waits_in_closed_form(wait: float) -> None:
    """Gaussian: s (1 + d) = s²σ²/2 + 2πin; exponential: (1 + s) e^{sd} = 1, each with what its root carries."""
    count, std = 5, mp.mpf(0.1)
    with mp.workdps(70):
        turns = [2j * mp.pi * n for n in range(1, count + 1)]
        whole = 1 + mp.mpf(wait)
        bells = [2 * turn / (whole + mp.sqrt(whole**2 - 2 * turn * std**2)) for turn in turns]
        tails = [mp.findroot(lambda s, t=t: mp.log1p(s) + s * wait - t, t / whole) for t in turns]
        moved = []
        for s in bells:
            law = mp.exp(-s + (s * std) ** 2 / 2)
            mean = 1 - std**2 * s
            moved.append(2 * (1 - law - s * mean * law) / s**2 / (wait + mean))
        gone = [2 / (1 + s) ** 2 / (wait + 1 / (1 + s)) for s in tails]
        for law, roots, amplitudes in ((gaussian(1.0, 0.1), bells, moved), (stats.expon(), tails, gone)):
            found = master.decoherence_spectrum(Contacts(law, delay=Delay(wait)), n_roots=count)
            assert found.roots.size == count
            for n, (s, c) in enumerate(zip(roots, amplitudes, strict=True)):
                assert abs(s - mp.mpc(complex(found.roots[n]))) <= found.roots_error[n] < 1e-14 * abs(s)
                length, error = found.decay_length[n], found.decay_length_error[n]
                assert abs(length + 1 / s.real) <= error < 1e-13 * length
                assert abs(c - mp.mpc(complex(found.amplitude[n]))) <= found.amplitude_error[n] < 1e-12 * abs(c)


def test_the_sum_of_terms_after_a_long_wait_is_the_late_force() -> None:
    """Exponential thresholds: F of each generation is a gamma density, u^{j+1} e^{-u}/(j+1)! at u = X - jd."""
    wait = 401.0
    found = master.decoherence_spectrum(Contacts(stats.expon(), delay=Delay(wait)), n_roots=6)
    for x in np.array([1e-5, 0.01, 0.1, 0.3, 1.0]) * found.decay_length[0]:
        j = np.arange(int(x / wait) + 1.0)
        u = x - j * wait
        force = float(np.exp((j + 1.0) * np.log(u) - u - gammaln(j + 2.0)).sum())
        error = found.force_error(x)
        assert abs(found.force(x) - force) <= error + 1e-13
    assert error < 1e-12


@pytest.mark.parametrize("name", ["narrow peaks", "start", "reborn", "linked, warm"])
def test_roots_told_one_by_one_are_those_that_are_counted(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    peaks = mixture([gaussian(0.95, 0.01), gaussian(1.05, 0.01)], [0.5, 0.5])
    wait = Delay(40.0)
    contacts = {
        "narrow peaks": Contacts(peaks, 0.1, delay=wait),
        "start": Contacts(WIDE, gaussian_start(0.1, 0.05), delay=wait),
        "reborn": Contacts(WIDE, 0.1, reforming=gaussian_start(0.05, 0.05), delay=wait),
        "linked, warm": Contacts(WIDE, 0.1, thermal=Thermal("soft", 0.1), stiffness="linked", delay=wait),
    }[name]
    one = master.decoherence_spectrum(contacts, n_roots=6)
    monkeypatch.setattr(sys.modules["master._old.decoherence_spectrum"], "_COUNTED", 0.0)
    other = master.decoherence_spectrum(contacts, n_roots=6)
    assert (np.abs(one.roots - other.roots) <= one.roots_error + other.roots_error).all()
    assert (np.abs(one.amplitude - other.amplitude) <= one.amplitude_error + other.amplitude_error).all()
    np.testing.assert_allclose(one.decay_length, other.decay_length, rtol=1e-6)
    x = np.array([0.5, 5.0, 200.0, 3000.0])
    assert (np.abs(one.force(x) - other.force(x)) <= one.force_error(x) + other.force_error(x)).all()
