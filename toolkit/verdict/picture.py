"""The picture of a verdict: the friction trace, the threshold laws, and each reading's K* beside the spring."""

import re
from typing import Any, cast

import numpy as np

from origins.contacts import Contacts
from toolkit.pictures.axes import (
    DASHES,
    OKABE_ITO,
    force_name,
    in_lines,
    legend_above,
    name_axis,
    style_of,
)
from toolkit.scene.scale import SHARED, spoken
from toolkit.verdict.answers import Answer, Quantity, Verdict
from toolkit.verdict.sliders.machine import Machine
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.text.doubts import warnings
from toolkit.verdict.text.words import sentence
from toolkit.verdict.trace import draw_trace, drawn, last_cycles, traces_of
from toolkit.verdict.with_mass import in_its_own_time, rests_after

_DENSITY_POINTS = 400
# of a breakpoint: so near on both sides of it P_c is drawn, as it may jump or diverge there
_BESIDE = 1e-6
# readings that are told apart by colour and named in the legend; of more the others are grey
_NAMED = 5
# of a density that is drawn: the axis ends at so many times what this share of its points stays below
_HIGH, _MOST = 1.5, 0.98
# of the panels below the trace: heights with one reading, and more for each other one (in)
_LOW, _EACH = 2.8, 0.2
# letters of a line of the title, beyond which an answer is cut
_LONG = 110
# of an axis of springs, its least width as a factor: numerical errors alone would make ticks of many digits, and on
# less than two decades multiples of a power of ten are labelled, too, too near to one another in so narrow a panel
_LEAST_WIDTH = 120.0
# of a K*: an error whose bar does not stand out of its mark: half of its 7 points are 5.5 % of a value on an axis of
# that width, which has some 300 points
_WITHIN_THE_MARK = 0.05
# widths of P_c and the springs, of one reading and of several
_ONE_WIDE, _WIDE = (2.2, 1.0), (1.0, 1.0)


def draw_verdict(verdict: Verdict) -> Any:
    """The friction trace, the threshold laws and K* of each reading, on a figure of its own."""
    from matplotlib.figure import Figure

    pulled, many = bool(traces_of(verdict)), len(verdict.answers)
    low = _LOW + (1.2 + _EACH * many) * (many > 1)
    figure = Figure(figsize=(11, low + 4.4 * pulled), layout="constrained")
    slips = [one for one in drawn(verdict) if one.slip_drive.size]
    since = last_cycles(verdict) if pulled else None
    rows = figure.add_gridspec(1 + pulled, 1, height_ratios=[4.4] * pulled + [low])
    beside = [name for name, there in (("late", since is not None), ("slip", bool(slips))) if there]
    wide = (1.7 if len(beside) < 2 else 1.3, *(1.0 for _ in beside))
    places = _row(figure, rows[0], ("trace", *beside), wide) if pulled else {}
    places |= _row(figure, rows[-1], ("thresholds", "springs"), _WIDE if many > 1 else _ONE_WIDE)
    if pulled:
        draw_trace(places["trace"], verdict, letters=(150, 80, 40)[len(beside)])
    if since is not None:
        draw_trace(places["late"], verdict, 40, since)
    if slips:
        _draw_slip(places["slip"], verdict, slips[0], wide=since is None)
    _draw_thresholds(places["thresholds"], verdict)
    draw_springs(places["springs"], verdict)
    if len(verdict.answers) > 1:
        handles, labels = places["thresholds"].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize="small")
    doubt = ["do not trust this: the page says why"] * bool(warnings(verdict))
    doubt = [*doubt, _in_short(sentence(verdict)), *([] if pulled else _why_not_drawn(verdict))]
    title = "\n".join(map(in_lines, [verdict.title, *doubt]))
    figure.suptitle(title, fontsize="medium", parse_math=False)
    return figure


def _in_short(answer: str) -> str:
    """The answer as a title. The page has the rest: numbers of infinitely many contacts and of other readings, scatter,
    an assumed damping, and of an answer that is long the period."""
    answer = re.sub(r" \([^()]*(?:for infinitely many|scatter|of critical)[^()]*\)", "", answer)
    answer = answer.partition("; ")[0].partition(", with an assumed damping")[0]
    if answer.count("(") > answer.count(")"):  # a reason that goes on behind what was cut
        answer = answer.partition(" (")[0]
    return answer if len(answer) <= _LONG else answer.partition(" every ")[0]


def _row(
    figure: Any, place: Any, names: tuple[str, ...], widths: tuple[float, ...]
) -> dict[str, Any]:
    """Axes side by side, of these widths, by their names."""
    cells = place.subgridspec(1, len(widths), width_ratios=widths)
    return {name: figure.add_subplot(cells[k], label=name) for k, name in enumerate(names)}


