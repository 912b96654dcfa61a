"""Figs. 16 to 19: thresholds of rough surfaces (A10, figPcPersson) and of grains (A12)."""

from math import gamma
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss

import master
import origins
from origins.contacts import Contacts
from origins.thresholds.law import Array
from toolkit.figures.found import FORCE, INKS, Found
from toolkit.scene.scene import load_scene


def _pair(figure: Any, scenes: tuple[str, str], names: tuple[str, str]) -> list[Any]:
    """F(X) of two scenes, full and broken, with their P_c in an inset; both solutions."""
    figure.set_size_inches(5.5, 4.5)
    axes = figure.subplots()
    inset, x, found = axes.inset_axes((0.5, 0.67, 0.45, 0.3)), np.linspace(0.0, 2.5, 501), []
    for scene, name, dash in zip(scenes, names, ("-", "--"), strict=True):
        loaded = load_scene(scene)
        solved: Any = master.solve(loaded.contacts, loaded.path, 1e-8)
        axes.plot(solved.path, solved.force, dash, color=INKS[0], label=name)
        inset.plot(x, loaded.contacts.thresholds.pdf(x), dash, color=INKS[0])
        found.append(solved)
    inset.set(xlabel="$x$", ylabel="$P_c(x)$")
    top = 2.0 * max(
        float(solved.force.max()) for solved in found
    )  # the inset stands above the curves
    axes.set(xlabel="$X$", ylabel=FORCE, xlim=(0.0, 5.0), ylim=(0.0, top))
    axes.legend(loc="upper left", fontsize="small")
    return found


def _weibull_force(shape: float, scale: float) -> float:
    """F_k = <x_s²>/(2<x_s>) of a Weibull law."""
    return scale * gamma(1.0 + 2.0 / shape) / (2.0 * gamma(1.0 + 1.0 / shape))


def a10a(figure: Any) -> Found:
    """Exponential heights, elastic and plastic contacts."""
    names = "elastic, B' = 1.588", "plastic, B'' = 1.251"
    elastic, plastic = _pair(figure, ("gw-elastic", "gw-plastic"), names)
    exact = _weibull_force(4.0 / 3.0, 1.588**-0.75)
    above = [100.0 * (one.force.max() / one.force[-1] - 1.0) for one in (elastic, plastic)]
    return Found(
        *("F at X = 5, elastic, steady sliding", float(elastic.force[-1]), 1e-4),
        *(exact, "F_k of a Weibull law of shape 4/3"),
        paper="F rises (almost) monotonically",
        remark=f"Almost: F passes F_k by {above[0]:.1g} % and {above[1]:.1g} %. (GW3) takes f_s ~ A beside Hertz' "
        "f_s ~ A^(3/2): with the latter P_c is exponential.",
    )


def a10b(figure: Any) -> Found:
    """F_k against B, with its powers in an inset."""
    figure.set_size_inches(5.5, 4.5)
    axes, scales = figure.subplots(), np.geomspace(0.3, 30.0, 25)
    inset, powers = axes.inset_axes((0.45, 0.45, 0.5, 0.48)), []
    for law, dash, name in (
        (origins.gw_elastic, "-", "elastic"),
        (origins.gw_plastic, "--", "plastic"),
    ):
        force = np.array([master.steady_state(Contacts(law(b))).force for b in scales])
        power, level = np.polyfit(np.log(scales), np.log(force), 1)
        axes.plot(scales, force, dash, color=INKS[0], label=name)
        inset.loglog(scales, force, dash, color=INKS[0])
        inset.loglog(scales, np.exp(level) * scales**power, ":", color=INKS[2])
        powers.append(float(power))
    axes.set(xlabel="$B$", ylabel=r"$F_k/(N_c\langle k\rangle)$", xlim=(0.0, 10.0))
    axes.legend(fontsize="small", loc=(0.7, 0.2))
    reference = "x_s ~ B^(-3/4); plastic -1/2"
    return Found(
        "power of F_k(B), elastic", powers[0], 1e-9, -0.75, reference, paper="-3/4 and -1/2"
    )


def persson(figure: Any) -> Found:
    """Persson's thresholds of two widths."""
    _pair(figure, ("persson", "persson-wide"), ("width 0.5", "width 1"))
    late: Any = master.solve(load_scene("persson-wide").contacts, [200.0], 1e-8)
    x, weights = _nodes(0.0, 3.5)
    density = x * (np.exp(-((x * x - 1.0) ** 2)) - np.exp(-((x * x + 1.0) ** 2)))
    exact = float((weights * x * x * density).sum() / (2.0 * (weights * x * density).sum()))
    return Found(
        *("F at X = 200, width 1", float(late.force[0]), 1e-6, exact),
        "<x_s²>/(2<x_s>), quadrature of Eq. PcPersson3",
    )


def a12(figure: Any) -> Found:
    """P_c of grains at several times; dotted with the exact Jacobian."""
    figure.set_size_inches(5.5, 4.5)
    axes, x = figure.subplots(), np.linspace(0.0, 3.5, 1401)
    for ink, time in zip(INKS, (0.6, 1.0, 2.0, 4.0, 8.0), strict=False):
        forms: tuple[tuple[Any, str], ...] = (("paper", "-"), ("exact", ":"))
        for jacobian, dash in forms:
            law = origins.grains(alpha=1.0, time=time, B=1.0, jacobian=jacobian)
            name = f"t = {time:g}" if jacobian == "paper" else None
            axes.plot(x, law.pdf(x), dash, color=ink, lw=1.2, label=name)
            if time == 1.0 and jacobian == "paper":
                found = float(law.mean())
    axes.set(xlabel="$x$", ylabel="$P_c(x)$", ylim=(0.0, None), xlim=(0.0, 3.5))
    for name, dash in (("as printed", "-"), ("with the Jacobian", ":")):
        axes.plot([], [], dash, color="0.3", lw=1.2, label=name)
    axes.legend(fontsize="small")
    axes.set_title(r"numbers without unit: $\alpha$ = $B$ = 1", fontsize="small")
    place, weights = _nodes(0.0, np.sqrt(1.25))
    u = np.sqrt(1.0 + place * place)
    # the density vanishes with all its derivatives at the end, where 1 - 2u/3 = 0
    density = u * u * np.exp(-1.0 / (1.0 - 2.0 * u / 3.0))
    density /= (u + 3.0) ** (7.0 / 3.0) * (1.5 - u) ** (11.0 / 3.0)
    exact = float((weights * place * density).sum() / (weights * density).sum())
    return Found(
        *("<x_s> at t = 1, as printed", found, 1e-8, exact, "quadrature of Eqs. LS1, LS2"),
        remark="Times are our own choice. P_c = P_LS(u) as printed leaves out the Jacobian; with it (dotted) P_c(0) "
        "is 0.",
    )


def _nodes(low: float, high: float) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights."""
    nodes, weights = leggauss(300)
    return low + 0.5 * (high - low) * (nodes + 1.0), 0.5 * (high - low) * weights
