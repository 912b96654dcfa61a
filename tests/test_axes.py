"""Axes of pictures: prefixes, powers of ten, logarithmic where decades differ; read back as drawn."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import origins
from toolkit.judge.compare import compare
from toolkit.pictures.abscissa import conditions
from toolkit.pictures.axes import Lengths, heights, spans_decades
from toolkit.pictures.compare import draw_comparison, plot_forces, plot_springs, plot_surface, plot_thresholds
from toolkit.pictures.run import (
    plot_density,
    plot_deviation,
    plot_force,
    plot_hazard,
    plot_holding,
    plot_position,
    save_picture,
)
from toolkit.pictures.thresholds import final_law, plot_final
from toolkit.results.records import sample_curve
from toolkit.running.runner import run
from toolkit.scene.scene import load_scene, read_table


def labels(axis: Any) -> list[float]:
    """What the ticks within the limits say."""
    axis.figure.canvas.draw()
    low, high = sorted(axis.get_view_interval())
    texts = zip(axis.get_majorticklocs(), axis.get_majorticklabels(), strict=True)
    assert axis.get_offset_text().get_text() == ""
    return [float(text.get_text().replace("\u2212", "-")) for place, text in texts if low <= place <= high]


@pytest.mark.parametrize(
    ("largest", "metres", "power", "prefixed"),
    [
        (5e-8, True, -9, "nm"),
        (1e-6, True, -6, "µm"),
        (0.02, True, -3, "mm"),
        (3.0, True, 0, "m"),
        (1e-15, True, -12, "pm"),
        (0.05, False, 0, ""),
        (5e-8, False, -9, ""),
        (9999.0, False, 0, ""),
        (5e7, False, 6, ""),
        (0.0, True, 0, "m"),
    ],
)
def test_unit_of_lengths(largest: float, metres: bool, power: int, prefixed: str) -> None:
    assert Lengths.of(largest, metres) == Lengths(power, prefixed)


@pytest.mark.parametrize("ends", [(0.0, 5e-8), (6.9e-9, 7.1e-9), (0.0, 2.5e-9), (0.0, 9e-7)])
def test_ticks_say_where_they_stand(ends: tuple[float, float]) -> None:
    axes = Figure().subplots()
    axes.set_xlim(*ends)
    lengths = Lengths.of(ends[1], metres=True)
    lengths.write(axes.xaxis, "x")
    assert axes.get_xlabel() == "x (nm)"
    told = labels(axes.xaxis)
    places = [place for place in axes.get_xticks() if ends[0] <= place <= ends[1]]
    assert len(set(told)) == len(told) == len(places) > 2
    assert told == pytest.approx([place * 1e9 for place in places], rel=1e-9, abs=1e-12)


def test_force_of_a_surface_is_in_nanometres() -> None:
    axes = Figure().subplots()
    plot_force(axes, run(rough("amontons")))
    assert axes.get_xlabel() == "slider position $X$ (nm)" and axes.get_ylabel().endswith("(nm)")
    assert max(labels(axes.xaxis)) == 50.0 and 1.0 < max(labels(axes.yaxis)) < 100.0
    # the data stay in metres
    assert axes.get_lines()[0].get_xdata().max() == 5e-8
    plot_density(axes := Figure().subplots(), sample_curve(load_scene(rough("amontons")).contacts.thresholds))
    assert axes.get_xlabel() == "threshold $x$ (nm)" and axes.get_ylabel() == "$P_c(x)$ (1/nm)"
    assert 0.001 < max(labels(axes.yaxis)) < 10.0


def test_small_numbers_of_no_unit_name_their_power() -> None:
    axes = Figure().subplots()
    plot_density(axes, sample_curve(origins.gaussian(7e-9, 1e-10)))
    assert axes.get_xlabel() == "threshold $x$ / $10^{-9}$" and axes.get_ylabel() == "$P_c(x)$ / $10^{9}$"
    assert 7.0 in labels(axes.xaxis) and 3.0 <= max(labels(axes.yaxis)) <= 4.2


def test_a_density_that_diverges_is_cut_and_a_narrow_peak_is_not() -> None:
    curve = sample_curve(origins.lubricated(1.0, power=-0.5))
    found = heights(curve, curve.density)
    assert found.top < 100.0 < curve.density.max() and not found.logarithmic
    assert curve.survival[curve.density > found.top].min() > 0.95
    peak = sample_curve(origins.mixture([origins.rectangular(0.0, 2.0), origins.gaussian(1.0, 1e-4)], [0.99, 0.01]))
    assert heights(peak, peak.density).top > peak.density.max()
    axes = Figure().subplots()
    plot_hazard(axes, curve)
    assert axes.get_ylim()[1] < 100.0


def test_exact_values_beside_a_density_have_their_own_axis() -> None:
    law = origins.mixture([origins.rectangular(1e-7, 4e-7), origins.identical(2e-7)], [0.6, 0.4])
    axes = Figure().subplots()
    plot_density(axes, sample_curve(law))
    _, own = axes.figure.axes
    assert own.get_ylabel() == "weight at one value" and 0.4 < own.get_ylim()[1] < 0.5
    assert axes.get_ylim()[1] == pytest.approx(1.05 * 0.6 / 3e-7, rel=0.01)
    plot_density(alone := Figure().subplots(), sample_curve(origins.identical(2e-7)))
    assert len(alone.figure.axes) == 1 and alone.get_ylabel() == "weight at one value"
    assert max(labels(alone.yaxis)) == 1.0


def test_exact_values_in_a_comparison_have_their_own_axis() -> None:
    gaussian, exact = {"kind": "gaussian", "mean": 1.0, "std": 0.001}, {"kind": "identical", "value": 2.0}
    mixed = {"kind": "mixture", "weights": [0.98, 0.02], "components": [gaussian, exact]}
    figure = draw_comparison(compare([scene(mixed, 4.0), scene({"kind": "gw-elastic", "B": 1.0}, 400.0)]))
    (density,) = (axes for axes in figure.axes if axes.get_title() == "thresholds")
    (own,) = (axes for axes in figure.axes if axes.get_ylabel() == "weight at one value (diamonds)")
    # a logarithmic axis of densities has no place for a line that begins at zero
    assert density.get_yscale() == "log" and own.get_yscale() == "linear"
    assert own.get_ylim() == pytest.approx((0.0, 0.021)) and own.get_xlim()[1] > 2.0 / 1.02
    assert own.get_lines()[0].get_xydata() == pytest.approx(np.array([[2.0 / 1.02, 0.02]]))


@pytest.mark.parametrize(("to", "ends"), [(400.0, ", logarithmic axis"), (4.0, "$")])
def test_axis_of_the_way_says_that_it_is_logarithmic(to: float, ends: str) -> None:
    figure = draw_comparison(compare([scene({"kind": "gw-elastic", "B": b}, x) for b, x in ((1.0, 4.0), (2.0, to))]))
    (label,) = (axes.get_xlabel() for axes in figure.axes if axes.get_xlabel().startswith("slider position"))
    assert label.endswith(ends)


def test_points_do_not_hide_the_line() -> None:
    tables = {**rough("amontons"), "eq": {"contacts": 100, "replicas": 4}}
    plot_force(axes := Figure().subplots(), run(tables))
    (bars,) = axes.containers
    assert axes.get_lines()[0].get_zorder() > max(part.get_zorder() for part in bars.get_children())


def test_solvers_not_compared_are_said_to_be() -> None:
    tables = {**rough("amontons"), "eq": {"contacts": 2, "replicas": 2}}
    plot_deviation(axes := Figure().subplots(), run(tables))
    assert axes.texts[0].get_text().startswith("not compared: too few contacts")
    assert axes.get_xlabel() == "slider position $X$ (nm)"


def test_thresholds_over_decades_have_logarithmic_axes() -> None:
    curve = sample_curve(origins.lubricated(1.0, power=-0.95))
    assert spans_decades(curve) and not spans_decades(sample_curve(origins.gw_elastic(1.0)))
    axes = Figure().subplots()
    plot_density(axes, curve)
    assert axes.get_xscale() == axes.get_yscale() == "log"


def rough(law: str) -> dict[str, Any]:
    tables = {"kind": "from-topography", "model": "gw", "law": law, "pressure": 1e6}
    tables["surface"] = {"kind": "summits", "radius": 1e-6, "std": 5e-8, "density": 1e12}
    tables["material"] = {"contact_modulus": 1.75e9, "shear_modulus": 1.1e9, "local_friction": 0.4}
    return {"contacts": {"thresholds": tables}, "drive": {"to": 5e-8, "points": 51}, "master": {}}


def scene(law: dict[str, Any], to: float) -> Any:
    return load_scene({"contacts": {"thresholds": law}, "drive": {"to": to, "points": 41}, "master": {}})


def test_comparison_of_scenes_that_are_decades_apart() -> None:
    verdicts = compare(
        [
            scene({"kind": "identical", "value": 1.0}, 3.0),
            scene({"kind": "gaussian", "mean": 7e-9, "std": 7e-12}, 1.4e-8),
            scene({"kind": "gw-elastic", "B": 1.0}, 100.0),
        ]
    )
    axes = Figure(figsize=(13, 4), layout="constrained").subplots(1, 3)
    plot_thresholds(axes[0], verdicts)
    plot_forces(axes[1], verdicts)
    plot_springs(axes[2], verdicts)
    assert axes[0].get_yscale() == axes[1].get_xscale() == axes[2].get_xscale() == "log"
    # the lowest and the highest of the laws are both within
    low, high = axes[0].get_ylim()
    assert low < 0.1 and 400.0 < high < 4000.0
    axes[2].figure.canvas.draw()
    right = axes[2].get_window_extent().x1
    assert axes[2].texts[0].get_text() == "infinite"
    assert all(text.get_window_extent().x1 < right for text in axes[2].texts)
    alike = compare([scene({"kind": "gw-elastic", "B": b}, 4.0) for b in (1.0, 2.0)])
    axes = Figure().subplots(1, 2)
    plot_thresholds(axes[0], alike)
    plot_forces(axes[1], alike)
    assert axes[0].get_yscale() == axes[1].get_xscale() == "linear" and axes[0].get_ylim()[0] == 0.0


def test_surface_of_any_size() -> None:
    axes = Figure().subplots()
    plot_surface(axes, 1e-6 * np.random.default_rng(1).standard_normal((8, 8)), (2e-3, 1e-3))
    assert axes.get_xlabel() == "x (mm)" and max(labels(axes.xaxis)) == 2.0
    assert axes.figure.axes[1].get_ylabel() == "height (µm)"


def test_a_drive_in_time_is_drawn_against_time(tmp_path: Path) -> None:
    law = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    drive = {"turns": [1.5, 1.5, 2.0], "times": [1.5, 3.5, 4.0], "points": 10}
    scene = {"contacts": {"thresholds": law, "delay": {"time": 0.25}}, "drive": drive, "master": {"tolerance": 1e-3}}
    result = run(scene | {"eq": {"contacts": 200, "replicas": 2}})
    times = [0.0, 0.5, 1.0, 1.5, 13.0 / 6.0, 17.0 / 6.0, 3.5, 11.0 / 3.0, 23.0 / 6.0, 4.0]
    axes = Figure().subplots(4)
    for own, draw, values in (
        (axes[0], plot_force, result.master.force),
        (axes[1], plot_position, result.master.path),
        (axes[2], plot_holding, result.master.holding),
    ):
        line = draw(own, result).get_lines()[0]
        assert line.get_xdata() == pytest.approx(times) and np.array_equal(line.get_ydata(), values)
        assert own.get_xlabel() == "time $t$"
    assert axes[0].get_title().endswith(r"$\tau_m$ = 0.25")
    assert np.isin(plot_deviation(axes[3], result).get_lines()[0].get_xdata(), times).all()
    assert result.master.holding.min() < 0.9
    missed = replace(result, master=replace(result.master, success=False))
    labels = [plot_force(Figure().subplots(), one).get_lines()[0].get_label() for one in (result, missed)]
    assert "not as asked" not in labels[0] and "not as asked" in labels[1]
    save_picture(result, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000


def test_titles_name_the_laws_and_old_thresholds_are_drawn() -> None:
    laws = {
        "thermal": {"law": "stiff", "temperature": 0.1, "closure": "paper"},
        "reforming": {"kind": "gaussian", "mean": 0.0, "std": 0.05},
        "ageing": {"rate": 5e-4, "final": {"kind": "gaussian", "mean": 2.0, "std": 0.1}},
        "stiffness": "linked",
    }
    law = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    asked = read_table({"contacts": {"thresholds": law} | laws, "drive": {"to": 1.0, "points": 2}})
    curve = sample_curve(origins.gaussian(1.0, 0.2))
    result: Any = SimpleNamespace(asked=asked, thresholds=curve, master=None, eq=None, sweep=None)
    first = r"stiff law (paper's closure) at $T$ = 0.1, $\omega$ = 1, linked $k \sim x_s$"
    assert conditions(result) == f"{first},\nre-forming at 0 ± 0.05, $D$ = 0.0005, $v$ = 1"
    axes = plot_density(Figure().subplots(), curve)
    final = final_law(result)
    assert final is not None
    plot_final(axes, curve, final)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["new", "final"]
    assert axes.get_xlim()[1] > 2.2 and axes.get_ylim()[1] > 3.98
