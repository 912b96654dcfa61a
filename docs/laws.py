"""The pictures and the numbers of docs/laws.md: python docs/laws.py"""

from pathlib import Path
from typing import Any

import numpy as np

import master
import origins
from master.paper.q15_transient import AgeingTransient, paper_transient
from toolkit.pictures.axes import OKABE_ITO

PICTURES = Path(__file__).parent / "pictures"
BLUE, RED, GREEN, PURPLE, GREY = (*OKABE_ITO[:4], "0.55")
FORCE = r"$F_k/(N_c\langle k\rangle)$"
FORCE_OF_X = r"$F/(N_c\langle k\rangle)$"

# Figs. A08 and A13 of the paper
NARROW, WIDE = origins.gaussian(1.0, 0.05), origins.gaussian(1.0, 0.2)
START = origins.gaussian_start(0.1, 0.025)
# Fig. 24 (delta12), right column
PEAKS = origins.Contacts(
    origins.mixture([origins.gaussian(0.95, 1e-3), origins.gaussian(1.05, 1e-3)], [0.5, 0.5]), START
)


def a04(closure: str) -> origins.Contacts:
    """Fig. A04, D_X = 5e-4 at v = 1."""
    ageing = origins.Ageing(origins.gaussian(1.0, 0.02), 5e-4, closure)  # type: ignore[arg-type]
    return origins.Contacts(origins.gaussian(0.5, 0.05), START, ageing=ageing)


def a05(closure: str) -> origins.Contacts:
    """Fig. A05; with D = 1, D_X = 1/v."""
    ageing = origins.Ageing(origins.gaussian(1.0, 0.01), 1.0, closure)  # type: ignore[arg-type]
    return origins.Contacts(origins.gaussian(0.5, 0.1), ageing=ageing)


def a06(closure: str) -> origins.Contacts:
    """Fig. A06; the spring is 3.5 N_c <k>."""
    ageing = origins.Ageing(origins.gaussian(1.0, 0.02), 5e-4, closure)  # type: ignore[arg-type]
    return origins.Contacts(
        origins.gaussian(0.5, 0.05), origins.gaussian_start(0.02, 0.01), ageing=ageing
    )


def warm(
    law: str, temperature: float, closure: str = "exact", start: object = None
) -> origins.Contacts:
    """Fig. A08c."""
    thermal = origins.Thermal(law, temperature, closure=closure)  # type: ignore[arg-type]
    return origins.Contacts(NARROW, start, thermal=thermal)


def transient(end: float = 2.5, step: float = 2.5e-3) -> dict[str, AgeingTransient]:
    """(Q15) along Fig. A04, keyed by which of mass and sign is kept where both cannot be."""
    path = np.arange(0.0, end + 1e-9, 0.01)
    keeps: tuple[Any, ...] = ("positivity", "mass")
    return {keep: paper_transient(a04("paper"), path, step, keep=keep) for keep in keeps}


def fit(v: np.ndarray, at_rest: float, fast: float, crossover: float) -> np.ndarray:
    """Eq. fitFv: between F_k(0) and F_k(inf), half way at v = crossover."""
    return fast + (at_rest - fast) / (1.0 + v / crossover)


def draw_ageing() -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.5, 7.4), layout="constrained")
    axes = figure.subplots(2, 3)
    _draw_a04(axes[0])
    _draw_a05(axes[1, 0], axes[1, 1])
    _draw_a06(axes[1, 2])
    figure.savefig(PICTURES / "laws_ageing.png", dpi=130)


