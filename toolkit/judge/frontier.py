"""Runs of methods by error and run time: which are worth their time, how steep, what is cheapest when; all drawn."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from origins.thresholds.law import Array
from toolkit.pictures.axes import DASHES, INK, MARKERS, OKABE_ITO, legend_above

_INKS = {"master": INK["master"], "explicit": OKABE_ITO[5], "ensemble": INK["eq"]}
_INKS |= {"closest": OKABE_ITO[3]}
_STEPS = 20  # for each decade of the error, of the places where methods are compared
# Ratio of two run times below which another measurement may turn them round: on a machine that does other work, medians
# of the same call differ by up to as much.
_ALIKE = 1.5
# of the cheapest run's time, which mostly gets ready: above this a fifth of a run at most does
_READY = 5.0
# methods whose error is one of chance; by how much its log scatters, the largest error over a path being 1 to 4.4
# standard errors in each of 400 runs; and the error of an exponent above which it is not told
ONE_SEED = ("ensemble", "closest")
_CHANCE, _KNOWN = 0.3, 0.1


class Front(NamedTuple):
    """Run times in s, rising, and errors, falling, of the runs that no cheaper one beats."""

    run_time: Array
    error: Array


def front(points: Sequence[Mapping[str, Any]], method: str, floor: float) -> Front:
    """The front of a method, in which errors that are not known, or are below the `floor`, count as that much."""
    own = [point for point in points if point["method"] == method]
    kept, best = list[tuple[float, float]](), np.inf
    for point in sorted(own, key=lambda point: point["run_time"]):
        error = max(point["error"] or 0.0, floor)
        if error < best:
            kept.append((point["run_time"], error))
            best = error
    return Front(*np.array(kept).reshape(-1, 2).T)


class Slope(NamedTuple):
    """The exponent of error ~ (run time)^value, or ~ contacts^value, and its standard error."""

    value: float
    error: float


def slope(
    points: Sequence[Mapping[str, Any]], method: str, floor: float, along: str = "run_time"
) -> Slope | None:
    """The exponent of error ~ (run time)^exponent, fitted to the front of a method, or, `along` its "setting", of
    error ~ contacts^exponent, to all of its runs.

    Left out are errors below the floor, which the reference cannot tell, and of run times those below _READY times that
    of the cheapest run, which mostly get ready. Its error is that of the scatter about the straight line, and of
    methods of one seed that of chance at least. None for fewer than three runs, and where the error is above _KNOWN."""
    if along == "run_time":
        found = front(points, method, floor)
        some = found.error > floor
        some &= found.run_time > _READY * found.run_time.min(initial=np.inf)
        x, y = found.run_time[some], found.error[some]
    else:
        own = [p for p in points if p["method"] == method and (p["error"] or 0.0) > floor]
        x, y = np.array([(point[along], point["error"]) for point in own]).reshape(-1, 2).T
    if x.size < 3:
        return None
    log = np.log(x)
    value, rest, *_ = np.polyfit(log, np.log(y), 1, full=True)
    scatter = float(np.sqrt(rest.sum() / (x.size - 2)))
    if method in ONE_SEED:
        scatter = max(scatter, _CHANCE)
    error = scatter / float(np.sqrt(((log - log.mean()) ** 2).sum()))
    return Slope(float(value[0]), error) if error <= _KNOWN else None


def cheapest(points: Sequence[Mapping[str, Any]], floor: float) -> list[dict[str, Any]]:
    """Which method reaches an error in the shortest time, between its runs by straight lines on logarithmic axes: spans
    of errors from the largest to the smallest, each with `method`, `above`, `below` (None: any larger error), and
    `faster`, by how many times, at most, than the next one there (None: no other gets there)."""
    fronts = {name: front(points, name, floor) for name in {p["method"]: None for p in points}}
    fronts = {name: found for name, found in fronts.items() if found.error.size}
    if not fronts:
        return []
    ends = [bound for found in fronts.values() for bound in (found.error[0], found.error[-1])]
    # no place falls on a run itself, which would be within reach or not by round-off
    places = _STEPS * max(1, int(np.log10(max(ends) / min(ends)) + 1.0))
    errors = np.geomspace(max(ends), min(ends) * (1.0 + 1e-9), places)

    def cost(found: Front) -> Array:
        """The logarithm of the run time at each of the errors; inf where the method does not get there."""
        logs, times = np.log(found.error[::-1]), np.log(found.run_time[::-1])
        return np.interp(np.log(errors), logs, times, left=np.inf, right=times[-1])

    names = list(fronts)
    costs = np.array([cost(found) for found in fronts.values()])
    best = np.argmin(costs, axis=0)
    ordered = np.sort(np.append(costs, np.full((1, errors.size), np.inf), axis=0), axis=0)
    ahead = ordered[1] - ordered[0]
    spans, below = list[dict[str, Any]](), None
    for which, group in groupby(range(errors.size), key=lambda place: int(best[place])):
        own = list(group)
        above, most = float(errors[own[-1]]), float(ahead[own].max())
        faster = float(np.exp(most)) if most < np.inf else None
        spans.append({"method": names[which], "above": above, "below": below, "faster": faster})
        below = above
    return spans


def as_words(
    slopes: Mapping[str, Slope | None],
    spans: Sequence[Mapping[str, Any]],
    unit: str = "<x_s>",
    by_size: Mapping[str, Slope | None] | None = None,
) -> list[str]:
    """The slopes, by run time and `by_size` in contacts, and the crossings in words, errors in this unit, which is told
    where it is not <x_s>."""
    powers = [
        f"{method} as {what}^({one.value:.2f} ± {max(one.error, 0.01):.2f})"
        for what, each in (("time", slopes), ("contacts", by_size or {}))
        for method, one in each.items()
        if one is not None
    ]
    lines = [f"error falls: {', '.join(powers)}"] if powers else []
    if len(spans) > 1:
        cheapest_ones = []
        for span in spans:
            low, high = f"{span['above']:.0e}", f"{span['below'] or 0.0:.0e}"
            last = span is spans[-1]
            where = f"below {high}" if last else f"from {high} to {low}"
            where = (
                ("at every error" if last else f"above {low}") if span["below"] is None else where
            )
            faster = span["faster"] or np.inf
            chance = f" (by a factor of {faster:.2g}, which may be chance)"
            hardly = chance if faster < _ALIKE else ""
            cheapest_ones.append(f"{span['method']} {where}{hardly}")
        smallest = f"; no run was below {spans[-1]['above']:.0e}"
        smallest += f" {unit}" * (unit != "<x_s>")
        lines.append(f"cheapest: {', '.join(cheapest_ones)}{smallest}")
    return lines


def of_claims(points: Sequence[Mapping[str, Any]], floor: float) -> list[str]:
    """In how many runs the master equation's claim bounds the true error, in words; runs whose error is below the
    `floor`, which the reference cannot tell, are counted apart."""
    own = [p for p in points if p["method"] == "master" and p["error"] is not None]
    told = [p for p in own if p["error"] >= floor]
    bounded = sum(p["error"] <= p["claimed_error"] + floor for p in told)
    below = f"{len(own) - len(told)} are nearer to the reference than its own error"
    words = [f"its claim bounds the true error in {bounded} of {len(told)} runs"] if told else []
    words += [below] if len(told) < len(own) else []
    return [f"master: {'; '.join(words)}"] if own else []


def of_threads(found: list[dict[str, Any]]) -> list[str]:
    """The run times on several threads in words."""
    if not found:
        return []
    times = [f"{one['run_time']:.2g} s on {one['threads']}" for one in found]
    alike = all(one["same_bits"] for one in found)
    bits = "the same bits on all" if alike else "not the same bits: please report it"
    return [f"threads: ensemble of {found[0]['contacts']:,} contacts, {', '.join(times)}; {bits}"]


def draw_picture(found: dict[str, Any]) -> Any:
    """True error in its unit against run time in s, hollow marks for the errors that are claimed; a line joins
    the runs that no cheaper one beats, and pale marks are runs whose error the reference cannot tell from its own."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 6), layout="constrained")
    axes = figure.subplots()
    floor, unit = (
        found["reference_error"],
        found["error_unit"].replace("<x_s>", r"$\langle x_s\rangle$"),
    )
    for (method, colour), marker, dashes in zip(_INKS.items(), MARKERS, DASHES, strict=False):
        points = [point for point in found["points"] if point["method"] == method]
        if not points:
            continue
        run_time = [point["run_time"] for point in points]
        error = np.array([max(point["error"] or 0.0, floor) for point in points])
        claimed = [point["claimed_error"] or np.nan for point in points]
        above = np.where(error > floor, error, np.nan)
        axes.plot(run_time, above, marker, color=colour, label=method)
        axes.plot(run_time, np.where(error > floor, np.nan, floor), marker, color=colour, alpha=0.3)
        line = front(points, method, floor)
        axes.plot(line.run_time, line.error, ls=dashes, color=colour, lw=1)
        if np.isfinite(claimed).any():
            label = f"{method}: its claim"
            axes.plot(run_time, claimed, marker, mfc="none", mec=colour, label=label)
    axes.set(xscale="log", yscale="log", xlabel="run time (CPU-seconds of one thread)")
    axes.axhline(floor, color="0.4", lw=0.8, label="reference's error")
    if found["witness"] is not None:
        least = max(found["witness"]["standard_error"], 1e-9 * floor)  # 0 has no place
        axes.axhline(least, color="0.4", lw=0.8, ls=":", label="independent road's error")
    axes.set_ylabel(f"largest error of $F$ over the path, in {unit}")
    axes.grid(alpha=0.3)
    legend_above(axes, f"{found['title']}: against {found['reference']}", 85)
    return figure