def _draw_slip(axes: Any, verdict: Verdict, behaviour: Behaviour, wide: bool) -> None:
    """The first slip of a mass in its own time: the spring's force, and how far the slider has moved."""
    scale, other = verdict.own.scale, axes.twinx()
    seconds, moved = in_its_own_time(behaviour, cast(Machine, verdict.own.machine))
    force, place = ({"color": OKABE_ITO[k], "ls": DASHES[k], "lw": 1.3} for k in (0, 1))
    axes.plot(seconds, behaviour.slip_force * scale.force, label="spring force", **force)
    rests = rests_after(behaviour, cast(Machine, verdict.own.machine))
    until = f"at rest after {spoken(rests, scale.time_unit)}"
    still = "still moving where this ends" if np.isnan(rests) else until
    axes.plot([], [], label=f"slider's way, {still}", **place)
    other.plot(seconds, moved, **place)
    axes.axhline(0.0, color="0.8", lw=0.8, zorder=0)
    axes.margins(x=0.0)
    name, unit = force_name(scale)
    name_axis(axes.xaxis, "time since the first slip began", scale.time_unit)
    name_axis(axes.yaxis, name.replace("force", "spring force"), unit)
    name_axis(other.yaxis, "way of the slider", scale.length_unit)
    legend_above(axes, letters=60 if wide else 20)


def _why_not_drawn(verdict: Verdict) -> list[str]:
    """Why there is no friction trace of a slider that a spring pulls."""
    errors = [one.error for one in verdict.own.behaviours if one.drive.size]
    known = f"its force is known to {min(errors, default=0.0):.2g} <x_s> only: see friction.csv"
    why = known if errors else "no slider was followed"
    return [f"no friction trace is drawn, as {why}"] * bool(verdict.own.machine)


def _draw_thresholds(axes: Any, verdict: Verdict) -> None:
    """P_c of each reading as the density of ln x_s, whose area is 1 for each, as readings differ by orders of
    magnitude; where it diverges the axis ends."""
    top = highest = 0.0
    for number, answer in enumerate(verdict.answers):
        x, density = _density(answer.contacts)
        style = _style_of(number, verdict) | {"lw": 1.3 if number else 2.2, "ms": 4}
        # marks of different curves at different places, at even distances on the axes; one curve needs none
        style["markevery"] = (0.013 * (number % 8), 0.1)
        style["marker"] = style["marker"] if len(verdict.answers) > 1 else ""
        label = answer.name
        if number and len(verdict.answers) > _NAMED:
            marked = style | {"lw": 0.8}  # its curve has no marks, and its K* no dashes
            style |= {"lw": 0.8, "marker": "", "zorder": 1}
            kinds = [_model_of(one.name) for one in verdict.answers]
            own = kinds[number]
            alike = kinds[1:].count(own)
            others = f"{alike} other reading{'s' * (alike > 1)}"
            label = ""
            if own not in kinds[1:number]:
                axes.plot([], [], label=f"{own}: {others}", **marked)
        axes.plot(x, density, label=label or None, **style)
        # where contacts share one value the density is infinite
        whole: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "color": style["color"]}
        axes.vlines(answer.contacts.thresholds.atoms[0], 0.0, 1.0, lw=style["lw"], **whole)
        # of a density that diverges the highest points hang on where it is drawn; a narrow peak leaves the rest flat
        evenly = np.interp(np.geomspace(x[0], x[-1], _DENSITY_POINTS), x, density)
        top = max(top, min(density.max(), _HIGH * np.quantile(evenly, _MOST)))
        highest = max(highest, density.max())
    if highest > 1.1 * top:
        above: dict[str, Any] = {"transform": axes.transAxes, "va": "top", "fontsize": "small"}
        axes.text(0.02, 0.96, "higher peaks are cut off", **above)
    axes.set_xscale("log")
    axes.set_ylim(0.0, 1.1 * top or 1.0)
    name_axis(axes.xaxis, "threshold $x_s$", verdict.own.scale.length_unit)
    axes.set_ylabel("$x_s\\,P_c(x_s)$\nper unit of $\\ln x_s$")


def _style_of(number: int, verdict: Verdict) -> dict[str, Any]:
    """Colour, dashes and mark of a reading: of many, all but the scene's own are grey, alike where their contact model
    is."""
    if number and len(verdict.answers) > _NAMED:
        kinds = list(dict.fromkeys(_model_of(one.name) for one in verdict.answers[1:]))
        alike = style_of(1 + kinds.index(_model_of(verdict.answers[number].name)))
        return alike | {"color": "0.5"}
    return style_of(number)


def _model_of(name: str) -> str:
    """The contact model of a reading, such as "gw" or "gw, mixed"."""
    model, _, *regime = name.partition(",")[0].split("/")
    return ", ".join([model, *regime])


