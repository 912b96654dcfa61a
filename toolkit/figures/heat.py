"""Figs. 8 to 12, A08: contacts that heat breaks."""

from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss

import master
from origins.contacts import Contacts
from origins.laws.thermal import Thermal
from origins.thresholds.law import Array
from toolkit.figures.found import FORCE, INKS, Found, lettered, normal_tail
from toolkit.scene.scene import load_scene

_MEAN, _STD = 1.0, 0.05
_SLOWNESS = (0.3, 1.0, 3.0, 10.0)  # omega/kv


def _contacts(temperature: float, closure: Any = "paper", law: Any = "soft") -> Contacts:
    plain = load_scene("thermal-paper").contacts
    return plain.replace(thermal=Thermal(law, temperature, closure=closure))


def _mean_rate(x: Array, temperature: float) -> Array:
    """H(x)/omega of soft contacts with Gaussian thresholds, in closed form (Eq. temper11)."""
    both = temperature + _STD**2
    weight = np.sqrt(temperature / both) * np.exp(-0.5 * _MEAN**2 / both)
    mean, std = temperature * _MEAN / both, _STD * np.sqrt(temperature / both)
    return weight * np.exp(0.5 * x * x / temperature) * normal_tail((x - mean) / std)


class _Survival(NamedTuple):
    """Gauss-Legendre nodes (stretches) and weights, and the fraction of the contacts that survives to each node."""

    x: Array
    weights: Array
    survival: Array


def _survival(temperature: float, slowness: float) -> _Survival:
    """Survival on (0, 1.6) in the paper's closure."""
    nodes, weights = leggauss(400)
    x, weights = 0.8 * (nodes + 1.0), 0.8 * weights
    inner, inner_weights = leggauss(60)
    stretch = 0.5 * np.outer(x, inner + 1.0)
    integral = (0.5 * x[:, None] * inner_weights * _mean_rate(stretch, temperature)).sum(axis=1)
    return _Survival(x, weights, normal_tail((x - _MEAN) / _STD) * np.exp(-slowness * integral))


def a08a(figure: Any) -> Found:
    """The breaking rate P_T at several temperatures, and at several speeds."""
    figure.set_size_inches(6.0, 4.8)
    axes = figure.subplots()
    inset = axes.inset_axes((0.12, 0.5, 0.42, 0.43))
    x = np.linspace(0.0, 1.15, 1151)
    cold = load_scene("gaussian").contacts.thresholds
    plain = np.exp(cold.logpdf(x) - cold.logsf(x))
    for axis, cases in (
        (axes, [(t, 1.0) for t in (0.03, 0.1, 0.3, 1.0)]),
        (inset, [(0.3, slow) for slow in _SLOWNESS]),
    ):
        axis.plot(x, plain, ":", color=INKS[0], lw=1.0, label="T = 0")
        for ink, (temperature, slow) in zip(INKS[1:], cases, strict=False):
            rate = _rate(x, temperature, slow)
            name = f"T = {temperature:g}" if axis is axes else f"ω/kv = {slow:g}"
            axis.plot(x, rate, color=ink, lw=1.1, label=name)
        axis.plot(x, cold.pdf(x) * (0.1 if axis is axes else 1.0), "--", color="0.5", lw=0.8)
        axis.set(xlim=(0.0, 1.1))
    axes.set(xlabel="$x$", ylabel="$P_T(x)$, ω/kv = 1 (dashed: $P_c$/10)", ylim=(0.0, 2.5))
    inset.set(ylim=(0.0, 10.0))
    inset.set_title("T = 0.3", fontsize=7, pad=2.0)
    axes.legend(fontsize="x-small", ncols=3, loc="center left", bbox_to_anchor=(0.01, 0.385))
    inset.legend(fontsize=6)
    exact = float(_mean_rate(np.array([0.5]), 0.3)[0])
    found = float(_rate(np.linspace(0.49, 0.51, 21), 0.3, 1.0)[10])
    return Found("P_T(0.5) at T = 0.3, ω/kv = 1", found, 1e-4, exact, "Eq. temper11 in closed form")


def _rate(x: Array, temperature: float, slowness: float) -> Array:
    """P_T = -d ln Q_s/dx of the master equation's steady state in the paper's closure."""
    steady = master.steady_state(_contacts(temperature), velocity=1.0 / slowness)
    return -np.gradient(np.log(steady.distribution(x)), x, edge_order=2)