def _draw_a04(axes: Any) -> None:
    """Fig. A04: P_c(x; X) of the paper's equation (Q15), its force beside the exact one, and what it does not keep."""
    found = transient()
    kept = found["positivity"]
    exact = master.solve(a04("exact"), kept.path, 1e-8)
    late = kept.path <= kept.outrun
    print(
        f"A04: exact F(X) to {exact.force_error:.0e}; (Q15) outrun from X = {kept.outrun:.3f}, ",
        end="",
    )
    print(f"before it (Q15) is off by {np.abs(kept.force - exact.force)[late].max():.3f}, ", end="")
    print(
        f"mass gained in the end {kept.mass_defect[-1]:.3f}; with mass kept it ends at {found['mass'].path[-1]:.2f}"
    )
    axes[0].set(
        title="Fig. 13: one $P_c(x;X)$ of (Q15), every 0.1", xlabel="threshold $x$", ylabel="$P_c$"
    )
    middle, width = 0.5 * (kept.edges[1:] + kept.edges[:-1]), np.diff(kept.edges)
    for number, i in enumerate(range(0, int(late.sum()), 10)):
        ink = (0.12 + 0.06 * number, 0.31, 0.47 + 0.04 * number)
        axes[0].plot(middle[1:-1], (kept.weights[i] / width)[1:-1], color=ink, lw=1.1)
    steady = master.steady_state(a04("paper")).thresholds
    x = np.linspace(0.25, 1.1, 401)
    axes[0].plot(x, steady.pdf(x), color="k", lw=1.2, ls=":", label="steady")
    axes[0].set_xlim(0.25, 1.1)
    axes[0].annotate("X = 0", (0.33, 7.2), color=BLUE)
    axes[0].annotate(f"X = {kept.path[10 * number]:.1f}", (0.84, 6.5), color=ink)
    axes[0].legend(fontsize="small", loc="upper left")
    axes[1].plot(kept.path, exact.force, color=BLUE, lw=1.5, label="each its own threshold: exact")
    axes[1].plot(kept.path, kept.force, color=RED, lw=1.2, ls="--", label="(Q15), sign kept")
    mass = found["mass"]
    axes[1].plot(
        mass.path, mass.force, color=GREEN, lw=2.0, ls=":", label="(Q15), mass kept, ends here"
    )
    axes[1].plot(mass.path[-1], mass.force[-1], "x", color=GREEN, ms=8, mew=2)
    for ax in axes[1:]:
        ax.axvspan(kept.outrun, kept.path[-1], color="0.93", lw=0)
    axes[1].set(
        title="Fig. 13: force",
        xlabel="position $X$",
        ylabel=r"$F/(N_c\langle k\rangle)$",
        ylim=(0.05, 0.92),
    )
    axes[1].legend(fontsize="small", loc="upper right")
    axes[2].plot(
        kept.path, kept.mass_defect, color=RED, lw=1.2, ls="--", label="sign kept: mass less 1"
    )
    axes[2].plot(
        mass.path,
        mass.positivity_defect,
        color=GREEN,
        lw=2.0,
        ls=":",
        label="mass kept: weight below 0",
    )
    axes[2].set(title="Fig. 13: what (Q15) does not keep", xlabel="position $X$", ylabel="defect")
    axes[2].annotate("contacts outrun $P_c$", (0.45, 0.2), xycoords="axes fraction", color="0.4")
    axes[2].legend(fontsize="x-small", loc="center right", handlelength=1.5)


def _draw_a05(histogram: Any, curve: Any) -> None:
    """Fig. A05: the steady thresholds of (Q15), and the kinetic force against the speed by both closures."""
    x = np.linspace(0.2, 1.1, 901)
    for number, diffusion in enumerate((1e-5, 1e-4, 3e-4, 1e-3, 1e-2)):
        steady = master.steady_state(a05("paper"), velocity=1.0 / diffusion)
        ink = (0.12 + 0.15 * number, 0.31, 0.5 - 0.05 * number)
        histogram.plot(x, steady.thresholds.pdf(x), color=ink, lw=1.2, label=f"{diffusion:g}")
        print(
            f"A05: D_X = {diffusion:g}: F_k = {steady.force:.10f} +- {0.5 * steady.force_error:.0e} (Q15)"
        )
    histogram.set(
        title="Fig. 14: steady $P_c$ of (Q15)", xlabel="threshold $x$", ylabel="$P_c$", yscale="log"
    )
    histogram.set(ylim=(1e-3, 3e3))
    histogram.legend(title="$D_X$", fontsize="small", loc="upper center", ncols=3)
    v = np.geomspace(1.0, 1e7, 57)
    exact, paper = (master.kinetic_curve(a05(closure), v) for closure in ("exact", "paper"))
    print(
        f"A05: F_k(v) at {v.size} speeds, exact to {exact.force_error.max():.0e} in {exact.run_time:.1f} s, ",
        end="",
    )
    print(f"(Q15) to {paper.force_error.max():.0e} in {paper.run_time:.1f} s")
    laws = origins.gaussian(1.0, 0.01), origins.gaussian(0.5, 0.1)
    final, fresh = (0.5 * law.moment(2) / law.mean() for law in laws)
    curve.semilogx(v, exact.force, color=BLUE, lw=1.5, label="exact")
    curve.semilogx(v, paper.force, color=RED, lw=1.3, ls="--", label="(Q15)")
    curve.semilogx(
        v, fit(v, final, fresh, 6.5e3), color=GREY, lw=1.0, label="the paper's fit, 6.5e3 D"
    )
    curve.axvline(7.5e3, color=GREY, lw=0.8, ls=":")
    curve.annotate("7.5e3 D", (9e3, 0.47), color="0.4")
    curve.set(title="Fig. 14: kinetic force", xlabel="speed $v/D = 1/D_X$", ylabel=FORCE)
    curve.legend(fontsize="small", loc="lower left")


