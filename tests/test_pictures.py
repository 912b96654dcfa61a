"""Pictures, read back as drawn: prefixes of metres, axes where decades differ, what is drawn against what."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from scenes import GAUSSIAN, ROUGH, scene

import origins
import toolkit
from toolkit.judge.compare import compare
from toolkit.judge.picture import draw_comparison
from toolkit.pictures.run import plot_force, plot_holding, plot_position
from toolkit.pictures.thresholds import plot_density, plot_samples
from toolkit.results.records import sample_curve

WIDE = {"kind": "gaussian", "mean": 1.0, "std": 0.2}


def labels(axis: Any) -> list[str]:
    axis.figure.canvas.draw()
    return [text.get_text() for text in axis.get_majorticklabels()]


def test_lengths_of_a_surface_have_a_prefix_and_data_stay_in_metres() -> None:
    plot_force(
        axes := Figure().subplots(), toolkit.run(scene(ROUGH, drive={"to": 5e-8, "points": 51}))
    )
    assert "20 nm" in labels(axes.xaxis)
    assert all(one.endswith(("m", "nm")) for one in labels(axes.yaxis))
    assert axes.get_lines()[0].get_xdata().max() == 5e-8


def test_a_narrow_peak_is_not_cut_and_samples_are_shown() -> None:
    peak = origins.mixture(
        [origins.rectangular(0.0, 2.0), origins.gaussian(1.0, 1e-4)], [0.99, 0.01]
    )
    plot_density(axes := Figure().subplots(), sample_curve(peak))
    assert axes.get_ylim()[1] > peak.pdf(1.0)
    samples = np.array([0.5, 1.0, 1.5, 1.7])
    x, above = plot_samples(Figure().subplots(), origins.from_samples(samples)).lines[0].get_data()
    np.testing.assert_allclose(above, [np.mean(one < samples) for one in x], atol=1e-12)


def test_comparison_of_scenes_that_are_decades_apart_or_share_a_surface() -> None:
    kinds = [({"kind": "identical", "value": 1.0}, 3.0), ({"kind": "gw-elastic", "B": 1.0}, 100.0)]
    kinds.append(({"kind": "gaussian", "mean": 7e-9, "std": 7e-12}, 1.4e-8))
    verdicts = compare(
        [toolkit.load_scene(scene(law, drive={"to": to, "points": 41})) for law, to in kinds]
    )
    density, springs, force, *_ = draw_comparison(verdicts).axes
    assert density.get_yscale() == springs.get_xscale() == force.get_xscale() == "log"
    assert springs.texts[0].get_text() == "infinite" and "EQ" not in force.get_title()


def test_a_drive_in_time_is_drawn_against_time_and_its_holds_in_decades() -> None:
    drive = {"turns": [1.5, 1.5, 2.0], "times": [1.5, 3.5, 4.0], "points": 10}
    result = toolkit.run(scene(contacts={"thresholds": WIDE, "delay": {"time": 0.25}}, drive=drive))
    found = result.master
    drawn = {plot_force: found.force, plot_position: found.path, plot_holding: found.holding}
    for draw, values in drawn.items():
        line = draw(axes := Figure().subplots(), result).get_lines()[0]
        assert line.get_xdata() == pytest.approx(result.time)
        assert np.array_equal(line.get_ydata(), values) and axes.get_xlabel() == "time $t$"
    times = [1.0, 1.0 + 1e6, 2.0 + 1e6]
    long = {"turns": [1.0, 1.0, 2.0], "times": times, "points": 91, "hold_scale": 1e-2}
    result = toolkit.run(scene(WIDE, drive=long))
    axes = plot_force(Figure().subplots(), result)
    axes.figure.canvas.draw()
    shown = axes.transData.transform([(time, 0.0) for time in result.time])
    at = axes.transAxes.inverted().transform(shown)[:, 0]
    np.testing.assert_allclose(np.diff(at), at[1] - at[0], rtol=1e-6)  # points are even


def test_slips_are_drawn_where_they_are() -> None:
    found = toolkit.run(scene(GAUSSIAN, drive={"to": 6.0, "points": 7, "spring": 1.0}))
    x, y = plot_force(Figure().subplots(), found).get_lines()[0].get_data()
    slips = found.master.slips
    assert slips.drive.size >= 1
    each = zip(slips.drive, slips.force_before, slips.force_after, strict=True)
    for place, before, after in each:
        assert y[x == place].tolist() == [before, after]


def test_a_picture_of_a_sweep_has_a_line_for_each_value_of_the_second_quantity() -> None:
    contacts = {"thresholds": GAUSSIAN, "thermal": {"law": "soft", "temperature": 0.3}}
    sweep = {"velocity": {"from": 1e-2, "to": 1e2, "points": 5}, "temperature": [0.1, 0.3]}
    result = toolkit.run({"contacts": contacts, "sweep": sweep})
    axes = Figure().subplots(1, 2)
    toolkit.plot(result, axes)
    assert axes[0].get_xscale() == "log" and len(axes[0].lines) == 2
    assert [text.get_text()[-5:] for text in axes[0].get_legend().get_texts()] == ["= 0.1", "= 0.3"]
    np.testing.assert_array_equal(axes[0].lines[1].get_ydata(), result.sweep.force[:, 1])


def test_what_is_not_solved_is_not_drawn() -> None:
    result = toolkit.run(scene())
    for error, points in ((1e-9, 21), (1e-2, 21), (np.inf, 0)):
        master = dataclasses.replace(result.master, success=error < 1e-8, force_error=error)
        axes = Figure().subplots(1, 2)
        toolkit.plot(dataclasses.replace(result, master=master), axes)
        (line,) = axes[0].lines
        assert len(line.get_xdata()) == points
        assert ("not solved" in line.get_label()) == (points == 0)


def test_springs_of_surfaces_with_areas_are_in_newtons_per_metre() -> None:
    drive = {"to": 1e-7, "points": 3}
    for own, label in ((drive | {"area": 1e-6}, "(N/m)"), (drive, "(N/m³)")):
        one = compare([toolkit.load_scene(scene(ROUGH, drive=own, master=None), solved=False)])
        springs = draw_comparison(one).axes[1]
        assert label in springs.get_xlabel()
        (bar,) = springs.patches
        assert springs.get_xlim()[0] < bar.get_width() < springs.get_xlim()[1]
