"""Figs. 13 to 15, A04 to A06: contacts that age, by the paper's system (Q15) and one by one."""

from typing import Any

import numpy as np

import master
from origins.contacts import Contacts
from origins.laws.ageing import Ageing
from toolkit.figures.found import FORCE, INKS, Found, lettered
from toolkit.scene.scene import load_scene

_SPRING = 3.5  # N_c<k>, of Fig. A06


def a04(figure: Any) -> Found:
    """P_c(x;X) of (Q15) every 0.05."""
    contacts = load_scene("ageing-paper").contacts
    path = np.linspace(0.0, 2.0, 41)
    found = master.paper_transient(contacts, path, 2.5e-3)
    middle, width = 0.5 * (found.edges[1:] + found.edges[:-1]), np.diff(found.edges)
    figure.set_size_inches(6.0, 5.5)
    axes = figure.subplots()
    for number, weights in enumerate(found.weights):
        late = path[number] > found.outrun
        density = (weights / width)[1:-1]
        style: dict[str, Any] = {"color": "0.7" if late else INKS[0], "lw": 0.7}
        axes.plot(middle[1:-1] + 0.01 * number, density + 0.5 * number, **style)
    axes.set(
        xlabel="$x$ (each moved by 0.01)", ylabel="$P_c(x;X)$ (each moved up)", xlim=(0.2, 1.6)
    )
    axes.set_title(
        f"grey: from X = {found.outrun:.2f} on contacts stand beyond $P_c$", fontsize="small"
    )
    early = found.weights[4][1:-1]
    mean = float((middle[1:-1] * early).sum() / early.sum())
    exact = 1.0 - 0.5 * float(np.exp(-5e-4 / 0.02**2 * path[4]))
    return Found(
        *("mean of P_c at X = 0.2, before contacts break", mean, 2e-4, exact),
        "Ornstein-Uhlenbeck: relaxes as exp(-D_X X/std_f²)",
        remark=f"(Q15) as printed gains {100.0 * found.mass_defect[-1]:.1f} % of mass by X = 2, at every step: from "
        f"a peaked start some contacts stand beyond P_c from X = {found.outrun:.2f} on, and it has no one answer.",
    )


def a05(figure: Any) -> Found:
    """Steady stretches and thresholds of (Q15) at five D_X, and F_k against the speed."""
    contacts = load_scene("ageing-speeds").contacts
    figure.set_size_inches(5.5, 8.5)
    upper, lower = figure.subplots(2, 1)
    inset = lower.inset_axes((0.1, 0.42, 0.42, 0.5))
    x = np.linspace(0.0, 1.1, 1101)
    for ink, diffusion in zip(INKS, (1e-5, 1e-4, 3e-4, 1e-3, 1e-2), strict=False):
        steady: Any = master.steady_state(contacts, velocity=1.0 / diffusion)
        upper.plot(
            x[1:], steady.distribution(x[1:]), color=ink, lw=1.0, label=f"$D_X$ = {diffusion:g}"
        )
        lower.plot(x, steady.thresholds.pdf(x), color=ink, lw=1.0)
        if diffusion == 1e-3:
            found, off = float(steady.force), float(steady.force_error)
    for law, dash in ((contacts.thresholds, "--"), (_of(contacts).final, ":")):
        lower.plot(x, law.pdf(x), dash, color="0.5", lw=1.5)
    speeds = np.geomspace(10.0, 1e6, 41)
    paper = master.kinetic_curve(contacts, speeds).force
    single = master.kinetic_curve(contacts.replace(ageing=_one_by_one(contacts)), speeds).force
    inset.semilogx(speeds, paper, color=INKS[0], lw=1.0, label="(Q15)")
    inset.semilogx(speeds, single, ":", color=INKS[1], lw=1.0, label="one by one")
    inset.set_xlabel("$v/D$")
    inset.text(0.05, 0.6, "$F_k$", transform=inset.transAxes)
    inset.legend(fontsize=6)
    upper.set(xlabel="$x$", ylabel="$Q_s(x)$", xlim=(0.0, 1.1))
    lower.set(xlabel="$x$", ylabel="$P_c(x)$", xlim=(0.0, 1.1), ylim=(0.0, 12.0))
    upper.legend(fontsize="small")
    for axes, letter in ((upper, "a"), (lower, "b")):
        lettered(axes, letter)
    exact, _ = _q15_steady(1e-3)
    crossing = _crossover()
    return Found(
        "F_k of (Q15), D_X = 1e-3",
        found,
        off + 1e-8,
        exact,
        "moments of diffusion with resetting",
        paper="v_aging = 6.5e3 D",
        remark=f"The paper's 6.5e3 D is a fit: ageing and breaking are equally fast at {crossing:.2g} D. Contacts that "
        "age one by one weaken again at slow speeds, as thresholds that fluctuate come down to the stretch.",
    )


