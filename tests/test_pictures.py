"""Pictures, read back as drawn: units with prefixes, slips from their own data, holds and steps of the speed, errors,
and what is drawn against what."""

import dataclasses
import re
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import slow
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scenes import GAUSSIAN, ROUGH, scene

import master
import origins
import toolkit
from tests.verdicts import infinite, reading, verdict_on
from toolkit.judge.compare import compare
from toolkit.judge.lines import table
from toolkit.judge.picture import draw_comparison
from toolkit.pictures.axes import INK, MARKERS, OKABE_ITO, name_axis, style_of
from toolkit.pictures.critical_spring import plot_points_spring
from toolkit.pictures.keys import last_words, symbol_of_key
from toolkit.pictures.points import plot_points
from toolkit.pictures.run import (
    draw_run,
    plot_force,
    plot_holding,
    plot_position,
    plot_velocity,
)
from toolkit.pictures.thresholds import plot_density, plot_histogram, plot_samples
from toolkit.results.beside import deviation
from toolkit.results.records import sample_curve
from toolkit.scene.scale import written
from toolkit.stability.table import VERDICTS
from toolkit.verdict.judge import verdict
from toolkit.verdict.picture import draw_springs, draw_verdict
from toolkit.verdict.sliders.records import Finite
from toolkit.verdict.trace import draw_trace

ROOT = Path(__file__).parents[1]
WIDE = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
EQ = {"contacts": 500, "replicas": 2, "seed": 1}
HEAVY = {"to": 3.0, "points": 41, "spring": 0.5, "mass": 0.02, "velocity": 1e-3}


def drawn(figure: Any) -> Any:
    """The figure, with all its places found; nothing is rendered, which takes longer."""
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    return figure


def ticks(axis: Any) -> list[str]:
    drawn(axis.figure)
    return [text.get_text() for text in axis.get_majorticklabels()]


def panels(figure: Any) -> dict[str, Any]:
    """The axes of a figure by the label of its mosaic."""
    return {axes.get_label(): axes for axes in figure.axes}


@pytest.mark.parametrize(
    ("own", "name", "largest"),
    [
        ({"area": 1e-6}, "force $F$ (mN)", 251.6e-3),
        ({}, "shear stress $F/A$ (kPa)", 251.6e3),
    ],
)
def test_forces_of_a_surface_are_in_newtons_or_pascals_and_lengths_in_nanometres(
    own: dict[str, float], name: str, largest: float
) -> None:
    result = toolkit.run(scene(ROUGH, drive={"to": 5e-8, "points": 51} | own))
    axes = plot_force(Figure().subplots(), result)
    (line,) = axes.get_lines()
    assert axes.get_xlabel() == "slider position $X$ (nm)" and axes.get_ylabel() == name
    assert "20" in ticks(axes.xaxis) and line.get_xdata().max() == 5e-8
    assert line.get_ydata() == pytest.approx(result.scale.force * result.master.force)
    # F over the load, on the other side
    (over,) = axes.child_axes
    surface = toolkit.load_scene(scene(ROUGH)).contacts.interface
    top = axes.get_ylim()[1] / result.scale.load
    assert over.get_ylim()[1] == pytest.approx(top) and "load" in over.get_ylabel()
    assert line.get_ydata()[-1] / result.scale.load == pytest.approx(
        surface.friction_coefficient, rel=2e-2
    )


def test_an_error_above_the_tolerance_stands_in_the_legend_in_newtons() -> None:
    result = toolkit.run(scene(ROUGH, drive={"to": 5e-8, "points": 5, "area": 1e-6}))
    short = dataclasses.replace(result.master, success=False, force_error=0.01)
    axes = plot_force(Figure().subplots(), dataclasses.replace(result, master=short))
    newtons = 0.01 * result.mean_threshold * result.scale.force
    said = axes.get_lines()[0].get_label()
    assert f"error {written(newtons, 'N', digits=2)} (" in said and said.endswith("not as asked")


def test_units_of_n_c_k_are_one_key_away_and_own_units_have_no_prefix() -> None:
    drive = {"to": 5e-8, "points": 5, "area": 1e-6}
    result = toolkit.run(scene(ROUGH, drive=drive, units="N_c<k>"))
    assert "N_c" in plot_force(Figure().subplots(), result).get_ylabel()
    own = plot_force(Figure().subplots(), toolkit.run(scene()))
    assert own.get_xlabel() == "slider position $X$ (units of length)" and not own.child_axes


@pytest.mark.parametrize(
    ("unit", "log", "limits", "label", "tick"),
    [
        ("N", False, (0.0, 0.25), "x (mN)", "50"),
        ("N/m", False, (0.0, 8.5e6), "x (MN/m)", "2"),
        ("m", True, (1e-10, 5e-8), "x (nm)", "10"),
        ("m", True, (1.1e-10, 2.4e-9), "x (nm)", "1"),
        ("m", True, (1e-14, 5e-8), "x (nm)", r"$\mathdefault{10^{1}}$"),
        ("N/m", True, (5e1, 2e6), "x (kN/m)", "100"),
        ("N/m", True, (1e1, 1e9), "x (N/m)", None),
        ("1/m", False, (0.0, 1.3e8), "x (1/µm)", "100"),
        ("s", False, (0.0, 15e3), "x (s)", "4000"),
        ("m/s", False, (0.0, 0.08), "x (mm/s)", "20"),
    ],
)
def test_an_axis_has_the_prefix_that_keeps_its_ticks_short(
    unit: str, log: bool, limits: tuple[float, float], label: str, tick: str | None
) -> None:
    axes = Figure().subplots()
    axes.set(xscale="log" if log else "linear", xlim=limits)
    name_axis(axes.xaxis, "x", unit)
    assert axes.get_xlabel() == label
    assert tick is None or tick in ticks(axes.xaxis)


def test_a_logarithmic_axis_with_one_power_of_ten_labels_multiples_of_it() -> None:
    """One label alone tells no scale."""
    axes = Figure().subplots()
    axes.set(xscale="log", xlim=(1.3e-10, 1.1e-9))
    name_axis(axes.xaxis, "x", "m")
    drawn(axes.figure)
    labels = [text.get_text() for text in axes.xaxis.get_ticklabels(minor=True)]
    assert {"0.2", "0.4"} <= set(labels)


