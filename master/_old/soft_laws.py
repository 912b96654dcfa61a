"""The soft slider with laws of single contacts, to the tolerance asked: steps halved, slips and forces extrapolated."""

import time as clocks
from functools import partial
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from master._old.forward import ROUND_OFF
from master._old.lives import Lives
from master._old.make_lives import make_fresh, make_lives, prepare
from master._old.marching import lagrange
from master._old.pulled import COARSEST, Pull
from master._old.regime import Course, regime
from master._old.timed import Extrapolation, uneven
from master._old.timeline import Piece, pieces, times
from master._old.track import TooLong, Track
from master.outcome import Progress, outcome, unheard
from master.soft.slips import Slips
from master.soft.solution import SoftSolution
from origins import Contacts, Drive
from origins.errors import refuse

Array = npt.NDArray[np.float64]

_MOST_STEPS, _MOST_WORK = 6e3, 1e9  # these take a minute or less
_FULL, _TELLING = 0.7, 2  # of the most steps; halvings until there is an error
_LAST, _MORE = 4, 1.25  # so often where slips come and go; of what is foreseen, some more
_OFTEN = 5.0  # breaks per mean threshold of the drive's way
_STENCIL = 6
_BISECTIONS = 60
_SAME = 1e-12


def solve_soft_laws(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress = unheard
) -> SoftSolution:
    """Force as the drive moves and pulls the slider, for contacts with any laws; rates, delay and holds run on the
    drive's clock; arguments checked before.

    The drive begins at t = 0 where it balances the start, X_T = F(0)/K with the slider at X = 0. A contact that breaks
    in a slip waits out its delay, where there is one, under every rule but "reset".
    """
    prepare(contacts)
    began = clocks.perf_counter()
    assert drive.spring is not None
    unit, spring = contacts.mean_threshold, drive.spring
    if contacts.reforming is not None and drive.slip != "reset" and (drive.slip == "reform-after" or contacts.delay):
        refuse("slip", drive.slip, 'takes contacts that form again at x = 0; leave out reforming, or use "reset"')
    balance = float(make_lives(contacts).pull[0]) / spring
    if abs(drive.path[0] - balance) <= _SAME * unit:
        balance = float(drive.path[0])  # a start of no mean stretch is one of rounding
    if drive.time is not None and drive.time[0] == 0.0 and abs(drive.path[0] - balance) > 1e-12 * unit:
        refuse("path[0]", drive.path[0], f"at time 0 the drive stands where it balances the start, {balance:.9g}")
    asked = times(drive, balance)
    found = _refine(contacts, drive, balance, asked, tolerance, progress)
    table, force, holding, error, steps, message = found
    success, message = outcome(contacts, error, tolerance, message)
    drives, before, after, above, below = table
    slips = Slips(drives, before, after, above, below, error * unit / spring)
    moving = [piece for piece in pieces(drive, balance) if piece.travel != 0.0]
    speed, course = drive.velocity, None
    if moving:
        last = abs(moving[-1].travel) / moving[-1].duration
        course = Course(asked, force, drive.path - force / spring, moving[-1].begin, last)
        if drive.time is not None:  # the mean while it moves
            speed = sum(abs(piece.travel) for piece in moving) / sum(piece.duration for piece in moving)
    return SoftSolution(
        path=drive.path,
        balance=balance,
        position=drive.path - force / spring,
        force=force,
        force_error=error,
        holding=holding,
        slips=slips,
        period=slips.period,
        regime=regime(contacts, spring, drive.slip, slips.drive, slips.drop, drive.path, tolerance, speed, course),
        run_time=clocks.perf_counter() - began,
        nodes=steps,
        success=success,
        message=message,
    )


