"""The picture and the table of docs/rough-surfaces.md, from the shipped scenes: python docs/rough_surfaces.py"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import master
import toolkit
from toolkit.pictures.axes import MARKERS, OKABE_ITO

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# scene, its name on the page, ink, one for each law, and dashes: Greenwood-Williamson solid, Persson dashed
SCENES = [
    ("rough-gw-amontons", "GW, amontons", OKABE_ITO[1], "-"),
    ("rough-gw-paper", "GW, paper", OKABE_ITO[0], "-"),
    ("rough-gw-strength", "GW, strength", OKABE_ITO[2], "-"),
    ("rough-gw-mixed", "GW, amontons, mixed", OKABE_ITO[3], "-"),
    ("rough-persson-amontons", "Persson, amontons", OKABE_ITO[1], "--"),
    ("rough-persson-paper", "Persson, paper", OKABE_ITO[0], "--"),
]
PICTURE = Path(__file__).parent / "pictures" / "rough_surfaces.png"


@dataclass(frozen=True)
class Reading:
    """One reading of the surface: its thresholds in m, how prone to stick-slip they are, and F/F_k over X/<x_s>."""

    name: str
    ink: str
    dashes: str
    thresholds: Any
    propensity: Any
    path: np.ndarray
    force: np.ndarray

    def style(self, points: int) -> dict[str, Any]:
        """How its curve of so many points is drawn; marks, a few along it, tell curves apart without their colours."""
        number = [name for _, name, *_ in SCENES].index(self.name)
        marks = {"marker": MARKERS[number], "ms": 4.5, "markevery": (10 + 9 * number, points // 7)}
        return {"color": self.ink, "ls": self.dashes, "lw": 1.4, **marks}


def readings() -> list[Reading]:
    """All of SCENES, solved from relaxed contacts over five mean thresholds."""
    found = []
    for scene, name, ink, dashes in SCENES:
        contacts = toolkit.load_scene(scene).contacts
        path = np.linspace(0.0, 5.0, 401)
        mean = contacts.mean_threshold
        force = (
            master.solve(contacts, path * mean, tolerance=1e-7).force
            / master.steady_state(contacts).force
        )
        found.append(
            Reading(
                name, ink, dashes, contacts.thresholds, master.propensity(contacts), path, force
            )
        )
    return found


def table(found: list[Reading]) -> list[str]:
    """The numbers of the page, as lines of Markdown."""
    lines = [
        "| reading | contacts (1/µm²) | radius (nm) | <x_s> (nm) | <f_s> (µN) | <k> (N/m) | spread | onset power | "
        "K*/(N<k>) | F_s/F_k | F_k/load |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for reading in found:
        law, i, p = reading.thresholds, reading.thresholds.interface, reading.propensity
        columns = [
            reading.name,
            f"{i.contact_density * 1e-12:.3f}",
            f"{i.mean_radius * 1e9:.0f}",
            f"{law.mean() * 1e9:.2f}",
            f"{i.mean_force_threshold * 1e6:.2f}",
            f"{i.mean_stiffness:.0f}",
            f"{law.std() / law.mean():.2f}",
            f"{law.onset_power:.2g}",
            f"{p.critical_spring:.2g}",
            f"{p.static_to_kinetic:.3f}",
            f"{i.friction_coefficient:.3f}",
        ]
        lines.append(f"| {' | '.join(columns)} |")
    return lines


def draw(found: list[Reading], path: Path) -> None:
    """Four panels: how the load is shared, what thresholds that makes, the force, and the springs that slip."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8), layout="constrained")
    loads, thresholds, force, springs = figure.subplots(2, 2).ravel()
    plot_loads(loads, found)
    plot_thresholds(thresholds, found)
    for reading in found:
        force.plot(reading.path, reading.force, **reading.style(reading.path.size))
    force.axhline(1.0, color="0.6", lw=0.8, zorder=0)
    force.set(
        title="the force as the slider sets off", xlabel=r"$X/\langle x_s\rangle$", ylabel="$F/F_k$"
    )
    force.set(xlim=(0.0, 5.0), ylim=(0.0, 1.3))
    plot_springs(springs, found)
    figure.savefig(path, dpi=130, format="png")


def plot_loads(axes: "Axes", found: list[Reading]) -> None:
    """Density of the load on a contact: under Amontons' law for one contact f_s is proportional to it."""
    for reading in found:
        if "amontons" not in reading.name:
            continue
        law, i = reading.thresholds, reading.thresholds.interface
        x = np.geomspace(law.ppf(1e-5), law.isf(1e-4), 2001)
        # points on both sides of a jump, so that it is drawn vertically
        x = np.sort(
            np.concatenate([x, law.breakpoints[1:] * (1 - 1e-9), law.breakpoints[1:] * (1 + 1e-9)])
        )
        load, bend = i.force_threshold(x) / i.mean_force_threshold, i.force_law
        steepness = np.where(x <= bend.at, bend.exponent, bend.above)
        density = law.pdf(x) * x / (steepness * load)
        axes.plot(load, density, **reading.style(load.size), label=reading.name)
    axes.set(
        title="how contacts share the load", xlabel="load of a contact / its mean", ylabel="density"
    )
    axes.set(xlim=(0.0, 3.0), ylim=(0.0, 1.6))
    axes.legend(fontsize="small")


def plot_thresholds(axes: "Axes", found: list[Reading]) -> None:
    """P_c of each reading in units of its own mean."""
    for reading in found:
        law = reading.thresholds
        mean = law.mean()
        marks = law.breakpoints[1:] / mean
        x = np.sort(
            np.concatenate([np.linspace(0.0, 3.0, 1501), marks * (1 - 1e-9), marks * (1 + 1e-9)])
        )
        axes.plot(x, law.pdf(x * mean) * mean, **reading.style(x.size), label=reading.name)
    axes.set(
        title="thresholds", xlabel=r"$x/\langle x_s\rangle$", ylabel=r"$\langle x_s\rangle\,P_c$"
    )
    axes.set(xlim=(0.0, 3.0), ylim=(0.0, None))
    axes.legend(fontsize="small")


def plot_springs(axes: "Axes", found: list[Reading]) -> None:
    """K*/(N<k>) of each: under a softer driving spring the slider slips."""
    for row, reading in enumerate(found):
        value = reading.propensity.critical_spring
        hatch = "//" if reading.dashes == "--" else None
        axes.barh(
            row,
            value - 3e-4,
            left=3e-4,
            color=reading.ink,
            height=0.6,
            hatch=hatch,
            edgecolor="white",
        )
        axes.annotate(
            f"{value:.2g}", (value, row), xytext=(4, 0), textcoords="offset points", va="center"
        )
    axes.set_yticks(range(len(found)), [reading.name for reading in found])
    axes.invert_yaxis()
    axes.set(xscale="log", xlim=(3e-4, 3.0), xlabel=r"$K^*/(N\langle k\rangle)$")
    axes.set_title("under softer springs the slider slips")


if __name__ == "__main__":
    all_of_them = readings()
    draw(all_of_them, PICTURE)
    print("\n".join(table(all_of_them)))
