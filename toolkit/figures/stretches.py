"""Figs. 2 to 7 and 20: stretches Q(x;X) of the ensemble (A02) and of the master equation (A03), and where they end."""

from typing import Any

import numpy as np

import eq_model
import master
from origins.contacts import Contacts
from origins.thresholds.law import Array
from toolkit.figures.found import FORCE, INKS, Found, coarser, lettered, waterfall
from toolkit.judge.closed_form import closed_form
from toolkit.scene.scene import load_scene

_CONTACTS = 200_000  # so that noise is visible, as in the paper, and F is good to 1e-3
_FINE = 8  # bins of a histogram in one: 0.2 of the standard deviation of the start, and noise of a per cent at a peak
_LONG = 1.05  # the increment of X in Figs. 3 and 6, 1.09 in the latter of the paper


def _contacts() -> Contacts:
    return load_scene("gaussian").contacts


def _followed(contacts: Contacts, path: Any, shown: Any) -> Any:
    """The ensemble along the path, with histograms at the positions shown."""
    points = np.searchsorted(path, np.asarray(shown) - 1e-9).tolist()
    return eq_model.simulate(
        contacts, path, n_contacts=_CONTACTS, n_replicas=1, seed=1, histograms=points
    )


def _two(figure: Any) -> Any:
    figure.set_size_inches(5.5, 8.5)
    return figure.subplots(2, 1, height_ratios=(1.6, 1.0))


def a02a(figure: Any) -> Found:
    """Short times of the ensemble: Q(x;X) every 0.05, and F(X)."""
    path = np.linspace(0.0, 3.0, 301)
    found, exact = _by_ensemble(figure, path, path[:151:5])
    top = int(np.argmax(exact))
    return _told_at(top, f"F_s, the ensemble's F at X = {path[top]:.2f}", found, exact)


def a02b(figure: Any) -> Found:
    """Long times of the ensemble, with the increment 1.05."""
    shown = _LONG * np.arange(25.0)
    path = np.unique(np.concatenate([shown, np.linspace(0.0, shown[-1], 501)]))
    found, exact = _by_ensemble(figure, path, shown)
    return _told_at(-1, f"the ensemble's F at X = {path[-1]:.1f}", found, exact)


def _by_ensemble(figure: Any, path: Array, shown: Array) -> tuple[Any, Array]:
    """The ensemble's Q(x;X) where it is shown, above F(X); what it found, and F in closed form."""
    found = _followed(_contacts(), path, shown)
    upper, lower = _two(figure)
    waterfall(upper, (coarser(h.stretch_edges, h.stretches, _FINE) for h in found.histograms), 1.0)
    lower.plot(path, found.force, color=INKS[0], lw=1.0)
    _name(upper, lower)
    return found, closed_form(_contacts(), path)[0]


def _told_at(point: int, what: str, found: Any, exact: Array) -> Found:
    """The ensemble's force at a point of its path."""
    value, off = float(found.force[point]), 5.0 * float(found.force_standard_error[point])
    return Found(what, value, off, float(exact[point]), "closed form, Gaussian thresholds")


def a02c(figure: Any) -> Found:
    """The ensemble's stretches and thresholds in steady sliding, with their exact laws."""
    contacts, figure_path = _contacts(), np.linspace(0.0, 120.0, 25)
    (last,) = _followed(contacts, figure_path, [120.0]).histograms
    upper, lower = _two(figure)
    x, density = coarser(last.stretch_edges, last.stretches, 2 * _FINE)
    upper.plot(x, density, color=INKS[0], lw=0.9, label="$Q_s(x)$, ensemble")
    grid = np.linspace(0.001, 1.3, 800)
    steady = master.steady_state(contacts)
    upper.plot(grid, steady.distribution(grid), "--", color=INKS[1], lw=0.9, label="exact")
    law, mean = contacts.thresholds, contacts.thresholds.mean()
    lower.plot(grid, law.pdf(grid), color=INKS[0], lw=1.0, label="$P_c(x)$")
    far, falls = coarser(last.stretch_edges, last.stretches, 64)
    style: dict[str, Any] = {"ls": "", "marker": "D", "ms": 3, "mfc": "none", "color": INKS[0]}
    lower.plot(
        0.5 * (far[1:] + far[:-1]), -np.diff(falls) / np.diff(far), **style, label="$-dQ_s/dx$"
    )
    lower.plot(
        grid, grid * law.pdf(grid) / mean, ":", color=INKS[2], label="$xP_c/\\langle x_s\\rangle$"
    )
    middle, thresholds = coarser(last.threshold_edges, last.thresholds, 64)
    style |= {"marker": "o", "color": INKS[2]}
    lower.plot(middle, thresholds, **style, label="thresholds that hold")
    lower.set(xlim=(0.75, 1.25), ylim=(-1.0, 10.0))
    lower.legend(fontsize="small")
    upper.legend(fontsize="small", loc="center")
    upper.set(xlabel="$x$", ylabel="$Q_s(x)$", xlim=(-0.05, 1.3))
    lower.set(xlabel="$x$", ylabel="$P_c(x)$, $-dQ_s/dx$")
    return Found(
        "C, the mean travel to a break",
        *(float(steady.cycle_length), 1e-9, float(mean), "C = <x_s>"),
        paper="0.9999",
        remark="The paper's 0.9999 is an error of its grid: C is the mean threshold, 1.",
    )


