"""The friction trace in the picture of a verdict: the whole path, and beside it the last cycles of many."""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

from toolkit.pictures.axes import DASHES, OKABE_ITO, force_name, in_lines, legend_above, name_axis
from toolkit.pictures.traces import draw_curve, hides_swings
from toolkit.scene.scale import spoken, told_contacts, written
from toolkit.verdict.answers import Verdict
from toolkit.verdict.of_area import finite_told_apart
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.slips_in_words import does, kind_of_trace
from toolkit.verdict.text.kinds import named

# of the force, in mean thresholds: a trace of the master equation with a larger error is not drawn; one of the ensemble
# is a slider's own, and its error that of fewer contacts than there are
UNKNOWN = 0.1
# of the largest force: curves nearer than that are one in the picture
_ALIKE = 2e-3
# cycles on a path beyond which the last few of them are drawn again, as each is some 3 mm wide; and part of a path
# without cycles whose swings are too many to be drawn; of one with few the last part shows no more than that, or one
# and a half, in which there is a slip
_MANY, _LAST, _LAST_PART, _MOST_SHOWN, _A_CYCLE = 45, 6, 0.05, 0.25, 1.5
# of the range of a force: a smaller change is not seen in the picture; of a path, the part up to which it is cut where
# nothing happens any more
_SEEN, _MOST_OF_A_PATH = 0.01, 0.7
# of a path: on a shorter part at its end nobody sees that the force no longer rises: 40 thresholds are micrometres, and
# a soft spring loads over millimetres
_SLIDING = 0.05
Traced = TypeVar("Traced", Behaviour, Finite)


def traces_of(verdict: Verdict) -> list[list[Behaviour] | list[Finite]]:
    """The traces to draw, those that lie on one another together: of infinitely many contacts under each rule, and of
    one of the sliders of so many contacts where these do something else."""
    each = drawn(verdict)
    followed = [finite for finite in finite_told_apart(verdict).values() if finite.drive.size]
    # where they tell what the slider does, its trace is theirs
    followed = [one for one in followed if not any(one is own.finite for own in each)]
    return [*_alike(each), *_alike(followed)]


def drawn(verdict: Verdict) -> list[Behaviour]:
    """What the slider does under the rules whose force is known well enough to be drawn."""
    each = [one for one in verdict.own.behaviours if one.drive.size]
    return [one for one in each if one.error < UNKNOWN or one.contacts is not None]


def last_cycles(verdict: Verdict) -> float | None:
    """Where the last cycles begin that are drawn again (a length), as the whole path has too many; None where the whole
    path shows them."""
    begin = None
    for one, *_ in traces_of(verdict):
        end, way = float(one.drive[-1]), float(np.ptp(one.drive))
        last = _LAST_PART * way
        if one.period:
            last = max(min(_LAST * one.period, _MOST_SHOWN * way), _A_CYCLE * one.period)
        crowded = one.rule == "mass" and hides_swings(one.drive, one.force)
        if crowded or (one.period and way > _MANY * one.period):
            begin = min(end - min(last, way), np.inf if begin is None else begin)
    return begin


def draw_trace(axes: Any, verdict: Verdict, letters: int, since: float | None = None) -> None:
    """The spring's force against the drive, slips at their own places; `since`: from there on, without a legend."""
    scale, number_of_rules = verdict.own.scale, 0
    for number, alike in enumerate(traces_of(verdict)):
        one, rules = alike[0], named([each.rule for each in alike])
        style: dict[str, Any] = {"color": OKABE_ITO[number % len(OKABE_ITO)]}
        if isinstance(one, Behaviour):
            number_of_rules += 1
            style |= {"ls": DASHES[number], "lw": 1.3}
            whose = f"{told_contacts(one.contacts)}, " if one.contacts else ""
            label = f"{whose}{rules}: {_of_rule(verdict, one)}"
        else:
            label = f"{told_contacts(one.contacts)}, {rules}: {does(one)}"
            # thin, and above the others, which it may follow for long, as one of these another
            style |= {"lw": 0.8, "zorder": 4}
            style["ls"] = DASHES[(number - number_of_rules) % len(DASHES)]
        _draw_line(axes, verdict, one, (label, letters), style, since)
    axes.margins(x=0.01, y=0.05)
    if since is None:
        _draw_sliding_force(axes, verdict)
        _end_behind_events(axes, verdict)
    name, unit = force_name(scale)
    name_axis(axes.xaxis, "drive $X_T$", scale.length_unit)
    name_axis(axes.yaxis, name.replace("force", "spring force"), unit)
    if since is None:
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, 0.0), high)
        legend_above(axes, letters=letters)
    else:
        axes.set_title("the last part of the way", fontsize="small", loc="left")