def test_a_density_has_the_inverse_of_the_unit_of_its_lengths() -> None:
    """1/nm beside nm, where its own ticks would be shortest in 1/µm."""
    axes = Figure().subplots()
    axes.set(xlim=(0.0, 4e-8), ylim=(0.0, 1.3e8))
    name_axis(axes.xaxis, "x", "m")
    name_axis(axes.yaxis, "P", "1/m", axes.xaxis)
    assert axes.get_ylabel() == "P (1/nm)" and "0.1" in ticks(axes.yaxis)


def test_comparison_in_newtons_has_the_machines_springs_and_forces_that_differ_by_decades() -> None:
    """A dashed line at each spring, forces on a logarithmic axis, and marks that are seen without a bar."""
    law = {"kind": "gaussian", "mean": 7e-9, "std": 2e-9}
    scenes = []
    for name, density in (("few", 1e9), ("many", 1e12)):
        stated = {"mean_stiffness": 10.0, "contact_density": density}
        drive = {"to": 1e-8, "points": 21, "spring": "50 N/m", "area": 1e-6}
        contacts = {"thresholds": law, "interface": stated}
        scenes.append(toolkit.load_scene(scene(contacts=contacts, drive=drive) | {"title": name}))
    verdicts = compare(scenes)
    density, springs, force, *_ = (figure := draw_comparison(verdicts)).axes
    assert figure.get_suptitle() == f"{verdicts[0].name} and {verdicts[1].name}"
    assert density.get_xscale() == "linear" and density.get_ylabel() == "$P_c(x_s)$ (1/nm)"
    dashed = [line.get_xdata() for line in springs.lines if line.get_linestyle() == "--"]
    assert (
        np.ravel([one for one in dashed if len(one)]) == pytest.approx([50.0] * 4)
        and force.get_yscale() == "log"
    )
    said = [text.get_text() for text in springs.get_legend().get_texts()]
    assert said == ["$K^*$: slips at least once on softer springs", "the machine's spring"]


def test_a_comparison_promises_no_slip_of_a_slider_with_mass() -> None:
    """Below K* a verdict on one may tell smooth sliding, where the comparison said that it slips."""
    for mass, light in ({}, ""), ({"mass": 1e-2, "damping": 1e-2}, " without mass"):
        drive = {"to": 2.0, "points": 5, "spring": 0.1} | mass
        compared = compare([toolkit.load_scene(scene(GAUSSIAN | {"std": 0.2}, drive=drive))])
        (line,) = [one for one in table(compared) if one.startswith("K*: ")]
        assert f"a slider{light} on a softer spring slips at least once" in line
        assert ("with a mass the balance is unstable" in line) == bool(mass)
        springs = draw_comparison(compared).axes[1].get_legend().get_texts()[0].get_text()
        assert ("without mass slips" in springs) == bool(mass)


def test_points_of_ensembles_stand_apart_in_a_comparison() -> None:
    """Those of each scene between those of the others, with a mark of its own; lines have none then."""
    asked = {"drive": {"to": 2.0, "points": 81}, "eq": {"contacts": 100, "replicas": 2, "seed": 1}}
    laws = (GAUSSIAN, GAUSSIAN | {"std": 0.2}, GAUSSIAN | {"std": 0.3})
    force = draw_comparison(
        compare([toolkit.load_scene(scene(one, **asked)) for one in laws])
    ).axes[2]
    points = [each.lines[0] for each in force.containers]
    assert [one.get_marker() for one in points] == ["o", "s", "^"]
    places = np.concatenate([one.get_xdata() for one in points])
    assert np.unique(places.round(2)).size == places.size == 61 and (
        force.lines[0].get_marker() == "None"
    )


def test_curves_are_of_colours_by_okabe_and_ito_and_of_different_marks() -> None:
    styles = [style_of(number) for number in range(12)]
    assert {one["color"] for one in styles} <= set(OKABE_ITO)
    assert len({one["marker"] for one in styles}) == 12


def test_no_picture_has_colours_of_its_own() -> None:
    """Colours are those of the palette, or greys."""
    own = re.compile(r"""["'](#[0-9a-f]{6}|tab:\w+|red|green|blue|C\d)["']""", re.IGNORECASE)
    files = [*(ROOT / "toolkit").rglob("*.py"), *(ROOT / "docs").glob("*.py")]
    found = {(file.name, ink.lower()) for file in files for ink in own.findall(file.read_text())}
    assert len(found) >= len(OKABE_ITO)
    assert {ink for _, ink in found} <= {*OKABE_ITO, VERDICTS["refused"]}, found


def test_a_narrow_peak_is_not_cut_and_samples_are_shown() -> None:
    peak = origins.mixture(
        [origins.rectangular(0.0, 2.0), origins.gaussian(1.0, 1e-4)], [0.99, 0.01]
    )
    plot_density(axes := Figure().subplots(), sample_curve(peak))
    assert axes.get_ylim()[1] > peak.pdf(1.0)
    samples = np.array([0.5, 1.0, 1.5, 1.7])
    x, above = plot_samples(Figure().subplots(), origins.from_samples(samples)).lines[0].get_data()
    np.testing.assert_allclose(above, [np.mean(one < samples) for one in x], atol=1e-12)
    assert above[0] == 1.0


def test_samples_have_a_histogram_beside_their_smooth_law() -> None:
    rng = np.random.default_rng(1)
    spread, same = rng.normal(1.0, 0.1, 800), np.full(500, 1.5)
    weights = rng.uniform(0.1, 2.0, 1300)
    law = origins.from_samples(np.append(spread, same), weights=weights)
    (bars,) = plot_histogram(Figure().subplots(), law).patches
    density, edges, _ = bars.get_data()
    assert edges[0] == spread.min() and edges[-1] == spread.max()
    # that of one value is a weight, beside the bars
    expected = weights[:800].sum() / weights.sum()
    np.testing.assert_allclose((density * np.diff(edges)).sum(), expected, rtol=1e-9)
    assert bars.get_label() == "1,300 samples"
    assert not plot_histogram(Figure().subplots(), origins.gaussian(1.0, 0.1)).patches