def _draw_a06(axes: Any) -> None:
    """Fig. A06: the spring K* below which sliding is stick-slip against the speed, by both closures."""
    v = np.geomspace(1.5, 12.0, 15)
    line = master.phase_line(a06("exact"), v, tolerance=1e-4)
    axes.semilogx(v, line.critical_spring, color=BLUE, lw=1.5, label="exact")
    print(f"A06: K*(v), exact, to {line.critical_spring_error.max():.0e}")
    found = [
        (spring, master.critical_velocity(a06("paper"), spring, 1.0, 4.0))
        for spring in (3.0, 3.5, 4.0)
    ]
    axes.plot(
        [v.velocity for _, v in found],
        [k for k, _ in found],
        "o--",
        color=RED,
        lw=1.3,
        label="(Q15)",
    )
    exact = master.critical_velocity(a06("exact"), 3.5, 2.5, 7.0)
    for closure, critical in (("exact", exact), ("(Q15)", found[1][1])):
        print(f"A06: v_c = {critical.velocity:.5f} +- {critical.velocity_error:.0e}, {closure}")
    axes.axhline(3.5, color=GREY, lw=0.8)
    axes.plot([1.5, 1.6], [3.5, 3.5], color="k", lw=4, label="the paper: 1.5 to 1.6")
    axes.annotate("smooth sliding", (0.6, 0.6), xycoords="axes fraction", color="0.3")
    axes.annotate("stick-slip", (0.03, 0.04), xycoords="axes fraction", color="0.3")
    axes.set(
        title="Fig. 15: where ageing ends stick-slip",
        xlabel="speed $v$",
        ylabel=r"$K^*/(N_c\langle k\rangle)$",
    )
    axes.set(xticks=[1.5, 2, 3, 4, 6, 10], xticklabels=["1.5", "2", "3", "4", "6", "10"])
    axes.minorticks_off()
    axes.legend(fontsize="small")


def draw_stick_slip() -> None:
    """Fig. A06 as a spring sees it: the drive's own clock, every slip a reset to relaxed contacts."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.5, 3.9), layout="constrained")
    axes = figure.subplots()
    for velocity, ink in ((1.5, BLUE), (6.0, GREEN), (15.0, RED)):
        path = np.linspace(0.0, 3.0, 601)[6:]
        solved = master.solve(a06("exact"), path, 1e-3, velocity=velocity, spring=3.5)
        slips = solved.slips
        told = (
            f"{slips.drive.size} slips, period {solved.period:.6f}" if solved.period else "no slip"
        )
        print(
            f"A06: v = {velocity:g}: {told}, F to {solved.force_error:.0e} of <x_s> in {solved.run_time:.0f} s"
        )
        # before and after a slip at one place
        at = np.concatenate([path, slips.drive, slips.drive])
        force = np.concatenate([solved.force, slips.force_before, slips.force_after])
        order = np.lexsort(
            (np.repeat([1, 0, 2], [path.size, slips.drive.size, slips.drive.size]), at)
        )
        axes.plot(at[order], force[order], color=ink, lw=1.4, label=f"v = {velocity:g}")
    axes.set(
        title="Fig. 15: a spring of 3.5 $N_c\\langle k\\rangle$, contacts that age",
        xlabel="drive $X_T$",
        ylabel=FORCE_OF_X,
    )
    axes.set(xlim=(0.0, 3.0), ylim=(-0.02, 0.85))
    axes.legend(fontsize="small", loc="upper right", ncols=3)
    figure.savefig(PICTURES / "laws_stick_slip.png", dpi=130)


def draw_temperature() -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.5, 7.4), layout="constrained")
    axes = figure.subplots(2, 2)
    _draw_speeds(axes[0, 0])
    _draw_temperatures(axes[0, 1])
    _draw_line(axes[1, 0])
    _draw_delay(axes[1, 1])
    figure.savefig(PICTURES / "laws_temperature.png", dpi=130)


TEMPERATURES = ((0.01, BLUE), (0.1, GREEN), (0.3, PURPLE), (1.0, RED))
STYLES = (("soft", "-"), ("stiff", "--"))


def _draw_speeds(axes: Any) -> None:
    """F_k against the speed at four temperatures, of soft and of stiff contacts, and by the paper's closure."""
    v = np.geomspace(1e-4, 1e4, 200)
    for temperature, ink in TEMPERATURES:
        for law, dashes in STYLES:
            curve = master.kinetic_curve(warm(law, temperature), v)
            told = f"to {curve.force_error.max():.0e} in {curve.run_time:.2f} s"
            print(f"A08c: F_k(v), {law}, T = {temperature:g}: {told}")
            label = f"T = {temperature:g}" if law == "soft" else None
            axes.semilogx(v, curve.force, color=ink, ls=dashes, lw=1.4, label=label)
    few = np.geomspace(1e-3, 1e3, 13)
    paper = master.kinetic_curve(warm("soft", 0.3, "paper"), few)
    axes.semilogx(
        few,
        paper.force,
        "o",
        color=PURPLE,
        ms=4,
        mfc="none",
        label="T = 0.3, the paper's closure",
    )
    axes.set(
        title="Fig. 10: soft contacts, dashed stiff",
        xlabel=r"speed $v$ ($\omega = 1$)",
        ylabel=FORCE,
    )
    axes.legend(fontsize="small")


