"""The picture of a verdict: the friction trace, the threshold laws, and each reading's K* beside the spring."""

from pathlib import Path
from typing import Any

import numpy as np

from origins.contacts import Contacts
from toolkit.scene.scale import Scale
from toolkit.verdict.judge import Answer, Verdict
from toolkit.verdict.words import NAMED, sentence

# by Okabe and Ito, which colour-blind readers distinguish; dashes keep coinciding curves visible
_INK = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]
_DASHES: list[Any] = ["-", (0, (5, 3)), (0, (1.5, 2)), (0, (6, 2, 1, 2))]
_DENSITY_POINTS = 400


def save_verdict_picture(verdict: Verdict, path: Path) -> None:
    """Draw the verdict as a PNG, on a figure of its own."""
    from matplotlib.figure import Figure

    pulled = bool(verdict.own.behaviours)
    figure = Figure(figsize=(11, 8 if pulled else 4.6), layout="constrained")
    rows: list[Any] = [["trace", "trace"]] * pulled + [["thresholds", "springs"]]
    places = figure.subplot_mosaic(rows)
    if pulled:
        _draw_trace(places["trace"], verdict)
    _draw_thresholds(places["thresholds"], verdict)
    _draw_springs(places["springs"], verdict)
    figure.suptitle(
        f"{verdict.title}\n{sentence(verdict)}", fontsize="medium", parse_math=False, wrap=True
    )
    figure.savefig(path, dpi=150, format="png")


def _engineering(axis: Any, unit: str) -> None:
    """Ticks with a prefix and a unit, such as 250 mN, for units that take one."""
    from matplotlib.ticker import EngFormatter

    if unit in ("m", "s", "N", "N/m", "Pa", "N/m³"):
        axis.set_major_formatter(EngFormatter(unit=unit))


def _draw_trace(axes: Any, verdict: Verdict) -> None:
    """The spring's force against the drive for each rule, slips at their own places."""
    own = verdict.own
    scale = own.scale
    shown = [one for one in own.behaviours if one.drive.size]
    for number, behaviour in enumerate(shown):
        dashes = _DASHES[number % len(_DASHES)]
        style = {"color": _INK[number % len(_INK)], "ls": dashes, "lw": 1.3}
        label = f"{NAMED[behaviour.rule]}: {behaviour.kind}"
        axes.plot(behaviour.drive, behaviour.force * scale.force, label=label, **style)
    axes.set_xlabel("drive $X_T$")
    axes.set_ylabel("spring force $K(X_T - X)$")
    _engineering(axes.xaxis, scale.length_unit)
    _engineering(axes.yaxis, scale.force_unit)
    axes.margins(x=0.01, y=0.15)
    lowest = min((float(one.force.min()) * scale.force for one in shown), default=0.0)
    axes.set_ylim(bottom=min(1.1 * lowest, 0.0))
    if shown:
        axes.legend(fontsize="small", loc="upper right", ncols=len(shown))


def _draw_thresholds(axes: Any, verdict: Verdict) -> None:
    """P_c of each reading, each to its own peak, as readings differ by orders of magnitude."""
    unit = verdict.own.scale.length_unit
    for number, answer in enumerate(verdict.answers):
        x, density = _density(answer.contacts)
        axes.plot(x, density, label=answer.name, **_style(number))
    axes.set_xscale("log")
    axes.set_xlabel("threshold $x_s$")
    axes.set_ylabel("$x\\,P_c(x)$ over its peak")
    _engineering(axes.xaxis, unit)
    axes.set_ylim(0.0, 1.1)
    axes.legend(fontsize="x-small")


def _style(number: int) -> dict[str, Any]:
    """Colour and dashes of the reading of this number."""
    dashes = _DASHES[number // len(_INK) % len(_DASHES)]
    return {"color": _INK[number % len(_INK)], "ls": dashes, "lw": 1.3 if number else 2.2}


def _density(contacts: Contacts) -> tuple[Any, Any]:
    """x and x P_c(x), the density of ln x, over its largest value."""
    law = contacts.thresholds
    low, high = float(law.ppf(1e-3)), float(law.isf(1e-4))
    x = np.geomspace(max(low, 1e-6 * high), 1.05 * high, _DENSITY_POINTS)
    density = x * law.pdf(x)
    finite = np.isfinite(density)
    top = density[finite].max(initial=0.0)
    return x[finite], density[finite] / (top or 1.0)


def _draw_springs(axes: Any, verdict: Verdict) -> None:
    """K* of each reading as a bar, with its error, and the machine's spring as a mark."""
    rows, scale = list(enumerate(verdict.answers)), verdict.own.scale
    for row, (number, answer) in enumerate(rows):
        _bar(axes, row, number, answer)
    axes.set_yticks(range(len(rows)), [one.name for _, one in rows], fontsize="small")
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("critical spring $K^*$: softer springs slip")
    _engineering(axes.xaxis, scale.spring_unit)
    axes.tick_params(axis="x", labelrotation=30)
    _mark_machine(axes, rows, scale)


def _bar(axes: Any, row: int, number: int, answer: Answer) -> None:
    """One reading's K*; an infinite one is said in words, as is one of 0."""
    value = answer.critical_spring.value * answer.scale.spring
    if not 0.0 < value < np.inf:
        said = "slips on every spring" if value else "never slips before it turns"
        axes.text(
            0.02, row, said, va="center", fontsize="small", transform=axes.get_yaxis_transform()
        )
        return
    error = max(answer.critical_spring.error, answer.critical_spring.sampling or 0.0)
    axes.plot([value], [row], "o", color=_INK[number % len(_INK)])
    axes.errorbar(
        [value], [row], xerr=[error * answer.scale.spring], color=_INK[number % len(_INK)]
    )


def _mark_machine(axes: Any, rows: list[tuple[int, Answer]], scale: Scale) -> None:
    """The machine's spring: one line where it is the same for all readings, else a mark a reading."""
    springs = [one.machine.spring * one.scale.spring for _, one in rows if one.machine]
    if not springs:
        return
    axes.axvline(springs[0], color="0.3", ls="--", lw=1.2, label="the machine's spring $K$")
    axes.legend(fontsize="small", loc="best")