def a08b(figure: Any) -> Found:
    """Steady stretches at T = 0.3 and several speeds."""
    figure.set_size_inches(5.5, 4.5)
    axes, x = figure.subplots(), np.linspace(0.0, 1.3, 651)
    for ink, slow in zip(INKS[1:], _SLOWNESS, strict=False):
        steady = master.steady_state(_contacts(0.3), velocity=1.0 / slow)
        axes.plot(x, steady.distribution(x), color=ink, label=f"ω/kv = {slow:g}")
        if slow == 10.0:
            found = float(steady.distribution(np.zeros(1))[0])
    axes.plot(
        x,
        load_scene("thermal-paper").contacts.thresholds.pdf(x) / 8.0,
        ":",
        color="0.5",
        label="$P_c$/8",
    )
    axes.set(xlabel="$x$", ylabel="$Q_s(x)$", xlim=(0.0, 1.3))
    axes.legend(fontsize="small", title="T = 0.3")
    _, weights, survival = _survival(0.3, 10.0)
    exact = float(1.0 / (weights * survival).sum())
    return Found("Q_s(0) = 1/C, ω/kv = 10", found, 1e-6, exact, "quadrature of E_P")


def a08c(figure: Any) -> Found:
    """F_k against temperature and against speed, of soft (full) and stiff contacts (broken)."""
    figure.set_size_inches(5.5, 8.5)
    upper, lower = figure.subplots(2, 1)
    inset = lower.inset_axes((0.5, 0.12, 0.47, 0.42))
    temperatures, speeds = np.linspace(1e-3, 2.0, 80), np.geomspace(1e-3, 1e3, 121)
    for law, dash, marker in (("soft", "-", "o"), ("stiff", "--", "o")):
        filled: dict[str, Any] = {
            "ls": dash,
            "lw": 1.0,
            "marker": marker,
            "ms": 3.5,
            "markevery": 10,
        }
        for ink, speed in zip(INKS, (0.01, 0.1, 1.0, 10.0), strict=False):
            force = master.kinetic_curve(
                _contacts(1.0, "exact", law), speed, temperature=temperatures
            ).force
            style = filled | {"color": ink, "mfc": ink if law == "soft" else "none"}
            upper.plot(
                temperatures, force, **style, label=f"v = {speed:g}" if law == "soft" else None
            )
        for ink, temperature in zip(INKS, (0.01, 0.1, 0.3, 1.0), strict=False):
            force = master.kinetic_curve(_contacts(temperature, "exact", law), speeds).force
            style = filled | {"color": ink, "mfc": ink if law == "soft" else "none"}
            lower.semilogx(
                speeds, force, **style, label=f"T = {temperature:g}" if law == "soft" else None
            )
            inset.loglog(speeds, force, ls=dash, color=ink, lw=0.8)
    upper.set(xlabel="$T$", ylabel=r"$F_k/(N_c\langle k\rangle)$", ylim=(0.0, 0.55))
    lower.set(xlabel="$v$", ylabel=r"$F_k/(N_c\langle k\rangle)$", ylim=(0.0, 0.6))
    upper.legend(fontsize="small", title="full: soft; broken: stiff", title_fontsize="small")
    lower.legend(fontsize="small", loc="upper center", ncols=4, columnspacing=1.0)
    inset.tick_params(labelsize=6)
    for axes, letter in ((upper, "a"), (lower, "b")):
        lettered(axes, letter)
    speed, temperature = 1e4, 0.1
    fast = master.kinetic_curve(_contacts(temperature, "exact"), speed)
    found = (float(fast.force) - 0.5 * (1.0 + _STD**2)) * speed
    return Found(
        "v (F_k - F(∞)) for v → ∞, soft contacts, T = 0.1",
        found,
        2e-4 * abs(found),
        _fast_coefficient(temperature),
        "first order in 1/v, by quadrature",
        paper="∝ -ωT²/k",
        remark=f"-ωT²/2k = {-0.5 * temperature**2:g} is the limit T → 0, of soft contacts that break one by one; stiff "
        "ones go as T^(5/3), and in the paper's own closure it is T std.",
    )


def _fast_coefficient(temperature: float) -> float:
    """The limit of v (F_k - F(∞)) for soft contacts, omega = 1: one heat break in a thousand changes F so.

    E(x) = 1 - A(x)/v below the threshold, A(x) the integral of the rate; its integrals over x are single ones."""
    nodes, weights = leggauss(60)
    bell, bell_weights = np.polynomial.hermite_e.hermegauss(30)
    xi = _MEAN + _STD * bell[:, None]
    y, dy = 0.5 * xi * (nodes + 1.0), 0.5 * xi * weights
    rate = np.exp(-0.5 * (xi * xi - y * y) / temperature) * dy
    weight = bell_weights / bell_weights.sum()
    travel = -float(weight @ (rate * (xi - y)).sum(axis=1))
    moment = -float(weight @ (rate * 0.5 * (xi * xi - y * y)).sum(axis=1))
    return (moment - 0.5 * (1.0 + _STD**2) * travel) / _MEAN


