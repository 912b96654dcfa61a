"""The pictures and the numbers of docs/sliders.md: python docs/sliders.py"""

from pathlib import Path

import numpy as np

import eq_model
import master
import origins
from master.paper.explicit import explicit_loop
from toolkit.pictures.axes import DASHES, OKABE_ITO, legend_above, name_axis, style_of

PICTURES = Path(__file__).parent / "pictures"
CONTACTS = origins.Contacts(origins.gaussian(1.0, 0.2), origins.gaussian_start(0.0, 0.025))
SPRING = 0.5
NARROW, SIZES = origins.Contacts(origins.gaussian(1.0, 0.05)), (4_000, 32_000, 256_000)
RULES = ("reset", "reform-after", "instant")
MEAN = r"($\langle x_s\rangle$)"  # the unit of lengths, and of forces over N_c <k>
FORCE = rf"force $F/(N_c\langle k\rangle)$ {MEAN}"


def loop(amplitude: float, points: int = 601) -> np.ndarray:
    """0, amplitude, -amplitude, amplitude."""
    ends = amplitude * np.array([0.0, 1.0, -1.0, 1.0])
    travelled = np.append(0.0, np.abs(np.diff(ends)).cumsum())
    return np.interp(np.linspace(0.0, travelled[-1], points), travelled, ends)


def both(amplitude: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The path, F by exact cohorts, and F by the paper's closure, its steps extrapolated."""
    path = loop(amplitude)
    coarse, fine = (explicit_loop(CONTACTS, path, amplitude / n).force for n in (300, 600))
    return path, master.solve(CONTACTS, path, 1e-8).force, 2.0 * fine - coarse


def static_force(temperature: float, hold: float, tolerance: float = 1e-6) -> float:
    """The largest force on the way after two thresholds at speed 1 and a hold, of soft contacts with ω = 1."""
    contacts = origins.Contacts(
        origins.gaussian(1.0, 0.2), thermal=origins.Thermal("soft", temperature)
    )
    after = np.linspace(0.02, 2.0, 100)
    path, time = (
        np.concatenate([[2.0, 2.0], 2.0 + after]),
        np.concatenate([[2.0, 2.0 + hold], 2.0 + hold + after]),
    )
    found = master.solve(contacts, path, tolerance, time=time)
    if not found.success:
        raise RuntimeError(found.message)
    return float(found.force[2:].max())


def draw_holds() -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 3.8), layout="constrained")
    ax = figure.subplots()
    holds = np.logspace(0.0, 8.0, 17)
    for number, temperature in enumerate((0.03, 0.1, 0.3)):
        forces = [static_force(temperature, hold, 1e-5) for hold in holds]
        label = rf"$T$ = {temperature} $\langle x_s\rangle^2$"
        ax.semilogx(holds, forces, **style_of(number), ms=4, lw=1.4, label=label)
    ax.set(xlabel=r"time of the hold ($1/\omega$)", ylabel=f"static {FORCE}")
    legend_above(ax, "soft contacts, after a hold", 140)
    figure.savefig(PICTURES / "holds.png", dpi=130)


def of_slips(slips: eq_model.CoupledSlips, replicas: int) -> np.ndarray:
    """X_T of the first three slips, the two periods between them and their three drops, of each replica."""
    drive, drop = (values.reshape(replicas, -1)[:, :3] for values in (slips.drive, slips.drop))
    return np.hstack([drive, np.diff(drive), drop])


def finite_numbers(contacts_each: int = 128_000_000) -> list[tuple[np.ndarray, np.ndarray]]:
    """Mean and standard error of these, less the master equation's, at each of SIZES; so many contacts in all replicas
    of one size."""
    path = [0.0, 5.6]
    solved = master.solve(NARROW, path, spring=1.0, slip="reform-after").slips
    exact = np.concatenate([solved.drive[:3], np.diff(solved.drive)[:2], solved.drop[:3]])
    found = []
    for size in SIZES:
        replicas = contacts_each // size
        run = eq_model.simulate(
            NARROW,
            path,
            spring=1.0,
            slip="reform-after",
            n_contacts=size,
            n_replicas=replicas,
            seed=1,
        )
        own = of_slips(run.slips, replicas) - exact
        found.append((own.mean(axis=0), own.std(axis=0, ddof=1) / np.sqrt(replicas)))
    return found


