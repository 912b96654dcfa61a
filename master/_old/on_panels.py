"""Any path in time, by collocation: panels made shorter until the force along it changes by less than the tolerance."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from master._old.bends import bends, beside
from master._old.collocation import Course, TooMuch
from master._old.forward import ROUND_OFF
from master._old.jumps import Jump, jumps
from master._old.make_lives import make_generations
from master._old.panels import MOST_NODES, Scales, panels
from master._old.reading import read, unread, unsure
from master._old.timeline import Piece, pieces, times, where
from master.outcome import Progress, unheard
from origins import Contacts, Drive, InputError
from origins.errors import refuse

Array = npt.NDArray[np.float64]

_COARSEST, _FINER = 0.4, 1.15
_ACCURACY, _FALLS = 3e-4, 0.12
_SURE, _SUDDEN = 1.1, 0.1  # of the last change, and of the one before
_BOTH, _LACKS = 0.8, 0.1  # of the last change and what B lacks, multiplied; of what B lacks
_UNREAD = 0.3
_SLIGHT = 0.01  # of what B lacks: a first change that tells nothing
_STUCK, _MORE = 0.5, 1.3  # changes that do not fall
_LENGTH = 1.5  # widths of the law
_FIRST = 0.5  # of k_BT/<k x>
_WEAKEST = 1e-6  # of the contacts
_RATE = 1.0
_ORDERS = 2
_WATCH = 4
_MOST_WORK = 2.5e9  # takes some fifteen seconds
_LEFT = 4.0  # of the error of strands that age one part in so many is left with each level
_FIRST_WORK = 0.3  # of the most
_MOST_PANELS = 5_000
_GLANCE = 0.03  # of the most, where even these would not do
_MOST_LEVELS = 12
_TORN = 1e-3  # more than that is left where rounding decides what breaks
_HARDLY = 2.0  # times what is known of single contacts: steps have nothing to add
_EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Found:
    """Force (lengths) and holding at the times asked for, error estimate in mean thresholds, nodes in time, the last
    course, and the reason for stopping short."""

    force: Array
    holding: Array
    error: float
    nodes: int
    course: Course | None
    message: str


def follow(contacts: Contacts, drive: Drive, tolerance: float, progress: Progress = unheard) -> Found:
    """Force on a rigid slider that moves as the drive says, for contacts with any laws but growing thresholds."""
    unit, delay = contacts.mean_threshold, 0.0 if contacts.delay is None else contacts.delay.time
    asked, course = times(drive), pieces(drive)
    lives = make_generations(contacts, course)
    if not course:
        force, holding = (np.full(asked.size, x) for x in lives.start[::-1])
        return Found(force, holding, lives.error + ROUND_OFF, 0, None, "")
    first = _first(contacts, lives.length)
    start = _start(contacts, course[0], first)
    scales = Scales(_LENGTH * lives.length, first, lives.time, lives.rate / _RATE, start)
    edges, sharp = _edges(contacts, course, delay)
    if sharp and sharp[-1].end > course[-1].end:
        course = _beyond(course, sharp[-1])
        edges, sharp = _edges(contacts, course, delay)
    needed, fine = _needed(course, scales), _COARSEST
    lost, torn, exact = sharp is None, _torn(course, sharp), _exact_again(contacts)
    if needed > _MOST_PANELS:
        too_long(contacts, course, MOST_NODES * needed, f"{MOST_NODES * _MOST_PANELS:,} are the most", scales.rate)
    watch = np.concatenate([_watched(a, b) for a, b in pairwise(edges.tolist())])
    place = np.append(drive.path, [where(course, time) for time in watch])
    everywhere = np.append(asked, watch)
    speed = max(abs(piece.travel) / piece.duration for piece in course)
    rounding = _EPSILON * speed * float(asked[-1]) / unit
    best: Found | None = None
    before: Array | None = None
    raw: list[Array] = []
    worked = 0.0
    changes: list[float] = []
    for level in range(_MOST_LEVELS):
        cut = panels(course, edges[1:-1], sharp, scales, fine, level)
        if level:
            lives = make_generations(contacts, course, level)
        accuracy = np.inf if lost else max(_ACCURACY * _FALLS**level, lives.error, 10.0 * rounding)
        share = _GLANCE if lost or (exact and not level) else 1.0 if level else _FIRST_WORK
        try:
            found = Course(lives, cut, delay, accuracy, share * _MOST_WORK - worked)
        except TooMuch:
            if best is not None:
                break
            if exact:
                raise InputError(
                    "contacts.reforming: contacts of exact thresholds that form again at many stretches break at "
                    "another moment from each, more than can be followed on this path; give them a width, such as "
                    "gaussian(1.0, 0.02), re-form at one stretch, or move straight on at one speed"
                ) from None
            too_long(contacts, course, MOST_NODES * needed, "to follow all contacts takes minutes", scales.rate)
        worked += found.work
        count = sum(panel.count for panel in found.panels)
        answer = np.stack([read(found, everywhere, place, row) for row in (found.force, found.holding)])
        if contacts.ageing is not None:
            raw.append(answer)
            if len(raw) > 1:
                answer = answer + (answer - raw[-2]) / (_LEFT - 1.0)
        if before is not None and (len(raw) > 2 or contacts.ageing is None):
            changes.append(float(np.abs(answer - before)[0].max()) / unit)
        before = answer
        error = np.inf
        if not lost:
            error = max(left(changes, found.lacks), _UNREAD * unread(found, asked, unit))
            error = max(error, unsure(found, asked, drive.path, torn) / unit)
            error += rounding + ROUND_OFF * (1.0 + count) + lives.error
        if len(raw) == 2 and not lost:
            # what is extrapolated is better than that, but nothing tells by how much if nothing finer follows
            error = left([float(np.abs(raw[1] - raw[0])[0].max()) / unit], found.lacks) + lives.error
        progress(error)
        if best is None or error < best.error or len(changes) == 2 or len(raw) == 3:
            best = Found(answer[0, : asked.size], answer[1, : asked.size], error, count, found, "")
        more = worked + found.work * _FINER**2
        # the panels that matter may be the same in the first two answers
        known = len(raw) != 2 and (len(changes) != 1 or changes[0] > _SLIGHT * found.lacks)
        if known and (best.error <= tolerance or error < _HARDLY * lives.error):
            break
        stuck = torn is not None and level > 1 and best.error > _TORN
        if lost or stuck or (changes and more > _MOST_WORK):
            break
        fine *= _FINER
    assert best is not None
    return replace(best, message=_words(best, tolerance, lives.error, torn, lost))


def left(changes: list[float], lacks: float) -> float:
    """What the last answer is off by, from the changes of answers that get better and better, and from what the
    polynomials lack; each alone is at times small by chance."""
    if not changes:
        return np.inf
    before, last = [0.0, *changes][-2:]
    sure = _MORE if last > _STUCK * before > 0.0 else _SURE
    return max(sure * last, _SUDDEN * before, _BOTH * float(np.sqrt(last * lacks)), _LACKS * lacks)


def too_long(contacts: Contacts, course: list[Piece], steps: float, most: str, rate: float) -> NoReturn:
    """InputError for a path along which contacts do too much: `steps` in time that resolve it, `rate` at which fresh
    ones break by themselves (per time)."""
    travel = sum(abs(piece.travel) for piece in course) / contacts.mean_threshold
    moving = sum(piece.duration for piece in course if piece.travel != 0.0)
    if contacts.thermal is not None and rate * moving > travel:
        refuse(
            "contacts.thermal.attempt_frequency",
            contacts.thermal.attempt_frequency,
            f"fresh contacts break within a time of {1.0 / rate:.1g}, and the path moves for {moving:.3g}: some "
            f"{steps:.0e} steps in time resolve that, and {most}; slide faster, end the path sooner, or make it lower",
        )
    refuse(
        "path",
        f"{travel:.3g} mean thresholds in all",
        f"some {steps:.0e} steps in time resolve what contacts do on it, and {most}; end it sooner",
    )


def _exact_again(contacts: Contacts) -> bool:
    """Whether exact thresholds meet births at many stretches: each of these breaks at a moment of its own."""
    again = contacts.reforming
    return again is not None and not again.law.is_single and contacts.thresholds.atoms[0].size > 0


def _torn(course: list[Piece], sharp: list[Jump] | None) -> Jump | None:
    """Where the path turns or stops just as many contacts are stretched to their thresholds at places that are not
    known to rounding: whether they break is luck."""
    ends = np.array([piece.end for piece in course[:-1]])
    unsure = (one for one in sharp or [] if one.spot is None and ((ends >= one.begin) & (ends <= one.end)).any())
    return next(unsure, None)


def _words(found: Found, tolerance: float, known: float, torn: Jump | None, lost: bool) -> str:
    if not np.isfinite(found.error) and not lost:
        return "to follow all contacts in more detail takes minutes, so that no error is known; end the path sooner"
    if not np.isfinite(found.error):
        return "breaks at exact thresholds come at more times than can be followed; give the values a width"
    reached = f"error estimate {found.error:.1e} with {found.nodes} steps in time, above the tolerance {tolerance:.1e}"
    if torn is not None:
        met = f"at t = {torn.time:.6g} the path changes just as exact thresholds are met"
        return f"{reached}: {met}; move that point a bit"
    if found.error < _HARDLY * known:
        return f"{reached}: how much of each threshold is left is known to {known:.1e} only; loosen the tolerance"
    return f"{reached}; loosen the tolerance, or end the path sooner"


def _first(contacts: Contacts, length: float) -> float:
    """Travel over which rates change when a motion begins."""
    if contacts.thermal is None:
        return _LENGTH * length
    return min(_LENGTH * length, _FIRST * contacts.thermal.temperature / contacts.mean_threshold)


def _start(contacts: Contacts, piece: Piece, first: float) -> float:
    """The same where all begins: the weakest of those that start may be gone sooner than that, one after the other in
    the logarithm of time."""
    if contacts.thermal is None or piece.travel == 0.0:
        return first
    weakest, speed = float(contacts.thresholds.isf(1.0 - _WEAKEST)), abs(piece.travel) / piece.duration
    rate = float(contacts.thermal.rate(0.0, weakest, contacts.relative_stiffness(weakest)))
    return min(first, speed / contacts.thermal.attempt_frequency) if speed < rate * first else first


def _edges(contacts: Contacts, course: list[Piece], delay: float) -> tuple[Array, list[Jump] | None]:
    """Times between which breaks go on smoothly, both ends among them; when many contacts break at once, None where
    that is more often than can be followed."""
    law, end = contacts.thresholds, course[-1].end
    lone = [contacts.start.mean()] if contacts.start.is_single else []
    again = 0.0 if contacts.reforming is None else contacts.reforming.law.mean()
    limits = np.append(law.breakpoints, law.atoms[0])
    sharp = jumps(course, lone, again, law.atoms[0], delay)
    slivers = np.array([[one.begin, one.end] for one in sharp or []]).reshape(-1, 2)
    inner = beside(bends(course, lone, again, limits[limits > 0.0], delay, _ORDERS), slivers)
    edges = np.concatenate([[0.0], inner[(inner > 0.0) & (inner < end)], [end]])
    return edges, sharp


def _beyond(course: list[Piece], jump: Jump) -> list[Piece]:
    """The course with a bit more of its last piece, where it ends within a sliver."""
    last, end = course[-1], jump.end + jump.width
    after = last.before + last.travel * ((end - last.begin) / last.duration)
    return [*course[:-1], Piece(last.begin, end, last.before, after)]


def _needed(course: list[Piece], scales: Scales) -> float:
    """How many panels motion takes."""
    moving = [piece for piece in course if piece.travel != 0.0]
    return sum(max(abs(piece.travel) / scales.length, piece.duration * scales.rate, 1.0) for piece in moving)


def _watched(begin: float, end: float) -> Array:
    return begin + (end - begin) * np.arange(1, _WATCH) / _WATCH
