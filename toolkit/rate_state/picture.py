"""The picture of rate and state: both velocity steps with a, b and D_c marked, and the peak after rests."""

from typing import Any

import numpy as np

from toolkit.pictures.axes import (
    DASHES,
    OKABE_ITO,
    force_name,
    in_lines,
    legend_above,
    name_axis,
    name_over_load,
)
from toolkit.rate_state.judge import Judged

# slip after a step that is drawn, in D_c or in slips of the direct effect, and before the step, of that after it
SHOWN, BEFORE = 6.0, 0.15


def draw_rate_state(judged: Judged) -> Any:
    """The steps and, where there are some, the rests on a figure of its own."""
    from matplotlib.figure import Figure

    rests = bool(judged.found.rests)
    figure = Figure(figsize=(12 if rests else 8, 5.4), layout="constrained")
    panels = figure.subplots(1, 1 + rests, squeeze=False)[0]
    for draw, axes in zip((draw_steps, draw_rests), panels, strict=False):
        draw(axes, judged)
        name_over_load(axes, judged.scale)
    title = judged.title if rests else f"{judged.title}; no rest was followed"
    figure.suptitle(in_lines(title, 110 if rests else 75), fontsize="medium", parse_math=False)
    return figure


def draw_steps(axes: Any, judged: Judged) -> None:
    """The force against the slip since a step up and one down, the law beside them, and its numbers."""
    found, scale = judged.found, judged.scale
    distance = found.slip_distance.value
    direct = found.direct_slip * found.a.known
    lengths = [each for each in (direct, distance) if each > 0.0]
    slip = found.steps[0].slip
    far = min(SHOWN * max(lengths, default=judged.mean_threshold), float(slip[-1]))
    shown = slip <= far
    for number, (step, law) in enumerate(zip(found.steps, found.law_steps, strict=True)):
        change, before = "up" if step.log_ratio > 0.0 else "down", [step.steady_before] * 2
        places = np.r_[-BEFORE * far, 0.0, slip[shown]]
        style: dict[str, Any] = {"color": OKABE_ITO[number], "lw": 1.6}
        axes.plot(
            places, np.r_[before, step.force[shown]] * scale.force, label=f"speed {change}", **style
        )
        style |= {"ls": DASHES[2], "lw": 1.2, "label": f"{found.law.evolution} law, {change}"}
        if np.isfinite(distance):
            axes.plot(places, np.r_[before, law[shown]] * scale.force, **style)
    if found.a.known and found.b.known:
        _mark_numbers(axes, judged, far)
    axes.set_xlim(-BEFORE * far, far)
    name_axis(axes.xaxis, "slip since the step", scale.length_unit)
    name_axis(axes.yaxis, *force_name(scale))
    legend_above(axes)


def _mark_numbers(axes: Any, judged: Judged, far: float) -> None:
    """Arrows for a, b and a - b of the step up, and a line at D_c."""
    found, force = judged.found, judged.scale.force
    up = found.steps[0]
    low, end = up.steady_before * force, up.steady_after * force
    high = low + found.a.value * up.log_ratio * force
    ratio = up.after / up.before
    factor = "" if abs(ratio - np.e) < 1e-9 else rf"\,\ln {ratio:.3g}"
    style = {"arrowstyle": "<->", "color": "0.3", "lw": 1.0, "shrinkA": 0.0, "shrinkB": 0.0}
    marks = {"a": (-0.1, low, high), "b": (0.7, end, high), "(a-b)": (0.85, low, end)}
    for name, (place, foot, top) in marks.items():
        if foot != top:
            axes.annotate("", (place * far, foot), (place * far, top), arrowprops=style)
            middle = (place + 0.01) * far, 0.5 * (foot + top)
            axes.text(*middle, f"${name}{factor}$", fontsize="small", va="center")
    for level in (low, high, end):
        axes.axhline(level, color="0.8", lw=0.6, zorder=0)
    if found.slip_distance.value > 0.0:
        axes.axvline(found.slip_distance.value, color="0.5", lw=0.9, ls=":", label="$D_c$")


def draw_rests(axes: Any, judged: Judged) -> None:
    """The peak after a rest, the ageing law's, and the healing rate, against the time at rest."""
    found, scale = judged.found, judged.scale
    times = np.array([one.time for one in found.rests])
    peaks = {
        "largest force after a rest": np.array([one.peak for one in found.rests]),
        "ageing law": np.asarray(found.law_rests),
    }
    for number, (name, values) in enumerate(peaks.items()):
        style: dict[str, Any] = {"color": OKABE_ITO[2 + number], "ls": DASHES[2 * number]}
        axes.plot(times, values * scale.force, label=name, marker="os"[number], ms=4, **style)
    if found.healing is not None:
        ends = np.array([found.healing.low, found.healing.high])
        begin = next(one.peak for one in found.rests if one.time == ends[0])
        line = begin + found.healing.value * np.log10(ends / ends[0])
        axes.plot(ends, line * scale.force, color="0.2", lw=4.0, alpha=0.35, label="healing rate")
    axes.axhline(found.kinetic_force * scale.force, color="0.6", lw=0.8, label="$F_k$")
    axes.set_xscale("log")
    name_axis(axes.xaxis, "time at rest", scale.time_unit)
    name_axis(axes.yaxis, *force_name(scale, "F_s"))
    legend_above(axes)