def _refine(
    contacts: Contacts, drive: Drive, balance: float, asked: Array, tolerance: float, progress: Progress
) -> tuple[Array, Array, Array, float, int, str]:
    """Slips (5, m), force and holding at the times asked for, error estimate, steps and reason for stopping short."""
    unit, delay = contacts.mean_threshold, contacts.waiting_time
    spring = float(drive.spring or 0.0)
    course = pieces(drive, balance)
    if not course:
        lives = make_lives(contacts)
        stands = np.full(asked.size, lives.pull[0]), np.full(asked.size, lives.held[0])
        return np.empty((5, 0)), *stands, lives.error, 0, ""
    # steps of third order leave more than powers of their square
    rough = uneven(contacts) or contacts.ageing is not None or contacts.grains is not None
    scale = np.array([spring, 0.0, 0.0, 1.0, 1.0])[:, None] / unit
    plan: list[float] = []
    table, best = Extrapolation(rough), (np.inf, np.empty((5, 0)), np.empty(0), np.empty(0), 0)
    before: list[Array] = []
    level = 0
    message = ""
    lives, finer = make_lives(contacts), make_lives(contacts, 1)
    # an error takes steps of three sizes
    grown = max(make_lives(contacts, _TELLING).work / lives.work, 1.0) ** (1.0 / _TELLING)
    most = _FULL * _MOST_STEPS * 0.5**_TELLING, _FULL**2 * _MOST_WORK * (0.25 / grown) ** _TELLING
    while True:
        length = COARSEST * lives.length
        again = partial(make_fresh, contacts, level)
        try:
            pull = Pull(lives, again, course, spring, drive.slip, delay, unit, length, level, plan, most)
        except TooLong as why:
            message = str(why) or "no steps were found that follow the slider"
            if not np.isfinite(best[0]):
                refuse("path[-1]", drive.path[-1], f"{message}; {_hot(lives, course, unit)}end the path sooner")
            break
        plan = pull.stretches
        rows = [[s.drive, s.before, s.after, s.force_before, s.force_after] for s in pull.slips]
        slips = np.array(rows).reshape(-1, 5).T
        force, holding = _read(pull.tracks, asked, contacts)
        if before and before[-1].shape != slips.shape:
            table, before = Extrapolation(rough), []
        before.append(slips)
        near = np.zeros(asked.size, dtype=bool)
        for one, other in pairwise(before[-3:]):
            for k in range(slips.shape[1]):
                # points of the path that the slip's own error takes to its other side
                near |= np.abs(drive.path - other[0, k]) <= 3.0 * np.abs(one[0, k] - other[0, k])
        everything = np.concatenate([force / unit, holding, (slips * scale).ravel(), slips[1] / unit, slips[2] / unit])
        watched = np.ones(everything.size, dtype=bool)
        watched[: 2 * asked.size] = np.tile(~near, 2)
        watched[-2 * slips.shape[1] :] = slips.shape[1] == 0
        error, answer = table.add(everything, watched)
        # what rounding leaves of the balance moves a slider by 1/K of it: only one that slips is on a slope as steep
        steep = spring if pull.slips else min(spring, 1.0)
        error += ROUND_OFF * (1.0 + pull.steps) * (1.0 + steep) + lives.error
        error = max(error, pull.unresolved / unit)
        progress(error)
        if error < best[0] or not level:
            f, h = answer[: asked.size] * unit, answer[asked.size : 2 * asked.size]
            f, h = np.where(near, force, f), np.where(near, holding, h)
            rest = answer[2 * asked.size :].reshape(-1, slips.shape[1]) if slips.size else np.empty((7, 0))
            better = np.stack([rest[0] / spring, rest[5], rest[6], rest[3], rest[4]]) * unit
            best = error, better, f, h, pull.steps
        # coarse steps may find slips that finer ones do not: then there is no error yet
        untold = not np.isfinite(best[0]) and len(before) <= _TELLING and level < _LAST
        # twice as many, each with twice as many cohorts
        more = 2.0 * pull.steps, 4.0 * pull.work * finer.work / lives.work
        too_many = more[0] > _FULL * _MOST_STEPS or more[1] > _FULL**2 * _MOST_WORK
        if best[0] <= tolerance or error < 2.0 * lives.error or (too_many and not untold):
            break
        lives, finer = finer, make_lives(contacts, level + 2)
        level += 1
        most = (2.0 * most[0], 4.0 * most[1] * grown) if level < _TELLING else (_MOST_STEPS, _MOST_WORK)
        if untold:
            most = max(most[0], _MORE * more[0]), max(most[1], _MORE**2 * more[1])
    error, slips, force, holding, steps = best
    reached = f"error estimate {error:.1e} with {steps} steps, above the tolerance {tolerance:.1e}"
    message = message or f"{reached}; shorten the path or loosen the tolerance"
    return slips, force, holding, error, steps, message


def _hot(lives: Lives, course: list[Piece], unit: float) -> str:
    """Why steps are so many, and what else to ask, where fresh contacts break far sooner than they are stretched."""
    fastest = max(abs(piece.travel) / piece.duration for piece in course)
    if not lives.rate * unit > _OFTEN * fastest:
        return ""
    return (
        f"fresh contacts break within a time of {1.0 / lives.rate:.1g}, long before they reach their thresholds, and F "
        "soon stays near F_k, which steady_state and kinetic_curve tell; ask these, or "
    )


def _read(tracks: list[Track], asked: Array, contacts: Contacts) -> tuple[Array, Array]:
    """Force and holding at times: through the step parameter, in which all is smooth."""
    force, holding = np.empty(asked.size), np.empty(asked.size)
    ends = np.array([track.clock[-1] for track in tracks])
    # at a slip, after it
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(tracks) - 1)
    for k, at in enumerate(asked):
        track = tracks[which[k]]
        clock = np.array(track.clock)
        cell = min(max(int(np.searchsorted(clock, at, side="left")), 1), clock.size - 1) if clock.size > 1 else 0
        size = min(_STENCIL, clock.size)
        low = min(max(cell - size // 2, 0), clock.size - size)
        here = slice(low, low + size)
        step, values = np.array(track.step)[here], clock[here]
        place = step[0]
        if clock.size > 1:
            a, b = track.step[cell - 1], track.step[cell]
            for _ in range(_BISECTIONS):
                place = 0.5 * (a + b)
                if float(lagrange(step, place) @ values) < at:
                    a = place
                else:
                    b = place
        weights = lagrange(step, place)
        force[k] = float(weights @ np.array(track.force)[here])
        holding[k] = float(weights @ np.array(track.holding)[here])
    return force, holding