def _draw_sliding_force(axes: Any, verdict: Verdict) -> None:
    """A dashed line at each force of smooth sliding that its trace does not show, as it ends where it slides."""
    label: str | None = "force of smooth sliding"
    for one, *_ in traces_of(verdict):
        force = one.late if isinstance(one, Finite) else one.after
        settled = not one.rises if isinstance(one, Finite) else one.swings is None
        shown = one.drive[-1] - _last_event(one) > _SLIDING * np.ptp(one.drive)
        if one.kind == "smooth" and settled and np.isfinite(force) and not shown:
            style: dict[str, Any] = {"color": "0.3", "ls": "--", "lw": 1.0, "zorder": 0}
            axes.axhline(force * verdict.own.scale.force, label=label, **style)
            label = None


def _end_behind_events(axes: Any, verdict: Verdict) -> None:
    """The axis of the drive ends at twice the way on which something happens, and says how far all goes on alike."""
    each = [one for one, *_ in traces_of(verdict)]
    begin, way = axes.get_xlim()[0], max(float(one.drive[-1]) for one in each)
    end = 2.0 * max(_last_event(one) for one in each)
    if not 0.0 < end < _MOST_OF_A_PATH * way:
        return
    axes.set_xlim(begin, end)
    until = spoken(way, verdict.own.scale.length_unit)
    place: dict[str, Any] = {"transform": axes.transAxes, "ha": "right", "fontsize": "small"}
    axes.text(0.99, 0.04, f"all goes on like this up to {until}", **place)


def _last_event(one: Behaviour | Finite) -> float:
    """Where along the drive (a length) a force is last off that at the end of its way by more than can be seen."""
    off = np.abs(one.force - one.force[-1]) > _SEEN * np.ptp(one.force)
    return float(one.drive[np.flatnonzero(off)[-1]]) if off.any() else 0.0


def _draw_line(
    axes: Any,
    verdict: Verdict,
    one: Behaviour | Finite,
    label: tuple[str, int],
    style: dict[str, Any],
    since: float | None,
) -> None:
    """A trace as a line, or as a band where a line would draw swings that do not exist; `label`: its text, in lines of
    so many letters."""
    text, letters = label
    shown = slice(0 if since is None else int(np.searchsorted(one.drive, since)), None)
    drive, force = one.drive[shown], one.force[shown]
    if not drive.size:  # its path ends before the last cycles of another one
        return
    swings = one.rule == "mass" and hides_swings(drive, force)
    text += "; a band, as its swings are too many to be drawn" * swings
    style = style | {"label": in_lines(text, letters)}
    draw_curve(axes, drive, force * verdict.own.scale.force, swings, style)


def _of_rule(verdict: Verdict, behaviour: Behaviour) -> str:
    """What a trace of infinitely many contacts shows, in words."""
    label, lasts = kind_of_trace(behaviour), behaviour.in_time.slip_time
    label += ", without heat" * behaviour.without_heat
    if lasts is not None and behaviour.after < 0.0 and not behaviour.slip_drive.size:
        # else the panel beside it shows that
        long = spoken(lasts, verdict.own.scale.time_unit)
        label += f" (below 0 the slider swings after a slip, {long} long)"
    if not behaviour.success or behaviour.error >= UNKNOWN:
        own = verdict.own
        error = behaviour.error * own.contacts.mean_threshold * own.scale.force
        label += f", error {written(error, own.scale.force_unit, digits=2)}"
    return label


def _alike(behaviours: Sequence[Traced]) -> list[list[Traced]]:
    """Behaviours in groups whose traces lie on one another, so that one curve stands for all of a group."""
    groups = list[list[Traced]]()
    for one in behaviours:
        alike = [group for group in groups if _on_one_curve(one, group[0])]
        if alike:
            alike[0].append(one)
        else:
            groups.append([one])
    return groups


def _on_one_curve(one: Behaviour | Finite, other: Behaviour | Finite) -> bool:
    """Whether two traces have the same points, as far as a picture shows."""
    if one.kind != other.kind or one.drive.shape != other.drive.shape:
        return False
    pairs = (one.drive, other.drive), (one.force, other.force)
    return all(np.abs(a - b).max() <= _ALIKE * np.abs(b).max() for a, b in pairs)