def marks_of(axes: Axes) -> dict[int, float]:
    """Where the marks of a picture of springs stand, by row."""
    marks = [line for line in axes.lines if len(line.get_xdata()) == 1]
    return {int(row): float(place) for place, row in (line.get_xydata()[0] for line in marks)}


def test_comparison_of_scenes_that_are_decades_apart_or_share_a_surface() -> None:
    kinds = [({"kind": "identical", "value": 1.0}, 3.0), ({"kind": "gw-elastic", "B": 1.0}, 100.0)]
    kinds.append(({"kind": "gaussian", "mean": 7e-9, "std": 7e-12}, 1.4e-8))
    verdicts = compare(
        [toolkit.load_scene(scene(law, drive={"to": to, "points": 41})) for law, to in kinds]
    )
    density, springs, force, *_ = draw_comparison(verdicts).axes
    assert density.get_yscale() == springs.get_xscale() == force.get_xscale() == "log"
    # from X = 0, which has no place there, a line would lead to the first point at one level
    drawn = [line.get_xdata() for line in force.lines if len(line.get_xdata()) > 2]
    assert len(drawn) == len(verdicts) and all(np.min(place) > 0.0 for place in drawn)
    assert [line.get_marker() for line in force.lines[::2]] == ["o", "s", "^"]
    assert springs.texts[0].get_text() == "infinite" and "ensemble" not in force.get_title()
    # a logarithmic axis has no zero for a bar to begin at
    assert not springs.patches and len(marks_of(springs)) == len(verdicts)


def test_a_comparison_on_an_axis_of_decades_has_the_density_of_the_log() -> None:
    """Whose area there is 1 for each scene."""
    scenes = []
    for mean in (1e-9, 1e-6):
        law = {"kind": "gaussian", "mean": mean, "std": 0.2 * mean}
        stated = {"mean_stiffness": 10.0, "contact_density": 1e10}
        contacts = {"thresholds": law, "interface": stated}
        drive = {"to": 2.0 * mean, "points": 5, "area": 1e-6}
        scenes.append(toolkit.load_scene(scene(contacts=contacts, drive=drive)))
    density = draw_comparison(compare(scenes)).axes[0]
    assert density.get_xscale() == "log" and density.get_yscale() == "linear"
    assert density.get_ylabel() == "$x_s\\,P_c(x_s)$, per unit of $\\ln x_s$"
    for line in density.lines[:2]:
        x, y = line.get_data()
        some = x > 0.0
        assert np.trapezoid(y[some], np.log(x[some])) == pytest.approx(1.0, rel=0.01)


def test_a_drive_in_time_is_drawn_against_time_and_its_holds_in_decades() -> None:
    drive = {"turns": [1.5, 1.5, 2.0], "times": [1.5, 3.5, 4.0], "points": 10}
    result = toolkit.run(scene(contacts={"thresholds": WIDE, "delay": {"time": 0.25}}, drive=drive))
    found = result.master
    curves = {plot_force: found.force, plot_position: found.path, plot_holding: found.holding}
    for draw, values in curves.items():
        line = draw(axes := Figure().subplots(), result).get_lines()[0]
        assert line.get_xdata() == pytest.approx(result.time)
        assert (
            np.array_equal(line.get_ydata(), values)
            and axes.get_xlabel() == "time $t$ (units of time)"
        )
    times = [1.0, 1.0 + 1e6, 2.0 + 1e6]
    long = {"turns": [1.0, 1.0, 2.0], "times": times, "points": 91, "hold_scale": 1e-2}
    result = toolkit.run(scene(WIDE, drive=long))
    axes = plot_force(Figure().subplots(), result)
    drawn(axes.figure)
    shown = axes.transData.transform([(time, 0.0) for time in result.time])
    at = axes.transAxes.inverted().transform(shown)[:, 0]
    np.testing.assert_allclose(np.diff(at), at[1] - at[0], rtol=1e-6)  # points are even


def test_slips_are_drawn_where_they_are() -> None:
    """On a coarse path each slip is a vertical fall at its own place: of the master equation and of each replica."""
    eq = {"contacts": 500, "replicas": 2, "seed": 1}
    drive = {"to": 6.0, "points": 7, "spring": 1.0}
    found = toolkit.run(scene(GAUSSIAN, drive=drive, eq=eq))
    one, *replicas = plot_force(Figure().subplots(), found).get_lines()
    falls(one, found.master.slips, slice(None))
    for number, line in enumerate(replicas):
        falls(line, found.eq.slips, found.eq.slips.replica == number)


@pytest.mark.slow  # quick: the test before
def test_slips_of_a_drive_that_turns_are_drawn_where_they_are() -> None:
    """Up and down, each at its own place."""
    turning = {"turns": [4.0, -4.0], "points": 13, "spring": 1.0}
    found = toolkit.run(scene(GAUSSIAN, drive=turning))
    drops = found.master.slips.drop
    assert drops.max() > 0.0 > drops.min()
    falls(plot_force(Figure().subplots(), found).get_lines()[0], found.master.slips, slice(None))


def falls(line: Any, slips: Any, own: Any) -> None:
    x, y = line.get_data()
    each = list(zip(slips.drive[own], slips.force_before[own], slips.force_after[own], strict=True))
    assert len(each) >= 2
    for place, before, after in each:
        at = np.flatnonzero((x == place) & (y == before))
        assert x[at + 1] == place and y[at + 1] == after
    assert x.size == np.unique(x).size + len(each) or np.ptp(np.sign(np.diff(x[::2]))) > 1


def test_a_slip_in_a_drive_with_times_is_at_its_own_time() -> None:
    drive = {"turns": [3.0, 3.0, 6.0], "times": [3.0, 5.0, 11.0], "points": 10, "spring": 1.0}
    found = toolkit.run(scene(GAUSSIAN, drive=drive))
    x, y = plot_force(Figure().subplots(), found).get_lines()[0].get_data()
    slips = found.master.slips
    assert slips.drive.size >= 3
    for place, before in zip(slips.drive, slips.force_before, strict=True):
        time = place if place < 3.0 else 5.0 + 2.0 * (place - 3.0)
        assert np.abs(x[y == before] - time).min() < 1e-9
    # the slider's own steps, too
    _, slider = plot_position(Figure().subplots(), found).get_lines()[:2]
    x, y = slider.get_data()
    assert set(slips.after) <= set(y) and set(slips.before) <= set(y)


