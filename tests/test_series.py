"""Convolution and the renewal equation on sequences, against sums term by term."""

import numpy as np
import pytest

from master._old.series import convolve, renew


def renew_by_recursion(source, kernel):
    """b_j (1 - k_0) = s_j + sum of k_i b_(j-i), i >= 1."""
    out = np.zeros(source.size)
    for j in range(source.size):
        out[j] = (source[j] + kernel[1 : j + 1] @ out[:j][::-1]) / (1.0 - kernel[0])
    return out


def gaussian_kernel(size, middle, width):
    kernel = np.exp(-0.5 * ((np.arange(size) - middle) / width) ** 2)
    return kernel / kernel.sum()


@pytest.mark.parametrize(("first", "second", "size"), [(100, 100, 100), (7, 300, 200), (1, 1, 1), (1000, 3, 1000)])
def test_convolution_is_the_sum_of_products(first, second, size):
    rng = np.random.default_rng(first)
    a, b = rng.normal(size=first), rng.normal(size=second)
    exact = np.convolve(a[:size], b[:size])[:size]
    got = convolve(a, b, size)[: exact.size]
    assert np.abs(got - exact).max() <= 1e-14 * np.convolve(np.abs(a), np.abs(b)).max()


def test_convolution_is_causal():
    a, b = np.zeros(64), np.zeros(64)
    a[40], b[30] = 1.0, 1.0
    assert np.abs(convolve(a, b, 64)).max() < 1e-15  # 70 lies beyond and does not come round


@pytest.mark.parametrize(
    "kernel",
    [
        gaussian_kernel(2000, 200, 20),
        gaussian_kernel(2000, 700, 2),
        np.eye(1, 2000, 100)[0],
        0.01 * 0.99 ** np.arange(2000),
        -0.3 * np.eye(1, 2000, 0)[0] + 1.3 * np.eye(1, 2000, 3)[0],
        0.2 * np.eye(1, 2000, 37)[0],
    ],
    ids=["wide", "narrow", "one-step", "exponential", "signed", "defective"],
)
def test_renewal_agrees_with_the_recursion(kernel):
    source = gaussian_kernel(2000, 150, 15)
    exact = renew_by_recursion(source, kernel)
    if not np.isfinite(exact).all() or np.abs(exact).max() > 10.0:
        pytest.fail("the case itself grows: choose another")
    breaks, released = renew(source, kernel, source)
    assert np.abs(breaks - exact).max() <= 1e-13 * np.abs(exact).max()
    assert np.abs(released - np.convolve(source, exact)[:2000]).max() <= 1e-13 * np.abs(exact).max()


def test_renewal_rate_stays_the_inverse_mean_for_ever():
    kernel = gaussian_kernel(300_000, 300, 40)
    late = renew(kernel, kernel, kernel)[0][50_000:]
    assert np.abs(late * 300.0 - 1.0).max() < 1e-12


def test_an_undamped_train_of_breaks_keeps_its_height():
    kernel = np.eye(1, 50_000, 100)[0]
    breaks, _ = renew(np.eye(1, 50_000, 0)[0], kernel, kernel)
    assert np.abs(breaks[::100] - 1.0).max() < 1e-12
    breaks[::100] = 0.0
    assert np.abs(breaks).max() < 1e-12