def _of(contacts: Contacts) -> Any:
    """The ageing of a shipped scene's contacts."""
    return contacts.ageing


def _one_by_one(contacts: Contacts) -> Ageing:
    """The same ageing of single contacts."""
    own = _of(contacts)
    return Ageing(own.final, own.rate, "exact")


def _q15_steady(diffusion: float) -> tuple[float, float]:
    """F_k and C of (Q15) with Fig. A05's Gaussian laws, 0.5 ± 0.1 to 1 ± 0.01: C = 1 - 0.5 r/(r + rate), r = 1/C."""
    rate, mean = diffusion / 0.01**2, 1.0
    for _ in range(200):  # each step halves the distance at least
        reset = 1.0 / mean
        mean = 0.5 * (mean + 1.0 - 0.5 * reset / (reset + rate))
    reset = 1.0 / mean
    square = 1.0 - reset / (reset + rate) + 0.25 * reset / (reset + 2.0 * rate)
    square += 0.01**2 + (0.1**2 - 0.01**2) * reset / (reset + 2.0 * rate)
    return square / (2.0 * mean), mean


def _crossover() -> float:
    """v/D where rate × C = 1: a contact ages as much as it lives."""
    low, high = 1e3, 1e5
    for _ in range(60):
        middle = np.sqrt(low * high)
        _, mean = _q15_steady(1.0 / middle)
        low, high = (middle, high) if mean / (middle * 0.01**2) > 1.0 else (low, middle)
    return float(low)


def a06(figure: Any) -> Found:
    """F(X) of (Q15) at the paper's two speeds and at a faster one; each slip begins again at Q_ini, as in the paper."""
    contacts = load_scene("ageing-springs").contacts.replace(ageing=None)
    own = _of(load_scene("ageing-springs").contacts)
    contacts = contacts.replace(ageing=Ageing(own.final, own.rate, "paper"))
    figure.set_size_inches(5.5, 8.0)
    for axes, letter, speed in zip(
        figure.subplots(3, 1, sharex=True), "abc", (1.5, 1.6, 2.2), strict=True
    ):
        path = np.linspace(0.0, 3.0, 1201)
        solved = master.paper_transient(contacts, path, 2.5e-3, velocity=speed)
        unique = solved.path < solved.outrun  # beyond, (Q15) has no one answer
        steep = unique & (np.gradient(solved.force, solved.path) <= -_SPRING)
        if steep.any():
            cycle = int(np.argmax(steep)) + 1
            force = np.tile(solved.force[:cycle], path.size // cycle + 1)[: path.size]
        else:
            path, force = solved.path[unique], solved.force[unique]
            axes.text(path[-1], 0.02, " contacts stand beyond $P_c$", color="0.5", fontsize="small")
        axes.plot(path, force, color=INKS[0], lw=1.0)
        axes.set(ylabel=FORCE, ylim=(0.0, 0.8))
        axes.text(0.98, 0.9, f"v = {speed:g}", ha="right", transform=axes.transAxes)
        lettered(axes, letter)
    axes.set_xlabel("$X$")
    critical = master.critical_velocity(contacts, _SPRING, 1.0, 4.0)
    single = master.critical_velocity(load_scene("ageing-springs").contacts, _SPRING, 2.5, 7.0)
    return Found(
        *("v_c of (Q15), K = 3.5 N_c<k>", float(critical.velocity), 0.0, None, ""),
        paper="1.5 to 1.6",
        remark=f"The paper's v_c hangs on its grid: (Q15), converged, gives {critical.velocity:.4f}, and contacts that "
        f"age one by one {single.velocity:.4f}; so (b) sticks and slips, and (c) does not.",
    )