def _draw_temperatures(axes: Any) -> None:
    temperatures = np.geomspace(1e-3, 10.0, 60)
    for velocity, ink in ((0.01, BLUE), (0.1, GREEN), (1.0, PURPLE), (10.0, RED)):
        for law, dashes in STYLES:
            curve = master.kinetic_curve(warm(law, 1.0), velocity, temperature=temperatures)
            label = f"v = {velocity:g}" if law == "soft" else None
            axes.semilogx(temperatures, curve.force, color=ink, ls=dashes, lw=1.4, label=label)
    told = f"to {curve.force_error.max():.0e} in {curve.run_time:.1f} s"
    print(f"A08c: F_k(T) at {temperatures.size} temperatures: {told}")
    axes.set(
        title="Fig. 10: soft contacts, dashed stiff",
        xlabel=r"temperature $T = k_BT/\langle k\rangle$",
        ylabel=FORCE,
    )
    axes.legend(fontsize="small")


def _draw_line(axes: Any) -> None:
    """K* against the speed at the same temperatures, and at T = 0."""
    v = np.geomspace(1e-4, 1e4, 33)
    for temperature, ink in TEMPERATURES:
        for law, dashes in STYLES:
            line = master.phase_line(warm(law, 1.0), v, temperature=temperature)
            label = f"T = {temperature:g}" if law == "soft" else None
            axes.semilogx(v, line.critical_spring, color=ink, ls=dashes, lw=1.4, label=label)
            told = f"to {line.critical_spring_error.max():.0e} in {line.run_time:.1f} s"
            print(f"K*(v), {law}, T = {temperature:g}: {told}")
    cold = master.phase_line(origins.Contacts(NARROW))
    axes.axhline(float(cold.critical_spring), color=GREY, lw=0.8)
    axes.annotate("T = 0", (1.2e-4, float(cold.critical_spring) - 0.45), color="0.4")
    axes.set(
        title="below a line the slider slips, above it slides smoothly",
        xlabel=r"speed $v$ ($\omega = 1$)",
    )
    axes.set(ylabel=r"$K^*/(N_c\langle k\rangle)$")
    axes.legend(fontsize="small", loc="lower right")