def draw_contacts() -> None:
    """Against N^(-2/3), with the straight line through the three sizes, weighted, and where it meets infinite N."""
    from matplotlib.figure import Figure

    found = finite_numbers()
    mean, error = (np.array(rows) for rows in zip(*found, strict=True))
    scale = np.array(SIZES) ** (-2.0 / 3.0)
    figure = Figure(figsize=(10, 4.0), layout="constrained")
    axes = figure.subplots(1, 2)
    named = [
        *(f"$X_T$ of slip {k}" for k in (1, 2, 3)),
        "first period",
        "second",
        *(f"drop {k}" for k in (1, 2, 3)),
    ]
    for k, name in enumerate(named):
        weights = (
            np.linalg.pinv(np.stack([np.ones(3), scale], axis=1) / error[:, k : k + 1])
            / error[:, k]
        )
        at, slope = weights @ mean[:, k]
        # the next order is N^(-1), by up to five times the slope
        off = float(
            np.hypot(
                np.linalg.norm(weights[0] * error[:, k]), 5.0 * slope * weights[0] @ scale**1.5
            )
        )
        print(
            f"{name.replace('$', '')}: {at:.1e} ± {off:.1e} beside the master equation, {slope:.2f} N^(-2/3)"
        )
        ax, style = (axes[0], style_of(k)) if k < 3 else (axes[1], style_of(k - 3))
        dashes = style.pop("ls")
        bars = {"yerr": error[:, k], "ms": 4, "capsize": 2, "lw": 1, "ls": "none"}
        ax.errorbar(scale, mean[:, k], **bars, **style, label=name)
        ends = [at, at + slope * scale[0]]
        ax.plot([0.0, scale[0]], ends, lw=1, ls=dashes, color=style["color"])
    for ax in axes:
        ax.axhline(0.0, color="0.6", lw=0.8, zorder=0)
        ax.set_xlim(left=0.0)
        ax.locator_params(axis="x", nbins=5)
        name_axis(ax.xaxis, "$N^{-2/3}$ of $N$ contacts", "")
        name_axis(ax.yaxis, "$N$ contacts less infinitely many", r"$\langle x_s\rangle$")
    legend_above(axes[0], "where slips come", 75)
    legend_above(axes[1], "period, and fall of the force", 75)
    figure.savefig(PICTURES / "finite_numbers.png", dpi=130)


def main() -> None:
    """Draw sliders.png, the loops beside the paper's closure and the three rules; then the other pictures."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 3.8), layout="constrained")
    axes = figure.subplots(1, 3, width_ratios=(1, 1, 1.4))
    for ax, amplitude in zip(axes, (3.0, 0.9), strict=False):
        path, exact, paper = both(amplitude)
        print(
            f"turning at +-{amplitude}: the paper's closure is off by {np.abs(paper - exact).max():.3f}"
        )
        ax.plot(path, exact, color=OKABE_ITO[0], lw=1.4, label="exact cohorts")
        ax.plot(path, paper, color=OKABE_ITO[1], lw=1.4, ls=DASHES[1], label="paper's closure")
        ax.set(xlabel=f"slider position $X$ {MEAN}", ylabel=FORCE)
        legend_above(ax, f"turns at ±{amplitude}", 50)
    drive = np.linspace(0.0, 12.0, 1201)
    for slip, ink, dashes in zip(RULES, OKABE_ITO, DASHES, strict=False):
        found = master.solve(CONTACTS, drive, spring=SPRING, slip=slip)
        print(f"{slip}: {found.regime.verdict}; {found.regime.reason}")
        axes[2].plot(drive, found.force, color=ink, ls=dashes, lw=1.4, label=slip)
    axes[2].set(xlabel=f"drive position $X_T$ {MEAN}", ylabel=FORCE)
    legend_above(axes[2], f"soft slider, K = {SPRING} N_c<k>, by slip rule", 90)
    figure.savefig(PICTURES / "sliders.png", dpi=130)
    draw_holds()
    draw_contacts()


if __name__ == "__main__":
    main()