def a08d(figure: Any) -> Found:
    """F(X) at T = 0.3 and several speeds: by single contacts, and dotted in the paper's closure."""
    figure.set_size_inches(5.5, 4.5)
    axes, path = figure.subplots(), np.linspace(0.0, 12.0, 601)
    for ink, slow in zip(INKS, (0.0, *_SLOWNESS), strict=False):
        for closure, dash in (("exact", "-"), ("paper", ":")):
            contacts = _contacts(0.3, closure) if slow else load_scene("gaussian").contacts
            contacts = contacts.replace(start=_contacts(0.3).start)
            solved: Any = master.solve(contacts, path, 1e-6, velocity=1.0 / (slow or 1.0))
            name = f"ω/kv = {slow:g}" if closure == "exact" else None
            axes.plot(path, solved.force, dash, color=ink, lw=1.0, label=name)
            if slow == 1.0 and closure == "paper":
                late: Any = master.solve(contacts, [200.0], 1e-8)
    axes.plot([], [], ":", color="0.4", label="the paper's closure")
    axes.set(xlabel="$X$", ylabel=FORCE, xlim=(0.0, 12.0), ylim=(0.0, 1.2))
    axes.legend(fontsize="small", ncols=2)
    x, weights, survival = _survival(0.3, 1.0)
    exact = float((weights * x * survival).sum() / (weights * survival).sum())
    return Found(
        "F at X = 200, T = 0.3, ω/kv = 1, the paper's closure",
        float(late.force[0]),
        1e-6,
        exact,
        "F_k by quadrature of Eq. temper4",
        remark="Dotted lines add the mean rate H/v to P, which counts weak contacts that heat has already broken; full "
        "lines follow single contacts.",
    )


def a08e(figure: Any) -> Found:
    """The first cycle: F(X) at several temperatures, and at several speeds."""
    figure.set_size_inches(5.5, 8.5)
    rows, path = figure.subplots(2, 1), np.linspace(0.0, 1.6, 321)
    cases = [[(t, 1.0) for t in (0.0, 0.03, 0.1, 0.3, 1.0)], [(0.3, s) for s in (0.0, *_SLOWNESS)]]
    for axes, letter, own in zip(rows, "ab", cases, strict=True):
        for ink, (temperature, slow) in zip(INKS, own, strict=False):
            warm = temperature > 0.0 and slow > 0.0
            contacts = _contacts(temperature, "exact") if warm else _cold()
            solved: Any = master.solve(contacts, path, 1e-6, velocity=1.0 / (slow or 1.0))
            name = f"T = {temperature:g}" if letter == "a" else f"ω/kv = {slow:g}"
            axes.plot(path, solved.force, color=ink, lw=1.1, label=name)
        axes.set(xlabel="$X$", ylabel=FORCE)
        axes.legend(fontsize="small")
        lettered(axes, letter)
    found: Any = master.propensity(_cold(), tolerance=1e-9)
    exact = _steepest(np.linspace(0.7, 1.1, 400_001))
    return Found(
        "K* = max(-F'), T = 0",
        *(float(found.critical_spring), float(found.critical_spring_error) + 1e-8, exact),
        "closed form of F'(X), Gaussian thresholds",
        paper="~ <x_s>/std = 20",
        remark="The paper's scaling does not hold: for narrow Gaussians, relaxed, K* is <x_s>/(std (2π)^(1/2)) - 1.",
    )


def _cold() -> Contacts:
    return load_scene("thermal-paper").contacts.replace(thermal=None)


def _steepest(path: Array) -> float:
    """max(-F') over the first cycle: F' = 1 - sum of [<x_s> phi/w + (std²/w²) z phi], start 0.1 ± 0.025."""
    slope = np.ones_like(path)
    for count in (1, 2, 3):
        w = np.sqrt(count * _STD**2 + 0.025**2)
        z = (path + 0.1 - count * _MEAN) / w
        bell = np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
        slope -= _MEAN * bell / w + (_STD / w) ** 2 * z * bell
    return float(-slope.min())