def _draw_delay(axes: Any) -> None:
    """The share of contacts that hold, and F_k, against the drive's way in a delay; and both of F(X) followed far."""
    waits = np.linspace(0.0, 3.0, 121)
    curve = master.kinetic_curve(origins.Contacts(WIDE), delay=waits)
    print(f"A13b: N_c to {curve.holding_error.max():.0e}, F_k to {curve.force_error.max():.0e}")
    axes.plot(
        waits, curve.holding, color=BLUE, lw=1.5, label=r"$N_c(\infty)/N_c(0) = C/(C + v\tau_m)$"
    )
    axes.plot(waits, curve.force, color=RED, lw=1.5, label=FORCE)
    some = np.array([0.2, 0.4, 0.8, 1.2])
    late = [
        master.solve(origins.Contacts(WIDE, START, delay=origins.Delay(float(wait))), [300.0], 1e-8)
        for wait in some
    ]
    told = "F(X) followed to X = 300"
    axes.plot(some, [one.holding[0] for one in late], "o", color=BLUE, mfc="none", ms=6, label=told)
    axes.plot(some, [one.force[0] for one in late], "o", color=RED, mfc="none", ms=6)
    axes.set(
        title="Fig. 23: a delay",
        xlabel=r"way of the drive in a delay, $\Delta X_m = v\tau_m$",
        ylim=(0.0, 1.05),
    )
    axes.legend(fontsize="small")


def draw_decoherence() -> None:
    """The force after the start beside the sum of its slowest terms, and the error that the spectrum estimates."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.5, 3.9), layout="constrained")
    axes = figure.subplots(1, 3, width_ratios=(1, 1.2, 1.2))
    for std, ink in ((0.05, BLUE), (0.1, GREEN), (0.2, RED)):
        found = master.decoherence_spectrum(origins.Contacts(origins.gaussian(1.0, std)), n_roots=8)
        axes[0].loglog(
            found.period,
            found.decay_length,
            "o-",
            color=ink,
            ms=4,
            lw=0.8,
            label=f"one peak, std {std:g}",
        )
        print(
            f"spectrum, std {std:g}: X* = {found.decay_length[0]:.10g} +- {found.decay_length_error[0]:.0e}"
        )
    found = master.decoherence_spectrum(PEAKS, n_roots=60)
    print(
        f"spectrum, two peaks: {found.roots.size} roots in {found.run_time:.1f} s; slowest: period ",
        end="",
    )
    print(
        f"{found.period[0]:.6f}, X* = {found.decay_length[0]:.4f} +- {found.decay_length_error[0]:.0e}, ",
        end="",
    )
    print(f"|c| = {abs(found.amplitude[0]):.1e}; first harmonic: ", end="")
    first = int(np.argmin(np.abs(found.period - 1.0)))
    print(f"X* = {found.decay_length[first]:.4f}, |c| = {abs(found.amplitude[first]):.3f}")
    axes[0].loglog(
        found.period, found.decay_length, "x", color="k", ms=5, label="two peaks of Fig. 24"
    )
    axes[0].set(
        title="roots of $\\hat p(s) = 1$",
        xlabel="period (units of length)",
        ylabel="decay length (units of length)",
        ylim=(0.1, 1e4),
    )
    axes[0].legend(fontsize="small", loc="upper left")
    x = np.linspace(0.0, 50.0, 4001)
    solved = master.solve(PEAKS, x, 1e-9)
    axes[1].plot(x, solved.force, color=BLUE, lw=0.7, label="master equation")
    envelope = abs(found.amplitude[first]) * np.exp(-x / found.decay_length[first])
    for sign, label in (
        (-1.0, None),
        (1.0, f"first harmonic, X* = {found.decay_length[first]:.1f}"),
    ):
        axes[1].plot(
            x, found.kinetic_force + sign * envelope, color=RED, lw=1.2, ls="--", label=label
        )
    axes[1].set(
        title="Fig. 24, two peaks", xlabel="position $X$", ylabel=r"$F/(N_c\langle k\rangle)$"
    )
    axes[1].legend(fontsize="small", loc="upper right")
    late = x[x >= 2.0]
    off = np.abs(found.force(late) - solved.force[x >= 2.0])
    axes[2].semilogy(
        late, np.maximum(off, 1e-17), color=BLUE, lw=0.6, label="60 roots less master equation"
    )
    axes[2].semilogy(
        late, found.force_error(late), color=RED, lw=1.2, label="error estimated with them"
    )
    axes[2].set(
        title="the sum of 60 terms",
        xlabel="position $X$",
        ylabel=r"$|\Delta F|/(N_c\langle k\rangle)$",
    )
    axes[2].set_ylim(1e-12, 1e2)
    axes[2].legend(fontsize="small")
    figure.savefig(PICTURES / "decoherence.png", dpi=130)


if __name__ == "__main__":
    draw_ageing()
    draw_stick_slip()
    draw_temperature()
    draw_decoherence()
