"""Figs. 21 to 24, the appendices: friction loop (A09), delay (A13), nearly exact thresholds (delta12)."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.polynomial.hermite_e import hermegauss

import master
from origins.laws.delay import Delay
from origins.thresholds.law import Array
from toolkit.figures.found import FORCE, INKS, Found, normal_tail, waterfall
from toolkit.judge.closed_form import closed_form
from toolkit.scene.scene import load_scene


def a09(figure: Any) -> Found:
    """The friction loop, to the right, to the left, to the right again."""
    scene = load_scene("friction-loop-wide")
    solved: Any = master.solve(scene.contacts, scene.path, 1e-8)
    figure.set_size_inches(5.5, 4.5)
    axes = figure.subplots()
    axes.plot(solved.path, solved.force, color=INKS[0], lw=1.1)
    for where in (15, 210, 470):  # in the middle of each leg, roughly
        there: dict[str, Any] = {"xytext": (solved.path[where], solved.force[where])}
        there["arrowprops"] = {"arrowstyle": "-|>", "color": INKS[2], "lw": 2, "mutation_scale": 22}
        axes.annotate("", (solved.path[where + 12], solved.force[where + 12]), **there)
    axes.set(xlabel="$X$", ylabel=FORCE)
    turn = int(np.argmax(solved.path))
    return Found(
        *("F at the first turn, X = 3", float(solved.force[turn])),
        *(
            2e-6,
            _gaussian_force(3.0, 0.2, 0.025),
        ),  # those cut at 0, 3e-7 of all, move it by a few times as much
        "closed form, Gaussian thresholds",
        remark="Turning points are our own choice. P_b(x) = P(-x) as printed forgets each contact's largest stretch: "
        "its loop is off by 0.04 at ±3 and by 0.18 at ±0.9 (docs/sliders.md).",
    )


def _gaussian_force(at: float, std: float, spread: float) -> float:
    """F at X from starts 0 ± spread, thresholds 1 ± std: X less the released thresholds."""
    force = at
    for count in range(1, 30):
        w = np.sqrt(count * std**2 + spread**2)
        z = (at - count) / w
        force -= normal_tail(-z) - std**2 / w * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
    return float(force)


def a13a(figure: Any) -> Found:
    """F(X) with several delays."""
    scene = load_scene("delay")
    figure.set_size_inches(5.5, 4.5)
    axes, path = figure.subplots(), np.linspace(0.0, 6.0, 601)
    dashes = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)))
    for ink, dash, wait in zip(INKS, dashes, (0.0, 0.2, 0.4, 0.8, 1.2), strict=False):
        delay = Delay(wait) if wait else None
        solved: Any = master.solve(scene.contacts.replace(delay=delay), path, 1e-8)
        axes.plot(path, solved.force, ls=dash, color=ink, lw=1.2, label=f"{wait:g}")
    axes.set(xlabel="$X$", ylabel=FORCE, xlim=(0.0, 6.0))
    # above the curves
    axes.set_ylim(axes.get_ylim()[0], 0.85)
    axes.legend(title="$\\Delta X_m$", fontsize="small", loc="upper right", ncols=5)
    nodes, weights = hermegauss(40)  # over the start, 0.1 ± 0.025; none has re-formed by X = 1
    x = 1.1 + 0.025 * nodes
    exact = float((weights / weights.sum()) @ (x * normal_tail((x - 1.0) / 0.2)))
    return Found(
        *("F at X = 1, delay 1.2", float(solved.force[100]), 1e-5, exact),
        "those of the start that hold, by quadrature",
    )


def a13b(figure: Any) -> Found:
    """Contacts that hold, and F_k, against the delay."""
    contacts = load_scene("delays").contacts
    figure.set_size_inches(5.5, 4.5)
    axes, waits = figure.subplots(), np.linspace(0.0, 2.0, 81)
    curve = master.kinetic_curve(contacts, delay=waits)
    axes.plot(waits, 1.0 / (1.0 + waits), color=INKS[0], lw=1.0, label="$1/(1 + \\Delta X_m)$")
    some = slice(None, None, 8)
    axes.plot(waits[some], curve.holding[some], "o", color=INKS[2], label="$N_c(\\infty)/N_c(0)$")
    axes.plot(waits[some], curve.force[some], "D", color=INKS[0], label="$F_k$")
    axes.set(xlabel="$\\Delta X_m$", ylim=(0.0, 1.05))
    axes.legend(fontsize="small")
    return Found(
        *("N_c(∞)/N_c(0), delay 1.2", float(curve.holding[48]), 1e-6, 1.0 / 2.2),
        "C/(C + delay), C = 1",
        paper="F_k depends on the history",
        remark="At a fixed total number of contacts N_c(∞), and with it F_k, does not depend on the history.",
    )


def delta12(figure: Any) -> Found:
    """One and two narrow peaks: stretches above, force below."""
    figure.set_size_inches(10.0, 7.5)
    rows = figure.subplots(2, 2, height_ratios=(1.6, 1.0))
    for column, name in enumerate(("one-peak", "two-peaks")):
        scene = load_scene(name)
        path = np.linspace(0.0, 50.0, 2001)
        solved: Any = master.solve(scene.contacts, path, 1e-8)
        x = np.linspace(-0.02, 1.2, 1600)
        waterfall(rows[0][column], _shown(solved, x), 1.5)
        rows[0][column].plot(x, scene.contacts.thresholds.pdf(x) / 30.0, ":", color=INKS[2], lw=1.0)
        rows[0][column].set_title(scene.title, fontsize="small")
        rows[1][column].plot(path, solved.force, color=INKS[0], lw=0.7)
        rows[1][column].set(xlabel="$X$", ylabel=FORCE, ylim=(0.0, 1.05))
        if name == "one-peak":
            exact, rounding = closed_form(scene.contacts, path)
            worst = int(np.abs(solved.force - exact).argmax())
            found = float(solved.force[worst]), float(solved.force_error) + rounding
    return Found(
        f"F of one peak at X = {path[worst]:g}, where it is off most",
        *(*found, float(exact[worst]), "closed form, Gaussian thresholds"),
        paper="two values always decay",
        remark="Two exact values decay only if they have no common divisor: those at 0.95 and 1.05 would keep a "
        "sawtooth of ±0.025 for ever; with the width of 1e-3 drawn here it decays over 127 thresholds.",
    )


def _shown(solved: Any, x: Array) -> Iterator[tuple[Array, Array]]:
    """Q(x;X) every two thresholds, each with its grid."""
    for at in np.arange(0.0, 50.5, 2.0):
        yield x, solved.distribution(float(at)).density(x)
