"""The spectrum from transforms of what is left of contacts: roots and amplitudes in closed form."""

import mpmath as mp
import numpy as np
import pytest
import scipy.stats as stats
from rate_laws import Tilted

import master
from master import decoherence_spectrum
from master.lives.make import life_of
from master.steady.steady import births_of
from master.steady.travel import Travel
from master.stick_slip.decoherence import decoherence_length
from origins import (
    Contacts,
    Delay,
    InputError,
    Thermal,
    gaussian,
    identical,
    mixture,
)

WIDE = gaussian(1.0, 0.2)


def bells(mean: float, std: float, count: int) -> np.ndarray:
    """4 pi i n/[m + sqrt(m^2 - 4 pi i n std^2)]: the roots of a Gaussian law of ways."""
    turns = 4j * np.pi * np.arange(1, count + 1)
    return turns / (mean + np.sqrt(mean**2 - turns * std**2))


def length_of(contacts: Contacts):
    travel = Travel(life_of(contacts), births_of(contacts), 1.0)
    return decoherence_length(contacts, travel, contacts.waiting_time)


@pytest.mark.parametrize("born", [0.0, 0.1, 0.3])
def test_births_at_a_stretch_shorten_the_way(born: float) -> None:
    """The law of the ways is that of the thresholds, shifted: no root is left out among seven."""
    contacts = Contacts(gaussian(1.0, 0.1), reforming=born)
    found = decoherence_spectrum(contacts, n_roots=7)
    exact = bells(1.0 - born, 0.1, 7)
    assert (np.abs(found.roots - exact) <= found.roots_error).all()
    np.testing.assert_allclose(found.roots, exact, rtol=1e-6)


def test_gamma_thresholds_in_closed_form() -> None:
    """(1 + s)^-8 = 1 on a circle about -1, right of nine tenths of the tail's rate: one of them."""
    found = decoherence_spectrum(Contacts(stats.gamma(8.0)), n_roots=4)
    exact = np.exp(2j * np.pi / 8.0) - 1.0
    assert found.roots.size == 1
    assert abs(found.roots[0] - exact) <= found.roots_error[0] < 1e-9
    length = length_of(Contacts(stats.gamma(3.0)))
    assert abs(length.length - 1.0) <= length.error <= 0.12


def test_arcsine_thresholds_whose_density_diverges_at_both_ends() -> None:
    """p^(s) = e^(-s/2) I_0(s/2)."""
    root = mp.findroot(
        lambda s: mp.exp(-s / 2) * mp.besseli(0, s / 2) - 1, mp.mpc(-1.4, 2 * mp.pi)
    )
    length = length_of(Contacts(stats.arcsine()))
    assert abs(length.length + float(1 / root.real)) <= length.error < 1e-11


@pytest.mark.parametrize("wait", [4.0, 20.0, 100.0])
def test_exponential_thresholds_that_wait(wait: float) -> None:
    """(1 + s) e^(sd) = 1, each root with c = 2/(1 + s)^2/[d + 1/(1 + s)]."""
    found = decoherence_spectrum(Contacts(stats.expon(), delay=Delay(wait)), n_roots=4)
    exact = np.array(
        [
            complex(
                mp.findroot(
                    lambda s, t=2j * mp.pi * n: mp.log1p(s) + s * wait - t,
                    2j * mp.pi * n / (1 + wait),
                )
            )
            for n in range(1, 5)
        ]
    )
    exact = exact[exact.real > -0.9][: found.roots.size]
    assert exact.size == found.roots.size > 0
    assert (np.abs(found.roots - exact) <= found.roots_error).all()
    amplitude = 2.0 / (1.0 + exact) ** 2 / (wait + 1.0 / (1.0 + exact))
    assert (np.abs(found.amplitude - amplitude) <= found.amplitude_error).all()
    assert found.roots_error.max() < 1e-9


def test_exact_values_alone_and_heavy_tails_have_no_decay() -> None:
    for law in (identical(1.0), stats.lognorm(0.5)):
        assert length_of(Contacts(law)) == (np.inf, 0.0)
    for contacts, told in (
        (Contacts(mixture([identical(0.95), identical(1.05)], [0.5, 0.5])), "exact values alone"),
        (Contacts(identical(1.0), thermal=Thermal("soft", 1e-3)), "no root can be told"),
        (Contacts(stats.lognorm(1.0)), "slower than any exponential"),
        (Contacts(gaussian(1.0, 0.1), thermal=Thermal("soft", 0.1, 1e12)), "among so many"),
        (Contacts(WIDE, delay=Delay(1e3)), "wait for 1e[+]03 times"),
    ):
        with pytest.raises(InputError, match=told):
            decoherence_spectrum(contacts)


@pytest.mark.parametrize("wait", [401.0, 1e4, 1e6])
def test_long_waits_decay_as_the_variance_tells(wait: float) -> None:
    exact = mp.mpf(1.0 + wait)
    root = 4j * mp.pi / (exact + mp.sqrt(exact**2 - 4j * mp.pi * mp.mpf(0.1) ** 2))
    length = length_of(Contacts(gaussian(1.0, 0.1), delay=Delay(wait)))
    assert abs(length.length + float(1 / root.real)) <= length.error < 1e-2 * length.length


def test_propensity_takes_a_rate_law_of_this_test() -> None:
    """Its X* is the slowest root of E^(s) = 0, E and E^ by quadrature from the law's formula."""
    alpha, rate = 0.3, 1.0
    contacts = Contacts(gaussian(1.0, 0.1), thermal=Tilted(alpha, rate))
    told = decoherence_spectrum(contacts, n_roots=1)
    found = master.propensity(contacts, 1e-6)
    assert found.success
    assert found.decoherence_length == pytest.approx(told.decay_length[0], rel=1e-9)
    assert found.decoherence_length < 0.5 * length_of(Contacts(gaussian(1.0, 0.1))).length
    nodes, weights = np.polynomial.legendre.leggauss(300)
    x, law = 0.95 * (nodes + 1.0), contacts.thresholds
    xi = x[:, None] + 0.5 * (1.9 - x[:, None]) * (nodes + 1.0)
    spent = rate * alpha * xi * np.exp(-1.0 / alpha) * np.expm1(x[:, None] / (xi * alpha))
    held = (0.5 * (1.9 - x[:, None]) * weights * law.pdf(xi) * np.exp(-spent)).sum(axis=1)
    s = told.roots[0]
    assert abs((0.95 * weights * held * np.exp(-s * x)).sum()) < 1e-11
