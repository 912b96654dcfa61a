"""The pictures and the numbers of docs/sliders.md: python docs/sliders.py"""

from pathlib import Path

import numpy as np

import eq_model
import master
import origins
from master.paper.explicit import explicit_loop

PICTURES = Path(__file__).parent / "pictures"
CONTACTS = origins.Contacts(origins.gaussian(1.0, 0.2), origins.gaussian_start(0.0, 0.025))
SPRING = 0.5
NARROW, SIZES = origins.Contacts(origins.gaussian(1.0, 0.05)), (4_000, 32_000, 256_000)
RULES = [("reset", "#1f4e79", "-"), ("reform-after", "#c0392b", "--"), ("instant", "#2e7d32", ":")]


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
    for temperature, ink in ((0.03, "#1f4e79"), (0.1, "#2e7d32"), (0.3, "#c0392b")):
        forces = [static_force(temperature, hold, 1e-5) for hold in holds]
        ax.semilogx(holds, forces, "o-", color=ink, ms=3, lw=1.4, label=f"$T$ = {temperature}")
    ax.set(xlabel=r"time of the hold, $1/\omega$", ylabel=r"static force $F/(N_c\langle k\rangle)$")
    ax.set_title("soft contacts, after a hold")
    ax.legend(fontsize="small")
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
    figure = Figure(figsize=(10, 3.6), layout="constrained")
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
        ax = axes[0] if k < 3 else axes[1]
        ink = ("#1f4e79", "#2e7d32", "#c0392b", "#1f4e79", "#2e7d32", "0.2", "0.5", "0.7")[k]
        ax.errorbar(
            scale,
            mean[:, k],
            yerr=error[:, k],
            fmt="o",
            ms=3,
            capsize=2,
            lw=1,
            color=ink,
            label=name,
        )
        ax.plot([0.0, scale[0]], [at, at + slope * scale[0]], lw=1, color=ink)
    for ax in axes:
        ax.axhline(0.0, color="0.6", lw=0.8, zorder=0)
        ax.set(xlabel="$N^{-2/3}$", ylabel="$N$ contacts less infinitely many")
        ax.ticklabel_format(style="sci", scilimits=(0, 0))
        ax.legend(fontsize="small")
    axes[0].set_title("where slips come")
    axes[1].set_title("period, and fall of the force")
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
        ax.plot(path, exact, color="#1f4e79", lw=1.4, label="exact cohorts")
        ax.plot(path, paper, color="#c0392b", lw=1.2, ls="--", label="paper's closure")
        ax.set(
            title=f"turns at ±{amplitude}",
            xlabel="slider position $X$",
            ylabel=r"force $F/(N_c\langle k\rangle)$",
        )
        ax.legend(loc="center" if amplitude > 1.0 else "lower right", fontsize="small")
    drive = np.linspace(0.0, 12.0, 1201)
    for slip, ink, dashes in RULES:
        found = master.solve(CONTACTS, drive, spring=SPRING, slip=slip)
        print(f"{slip}: {found.regime.verdict}; {found.regime.reason}")
        axes[2].plot(drive, found.force, color=ink, ls=dashes, lw=1.4, label=f'slip = "{slip}"')
    title = f"soft slider, K = {SPRING} $N_c\\langle k\\rangle$"
    axes[2].set(
        title=title, xlabel="drive position $X_T$", ylabel=r"force $F/(N_c\langle k\rangle)$"
    )
    axes[2].legend(loc="lower right", fontsize="small", framealpha=1.0)
    figure.savefig(PICTURES / "sliders.png", dpi=130)
    draw_holds()
    draw_contacts()


if __name__ == "__main__":
    main()