def _solved(both: Any, shown: Any, path: Any) -> Any:
    """The master equation's Q, above, and F, below."""
    upper, lower = both
    solved: Any = master.solve(_contacts(), path, 1e-8)
    x = np.linspace(-0.12, 1.3, 1200)
    waterfall(upper, ((x, solved.distribution(float(at)).density(x)) for at in shown), 1.0)
    lower.plot(path, solved.force, color=INKS[0], lw=1.0)
    _name(upper, lower)
    return solved


def a03a(figure: Any) -> Found:
    """Short times of the master equation."""
    path = np.linspace(0.0, 3.0, 301)
    solved = _solved(_two(figure), path[:151:5], path)
    exact, rounding = closed_form(_contacts(), path)
    return Found(
        "F_s by the master equation",
        *(float(solved.force.max()), solved.force_error + rounding, float(exact.max())),
        "closed form, Gaussian thresholds",
    )


def a03b(figure: Any) -> Found:
    """Long times of the master equation."""
    shown = 1.09 * np.arange(25)
    _solved(_two(figure), shown, np.linspace(0.0, shown[-1], 801))
    found: Any = master.propensity(_contacts(), tolerance=1e-8)
    mean, std = 1.0, 0.05
    root = (mean - np.sqrt(mean**2 - 4j * np.pi * std**2)) / std**2
    return Found(
        "X*, over which F - F_k decays",
        *(float(found.decoherence_length), 1e-6, float(1.0 / abs(root.real)), "root of p^(s) = 1"),
        paper="~ <x_s>²/std = 20",
        remark="The scaling of the paper does not hold: X* is <x_s>³/(2π² std²) for small std.",
    )


def a03c(figure: Any) -> Found:
    """The steady stretches of both solvers, P_c and the breaking rate P."""
    contacts = _contacts()
    figure.set_size_inches(5.5, 4.5)
    axes = figure.subplots()
    grid = np.linspace(0.0, 1.3, 1301)
    steady = master.steady_state(contacts)
    (last,) = _followed(contacts, np.linspace(0.0, 120.0, 25), [120.0]).histograms
    axes.plot(grid, steady.distribution(grid), color=INKS[0], label="$Q_s$, master equation")
    x, density = coarser(last.stretch_edges, last.stretches, 64)
    axes.plot(x, density, "x", ms=4, color=INKS[0], label="$Q_s$, ensemble")
    law = contacts.thresholds
    axes.plot(grid, law.pdf(grid) / 8.0, ":", color=INKS[2], label="$P_c$/8")
    axes.plot(
        grid, np.exp(law.logpdf(grid) - law.logsf(grid)) / 40.0, "--", color=INKS[1], label="$P$/40"
    )
    axes.set(xlabel="$x$", ylabel="$Q_s(x)$", ylim=(0.0, 1.5), xlim=(-0.05, 1.3))
    axes.legend(fontsize="small")
    return Found(
        "F_k",
        *(float(steady.force), float(steady.force_error) + 1e-12, 0.5 * (1.0 + 0.05**2)),
        "<x_s²>/(2<x_s>)",
    )


def a02d(figure: Any) -> Found:
    """A rectangular P_c: Q_s and the thresholds that hold."""
    contacts = load_scene("rectangular").contacts
    (last,) = _followed(contacts, np.linspace(0.0, 60.0, 25), [60.0]).histograms
    figure.set_size_inches(5.5, 4.5)
    axes = figure.subplots()
    grid = np.linspace(0.0, 1.7, 1701)
    axes.plot(grid, contacts.thresholds.pdf(grid), color=INKS[0], label="$P_c$")
    axes.plot(
        grid, master.steady_state(contacts).distribution(grid), ":", color=INKS[1], label="$Q_s$"
    )
    x, density = coarser(last.threshold_edges, last.thresholds, 2 * _FINE)
    axes.plot(x, density, "--", color=INKS[2], label="$P_{xs}$, ensemble")
    axes.legend(fontsize="small")
    axes.set(xlabel="$x$", ylabel="density", xlim=(0.0, 1.7), ylim=(0.0, 1.7))
    width = np.diff(last.threshold_edges)
    middles = 0.5 * (last.threshold_edges[1:] + last.threshold_edges[:-1])
    mean = float((middles * last.thresholds * width).sum() / (last.thresholds * width).sum())
    spread = np.sqrt(1.25 - (13.0 / 12.0) ** 2) / np.sqrt(_CONTACTS)  # <x_s³>/<x_s> = 1.25
    reference = "<x_s²>/<x_s>: those that hold are chosen by their length"
    return Found("mean threshold of contacts that hold", mean, 5.0 * spread, 13.0 / 12.0, reference)


def _name(upper: Any, lower: Any) -> None:
    lower.set(xlabel="$X$", ylabel=FORCE)
    for axes, letter in ((upper, "a"), (lower, "b")):
        lettered(axes, letter)
