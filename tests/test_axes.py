"""Pictures, read back as drawn: prefixes of metres, axes where decades differ, what is drawn against what."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import origins
from toolkit.judge.compare import compare
from toolkit.pictures.compare import draw_comparison
from toolkit.pictures.run import (
    plot_deviation,
    plot_force,
    plot_holding,
    plot_position,
    save_picture,
)
from toolkit.pictures.thresholds import highest, plot_density
from toolkit.results.records import sample_curve
from toolkit.running.runner import run
from toolkit.scene.scene import load_scene


def rough() -> dict[str, Any]:
    tables = {"kind": "from-topography", "model": "gw", "law": "amontons", "pressure": 1e6}
    tables["surface"] = {"kind": "summits", "radius": 1e-6, "std": 5e-8, "density": 1e12}
    tables["material"] = {"contact_modulus": 1.75e9, "shear_modulus": 1.1e9, "local_friction": 0.4}
    return {"contacts": {"thresholds": tables}, "drive": {"to": 5e-8, "points": 51}, "master": {}}


def scene(law: dict[str, Any], to: float) -> Any:
    return load_scene(
        {"contacts": {"thresholds": law}, "drive": {"to": to, "points": 41}, "master": {}}
    )


def labels(axis: Any) -> list[str]:
    axis.figure.canvas.draw()
    return [text.get_text() for text in axis.get_majorticklabels()]


def test_lengths_of_a_surface_have_a_prefix_and_data_stay_in_metres() -> None:
    result = run(rough() | {"eq": {"contacts": 2, "replicas": 2}})
    plot_force(axes := Figure().subplots(), result)
    assert "20 nm" in labels(axes.xaxis) and all(
        one.endswith(("m", "nm")) for one in labels(axes.yaxis)
    )
    assert axes.get_lines()[0].get_xdata().max() == 5e-8
    plot_deviation(axes := Figure().subplots(), result)
    assert axes.texts[0].get_text().startswith("not compared: too few contacts")


def test_a_density_that_diverges_is_cut_and_a_narrow_peak_is_not() -> None:
    curve = sample_curve(origins.lubricated(1.0, power=-0.5))
    assert highest(curve, curve.density) < 100.0 < curve.density.max()
    peak = sample_curve(
        origins.mixture([origins.rectangular(0.0, 2.0), origins.gaussian(1.0, 1e-4)], [0.99, 0.01])
    )
    assert highest(peak, peak.density) > peak.density.max()
    plot_density(axes := Figure().subplots(), curve)
    assert axes.get_ylim()[1] < 100.0


def test_comparison_of_scenes_that_are_decades_apart() -> None:
    kinds = [({"kind": "identical", "value": 1.0}, 3.0), ({"kind": "gw-elastic", "B": 1.0}, 100.0)]
    kinds.append(({"kind": "gaussian", "mean": 7e-9, "std": 7e-12}, 1.4e-8))
    figure = draw_comparison(compare([scene(law, to) for law, to in kinds]))
    density, springs, force, _, weights = figure.axes
    assert density.get_yscale() == springs.get_xscale() == force.get_xscale() == "log"
    assert (
        weights.get_ylabel() == "weight at one value (diamonds)"
        and weights.get_yscale() == "linear"
    )
    assert springs.texts[0].get_text() == "infinite"


def test_a_drive_in_time_is_drawn_against_time(tmp_path: Path) -> None:
    law = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    drive = {"turns": [1.5, 1.5, 2.0], "times": [1.5, 3.5, 4.0], "points": 10}
    tables = {
        "contacts": {"thresholds": law, "delay": {"time": 0.25}},
        "drive": drive,
        "master": {"tolerance": 1e-3},
    }
    result = run(tables | {"eq": {"contacts": 200, "replicas": 2}})
    times = [0.0, 0.5, 1.0, 1.5, 13.0 / 6.0, 17.0 / 6.0, 3.5, 11.0 / 3.0, 23.0 / 6.0, 4.0]
    for draw, values in (
        (plot_force, result.master.force),
        (plot_position, result.master.path),
        (plot_holding, result.master.holding),
    ):
        axes = draw(Figure().subplots(), result)
        line = axes.get_lines()[0]
        assert line.get_xdata() == pytest.approx(times) and np.array_equal(line.get_ydata(), values)
        assert axes.get_xlabel() == "time $t$"
    save_picture(result, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000
