"""The decay towards smooth sliding: roots, what they carry, and the rate of a law's own tail."""

import numpy as np
import pytest
import scipy.stats as stats

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
    told = master.propensity(Contacts(law), 1e-6)
    length, error = told.decoherence_length, told.decoherence_length_error

    def excess(s: complex) -> complex:
        return (1.0 - weight) * np.exp(-s + 0.5 * (s * width) ** 2) + weight * (1.0 + scale * s) ** -shape - 1.0

    # either the tail's own rate, or a root of the closed transform beside what was found
    assert error <= 0.101 * length
    if error > 1e-6:
        assert length == pytest.approx(scale, rel=1e-7)
    else:
        line = -1.0 / length + 1j * np.linspace(0.5, 12.0, 20001)
        assert np.abs([excess(s) for s in line]).min() < 1e-3


@pytest.mark.parametrize("shape", [0.1, 1.0, 3.5])
def test_broad_tails_decay_at_their_own_rate(shape: float) -> None:
    told = master.propensity(Contacts(stats.gamma(shape)), 1e-6)
    # no root is looked for between 0.9 and 1 of the tail's rate
    assert abs(told.decoherence_length - 1.0) <= told.decoherence_length_error < 0.12


@pytest.mark.parametrize("law", [stats.weibull_min(0.8), stats.lognorm(0.5)])
def test_tails_slower_than_any_exponential_have_no_length(law) -> None:
    told = master.propensity(Contacts(law), 1e-6)
    assert (told.decoherence_length, told.decoherence_length_error) == (np.inf, 0.0)


TWO_WITNESSES = {
    # identical contacts, hot: an exact value of less weight beside a density that ends in a root
    "soft, cold": Contacts(identical(1.0), thermal=Thermal("soft", 0.05)),
    "soft, hot": Contacts(identical(1.0), thermal=Thermal("soft", 0.3)),
    "stiff, cold": Contacts(identical(1.0), thermal=Thermal("stiff", 0.05)),
    "stiff, hot": Contacts(identical(1.0), thermal=Thermal("stiff", 0.3)),
    "paper's closure": Contacts(identical(1.0), thermal=Thermal("soft", 0.1, closure="paper"), delay=WAIT),
    "no temperature": LATE["exact value and width"](),
    "rectangular": Contacts(rectangular(0.5, 1.5), thermal=Thermal("soft", 0.1), delay=WAIT),
    "wide": LATE["wide"](),
}


@pytest.mark.parametrize("name", TWO_WITNESSES)
def test_the_slowest_root_is_the_decoherence_length(name: str) -> None:
    """X* is that of the slowest root, or of the rate about which roots crowd."""
    contacts = TWO_WITNESSES[name]
    told = master.propensity(contacts, 1e-6)
    length, error = told.decoherence_length, told.decoherence_length_error
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
    with pytest.raises(InputError, match=r"velocity = 10.0: grains grow, unpinned, .* times as long as they hold"):
        master.decoherence_spectrum(Contacts(growing_grains(1.0, 1.0, age=4.0)), velocity=10.0)
    with pytest.raises(InputError, match="among so many no leading oscillating wave"):
        master.decoherence_spectrum(Contacts(gaussian(1.0, 0.1), thermal=Thermal("soft", 0.1, 1e12)))
    with pytest.raises(InputError, match="n_roots"):
        master.decoherence_spectrum(Contacts(WIDE), n_roots=0)
    with pytest.raises(InputError, match=r"contacts wait for 1e\+13 times .*: roots are told up to 400 times"):
        master.decoherence_spectrum(Contacts(gaussian(1.0, 0.05), delay=Delay(1e13)))


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_no_root_is_left_out_beside_the_rate_of_an_exact_value(law: str) -> None:
    """Roots of the transform of E, by quadrature, from starts near 2πin: some hardly decay, some as the crowd."""
    contacts = Contacts(identical(1.0), thermal=Thermal(law, 0.05))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    edges = np.concatenate([np.linspace(0.0, 0.9, 10), 1.0 - np.geomspace(0.1, 1e-9, 20)[1:], [1.0]])
    half = 0.5 * np.diff(edges)[:, None]
    x = (edges[:-1, None] + half * (nodes + 1.0)).ravel()
    one = np.ones(x.size)
    spent = np.exp(contacts.thermal.rates.log_passed(0.0 * x, x, one, one))
    held = np.exp(-spent) * (half * weights).ravel()
    exact = []
    for n in range(1, 9):
        s = -0.03 + 2j * np.pi * n
        for _ in range(60):
            wave = held * np.exp(-s * x)
            s += wave.sum() / (wave @ x)
        exact.append(s)
    exact = np.array(sorted(exact, key=lambda s: -s.real))
    found = master.decoherence_spectrum(contacts, n_roots=5)
    assert found.roots.size >= (5 if law == "soft" else 1)
    np.testing.assert_allclose(found.roots, exact[: found.roots.size], rtol=1e-9)
    length = master.propensity(contacts, 1e-6)
    assert length.critical_spring == np.inf and length.critical_spring_error == 0.0
    assert length.decoherence_length == pytest.approx(-1.0 / exact[0].real, rel=1e-8)