def _density(contacts: Contacts) -> tuple[Any, Any]:
    """x and x P_c(x), the density of ln x."""
    law = contacts.thresholds
    low, high = float(law.ppf(1e-3)), float(law.isf(1e-4))
    beyond = 0.05 * (high - low) or 0.05 * high  # one exact value has no width
    low, high = max(low - beyond * (low == high), 1e-6 * high), high + beyond
    # a peak may be narrower than a step of the axis: quantiles lie as close as its weight asks for
    dense = law.ppf(np.linspace(1e-3, 1.0 - 1e-4, _DENSITY_POINTS))
    beside = np.multiply.outer([1.0 - _BESIDE, 1.0 + _BESIDE], law.breakpoints).ravel()
    x = np.unique(np.concatenate([np.geomspace(low, high, _DENSITY_POINTS), dense, beside]))
    x = x[(x >= low) & (x <= high)]
    density = x * law.pdf(x)
    finite = np.isfinite(density)
    return x[finite], density[finite]


def draw_springs(axes: Any, verdict: Verdict) -> None:
    """K* of each reading as a mark with its error, and the machine's spring."""
    rows, scale = list(enumerate(verdict.answers)), verdict.own.scale
    marked = [one for row, one in rows if _draw_spring(axes, row, one, _style_of(row, verdict))]
    said = _without_bars(marked)
    if said:
        axes.plot([], [], "o", color="0.4", ms=7, label=said)
    axes.set_yticks([row for row, _ in rows], [one.name for _, one in rows], fontsize="small")
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xscale("log")
    springs = [one.machine.spring * one.scale.spring for _, one in rows if one.machine]
    if springs and not axes.containers:  # no K* is a point, which would set the axis
        axes.set_xlim(0.1 * min(springs), 10.0 * max(springs))
    if springs and np.ptp(springs) <= 1e-9 * max(springs):
        axes.axvline(springs[0], color="0.3", ls="--", lw=1.2, label="the machine's spring $K$")
    elif springs:
        style: dict[str, Any] = {"color": "0.3", "ms": 14, "label": "the machine's spring $K$"}
        axes.plot(springs, [row for row, one in rows if one.machine], "|", **style)
    axes.margins(x=0.1)
    low, high = axes.get_xlim()
    if axes.containers and high < _LEAST_WIDTH * low:
        middle, half = np.sqrt(low * high), _LEAST_WIDTH**0.5
        axes.set_xlim(middle / half, middle * half)
    legend_above(axes)
    unit = scale.spring_unit
    name = {"N/m": "$K^*$", "N/m³": "$K^*/A$"}.get(unit, r"$K^*/(N_c\langle k\rangle)$")
    own, said = verdict.own, f"slips at least once below\nthe critical spring {name}"
    if own.machine is not None and own.machine.mass:
        said = f"balance unstable somewhere below\nthe critical spring {name}"
    if own.contacts.in_time:
        said = f"steepest fall of the force\nof a rigid slider as fast\nas the drive, {name}"
    name_axis(axes.xaxis, said, "" if unit == SHARED else unit)


def _without_bars(marked: list[Answer]) -> str:
    """Which errors are smaller than the marks of K* that show no bar: none of other samples where it is not known, as
    of a single scan; "" where each has a bar."""
    each = [one.critical_spring for one in marked]
    hidden = [one for one in each if _error_of(one) <= _WITHIN_THE_MARK * one.value]
    known = all(one.sampling is not None for one in hidden)
    errors = "numerical and sampling\nerrors " if known else "numerical error\n"
    return f"no bar: {errors}smaller than the mark" if hidden else ""


def _error_of(critical_spring: Quantity) -> float:
    """The larger of the numerical error and the scatter of other samples."""
    return max(critical_spring.error, critical_spring.sampling or 0.0)


def _draw_spring(axes: Any, row: int, answer: Answer, style: dict[str, Any]) -> bool:
    """One reading's K*, an infinite one in words, as is one of 0; whether it is a mark."""
    value = answer.critical_spring.value * answer.scale.spring
    if answer.smoothed or answer.critical_spring.lost or not 0.0 < value < np.inf:
        said = "slips on every spring" if value else "slips on no spring"
        if not value and answer.critical_spring.sampling:
            said = "slips on no spring by these samples"
        if answer.critical_spring.unknown:
            said = "not found in time"
        if answer.critical_spring.lost:
            said = "not known"
        if answer.smoothed:
            said = "not known: it hangs on the smoothing of $P_c$"
        place: dict[str, Any] = {"transform": axes.get_yaxis_transform(), "va": "center"}
        # the machine's spring may stand behind the words
        place["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        axes.text(0.02, row, said, fontsize="small", **place)
        return False
    error = _error_of(answer.critical_spring)
    bars: dict[str, Any] = {"fmt": style["marker"], "color": style["color"], "ms": 7, "capsize": 4}
    axes.errorbar([value], [row], xerr=[error * answer.scale.spring], **bars)
    return True