def test_holds_are_shaded_and_speeds_are_named() -> None:
    drive = {"turns": [1.0, 1.0, 3.0], "times": [1.0, 3.0, 4.0], "points": 13}
    result = toolkit.run(scene(WIDE, drive=drive))
    for draw in (plot_force, plot_position):
        axes = draw(Figure().subplots(), result)
        (hold,) = axes.patches
        assert (hold.get_x(), hold.get_width()) == (1.0, 2.0)
        steps = [one.get_xdata()[0] for one in axes.lines if one.get_linestyle() == ":"]
        assert steps == [1.0, 3.0]
    assert [text.get_text() for text in axes.texts] == ["speed 1", "hold", "speed 2"]


def test_the_speed_of_a_short_leg_is_written_upright() -> None:
    drive = {"turns": [6.0, 7.0, 13.0], "times": [6.0, 6.5, 12.5], "points": 13}
    result = toolkit.run(scene(WIDE, drive=drive))
    plot_position(axes := Figure().subplots(), result)
    named = [(text.get_text(), text.get_rotation()) for text in axes.texts]
    assert named == [("speed 1", 0.0), ("2", 90.0), ("speed 1", 0.0)]


def test_an_upright_speed_does_not_lie_over_the_curve() -> None:
    """That of the last of ten legs did, of a slider that goes to the right end of its axis."""
    moves, rests = 1.0 / 0.00123, [10.0**decade for decade in range(5)]
    lasting = [each for rest in rests for each in (moves, rest)]
    turns = [float(1 + k // 2) for k in range(10)]
    drive = {"turns": turns, "times": np.cumsum(lasting).tolist(), "points": 31}
    figure = draw_run(toolkit.run(scene(WIDE, drive=drive)), Figure(layout="constrained"))
    (axes,) = (one for one in figure.axes if one.get_ylabel().startswith("position"))
    drawn(figure)
    top = axes.transData.transform([(0.0, float(axes.lines[0].get_ydata().max()))])[0, 1]
    assert [text.get_text() for text in axes.texts][-2:] == ["0.00123", "hold"]
    assert min(text.get_window_extent().y0 for text in axes.texts) > top


def test_legs_of_very_different_durations_are_equally_wide() -> None:
    result = toolkit.run(
        scene(WIDE, drive={"turns": [2.0, 2.0, 4.0], "times": [2.0, 302.0, 304.0], "points": 31})
    )
    axes = plot_force(Figure().subplots(), result)
    drawn(axes.figure)
    shown = axes.transData.transform([(time, 0.0) for time in (0.0, 2.0, 302.0, 304.0)])
    at = axes.transAxes.inverted().transform(shown)[:, 0]
    np.testing.assert_allclose(at, [0.0, 1 / 3, 2 / 3, 1.0], atol=1e-9)


def test_ends_of_many_legs_are_labelled_evenly() -> None:
    """Of eleven legs every other end, each short enough for its place."""
    turns = [float(place) for place in range(1, 12)]
    times = np.cumsum([0.05, 0.05] * 2 + [1.0, 0.05, 100.0, 0.05, 9999.0, 0.05, 0.05]).tolist()
    drive = {"turns": turns, "times": times, "points": 12}
    axes = plot_force(Figure().subplots(), toolkit.run(scene(WIDE, drive=drive)))
    drawn(axes.figure)
    labels = [text.get_text() for text in axes.get_xticklabels()]
    assert labels == ["0", "0.1", "0.2", "1.25", "101", "10100"]


@pytest.mark.parametrize(("points", "band"), [(60, True), (1201, False)])
def test_a_mass_that_swings_between_the_points_of_the_path_is_drawn_as_a_band(
    points: int, band: bool
) -> None:
    """A line through points farther apart than its swings would show slower ones. No contact forms again here."""
    drive = {"to": 120.0, "points": points, "spring": 0.01, "mass": 0.0023, "velocity": 1.0}
    contacts = {"thresholds": WIDE, "delay": {"time": 1e3}}
    result = toolkit.run(
        scene(contacts=contacts, drive=drive | {"damping": 1e-5}, master=None, eq=EQ)
    )
    # drawn alike where it was cut short
    for draw, success in product((plot_force, plot_velocity, plot_position), (True, False)):
        eq = dataclasses.replace(result.eq, success=success)
        axes = draw(Figure().subplots(), dataclasses.replace(result, eq=eq))
        of_slider = [line for line in axes.get_lines() if line.get_color() == INK["eq"]]
        swings = [line for line in of_slider if len(line.get_xdata()) >= points]
        bands = [own for own in axes.collections if len(own.get_paths()[0].vertices) > 2 * points]
        assert bool(bands) is band and bool(swings) is not band


def test_a_heavy_slider_has_panels_in_time_with_slips_from_their_own_data() -> None:
    eq = {"contacts": 400, "replicas": 2, "seed": 1}
    delay = {"time": 1.0}
    contacts = {"thresholds": GAUSSIAN, "delay": delay}
    result = toolkit.run(scene(contacts=contacts, drive=HEAVY, master=None, eq=eq))
    found = panels(draw_run(result, Figure()))
    force, place, speed = (found[name] for name in ("F", "plot_position", "plot_velocity"))
    assert place.get_ylabel() == "position\n(units of length)"
    assert speed.get_ylabel() == "slider's speed\n(length/time)"
    own = result.eq.slips
    assert own.number.size >= 2
    for replica, line in enumerate(force.lines):
        x, y = line.get_data()
        here = own.replica == replica
        begin = (own.drive[here] - result.eq.balance) / HEAVY["velocity"]
        for start, lasts, before, after in zip(
            begin, own.duration[here], own.force_before[here], own.force_after[here], strict=True
        ):
            assert x[y == before] == pytest.approx(start)
            assert x[y == after] == pytest.approx(start + lasts)
    tops = [line.get_ydata() for line in speed.lines if line.get_marker() in MARKERS]
    np.testing.assert_array_equal(np.concatenate(tops), own.top_speed)


def test_no_legend_lies_over_data() -> None:
    many = [scene(GAUSSIAN, eq=EQ), scene(drive={"to": 6.0, "points": 61, "spring": 1.0}, eq=EQ)]
    figures = [draw_run(toolkit.run(one), Figure(layout="constrained")) for one in many]
    rough = scene(ROUGH, drive={"to": 5e-8, "points": 9})
    figures.append(draw_comparison(compare([toolkit.load_scene(rough)])))
    for figure in figures:
        drawn(figure)
        legends = [axes.get_legend() for axes in figure.axes] + figure.legends
        boxes = [one.get_window_extent() for one in legends if one is not None]
        assert boxes
        for axes in figure.axes:
            assert not any(
                box.overlaps(axes.get_window_extent().shrunk(0.99, 0.99)) for box in boxes
            )


def test_springs_of_a_sweep_have_error_bars_and_units() -> None:
    sweep = {"velocity": {"from": 1e-8, "to": 1e-4, "points": 3}, "critical_spring": True}
    contacts = {"thresholds": ROUGH, "delay": {"time": 1e-3}}
    drive = {"to": 1e-8, "points": 3, "area": 1e-6}
    result = toolkit.run(scene(contacts=contacts, drive=drive, sweep=sweep))
    axes = plot_points_spring(Figure().subplots(), result)
    assert axes.get_ylabel().endswith("N/m)") and axes.get_xlabel().startswith("speed $v$ (")
    (bars,) = axes.containers
    low, high = np.array([one[:, 1] for one in bars[2][0].get_segments()]).T
    own = result.sweep
    np.testing.assert_allclose(
        0.5 * (high - low), result.newtons(own.critical_spring_error), rtol=1e-6, atol=1e-9
    )
    np.testing.assert_allclose(0.5 * (high + low), result.newtons(own.critical_spring))


def test_the_slope_of_the_kinetic_force_is_drawn_where_it_is_straight_in_the_log_of_speed() -> None:
    """Of Eyring heat the slope is 0.0299 F_k(∞) at α = 0.03 (quadrature); contacts with a delay have
    F_k ~ 1/(1 + v τ/<x_s>), which falls in one decade alone."""
    heat = {"law": "eyring", "width": 0.03, "attempt_frequency": 1.0}
    wide = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    sweep = {"velocity": {"from": 1e-8, "to": 10.0, "points": 28}}

    def picture(**laws: Any) -> Any:
        given = {"contacts": {"thresholds": wide} | laws, "drive": None, "master": None}
        return plot_points(Figure().subplots(), toolkit.run(scene(**given, sweep=sweep)))

    axes = picture(thermal=heat)
    speed, force = axes.get_lines()[0].get_data()
    kinetic = float(master.kinetic_curve(origins.Contacts(origins.gaussian(1.0, 0.2))).force)
    slopes = np.diff(force) / np.diff(np.log(speed))
    np.testing.assert_allclose(slopes, 0.0299 * kinetic, rtol=0.01)
    assert speed[0] < 1e-7 and 1e-4 < speed[-1] < 0.03
    said = axes.get_legend().get_texts()[0].get_text()
    assert said == "slope $dF_k/d\\,\\ln v$ = 0.0156 N_c<k>·length", said
    bare = picture(delay={"time": 1.0})
    assert bare.get_legend() is None and len(bare.get_lines()) == 3  # a curve and its error bars


def test_a_sweep_over_thresholds_has_logarithmic_axes_and_says_whose_thresholds_are_drawn() -> None:
    sweep = {"contacts.thresholds.pressure": [1e4, 1e5, 1e6], "critical_spring": True}
    figure = toolkit.plot(toolkit.run(scene(ROUGH, drive=None, master=None, sweep=sweep)))
    force, density, springs = figure.axes
    assert density.get_title() == "thresholds, without the sweep"
    assert force.get_xscale() == force.get_yscale() == springs.get_yscale() == "log"


def test_a_picture_has_the_figure_with_its_axes(tmp_path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    figure = toolkit.plot(toolkit.run(scene()))
    assert isinstance(figure, Figure) and [one.get_label() for one in figure.axes] == ["F", "P"]
    figure.savefig(tmp_path / "picture.pdf")
    axes = Figure().subplots(1, 2)
    assert toolkit.plot(toolkit.run(scene()), axes) is axes[0].figure


def test_a_verdict_draws_the_sliders_of_so_many_contacts_that_disagree() -> None:
    """A few contacts slip on a spring on which infinitely many do not; a trace that is not known is not drawn."""
    own = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.3}}
    tables = {"contacts": own, "drive": {"spring": 0.9, "to": 3.0, "points": 5}}
    tables |= {"eq": {"contacts": 12}, "verdict": {"rules": ["reset"]}}
    found = verdict(toolkit.load_scene(tables, solved=False))
    trace = panels(draw_verdict(found))["trace"]
    assert found.finite[0].kind != found.own.behaviours[0].kind
    one, finite = trace.lines
    np.testing.assert_array_equal(finite.get_xdata(), found.finite[0].drive)
    assert "12 contacts" in finite.get_label() and one.get_label().endswith("smooth")
    unknown = dataclasses.replace(found.own.behaviours[0], error=np.inf, success=False)
    answer = dataclasses.replace(found.own, behaviours=(unknown,))
    lost = dataclasses.replace(found, answers=(answer,), finite=())
    assert "trace" not in panels(draw_verdict(lost))


def test_a_trace_that_ends_where_it_slides_has_a_line_at_the_force_of_sliding() -> None:
    few = Finite("reset", 900, "smooth", late=0.52, late_error=1e-3)
    for end, rises, lines in ((51.0, False, [0.52]), (90.0, False, []), (51.0, True, [])):
        trace = {"drive": np.array([0.0, 50.0, end]), "force": np.array([0.0, 0.5, 0.51])}
        one = dataclasses.replace(few, rises=rises, **trace)
        axes = Figure().subplots()
        draw_trace(axes, verdict_on(reading(infinite("smooth", 0)), finite=(one,)), letters=80)
        told = [line for line in axes.lines if line.get_label() == "force of smooth sliding"]
        assert [line.get_ydata()[0] for line in told] == lines


def test_a_verdict_is_a_table_in_a_notebook() -> None:
    tables = scene(drive={"spring": 0.5}, master=None) | {"verdict": {"rules": ["reset"]}}
    found = verdict(toolkit.load_scene(tables, solved=False))._repr_html_()
    assert "slip rule reset</th><td>stick-slip" in found and "critical spring K*" in found


def test_five_readings_have_five_marks_and_of_ten_the_own_one_stands_out() -> None:
    """A panel with ten curves in ten colours told none: the others are thin and grey, with one entry in the legend."""
    tables = scene(ROUGH, drive={"area": 1e-6}, master=None)
    tables["verdict"] = {"readings": ["gw/amontons"]}
    found = verdict(toolkit.load_scene(tables, solved=False))
    for number, named in ((5, 5), (10, 2)):
        figure = draw_verdict(dataclasses.replace(found, answers=found.answers * number))
        drawn = panels(figure)
        lines = [one for one in drawn["thresholds"].lines if len(one.get_xdata())]
        marks = [line.get_marker() for line in lines]
        inks = [(line.get_color(), str(line.get_linestyle())) for line in lines]
        assert len(lines) == number and len(set(zip(marks, inks, strict=True))) == named
        (legend,) = figure.legends
        names = [text.get_text() for text in legend.get_texts()]
        assert len(names) == named and ("gw: 9 other readings" in names) is (number == 10)
        assert lines[0].get_linewidth() > 2.0 * lines[1].get_linewidth() or number == 5
        assert drawn["springs"].get_xlabel().endswith("N/m)")


def test_marks_of_k_star_without_a_bar_say_which_errors_they_hide() -> None:
    """A law without samples has no sampling error to speak of; a bar that is seen needs no words."""
    tables = {"contacts": {"thresholds": WIDE}, "drive": {}}
    found = verdict(toolkit.load_scene(tables, solved=False))
    own = found.own.critical_spring
    for sampling, said in (
        (None, "no bar: numerical error\nsmaller than the mark"),
        (0.01 * own.value, "no bar: numerical and sampling\nerrors smaller than the mark"),
        (0.3 * own.value, None),
    ):
        critical = dataclasses.replace(own, sampling=sampling)
        answer = dataclasses.replace(found.own, critical_spring=critical)
        axes = Figure().subplots()
        draw_springs(axes, dataclasses.replace(found, answers=(answer,)))
        names = [text.get_text() for text in axes.get_legend().get_texts()] if said else [None]
        assert names == [said] and (said is None) == (axes.get_legend() is None)


@pytest.mark.slow  # K* of so narrow a peak takes long; quick: the other panels, above
def test_a_peak_narrower_than_the_panels_points_has_its_height() -> None:
    """It is cut off where the axis ends, and the panel says so."""
    parts = [{"kind": "gaussian", "mean": 1.0, "std": 0.3}]
    parts += [{"kind": "gaussian", "mean": 0.5, "std": 3e-4}]
    law = {"kind": "mixture", "components": parts, "weights": [0.7, 0.3]}
    tables = {"contacts": {"thresholds": law}, "drive": {}}
    found = verdict(toolkit.load_scene(tables, solved=False))
    axes = panels(draw_verdict(found))["thresholds"]
    density = axes.lines[0].get_ydata()
    exact = 0.5 * float(found.own.contacts.thresholds.pdf(0.5))
    assert density.max() == pytest.approx(exact, rel=1e-2)
    assert axes.get_ylim()[1] < 0.01 * exact
    assert [text.get_text() for text in axes.texts] == ["higher peaks are cut off"]


def test_a_picture_of_a_sweep_has_a_line_for_each_value_of_the_second_quantity() -> None:
    contacts = {"thresholds": GAUSSIAN, "thermal": {"law": "soft", "temperature": 0.3}}
    sweep = {"velocity": {"from": 1e-2, "to": 1e2, "points": 5}, "temperature": [0.1, 0.3]}
    result = toolkit.run({"contacts": contacts, "sweep": sweep})
    axes = Figure().subplots(1, 2)
    toolkit.plot(result, axes)
    assert axes[0].get_xscale() == "log" and len(axes[0].containers) == 2
    assert [text.get_text() for text in axes[0].get_legend().get_texts()] == [
        r"$k_BT/\langle k\rangle$ = 0.1 length²",
        r"$k_BT/\langle k\rangle$ = 0.3 length²",
    ]
    second = axes[0].containers[1].lines[0].get_ydata()
    np.testing.assert_array_equal(second, result.sweep.force[:, 1])


@pytest.mark.parametrize(
    ("key", "values", "symbol"),
    [
        ("drive.spring", ["50 N/m", "0.5 N_c<k>"], "$K$"),
        ("drive.mass", [0.1], r"$M/(N_c\langle k\rangle)$"),
        ("contacts.thermal.kelvin", [300.0], "$T$"),
        ("contacts.delay.time", [0.1], r"$\tau$"),
        ("contacts.thresholds.std", [0.1], "std"),
    ],
)
def test_a_legend_has_the_symbol_of_a_key(key: str, values: list[Any], symbol: str) -> None:
    assert symbol_of_key(key, last_words([key])[key], np.array(values)) == symbol


def test_a_sweep_over_a_spring_shows_forces_before_and_after_slips() -> None:
    sweep = {"drive.spring": [0.3, 0.6, 3.0]}
    table = GAUSSIAN | {"std": 0.2}
    result = toolkit.run(scene(table, drive={"to": 8.0, "points": 81}, sweep=sweep))
    axes = Figure().subplots(1, 2)
    toolkit.plot(result, axes)
    names = [text.get_text() for text in axes[0].get_legend().get_texts()]
    # on the stiffest spring it slides smoothly, which stands on the axis, too
    assert names[0] == "before the last slip (no mark: no slip)" and "kinetic force" in names[-1]
    assert axes[0].get_xlim()[1] > 3.0
    before = axes[0].containers[0].lines[0].get_ydata()
    np.testing.assert_array_equal(before, result.sweep["force_before_slip"])
    assert np.isfinite(before[:2]).all() and np.isnan(before[2])
    assert "force_before_slip" in result.sweep._ipython_key_completions_()
    # of several lines the axis names the force, in short lines, and the legend tells why marks are missing
    sweep |= {"contacts.thresholds.std": [0.2, 0.3]}
    axes = Figure().subplots()
    plot_points(axes, toolkit.run(scene(table, drive={"to": 8.0, "points": 81}, sweep=sweep)))
    assert axes.get_ylabel().splitlines()[1] == "before the last slip (units of length)"
    assert "no mark: no slip" in [text.get_text() for text in axes.get_legend().get_texts()]


@pytest.mark.parametrize("error", [*(slow(one) for one in (1e-9, 1e-2)), np.inf])
def test_what_is_not_solved_is_not_drawn(error: float) -> None:
    """An empty panel says why; beside the ensemble the legend says so, and nothing is compared."""
    result, beside = toolkit.run(scene()), toolkit.run(scene(eq=EQ))
    changes = {"success": error < 1e-8, "force_error": error, "message": "costs $ 5"}
    master = dataclasses.replace(result.master, **changes)
    axes = Figure().subplots(1, 2)
    drawn(toolkit.plot(dataclasses.replace(result, master=master), axes))
    assert [len(line.get_xdata()) for line in axes[0].lines] == [21] * (error < 1.0)
    said = [text.get_text() for text in axes[0].texts]
    assert said == ["the master equation is not solved:\ncosts $ 5"] * (error > 1.0)
    other = dataclasses.replace(beside, master=dataclasses.replace(beside.master, **changes))
    found = panels(drawn(draw_run(other, Figure())))
    (curve,) = (one for one in found["F"].lines if "master" in one.get_label())
    assert ("not solved" in curve.get_label()) == (error > 1.0)
    assert bool(deviation(other).points.size) == (error < 1.0)
    words = found["plot_deviation"].texts
    assert len(words) == (error > 1.0)
    place = found["plot_deviation"].get_window_extent()
    assert all(place.x0 < one.get_window_extent().x0 for one in words)


def test_powers_of_ten_stand_in_the_label() -> None:
    """Not above the axes, where the legend is, nor as products at each tick of less than a decade."""
    table = {"kind": "gaussian", "mean": 1e-9, "std": 1e-10}
    figure = draw_run(toolkit.run(scene(table, drive={"to": 5e-9, "points": 21})), Figure())
    force = panels(figure)["F"]
    assert force.get_ylabel().endswith(r"($10^{-10}$ units of length)")
    assert force.get_xlabel().endswith(r"($10^{-9}$ units of length)")
    shown = [float(text.replace("−", "-")) for text in ticks(force.yaxis)]
    np.testing.assert_allclose(1e-10 * np.array(shown), force.get_yticks(), atol=1e-20)
    assert not force.yaxis.get_offset_text().get_text()
    axes = Figure().subplots()
    axes.set(xscale="log", xlim=(0.4, 0.9))
    name_axis(axes.xaxis, "K", "")
    drawn(axes.figure)
    named = [text.get_text() for text in axes.get_xticklabels(which="minor")]
    assert {"0.5", "0.6"} <= {*named} and axes.get_xlabel() == "K"
    law = ROUGH | {"material": ROUGH["material"] | {"local_friction": 1e-5}}
    drive = {"to": 1e-12, "points": 11, "area": 1e-6}
    (over,) = panels(draw_run(toolkit.run(scene(law, drive=drive)), Figure()))["F"].child_axes
    assert over.get_ylabel() == r"$\mu = F$/load ($10^{-6}$)"


def test_a_sweep_over_springs_marks_where_they_pass_k_star() -> None:
    table, drive = GAUSSIAN | {"std": 0.2}, {"to": 2.0, "points": 5}
    for springs, passed in (([0.6, 3.0, 0.9, 1.2], True), ([0.6, 0.9], False)):
        sweep = {"drive.spring": springs, "critical_spring": True}
        result = toolkit.run(scene(table, drive=drive, sweep=sweep))
        force = draw_run(result, Figure()).axes[0]
        marks = [line for line in force.lines if line.get_label() == "$K = K^*$"]
        assert len(marks) == passed
        for mark in marks:
            expected = result.sweep.critical_spring[0]
            np.testing.assert_allclose(mark.get_xdata(), expected, rtol=1e-9)
            names = [text.get_text() for text in force.get_legend().get_texts()]
            assert "$K = K^*$" in names
    springs = ["1e4 N/m", "1e5 N/m"]
    sweep = {"drive.spring": springs, "critical_spring": True}
    drive = {"to": 1e-8, "points": 3, "area": 1e-6, "velocity": 1e-6}
    result = toolkit.run(scene(ROUGH, drive=drive, sweep=sweep, master=None))
    force = draw_run(result, Figure()).axes[0]
    (mark,) = (line for line in force.lines if line.get_label() == "$K = K^*$")
    expected = result.newtons(result.sweep.critical_spring[0])
    np.testing.assert_allclose(mark.get_xdata(), expected, rtol=1e-9)
    assert force.get_legend() is not None


def test_a_sweep_on_which_k_star_does_not_depend_says_so_in_place_of_a_flat_line() -> None:
    drive = {"to": 2.0, "points": 5, "spring": 0.9}
    for swept, flat in (
        ({"drive.spring": [0.6, 0.9]}, True),
        ({"contacts.thresholds.std": [0.1, 0.2]}, False),
    ):
        sweep = swept | {"critical_spring": True}
        result = toolkit.run(scene(GAUSSIAN | {"std": 0.2}, drive=drive, sweep=sweep))
        figure = draw_run(result, Figure())
        drawn_there = any("critical spring" in axes.get_ylabel() for axes in figure.axes)
        said = f"K* = {result.sweep.critical_spring[0]:.4g} N_c<k>, which does not depend on spring"
        assert drawn_there is not flat and (said in figure.get_suptitle()) is flat
    # along both the axis was the spring, on which nothing hangs, with a flat line for each std
    both = {"drive.spring": [0.6, 0.9], "contacts.thresholds.std": [0.1, 0.2]}
    result = toolkit.run(scene(drive=drive, sweep=both | {"critical_spring": True}))
    figure = draw_run(result, Figure())
    (panel,) = (axes for axes in figure.axes if "critical spring" in axes.get_ylabel())
    assert "std" in panel.get_xlabel() and len(panel.containers) == 1
    np.testing.assert_array_equal(panel.containers[0].lines[0].get_xdata(), [0.1, 0.2])
    assert "K* does not depend on spring" in figure.get_suptitle()


def test_a_critical_spring_below_its_numerical_error_is_not_compared() -> None:
    """Neither in the table nor in the picture; it may still be told below what it is."""
    verdicts = compare(
        [toolkit.load_scene(scene(ROUGH, drive={"area": 1e-6}, master=None), solved=False)]
    )
    (own, *others) = verdicts[0].readings
    errors = {
        key: dataclasses.replace(number, error=1.5 * number.value)
        for key, number in own.numbers.items()
        if key.startswith("critical_spring")
    }
    lost = dataclasses.replace(own, numbers=own.numbers | errors, unknown=True)
    (one,) = [dataclasses.replace(verdicts[0], readings=(lost, *others))]
    most = 2.5 * own.spring("N/m").value
    text = "\n".join(table([one]))
    assert f"not known, below {most:.2g}" in text and f"{own.spring('N/m').value:.3g}" not in text
    springs = draw_comparison([one]).axes[1]
    assert marks_of(springs)[0] == pytest.approx(most)
    assert springs.texts[0].get_text() == f"not known, below {written(most, 'N/m', digits=2)}"


@pytest.mark.slow  # quick: the same in the table of test_verdict.py
def test_islands_whose_critical_spring_hangs_on_smoothing_have_no_rank_by_it(
    monkeypatch: Any,
) -> None:
    """Neither in the table nor in the picture, where they would come first."""
    monkeypatch.setattr("toolkit.judge.describe.RESAMPLES", 2)
    law = {"kind": "domains", "law": "equal", "stiffness": 1.0, "samples": 200}
    law |= {"lattice_constant": 1.0, "mean_atoms": 30}
    drive = {"to": 0.5, "points": 6}
    each = [{"kind": "gaussian", "mean": 1.0, "std": 0.6}, law]
    scenes = [toolkit.load_scene(scene(one, drive=drive)) for one in each]
    verdicts = compare([dataclasses.replace(one, name=f"s{k}") for k, one in enumerate(scenes)])
    told = master.propensity(scenes[1].contacts).critical_spring
    assert told > verdicts[0].own.numbers["critical_spring"].value
    assert [one.name for one in verdicts] == ["s0", "s1"]
    text = table(verdicts)
    assert text[0].startswith("no rank by K* of s1: it hangs on the smoothing")
    assert sum("hangs on smoothing" in line for line in text) == 1
    assert np.isnan(verdicts[1].own.numbers["critical_spring"].value)
    springs = draw_comparison(verdicts).axes[1]
    assert list(marks_of(springs)) == [0]
    assert any("hangs on the smoothing" in one.get_text() for one in springs.texts)


def test_numerical_errors_that_nobody_sees_are_no_lines(monkeypatch: Any) -> None:
    """Of K* that is known to 1e-10 of itself, and of one with samples."""
    monkeypatch.setattr("toolkit.judge.describe.RESAMPLES", 3)
    few = {"kind": "from-samples", "x_s": [0.5, 0.8, 0.9, 1.0, 1.1, 1.3, 1.6]}
    for law, lines in ((GAUSSIAN, 0), (few, 1)):
        one = compare([toolkit.load_scene(scene(law, drive={"to": 1.0, "points": 5}))])
        springs = draw_comparison(one).axes[1]
        drawn_there = [each for each in springs.containers if hasattr(each, "has_xerr")]
        assert len(drawn_there) == lines
        said = [text.get_text() for text in springs.get_legend().get_texts()]
        assert ("its error, of samples two standard errors" in said) == bool(lines)
        # as the text tells where an order is undecided
        own = one[0].own.spring("N_c<k>")
        if lines:
            (_, (high, _)), *_ = drawn_there[0][2][0].get_segments()
            assert high == pytest.approx(own.value + 2.0 * own.error)


def test_springs_of_surfaces_with_areas_are_in_newtons_per_metre() -> None:
    drive = {"to": 1e-7, "points": 3}
    for own, label in ((drive | {"area": 1e-6}, "(kN/m)"), (drive, "(GN/m³)")):
        one = compare([toolkit.load_scene(scene(ROUGH, drive=own, master=None), solved=False)])
        springs = draw_comparison(one).axes[1]
        assert label in springs.get_xlabel()
        (place,) = marks_of(springs).values()
        assert springs.get_xlim()[0] < place < springs.get_xlim()[1]


def test_ticks_of_a_logarithmic_axis_are_in_the_unit_of_its_label() -> None:
    """K* and F_k of three areas go over four decades: each tick times its prefix is where the tick stands. The panels
    share one legend, with the last words of the keys."""
    table = {"kind": "gaussian", "mean": 1e-8, "std": 2e-9}
    stated = {"mean_stiffness": 10.0, "contact_density": 1e12}
    areas = [1e-8, 1e-6, 1e-4]
    sweep: dict[str, Any] = {"drive.area": areas, "contacts.thresholds.std": [1e-9, 2e-9]}
    contacts = {"thresholds": table, "interface": stated}
    sweep["critical_spring"] = True
    result = toolkit.run({"contacts": contacts, "sweep": sweep, "drive": {"area": 1e-6}})
    figure = drawn(draw_run(result, Figure(layout="constrained")))
    seen = {axes.get_ylabel().split(" $")[0]: axes for axes in figure.axes}
    for name, column in (
        ("force", "kinetic_force_newtons"),
        ("critical spring", "critical_spring_newtons"),
    ):
        axes, factor = seen[name], {"mN": 1e-3, "N": 1.0, "kN/m": 1e3, "MN/m": 1e6}
        assert axes.get_yscale() == "log"
        unit = axes.get_ylabel().partition("(")[2].rstrip(")")
        low, high = axes.get_ylim()
        values = result.sweep[column]
        assert low < values.min() and values.max() < high
        labels = [text.get_text() for text in axes.get_yticklabels()]
        ticks = zip(axes.get_yticks(), labels, strict=True)
        told = [(y, float(text)) for y, text in ticks if text and low < y < high]
        assert len(told) > 2
        for place, number in told:
            assert number * factor[unit] == pytest.approx(place, rel=1e-9) and number < 1e4
    assert seen["critical spring"].get_legend() is None
    names = [text.get_text() for text in seen["force"].get_legend().get_texts()]
    assert names == ["std = 1.00 nm", "std = 2.00 nm"]
